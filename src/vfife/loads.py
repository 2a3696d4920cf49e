"""Loads: gravity is a vector of the mechanism; forces and moments act at a pin of a body, constant or over time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class PointForce:
    """Force (N) fixed in space and moment (N m) at ``at`` = ``body.pin``.

    With ``times`` (s) and ``factors`` both are multiplied by a function of time, the factors joined by a cubic spline.
    """

    name: str
    at: str
    force: tuple[float, float] = (0.0, 0.0)
    moment: float = 0.0
    times: tuple[float, ...] | None = None
    factors: tuple[float, ...] | None = None
