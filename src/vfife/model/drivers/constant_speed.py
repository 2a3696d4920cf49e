"""Constant speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import quantity
from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class ConstantSpeed(Driver):
    """speed t; rad/s or m/s."""

    kind: ClassVar[str] = "constant-speed"

    lead: ClassVar[str] = "speed"

    speed: float = quantity("rad/s", "angular velocity", along=quantity("m/s", "velocity"))
