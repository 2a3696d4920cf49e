"""Loads, one file each: gravity is a vector of the mechanism; forces and moments act at a pin of a body, constant or over time."""

from __future__ import annotations

from .load import Load
from .point_force import PointForce

__all__ = ["Load", "PointForce"]
