"""Lengths, places and angles as a user would write them: in the unit of the value before, rounded to what a
drawing shows.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

from ...modelfile.tables import Raw, table
from ...units import quantity_in_si

FINENESS = 1e-4  # of the size of a mechanism: resolution of lengths, rounded down to a power of ten
ANGLE = 1e-5  # rad, resolution of angles
QUANTITY = re.compile(r"\s*([-+0-9.eE]+)\s*(\S.*?)\s*")


def resolution(size: float) -> float:
    """Return the resolution (m) of lengths in a mechanism of a ``size`` (m)."""
    return 10.0 ** math.floor(math.log10(size * FINENESS)) if size > 0.0 else 1e-6


def unit_of(value: Any) -> str:
    """Return the unit of a value as written; "" for a bare number and for anything else."""
    match = QUANTITY.fullmatch(value) if isinstance(value, str) else None
    return match[2] if match else ""


def length_unit(raw: Raw) -> str:
    """Return the unit in which a model gives its lengths; "" if it gives them as bare numbers."""
    values: Iterable[Any] = [
        *(body.get("length") for body in table(raw, "body").values() if isinstance(body, dict)),
        *(part for point in table(raw, "ground").values() if isinstance(point, list) for part in point),
    ]
    return next((unit for value in values if (unit := unit_of(value))), "")


def quantity_text(value: float, step: float, unit: str) -> Any:
    """Return a number (SI), rounded to a ``step`` (SI), as a bare number or as a text with its unit.

    >>> quantity_text(0.41237, 1e-4, "mm"), quantity_text(0.41237, 1e-4, "")
    ('412.4 mm', 0.4124)
    """
    factor = quantity_in_si("1", unit) if unit else 1.0
    decimals = max(0, -math.floor(math.log10(step / factor) + 1e-9))
    text = f"{round(value / factor, decimals) + 0.0:.{decimals}f}"
    if unit:
        return f"{text.rstrip('0').rstrip('.') if '.' in text else text} {unit}"
    number = float(text)
    return int(number) if number == int(number) else number


def angle(value: float, old: Any) -> Any:
    """Return an angle (rad) within half a turn, in the unit of the angle before; in degrees if there is
    none.
    """
    turned = math.remainder(value, 2.0 * math.pi)
    unit = unit_of(old) or ("" if isinstance(old, float) else "deg")
    return quantity_text(turned, ANGLE, unit)
