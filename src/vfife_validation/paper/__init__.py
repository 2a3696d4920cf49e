"""The source paper's numerical results computed anew: VFIFE analysis of planar mechanisms with clearance
joints.

Each item is a figure or a table of the paper, or something that the paper could not show. An item says which
parameters the paper states and which are inferred, shows our picture or table in the paper's axes, and judges
each statement of the text with its numbers.
"""
