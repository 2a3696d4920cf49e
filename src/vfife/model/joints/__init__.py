"""Joints, one file each: revolute, slider, weld and contacts, ideal or with clearance; gears. Sides are
written ``body.pin``.
"""

from .clearance_revolute import ClearanceRevolute
from .clearance_slider import ClearanceSlider
from .contact import Contact, FrictionMoment
from .curved_slot import ClearanceCurvedSlot, CurvedSlot
from .distance import Distance
from .external_contact import ExternalContact
from .gear import Gear
from .ideal_revolute import IdealRevolute
from .joint import Joint
from .slider import Slider
from .weld import Weld

__all__ = [
    "ClearanceCurvedSlot",
    "ClearanceRevolute",
    "ClearanceSlider",
    "Contact",
    "CurvedSlot",
    "Distance",
    "ExternalContact",
    "FrictionMoment",
    "Gear",
    "IdealRevolute",
    "Joint",
    "Slider",
    "Weld",
]
