"""The nouns: mechanism, bodies, joints, springs, drivers, loads, and what they are without arrays: functions
of time, lumped masses, limits.
"""
