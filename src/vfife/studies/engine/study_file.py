"""Study files: the tables of a study read and checked against the model before anything is run, the values of
all cases, the JSON Schema.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from ...assembly.assemble import assemble
from ...errors import Fault, ModelError, Path, StepError, VfifeError, article, kind_of, shown, suggestion
from ...measures.catalogue import of_whole_runs
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile import dump, loads
from ...modelfile.jsonschema import DIALECT, noun_table
from ...modelfile.read import load, raw_of, text_of
from ...modelfile.tables import Raw, Table
from ...results.series import REDUCTION
from ...results.studied import UNITS
from ...results.view import View, standing
from ...schema import Field, Measure, Reading, Whole, meaning_of
from ..spec.plan import GRIDS, MOST_MEMBERS, SEARCH, Amount, Asked, Number, Parameter, Plan, Several, Varied
from ..spec.sampling import points as sampled
from ..spec.varied import number, parameters
from .cases import Wanted

MOST_MODELS = 16  # whose names are kept: a command reads a study file more than once


class Names(NamedTuple):
    """What may be wanted of a model."""

    measures: tuple[str, ...]
    series: tuple[str, ...]


NAMES: OrderedDict[str, Names] = OrderedDict()


def names_of(base: Mechanism) -> Names:
    """Names of the measures and of the channels of a model. Raises VfifeError where it cannot be assembled."""
    text = dump(base)
    found = NAMES.get(text)
    if found is None:
        view = standing(assemble(base))
        found = NAMES[text] = Names(tuple(known_measures(view)), tuple(view.series))
        if len(NAMES) > MOST_MODELS:
            NAMES.popitem(last=False)
    return found


def wanted_of(asked: Asked) -> Wanted:
    """What the engine is asked for."""
    step = None if asked.step == "auto" else float(asked.step)
    return Wanted(tuple(asked.measures), asked.turns, asked.settle, asked.last, step)


def beside_last(asked: Asked) -> str:
    """What of the measures does not heed the ``last`` turns asked for, in a sentence; empty where nothing is."""
    names = of_whole_runs(asked.measures) if asked.last > 1 else []
    if not names:
        return ""
    of = "is of the whole run" if len(names) == 1 else "are of the whole run"
    return f"{', '.join(names)} {of}, from its first turn on; last = {asked.last} does not change that."


def check_measures(base: Mechanism, names: Sequence[str] | None, by: Reading) -> None:
    """Tells names that no measure of the model has, and channels that it does not have."""
    try:
        known, series = names_of(base)
    except VfifeError as error:
        by.refuse(("model",), f"it cannot be assembled: {error}", base.name, "", "see vfife check")
        return
    endings = {
        name.partition(".")[2] for name in known
    }  # what is there from the start, where it is at all; others begin later
    owners = {
        name for part in (base.bodies, base.joints, base.drivers, base.springs, base.loads) for name in part
    } | {"ground", "mechanism"}
    for k, name in enumerate(names or ()):
        reduced = REDUCTION.fullmatch(name)
        if reduced is not None:
            if reduced[2] not in series:
                remedy = suggestion(reduced[2], series, "name a channel of the run")
                by.refuse(("measures", k), "there is no such channel", shown(name), "", remedy)
        elif name not in known:
            owner, _, ending = name.partition(".")
            if owner not in owners or ending not in UNITS or ending in endings:
                remedy = suggestion(name, known, "the names are those of vfife run MODEL.toml --json")
                by.refuse(("measures", k), "there is no such measure", shown(name), "", remedy)
    if names and len(set(names)) < len(names):
        by.refuse(("measures",), "the same measure twice", "", "each one once", "remove it")


def known_measures(view: View) -> list[str]:
    """Names of measures that the model has at its start, and those that need a turn."""
    from ...measures.catalogue import measures

    found = list(measures(view.record))
    found += [
        f"{name.removesuffix('.max')}.lip"
        for name in found
        if name.endswith((".force.max", ".angular_acceleration.max"))
    ]
    found += [
        f"{name.removesuffix('.max')}.{kind}"
        for name in found
        if name.endswith(".torque.max")
        for kind in ("mean", "ripple")
    ]
    found += [name.replace(".torque.max", ".power.mean") for name in found if name.endswith(".torque.max")]
    return [*found, "mechanism.efficiency"]


def check_turns(base: Mechanism, asked: Asked, by: Reading) -> None:
    """Tells what keeps members from being counted in turns."""
    if base.settings.analysis == "static":
        by.refuse(
            ("model",),
            "a static analysis has no turns",
            base.name,
            "a model that moves",
            'set "run.analysis" = "dynamic" in [set]',
        )
    elif turn_of(base) is None:
        by.refuse(
            ("model",), "no driver turns a crank, so turns cannot be counted", base.name, "", "drive a body"
        )
    elif isinstance(asked.step, float):
        try:
            assemble(base, asked.step)
        except StepError as error:
            by.refuse(
                ("step",),
                "too large for the model",
                f"{asked.step:g} s",
                str(error).partition(": ")[2].partition(";")[0],
                "set it smaller",
            )
        except VfifeError:
            pass  # told by its measures
    if None not in (asked.last, asked.turns) and asked.last > asked.turns:
        by.refuse(
            ("last",),
            "more turns than a member makes",
            str(asked.last),
            f"at most {asked.turns}",
            "give fewer, or more turns",
        )


def spread(plan: Plan, extra: Any, by: Reading) -> Plan:
    """The plan with its members, ``extra`` ones among them as tables of values by name; what is wrong is
    told.
    """
    listed = tuple(single(plan, one, k, by) for k, one in enumerate(extra)) if isinstance(extra, list) else ()
    if not isinstance(extra, list):
        by.refuse(("point",), f"this is {kind_of(extra)}", shown(extra), "tables [[point]]", "write them so")
    points = tuple(one for one in listed if one is not None)
    members = planned(plan, by)
    every = tuple(dict.fromkeys((*members, *points))) if members is not None else ()
    return dataclasses.replace(plan, points=points, members=every)


def planned(plan: Plan, by: Reading) -> list[tuple[Number, ...]] | None:
    """Values of every member, in the order of the parameters; None where there cannot be any."""
    method, count = plan.asked.method, plan.asked.count
    free = [one for one in plan.parameters if one.values is None]
    if method == SEARCH:
        return []
    if method in GRIDS:
        for one in free:
            what = f"a {method} takes values, and {one.name} has {article_of(one)}"
            remedy = 'list its values, give from, to and count, or take samples: method = "sobol" and count'
            by.refuse(("vary", one.name, ""), what, "", "", remedy)
        if count is not None:
            by.refuse(
                ("count",),
                f"a {method} takes no samples",
                str(count),
                "",
                "remove it, or name another method",
            )
        if free or count is not None:
            return None
        return rows_of_lists(plan, by) if method == "list" else grid(plan, None, by)
    if not free:
        remedy = 'give a number from and to, or mean and deviation, or set method = "grid"'
        by.refuse(
            ("method",),
            "there is nothing to take samples of: every parameter has values",
            f'"{method}"',
            "",
            remedy,
        )
    if count is None:
        by.refuse(
            ("count",), "this key is missing", "", "how many samples are taken", "add it, as in count = 256"
        )
    if not free or count is None or too_many(plan, count, by):
        return None
    try:
        drawn = sampled([one.distribution for one in free], method, count, plan.asked.seed)
    except Fault as refused:
        by.add(refused.at(("method",)))
        return None
    columns = [fitting(one, drawn[:, k], by) for k, one in enumerate(free)]
    return grid(plan, list(zip(*columns, strict=True)), by) if all(columns) else None


def article_of(one: Parameter) -> str:
    """What a parameter without values has."""
    return (
        "a range"
        if one.kind == "uniform"
        else f"a {one.kind} distribution"
        if one.kind != "fit"
        else f"the fit {one.words}"
    )


def too_many(plan: Plan, samples: int, by: Reading) -> bool:
    """Whether there are more members than anybody means, counted before any is made."""
    sizes = [len(one.values) for one in plan.parameters if one.values is not None] + (
        [samples] if samples > 1 else []
    )
    count = math.prod(sizes)
    if count <= MOST_MEMBERS:
        return False
    counted = " x ".join(f"{size:,}" for size in sizes)
    by.refuse(
        ("vary", ""),
        f"{counted} = {count:,} members",
        "",
        f"at most {MOST_MEMBERS:,}",
        "give fewer values, or take samples",
    )
    return True


def grid(
    plan: Plan, samples: list[tuple[Number, ...]] | None, by: Reading
) -> list[tuple[Number, ...]] | None:
    """Every value with every other, and with every sample of what has none."""
    if too_many(plan, len(samples or ()), by):
        return None
    axes = [one.values for one in plan.parameters if one.values is not None]
    found = []
    for values in itertools.product(*axes):
        for sample in samples or [()]:
            given, drawn = iter(values), iter(sample)
            found.append(tuple(next(given if one.values is not None else drawn) for one in plan.parameters))
    return found


def rows_of_lists(plan: Plan, by: Reading) -> list[tuple[Number, ...]] | None:
    """First with first, second with second."""
    lists = [one.values or () for one in plan.parameters]
    if len({len(one) for one in lists}) > 1:
        sizes = ", ".join(
            f"{one.name} {len(values)}" for one, values in zip(plan.parameters, lists, strict=True)
        )
        by.refuse(
            ("vary", ""),
            "lists that go together are of different lengths",
            sizes,
            "one length",
            'complete them, or set method = "grid"',
        )
        return None
    return list(zip(*lists, strict=True))


def fitting(one: Parameter, values: Any, by: Reading) -> list[Number]:
    """Samples of a parameter as the model takes them; none, and a fault, where some lie beyond the limits of
    the field.
    """
    found = [float(round(value)) if isinstance(one.held, Whole) else float(value) for value in values]
    limits = one.held
    bad = [value for value in found if isinstance(limits, Measure) and not limits.allows(value)]
    if isinstance(limits, Whole):
        bad = [value for value in found if not limits.low <= value <= limits.high]
    if bad:
        said = limits.limits() if isinstance(limits, Measure) else f"{limits.low} to {limits.high}"
        what = f"{len(bad)} of {len(found)} samples are beyond the limits of {one.paths[0]}"
        by.refuse(
            ("vary", one.name, ""),
            what,
            f"{bad[0]:.6g} {one.unit}",
            said,
            "cut the distribution off with from and to",
        )
    return [] if bad else list(found)


def single(plan: Plan, one: Any, k: int, by: Reading) -> tuple[Number, ...] | None:
    """A member given by itself: a value for each parameter."""
    if not isinstance(one, dict):
        by.refuse(
            ("point", k), f"this is {kind_of(one)}", shown(one), "a table of values by name", "write one"
        )
        return None
    names = [parameter.name for parameter in plan.parameters]
    before = len(by.faults)
    for name in one:
        if name not in names:
            by.refuse(
                ("point", k, name),
                "no parameter is called so",
                shown(one[name]),
                "",
                suggestion(name, names, "name one"),
            )
    found = []
    for parameter in plan.parameters:
        if parameter.name not in one:
            by.refuse(
                ("point", k, parameter.name),
                "a point has a value for each parameter",
                "",
                ", ".join(names),
                "add it",
            )
        else:
            found.append(number(one[parameter.name], parameter.held, ("point", k, parameter.name), by))
    return None if len(by.faults) > before else tuple(value for value in found if value is not None)


VARY, POINT = "vary", "point"
BESIDE = (
    "sensitivity",
    "tolerance",
    "allocation",
    "optimise",
    "limit",
    "cost",
)  # tables that other commands read


class Written(Reading):
    """Reads the tables of a study file."""

    def __init__(self) -> None:
        super().__init__(written=True)

    def missing(self, path: Path, field: Field) -> None:
        """A key that has to be there, and its meaning."""
        self.refuse(path, "this key is missing", "", meaning_of(field), "add it")

    def table(self, path: Path, kind: type, holder: Any) -> Any:
        """The object of a table, known in part where something of it was refused."""
        before = len(self.faults)
        return self.made(kind, self.values(path, Table(kind).fields, holder), before)


@dataclass(frozen=True)
class StudyTables:
    """The tables of a study file, or of arguments that say the same: what faults call them (``source``),
    their folder, the model where it is at hand, and a name, that of the model unless given.
    """

    raw: Raw
    source: str
    folder: FilePath = FilePath()
    base: Mechanism | None = None
    name: str = ""

    @classmethod
    def load(cls, path: str | FilePath) -> StudyTables:
        """Read a study file. Raises ModelError."""
        path = FilePath(path)
        return cls(raw_of(text_of(path), str(path)), str(path), path.parent, None, path.stem)

    def plan(self) -> Plan:
        """Return the plan, of the model with what ``[set]`` replaces. Raises ModelError with every fault of
        both.
        """
        by, base = Written(), self.base
        given = {key: value for key, value in self.raw.items() if key not in (VARY, POINT, *BESIDE)}
        if base is not None:
            given = {"model": base.source or base.name, **given}
        asked = by.table((), Asked, given)
        varied = vary_tables(self.raw, by)
        faults = list[Fault]()
        model = base_model(asked, self.folder, base, faults)
        found = parameters(varied, model, by)
        if model is not None:
            check_measures(model, asked.measures, by)
            check_turns(model, asked, by)
            plan = Plan(self.name or model.name, model, asked, tuple(found), raw=dict(self.raw))
            if not by.faults and not faults:
                plan = spread(plan, self.raw.get(POINT, []), by)
        if by.faults or faults or model is None:
            raise ModelError([*by.faults, *faults], self.source)
        return plan


def vary_tables(raw: Raw, by: Written) -> dict[str, Varied]:
    """What is varied, by name; a list in the place of a table holds the values of the path that its key is."""
    tables = raw.get(VARY)
    if not isinstance(tables, dict) or not tables:
        what = "nothing is varied" if tables is None or tables == {} else f"this is {kind_of(tables)}"
        by.refuse(
            (VARY, ""),
            what,
            "",
            "a table for each number that varies",
            'add one, as in [vary.play] with path = "joint.C.clearance"',
        )
        return {}
    found = {}
    for name, holder in tables.items():
        if isinstance(holder, list):
            holder = {"path": name, "values": holder}
        if not isinstance(holder, dict):
            remedy = (
                'give its path and values, as in path = "joint.C.clearance", values = ["0.1 mm", "0.2 mm"]'
            )
            by.refuse(
                (VARY, name),
                f"this is {kind_of(holder)}",
                shown(holder),
                "a table, or a list of values",
                remedy,
            )
        elif any(sign in name for sign in "[]/\n") or not name.strip():
            by.refuse(
                (VARY, name, ""),
                "a name with signs that name something else",
                shown(name),
                "a plain name",
                "choose another name",
            )
        else:
            found[name] = by.table((VARY, name), Varied, holder)
    return found


def base_model(
    asked: Asked, folder: FilePath, base: Mechanism | None, faults: list[Fault]
) -> Mechanism | None:
    """The model, with what is set for all members; what is wrong with it goes to ``faults``."""
    items = [(path, value) for path, value in (asked.set or {}).items() if value is not None]
    if asked.model is None:
        return None
    name = asked.model
    try:
        if base is not None:
            return loads(dump(base), items, file=base.source) if items else base
        return load(folder / name, items)
    except ModelError as error:
        faults += [one.at(f"{article('model')} {name}, {one.where}") for one in error.faults]
    except (TypeError, ValueError) as error:
        faults.append(Fault("model", f"no model file can hold it: {error}"))
    return None


def of_mapping(given: Mapping[str, Any]) -> Raw:
    """What Python gives, as a file has it: arrays as lists, numbers of NumPy as Python's."""

    def plain(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {str(key): plain(one) for key, one in value.items()}
        if hasattr(value, "tolist"):
            return plain(value.tolist())
        return [plain(one) for one in value] if isinstance(value, list | tuple | range) else value

    return {key: plain(value) for key, value in given.items() if value is not None}


Json = dict[str, Any]
IDENTITY = "urn:vfife:study"
TITLE = "Study file of vfife"


def study_schema() -> Json:
    """The schema, in what drafts 4 and 7 have in common."""
    found = noun_table(Table(Asked), "The file", {})
    varied = noun_table(Table(Varied), "[vary.NAME]", {})
    listed = {**Several(Amount()).json(), "description": "the values of the path that the key is"}
    amounts = {"type": "object", "additionalProperties": Amount().json()}
    found["properties"] |= {
        VARY: {
            "type": "object", "additionalProperties": {"anyOf": [varied, listed]},
            "description": "what is varied, by names of your own, or by path with a list of values",
        },
        POINT: {"type": "array", "items": amounts, "description": "members one by one: a value for each parameter by its name"},
        **{name: {"type": "object", "description": "read by the commands that analyse a study"} for name in BESIDE},
    }  # fmt: skip
    found["required"] = [*found.get("required", ()), VARY]
    return {"$schema": DIALECT, "$id": IDENTITY, "title": TITLE, **found}


def text() -> str:
    """The schema as it is printed."""
    return json.dumps(study_schema(), indent=1, ensure_ascii=False) + "\n"
