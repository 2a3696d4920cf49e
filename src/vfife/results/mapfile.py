"""One SQLite file a map: what is asked, and what each value of the number that is swept left; whole up to the last transaction."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from . import tables
from .header import MAP_APPLICATION, MAP_FORMAT, head_with
from .opening import connected, new_file, readable
from .packing import packed, unpacked
from .tables import told

Array = NDArray[np.float64]
ASKED = "map"  # the entry of the meta that says what is asked


class MapFile:
    """A map file, open for writing (:meth:`create`, :meth:`write`) or reading (:meth:`open`); a context manager that closes it."""

    kind: ClassVar[str] = "map"

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path, self._connection = path, connection

    @classmethod
    def create(cls, path: Path, asked: Mapping[str, Any]) -> MapFile:
        """A new map file, which is there whole or not at all; one of this name gives way. Raises StorageError."""
        with new_file(path, cls.kind, MAP_APPLICATION, MAP_FORMAT, tables.MAP_SCHEMA) as connection:
            tables.insert(connection, "meta", ASKED, json.dumps(asked))
        return cls.write(path)

    @classmethod
    def write(cls, path: Path) -> MapFile:
        """An existing map file, to go on with it."""
        return cls(refuse_other(path), connected(path))

    @classmethod
    def open(cls, path: Path) -> MapFile:
        """An existing map file, to be read. Raises RunFileError for any other file."""
        return cls(refuse_other(path), readable(path, cls.kind))

    def __enter__(self) -> MapFile:
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()

    @property
    @told
    def asked(self) -> dict[str, Any]:
        """What is asked. Raises RunFileError where that is damaged."""
        row = tables.sound(self._connection, "meta", ASKED)
        if row is None:
            raise RunFileError(f"{self.path}: what this map asks is damaged; make it again")
        found: dict[str, Any] = json.loads(row[1])
        return found

    @told
    def keep(self, number: int, points: Array, growth: Array, state: Array) -> None:
        """What the chains left at a value: points, shape (turns, series x chains), growth (turns, chains) and the state to go on from."""
        tables.insert(self._connection, "legs", number, packed(points), packed(growth), packed(state))

    @told
    def members(self) -> dict[int, tuple[Array, Array]]:
        """Points and growth of all that are there, whatever is missing or damaged between them."""
        found = tables.rows(self._connection, "legs")
        return {number: (unpacked(row[1]), unpacked(row[2])) for number, row in found if row is not None}

    @told
    def legs(self) -> list[tuple[Array, Array]]:
        """Points and growth of all values from the first on, up to one that is missing or damaged."""
        found: list[tuple[Array, Array]] = []
        while (row := tables.sound(self._connection, "legs", len(found))) is not None:
            found.append((unpacked(row[1]), unpacked(row[2])))
        return found

    @told
    def state(self, number: int) -> Array:
        """The state after a value, shape (rows, chains)."""
        row = tables.sound(self._connection, "legs", number)
        if row is None:
            raise RunFileError(f"{self.path}: the state after value {number} is damaged; make the map again")
        return unpacked(row[3])


def refuse_other(path: Path) -> Path:
    """The path of a map file. Raises RunFileError for any other, and for one that a newer version wrote."""
    head = head_with(path, MAP_APPLICATION)
    if head is None:
        raise RunFileError(f"{path}: this is no map file of vfife; name a file that vfife map left")
    if int.from_bytes(head[60:64], "big") > MAP_FORMAT:
        raise RunFileError(f"{path}: this map file was written by a newer vfife; install that version to read it")
    return path
