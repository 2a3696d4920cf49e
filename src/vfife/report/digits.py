"""Numbers as text: no digit is finer than scatter over turns or numerical uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from ..measures.values import NOT_ESTIMATED
from ..numerics.outward import DOWN, NEAREST, UP, exponent, rounded, significant, significant_range
from ..numerics.scalar import log10

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
WIDE = 0.1  # width of a range over the value: of one that is wider not even two digits are known
LARGE = ((1e9, "thousand million"), (1e6, "million"), (1.0, ""))  # scales of large numbers, and their words
COUNTS = (".impacts", ".grazing", ".deep_landings")
UNITS = {  # of the measures that a summary shows with their units, by the ends of their names
    "force.max": "N", "moment.max": "N m", "torque.max": "N m", "penetration.max": "m",
    "displacement.max": "m", "actuator_force.max": "N", "actuator_torque.max": "N m",
    "angular_acceleration.max": "rad/s²",
}  # fmt: skip
PREFIXES = (  # factors with their exponents of ten
    (1e9, 9, "G"), (1e6, 6, "M"), (1e3, 3, "k"), (1.0, 0, ""),
    (1e-3, -3, "m"), (1e-6, -6, "µ"), (1e-9, -9, "n"), (1e-12, -12, "p"),
)  # fmt: skip
PREFIXED = ("m", "N", "Pa", "W", "J", "s")  # units of quantities with prefixes
MOST_DIGITS = 10  # of a number whose error is unknown
TENTH = 0.1 + 1e-12  # of an end of a range: its second digit is kept, although products round
TINY = 0.01  # of the larger end of a range: a smaller end has one digit
LEAST_DIGITS = 2  # of a number of a column, however large its error
NEGLIGIBLE_IDEAL = 1e-9  # of the largest of its kind: an ideal force or acceleration below it is rounding


# -------------------------------------------------------------------------------- measures of a run's summary


def unit_of(measure: str) -> str:
    """Return the unit of a measure, "" for one that a summary shows without."""
    return next((unit for ending, unit in UNITS.items() if f".{measure}".endswith(f".{ending}")), "")


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
    if (turns.get("period") or 1) > 1:
        return numerical
    alike = turns.get("motion") != "not periodic" and not turns.get("scatters")
    return max(numerical, scatter) if alike or numerical <= 0.0 else numerical


def turns_text(summary: Json, name: str, unit: str, share: float = SCATTER) -> str:
    """Return the lowest and the highest turn of a measure that is a mean over turns, where turns differ by
    the motion, by more than the range of the mean, and by more than a ``share`` (1) of the highest;
    "" for any other.
    """
    bounds, turns = (summary.get("ranges") or {}).get(name), summary.get("turns") or {}
    differ = turns.get("motion") == "not periodic" or (turns.get("period") or 1) > 1 or turns.get("scatters")
    if not differ or bounds is None or is_about_zero(summary, name):
        return ""
    lowest, highest = float(bounds["lowest"]), float(bounds["highest"])
    inside = bounds["low"] <= lowest and highest <= bounds["high"] and is_estimated(summary, name)
    if inside or highest - lowest <= share * highest:
        return ""
    # Other turns of chaos have other extremes.
    fineness = 0.1 if turns.get("motion") == "not periodic" else 0.01
    return interval(lowest, highest, unit, fineness * (highest - lowest))


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
    """Return a measure without its unit, with at most six digits and none finer than its uncertainty."""
    value = summary["measures"][name]
    if name.endswith(COUNTS):
        return (  # 45 contacts are 45 as in the tables of a summary, though companions may have 41
            f"{value:.0f}"
        )
    width = uncertainty(summary, name)
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


def is_ideal_zero(value: float, values: Iterable[float | None]) -> bool:
    """Return whether a largest force or acceleration of the ideal mechanism is rounding beside ``values`` of
    its kind.
    """
    return 0.0 < value <= NEGLIGIBLE_IDEAL * max((abs(size or 0.0) for size in values), default=0.0)


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


def interval(low: float, high: float, unit: str, width: float, word: str = "to", prefix: bool = True) -> str:
    """Return a range with its unit once, its ends rounded outwards: the range that is shown contains the
    range.

    No digit is finer than the first of ``width`` (same unit), or those of :func:`end_width`. With ``prefix``,
    both ends have the prefix of the larger one.
    """
    directions = (DOWN, UP) if high > low else (NEAREST, NEAREST)
    size = max(abs(low), abs(high))
    texts = []
    for end, way in zip((low, high), directions, strict=True):
        fine = end_width(end, low, high, width)
        texts.append(
            prefixed(end, unit, fine, way, size) if prefix or not end else amount(end, unit, fine, way)
        )
    return f"{texts[0].split()[0]} {word} {texts[1]}"


def end_width(end: float, low: float, high: float, width: float) -> float:
    """Return the uncertainty whose first digit is the last of an ``end`` of the range ``low`` to ``high``, at
    most ``width``: such that a wide range has two digits of its width, and each end two of its own unless it
    is nothing beside the other.
    """
    size = max(abs(low), abs(high))
    if not (width > 0.0 and math.isfinite(high - low)):
        return width
    fine = min(width, 0.1 * (high - low)) if high - low > WIDE * size else width
    return min(fine, TENTH * abs(end)) if high > low and abs(end) > TINY * size else fine


def deviations(low: float, high: float, value: float) -> str:
    """Return the ends of a range as deviations from a value in per cent, rounded outwards to two digits of
    its width.
    """
    ends = [100.0 * (end / value - 1.0) if value else 0.0 for end in (low, high)]
    width = ends[1] - ends[0]
    places = 2 if width <= 0.0 else min(2, max(0, 1 - exponent(width)))
    first, last = (
        # Differences of numbers that are nearly equal end in rounding errors.
        f"{rounded(round(end, 9), places, way):+,.{places}f}"
        for end, way in zip(ends, (DOWN, UP), strict=True)
    )
    return f"{first} to {last} %"


def estimate_mark(summary: Json, *names: str) -> str:
    """Return the note behind a measure, or the largest of several, whose error was not estimated in a run
    where others were.
    """
    estimated = not summary.get("trust") or all(is_estimated(summary, name) for name in names)
    return "" if estimated else f" ({NOT_ESTIMATED})"


# ------------------------------------------------------------------------------------------------ any numbers


def decimals(value: float, width: float, significant: int = 4, coarse_places: int = 1) -> int:
    """Return the number of decimals; less than 0 means tens, hundreds ...

    The ``significant`` digits, or ``coarse_places`` decimals of values from 100 on; but none finer than the
    first digit of the uncertainty ``width`` (in the same unit), except the first digit of the value itself.
    """
    first = -exponent(value) if value else 0
    usual = coarse_places if abs(value) >= 100.0 else significant - 1 + first
    if not (width > 0.0 and math.isfinite(width)):
        return usual
    return min(usual, max(-exponent(width), first))


def amount(value: float | None, unit: str, width: float = 0.0, direction: int = NEAREST) -> str:
    """Return a quantity without prefix, "" for None; no digit is finer than the first of its uncertainty
    ``width`` (same unit).
    """
    if value is None:
        return ""
    if not (width > 0.0 and math.isfinite(value)) or abs(value) < 1e-6:
        if value >= 100.0 or value < 1e-6:
            return f"{fixed_point(value, 1, direction)} {unit}"
        return f"{significant(value, 4, direction)} {unit}"
    return f"{fixed_point(value, decimals(value, width), direction)} {unit}"


def percent(value: float | None, width: float = 0.0) -> str:
    """Return a percentage with at most two decimals, and from 100 % on four digits; "" for None."""
    if value is None:
        return ""
    places = 2 if abs(value) < 100.0 else max(0, 3 - exponent(value))
    return f"{fixed_point(value, min(places, decimals(value, width, significant=99, coarse_places=2)))} %"


def fixed_point(value: float, places: int, direction: int = NEAREST) -> str:
    """Return a number rounded to decimals, or with less than 0 of them to tens, hundreds ..."""
    return f"{rounded(value, places, direction):,.{max(places, 0)}f}"


def prefixed(
    value: float, unit: str, width: float = 0.0, direction: int = NEAREST, size: float | None = None
) -> str:
    """Return a quantity with a prefix that leaves one to three digits before the point of it, or of a
    ``size``; ``width`` as in :func:`amount`.
    """
    for factor, tens, prefix in PREFIXES if value else ():
        if abs(size or value) >= factor and not (factor > 1.0 and unit in ("s", "m")):
            scaled = value / factor
            places = decimals(scaled, width / factor) if width > 0.0 else 3 - exponent(scaled)
            scaled = rounded(value, places - tens, direction) / factor if direction != NEAREST else scaled
            text = fixed_point(scaled, places) if width > 0.0 else f"{scaled:.4g}"
            return f"{text} {prefix}{unit}"
    return f"{significant(value, 4, direction)} {unit}"


def quantity(value: Any, unit: str, direction: int = NEAREST, size: float | None = None) -> str:
    """Return a parameter or measure with its unit, with the prefix of its ``size`` if the unit takes one; a
    word as it is, None as a dash.
    """
    if value is None or isinstance(value, str):
        return value or "-"
    if unit in ("1", "%") or not value or not math.isfinite(value):
        return significant(value, 6, direction) + (" %" if unit == "%" else "")
    if unit in PREFIXED:
        return prefixed(value, unit, 0.0, direction, size)
    return f"{significant(value, 5, direction)} {unit.replace('^2', '²')}"


class Digits(NamedTuple):
    """What decides the digits of a column of numbers: their ``spread``, of which two more digits are
    printed, and their ``error``, whose first digit is the last (both in the unit of the numbers, 0 unknown);
    but two digits are printed in any event, because one may differ from the number by half of it.
    """

    spread: float = 0.0
    error: float = 0.0

    def significant(self, value: float, usual: int) -> int:
        """Return the significant digits of a number, at least the ``usual`` ones unless its error forbids."""
        first = exponent(value)
        count = max(usual, first - exponent(self.spread) + 3) if self.spread > 0.0 else usual
        if self.error > 0.0:
            count = min(count, first - exponent(self.error) + 1)
        return max(LEAST_DIGITS, min(count, MOST_DIGITS))


def quantity_of_digits(value: Any, unit: str, digits: Digits) -> str:
    """Return a number of a column with its unit as :func:`quantity`, with the digits of the column."""
    if value is None or isinstance(value, str) or not value or not math.isfinite(value):
        return quantity(value, unit)
    factor, prefix, usual = 1.0, "", 6 if unit in ("1", "%") else 5
    if unit in PREFIXED:
        usual = 4
        prefixes = (entry for entry in PREFIXES if not (entry[0] > 1.0 and unit in ("s", "m")))
        factor, _, prefix = next((entry for entry in prefixes if abs(value) >= entry[0]), (1.0, 0, ""))
    shown_digits = f"{value / factor:.{digits.significant(value, usual)}g}"
    text = f"{float(shown_digits):.{MOST_DIGITS}g} {prefix}{unit.replace('^2', '²')}"
    return text.removesuffix(" 1")


def quantities(low: float, high: float, unit: str, exact: bool = False) -> str:
    """Return a range of a parameter or measure with its unit once, its ends rounded outwards; ``exact`` ends
    to the nearest.
    """
    size = max((abs(end) for end in (low, high) if math.isfinite(end)), default=0.0)
    down, up = (NEAREST, NEAREST) if exact else (DOWN, UP)
    first, last = quantity(low, unit, down, size), quantity(high, unit, up, size)
    return f"{first.split()[0]} to {last}"


# ------------------------------------------------------------------------------------------------------ lives


def life_words(turns: float, turn: float | None, scatter: float | None = None) -> str:
    """Return a life, as in "about 14 million turns (80 h at 3,000 rpm)", with its range.

    ``turn`` (s) is the duration of a turn; None where turns have none. Depths grow with coefficient times
    turns, so that all lives are divided by the factor by which the coefficients are larger: ``scatter`` to
    either side, None where it is unknown.
    """
    (number,), word = large_numbers(turns)
    text = f"about {number}{f' {word}' if word else ''} turns"
    if turn:
        hours = turns * turn / 3600.0
        text += f" ({rounded(hours, 1 - exponent(hours)):,.{max(0, 1 - exponent(hours))}f} h"
        text += f" at {float(f'{60.0 / turn:.3g}'):,g} rpm)"
    if scatter is None:
        return text
    (low, high), word = large_numbers(turns / scatter, turns * scatter)
    return f"{text}; {low} to {high}{f' {word}' if word else ''} with the scatter of the wear coefficient"


def turns_words(turns: float) -> str:
    """Return a number of turns with two digits: 14 million."""
    (number,), word = large_numbers(turns)
    return f"{number} {word}".rstrip()


def large_numbers(*values: float) -> tuple[list[str], str]:
    """Return numbers with two digits and the word of the largest power of 1,000 that suits the first of them;
    the ends of a range, rounded outwards.
    """
    factor, word = next(scale for scale in LARGE if values[-1] >= scale[0] or scale[0] == 1.0)
    ways = (DOWN, UP) if len(values) > 1 else (NEAREST,)
    shown = (
        rounded(value, 1 - exponent(value), way) / factor for value, way in zip(values, ways, strict=True)
    )
    return [f"{float(f'{value:.6g}'):,g}" for value in shown], word
