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
from .packing import packed, unpacked

KEYS = "*"  # the entry that names all others
FIRST = "first output"  # its copy
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
        lose(f"its {name}")
    return found


def first_output(connection: sqlite3.Connection) -> NDArray[np.float64] | None:
    """The copy of the first output, shape (1, kept); None where there is none, or it is damaged."""
    row = tables.sound(connection, "copies", FIRST)
    return None if row is None else unpacked(row[1])


def parted(meta: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
    """What JSON can say, and arrays."""
    arrays = {key: value for key, value in meta.items() if isinstance(value, np.ndarray)}
    return {key: value for key, value in meta.items() if key not in arrays}, arrays


def packed_all(arrays: Mapping[str, NDArray[np.float64]]) -> dict[str, bytes]:
    """Arrays as bytes."""
    return {key: packed(values) for key, values in arrays.items()}
