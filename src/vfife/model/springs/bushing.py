"""Elastic bearing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import Each, Measure, described
from .force_element import ForceElement


@dataclass(frozen=True, kw_only=True)
class Bushing(ForceElement):
    """Elastic bearing between two pins: stiffness (N/m, N/m, N m/rad) and damping (N s/m, N s/m, N m s/rad) in x, y and about the axis.

    The axes are those of the first body; the bushing is free of force where the pins coincide and the angle is that of the start.
    """

    kind: ClassVar[str] = "bushing"

    stiffness: tuple[float, float, float] = described(
        Each((Measure("N/m", low=0.0), Measure("N/m", low=0.0), Measure("N m/rad", low=0.0))), "stiffness in x, in y, about the axis"
    )
    damping: tuple[float, float, float] = described(
        Each((Measure("N s/m", low=0.0), Measure("N s/m", low=0.0), Measure("N m s/rad", low=0.0))),
        "damping in x, in y, about the axis",
        (0.0, 0.0, 0.0),
    )
