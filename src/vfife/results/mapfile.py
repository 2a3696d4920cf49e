"""One SQLite file a map, a section or basins: what is asked, and what each value, piece or start left; whole up to the last transaction."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from . import tables
from .askedfile import AskedFile
from .header import MAP_APPLICATION, MAP_FORMAT
from .packing import packed, unpacked
from .tables import told

Array = NDArray[np.float64]


class MapFile(AskedFile):
    """A map file."""

    kind: ClassVar[str] = "map"
    application: ClassVar[int] = MAP_APPLICATION
    version: ClassVar[int] = MAP_FORMAT
    schema: ClassVar[list[str]] = tables.MAP_SCHEMA
    rows: ClassVar[dict[str, str]] = {"legs": "values", "arrays": "arrays"}

    @told
    def keep(self, number: int, points: Array, growth: Array, state: Array) -> None:
        """What the chains left at a value: points, shape (turns, series x chains), growth (turns, chains) and the state to go on from."""
        with self._transaction():
            self._insert("legs", number, packed(points), packed(growth), packed(state))

    @told
    def array(self, key: str, values: Array) -> None:
        """Keeps an array beside a leg that is kept after it: without the leg it means nothing."""
        with self._transaction():
            self._insert("arrays", key, packed(values))

    @told
    def stored(self, key: str) -> Array | None:
        """An array; None where it is missing or damaged."""
        row = tables.sound(self._connection, "arrays", key)
        return None if row is None else unpacked(row[1])

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
