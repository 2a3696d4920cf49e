"""Spring and damper about the axis of the plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import Text, described, quantity
from .force_element import ForceElement


@dataclass(frozen=True, kw_only=True)
class TorsionalSpring(ForceElement):
    """Spring and damper about the axis of the plane between two bodies (or the ground).

    M = -stiffness (angle - free_angle) - damping rate on the second body, angle that of the second less that of the first; N m/rad, N m s/rad,
    rad. The free angle is the angle at the start unless given.
    """

    kind: ClassVar[str] = "torsional"

    first: str = described(Text("body"), "a body, or ground")
    second: str = described(Text("body"), "another body, or ground")
    stiffness: float = quantity("N m/rad", "stiffness", 0.0, low=0.0)
    damping: float = quantity("N m s/rad", "damping", 0.0, low=0.0)
    free_angle: float | None = quantity("rad", "angle of the second less that of the first without moment; that of the start if left out", None)
