"""One SQLite file of what was asked once and is answered bit by bit: a map, the wear of a mechanism; whole up to the last transaction."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

from ..errors import RunFileError, VfifeError
from . import tables
from .header import head_with
from .opening import connected, new_file, readable
from .tables import told
from .tally import TalliedFile, warn_of_damage


class AskedFile(TalliedFile):
    """Such a file, open for writing (:meth:`create`, :meth:`write`) or reading (:meth:`open`); a context manager that closes it.

    A ``kind`` has an ``application`` and a ``version`` in its header, and its tables, ``schema``.
    """

    application: ClassVar[int]
    version: ClassVar[int]
    schema: ClassVar[list[str]]

    @classmethod
    def create(cls, path: Path, asked: Mapping[str, Any]) -> Self:
        """A new file, which is there whole or not at all; one of this name gives way. Raises StorageError."""
        with new_file(path, cls.kind, cls.application, cls.version, cls.schema) as connection:
            file = cls(path, connection)
            with file._transaction():
                file._insert("meta", cls.kind, json.dumps(asked))
        return cls.write(path)

    @classmethod
    def write(cls, path: Path) -> Self:
        """An existing file, to go on with it."""
        return cls(cls.own(path), connected(path))

    @classmethod
    def open(cls, path: Path) -> Self:
        """An existing file, to be read. Raises RunFileError for any other file."""
        file = cls(cls.own(path), readable(path, cls.kind))
        try:
            file.examine()
        except sqlite3.Error as error:
            file.close()
            raise RunFileError(tables.damaged(path, str(error), cls.kind)) from error
        return file

    @classmethod
    def going_on(cls, path: Path, asked: Mapping[str, Any]) -> Self:
        """A new file, or one that asks the same. Raises VfifeError for one that asks something else."""
        if not path.exists():
            return cls.create(path, asked)
        with cls.open(path) as before:
            warn_of_damage(path, cls.kind, before.damage, "What is gone is computed again now.")
            if before.asked != json.loads(json.dumps(asked)):
                raise VfifeError(f"{path}: there is a {cls.kind} file here that asks something else; name another file, or remove this one")
        return cls.write(path)

    @property
    @told
    def asked(self) -> dict[str, Any]:
        """What is asked. Raises RunFileError where that is damaged."""
        row = tables.sound(self._connection, "meta", self.kind)
        if row is None:
            raise RunFileError(f"{self.path}: what this {self.kind} asks is damaged; make it again")
        found: dict[str, Any] = json.loads(row[1])
        return found

    @classmethod
    def own(cls, path: Path) -> Path:
        """The path of a file of this kind. Raises RunFileError for any other, and for one that a newer version wrote."""
        head = head_with(path, cls.application)
        if head is None and not path.exists():
            raise RunFileError(f"{path}: there is no such file; name a file that vfife {cls.kind} left")
        if head is None:
            raise RunFileError(f"{path}: this is no {cls.kind} file of vfife; name a file that vfife {cls.kind} left")
        if int.from_bytes(head[60:64], "big") > cls.version:
            raise RunFileError(f"{path}: this {cls.kind} file was written by a newer vfife; install that version to read it")
        return path
