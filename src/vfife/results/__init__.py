"""Results and their files: channels with units, one sealed store for runs, studies, maps, wear and fits,
locks, run folders, restart.
"""
