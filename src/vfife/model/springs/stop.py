"""Rotational stop."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Stop:
    """Rotational stop: the angle of the second body less that of the first stays between ``low`` and ``high`` (rad).

    Beyond either the stop answers like a torsional spring and damper (N m/rad, N m s/rad); it never pulls back.
    """

    name: str
    first: str
    second: str
    low: float
    high: float
    stiffness: float
    damping: float = 0.0
