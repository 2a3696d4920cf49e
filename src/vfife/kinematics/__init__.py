"""The ideal mechanism: constraints between rigid bodies, closed positions, velocities, accelerations,
reactions, mobility.
"""
