"""Numbers of a model from measurements: misfits and their derivatives, searches, and how far what was found
can be trusted.
"""
