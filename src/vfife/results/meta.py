"""What a file knows of its run: entries that JSON can say, and arrays, each sealed. A second copy of each lies elsewhere in the file, and one
of the first output, from which energies count: damage to one place loses none of them.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import tables
from .packing import packed, seal, unpacked

ARRAY = "array."  # of the meta, among the parts of a reference
PART_BYTES = 2**26  # of the reference's rows in one block
KEYS = "*"  # the entry that names all others
FIRST = "first output"  # its copy
COUNTED = "counted"  # what a run that ended left: where all of a table is damaged, nothing else tells of it
NOT_COPIED = {"summary"}  # what can be told again from the rest


def put(connection: sqlite3.Connection, insert: Callable[..., None], meta: Mapping[str, Any]) -> None:
    """Replaces entries and their copies."""
    entries, arrays = parted(meta)
    if not entries and not arrays:
        return
    known = tables.sound(connection, "meta", KEYS) or tables.sound(connection, "copies", f"meta.{KEYS}")
    names = {*entries, *arrays, *(json.loads(known[1]) if known else ())}
    entries[KEYS] = sorted(names)
    for table, values in (("meta", {key: json.dumps(value) for key, value in entries.items()}), ("arrays", packed_all(arrays))):
        for key, value in values.items():
            insert(table, key, value)
            if key not in NOT_COPIED:
                insert("copies", f"{table}.{key}", value if isinstance(value, bytes) else value.encode())


def read(connection: sqlite3.Connection, lose: Callable[[str], None]) -> dict[str, Any]:
    """All entries. Those that are lost in both places are told to ``lose``, and left out."""
    found: dict[str, Any] = {}
    lost: set[str] = set()
    for table, value_of in (("meta", json.loads), ("arrays", unpacked)):
        stored = dict(tables.each(connection, table))
        prefix = f"{table}."
        keys = {*stored, *(str(key).removeprefix(prefix) for key in tables.keys(connection, "copies") if str(key).startswith(prefix))}
        for key in keys:
            row = stored.get(key) or tables.sound(connection, "copies", f"{table}.{key}")
            if row is None:
                lost.add(str(key))
            else:
                found[str(key)] = value_of(row[1])
    names = found.pop(KEYS, None)
    if names is None and (found or lost):
        lose("the list of what it says")
    for name in sorted((lost | set(names or ())) - set(found) - {KEYS}):
        lose(f"its {name}" if name.isprintable() else "an entry of what it says")
    found.pop(COUNTED, None)
    return found


def count(connection: sqlite3.Connection, history: tuple[int, int]) -> dict[str, Any]:
    """What there is of everything but the meta itself: chunks and outputs of the ``history``, rows of the other tables."""
    rows = {
        table: connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in ("checkpoints", "companions", "reference", "events")
    }
    return {COUNTED: {"history": history, **rows, "steps": seal_of_steps(blobs_of_steps(connection))}}


def blobs_of_steps(connection: sqlite3.Connection) -> list[bytes]:
    """Step numbers of all chunks, as they are stored; what stands behind them in their rows is not read."""
    return [bytes(data) for (data,) in connection.execute("SELECT steps FROM history ORDER BY chunk")]


def seal_of_steps(blobs: list[bytes]) -> str:
    """The seal of all step numbers together."""
    return seal("steps", *blobs).hex()


def steps_alone(connection: sqlite3.Connection) -> NDArray[np.int64] | None:
    """Step numbers of the outputs of a run that ended, (outputs,), without the outputs; None where they are not known to be whole."""
    try:
        blobs = blobs_of_steps(connection)
    except (sqlite3.DatabaseError, UnicodeDecodeError, TypeError):
        return None
    if not blobs or seal_of_steps(blobs) != counted(connection, "steps"):
        return None
    return np.concatenate([unpacked(data) for data in blobs]).astype(np.int64)


def counted(connection: sqlite3.Connection, table: str) -> Any:
    """How many rows of a table there were when the run ended, chunks and outputs of the history; zero before, or where nobody knows."""
    row = tables.sound(connection, "meta", COUNTED) or tables.sound(connection, "copies", f"meta.{COUNTED}")
    found = None if row is None else json.loads(row[1])
    return (found or {"history": (0, 0)}).get(table, 0)


def first_output(connection: sqlite3.Connection) -> NDArray[np.float64] | None:
    """The copy of the first output, shape (1, kept); None where there is none, or it is damaged."""
    row = tables.sound(connection, "copies", FIRST)
    return None if row is None else unpacked(row[1])


def reference_parts(meta: Mapping[str, Any], steps: NDArray[np.int64], rows: NDArray[np.float64]) -> dict[str, bytes]:
    """The record of the ideal mechanism as rows of its table."""
    entries, arrays = parted(meta)
    some = max(1, PART_BYTES // max(8 * rows.shape[1], 1))
    parts = {"steps": packed(steps.astype(float))}
    parts |= {f"rows.{k}": packed(rows[first : first + some]) for k, first in enumerate(range(0, max(len(rows), 1), some))}
    parts |= {f"{ARRAY}{key}": data for key, data in packed_all(arrays).items()}
    return parts | {"meta": json.dumps({**entries, KEYS: sorted(parts)}).encode()}


def reference_of(parts: Mapping[str, bytes]) -> tuple[dict[str, Any], NDArray[np.int64], NDArray[np.float64]] | None:
    """Meta, steps and rows from such rows; None where some of them are missing."""
    blocks = sorted((key for key in parts if key == "rows" or key.startswith("rows.")), key=lambda key: int(key.partition(".")[2] or 0))
    meta = json.loads(parts.get("meta", b"{}"))
    if not blocks or not {"meta", "steps", *meta.pop(KEYS, ())} <= set(parts):
        return None
    meta |= {key.removeprefix(ARRAY): unpacked(data) for key, data in parts.items() if key.startswith(ARRAY)}
    steps, rows = unpacked(parts["steps"]).astype(np.int64), np.concatenate([unpacked(parts[key]) for key in blocks])
    return (meta, steps, rows) if len(steps) == len(rows) else None


def parted(meta: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
    """What JSON can say, and arrays."""
    arrays = {key: value for key, value in meta.items() if isinstance(value, np.ndarray)}
    return {key: value for key, value in meta.items() if key not in arrays}, arrays


def packed_all(arrays: Mapping[str, NDArray[np.float64]]) -> dict[str, bytes]:
    """Arrays as bytes."""
    return {key: packed(values) for key, values in arrays.items()}
