"""Numbers as text: amounts with units and prefixes, ranges rounded outward, lives and large numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

from ..numerics.outward import DOWN, NEAREST, UP, exponent, rounded, significant

WIDE = 0.1  # width of a range over the value: of one that is wider not even two digits are known
LEAST_DIGITS = 2  # of a number of a column, however large its error
LARGE = ((1e9, "thousand million"), (1e6, "million"), (1.0, ""))  # scales of large numbers, and their words
PREFIXES = (  # factors with their exponents of ten
    (1e9, 9, "G"), (1e6, 6, "M"), (1e3, 3, "k"), (1.0, 0, ""),
    (1e-3, -3, "m"), (1e-6, -6, "µ"), (1e-9, -9, "n"), (1e-12, -12, "p"),
)  # fmt: skip
PREFIXED = ("m", "N", "Pa", "W", "J", "s")  # units of quantities with prefixes
MOST_DIGITS = 10  # of a number whose error is unknown
TENTH = 0.1 + 1e-12  # of an end of a range: its second digit is kept, although products round
TINY = 0.01  # of the larger end of a range: a smaller end has one digit
LEAST_SHARE = 1e-6  # of the larger end of a range: a smaller end has the last digit of the width
SMALL = 1e-4  # below it a range without prefix has powers of ten, as Python prints single numbers


def interval(low: float, high: float, unit: str, width: float, word: str = "to", prefix: bool = True) -> str:
    """Return a range with its unit once, its ends rounded outwards: the range that is shown contains the
    range.

    No digit is finer than the first of ``width`` (same unit), or those of :func:`end_width`. With ``prefix``,
    both ends have the prefix of the larger one; without, ranges below :data:`SMALL` have powers of ten.
    """
    directions = (DOWN, UP) if high > low else (NEAREST, NEAREST)
    size = max(abs(low), abs(high))
    texts = []
    for end, way in zip((low, high), directions, strict=True):
        fine = end_width(end, low, high, width)
        if 0.0 < abs(end) < LEAST_SHARE * size < math.inf:
            end = rounded(end, -exponent(0.1 * (high - low)), way)
        with_prefix = prefix or not end
        texts.append(
            prefixed(end, unit, fine, way, size) if with_prefix else _plain_end(end, unit, fine, way, size)
        )
    return f"{texts[0].split()[0]} {word} {texts[1]}"


def _plain_end(end: float, unit: str, fine: float, way: int, size: float) -> str:
    """Return an end of a range without prefix; no digit is finer than the first of ``fine`` (same unit)."""
    places = decimals(end, fine)
    if size < SMALL:
        end = rounded(end, places, way)
        return f"{end:.{max(0, places + int(f'{end:e}'.partition('e')[2]))}e} {unit}"
    if fine > 0.0 or abs(end) >= 100.0:
        return f"{fixed_point(end, places, way)} {unit}"
    return f"{significant(end, 4, way)} {unit}"


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
        if abs(value) >= 100.0 or abs(value) < 1e-6:
            return f"{fixed_point(value, 1, direction)} {unit}"
        return f"{significant(value, 4, direction)} {unit}"
    return f"{fixed_point(value, decimals(value, width), direction)} {unit}"


def percent(value: float | None, width: float = 0.0, direction: int = NEAREST) -> str:
    """Return a percentage with at most two decimals, and from 100 % on four digits; "" for None."""
    return "" if value is None else f"{fixed_point(value, percent_places(value, width), direction)} %"


def percent_places(value: float, width: float = 0.0) -> int:
    """Return the decimals of :func:`percent`, below 0 for tens, hundreds ..."""
    places = 2 if abs(value) < 100.0 else max(0, 3 - exponent(value))
    return min(places, decimals(value, width, significant=99, coarse_places=2))


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
    if unit in PREFIXED or unit == "m/s":
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


def limit_digits(limit: float | None, values: Iterable[float | None], written: bool = True) -> Digits:
    """Return the digits of ``values`` and of their ``limit``, by which they differ: of the width of all, and
    of the least distance from the limit. A ``written`` limit keeps all digits that it was given with, up to
    nine.
    """
    numbers = [value for value in values if value is not None and math.isfinite(value)]
    if limit is None or not math.isfinite(limit):
        return Digits(max(numbers) - min(numbers) if numbers else 0.0)
    width = max([limit, *numbers]) - min([limit, *numbers])
    gaps = [abs(value - limit) for value in numbers if value != limit]
    spread = max(0.1 * width, min(10.0 * min(gaps), width)) if gaps else 0.0
    mantissa = f"{limit:.{MOST_DIGITS - 1}e}".partition("e")[0].rstrip("0").lstrip("-")
    count = len(mantissa.replace(".", ""))
    if written and limit and count < MOST_DIGITS:
        last = float(f"1e{exponent(limit) - count + 1}")
        spread = min(spread, 100.0 * last) if spread else 100.0 * last
    return Digits(spread)


def quantity_of_digits(value: Any, unit: str, digits: Digits, direction: int = NEAREST) -> str:
    """Return a number of a column with its unit as :func:`quantity`, with the digits of the column."""
    if value is None or isinstance(value, str) or not value or not math.isfinite(value):
        return quantity(value, unit)
    factor, prefix, usual = 1.0, "", 6 if unit in ("1", "%") else 5
    if unit in PREFIXED:
        usual = 4
        prefixes = (entry for entry in PREFIXES if not (entry[0] > 1.0 and unit in ("s", "m")))
        factor, _, prefix = next((entry for entry in prefixes if abs(value) >= entry[0]), (1.0, 0, ""))
    # Without the rounding of the division, whose last digit would move an end that is rounded outwards.
    scaled = value / factor if direction == NEAREST else float(f"{value / factor:.14g}")
    shown_digits = significant(scaled, digits.significant(value, usual), direction)
    text = f"{float(shown_digits):.{MOST_DIGITS}g} {prefix}{unit.replace('^2', '²')}"
    return text.removesuffix(" 1")


def limit_quantity(value: float | None, unit: str, digits: Digits, direction: int = NEAREST) -> str:
    """Return a quantity as :func:`quantity`, with more digits where :func:`limit_digits` asks for them."""
    prefixes = unit in PREFIXED or unit == "m/s"
    usual = 4 if prefixes else 6 if unit in ("1", "%") else 5
    if not value or not math.isfinite(value) or digits.significant(value, usual) == usual:
        return quantity(value, unit, direction)
    if unit == "m/s":  # with the prefixes of metres
        return f"{quantity_of_digits(value, 'm', digits, direction)}/s"
    return quantity_of_digits(value, unit, digits, direction)


def quantities(low: float, high: float, unit: str, exact: bool = False) -> str:
    """Return a range of a parameter or measure with its unit once, its ends rounded outwards; ``exact`` ends
    to the nearest.
    """
    size = max((abs(end) for end in (low, high) if math.isfinite(end)), default=0.0)
    down, up = (NEAREST, NEAREST) if exact else (DOWN, UP)
    first, last = quantity(low, unit, down, size), quantity(high, unit, up, size)
    return f"{first.split()[0]} to {last}"


def life_words(turns: float, turn: float | None, scatter: float | None = None) -> str:
    """Return a life, as in "about 14 million turns (80 h at 3,000 rpm)", with its range.

    ``turn`` (s) is the duration of a turn; None where turns have none. Depths grow with coefficient times
    turns, so that all lives are divided by the factor by which the coefficients are larger: ``scatter`` to
    either side, None where it is unknown.
    """
    (number,), word = large_numbers(turns)
    text = f"about {number}{f' {word}' if word else ''} turns"
    if turn:
        text += f" ({hours_text(turns, turn)} h at {float(f'{60.0 / turn:.3g}'):,g} rpm)"
    if scatter is None:
        return text
    (low, high), word = large_numbers(turns / scatter, turns * scatter)
    return f"{text}; {low} to {high}{f' {word}' if word else ''} with the scatter of the wear coefficient"


def life_range_words(
    shortest: float, longest: float, turn: float | None, scatter: float | None = None
) -> str:
    """Return the range of a life that is not determined, as in "0.11 to 3.9 million turns (0.66 to 22 h at
    2,900 rpm)"; ``turn`` (s) and ``scatter`` are those of :func:`life_words`.
    """
    if not math.isfinite(longest):
        return f"more than {turns_words(shortest)} turns"
    (low, high), word = large_numbers(shortest, longest)
    text = f"{low} to {high}{f' {word}' if word else ''} turns"
    if turn:
        hours = f"{hours_text(shortest, turn, DOWN)} to {hours_text(longest, turn, UP)}"
        text += f" ({hours} h at {float(f'{60.0 / turn:.3g}'):,g} rpm)"
    if scatter is None:
        return text
    (low, high), word = large_numbers(shortest / scatter, longest * scatter)
    return f"{text}; {low} to {high}{f' {word}' if word else ''} with the scatter of the wear coefficient"


def hours_text(turns: float, turn: float, way: int = NEAREST) -> str:
    """Return the hours of turns with two digits; ``turn`` (s) is the duration of one."""
    hours = turns * turn / 3600.0
    digit = 1 - exponent(hours)
    return f"{rounded(hours, digit, way):,.{max(0, digit)}f}"


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
