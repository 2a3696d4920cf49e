"""What all massless elements of force share."""

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
    """What a step reads of a spring: stiffness (N/m, N/m, N m/rad) and damping (N s/m, N s/m, N m s/rad)
    along its axes.

    ``free`` is its free length (m), free angle (rad), or the lower limit (rad) of a stop, ``high`` the upper
    limit.
    """

    stiffness: Triple
    damping: Triple
    free: float = 0.0
    high: float = 0.0


@dataclass(frozen=True, kw_only=True)
class ForceElement(Kind):
    """A massless element between ``first`` and ``second``: pins (``body.pin`` or ``ground.point``), or bodies
    where it acts about the axis.
    """

    name: str
    first: str = described(Text("pin"), 'one end, "body.pin" or "ground.point"')
    second: str = described(Text("pin"), 'the other end, "body.pin" or "ground.point"')

    axes: ClassVar[Axes] = (
        # along the line between two pins, about the axis between two bodies, with limits there, or along
        # three axes
        "linear"
    )
    registry: ClassVar[dict[str, type[ForceElement]]] = {}

    def conflicts(self) -> Iterator[Fault]:
        """Sizes that do not go together; of what is not known (None) nothing is said."""
        yield from ()

    @property
    def between_pins(self) -> bool:
        """Whether its ends are pins, ``body.pin``; else bodies."""
        return self.axes in ("linear", "bushing")

    @property
    def turns(self) -> bool:
        """Whether it acts on the angles of its bodies."""
        return not self.between_pins

    def numbers(self, start: float) -> SpringNumbers:
        """What a step reads; ``start`` is the distance (m) of the pins at the start if it is linear, else the
        angle (rad) between the bodies.
        """
        raise NotImplementedError

    @property
    def words(self) -> str:
        """What it is, in a few words."""
        return self.kind

    def strokes(self, view: PairView) -> list[Stroke]:
        """How it is drawn."""
        return []
