"""Drivers, one file each: a prescribed motion of a body, a slider or a pin, or a torque or force on it."""

from __future__ import annotations

from .constant_speed import ConstantSpeed
from .driver import Driver as Driver
from .driver import Point as Point
from .harmonic import Harmonic
from .ramp import Ramp
from .step_to import StepTo
from .table import AngleTable
from .torque import Torque

# What all of them share is imported by its name; the kinds are public, and those of vfife too.
__all__ = ["AngleTable", "ConstantSpeed", "Harmonic", "Ramp", "StepTo", "Torque"]
