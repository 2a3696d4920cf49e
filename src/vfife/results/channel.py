"""One series of a result, and the frames that directions are told in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray


@dataclass(frozen=True)
class Channel:
    """A series: ``values`` of shape (outputs,) or (outputs, entities), what it is counted over, unit and meaning.

    ``frame``: in which axes a place, a direction or a component is told (``FRAMES``); empty for what has none.
    """

    values: NDArray[Any]
    entity: str | None
    unit: str
    meaning: str
    frame: str = ""

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return ("time",) if self.entity is None else ("time", self.entity)

    @property
    def attributes(self) -> dict[str, str]:
        """Unit, meaning and frame, as a dataset has them."""
        return {"units": self.unit, "long_name": self.meaning} | ({"frame": FRAMES[self.frame]} if self.frame else {})


GLOBAL = "global axes"
FRAMES = {
    GLOBAL: "the axes of the ground",
    "bearing": "the axes of the body that carries the bearing; of a link from its start to its end",
    "journal": "the axes of the body that carries the journal",
    "guide": "along the guide, which the bearing's body carries, from the bearing's pin",
    "chord": "across the line from a link's start to its end, positive to its left",
    "start": "across the direction of a link at its start, positive to its left",
    "link": "along the axis of the link: tension positive",
}
