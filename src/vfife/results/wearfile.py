"""One SQLite file of how a mechanism wears: what is asked, and each number of turns at which its surfaces are known."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from . import tables
from .askedfile import AskedFile
from .header import WEAR_APPLICATION, WEAR_FORMAT
from .packing import packed, unpacked
from .tables import told

Array = NDArray[np.float64]


class WornPoint(NamedTuple):
    """Surfaces after so many turns: ``depth`` (m) and its ``rate`` (m a turn) around them, shape (surfaces, places); what else is ``told``."""

    depth: Array
    rate: Array
    told: dict[str, Any]


class WearFile(AskedFile):
    """A wear file."""

    kind: ClassVar[str] = "wear"
    application: ClassVar[int] = WEAR_APPLICATION
    version: ClassVar[int] = WEAR_FORMAT
    schema: ClassVar[list[str]] = tables.WEAR_SCHEMA
    rows: ClassVar[dict[str, str]] = {"points": "points"}

    @told
    def keep(self, number: int, point: WornPoint, state: Array) -> None:
        """A point, and the state to go on from."""
        with self._transaction():
            self._insert("points", number, json.dumps(point.told), packed(point.depth), packed(point.rate), packed(state))

    @told
    def points(self) -> list[WornPoint]:
        """All points from the first on, up to one that is missing or damaged."""
        found: list[WornPoint] = []
        while (row := tables.sound(self._connection, "points", len(found))) is not None:
            found.append(WornPoint(unpacked(row[2]), unpacked(row[3]), json.loads(row[1])))
        return found

    @told
    def keep_beside(self, apart: Sequence[float]) -> None:
        """How far the companion of the last block is apart from it."""
        with self._transaction():
            self._insert("meta", "beside", json.dumps(list(apart)))

    @property
    @told
    def beside(self) -> tuple[float, ...]:
        """The same; empty where there was none."""
        row = tables.sound(self._connection, "meta", "beside")
        return () if row is None else tuple(json.loads(row[1]))

    @told
    def state(self, number: int) -> Array:
        """The state after a point, shape (rows,)."""
        row = tables.sound(self._connection, "points", number)
        if row is None:
            raise RunFileError(f"{self.path}: the state after point {number} is damaged; make the wear again")
        return unpacked(row[4])
