"""One SQLite file a study: what is asked, its members by their numbers, and what each of them came to; whole up to the last transaction.

Rows are sealed as those of a run file are, and SQLite keeps its rollback journal, so that a study is one file that is read while it grows. A
member is known by the hash of its numbers: what is there already is never computed again.
"""

from __future__ import annotations

import hashlib
import json
import math
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from ..errors import RunFileError, StorageError
from . import tables
from .header import STUDY_APPLICATION, STUDY_FORMAT, study_head
from .member_errors import REPEATS
from .opening import connected, new_file, readable
from .tables import told, unwritten
from .tally import TalliedFile

if TYPE_CHECKING:
    from ..study.engine import Outcome

Numbers: TypeAlias = Mapping[str, float | str]
AS_TEXT = json.JSONEncoder(ensure_ascii=False).encode
GATHER = 0.25  # s: what a kill may cost beside the members under way
WHAT = "study"  # the entry of the meta that says what is asked


@dataclass(frozen=True)
class Kept:
    """A member as a study file has it: its place, the hash of its numbers, and they themselves, by path, in SI units."""

    number: int
    hash: str
    numbers: dict[str, float | str]


def hash_of(numbers: Numbers) -> str:
    """What a member is known by: the numbers of the model that it changes, to the bit, in whatever order they come."""
    text = AS_TEXT(sorted(numbers.items()))
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


