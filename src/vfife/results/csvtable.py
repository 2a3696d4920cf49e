"""Tables of commas, each whole or not there: numbers to the last bit, lines that end as RFC 4180 has it on every machine."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..files import write_text


def write_rows(path: str | Path, rows: Iterable[Iterable[Any]]) -> None:
    """Writes rows, that of the heads first; a file that is there gives way when the new one is whole. Raises OSError."""
    stream = io.StringIO(newline="")
    csv.writer(stream).writerows(rows)
    write_text(Path(path), stream.getvalue(), newline="")


def write_named(path: str | Path, heads: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> None:
    """The same of rows by names, empty where one has no value of a head. Raises OSError."""
    write_rows(path, [heads, *([row.get(head, "") for head in heads] for row in rows)])
