"""Numbers of tables for spreadsheets (XLSX, CSV with decimal commas): no more digits than readers can use.

Formats that programs read back (CSV with decimal points, NetCDF, Parquet, MATLAB, JSON) have all digits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import chain, repeat
from typing import Any

DIGITS = 7
# Outputs of a long run lie close together on its axis of time.
DIGITS_OF_TIME = 10
TIMES = ("time [s]", "load_factor")
# Decimals of an angle: 3.4e-13 degrees is the 0 of an angle that was reduced to one turn.
DECIMALS_OF_ANGLES = 6
ANGLE = "[deg]"


def rounded_rows(rows: Iterable[Iterable[Any]]) -> Iterator[Iterable[Any]]:
    """Yield the heads of a table, then its rows with numbers of :data:`DIGITS` digits, times of a few more;
    angles in degrees are rounded to millionths, so that multiples are exact. Other cells are unchanged.
    """
    remaining = iter(rows)
    heads = next(remaining, None)
    if heads is None:
        return
    heads = list(heads)
    yield heads
    kinds = [(DIGITS_OF_TIME if head in TIMES else DIGITS, str(head).endswith(ANGLE)) for head in heads]
    for row in remaining:
        # A row may be longer than its heads.
        yield [
            _rounded(value, *kind) if isinstance(value, float) else value
            for value, kind in zip(row, chain(kinds, repeat((DIGITS, False))), strict=False)
        ]


def _rounded(value: float, digits: int, angle: bool) -> float:
    """Return a number with a count of digits; zero without a sign."""
    if not math.isfinite(value):
        return value
    return float(f"{round(value, DECIMALS_OF_ANGLES) if angle else value:.{digits}g}") + 0.0
