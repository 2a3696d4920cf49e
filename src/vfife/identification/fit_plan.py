"""Fit plans: TOML files that name a model, measured records and what is looked for in all of them."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from ..errors import Fault, ModelError, kind_of, shown
from ..model.mechanism import Mechanism
from ..modelfile.jsonschema import DIALECT, noun_table
from ..modelfile.read import load, raw_of, text_of
from ..modelfile.tables import Table
from ..schema import Choice, Integer, Measure, Text, Value, described
from ..schema.parts import Names
from ..schema.values import is_list
from ..studies.spec.plan import Amount
from ..studies.spec.study_file import StudyReader
from .descents import MOST_RESTARTS, Derivatives
from .fit_task import MOST_SEARCHES, MOST_SKIPPED, FitTask, plan_fit
from .records import Record, Start
from .residuals import Comparison

LARGEST_COUNT = 1_000_000
RECORD = "record"
OWN_KEYS = ("model", "set", "parameters", "note")  # that are no keywords of a fit


@dataclass(frozen=True)
class Bounds(Value):
    """Two bounds: a text as in "0.1..1 mm", or a list of two."""

    def take(self, value: Any, written: bool) -> Any:
        """Return the bounds unread; the path that they are of decides on their dimension."""
        if isinstance(value, str) or (is_list(value) and len(value) == 2):
            return value
        remedy = 'write them as in "0.1..1 mm" or ["0.1 mm", "1 mm"]'
        raise Fault("", f"this is {kind_of(value)}", shown(value), "two bounds", remedy)

    def json(self) -> dict[str, Any]:
        """Return the JSON Schema of bounds: a text, or a list of two."""
        return {"anyOf": [{"type": "string"}, {"type": "array", "minItems": 2, "maxItems": 2}]}


BOUNDS = Names(Bounds())


@dataclass(frozen=True)
class RecordTable:
    """A table ``[[record]]``: a measured record and what it has of its own."""

    data: str = described(Text(), "file of measured curves, beside the plan")
    name: str = described(Text(), "name in tables; that of its file if left out", "")
    offset: Any = described(Amount(), "where its first sample lies: free, a number or two bounds", None)
    start: str | None = described(
        Choice(get_args(Start)), "data: angles and speeds near the first samples are identified", None
    )
    own: dict[str, Any] | None = described(
        BOUNDS, "bounds of numbers of which it has a value of its own, by path", None
    )
    set: dict[str, Any] = described(Names(Amount()), "numbers that are known of it, by path", factory=dict)


@dataclass(frozen=True)
class FitPlan:
    """The keys at the top of a fit plan."""

    model: str = described(Text(), "model file, beside the plan")
    parameters: dict[str, Any] = described(
        BOUNDS, "parameters to identify, by path: two bounds", factory=dict
    )
    set: dict[str, Any] = described(Names(Amount()), "numbers replaced in the model, by path", factory=dict)
    own: dict[str, Any] | None = described(
        BOUNDS, "bounds of numbers of which each record has a value of its own", None
    )
    columns: dict[str, Any] | None = described(Names(Text()), "channels by names of columns", None)
    weights: dict[str, Any] | None = described(
        Names(Measure("1", above=0.0)), "weights by names of columns", None
    )
    start: str = described(
        Choice(get_args(Start)), "data: angles and speeds near the first samples are identified", "model"
    )
    offset: Any = described(Amount(), "where first samples lie: free, a number or two bounds", None)
    skip: float = described(
        Measure("1", low=0.0, high=MOST_SKIPPED), "turns before data may begin, where the offset is free", 3.0
    )
    compare: str = described(Choice(get_args(Comparison)), "what of the curves is compared", "curve")
    width: Any = described(Amount(), "window of an envelope", None)
    step: Any = described(Measure("s", above=0.0, words=("auto",)), "time step of every run", "auto")
    every: int = described(Integer(1, LARGEST_COUNT), "every so many samples of each record count", 1)
    screened: int = described(Integer(1, LARGEST_COUNT), "points that are tried first", 64)
    starts: int = described(Integer(1, LARGEST_COUNT), "the best of them, from which searches begin", 4)
    restarts: int = described(Integer(0, MOST_SEARCHES), "times that searches begin again", MOST_RESTARTS)
    derivatives: str = described(Choice(get_args(Derivatives)), "where derivatives come from", "auto")
    seed: int = described(Integer(0, 2**31 - 1), "seed of the points", 0)
    note: str = described(Text(), "anything worth knowing", "")

    @property
    def options(self) -> dict[str, Any]:
        """Keywords of :func:`fit`."""
        names = (one.name for one in dataclasses.fields(self) if one.name not in OWN_KEYS)
        return {name: getattr(self, name) for name in names}


def records_of(tables: Any, folder: Path, reader: StudyReader) -> list[Record]:
    """Return the records of a plan, their files relative to a folder; faults are collected in the reader."""
    if not is_list(tables) or not tables:
        what = "there is no record" if tables in (None, []) else f"this is {kind_of(tables)}"
        remedy = 'add one, as in [[record]] with data = "first.csv"'
        reader.refuse((RECORD,), what, "", "a table [[record]] for each record", remedy)
        return []
    records = []
    for k, table in enumerate(tables):
        if not isinstance(table, dict):
            remedy = 'give its file, as in data = "first.csv"'
            reader.refuse((RECORD, k), f"this is {kind_of(table)}", shown(table), "a table", remedy)
            continue
        one = reader.table((RECORD, k), RecordTable, table)
        records.append(Record(folder / str(one.data), one.offset, one.start, one.own, one.set, one.name))
    return records


def plan_schema() -> dict[str, Any]:
    """Return the JSON Schema of fit plans, in what drafts 4 and 7 have in common."""
    schema = noun_table(Table(FitPlan), "The file", {})
    record = noun_table(Table(RecordTable), "[[record]]", {})
    schema["properties"][RECORD] = {"type": "array", "items": record, "minItems": 1}
    schema["required"] = [*schema.get("required", ()), RECORD]
    return {"$schema": DIALECT, "$id": "urn:vfife:fit", "title": "Fit plan of vfife", **schema}


def schema_text() -> str:
    """Return the schema as text."""
    return json.dumps(plan_schema(), indent=1, ensure_ascii=False) + "\n"


def is_plan(path: Path) -> bool:
    """Whether a file is a fit plan: TOML with records."""
    try:
        return path.suffix.lower() == ".toml" and RECORD in raw_of(text_of(path, "fit plan"), str(path))
    except ModelError:
        return False


def load_plan(path: str | Path) -> FitTask:
    """Read a fit plan without starting the fit. Raises ModelError with all faults.

    path: file of the plan (TOML)

    Returns a task whose ``run`` identifies the parameters.
    """
    path = Path(path)
    reader, raw = StudyReader(), raw_of(text_of(path, "fit plan"), str(path), "fit plan")
    plan = reader.table((), FitPlan, {key: value for key, value in raw.items() if key != RECORD})
    records = records_of(raw.get(RECORD), path.parent, reader)
    reader.check(str(path))
    mechanism: Mechanism = load(path.parent / plan.model, set=list(plan.set.items()))
    try:
        return plan_fit(mechanism, records, plan.parameters, **plan.options)
    except ModelError as error:
        raise ModelError(error.faults, str(path) if error.file == "fit" else error.file) from None
