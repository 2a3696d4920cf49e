"""Loads, one file each: forces and moments at a pin of a body or along a guide. Gravity is a vector of the
mechanism.

A load is constant, or depends on time, on a crank's angle, or on the travel along a guide, its direction and
its speed.
"""

from .guide_force import GuideForce
from .load import Load
from .point_force import PointForce

__all__ = ["GuideForce", "Load", "PointForce"]
