"""Files of maps and of wear: a row for each value, piece, start or number of turns, with the state from which
the next one continues.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from .lock import Lock
from .schemas import MAP, WEAR, Schema
from .store import Row, Store

Array = NDArray[np.float64]

Kind = TypeVar("Kind", bound=Store)


@contextmanager
def locked_file(
    kind: type[Kind], file: str | Path | None, spec: Mapping[str, Any], what: str
) -> Iterator[Kind | None]:
    """Open the file of a specification, new or to be continued, and hold its lock; None without ``file``.

    Raises VfifeError if it has another specification, HeldError if another process writes it; ``what`` names
    its content.
    """
    if file is None:
        yield None
        return
    path = Path(file)
    with Lock(path.absolute().parent, f"{path.name}.lock", what), kind.resume(path, spec) as stored:
        yield stored


class MapFile(Store):
    """A file of a bifurcation diagram, a section, basins or a waterfall."""

    schema: ClassVar[Schema] = MAP

    def legs(self, gaps: bool) -> dict[int, tuple[Array, Array]]:
        """Return the points, shape (turns, series x chains), and growth, shape (turns, chains), by number;
        with ``gaps`` also those after a missing one.
        """
        rows: Any = (
            (row for _, row in self.read("legs") if row is not None) if gaps else self.sequence("legs")
        )
        return {row["number"]: (row["points"], row["growth"]) for row in rows}

    def array(self, key: str) -> Array | None:
        """Return an array that was written before the legs and without which they are meaningless; None if it
        is missing or damaged.
        """
        array: Array | None = self.get("arrays", key, "data")
        return array

    def state(self, number: int) -> Array:
        """Return the state after a leg, shape (rows, chains)."""
        return _state(self, "legs", number, f"value {number}")


class WearPoint(NamedTuple):
    """Surfaces after ``numbers["turns"]`` turns: ``depth`` (m) and its ``rate`` (m a turn) around them, shape
    (surfaces, places).
    """

    depth: Array
    rate: Array
    numbers: dict[str, Any]


class WearFile(Store):
    """A file of how a mechanism wears."""

    schema: ClassVar[Schema] = WEAR

    def points(self) -> list[WearPoint]:
        """Return all points from the first on, up to one that is missing or damaged."""
        return [WearPoint(row["depth"], row["rate"], row["told"]) for row in self.sequence("points")]

    @property
    def companion_difference(self) -> tuple[float, ...]:
        """Difference of the last block from its companion; empty before it was computed."""
        return tuple(self.get("meta", "beside", "json") or ())

    def state(self, number: int) -> Array:
        """Return the state after a point, shape (rows,)."""
        return _state(self, "points", number, f"point {number}")


def _state(file: Store, table: str, number: int, name: str) -> Array:
    row: Row | None = file.row(table, number)
    if row is None:
        raise RunFileError(
            f"{file.path}: the state after {name} is damaged; make the {file.schema.kind} again"
        )
    state: Array = row["state"]
    return state
