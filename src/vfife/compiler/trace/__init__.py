"""The step as data: traced, ordered, differentiated."""
