"""Spring and damper about the axis of the plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .force_element import Axes, ForceElement, SpringNumbers


@dataclass(frozen=True, kw_only=True)
class TorsionalSpring(ForceElement):
    """Spring and damper about the axis of the plane between two bodies (or the ground).

    M = -stiffness (angle - free_angle) - damping rate on the second body, angle that of the second less that of the first; N m/rad, N m s/rad,
    rad. The free angle is the angle at the start unless given.
    """

    kind: ClassVar[str] = "torsional"
    axes: ClassVar[Axes] = "torsional"

    stiffness: float = 0.0
    damping: float = 0.0
    free_angle: float | None = None

    def numbers(self, start: float) -> SpringNumbers:
        """What a step reads; the free angle is ``start`` (rad) unless given."""
        free = start if self.free_angle is None else self.free_angle
        return SpringNumbers((0.0, 0.0, self.stiffness), (0.0, 0.0, self.damping), free)

    @property
    def words(self) -> str:
        """What it is, in a few words."""
        return f"torsional spring, {self.stiffness:.6g} N m/rad, {self.damping:.6g} N m s/rad"
