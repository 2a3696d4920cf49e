"""Joints, one file each: revolute, slider, weld and contacts, ideal or with clearance; gears. Sides are written ``body.pin``."""

from __future__ import annotations

from .clearance_revolute import ClearanceRevolute
from .clearance_slider import ClearanceSlider
from .contact import Contact as Contact
from .contact import FrictionMoment as FrictionMoment
from .curved_slot import ClearanceCurvedSlot, CurvedSlot
from .external_contact import ExternalContact
from .gear import Gear
from .ideal_revolute import IdealRevolute
from .joint import Joint as Joint
from .joint import Point as Point
from .slider import Slider
from .weld import Weld

# What all of them share is imported by its name; the kinds are public, and those of vfife too.
__all__ = [
    "ClearanceCurvedSlot",
    "ClearanceRevolute",
    "ClearanceSlider",
    "CurvedSlot",
    "ExternalContact",
    "Gear",
    "IdealRevolute",
    "Slider",
    "Weld",
]
