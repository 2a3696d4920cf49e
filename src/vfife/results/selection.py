"""The part of a result that is exported: some of its series, over some of its turns."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError, shown, suggestion
from .series import FINE, SeriesColumn, belongs, columns

if TYPE_CHECKING:
    import xarray

    from .run_data import RunData

LAST = "last"
SPAN = re.compile(r"(\d+)(?:\.\.(\d+))?")
ROUNDING = 1e-9  # of a turn, by which the time of an output may miss an end of it
ALWAYS = ("time", "load_factor", "crank_angle")  # columns of series table


@dataclass(frozen=True)
class SelectedColumn(SeriesColumn):
    """A series at some outputs; ``rows`` are their numbers, in the order of the table."""

    rows: NDArray[np.intp]

    @property
    def values(self) -> NDArray[Any]:
        """Values at the selected outputs, shape (rows,)."""
        return super().values[self.rows]


@dataclass(frozen=True)
class Selection:
    """Series of a result whose names fit ``channels`` (all if there are none), at the outputs ``rows`` (all
    if None); ``by_angle``: in the order of the crank's angle.
    """

    view: RunData
    channels: tuple[str, ...] = ()
    rows: NDArray[np.intp] | None = None
    by_angle: bool = False

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return self.view.name

    @property
    def attributes(self) -> dict[str, Any]:
        """What the numbers come from."""
        return self.view.attributes

    @property
    def count(self) -> int:
        """Number of selected outputs."""
        return len(self.view.record.steps) if self.rows is None else len(self.rows)

    def columns(self, fine: bool = False) -> list[SeriesColumn]:
        """Return the selected series, time and the crank's angle first; ``fine``: with those of elements and
        particles, which are also selected by their names. Raises VfifeError for a name that fits none.
        """
        series = columns(self.view, fine=fine or bool(self.channels))
        if self.channels:
            series = [column for column in series if column.name in ALWAYS] + self.named(series, fine)
        if self.by_angle:
            series.sort(key=lambda column: column.name != "crank_angle")
        if self.rows is None:
            return series
        return [SelectedColumn(c.variable, c.owner, c.index, c.channel, self.rows) for c in series]

    def named(self, series: Sequence[SeriesColumn], fine: bool) -> list[SeriesColumn]:
        """Return the series that the channels name, in their order. Raises VfifeError for a name that fits
        none.
        """
        columns_by_name: dict[str, SeriesColumn] = {}
        for channel in self.channels:
            matches = {column.name: column for column in series if fits(column, channel, fine)}
            if not matches:
                remedy = suggestion(channel, [column.name for column in series], "leave it out for all")
                raise VfifeError(f"channels: there is no series {shown(channel)} in this result: {remedy}")
            columns_by_name |= {
                name: column for name, column in matches.items() if name not in columns_by_name
            }
        return list(columns_by_name.values())

    @property
    def data(self) -> xarray.Dataset:
        """Dataset of the selected outputs; a selected channel has all its joints or bodies."""
        data = self.view.data
        if self.rows is not None:
            data = data.isel(time=self.rows)
        if not self.channels:
            return data
        return data[
            [name for name in dict.fromkeys(c.variable for c in self.columns()) if name in data.data_vars]
        ]


def fits(column: SeriesColumn, channel: str, fine: bool) -> bool:
    """Return whether a series is meant by its name (``C.force``), by a pattern (``*.force``), or by the name
    of its joint or body, of which only with ``fine`` the elements and particles are meant, too.
    """
    if any(sign in channel for sign in "*?"):
        return fnmatchcase(column.name, channel)
    return column.name == channel or (belongs(column.owner, channel) and (fine or column.entity not in FINE))


def selection(
    view: RunData,
    channels: str | Iterable[str] | None = None,
    turns: str | int | Sequence[int] | None = None,
    by_angle: bool = False,
) -> Selection:
    """Select series and outputs of a result.

    channels: names or patterns of series, or names of joints, bodies and springs
    turns: number of a turn, counted from 1, first and last number, both as text ("59..60"), or "last"
    by_angle: the outputs of the one turn in the order of the crank's angle

    Raises VfifeError for names, numbers or a result that do not allow it.
    """
    names = tuple(
        name
        for text in ([channels] if isinstance(channels, str) else channels or ())
        for name in str(text).split(",")
        if name
    )
    if turns is None and not by_angle:
        return Selection(view, names)
    first, last = turn_numbers(view, LAST if turns is None else turns)
    rows = outputs_of(view, first, last)
    if by_angle:
        if first != last:
            raise VfifeError(
                f"turns: {first} to {last}: only the outputs of one turn have an order by angle; name one"
            )
        angle = view.crank_angle
        # The first output is at the same angle as the last one, and belongs to the turn before.
        rows = rows[1:]
        rows = rows if angle is None else rows[np.argsort(angle[rows], kind="stable")]
    return Selection(view, names, rows, by_angle)


def turn_numbers(view: RunData, turns: str | int | Sequence[int]) -> tuple[int, int]:
    """Return the first and the last of some turns. Raises VfifeError for a result without such turns."""
    duration = view.record.assembly.choice.turn
    count = 0 if duration is None else int(float(view.time[-1]) / duration + ROUNDING)
    if not count:
        raise VfifeError("turns: this result has no full turn of a crank; leave the turns out")
    if turns == LAST:
        return count, count
    match = SPAN.fullmatch(str(turns).strip()) if isinstance(turns, str | int) else None
    if match is not None:
        pair: Sequence[Any] = (match[1], match[2] or match[1])
    else:
        pair = turns if isinstance(turns, Sequence) and not isinstance(turns, str) else ()
    numbers = [int(number) for number in pair if str(number).isdigit()]
    if len(numbers) != 2 or len(pair) != 2 or not 1 <= numbers[0] <= numbers[1] <= count:
        remedy = f"this result has turns 1 to {count}: write one, as {count}, some, as 1..{count}, or last"
        raise VfifeError(f"turns: {shown(turns)}: {remedy}")
    return numbers[0], numbers[1]


def outputs_of(view: RunData, first: int, last: int) -> NDArray[np.intp]:
    """Return the numbers of the outputs from the begin of the ``first`` to the end of the ``last`` turn."""
    turn = view.time / (view.record.assembly.choice.turn or 1.0)
    inside = (turn >= first - 1 - ROUNDING) & (turn <= last + ROUNDING)
    return np.flatnonzero(inside)
