"""The bushing."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...schema import FixedList, Measure, described
from ..drawing.strokes import PairView, Stroke, ring
from .force_element import ForceElement, SpringNumbers


@dataclass(frozen=True, kw_only=True)
class Bushing(ForceElement):
    """A bushing (elastic bearing) between two pins: stiffness (N/m, N/m, N m/rad) and damping (N s/m, N s/m,
    N m s/rad) in x, in y and about the axis.

    The axes are those of the first body. The bushing exerts no force where the pins coincide and the relative
    angle is that of the start.
    """

    kind = "bushing"
    sample: ClassVar[dict[str, Any]] = {"stiffness": (1e3, 1e3, 1.0)}
    axes = "bushing"

    stiffness: tuple[float, float, float] = described(
        FixedList((Measure("N/m", low=0.0), Measure("N/m", low=0.0), Measure("N m/rad", low=0.0))),
        "stiffness in x, in y, about the axis",
    )
    damping: tuple[float, float, float] = described(
        FixedList((Measure("N s/m", low=0.0), Measure("N s/m", low=0.0), Measure("N m s/rad", low=0.0))),
        "damping in x, in y, about the axis",
        (0.0, 0.0, 0.0),
    )

    def numbers(self, start: float) -> SpringNumbers:
        """Return the numbers for a step; the moment is zero at the angle ``start`` (rad)."""
        return SpringNumbers(self.stiffness, self.damping, start)

    @property
    def turns(self) -> bool:
        """Whether it acts on the angles of its bodies."""
        return bool(self.stiffness[2] or self.damping[2])

    @property
    def words(self) -> str:
        """Description for readers."""
        x, y, turning = self.stiffness
        return f"bushing, {x:.6g} and {y:.6g} N/m, {turning:.6g} N m/rad"

    def strokes(self, view: PairView) -> list[Stroke]:
        """Return two rings."""
        return [
            ring(view.first, 0.022 * view.size, colour="spring", width=3.5, fade=0.6),
            ring(view.first, 0.012 * view.size, colour="spring", sign="bushing"),
        ]
