"""What a study varies and asks for: plan, distributions, limits."""
