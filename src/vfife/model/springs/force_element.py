"""Base of all massless force elements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

from ...errors import Fault
from ...schema import Text, described
from ..drawing.strokes import PairView, Stroke
from ..kind import Kind

Axes = Literal["linear", "torsional", "stop", "bushing"]
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class SpringNumbers:
    """Numbers of a spring for a step: stiffness (N/m, N/m, N m/rad) and damping (N s/m, N s/m, N m s/rad)
    along its axes.

    ``free`` is the free length (m), the free angle (rad) or the lower limit (rad) of a stop; ``high`` is its
    upper limit.
    """

    stiffness: Triple
    damping: Triple
    free: float = 0.0
    high: float = 0.0


@dataclass(frozen=True, kw_only=True)
class ForceElement(Kind):
    """Base of massless elements with a unique ``name`` between ``first`` and ``second``: pins (``body.pin``
    or ``ground.point``), or bodies if it acts about the axis.
    """

    name: str
    first: str = described(Text("pin"), 'one end, "body.pin" or "ground.point"')
    second: str = described(Text("pin"), 'the other end, "body.pin" or "ground.point"')

    # Along the line between two pins, about the axis between two bodies (torsional, stop), or in three axes.
    axes: ClassVar[Axes] = "linear"
    registry: ClassVar[dict[str, type[ForceElement]]] = {}

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for each pair of sizes that contradict each other; unknown sizes (None) are
        skipped.
        """
        yield from ()

    @property
    def between_pins(self) -> bool:
        """Whether its ends are pins, ``body.pin``, rather than bodies."""
        return self.axes in ("linear", "bushing")

    @property
    def turns(self) -> bool:
        """Whether it acts on the angles of its bodies."""
        return not self.between_pins

    def numbers(self, start: float) -> SpringNumbers:
        """Return the numbers for a step. ``start`` is the start distance (m) of the pins of a linear spring,
        else the start angle (rad) between the bodies.
        """
        raise NotImplementedError

    @property
    def words(self) -> str:
        """Description for readers."""
        return self.kind

    def strokes(self, view: PairView) -> list[Stroke]:
        """Return the strokes that draw the element in the pose ``view``."""
        return []
