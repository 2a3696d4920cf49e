"""Hysteresis damping factors chi of F_N = K delta^n (1 + chi rate / impact_speed), as functions of the restitution coefficient."""

from __future__ import annotations

from collections.abc import Callable


def lankarani_nikravesh(restitution: float) -> float:
    """3/4 (1 - c_r^2): Lankarani and Nikravesh, ASME Journal of Mechanical Design 112, 369-376 (1990)."""
    return 0.75 * (1.0 - restitution**2)


def hertz(restitution: float) -> float:
    """0: no dissipation."""
    return 0.0


DAMPING: dict[str, Callable[[float], float]] = {"lankarani-nikravesh": lankarani_nikravesh, "none": hertz}
