"""Numbers as text: no digit is finer than scatter over turns or numerical uncertainty."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..measures.catalogue import is_ideal_zero
from ..measures.values import NOT_ESTIMATED
from ..numerics.outward import DOWN, UP, exponent, significant_range
from ..numerics.scalar import log10
from .amounts import PREFIXED, WIDE, decimals, fixed_point, interval, prefixed

Json = Mapping[str, Any]
# Drawings give the difference of the diameters, twice as much.
RADIAL = "Clearances are radial: half of the difference of the diameters; in a guide, the gap on each side."
ABOUT_ZERO = "about 0"  # in the place of digits that mean nothing
NOT_DETERMINED = "not determined"  # in the place of a range that says nothing
# Width of a range over the largest measure of its kind, from which the measure is not determined. Ranges of
# sensitive runs are within some hundred times the value; forces at a singular position grow without bound.
UNBOUNDED = 1e6
SCATTER = 1e-4  # share of a measure by which turns have to differ to be shown
CERTAIN = 0.02  # largest relative error of a measure that needs no warning
OF_CYCLES = "settling", "unsettled"  # turns whose measures are means over cycles of gears, or a single one
COUNTS = (".impacts", ".grazing", ".deep_landings")
UNITS = {  # of the measures that a summary shows with their units, by the ends of their names
    "force.max": "N", "moment.max": "N m", "torque.max": "N m", "penetration.max": "m",
    "displacement.max": "m", "actuator_force.max": "N", "actuator_torque.max": "N m",
    "angular_acceleration.max": "rad/s²",
}  # fmt: skip


# -------------------------------------------------------------------------------- measures of a run's summary


def unit_of(measure: str) -> str:
    """Return the unit of a measure, "" for one that a summary shows without."""
    return next((unit for ending, unit in UNITS.items() if f".{measure}".endswith(f".{ending}")), "")


def shown_uncertainty(summary: Json, name: str) -> float:
    """Return the uncertainty of a measure that stands beside its range, or less, such that it keeps two
    digits, as the ends of the range have.
    """
    width, value = uncertainty(summary, name), summary["measures"].get(name)
    if not value or not math.isfinite(value) or is_about_zero(summary, name):
        return width
    return min(width, float(f"2e{exponent(value) - 1}"))


def uncertainty(summary: Json, name: str) -> float:
    """Return the scatter over turns or the numerical uncertainty of a measure, whichever is larger; 0 if both
    are unknown.

    Turns that differ by the motion, because their period is longer than one or there is none, have a mean
    whose uncertainty is that by companions or smaller steps alone.
    """
    bounds = (summary.get("ranges") or {}).get(name)
    if bounds is None:
        return 0.0
    numerical = float(bounds["high"] - bounds["low"])
    # A summary of a former version has no turns
    scatter = float(bounds.get("highest", 0.0) - bounds.get("lowest", 0.0))
    turns = summary.get("turns") or {}
    if (turns.get("period") or 1) > 1 or turns.get("motion") in OF_CYCLES:
        return numerical
    alike = turns.get("motion") != "not repeating" and not turns.get("scatters")
    return max(numerical, scatter) if alike or numerical <= 0.0 else numerical


def turns_text(summary: Json, name: str, unit: str, share: float = SCATTER) -> str:
    """Return the lowest and the highest turn of a measure that is a mean over turns, where turns differ by
    the motion, by more than the range of the mean, and by more than a ``share`` (1) of the highest;
    "" for any other.
    """
    bounds, turns = (summary.get("ranges") or {}).get(name), summary.get("turns") or {}
    differ = turns.get("motion", "periodic") != "periodic" or (turns.get("period") or 1) > 1
    differ = differ or bool(turns.get("scatters"))
    if not differ or bounds is None or is_about_zero(summary, name):
        return ""
    lowest, highest = float(bounds["lowest"]), float(bounds["highest"])
    inside = bounds["low"] <= lowest and highest <= bounds["high"] and is_estimated(summary, name)
    if inside or highest - lowest <= share * highest:
        return ""
    return interval(lowest, highest, unit, fineness(turns.get("motion")) * (highest - lowest))


def fineness(motion: str | None) -> float:
    """Return the share of the range of single turns that their ends are shown to; other turns of chaos have
    other extremes.
    """
    return 0.1 if motion == "not repeating" else 0.01


def is_estimated(summary: Json, name: str) -> bool:
    """Return whether the error of a measure was estimated; in a summary of a former version, whether its
    range has a width.
    """
    bounds = (summary.get("ranges") or {}).get(name)
    if "not_estimated" in summary:
        return name not in summary["not_estimated"]
    return bounds is not None and bounds["high"] > bounds["low"]


def is_negative(summary: Json, name: str) -> bool:
    """Return whether a measure is below 0 throughout its range."""
    bounds = (summary.get("ranges") or {}).get(name)
    return bool((summary["measures"].get(name, 0.0) if bounds is None else bounds["high"]) < 0.0)


def range_text(summary: Json, name: str) -> str:
    """Return the range of a measure without its unit, "exact", or that it was not estimated."""
    if not is_estimated(summary, name):
        return NOT_ESTIMATED
    bounds = (summary.get("ranges") or {}).get(name)
    value = summary["measures"][name]
    low, high = (float(value) if bounds is None else float(bounds[key]) for key in ("low", "high"))
    if is_undetermined(summary, name):
        return NOT_DETERMINED
    if not high > low:
        return "exact"
    digits = (
        max(1, math.ceil(log10(max(abs(low), abs(high)) / (high - low))) + 2)
        if math.isfinite(high - low)
        else 6
    )
    return significant_range(low, high, min(digits, 12))


def plain_number(summary: Json, name: str) -> str:
    """Return a measure without its unit, with two to six digits and further ones not finer than its
    uncertainty.
    """
    value = summary["measures"][name]
    if name.endswith(COUNTS):
        return (  # 45 contacts are 45 as in the tables of a summary, though companions may have 41
            f"{value:.0f}"
        )
    width = shown_uncertainty(summary, name)
    if not isinstance(value, float) or not 1e-3 <= abs(value) < 1e7:
        limited = width > 0.0 and value and math.isfinite(value / width)
        digits = exponent(value) - exponent(width) + 1 if limited else 6
        return f"{value:.{max(1, min(6, digits))}g}"
    places = decimals(value, width, significant=6, coarse_places=5 - exponent(value))
    return f"{value:.6g}" if width <= 0.0 else f"{round(value, places):.{max(places, 0)}f}"


def is_about_zero(summary: Json, name: str) -> bool:
    """Return whether a measure is zero but for rounding, or a remainder that is nothing on the scale of the
    mechanism; False in a summary of a former version.
    """
    return name in summary.get("about_zero", {})


def is_undetermined(summary: Json, name: str) -> bool:
    """Return whether other steps make a measure so large that its range says nothing, as those of forces at a
    singular position do.
    """
    bounds = (summary.get("ranges") or {}).get(name)
    if bounds is None or not is_estimated(summary, name):
        return False
    kind, measures = ".".join(name.split(".")[-2:]), summary["measures"]
    largest = max(abs(measures[measure]) for measure in measures if measure.endswith(kind))
    return bool(0.0 < UNBOUNDED * largest < bounds["high"] - bounds["low"])


def wide_range(summary: Json, name: str, unit: str, scale: float = 1.0) -> str:
    """Return the range of a measure times a ``scale`` where two digits of it are not known, else "".

    The ends have two digits of the width.
    """
    bounds = (summary.get("ranges") or {}).get(name)
    if bounds is None or not is_estimated(summary, name) or is_about_zero(summary, name):
        return ""
    low, high = scale * float(bounds["low"]), scale * float(bounds["high"])
    if not (math.isfinite(high - low) and high - low > WIDE * abs(scale * summary["measures"][name])):
        return ""
    return interval(low, high, unit, 0.1 * (high - low), prefix=unit in PREFIXED)


def value_text(summary: Json, name: str, unit: str) -> str:
    """Return a measure with the digits that are known, or as a range where two of them are not."""
    return wide_range(summary, name, unit) or measure_text(summary, name, unit)


def sum_text(summary: Json, names: Sequence[str], unit: str, certain: float = WIDE) -> str:
    """Return the sum of measures with the digits that are known, or as a range where that is wider than the
    share ``certain`` of the sum.
    """
    total, width = (
        sum(summary["measures"][name] for name in names),
        sum(uncertainty(summary, name) for name in names),
    )
    if all(name in (summary.get("ranges") or {}) and is_estimated(summary, name) for name in names):
        low, high = (sum(float(summary["ranges"][name][end]) for name in names) for end in ("low", "high"))
        if math.isfinite(high - low) and high - low > certain * abs(total):
            return interval(low, high, unit, 0.1 * (high - low))
    return prefixed(total, unit, width) + estimate_mark(summary, *names)


def share_text(summary: Json, name: str) -> str:
    """Return a measure that is a share (1) in per cent, with three digits at most, or as a range."""
    value, width = 100.0 * summary["measures"][name], 100.0 * uncertainty(summary, name)
    places = 2 - exponent(value) if value else 0
    places = min(places, -exponent(width)) if width > 0.0 else places
    single = f"{fixed_point(value, places)} %" + estimate_mark(summary, name)
    return wide_range(summary, name, "%", 100.0) or single


def measure_text(summary: Json, name: str, unit: str) -> str:
    """Return a measure with a prefix, and a mark if its error was not estimated; no digits of one that is
    about zero.
    """
    if is_about_zero(summary, name):
        return ABOUT_ZERO
    if is_undetermined(summary, name):
        return NOT_DETERMINED
    return prefixed(summary["measures"][name], unit, uncertainty(summary, name)) + estimate_mark(
        summary, name
    )


def shaking_text(summary: Json) -> str:
    """Return the largest force on the ground. That at the outputs may miss impacts: beside it stands an
    estimate with the peaks of the joints, or it is that of the only joint on the ground.
    """
    name, ground = "ground.shaking_force.max", summary.get("ground", {})
    if is_about_zero(summary, name):
        return ABOUT_ZERO
    if not ground or is_estimated(summary, name):
        return f"up to {largest_of_turns(summary, name, 'N')}"
    if joint := ground["joint"]:
        return f"up to {measure_text(summary, f'{joint}.force.max', 'N')} (that of {joint})"
    value = prefixed(summary["measures"][name], "N", 0.0, DOWN)
    if "estimate" not in ground:  # a summary of a former version
        return f"at least {value}, at most {prefixed(ground['at_most'], 'N', 0.0, UP)} ({NOT_ESTIMATED})"
    estimate = prefixed(ground["estimate"], "N", 0.0, UP)
    return f"at least {value}, about {estimate} ({NOT_ESTIMATED})"


def largest_of_turns(summary: Json, name: str, unit: str) -> str:
    """Return a largest value; where single turns differ, the mean of their largest values, and these."""
    turns = "" if is_undetermined(summary, name) else turns_text(summary, name, unit, CERTAIN)
    return over_turns(measure_text(summary, name, unit), turns)


def over_turns(text: str, turns: str) -> str:
    """Return a largest value with the range of those of single ``turns``, over which it is a mean; without
    turns as it is.
    """
    return f"{text}, mean over turns (single turns {turns})" if turns else text


def forces_of(summary: Json) -> list[float | None]:
    """Return the largest forces (N) of all joints, ideal and with clearance; None where one is unknown."""
    return [joint[key] for joint in summary["joints"].values() for key in ("ideal_force.max", "force.max")]


def ideal_force_text(summary: Json, joint: str) -> str:
    """Return the largest force of an ideal joint; "" if it is not known."""
    ideal = summary["joints"][joint]["ideal_force.max"]
    if ideal is None:
        return ""
    return ABOUT_ZERO if is_ideal_zero(ideal, forces_of(summary)) else prefixed(ideal, "N")


def ideal_shaking_text(summary: Json) -> str:
    """Return the largest force of the ideal mechanism on the ground, in brackets; "" if it is not known."""
    force = summary["model"].get("ideal_shaking_force.max")
    return f" (ideal {prefixed(force, 'N')})" if force else ""


def largest_text(summary: Json, names: Sequence[str], unit: str, certain: float = 0.0) -> str:
    """Return the largest of several measures: its range if that is wider than the share ``certain`` of the
    value, else the value; with a mark if an error was not estimated.
    """
    largest = max(names, key=summary["measures"].__getitem__)
    if is_about_zero(summary, largest):
        return ABOUT_ZERO
    if any(is_undetermined(summary, name) for name in names):
        return NOT_DETERMINED
    bounds = [summary["ranges"][name] for name in names if is_estimated(summary, name)]
    if len(bounds) == len(names):
        low, high = (float(max(ends[key] for ends in bounds)) for key in ("low", "high"))
        if high - low > certain * summary["measures"][largest]:
            return interval(low, high, unit, 0.1 * (high - low))
    return measure_text(summary, largest, unit)


def estimate_mark(summary: Json, *names: str) -> str:
    """Return the note behind a measure, or the largest of several, whose error was not estimated in a run
    where others were.
    """
    estimated = not summary.get("trust") or all(is_estimated(summary, name) for name in names)
    return "" if estimated else f" ({NOT_ESTIMATED})"


# ------------------------------------------------------------------------------------------------ any numbers


# ------------------------------------------------------------------------------------------------------ lives
