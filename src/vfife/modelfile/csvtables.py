"""CSV files beside a model with tables of loads, drivers and contact laws, whose numbers become lists of the
model.

A mechanism, and the copy of the model in a run, contains the numbers and no longer needs the file.
"""

from __future__ import annotations

import csv
import errno
import io
import re
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any

from ..errors import Fault, Path, shown, suggestion, value_fault
from ..files import read_bytes, remedy_of_row, with_decimal_points
from ..units import number, unit_factor
from .tables import CSV, Raw, entries, target_of

LARGEST, MOST_ROWS = 8_000_000, 100_000  # bytes; rows
LONGEST_HEAD = 200  # characters
AXES = {"times": "s", "angles": "rad", "travels": "m", "speeds": "m/s"}
VALUES = {"factors": "1", "force": "N", "pressure": "Pa"}
COLUMNS: dict[str, dict[str, str]] = {  # keys of a section, with their units
    "load": {**AXES, **VALUES, **{f"{key}_back": unit for key, unit in VALUES.items()}},
    "driver": {**AXES, "torque": "N m", "force": "N"},
}
TABULATED, CURVES = "table", ("loading", "unloading")  # the law, and its keys that may name a file
CURVE = {"penetrations": "m", "force": "N"}
MIXED = "write decimal points; or decimal commas in the whole column, and semicolons between columns"
EXAMPLES = {"rad": "deg", "Pa": "bar", "m": "mm", "rad/s": "rpm"}  # units that tables often have
HEAD = re.compile(r"([A-Za-z_ ]{1,40})(?:[(\[]([^()\[\]]{1,40})[)\]])?\s*")


def expand(raw: Raw, file: str | None) -> list[Fault]:
    """Replace the names of CSV files by their numbers; return faults of files that cannot be read, whose
    tables stay as they were.
    """
    broken = []
    for section, columns in COLUMNS.items():
        for name, holder in entries(raw, section):
            if CSV not in holder:
                continue
            path: Path = (section, name, CSV)
            file_name = holder.pop(CSV)
            try:
                units = units_of(columns, holder, section)
                columns_read = read(file_name, file, units)
                for key in columns_read:
                    if key in holder:
                        raise Fault(
                            "",
                            f"{file_name} has a column for {key}, which the model has too",
                            remedy="remove one of the two",
                        )
            except Fault as fault:
                broken.append(in_file(fault, file_name, path))
            else:
                holder.update(columns_read)
    for name, holder in entries(raw, "joint"):
        law = holder.get("contact")
        if isinstance(law, dict):
            broken += expand_curves(law, file, ("joint", name, "contact"))
    return broken


def in_file(fault: Fault, file: Any, path: Path) -> Fault:
    """Return a fault of a CSV file at the key that names the file; the text of its cell is part of the
    problem.
    """
    cell = fault.value if fault.value not in ("", shown(file)) and fault.value not in fault.what else ""
    problem = f"{fault.what} ({cell})" if cell else fault.what
    return Fault(path, problem, shown(file), fault.limit, fault.remedy)


def expand_curves(holder: Raw, file: str | None, path: Path = ()) -> list[Fault]:
    """Replace the names of CSV files by their points in the table of a tabulated law."""
    broken = []
    for key in CURVES if holder.get("law") == TABULATED else ():
        if not isinstance(name := holder.get(key), str):
            continue
        try:
            columns_read = read(name, file, CURVE)
        except Fault as fault:
            broken.append(in_file(fault, name, (*path, key)))
            holder[key] = []
        else:
            points = [
                list(point) for point in zip(columns_read["penetrations"], columns_read["force"], strict=True)
            ]
            holder[key] = points if points[0][0] <= points[-1][0] else points[::-1]
    return broken


def units_of(columns: Mapping[str, str], holder: Raw, section: str) -> dict[str, str]:
    """Return units by key, for a driver along a line or about an axis."""
    if section == "driver" and target_of(holder) == "body":
        return {key: unit for key, unit in columns.items() if key not in ("travels", "force")} | {
            "speeds": "rad/s"
        }
    return {
        key: unit for key, unit in columns.items() if section == "load" or key not in ("angles", "torque")
    }


def read(name: Any, file: str | None, columns: Mapping[str, str]) -> dict[str, list[float]]:
    """Return lists of numbers in SI units by key. Raises Fault."""
    text = contents(name, file)
    lines = [line for line in text.splitlines() if line.strip()]
    first = next((line for line in lines if not line.lstrip().startswith("#")), "")
    delimiter = max(",;\t", key=first.count)
    (_, heads), *rows = list(rows_of(text, delimiter)) or [(0, [])]
    cells = with_decimal_points([row for _, row in rows], delimiter)
    keys = [head(title, k, columns) for k, title in enumerate(heads, 1)]
    if len(keys) < 2 or len({key for key, _ in keys}) < len(keys):
        problem = (
            "its first line names a column twice"
            if len(keys) > 1
            else "its first line does not name two columns"
        )
        raise Fault("", problem, shown(first), "", 'begin with a line such as "angle (deg), force (kN)"')
    columns_read: dict[str, list[float]] = {key: [] for key, _ in keys}
    for (line, _), row in zip(rows, cells, strict=True):
        if len(row) != len(keys):
            raise Fault(
                "",
                f"line {line} has {len(row)} values",
                shown(delimiter.join(row)),
                f"{len(keys)} values",
                remedy_of_row(len(row), len(keys), delimiter),
            )
        if len(columns_read[keys[0][0]]) >= MOST_ROWS:
            raise Fault("", f"line {line} is too many", "", f"at most {MOST_ROWS} rows", "thin the table out")
        for column, ((key, unit), cell) in enumerate(zip(keys, row, strict=True), 1):
            location = f"line {line}, column {column} ({heads[column - 1].strip()})"
            columns_read[key].append(cell_of(cell, unit, columns[key], location))
            if (
                key in AXES
                and len(columns_read[key]) > 1
                and not columns_read[key][-1] > columns_read[key][-2]
            ):
                raise Fault(
                    "",
                    f"{location}: this is not above the value before it",
                    shown(cell.strip()),
                    "",
                    "sort the rows, and keep one for each place",
                )
    if len(columns_read[keys[0][0]]) < 2:
        raise Fault(
            "", f"{name} has {len(columns_read[keys[0][0]])} rows of numbers", "", "two or more", "add more"
        )
    return columns_read


