"""Numbers as text: no digit is finer than scatter over turns or numerical uncertainty."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any

from ..measures.values import NOT_ESTIMATED
from ..numerics.scalar import log10

Json = Mapping[str, Any]
CERTAIN = 0.02  # largest relative error of a measure that needs no warning
COUNTS = (".impacts", ".grazing", ".deep_landings")
UNITS = {  # of the measures that a summary shows with their units, by the ends of their names
    "force.max": "N", "moment.max": "N m", "torque.max": "N m", "penetration.max": "m",
    "displacement.max": "m",
    "angular_acceleration.max": "rad/s²",
}  # fmt: skip
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


# -------------------------------------------------------------------------------- measures of a run's summary


def unit_of(measure: str) -> str:
    """Return the unit of a measure, "" for one that a summary shows without."""
    return next((unit for ending, unit in UNITS.items() if f".{measure}".endswith(f".{ending}")), "")


def uncertainty(summary: Json, name: str) -> float:
    """Return the scatter over turns or the numerical uncertainty of a measure, whichever is larger; 0 if both
    are unknown.

    The measure of a motion that is not periodic is a mean over turns; its uncertainty is that by companions
    alone.
    """
    bounds = summary["ranges"].get(name)
    if bounds is None:
        return 0.0
    numerical = float(bounds["high"] - bounds["low"])
    # A summary of a former version has no turns
    scatter = float(bounds.get("highest", 0.0) - bounds.get("lowest", 0.0))
    return (
        numerical
        if numerical > 0.0 and summary["turns"].get("motion") == "not periodic"
        else max(numerical, scatter)
    )


def is_estimated(summary: Json, name: str) -> bool:
    """Return whether the error of a measure was estimated; in a summary of a former version, whether its
    range has a width.
    """
    bounds = (summary.get("ranges") or {}).get(name)
    if "not_estimated" in summary:
        return name not in summary["not_estimated"]
    return bounds is not None and bounds["high"] > bounds["low"]


def range_text(summary: Json, name: str) -> str:
    """Return the range of a measure without its unit, "exact", or that it was not estimated."""
    if not is_estimated(summary, name):
        return NOT_ESTIMATED
    bounds = (summary.get("ranges") or {}).get(name)
    value = summary["measures"][name]
    low, high = (float(value) if bounds is None else float(bounds[key]) for key in ("low", "high"))
    if not high > low:
        return "exact"
    digits = (
        max(1, math.ceil(log10(max(abs(low), abs(high)) / (high - low))) + 2)
        if math.isfinite(high - low)
        else 6
    )
    return f"{low:.{min(digits, 12)}g} to {high:.{min(digits, 12)}g}"


def plain_number(summary: Json, name: str) -> str:
    """Return a measure without its unit, with at most six digits and none finer than its uncertainty."""
    value = summary["measures"][name]
    if name.endswith(COUNTS):
        return (  # 45 contacts are 45 as in the tables of a summary, though companions may have 41
            f"{value:.0f}"
        )
    width = uncertainty({"ranges": summary.get("ranges") or {}, "turns": summary.get("turns") or {}}, name)
    if not isinstance(value, float) or not 1e-3 <= abs(value) < 1e7:
        limited = width > 0.0 and value and math.isfinite(value / width)
        digits = exponent(value) - exponent(width) + 1 if limited else 6
        return f"{value:.{max(1, min(6, digits))}g}"
    places = decimals(value, width, significant=6, most=5 - exponent(value))
    return f"{value:.6g}" if width <= 0.0 else f"{round(value, places):.{max(places, 0)}f}"


def measure_text(summary: Json, name: str, unit: str) -> str:
    """Return a measure with a prefix, and a mark if its error was not estimated."""
    return prefixed(summary["measures"][name], unit, uncertainty(summary, name)) + estimate_mark(
        summary, name
    )


def largest_text(summary: Json, names: Sequence[str], unit: str, certain: float = 0.0) -> str:
    """Return the largest of several measures: its range if that is wider than the share ``certain`` of the
    value, else the value; with a mark if an error was not estimated.
    """
    own = max(names, key=summary["measures"].__getitem__)
    bounds = [summary["ranges"][name] for name in names if is_estimated(summary, name)]
    if len(bounds) == len(names):
        low, high = (float(max(one[end] for one in bounds)) for end in ("low", "high"))
        if high - low > certain * summary["measures"][own]:
            return interval(low, high, unit, 0.1 * (high - low))
    return measure_text(summary, own, unit)


def interval(low: float, high: float, unit: str, width: float) -> str:
    """Return two quantities with prefixes as a range, with the unit once if both have the same."""
    first, last = (prefixed(end, unit, width) for end in (low, high))
    once = not low or first.split()[1:] == last.split()[1:]
    return f"{first.split()[0] if once else first} to {last}"


def estimate_mark(summary: Json, *names: str) -> str:
    """Return the note behind a measure, or the largest of several, whose error was not estimated in a run
    where others were.
    """
    return (
        ""
        if not summary.get("trust") or all(is_estimated(summary, name) for name in names)
        else f" ({NOT_ESTIMATED})"
    )


# ------------------------------------------------------------------------------------------------ any numbers


def decimals(value: float, width: float, significant: int = 4, most: int = 1) -> int:
    """Return the number of decimals; less than 0 means tens, hundreds ...

    The ``significant`` digits, or ``most`` decimals of values from 100 on; but none finer than the first
    digit of the uncertainty ``width`` (in the same unit), except the first digit of the value itself.
    """
    first = -exponent(value) if value else 0
    usual = most if abs(value) >= 100.0 else significant - 1 + first
    if not (width > 0.0 and math.isfinite(width)):
        return usual
    return min(usual, max(-exponent(width), first))


def amount(value: float | None, unit: str, width: float = 0.0) -> str:
    """Return a quantity without prefix, "" for None; no digit is finer than the first of its uncertainty
    ``width`` (same unit).
    """
    if value is None:
        return ""
    if not (width > 0.0 and math.isfinite(value)) or abs(value) < 1e-6:
        return f"{value:,.1f} {unit}" if value >= 100.0 or value < 1e-6 else f"{value:,.4g} {unit}"
    return f"{fixed(value, decimals(value, width))} {unit}"


def percent(value: float | None, width: float = 0.0) -> str:
    """Return a percentage with at most two decimals; "" for None."""
    if value is None:
        return ""
    return f"{fixed(value, min(2, decimals(value, width, significant=99, most=2)))} %"


def fixed(value: float, places: int) -> str:
    """Return a number rounded to decimals, or with less than 0 of them to tens, hundreds ..."""
    return f"{round(value, places):,.{max(places, 0)}f}"


def prefixed(value: float, unit: str, width: float = 0.0) -> str:
    """Return a quantity with a prefix that leaves one to three digits before the point; ``width`` as in
    :func:`amount`.
    """
    for factor, prefix in PREFIXES:
        if abs(value) >= factor and not (factor > 1.0 and unit in ("s", "m")):
            text = (
                fixed(value / factor, decimals(value / factor, width / factor))
                if width > 0.0
                else f"{value / factor:.4g}"
            )
            return f"{text} {prefix}{unit}"
    return f"{value:.4g} {unit}"


def quantity(value: Any, unit: str) -> str:
    """Return a parameter or measure with its unit, with a prefix if the unit takes one; a word as it is, None
    as a dash.
    """
    if value is None or isinstance(value, str):
        return value or "-"
    if unit in ("1", "%") or not value or not math.isfinite(value):
        return f"{value:.6g}" + (" %" if unit == "%" else "")
    return (
        prefixed(value, unit)
        if unit in ("m", "N", "Pa", "W", "J", "s")
        else f"{value:.5g} {unit.replace('^2', '²')}"
    )


def exponent(value: float) -> int:
    """Return the decimal exponent of a nonzero number: 0 of 1 to 9.99, -1 of 0.1; exact, where a logarithm
    may round.
    """
    return Decimal(value).adjusted()
