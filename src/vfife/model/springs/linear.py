"""Spring and damper along a line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .force_element import ForceElement


@dataclass(frozen=True, kw_only=True)
class Spring(ForceElement):
    """Spring and damper between two pins, ``first`` and ``second`` (``body.pin`` or ``ground.point``), along the line between them.

    F = stiffness (l - free_length) + damping dl/dt, pulling where positive; N/m, N s/m, m. The free length is the distance at the start unless
    given.
    """

    kind: ClassVar[str] = "linear"

    stiffness: float = 0.0
    damping: float = 0.0
    free_length: float | None = None
