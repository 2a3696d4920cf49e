"""Numbers as they are printed: with digits no finer than what varies or is not known."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Any

from ..measures.measured import NOT_ESTIMATED
from ..numerics.scalar import log10

COUNTED = (".impacts", ".grazing", ".deep_landings")


def spread_of(summary: dict[str, Any], name: str) -> float:
    """What a measure of a summary varies by, or is not known to, the larger of both; 0 where nobody knows.

    Of a motion that is not periodic the mean is told, of which companions say how far it is known.
    """
    one = summary["ranges"].get(name)
    if one is None:
        return 0.0
    unknown, varies = (
        float(one["high"] - one["low"]),
        float(one.get("highest", 0.0) - one.get("lowest", 0.0)),
    )  # a former summary has no turns
    return (
        unknown
        if unknown > 0.0 and summary["turns"].get("motion") == "not periodic"
        else max(unknown, varies)
    )


def estimated(summary: dict[str, Any], name: str) -> bool:
    """Whether the error of a measure of a summary is known. One of a former version does not say so; no width
    tells it there.
    """
    one = (summary.get("ranges") or {}).get(name)
    if "not_estimated" in summary:
        return name not in summary["not_estimated"]
    return one is not None and one["high"] > one["low"]


def bounds(summary: dict[str, Any], name: str) -> str:
    """The range of a measure of a summary as bare numbers, in the digits that are known, or that it was not
    estimated.
    """
    if not estimated(summary, name):
        return NOT_ESTIMATED
    one = (summary.get("ranges") or {}).get(name)
    value = summary["measures"][name]
    low, high = (float(value) if one is None else float(one[key]) for key in ("low", "high"))
    if not high > low:
        return "exact"
    digits = (
        max(1, math.ceil(log10(max(abs(low), abs(high)) / (high - low))) + 2)
        if math.isfinite(high - low)
        else 6
    )
    return f"{low:.{min(digits, 12)}g} to {high:.{min(digits, 12)}g}"


def plain(summary: dict[str, Any], name: str) -> str:
    """A measure of a summary as a bare number of six digits at the most, no finer than what is known of it."""
    value = summary["measures"][name]
    if name.endswith(COUNTED):
        # as the tables of a summary have it: 45 contacts are 45, though companions may have 41
        return f"{value:.0f}"
    spread = spread_of({"ranges": summary.get("ranges") or {}, "turns": summary.get("turns") or {}}, name)
    if not isinstance(value, float) or not 1e-3 <= abs(value) < 1e7:
        known_digits = spread > 0.0 and value and math.isfinite(value / spread)
        known = decade(value) - decade(spread) + 1 if known_digits else 6
        return f"{value:.{max(1, min(6, known))}g}"
    places = decimals(value, spread, significant=6, most=5 - decade(value))
    return f"{value:.6g}" if spread <= 0.0 else f"{round(value, places):.{max(places, 0)}f}"


def measured(summary: dict[str, Any], name: str, unit: str) -> str:
    """A measure of a summary with a prefix, in the digits that are known of it."""
    return prefixed(summary["measures"][name], unit, spread_of(summary, name)) + mark(summary, name)


def mark(summary: dict[str, Any], *names: str) -> str:
    """What stands behind a measure, or the largest of several, where others were estimated and it was not. A
    run without any says so once.
    """
    return (
        ""
        if not summary.get("trust") or all(estimated(summary, name) for name in names)
        else f" ({NOT_ESTIMATED})"
    )


def decimals(value: float, spread: float, significant: int = 4, most: int = 1) -> int:
    """Digits after the point: so many ``significant`` ones, or of 100 and more ``most``, and none below the
    first digit of a ``spread``, but one of the value at least; less than 0 means tens, hundreds ...
    """
    first = -decade(value) if value else 0
    usual = most if abs(value) >= 100.0 else significant - 1 + first
    if not (spread > 0.0 and math.isfinite(spread)):
        return usual
    return min(usual, max(-decade(spread), first))


def amount(value: float | None, unit: str, spread: float = 0.0) -> str:
    """A quantity, empty where there is none; of a ``spread`` (in the same unit) no finer digit is printed
    than its first.
    """
    if value is None:
        return ""
    if not (spread > 0.0 and math.isfinite(value)) or abs(value) < 1e-6:
        return f"{value:,.1f} {unit}" if value >= 100.0 or value < 1e-6 else f"{value:,.4g} {unit}"
    return f"{fixed(value, decimals(value, spread))} {unit}"


def percent(value: float | None, spread: float = 0.0) -> str:
    """Per cent, with two decimals at the most."""
    if value is None:
        return ""
    return f"{fixed(value, min(2, decimals(value, spread, significant=99, most=2)))} %"


def fixed(value: float, places: int) -> str:
    """A number with so many places after the point; with less than 0 of them it is rounded to tens, hundreds
    ...
    """
    return f"{round(value, places):,.{max(places, 0)}f}"


def prefixed(value: float, unit: str, spread: float = 0.0) -> str:
    """A quantity with a prefix that leaves one to three digits before the point; of a ``spread`` (in the
    unit) no finer digit than its first.
    """
    size = abs(value)
    for factor, prefix in ((1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")):
        if size >= factor and not (prefix == "k" and unit in ("s", "m")):
            shown = (
                fixed(value / factor, decimals(value / factor, spread / factor))
                if spread > 0.0
                else f"{value / factor:.4g}"
            )
            return f"{shown} {prefix}{unit}"
    return f"{value:.4g} {unit}"


def decade(value: float) -> int:
    """Place of the first digit of a number that is not zero: 0 of 1 to 9.99, -1 of 0.1; exact, where a
    logarithm may be a bit off.
    """
    return Decimal(value).adjusted()
