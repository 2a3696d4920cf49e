"""Elastic bearing."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Bushing:
    """Elastic bearing between two pins: stiffness (N/m, N/m, N m/rad) and damping (N s/m, N s/m, N m s/rad) in x, y and about the axis.

    The axes are those of the first body; the bushing is free of force where the pins coincide and the angle is that of the start.
    """

    name: str
    first: str
    second: str
    stiffness: tuple[float, float, float]
    damping: tuple[float, float, float] = (0.0, 0.0, 0.0)
