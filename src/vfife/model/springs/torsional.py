"""Spring and damper about the axis of the plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...numerics.elementwise import cos, sin
from ...schema import Text, described, quantity
from ..drawing.strokes import Curve, PairView, Stroke
from .force_element import Axes, ForceElement, SpringNumbers


@dataclass(frozen=True, kw_only=True)
class TorsionalSpring(ForceElement):
    """Spring and damper about the axis of the plane between two bodies (or the ground).

    M = -stiffness (angle - free_angle) - damping rate on the second body, angle that of the second less that
    of the first; N m/rad, N m s/rad, rad. The free angle is the angle at the start unless given.
    """

    kind: ClassVar[str] = "torsional"
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {"torsional_spring": ()}
    sample: ClassVar[dict[str, Any]] = {"stiffness": 10.0}
    axes: ClassVar[Axes] = "torsional"

    first: str = described(Text("body"), "a body, or ground")
    second: str = described(Text("body"), "another body, or ground")
    stiffness: float = quantity("N m/rad", "stiffness", 0.0, low=0.0)
    damping: float = quantity("N m s/rad", "damping", 0.0, low=0.0)
    free_angle: float | None = quantity(
        "rad",
        "angle of the second less that of the first without moment; that of the start if left out",
        None,
    )

    def numbers(self, start: float) -> SpringNumbers:
        """What a step reads; the free angle is ``start`` (rad) unless given."""
        free = start if self.free_angle is None else self.free_angle
        return SpringNumbers((0.0, 0.0, self.stiffness), (0.0, 0.0, self.damping), free)

    @property
    def words(self) -> str:
        """What it is, in a few words."""
        return f"torsional spring, {self.stiffness:.6g} N m/rad, {self.damping:.6g} N m s/rad"

    def strokes(self, view: PairView) -> list[Stroke]:
        """A spiral."""
        import numpy as np

        turn = np.linspace(0.0, 4.5 * np.pi, 200)
        radius = view.size * (0.012 + 0.022 * turn / turn[-1])
        points = view.second + radius[:, None] * np.stack([cos(turn), sin(turn)], axis=1)
        return [Curve(points, "spring", 1.3, 6.0, sign="torsional spring")]
