"""Runs of a mechanism as a script calls them: simulate, resume, the result, and a run stepped by
the caller.
"""
