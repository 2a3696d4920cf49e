"""The page with Python behind it: models chosen, edited, saved, run and followed from browsers on this
machine.
"""
