"""Spring and damper along a line."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Spring:
    """Spring and damper between two pins, ``first`` and ``second`` (``body.pin`` or ``ground.point``), along the line between them.

    F = stiffness (l - free_length) + damping dl/dt, pulling where positive; N/m, N s/m, m. The free length is the distance at the start unless
    given.
    """

    name: str
    first: str
    second: str
    stiffness: float = 0.0
    damping: float = 0.0
    free_length: float | None = None
