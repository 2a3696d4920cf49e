"""The torsional spring and damper."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...numerics.elementwise import cos, sin
from ...schema import Text, described, quantity
from ..drawing.strokes import Curve, PairView, Stroke
from .force_element import ForceElement, SpringNumbers


@dataclass(frozen=True, kw_only=True)
class TorsionalSpring(ForceElement):
    """A torsional spring and damper between two bodies (or a body and the ground).

    M = -stiffness (angle - free_angle) - damping rate acts on the second body; the angle is that of the
    second minus that of the first; N m/rad, N m s/rad, rad. The free angle defaults to the start angle.
    """

    kind = "torsional"
    builder = "torsional_spring"
    sample: ClassVar[dict[str, Any]] = {"stiffness": 10.0}
    axes = "torsional"

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
        """Return the numbers for a step; ``start`` (rad) is the default of the free angle."""
        free = start if self.free_angle is None else self.free_angle
        return SpringNumbers((0.0, 0.0, self.stiffness), (0.0, 0.0, self.damping), free)

    @property
    def words(self) -> str:
        """Description for readers."""
        return f"torsional spring, {self.stiffness:.6g} N m/rad, {self.damping:.6g} N m s/rad"

    def strokes(self, view: PairView) -> list[Stroke]:
        """Return a spiral."""
        turn = np.linspace(0.0, 4.5 * np.pi, 200)
        radius = view.size * (0.012 + 0.022 * turn / turn[-1])
        points = view.second + radius[:, None] * np.stack([cos(turn), sin(turn)], axis=1)
        return [Curve(points, "spring", 1.3, 6.0, sign="torsional spring")]
