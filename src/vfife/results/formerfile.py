"""Run files of versions 0.1 and 0.2: the same tables without seals, the steps in a table of their own."""

from __future__ import annotations

import json
import sqlite3
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from .packing import unpacked
from .space import space
from .tables import damaged

Array = NDArray[np.float64]


def meta(connection: sqlite3.Connection, version: int) -> dict[str, Any]:
    """What is known of the run."""
    found: dict[str, Any] = {key: json.loads(text) for key, text in connection.execute("SELECT key, json FROM meta")}
    if version > 1:
        found |= {key: unpacked(data) for key, data in connection.execute("SELECT key, data FROM arrays")}
    return found


def steps(connection: sqlite3.Connection) -> NDArray[np.int64]:
    """Steps of the outputs."""
    return np.fromiter((step for (step,) in connection.execute("SELECT step FROM steps ORDER BY output")), dtype=np.int64)


def rows(connection: sqlite3.Connection, where: Any) -> Array:
    """Recorded rows. Raises RunFileError where chunks do not follow each other."""
    total, filled = int(connection.execute("SELECT coalesce(sum(outputs), 0) FROM history").fetchone()[0]), 0
    found: Array = np.zeros((0, 0))
    for first, outputs, data in connection.execute("SELECT first, outputs, data FROM history ORDER BY chunk"):
        part = unpacked(data)
        if filled == 0 and part.ndim == 2 and len(part) == outputs:
            found = space(total, part.shape[1])
        if first != filled or part.shape != (outputs, found.shape[1]) or filled + len(part) > total:
            raise RunFileError(damaged(where, f"the outputs from {first} on do not follow those before"))
        found[filled : filled + len(part)] = part
        filled += len(part)
    return found


def companions(connection: sqlite3.Connection, where: Any) -> tuple[dict[str, Any], NDArray[np.int64], Array] | None:
    """What is told of companions, their steps and rows; None without any."""
    if connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'companions'").fetchone() is None:
        return None
    chunks = connection.execute("SELECT first, outputs, told, data FROM companions ORDER BY first").fetchall()
    if not chunks:
        return None
    every, parts = steps(connection), [unpacked(data) for *_, data in chunks]
    taken = [every[first : first + outputs] for first, outputs, *_ in chunks]
    if any(len(one) != len(part) or part.ndim != 2 or part.shape[1] != parts[0].shape[1] for one, part in zip(taken, parts, strict=True)):
        raise RunFileError(damaged(where, "the outputs of the companions do not fit those of the run"))
    return json.loads(chunks[-1][2]), np.concatenate(taken), np.concatenate(parts)


def checkpoint(connection: sqlite3.Connection) -> tuple[int, Array] | None:
    """Step and state of the latest checkpoint."""
    row = connection.execute("SELECT step, state FROM checkpoints ORDER BY step DESC LIMIT 1").fetchone()
    return None if row is None else (int(row[0]), unpacked(row[1]))


def reference(connection: sqlite3.Connection) -> dict[str, bytes]:
    """Parts of the record of the ideal mechanism."""
    return dict(connection.execute("SELECT part, data FROM reference").fetchall())
