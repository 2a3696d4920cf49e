"""Rotational stop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .force_element import ForceElement


@dataclass(frozen=True, kw_only=True)
class Stop(ForceElement):
    """Rotational stop: the angle of the second body less that of the first stays between ``low`` and ``high`` (rad).

    Beyond either the stop answers like a torsional spring and damper (N m/rad, N m s/rad); it never pulls back.
    """

    kind: ClassVar[str] = "stop"

    low: float
    high: float
    stiffness: float
    damping: float = 0.0
