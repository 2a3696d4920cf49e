"""Study files: their tables, read and checked against the model before any run, and their JSON Schema."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from ...assembly.assemble import assemble
from ...errors import Fault, ModelError, Path, StepError, VfifeError, article, kind_of, shown, suggestion
from ...measures.catalogue import CASE, COUNTS_KEY, LAST, UNITS, counted_from_start, measures, unit_of
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile import dump, loads
from ...modelfile.jsonschema import DIALECT, class_table
from ...modelfile.read import load, raw_of, text_of
from ...modelfile.tables import Raw, Table
from ...results.run_data import RunData, standing
from ...results.series import REDUCTION
from ...schema import Field, Reader, meaning_of
from ...store.studyfile import SEARCH
from .case_rows import with_cases
from .limits import read_bounds
from .parameters import read_parameters
from .plan import Amount, OneOrMore, Plan, StudySpec, VaryTable

MOST_MODELS = 16  # whose names are cached: a command reads a study file more than once
VARY, POINT = "vary", "point"
METHOD_TABLES = ("allocation", "optimise", "limit", "cost")  # read by the commands that analyse a study
IDENTITY, TITLE = "urn:vfife:study", "Study file of vfife"
Json = dict[str, Any]


class StudyReader(Reader):
    """Reads the tables of a study file."""

    def __init__(self) -> None:
        super().__init__(written=True)

    def missing(self, path: Path, field: Field) -> None:
        """Refuse a table without a key that it needs, with its meaning."""
        self.refuse(path, "this key is missing", "", meaning_of(field), "add it")

    def table(self, path: Path, kind: type, holder: Any, foreign_keys: Sequence[str] = ()) -> Any:
        """Return the object of a table, in part where something of it was refused; ``others`` are keys that
        are read elsewhere.
        """
        fault_count = len(self.faults)
        return self.build(kind, self.values(path, Table(kind).fields, holder, foreign_keys), fault_count)

    def check(self, source: str) -> None:
        """Raise ModelError with the faults, where there are any."""
        if self.faults:
            raise ModelError(self.faults, source)


@dataclass(frozen=True)
class StudyTables:
    """The tables of a study file, or of arguments with the same keys.

    ``source``: what faults call them; ``folder``: that of the model file; ``base``: the model, where Python
    has it; ``name``: of the study, that of the model unless given.
    """

    raw: Raw
    source: str
    folder: FilePath = FilePath()
    base: Mechanism | None = None
    name: str = ""

    @classmethod
    def load(cls, path: str | FilePath) -> StudyTables:
        """Read a study file. Raises ModelError, ValueError for a file that cases are saved in."""
        path = FilePath(path)
        raw = raw_of(text_of(path, "study file"), str(path), "study file")
        return cls(raw, str(path), path.parent, None, path.stem)

    @property
    def model(self) -> Mechanism | None:
        """The model with the numbers of ``[set]``, as far as it can be read; None for one with faults."""
        spec = StudyReader().table((), StudySpec, self.raw, (VARY, POINT, *METHOD_TABLES))
        return base_model(spec, self.folder, self.base, [])

    def plan(self) -> Plan:
        """Return the plan, of the model with the numbers of ``[set]``. Raises ModelError with every fault of
        both.
        """
        reader, base, keys = StudyReader(), self.base, self.raw
        if base is not None:
            keys = {"model": base.source or base.name, **keys}
        spec = reader.table((), StudySpec, keys, (VARY, POINT, *METHOD_TABLES))
        varied = vary_tables(self.raw, reader)
        faults = list[Fault]()
        model = base_model(spec, self.folder, base, faults)
        parameters = read_parameters(varied, model, reader, spec.method == "list")
        if model is not None:
            check_measures(model, spec.measures, reader)
            check_turns(model, spec, reader)
            plan = Plan(self.name or model.name, model, spec, tuple(parameters), raw=dict(self.raw))
            if not reader.faults and not faults:
                check_method_tables(plan, reader)
            if not reader.faults and not faults:
                plan = with_cases(plan, self.raw.get(POINT, []), reader)
        if reader.faults or faults or model is None:
            raise ModelError([*reader.faults, *faults], self.source)
        return plan


def plain_tables(arguments: Mapping[str, Any]) -> Raw:
    """Return arguments as a file has them: arrays as lists, NumPy's numbers as Python's, nothing for None."""

    def plain(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {str(key): plain(part) for key, part in value.items()}
        if hasattr(value, "tolist"):
            return plain(value.tolist())
        return [plain(part) for part in value] if isinstance(value, list | tuple | range) else value

    return {key: plain(value) for key, value in arguments.items() if value is not None}


def vary_tables(raw: Raw, reader: StudyReader) -> dict[str, VaryTable]:
    """Read the tables under ``[vary]`` by name. A list in place of a table has the values of the path that is
    its key; a table without a path whose key is one varies that.
    """
    tables = raw.get(VARY)
    if not isinstance(tables, dict) or not tables:
        message = "nothing is varied" if tables is None or tables == {} else f"this is {kind_of(tables)}"
        remedy = 'add one, as in [vary.clearance] with path = "joint.C.clearance"'
        reader.refuse((VARY, ""), message, "", "a table for each number that varies", remedy)
        return {}
    read = {}
    for name, holder in tables.items():
        if isinstance(holder, list):
            holder = {"path": name, "values": holder}
        elif isinstance(holder, dict) and "path" not in holder and "." in name:
            holder = {"path": name, **holder}
        if not isinstance(holder, dict):
            remedy = (
                'give its path and values, as in path = "joint.C.clearance", values = ["0.1 mm", "0.2 mm"]'
            )
            limit = "a table, or a list of values"
            reader.refuse((VARY, name), f"this is {kind_of(holder)}", shown(holder), limit, remedy)
        elif any(sign in name for sign in "[]/\n") or not name.strip():
            message = "a name with reserved characters"
            reader.refuse((VARY, name, ""), message, shown(name), "a plain name", "choose another name")
        else:
            read[name] = reader.table((VARY, name), VaryTable, holder)
    return read


def base_model(
    spec: StudySpec, folder: FilePath, base: Mechanism | None, faults: list[Fault]
) -> Mechanism | None:
    """Return the model with the numbers of ``[set]``; its faults are added to ``faults``."""
    items = [(path, value) for path, value in (spec.set or {}).items() if value is not None]
    if spec.model is None:
        return None
    try:
        if base is not None:
            return loads(dump(base), items, file=base.source) if items else base
        return load(folder / spec.model, set=items)
    except ModelError as error:
        faults += [fault.at(f"{article('model')} {spec.model}, {fault.where}") for fault in error.faults]
    except (TypeError, ValueError) as error:
        faults.append(Fault("model", f"it cannot be written as a model file: {error}"))
    return None


def search_plan(tables: StudyTables, table: str, example: str) -> tuple[Plan, Mapping[str, str]]:
    """Return the plan of a search, which has no cases of its own, and the units of its measures. Raises
    ModelError.
    """
    reader = StudyReader()
    if not isinstance(tables.raw.get(table), dict):
        reader.refuse(
            (table, ""), "this table is missing", "", "what the search is for", f"add it, as in {example}"
        )
    reader.check(tables.source)
    raw = {**{key: value for key, value in tables.raw.items() if key != "count"}, "method": SEARCH}
    plan = dataclasses.replace(tables, raw=raw).plan()
    return plan, units_of(plan)


class Names(NamedTuple):
    """Names of the measures and of the channels of a model."""

    measures: tuple[str, ...]
    channels: tuple[str, ...]


@lru_cache(MOST_MODELS)
def names_of(text: str) -> Names:
    """Return the names of a model by its text. Raises VfifeError where it cannot be assembled."""
    view = standing(assemble(loads(text)))
    return Names(tuple(measure_names(view)), tuple(view.series))


def measure_names(view: RunData) -> list[str]:
    """Return the measures that a model has at its start, and those that need a turn."""
    names = list(measures(view.record))
    names += [
        f"{name.removesuffix('.max')}.lip"
        for name in names
        if name.endswith((".force.max", ".angular_acceleration.max"))
    ]
    torques = [name.removesuffix(".torque.max") for name in names if name.endswith(".torque.max")]
    names += [f"{name}.torque.{kind}" for name in torques for kind in ("mean", "ripple", "rms")]
    names += [f"{name}.energy_fluctuation" for name in torques]
    return [*names, *(f"{name}.power.mean" for name in torques), "mechanism.efficiency"]


def check_measures(base: Mechanism, names: Sequence[str] | None, reader: Reader) -> None:
    """Refuse names that no measure of the model has, and channels that it does not have."""
    try:
        available, channels = names_of(dump(base))
    except VfifeError as error:
        reader.refuse(("model",), f"it cannot be assembled: {error}", base.name, "", "see vfife check")
        return
    # A measure may be missing at the start, as one of wear is. It may be one of any part, unless others of
    # its kind are there.
    endings = {name.partition(".")[2] for name in available}
    parts = (base.bodies, base.joints, base.drivers, base.springs, base.loads)
    owners = {"ground", "mechanism", *(name for part in parts for name in part)}
    for k, name in enumerate(names or ()):
        if (reduction := REDUCTION.fullmatch(name)) is not None:
            if reduction[2] not in channels:
                remedy = suggestion(reduction[2], channels, "name a channel of the run")
                reader.refuse(("measures", k), "there is no such channel", shown(name), "", remedy)
        elif name not in available:
            owner, _, ending = name.partition(".")
            if owner not in owners or ending not in UNITS or ending in endings:
                remedy = suggestion(name, available, "the names are those of vfife run MODEL.toml --json")
                corners = [c for c in available if c.startswith(owner + ".") and c.endswith("." + ending)]
                remedy = f"it is one of each corner: {', '.join(corners)}" if corners else remedy
                reader.refuse(("measures", k), "there is no such measure", shown(name), "", remedy)
    if names and len(set(names)) < len(names):
        reader.refuse(("measures",), "the same measure twice", "", "each one once", "remove it")


def check_method_tables(plan: Plan, reader: Reader) -> None:
    """Refuse unknown names in the tables of analyses, so that a study does not run before one is refused."""
    raw, units, varied = plan.raw, units_of(plan), [parameter.name for parameter in plan.parameters]
    read_bounds(raw.get("limit", {}), units, reader)
    lists = [(("optimise", key), raw.get("optimise"), units) for key in ("minimise", "maximise")]
    for path, holder, names in [*lists, (("allocation", "measure"), raw.get("allocation"), units)]:
        named = holder.get(path[1]) if isinstance(holder, dict) else None
        for k, name in enumerate([named] if isinstance(named, str) else named or ()):
            if isinstance(name, str) and name not in names:
                place = path if isinstance(named, str) else (*path, k)
                remedy = suggestion(name, names, "name one of the measures")
                reader.refuse(place, "it is not measured", shown(name), "a name of measures", remedy)
    costs = raw.get("cost")
    for name in costs if isinstance(costs, dict) else ():
        if name not in varied:
            remedy = suggestion(name, varied, "name a table of [vary]")
            reader.refuse(("cost", name, ""), "costs of a parameter that is not varied", "", "", remedy)


def units_of(plan: Plan) -> dict[str, str]:
    """Return the units of the measures of a plan, and of channels that are reduced."""
    units = {name: unit_of(name) for name in plan.spec.measures}
    channels = {name: match[2] for name in plan.spec.measures if (match := REDUCTION.fullmatch(name))}
    if channels:
        series = standing(assemble(plan.base)).series
        units |= {name: series.column(channel).unit for name, channel in channels.items()}
    return units


def check_turns(base: Mechanism, spec: StudySpec, reader: Reader) -> None:
    """Refuse a model whose turns cannot be counted, and a step that it cannot have."""
    if base.settings.analysis == "static":
        remedy = 'set "run.analysis" = "dynamic" in [set]'
        reader.refuse(("model",), "a static analysis has no turns", base.name, "a model that moves", remedy)
    elif turn_of(base) is None and spec.duration is None:
        message = "no driver turns a crank at a prescribed speed, so turns cannot be counted"
        remedy = 'give a length in seconds instead, as in duration = "0.5 s"'
        reader.refuse(("model",), message, base.name, "", remedy)
    elif isinstance(spec.step, float):
        try:
            assemble(base, spec.step)
        except StepError as error:
            limit = str(error).partition(": ")[2].partition(";")[0]
            reader.refuse(("step",), "too large for the model", f"{spec.step:g} s", limit, "set it smaller")
        except VfifeError:
            pass  # check_measures has refused the model
    if spec.duration is not None:
        keys = ("settle", spec.settle, None), ("last", spec.last or 1, 1), ("counts", spec.counts, CASE)
        for name, value, default in keys:
            if value != default:
                reader.refuse((name,), "a case with a duration has no turns", str(value), "", "leave it out")
    elif None not in (spec.last, spec.turns) and (spec.last or 1) > spec.turns:
        message = "more turns than a case makes"
        reader.refuse(
            ("last",), message, str(spec.last), f"at most {spec.turns}", "give fewer, or more turns"
        )


def remark_on_last(spec: StudySpec) -> str:
    """Return a sentence on measures of the whole run, which do not depend on ``last``; empty without any."""
    names = counted_from_start(spec.measures, spec.counts) if (spec.last or 1) > 1 else []
    if not names:
        return ""
    message = (
        f"{', '.join(names)} {'is' if len(names) == 1 else 'are'} of the whole run, from its first turn on"
    )
    way = f", but {COUNTS_KEY} does" if counted_from_start(names, LAST) != names else ""
    return f"{message}; last = {spec.last} does not change that{way}."


def study_schema() -> Json:
    """Return the schema, in what drafts 4 and 7 have in common."""
    schema = class_table(Table(StudySpec), "The file", {})
    table = class_table(Table(VaryTable), "[vary.NAME]", {})
    values = {**OneOrMore(Amount()).json(), "description": "the values of the path that the key is"}
    amounts = {"type": "object", "additionalProperties": Amount().json()}
    of_vary = "what is varied, by names of your own, or by path"
    of_point = "cases one by one: a value for each parameter by its name"
    needed = [key for key in table.get("required", ()) if key != "path"]
    by_path = {key: part for key, part in table.items() if key != "required"}
    by_path |= {"required": needed} if needed else {}
    varied = {
        "type": "object",
        "patternProperties": {r"\.": {"anyOf": [by_path, values]}},
        "additionalProperties": {"anyOf": [table, values]},
        "description": of_vary,
    }
    method_table = {"type": "object", "description": "read by the commands that analyse a study"}
    schema["properties"] |= {
        VARY: varied,
        POINT: {"type": "array", "items": amounts, "description": of_point},
        **dict.fromkeys(METHOD_TABLES, method_table),
    }
    schema["required"] = [*schema.get("required", ()), VARY]
    return {"$schema": DIALECT, "$id": IDENTITY, "title": TITLE, **schema}


def schema_text() -> str:
    """Return the schema as text."""
    return json.dumps(study_schema(), indent=1, ensure_ascii=False) + "\n"
