"""Fit plans: TOML files that name a model, measured records and the parameters that they have in common."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ModelError, kind_of, shown
from ..model.mechanism import Mechanism
from ..modelfile.jsonschema import DIALECT, class_table
from ..modelfile.read import load, raw_of, text_of
from ..modelfile.tables import Table
from ..schema import Names, Text, described
from ..schema.values import is_list
from ..studies.spec.plan import Amount
from ..studies.spec.study_file import StudyReader
from .fit_task import FitTask, task_of
from .records import BOUNDS, START, FitSettings, Record

RECORD = "record"


@dataclass(frozen=True)
class RecordTable:
    """A table ``[[record]]``: a measured record and what it has of its own."""

    data: str = described(Text(), "file of measured curves, beside the plan")
    name: str = described(Text(), "name in tables; that of its file if left out", "")
    offset: Any = described(Amount(), "where its first sample lies: free, a number or two bounds", None)
    start: str | None = described(*START, None)
    own: dict[str, Any] | None = described(
        BOUNDS, "bounds of numbers of which it has a value of its own, by path", None
    )
    set: dict[str, Any] = described(Names(Amount()), "numbers that are known of it, by path", factory=dict)


@dataclass(frozen=True, kw_only=True)
class FitPlan(FitSettings):
    """The keys at the top of a fit plan."""

    model: str = described(Text(), "model file, beside the plan")
    parameters: dict[str, Any] = described(
        BOUNDS, "parameters to identify, by path: two bounds", factory=dict
    )
    set: dict[str, Any] = described(Names(Amount()), "numbers replaced in the model, by path", factory=dict)
    note: str = described(Text(), "anything worth knowing", "")


def records_of(tables: Any, folder: Path, reader: StudyReader) -> list[Record]:
    """Return the records of a plan, their files relative to a folder; faults are collected in the reader."""
    if not is_list(tables) or not tables:
        message = "there is no record" if tables in (None, []) else f"this is {kind_of(tables)}"
        remedy = 'add one, as in [[record]] with data = "first.csv"'
        reader.refuse((RECORD,), message, "", "a table [[record]] for each record", remedy)
        return []
    records = []
    for k, table in enumerate(tables):
        if not isinstance(table, dict):
            remedy = 'give its file, as in data = "first.csv"'
            reader.refuse((RECORD, k), f"this is {kind_of(table)}", shown(table), "a table", remedy)
            continue
        entry = reader.table((RECORD, k), RecordTable, table)
        records.append(
            Record(folder / str(entry.data), entry.offset, entry.start, entry.own, entry.set, entry.name)
        )
    return records


def plan_schema() -> dict[str, Any]:
    """Return the JSON Schema of fit plans, in what drafts 4 and 7 have in common."""
    schema = class_table(Table(FitPlan), "The file", {})
    record = class_table(Table(RecordTable), "[[record]]", {})
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
        return task_of(mechanism, records, plan.parameters, plan)
    except ModelError as error:
        raise ModelError(error.faults, str(path) if error.file == "fit" else error.file) from None
