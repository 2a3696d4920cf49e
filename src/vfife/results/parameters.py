"""Parameters of a study, as its readers see them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..units import quantity_in_si


@dataclass(frozen=True)
class Varied:
    """A parameter of a study: name, paths in the model, unit, and how its values were chosen.

    ``written``: the unit in which the study file gives its values, empty for bare numbers.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    kind: str
    words: str = ""
    written: str = ""

    @property
    def written_factor(self) -> float:
        """Size of the unit in which values are written, in SI units."""
        return quantity_in_si("1", self.written or self.unit)

    def in_written_unit(self, value: float) -> float:
        """Return a number in SI units in the written unit: the short decimal that gives the same number back,
        if there is one.
        """
        factor = self.written_factor
        digits = f"{value / factor:.15g}"
        # Exact, as units are read: a product with the factor may miss by one rounding, as of 200 rpm.
        return float(digits) if quantity_in_si(digits, self.written) == value else value / factor

    @property
    def gridded(self) -> bool:
        """Whether its values were listed one by one."""
        return self.kind in ("values", "range")


def in_list(values: Any) -> list[Any]:
    """Return values as a list, a single one as a list of one."""
    return list(values) if isinstance(values, list | tuple) else [values]


def in_order(values: Any) -> list[Any]:
    """Return the distinct values: numbers sorted, words in order of appearance."""
    unique = list(dict.fromkeys(values))
    return unique if any(isinstance(value, str) for value in unique) else sorted(unique)
