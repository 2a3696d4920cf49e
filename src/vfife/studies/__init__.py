"""Many runs of one model: studies, searches, tolerance, sensitivity, comparison."""
