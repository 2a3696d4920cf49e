"""A measure of a run as a number with uncertainty and scatter, and the map of all measures by name."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

from ..errors import suggestion
from ..files import DataTable
from ..numerics.outward import significant_range

NOT_ESTIMATED = "not estimated"  # in the place of a range where the error of a number is unknown


DIFFERENT = 0.01  # share of a measure by which turns differ that do not repeat each other
MOST_SHOWN = 4  # measures in a line


class Measured(float):
    """A measure of a run: a number with its uncertainty, ``low`` to ``high``, and its scatter over turns,
    ``lowest`` to ``highest``.

    ``value`` is the plain number, used wherever a number is expected. ``low`` and ``high`` are the range over
    the run and its companions, or that of the estimated error; ``lowest`` and ``highest`` the extremes over
    the turns that the measure is taken of (:class:`~vfife.measures.repetition.Turns`). If ``estimated`` is
    False, the error is unknown, and ``low`` and ``high`` equal the value, or cover the part of the error that
    is known, as the values of tries with larger steps; by default it is True if both are given. ``unique`` is
    False for a reaction of redundant joints, which rigid bodies do not determine: its value is that of the
    distribution of least norm, one of infinitely many. ``unit`` is the SI unit, "1" for shares and counts, ""
    for a measure that is not part of :class:`Measures`.
    """

    low: float
    high: float
    unique: bool
    lowest: float
    highest: float
    estimated: bool
    unit = ""

    def __new__(
        cls,
        value: float,
        low: float | None = None,
        high: float | None = None,
        unique: bool = True,
        lowest: float | None = None,
        highest: float | None = None,
        estimated: bool | None = None,
    ) -> Measured:
        """Create a float that carries its range, its lowest and highest turn, and whether it is unique and
        estimated.
        """
        measure = super().__new__(cls, value)
        measure.low, measure.high, measure.unique = (
            (value if low is None else low),
            (value if high is None else high),
            unique,
        )
        measure.lowest, measure.highest = (
            (value if lowest is None else lowest),
            (value if highest is None else highest),
        )
        measure.estimated = (low is not None and high is not None) if estimated is None else estimated
        return measure

    def __getnewargs__(self) -> tuple[float, float, float, bool, float, float, bool]:  # type: ignore[override]
        return self.value, self.low, self.high, self.unique, self.lowest, self.highest, self.estimated

    def __repr__(self) -> str:
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        text = significant_range(self.low, self.high, 6) if self.estimated else NOT_ESTIMATED
        inside = self.low <= self.lowest and self.highest <= self.high
        if self.variation > DIFFERENT * abs(self) and not inside:
            text += f"; single turns {significant_range(self.lowest, self.highest, 4)}"
        return f"{self:.6g}{unit} ({text})"

    def __str__(self) -> str:
        return float.__repr__(self)

    @property
    def value(self) -> float:
        """The plain number."""
        return float(self)

    @property
    def width(self) -> float:
        """``high`` - ``low``."""
        return self.high - self.low

    @property
    def variation(self) -> float:
        """``highest`` - ``lowest``."""
        return self.highest - self.lowest


class MissingMeasure(KeyError):
    """KeyError for an unknown measure, whose message is shown without quotes."""

    def __str__(self) -> str:
        return str(self.args[0])


class Measures(dict[str, Measured], DataTable):
    """Measures by name, ``<joint or body>.<quantity>.<statistic>``: ``C.force.max``, ``C.force.lip``; counts
    have none, ``C.impacts``.
    """

    part = ""  # of the run that they are of, but for counts, which are those of all of it

    def __repr__(self) -> str:
        shown_items = ", ".join(
            f"{name} = {measured!r}" for name, measured in islice(self.items(), MOST_SHOWN)
        )
        ellipsis = ", ..." if len(self) > MOST_SHOWN else ""
        return (
            f"<{len(self)} measures, {self.part or 'of a run'}: {shown_items}{ellipsis}; see .to_dataframe()>"
        )

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a row for each measure: name, value, unit, its range by errors, NaN where
        they are not estimated, and that of its turns.
        """
        yield ["measure", "value", "unit", "low", "high", "lowest", "highest", "estimated"]
        for name, measured in self.items():
            ends = (measured.low, measured.high) if measured.estimated else (math.nan, math.nan)
            yield [
                name,
                measured.value,
                measured.unit,
                *ends,
                measured.lowest,
                measured.highest,
                measured.estimated,
            ]

    def __missing__(self, name: str) -> Measured:
        raise MissingMeasure(
            f"there is no measure {name!r} here:"
            f" {suggestion(str(name), self, 'their names are those of result.measures')}"
        )

    def of(self, name: str) -> Iterator[tuple[str, Measured]]:
        """Yield the quantities of a joint or body, each with its statistics and measures."""
        for key, measured in self.items():
            if key.startswith(f"{name}."):
                yield key.removeprefix(f"{name}."), measured


def lips(measures: dict[str, Any]) -> dict[str, Any]:
    """Return the local influence parameters among measures, by ``<joint or body>.<quantity>``."""
    return {name.removesuffix(".lip"): value for name, value in measures.items() if name.endswith(".lip")}
