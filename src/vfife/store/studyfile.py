"""Files of studies, maps and wear: cases, values or turns by number, and the outcome of each of them."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError, VfifeError
from .lock import Lock
from .salvage import salvage
from .schemas import MAP, OUTCOMES, STUDY, WEAR, Schema
from .store import Row, Store, present_time

if TYPE_CHECKING:
    from ..studies.engine.outcome import Outcome


Numbers: TypeAlias = Mapping[str, float | str]
AS_TEXT = json.JSONEncoder(ensure_ascii=False).encode
GATHER = 0.25  # s: what a kill may cost beside the cases under way
REPEATS = "repeats"  # entry of the meta that describes the repetition of cases with another step
SEARCH = "search"  # the method of a study whose cases a search asks for
SPECIFICATION = STUDY.kind  # the entry of the meta that has the specification
# Version of the definition of measures, an entry of the specification; files before version 2 have none. In
# version 1 the last turn of a case with a duration was counted from the start; in version 2 it is the last
# 360 degrees before the end, as of a run.
MEASURE_VERSION, MEASURE_VERSION_KEY = 2, "measure_version"
# Entries beside the measures of a case, which have no such names: files without them stay readable.
PERIOD, MEASURED_TURNS, RANGE, CAUTIONS = ":period", ":measured turns", ":range ", ":cautions"


@dataclass(frozen=True)
class StudyCase:
    """A case as a study file has it: its place, the hash of its numbers, and they themselves, by path, in
    SI units.
    """

    number: int
    hash: str
    numbers: dict[str, float | str]


def hash_of(numbers: Numbers) -> str:
    """Return what a case is known by: the numbers of the model that it changes, to the bit, in whatever
    order they come.
    """
    text = AS_TEXT(sorted(numbers.items()))
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def has_former_measures(spec: Mapping[str, Any], outcomes: Mapping[int, Mapping[str, Any]]) -> bool:
    """Return whether cases have measures of version 1 that version 2 defines otherwise: those of complete
    cases with a duration of a turn or more.
    """
    if spec.get(MEASURE_VERSION_KEY, 1) >= MEASURE_VERSION or spec["wanted"].get("duration") is None:
        return False
    return any(outcome["status"] == "complete" and outcome["turns"] for outcome in outcomes.values())


class StudyFile(Store):
    """A study file. A case is known by the hash of its numbers: what is there already is never computed
    again.

    ``damaged_cases`` counts cases that were damaged and are left out; a case whose outcome is lost is
    computed again.
    """

    schema: ClassVar[Schema] = STUDY
    damaged_cases = 0

    @classmethod
    def begin(cls, path: Any, spec: Mapping[str, Any], cases: Sequence[Numbers]) -> StudyFile:
        """Make a new study file with its cases, complete or not at all; it replaces one of this name. Raises
        StorageError.
        """
        return cls.create(
            path,
            {SPECIFICATION: spec, "created": present_time(), "status": "running"},
            lambda file: file._add(cases),
        )

    def record(self, case: StudyCase, outcome: Outcome) -> None:
        """Write the outcome of a case; what comes within a quarter of a second becomes one transaction."""
        self._record("outcomes", case, outcome)

    def begin_repeats(self, spec: Mapping[str, Any]) -> None:
        """Write how cases are repeated with another step; a file that was written before there was a table
        for them gets one.
        """
        with self.transaction():
            self.complete()
            self._put({REPEATS: spec})

    def record_repeat(self, case: StudyCase, outcome: Outcome) -> None:
        """Write the outcome of a case with another step, gathered as :meth:`record` does."""
        self._record("repeats", case, outcome)

    def record_step_trial(self, case: StudyCase, trial: int, outcome: Outcome) -> None:
        """Write the outcome of a case with the step of a ``trial``, gathered as :meth:`record` does."""
        self._record("step_trials", case, outcome, f"{case.number}/{trial}")

    def _record(self, table: str, case: StudyCase, outcome: Outcome, *key: str) -> None:
        step = outcome.step if math.isfinite(outcome.step) else 0.0
        settled = -1 if outcome.settled is None else outcome.settled
        values = outcome.values | {f"{RANGE}{name}": value for name, value in outcome.ranges.items()}
        values = {name: value for name, value in values.items() if math.isfinite(value)}
        if outcome.period is not None:
            values |= {PERIOD: float(outcome.period), MEASURED_TURNS: float(outcome.measured_turns)}
        entries: dict[str, Any] = dict(values)
        if outcome.cautions is not None:
            entries[CAUTIONS] = list(outcome.cautions)
        row = (
            str(outcome.status),
            outcome.reason or "",
            int(outcome.turns),
            int(settled),
            int(outcome.steps),
            float(step),
            entries,
        )
        with self.transaction(GATHER):
            self.insert(table, *key, case.number, case.hash, *row)

    def add(self, cases: Sequence[Numbers], spec: Mapping[str, Any]) -> int:
        """Add those cases that are not there yet, and replace the specification; returns how many were
        added.
        """
        with self.transaction():
            self._put({SPECIFICATION: spec, "status": "running"})
            return self._add(cases)

    def _add(self, cases: Sequence[Numbers]) -> int:
        for number, row in self.read("members"):
            if row is None:  # it is added anew
                self._connection.execute("DELETE FROM members WHERE number = ?", (number,))
        members = dict(self._connection.execute("SELECT hash, number FROM members"))
        # A case that a damaged page lost takes back its number, by which its outcome is known.
        outcome_numbers = dict(
            self._connection.execute(
                "SELECT hash, number FROM outcomes WHERE number NOT IN (SELECT number FROM members)"
            )
        )
        used_numbers = {*members.values(), *outcome_numbers.values()}
        free, first = (number for number in itertools.count() if number not in used_numbers), len(members)
        for numbers in cases:
            if (name := hash_of(numbers)) not in members:
                members[name] = outcome_numbers[name] if name in outcome_numbers else next(free)
                self.insert("members", members[name], name, dict(numbers))
        return len(members) - first

    def finish(self, status: str) -> None:
        """Write how the study ended ("complete", "interrupted")."""
        with self.transaction():
            self._put({"status": status, "finished": present_time()})

    def cases(self) -> list[StudyCase]:
        """Return the cases in the order in which they were planned; those that are damaged are left out,
        and counted.
        """
        with self.reported():
            rows = [row for _, row in self.read("members")]
            self.damaged_cases = rows.count(None)
            return [
                StudyCase(row.values[0], row.values[1], json.loads(row.values[2]))
                for row in rows
                if row is not None
            ]

    def outcomes(self, table: str = "outcomes") -> dict[int, dict[str, Any]]:
        """Return the outcomes of cases by their places: status, reason, turns, settled, steps, step,
        measures, and of their last turns period, measured_turns (None if unknown) and ranges;
        and cautions, None of those that were not examined.

        ``table``: "repeats" of those with another step; none in a file that was written before there were
        any.
        """
        with self.reported():
            return {int(number): _outcome(row.values) for number, row in self.read(table) if row is not None}

    def repeats(self) -> dict[int, dict[str, Any]]:
        """Return the outcomes of cases of the sample with another step."""
        return self.outcomes("repeats")

    def step_trials(self) -> dict[int, dict[int, dict[str, Any]]]:
        """Return the outcomes of sensitive cases of the sample with more steps, by case and trial."""
        repeats: dict[int, dict[int, dict[str, Any]]] = {}
        with self.reported():
            for key, row in self.read("step_trials"):
                if row is not None:
                    number, trial = map(int, key.split("/"))
                    repeats.setdefault(number, {})[trial] = _outcome(row.values[1:])
        return repeats


def _outcome(values: Sequence[Any]) -> dict[str, Any]:
    """Return the outcome in the columns of a row."""
    outcome = dict(zip(OUTCOMES, values, strict=True))
    entries = json.loads(outcome["measures"])
    period, measured_turns = (entries.pop(key, None) for key in (PERIOD, MEASURED_TURNS))
    cautions = entries.pop(CAUTIONS, None)
    ranges = {name: entries.pop(name) for name in list(entries) if name.startswith(RANGE)}
    return outcome | {
        "measures": entries,
        "settled": None if outcome["settled"] < 0 else outcome["settled"],
        "period": None if period is None else int(period),
        "measured_turns": None if measured_turns is None else int(measured_turns),
        "ranges": {name.removeprefix(RANGE): value for name, value in ranges.items()},
        "cautions": None if cautions is None else tuple(cautions),
    }


Array = NDArray[np.float64]

Kind = TypeVar("Kind", bound=Store)


@contextmanager
def locked_file(
    kind: type[Kind], file: str | Path | None, spec: Mapping[str, Any], content: str, replace: bool = False
) -> Iterator[Kind | None]:
    """Open the file of a specification, new or to be continued, and hold its lock; None without ``file``.

    Of a file whose pages do not fit together, the intact rows go into a new one. ``content`` names its
    content; ``replace`` begins a new file.

    Raises VfifeError if it has another specification, HeldError if another process writes it.
    """
    if file is None:
        yield None
        return
    path = Path(file)
    with Lock(path.absolute().parent, f"{path.name}.lock", content):
        if path.exists() and not replace:
            salvage(kind, path)
        opened = kind.create(path, {kind.schema.kind: spec}) if replace else kind.resume(path, spec)
        with opened as stored:
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


def stored_cases(file: str | Path | None) -> int:
    """Return the number of cases in a map file; 0 without a readable file."""
    if file is None or not Path(file).exists():
        return 0
    try:
        with MapFile.open(Path(file)) as store:
            return len(store.keys("legs"))
    except VfifeError:  # reported when the map is continued
        return 0
