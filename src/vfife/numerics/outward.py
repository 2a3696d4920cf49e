"""Decimal rounding of the ends of a range: away from its middle, so that a shown range contains the range."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal

DOWN, NEAREST, UP = -1, 0, 1
ROUNDING = {DOWN: ROUND_FLOOR, NEAREST: ROUND_HALF_EVEN, UP: ROUND_CEILING}
EXACT = Context(prec=800)  # digits: more than any double has before and after its point


def exponent(value: float) -> int:
    """Return the decimal exponent of a nonzero number: 0 of 1 to 9.99, -1 of 0.1; exact, where a logarithm
    may round.
    """
    return Decimal(value).adjusted()


def rounded(value: float, places: int, direction: int = NEAREST) -> float:
    """Return a number rounded to decimals, or with less than 0 of them to tens, hundreds ...

    The number is rounded as Python prints it, so that 2.3 remains 2.3 in each direction.
    """
    if direction == NEAREST or not math.isfinite(value):
        return round(value, places) + 0.0  # no negative zero
    shortest = Decimal(repr(float(value)))
    unit = Decimal(1).scaleb(-places)
    return float(shortest.quantize(unit, ROUNDING[direction], EXACT)) + 0.0


def significant(value: float, digits: int, direction: int = NEAREST) -> str:
    """Return a number with significant digits, in the shortest form."""
    if value and direction != NEAREST and math.isfinite(value):
        value = rounded(value, digits - 1 - exponent(value), direction)
    return f"{value:.{digits}g}"


def significant_range(low: float, high: float, digits: int, word: str = "to") -> str:
    """Return a range with significant digits, its ends rounded outwards."""
    return f"{significant(low, digits, DOWN)} {word} {significant(high, digits, UP)}"
