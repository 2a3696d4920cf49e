"""Parameters of a study, as its readers see them."""

from __future__ import annotations

from dataclasses import dataclass

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

    @property
    def gridded(self) -> bool:
        """Whether its values were listed one by one."""
        return self.kind in ("values", "range")
