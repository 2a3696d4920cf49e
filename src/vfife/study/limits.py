"""Limits of measures: which machines fail, and what is said of limits in a study file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import QuantityError, kind_of, shown, suggestion
from ..fields import Reading, Refused
from ..units import number

ENDS = ("low", "high")


@dataclass(frozen=True)
class Bound:
    """A limit of a measure: at least ``low``, at most ``high``, in SI units."""

    measure: str
    low: float = -math.inf
    high: float = math.inf

    def excess(self, value: float) -> float:
        """How far beyond it a value is, zero or less where it is kept; infinite for no value."""
        over = max(value - self.high, self.low - value)
        return over if math.isfinite(value) else math.inf

    def surely_fails(self, value: float, error: float) -> bool:
        """Whether a value is beyond the limit, to whichever side it is wrong by an ``error``; no value fails."""
        return not math.isfinite(value) or value - error > self.high or value + error < self.low

    def may_fail(self, value: float, error: float) -> bool:
        """Whether a value is beyond the limit, or would be if it is wrong by an ``error``."""
        return not math.isfinite(value) or value + error > self.high or value - error < self.low

    def words(self, unit: str) -> str:
        """The limit as a person says it."""
        said = "" if unit == "1" else f" {unit}"
        ends = ((self.low, "at least"), (self.high, "at most"))
        return " and ".join(f"{word} {end:.6g}{said}" for end, word in ends if math.isfinite(end))


def read_bounds(raw: Any, units: Mapping[str, str], by: Reading) -> tuple[Bound, ...]:
    """The limits of a table ``[limit]``: by measure the most that is allowed, or a table of ``low`` and ``high``. What is wrong is told."""
    if not isinstance(raw, dict):
        by.tell(("limit",), Refused(f"this is {kind_of(raw)}", shown(raw), "a table", 'write [limit] and, under it, "C.force.max" = "2 kN"'))
        return ()
    found = []
    for measure, given in flat(raw):
        where = ("limit", measure)
        if measure not in units:
            by.tell(where, Refused("a limit of what is not measured", "", "", suggestion(measure, units, "name one of the measures")))
            continue
        ends = given if isinstance(given, dict) else {"high": given}
        read = {key: quantity(value, units[measure], (*where, key), by) for key, value in ends.items()}
        known = {key: value for key, value in read.items() if value is not None}
        if len(known) < len(read):
            continue
        if not known.get("low", -math.inf) < known.get("high", math.inf):
            by.tell(where, Refused("no number is within this limit", shown(given), "low below high", "exchange or correct them"))
        else:
            found.append(Bound(measure, **known))
    return tuple(found)


def flat(raw: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Measures and what is said of them; a name without quotes has become tables in tables."""
    for key, value in raw.items():
        name = f"{above}.{key}" if above else str(key)
        if isinstance(value, dict) and value and not set(value) <= set(ENDS):
            yield from flat(value, name)
        else:
            yield name, value


def quantity(value: Any, unit: str, where: tuple[str, ...], by: Reading) -> float | None:
    """A quantity in SI units; None where it is none, which is told."""
    try:
        return number(value, "1" if unit == "%" else unit)
    except QuantityError as error:
        by.tell(where, Refused(f"this is {error.what}", shown(value), error.limit, f"write {error.remedy}"))
        return None
