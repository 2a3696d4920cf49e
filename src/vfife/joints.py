"""Joints, gears and how their surfaces wear: one class for each kind, ``vfife.joints.ClearanceRevolute``."""

from .model.joints import *  # noqa: F403
from .model.joints import __all__ as _kinds
from .model.wear import Wear

__all__ = ["Wear"]
__all__ += _kinds
