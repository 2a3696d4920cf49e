"""Spring and damper along a line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import quantity
from .force_element import ForceElement


@dataclass(frozen=True, kw_only=True)
class Spring(ForceElement):
    """Spring and damper between two pins, ``first`` and ``second`` (``body.pin`` or ``ground.point``), along the line between them.

    F = stiffness (l - free_length) + damping dl/dt, pulling where positive; N/m, N s/m, m. The free length is the distance at the start unless
    given.
    """

    kind: ClassVar[str] = "linear"

    stiffness: float = quantity("N/m", "stiffness", 0.0, low=0.0)
    damping: float = quantity("N s/m", "damping", 0.0, low=0.0)
    free_length: float | None = quantity("m", "length without force; that of the start if left out", None, low=0.0)
