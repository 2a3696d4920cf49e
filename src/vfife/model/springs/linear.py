"""The linear spring and damper."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...schema import quantity
from ..drawing.strokes import Curve, PairView, Stroke, zigzag
from .force_element import ForceElement, SpringNumbers


@dataclass(frozen=True, kw_only=True)
class Spring(ForceElement):
    """A spring and damper along the line between two pins, ``first`` and ``second`` (``body.pin`` or
    ``ground.point``).

    F = stiffness (l - free_length) + damping dl/dt pulls where positive; N/m, N s/m, m. The free length
    defaults to the start distance, which clearances and the place of the journals at the start change.
    """

    kind = "linear"
    builder = "spring"
    sample: ClassVar[dict[str, Any]] = {"stiffness": 100.0}
    axes = "linear"

    stiffness: float = quantity("N/m", "stiffness", 0.0, low=0.0)
    damping: float = quantity("N s/m", "damping", 0.0, low=0.0)
    free_length: float | None = quantity(
        "m",
        "length without force; that of the start if left out, which clearances and start.journals change",
        None,
        low=0.0,
    )

    def numbers(self, start: float) -> SpringNumbers:
        """Return the numbers for a step; ``start`` (m) is the default of the free length."""
        free = start if self.free_length is None else self.free_length
        return SpringNumbers((self.stiffness, 0.0, 0.0), (self.damping, 0.0, 0.0), free)

    @property
    def words(self) -> str:
        """Description for readers."""
        return f"spring, {self.stiffness:.6g} N/m, {self.damping:.6g} N s/m"

    def strokes(self, view: PairView) -> list[Stroke]:
        """Return a zigzag."""
        return [Curve(zigzag(view.first, view.second, 0.018 * view.size), "spring", 1.5, 6.0, sign="spring")]
