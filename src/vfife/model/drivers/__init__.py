"""Drivers, one file each: a prescribed motion of a body, a slider or a pin, or a torque or force on it."""

from .constant_speed import ConstantSpeed
from .driver import Driver
from .harmonic import Harmonic
from .ramp import Ramp
from .step_to import StepTo
from .table import AngleTable
from .torque import Torque

__all__ = ["AngleTable", "ConstantSpeed", "Driver", "Harmonic", "Ramp", "StepTo", "Torque"]
