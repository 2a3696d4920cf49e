"""Motion through a table of values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import Many, Measure, described
from ..renamed import renamed
from .driver import Driver


@renamed(angles="values")
@dataclass(frozen=True, kw_only=True)
class AngleTable(Driver):
    """Angle (rad) or travel (m) at given times (s), joined by a cubic spline; the last piece goes on."""

    kind: ClassVar[str] = "table"

    lead: ClassVar[str] = "values"

    times: tuple[float, ...] = described(Many(Measure("s")), "times of the values of a table, ascending")
    values: tuple[float, ...] = described(
        Many(Measure("rad")),
        "angles from the start angle: at the times, or of the torques",
        key="angles",
        along=described(Many(Measure("m")), "ways from the start: at the times, or of the forces", key="travels"),
    )
