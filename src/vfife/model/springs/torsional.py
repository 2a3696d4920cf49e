"""Spring and damper about the axis of the plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .force_element import ForceElement


@dataclass(frozen=True, kw_only=True)
class TorsionalSpring(ForceElement):
    """Spring and damper about the axis of the plane between two bodies (or the ground).

    M = -stiffness (angle - free_angle) - damping rate on the second body, angle that of the second less that of the first; N m/rad, N m s/rad,
    rad. The free angle is the angle at the start unless given.
    """

    kind: ClassVar[str] = "torsional"

    stiffness: float = 0.0
    damping: float = 0.0
    free_angle: float | None = None
