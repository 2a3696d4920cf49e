"""What a motion is over values: bifurcation diagrams, sections, basins, waterfalls, and the companions that
say so.
"""
