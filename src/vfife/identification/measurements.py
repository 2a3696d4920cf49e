"""Measured curves from a CSV file, whose columns are time or crank angle, and channels of a result in any
units.
"""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, VfifeError, shown, suggestion
from ..files import path_of, read_bytes, remedy_of_row, with_decimal_points
from ..files.kinds import refuse_kind
from ..units import unit_factor

if TYPE_CHECKING:
    import pandas

Array = NDArray[np.float64]
Abscissa = Literal["time", "angle"]

HEAD = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))?\s*")
ABSCISSAE: Mapping[str, tuple[Abscissa, str]] = {
    "time": ("time", "s"),
    "t": ("time", "s"),
    "crank_angle": ("angle", "rad"),
    "angle": ("angle", "rad"),
}
LARGEST, MOST_ROWS = 64_000_000, 500_000  # bytes and rows of a file
FRAME = "data frame"  # name of the data of a frame
LEAST_SAMPLES = 8  # samples of a curve
MOST_FAULTS = 10  # faults of one kind; more are counted


@dataclass(frozen=True)
class Curve:
    """A measured curve: its ``channel``, its ``head`` in the file, ``values`` in the channel's unit, shape
    (samples,), and its ``weight``.

    A curve that is only ``proportional`` to its channel, as a sound pressure is to an acceleration, has the
    unit of the file.
    """

    channel: str
    head: str
    values: Array
    proportional: bool = False
    weight: float = 1.0


@dataclass(frozen=True)
class Measured:
    """Measured ``curves`` over ascending times (s) or crank angles (rad) ``places``, shape (samples,).

    ``omitted``: names of columns that are named like a channel and not compared, because others were named.
    ``unknown``: columns that have the name of no channel, where none was named, each with what it may mean.
    """

    over: Abscissa
    places: Array
    curves: tuple[Curve, ...]
    name: str = "data"
    omitted: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()

    def subsample(self, count: int) -> Measured:
        """Return the curves with one sample out of ``count``."""
        curves = tuple(replace(curve, values=curve.values[::count]) for curve in self.curves)
        return replace(self, places=self.places[::count], curves=curves) if count > 1 else self

    @property
    def unit(self) -> str:
        """Unit of the places."""
        return "rad" if self.over == "angle" else "s"

    @property
    def span(self) -> float:
        """Distance from the first sample to the last (s or rad)."""
        return float(self.places[-1] - self.places[0])

    @property
    def spacing(self) -> float:
        """Median distance of successive samples (s or rad)."""
        return float(np.median(np.diff(self.places)))


@dataclass(frozen=True)
class CsvSpec:
    """The ``channel`` of a column, and whether the column is only ``proportional`` to it."""

    channel: str
    proportional: bool = False


def measured(
    data: str | Path | pandas.DataFrame,
    units: Mapping[str, str],
    specs: Mapping[str, CsvSpec] | None = None,
    weights: Mapping[str, float] | None = None,
) -> Measured:
    """Read the curves of a CSV file, or of a data frame with columns of the same names.

    ``units`` are the units of the mechanism's channels by name. ``specs`` maps names of columns to their
    channels; without it, every column with the name of a channel is used. ``weights`` are by name of a
    column, 1 unless given. Raises ModelError with all faults of the file.
    """
    weights, faults = weights or {}, list[Fault]()
    if isinstance(data, str | os.PathLike):
        path = path_of(data, "fit")
        refuse_kind(path, "table")
        name, text = path.name, csv_text(path, faults)
    else:
        path, name, text = Path(FRAME), FRAME, frame_text(data)
    heads, rows = table(text, faults)
    columns = [split(head) for head in heads]
    place = abscissa(columns, heads, faults)
    fault_count = len(faults)
    chosen = choice(columns, units, specs, faults) if heads else {}
    if heads and len(faults) == fault_count and not chosen:
        similar = ", ".join(text for text in unknown_columns(columns, place, units) if text[-1] == ")")
        remedy = (
            f"name columns as channels are{similar and ': '}{similar}, or say which is which with --column;"
        )
        remedy += f" the mechanism has {', '.join(list(units)[:8])} ..."
        faults.append(
            Fault("line 1", "no column is a channel of the mechanism", shown(", ".join(heads)), "", remedy)
        )
    check_weights(weights, {columns[k][0] for k in chosen}, heads, faults)
    factors: dict[int, float] = {}
    for k, spec in chosen.items():
        factors[k] = (
            1.0
            if spec.proportional
            else factor(columns[k][1], units[spec.channel], f"line 1, column {k + 1}", faults)
        )
    if place is not None:
        quantity, unit = ABSCISSAE[columns[place][0].lower()]
        factors[place] = factor(columns[place][1], unit, f"line 1, column {place + 1}", faults)
    values = numbers(rows, heads, sorted(factors), faults)
    if place is not None and quantity == "angle" and np.isfinite(values[place]).all():  # of several turns
        values[place] = np.unwrap(factors[place] * values[place]) / factors[place]
    if place is not None:
        check_places(values[place], [line for line, _ in rows], heads[place], faults)
    flat = [heads[k] for k in chosen if len(rows) and float(np.ptp(values[k])) == 0.0]
    faults += [Fault(f"column {head}", "every value is the same", remedy="leave it out") for head in flat]
    if faults or place is None:
        raise ModelError(faults, str(path))
    curves = tuple(
        Curve(
            spec.channel,
            heads[k],
            factors[k] * values[k],
            spec.proportional,
            float(weights.get(columns[k][0], 1.0)),
        )
        for k, spec in chosen.items()
    )
    omitted = tuple(name for k, (name, _) in enumerate(columns) if name in units and k not in chosen)
    unknown = unknown_columns(columns, place, units) if specs is None else ()
    return Measured(quantity, factors[place] * values[place], curves, name, omitted, unknown)


