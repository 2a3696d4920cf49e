"""What all long work has in common: a forecast from one table of costs, a confirmation, and a report of its
progress.
"""