def contents(name: Any, file: str | None) -> str:
    """Return the text of a file beside the model. Raises Fault."""
    if not isinstance(name, str):
        raise value_fault(name, "the name of a CSV file", "put it in quotes")
    if file is None:
        raise Fault(
            "",
            "the model was given as a text, which has no folder",
            remedy="read it from its file, or write the lists into it",
        )
    folder, path = FilePath(file).resolve().parent, FilePath(name)
    try:
        target = (folder / path).resolve()
        exists = target.is_file()
    except (OSError, RuntimeError, ValueError):  # too long, a link to itself, a character that no name has
        raise Fault(
            "", "this is no name of a file", "", "a file beside the model", "correct the name"
        ) from None
    if path.is_absolute() or path.drive or not target.is_relative_to(folder):
        raise Fault(
            "",
            "this leads out of the folder of the model",
            "",
            "a file beside the model, or in a folder there",
            "copy it there",
        )
    if not exists:
        names = [sibling.name for sibling in target.parent.glob("*.csv")] if target.parent.is_dir() else []
        raise Fault(
            "",
            "there is no such file beside the model",
            remedy=suggestion(name, names, f"put it into {folder}"),
        )
    try:
        data = read_bytes(target, LARGEST)
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise Fault(
                "", "the file is too large", "", f"at most {LARGEST // 1_000_000} MB", "thin the table out"
            ) from None
        raise Fault(
            "", f"it cannot be read ({error.strerror})", remedy="name a file that can be read"
        ) from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise Fault("", f"line {line} is not UTF-8", remedy="save the file in this encoding") from None


def rows_of(text: str, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Yield rows with their line numbers, without empty rows and comments. Raises Fault."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, skipinitialspace=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#"):
                yield reader.line_num, row
    except csv.Error as error:
        raise Fault(
            "", f"line {reader.line_num} is not valid CSV ({error})", remedy="close every quote"
        ) from None


def head(text: str, column: int, columns: Mapping[str, str]) -> tuple[str, str]:
    """Return the key and unit of a column's head. Raises Fault."""
    location = f"line 1, column {column}"
    match = HEAD.fullmatch(text.strip()) if len(text) < LONGEST_HEAD else None
    if match is None or not match[1].strip():
        raise Fault("", f"{location}: this names no column", shown(text), "", 'write it as in "force (kN)"')
    name = match[1].strip().lower().replace(" ", "_")
    key = next(
        (
            candidate
            for candidate in columns
            if name in (candidate, candidate.removesuffix("s"), candidate.replace("s_back", "_back"))
        ),
        "",
    )
    if not key:
        singular = [candidate.removesuffix("s").replace("s_back", "_back") for candidate in columns]
        remedy = suggestion(name, singular, "")
        if not remedy.startswith("did you mean"):
            pairs = zip(singular, columns.values(), strict=True)
            heads = (
                f"{quantity} ({EXAMPLES.get(unit, unit)})" if unit != "1" else quantity
                for quantity, unit in pairs
            )
            remedy = f"write one of these, with its unit: {', '.join(heads)}"
        problem = f"{location}: no quantity is called {shown(text.strip())}"
        raise Fault("", problem, shown(text), "", remedy)
    if match[2] is None and columns[key] != "1":
        raise Fault(
            "",
            f"{location}: the column {shown(text.strip())} has no unit",
            shown(text.strip()),
            "a unit in parentheses",
            f'for example "{text.strip()} ({EXAMPLES.get(columns[key], columns[key])})"',
        )
    unit = (match[2] or columns[key]).strip()
    try:
        unit_factor(unit, columns[key])
    except Fault as error:
        raise Fault(
            "", f"{location}: {error.what}", "", error.limit, f"for example ({columns[key]})"
        ) from None
    return key, unit


def cell_of(text: str, unit: str, dimension: str, location: str) -> float:
    """Return the number of a cell in SI units. Raises Fault."""
    try:
        return number(f"{text.strip()} {unit}" if unit != "1" else text.strip(), dimension)
    except Fault as error:
        raise Fault(
            "",
            f"{location}: this is {error.what}",
            shown(text.strip()),
            "a number",
            MIXED if "," in text else "write a bare number; its unit stands in the first line",
        ) from None
