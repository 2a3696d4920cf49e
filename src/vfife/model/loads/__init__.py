"""Loads, one file each: gravity is a vector of the mechanism; forces and moments act at a pin of a body or
along a guide.

They are constant, or go by a table over time, a crank's angle, or a travel along a guide, with its direction,
and its speed.
"""

from __future__ import annotations

from .guide_force import GuideForce
from .load import Load
from .point_force import PointForce

__all__ = ["GuideForce", "Load", "PointForce"]
