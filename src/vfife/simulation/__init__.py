"""What a script calls: simulate, resume, the result, and a run stepped by the caller."""
