"""Many runs of one question, and one run that a script steps."""
