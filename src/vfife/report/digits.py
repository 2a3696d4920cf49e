"""Numbers as they are printed: with digits no finer than what varies or is not known."""

from __future__ import annotations

import math
from typing import Any


def spread_of(told: dict[str, Any], name: str) -> float:
    """What a measure of a summary varies by, or is not known to, the larger of both; 0 where nobody knows.

    Of a motion that is not periodic the mean is told, of which companions say how far it is known.
    """
    one = told["ranges"].get(name)
    if one is None:
        return 0.0
    unknown, varies = float(one["high"] - one["low"]), float(one["highest"] - one["lowest"])
    return unknown if unknown > 0.0 and told["turns"].get("motion") == "not periodic" else max(unknown, varies)


def decimals(value: float, spread: float, significant: int = 4, most: int = 1) -> int:
    """Digits after the point: so many ``significant`` ones, or of 100 and more ``most``, and none below the first digit of a ``spread``; less
    than 0 means tens, hundreds ...
    """
    usual = most if abs(value) >= 100.0 else significant - 1 - (math.floor(math.log10(abs(value))) if value else 0)
    if not (spread > 0.0 and math.isfinite(spread)):
        return usual
    return min(usual, -math.floor(math.log10(spread)))


def amount(value: float | None, unit: str, spread: float = 0.0) -> str:
    """A quantity, empty where there is none; of a ``spread`` (in the same unit) no finer digit is printed than its first."""
    if value is None:
        return ""
    if not (spread > 0.0 and math.isfinite(value)) or abs(value) < 1e-6:
        return f"{value:,.1f} {unit}" if value >= 100.0 or value < 1e-6 else f"{value:,.4g} {unit}"
    return f"{fixed(value, decimals(value, spread))} {unit}"


def percent(value: float | None, spread: float = 0.0) -> str:
    """Per cent, with two decimals at the most."""
    if value is None:
        return ""
    return f"{fixed(value, min(2, -math.floor(math.log10(spread)) if spread > 0.0 and math.isfinite(spread) else 2))} %"


def fixed(value: float, places: int) -> str:
    """A number with so many places after the point; with less than 0 of them it is rounded to tens, hundreds ..."""
    return f"{round(value, places):,.{max(places, 0)}f}"


def prefixed(value: float, unit: str) -> str:
    """A quantity with a prefix that leaves one to three digits before the point."""
    size = abs(value)
    for factor, prefix in ((1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")):
        if size >= factor and not (prefix == "k" and unit in ("s", "m")):
            return f"{value / factor:.4g} {prefix}{unit}"
    return f"{value:.4g} {unit}"
