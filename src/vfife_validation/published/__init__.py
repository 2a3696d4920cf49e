"""Published studies of linkages with clearance (``vfife verify published``): their statements and numbers
beside ours.
"""
