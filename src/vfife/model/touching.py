"""Where a joint with play can touch, as data: one entry for each contact, with its geometry and sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from ..numerics.elementwise import hypot
from .path import Path
from .rows import Point

Geometry = Literal["bearing", "round", "line", "slot"]
CENTRED = {"bearing": 0.0, "round": -1.0, "line": 1.0, "slot": 1.0}


@dataclass(frozen=True)
class Touching:
    """A round of the journal's body in a bearing, beside another round, on a line, or in a slot along a path.

    ``size`` (m) is the distance from the bearing's pin, from the line through it or from the path at which the surfaces begin to touch; ``arms``
    (m) are those of friction on bearing and journal from there. ``offset`` is the round's centre seen from the journal's pin, in the journal's
    frame. ``normal`` points into the material of a line, and ``path`` counts from the bearing's pin, both in the bearing's frame.
    """

    geometry: Geometry
    size: float
    arms: tuple[float, float]
    offset: Point = (0.0, 0.0)
    normal: Point = (1.0, 0.0)
    path: Path | None = None

    @property
    def centred(self) -> tuple[float, float]:
        """Arms with which friction makes no couple: at the centres, which are in one place in a bearing; outside, both at the journal's."""
        return CENTRED[self.geometry] * self.size, 0.0

    def depth(self, x: Any, y: Any) -> Any:
        """Penetration (m) with the round's centre at (x, y), seen from the bearing's pin in the bearing's frame; negative where they are apart."""
        if self.path is not None:
            return abs(self.path.distance(x, y)) - self.size
        if self.geometry == "line":
            return self.normal[0] * x + self.normal[1] * y - self.size
        beyond = hypot(x, y) - self.size
        return -beyond if self.geometry == "round" else beyond
