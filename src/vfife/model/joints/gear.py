"""Gears and belts."""

from __future__ import annotations

from dataclasses import dataclass

from ..rows import Row, Turn


@dataclass(frozen=True, kw_only=True)
class Gear:
    """Gears or a belt between two bodies: ``second`` turns by ``ratio`` times the angle by which ``first`` turns.

    The ratio is negative for external gears (- teeth of the first over teeth of the second) and positive for belts and internal gears.
    """

    name: str
    first: str
    second: str
    ratio: float

    def rows(self) -> tuple[Row, ...]:
        """One turn coupled to another."""
        return (Turn(self.ratio),)

    @property
    def words(self) -> str:
        """What it is, in a few words."""
        return f"gear, ratio {self.ratio:.6g}"
