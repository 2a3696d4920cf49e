"""The rotational stop."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...errors import Fault
from ...numerics.elementwise import cos, sin
from ...schema import Text, described, quantity
from ..drawing.strokes import Curve, PairView, Stroke, facing
from .force_element import ForceElement, SpringNumbers


@dataclass(frozen=True, kw_only=True)
class Stop(ForceElement):
    """A rotational stop: the angle of the second body minus that of the first stays between ``low`` and
    ``high`` (rad); beyond a limit it acts as a torsional spring and damper (N m/rad, N m s/rad) that only
    pushes: its moment is zero where spring and damper together would pull.
    """

    kind = "stop"
    sample: ClassVar[dict[str, Any]] = {"low": -0.5, "high": -0.2, "stiffness": 10.0}
    axes = "stop"

    first: str = described(Text("body"), "a body, or ground")
    second: str = described(Text("body"), "another body, or ground")
    low: float = quantity("rad", "least angle of the second body less that of the first")
    high: float = quantity("rad", "largest angle of the second body less that of the first")
    stiffness: float = quantity("N m/rad", "stiffness beyond the limits", above=0.0)
    damping: float = quantity("N m s/rad", "damping beyond the limits", 0.0, low=0.0)

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for limits in the wrong order."""
        if None not in (self.low, self.high) and self.low >= self.high:
            yield Fault(
                ("low",),
                "no room between the limits",
                "",
                f"below high = {self.high:g} rad",
                "exchange them, or move them apart",
            )

    def numbers(self, start: float) -> SpringNumbers:
        """Return the numbers for a step."""
        return SpringNumbers((0.0, 0.0, self.stiffness), (0.0, 0.0, self.damping), self.low, self.high)

    @property
    def words(self) -> str:
        """Description for readers."""
        return f"stop between {self.low:.6g} and {self.high:.6g} rad, {self.stiffness:.6g} N m/rad"

    def strokes(self, view: PairView) -> list[Stroke]:
        """Return a cheek at each limit, seen from the first body, and the free sector between them."""
        at, radius, strokes = view.second, 0.06 * view.size, []
        for angle in (self.low, self.high):
            out = radius * facing(view.angle + angle)
            strokes.append(Curve([at + 0.4 * out, at + 1.25 * out], width=2.6, rank=6.0))
        turn = view.angle + np.linspace(self.low, self.high, 60)
        arc = at + radius * np.stack([cos(turn), sin(turn)], axis=1)
        return [*strokes, Curve(arc, width=1.0, rank=6.0, dashes=":", sign="stop")]