def unknown_columns(
    columns: Sequence[tuple[str, str]], place: int | None, units: Mapping[str, str]
) -> tuple[str, ...]:
    """Return the columns that have the name of no channel, each with channels that it may mean; that at
    ``place`` is the time or angle.
    """
    names = [name for k, (name, _) in enumerate(columns) if k != place and name and name not in units]
    advice = {name: suggestion(name, units, "") for name in names}
    return tuple(f"{name} ({text})" if text.startswith("did") else name for name, text in advice.items())


def abscissa(columns: Sequence[tuple[str, str]], heads: Sequence[str], faults: list[Fault]) -> int | None:
    """Return the number of the column of times or angles, or None after adding a fault."""
    place = next((k for k, (name, _) in enumerate(columns) if name.lower() in ABSCISSAE), None)
    if heads and place is None:
        faults.append(
            Fault(
                "line 1",
                "there is no column of times or angles",
                shown(", ".join(heads)),
                "time or crank_angle",
                "name the first column time (s)",
            )
        )
    return place


def check_weights(
    weights: Mapping[str, float], names: Collection[str], heads: Sequence[str], faults: list[Fault]
) -> None:
    """Add faults for weights that are not positive, or of a column that is not among the used ``names``."""
    for name, weight in weights.items():
        if names and name not in names:
            faults.append(
                Fault(
                    f"weight of {name}",
                    "there is no such column among those that are used",
                    "",
                    "",
                    suggestion(name, heads, "name one"),
                )
            )
        elif not 0.0 < weight < math.inf:
            faults.append(
                Fault(f"weight of {name}", "out of range", shown(weight), "a number above 0", "correct it")
            )


def csv_text(path: Path, faults: list[Fault]) -> str | None:
    """Return the text of a file, or None after adding a fault: too large, unreadable, or not UTF-8."""
    try:
        if path.stat().st_size > LARGEST:
            faults.append(
                Fault(
                    "file",
                    "it is too large",
                    f"{path.stat().st_size:,} bytes",
                    f"{LARGEST // 1_000_000} MB",
                    "thin it out",
                )
            )
            return None
        return read_bytes(path, LARGEST).decode("utf-8-sig")
    except OSError as error:
        csv_names = (
            [file.name for file in path.absolute().parent.glob("*.csv")]
            if path.absolute().parent.is_dir()
            else []
        )
        missing = isinstance(error, FileNotFoundError)
        remedy = (
            suggestion(path.name, csv_names, "check the name") if missing else "name a file that can be read"
        )
        faults.append(Fault("file", f"it cannot be read ({error.strerror})", remedy=remedy))
        return None
    except UnicodeDecodeError as error:
        faults.append(
            Fault(f"byte {error.start}", "the text is not UTF-8", remedy="save the file in this encoding")
        )
        return None


