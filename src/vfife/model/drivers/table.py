"""Motion through a table of values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..renamed import renamed
from .driver import Driver


@renamed(angles="values")
@dataclass(frozen=True, kw_only=True)
class AngleTable(Driver):
    """Angle (rad) or travel (m) at given times (s), joined by a cubic spline; the last piece goes on."""

    kind: ClassVar[str] = "table"

    times: tuple[float, ...]
    values: tuple[float, ...]
