"""Methods built on studies: searches, tolerance, allocation, sensitivity, comparison."""