def frame_text(frame: pandas.DataFrame) -> str:
    """Return a data frame as the text of a CSV file; its index is a column if it is named as times or angles
    are and no column is.
    """

    def is_place(name: Any) -> bool:
        return split(str(name))[0].lower() in ABSCISSAE

    index = is_place(frame.index.name) and not any(map(is_place, frame.columns))
    return str(frame.to_csv(index=index))


def table(text: str | None, faults: list[Fault]) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Read the heads of a CSV text and its rows, each with the number of its line; add faults to ``faults``.

    The delimiter is the most frequent of comma, semicolon and tab in the first line; lines that begin with
    ``#`` are comments. Between semicolons or tabs numbers may have decimal commas. Rows with a wrong number
    of cells are reported and left out.
    """
    if text is None:
        return [], []
    first = next(
        (line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), ""
    )
    delimiter = max(",;\t", key=first.count)
    reader = csv.reader(text.splitlines(), delimiter=delimiter, skipinitialspace=True)
    rows: list[tuple[int, list[str]]] = []
    try:
        rows += [
            (reader.line_num, row)
            for row in reader
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")
        ]
    except csv.Error as error:
        faults.append(
            Fault(f"line {reader.line_num}", f"this is not valid CSV ({error})", remedy="close every quote")
        )
    if not rows:
        faults.append(
            Fault("file", "the file is empty", remedy='begin with a line such as "time (s), C.force (N)"')
        )
        return [], []
    heads = [cell.strip() for cell in rows[0][1]]
    if len(rows) - 1 < LEAST_SAMPLES:
        faults.append(
            Fault(
                "file",
                f"it has {len(rows) - 1} rows of numbers",
                "",
                f"{LEAST_SAMPLES} or more",
                "measure more, or check the file",
            )
        )
    if len(rows) - 1 > MOST_ROWS:
        faults.append(
            Fault("file", f"it has {len(rows) - 1:,} rows of numbers", "", f"{MOST_ROWS:,}", "thin it out")
        )
    incomplete_rows = [(line, row) for line, row in rows if len(row) != len(heads)]
    add_first(
        faults,
        [fault_of_row(line, row, len(heads), delimiter) for line, row in incomplete_rows[:MOST_FAULTS]],
        len(incomplete_rows),
        "lines have another number of values",
    )
    complete_rows = [(line, row) for line, row in rows[1:] if len(row) == len(heads)]
    cells = with_decimal_points([row for _, row in complete_rows], delimiter)
    return heads, list(zip((line for line, _ in complete_rows), cells, strict=True))


def fault_of_row(line: int, row: Sequence[str], count: int, delimiter: str) -> Fault:
    """Return the fault of a row that has not ``count`` values."""
    remedy = remedy_of_row(len(row), count, delimiter)
    return Fault(f"line {line}", f"it has {len(row)} values", "", f"{count}, as the first line", remedy)


def add_first(faults: list[Fault], first: Sequence[Fault], count: int, noun: str) -> None:
    """Add the ``first`` faults of one kind, and one that states how many more of ``count`` there are."""
    faults += first
    if count > len(first):
        faults.append(Fault("file", f"{count - len(first):,} more {noun}"))


def split(head: str) -> tuple[str, str]:
    """Return name and unit of a column's head, ``C.force [N]`` or ``C.force (N)``."""
    match = HEAD.fullmatch(head)
    return (match[1].strip(), (match[2] or match[3] or "").strip()) if match is not None else (head, "")


def choice(
    columns: Sequence[tuple[str, str]],
    units: Mapping[str, str],
    specs: Mapping[str, CsvSpec] | None,
    faults: list[Fault],
) -> dict[int, CsvSpec]:
    """Return the columns to use, by number; add faults for unknown or repeated names."""
    names = [name for name, _ in columns]
    if specs is None:
        specs = {name: CsvSpec(name) for name in names if name in units}
    chosen = {}
    for name, spec in specs.items():
        place = f"column {name}"
        if name not in names:
            remedy = suggestion(name, names, "name one")
            faults.append(Fault(place, "there is no such column", "", "", remedy))
        elif spec.channel not in units:
            remedy = suggestion(spec.channel, units, f"there are {', '.join(list(units)[:8])} ...")
            faults.append(Fault(place, "the mechanism has no such channel", shown(spec.channel), "", remedy))
        else:
            if names.count(name) > 1:
                message, remedy = "there are several columns of this name", "rename all but one of them"
                faults.append(Fault(place, message, "", "one", remedy))
            chosen[names.index(name)] = spec
    return chosen


