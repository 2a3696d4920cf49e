"""Gears and belts."""

from __future__ import annotations

from dataclasses import dataclass

from ...fields import Text, described, quantity


@dataclass(frozen=True, kw_only=True)
class Gear:
    """Gears or a belt between two bodies: ``second`` turns by ``ratio`` times the angle by which ``first`` turns.

    The ratio is negative for external gears (- teeth of the first over teeth of the second) and positive for belts and internal gears.
    """

    name: str
    first: str = described(Text("body"), "a body")
    second: str = described(Text("body"), "another body, which turns by ratio times the angle of the first")
    ratio: float = quantity("1", "negative for external gears (- teeth of the first / teeth of the second), positive for belts")
