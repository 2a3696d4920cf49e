"""Transactions of a file that is written while something runs: each is whole on the disk or not there; several may be gathered into one."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from .tables import told


class Transactions:
    """What a run file and a study file have in common: the connection, and the transaction that gathers; a context manager that closes both."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path, self._connection, self._kept, self._waiting = path, connection, time.monotonic(), False
        self.size = 0  # bytes of the transaction under way

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    @told
    def close(self) -> None:
        """Closes the file; what was gathered goes to the disk first."""
        try:
            if self._waiting:
                self._settle()
        finally:
            self._connection.close()

    @contextmanager
    def _transaction(self, patience: float = 0.0) -> Iterator[None]:
        """A transaction, or more of the one that gathers: it ends unless the last ended less than ``patience`` seconds ago."""
        if not self._waiting:
            self._connection.execute("BEGIN IMMEDIATE")
            self.size = 0
        self._waiting = True
        try:
            yield
            if self._due(patience):
                self._settle()
        except BaseException:
            self._waiting = False
            if self._connection.in_transaction:
                self._connection.rollback()
            raise

    def _due(self, patience: float) -> bool:
        return time.monotonic() - self._kept >= patience

    def _settle(self) -> None:
        """Brings to the disk what was gathered."""
        if self._connection.in_transaction:
            self._connection.commit()
        self._waiting = False
        self._kept = time.monotonic()
