"""Constant speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class ConstantSpeed(Driver):
    """speed t; rad/s or m/s."""

    kind: ClassVar[str] = "constant-speed"

    speed: float