class StudyFile(TalliedFile):
    """A study file, open for writing (:meth:`create`, :meth:`write`) or reading (:meth:`open`); a context manager that closes it.

    ``lost`` counts rows that were damaged and are left out; a member whose outcome is lost is computed again.
    """

    kind: ClassVar[str] = "study"
    rows: ClassVar[dict[str, str]] = {"members": "members", "outcomes": "outcomes", "repeats": "repetitions"}

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        super().__init__(path, connection)
        self.lost = 0

    @classmethod
    def create(cls, path: Path, asked: Mapping[str, Any], members: Sequence[Numbers]) -> StudyFile:
        """A new study file, which is there whole or not at all; one of this name gives way. Raises StorageError."""
        with new_file(path, cls.kind, STUDY_APPLICATION, STUDY_FORMAT, tables.STUDY_SCHEMA) as connection:
            file = cls(path, connection)
            with file._transaction():
                file._put({WHAT: asked, "created": tables.now(), "status": "running"})
                file._add(members)
        return cls.write(path)

    @classmethod
    def open(cls, path: str | Path) -> StudyFile:
        """A study file for reading; also one whose writer was killed or is still at work."""
        path = study_file_at(Path(path))
        return cls(path, readable(path, cls.kind))

    @classmethod
    def write(cls, path: str | Path) -> StudyFile:
        """A study file that is there, to go on with."""
        path = study_file_at(Path(path))
        try:
            return cls(path, connected(path))
        except sqlite3.Error as error:
            raise StorageError(unwritten(str(path), str(error))) from error

    # ------------------------------------------------------------------------------------------------------- writing

    @told
    def record(self, member: Kept, outcome: Outcome) -> None:
        """Keeps what a member came to; what comes within a quarter of a second becomes one transaction."""
        self._record("outcomes", member, outcome)

    @told
    def begin_repeats(self, said: Mapping[str, Any]) -> None:
        """Says how members are repeated with another step; a file that was written before there was a table for them gets one."""
        with self._transaction():
            for statement in tables.STUDY_SCHEMA:
                self._connection.execute(statement)
            self._put({REPEATS: said})

    @told
    def record_repeat(self, member: Kept, outcome: Outcome) -> None:
        """Keeps what a member came to with another step, gathered as :meth:`record` does."""
        self._record("repeats", member, outcome)

    def _record(self, table: str, member: Kept, outcome: Outcome) -> None:
        step = outcome.step if math.isfinite(outcome.step) else 0.0
        settled = -1 if outcome.settled is None else outcome.settled
        values = json.dumps({name: value for name, value in outcome.values.items() if math.isfinite(value)})
        row = (str(outcome.status), outcome.reason or "", int(outcome.turns), int(settled), int(outcome.steps), float(step), values)
        with self._transaction(GATHER):
            self._insert(table, member.number, member.hash, *row)

    @told
    def add(self, members: Sequence[Numbers], asked: Mapping[str, Any]) -> int:
        """Adds those members that are not there yet, and says anew what is asked; returns how many they are."""
        with self._transaction():
            self._put({WHAT: asked, "status": "running"})
            return self._add(members)

    @told
    def flush(self) -> None:
        """Brings to the disk what was gathered."""
        self._settle()

    @told
    def finish(self, status: str) -> None:
        """Says how the study ended ("complete", "interrupted")."""
        with self._transaction():
            self._put({"status": status, "finished": tables.now()})

    def _put(self, meta: Mapping[str, Any]) -> None:
        for key, value in meta.items():
            self._insert("meta", key, json.dumps(value))

    def _add(self, members: Sequence[Numbers]) -> int:
        self._remove_damaged()
        known = {name for (name,) in self._connection.execute("SELECT hash FROM members")}
        number = 1 + int(self._connection.execute("SELECT coalesce(max(number), -1) FROM members").fetchone()[0])
        first = number
        for numbers in members:
            if (name := hash_of(numbers)) not in known:
                known.add(name)
                self._insert("members", number, name, json.dumps(dict(numbers)))
                number += 1
        return number - first

    def _remove_damaged(self) -> None:
        """Remove members whose rows are damaged, so that they are added anew."""
        for number, row in tables.rows(self._connection, "members"):
            if row is None:
                self._connection.execute("DELETE FROM members WHERE number = ?", (number,))

    # ------------------------------------------------------------------------------------------------------- reading

    @property
    @told
    def meta(self) -> dict[str, Any]:
        """What is known of the study. Raises RunFileError where that is damaged."""
        found = {key: json.loads(row[1]) for key, row in tables.each(self._connection, "meta") if row is not None}
        if WHAT not in found:
            raise RunFileError(tables.damaged(self, "nothing is left of what it asks"))
        return found

    @told
    def members(self) -> list[Kept]:
        """The members in the order in which they were planned; those that are damaged are left out, and counted."""
        self.lost = 0
        return self._members()

    def _members(self) -> list[Kept]:
        found = []
        for _, row in tables.rows(self._connection, "members"):
            if row is None:
                self.lost += 1
            else:
                found.append(Kept(row[0], row[1], json.loads(row[2])))
        return found

    @told
    def outcomes(self) -> dict[int, dict[str, Any]]:
        """What members came to, by their places: status, reason, turns, settled, steps, step and measures."""
        return self._outcomes("outcomes")

    @told
    def repeats(self) -> dict[int, dict[str, Any]]:
        """What members of the sample came to with another step; none in a file that was written before there were any."""
        return self._outcomes("repeats")  # a table that is missing has no rows

    def _outcomes(self, table: str) -> dict[int, dict[str, Any]]:
        names = [column.split()[0] for column in tables.STUDY["outcomes"]]
        found = {}
        for number, row in tables.rows(self._connection, table):
            if row is not None:
                one = dict(zip(names, row, strict=True))
                one |= {"measures": json.loads(one["measures"]), "settled": None if one["settled"] < 0 else one["settled"]}
                found[int(number)] = one
        return found

    @told
    def counts(self) -> tuple[int, int]:
        """Members that are planned, and those that ended."""
        planned, ended = (self._connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in ("members", "outcomes"))
        return int(planned), int(ended)


def study_file_at(path: Path) -> Path:
    """The study file that a path means. Raises RunFileError where there is none that this version reads."""
    if not path.is_file():
        raise RunFileError(f"{path}: there is no study file of this name; `vfife study STUDY.toml` makes one")
    head = study_head(path)
    if head is None:
        raise RunFileError(f"{path}: this is no study file of vfife; `vfife study STUDY.toml` makes one")
    if int.from_bytes(head[60:64], "big") > STUDY_FORMAT:
        raise RunFileError(f"{path}: this study file was written by a newer vfife; install that version to read it")
    return path