def factor(unit: str, channel_unit: str, place: str, faults: list[Fault]) -> float:
    """Return the factor from the unit of a column to that of its channel; 1 for a column without a unit."""
    try:
        return unit_factor(unit, channel_unit) if unit and unit != "1" else 1.0
    except Fault as error:
        faults.append(Fault(place, error.what, shown(unit), error.limit, f"for example [{channel_unit}]"))
        return 1.0


def numbers(
    rows: Sequence[tuple[int, list[str]]], heads: Sequence[str], columns: Collection[int], faults: list[Fault]
) -> dict[int, Array]:
    """Return the columns ``which`` as numbers, shape (rows,) each; report the first cells that are no finite
    numbers, and how many more there are.
    """
    table = {k: np.full(len(rows), np.nan) for k in columns}
    faulty_cells: list[Fault] = []
    count = 0
    for at, (line, row) in enumerate(rows):
        for k, column in table.items():
            try:
                column[at] = float(row[k])
            except ValueError:
                column[at] = math.nan
            if not math.isfinite(column[at]):
                count += 1
                if len(faulty_cells) < MOST_FAULTS:
                    faulty_cells.append(
                        Fault(f"line {line}, column {k + 1} ({heads[k]})", *cell_fault(row[k]))
                    )
    add_first(faults, faulty_cells, count, "cells are not numbers")
    return table


def cell_fault(cell: str) -> tuple[str, str, str, str]:
    """Return what is wrong with a cell, its text, what is allowed, and the remedy."""
    text = cell.strip()
    if not text:
        return "there is no value", "", "a number in each cell", "leave the row out, or fill it in"
    if re.fullmatch(r"[+-]?\d*,\d+(e[+-]?\d+)?", text, re.IGNORECASE):
        return "this is a text with a comma", shown(text), "a decimal point", "write 1.5 for 1,5"
    message = (
        "this is not a finite number"
        if re.fullmatch(r"[+-]?(nan|inf\w*)", text, re.IGNORECASE)
        else "this is not a number"
    )
    return message, shown(text), "a number", "leave the row out, or correct it"


def check_places(places: Array, lines: Sequence[int], head: str, faults: list[Fault]) -> None:
    """Add faults for times or angles that do not ascend; :func:`numbers` reports cells that are no
    numbers.
    """
    valid = np.flatnonzero(np.isfinite(places))
    back = np.flatnonzero(np.diff(places[valid]) <= 0.0)
    first = [
        Fault(
            f"line {lines[valid[at + 1]]}, column {head}",
            f"it is not after line {lines[valid[at]]}",
            f"{places[valid[at + 1]]:g} after {places[valid[at]]:g}",
            "ascending values",
            "sort the rows",
        )
        for at in back[:MOST_FAULTS]
    ]
    add_first(faults, first, len(back), "lines are not after the line before them")


def columns_of(texts: Sequence[str] | Mapping[str, str] | None) -> dict[str, CsvSpec] | None:
    """Return the channels of columns from texts ``"acc=C.force"``, or ``"mic~rod.angular_acceleration"`` for
    a column that is only proportional to its channel; None without any.

    Raises VfifeError for a text of another form.
    """
    pairs = (
        [f"{name}={channel}" for name, channel in texts.items()]
        if isinstance(texts, Mapping)
        else list(texts or ())
    )
    return dict(_columns(pairs)) or None


def _columns(texts: Sequence[str]) -> Iterator[tuple[str, CsvSpec]]:
    for text in texts:
        sign = next((letter for letter in text if letter in "=~"), "")
        name, _, channel = text.partition(sign) if sign else (text, "", text)
        channel = channel.strip()
        proportional = sign == "~" or channel.startswith("~")
        if not name.strip() or not channel.strip("~ "):
            raise VfifeError(
                f"column {shown(text)}: write COLUMN, COLUMN=CHANNEL, or COLUMN~CHANNEL where it is only"
                " proportional to the channel"
            )
        yield name.strip(), CsvSpec(channel.strip("~ "), proportional)
