"""TOML text -> plan of a study: keys read by the nouns' fields, paths and quantities by the model they are of; all faults at once."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

from ..errors import Fault, ModelError, Path, article, kind_of, place, shown, suggestion
from ..fields import Reading, Refused, partial
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.read import load, raw_of, text_of
from ..modelfile.tables import Raw, Table
from .plan import Asked, Plan, Varied
from .points import spread
from .varied import parameters
from .wanted import check_measures, check_turns

VARY, POINT = "vary", "point"
BESIDE = ("sensitivity", "tolerance", "allocation", "optimise", "limit", "cost")  # tables that other commands read


class Written(Reading):
    """Reads the tables of a study file."""

    written = True

    @property
    def faults(self) -> list[Fault]:
        """Everything refused, in words."""
        return [Fault(place(path), one.what, one.value, one.limit, one.remedy) for path, one in self.refused]

    def table(self, path: Path, noun: type, holder: Any, beside: tuple[str, ...] = ()) -> Any:
        """The noun of a table, known in part where something of it was refused."""
        what, found, before = Table(noun), dict[str, Any](), len(self.refused)
        for key, value in holder.items():
            if key in what.fields:
                found[what.fields[key].name] = what.value(key).read(value, (*path, key), self)
            elif key not in beside:
                said = "unknown table" if isinstance(value, dict) else "unknown key"
                self.tell((*path, key), Refused(said, shown(value), "", suggestion(key, (*what.keys, *beside), "remove it")))
        for key in what.needed:
            if key not in holder:
                self.tell((*path, key), Refused("this key is missing", "", what.fields[key].metadata["meaning"], "add it"))
        return noun(**found) if len(self.refused) == before else partial(noun, found)


def load_plan(path: str | FilePath) -> tuple[Plan, Mechanism]:
    """The plan of a study file and the model it is of, with what ``[set]`` replaces. Raises ModelError with every fault of both."""
    path = FilePath(path)
    return understood(raw_of(text_of(path), str(path)), str(path), path.parent)


def understood(raw: Raw, known_as: str, folder: FilePath | None = None, base: Mechanism | None = None) -> tuple[Plan, Mechanism]:
    """The plan of the tables of a study file, and the model; ``base`` is the model where it is at hand. Raises ModelError with every fault."""
    by = Written()
    given = {key: value for key, value in raw.items() if key not in (VARY, POINT, *BESIDE)}
    if base is not None:
        given = {"model": base.source or base.name, **given}
    asked = by.table((), Asked, given)
    varied = vary_tables(raw, by)
    faults = list[Fault]()
    model = base_model(asked, folder or FilePath(), base, faults)
    found = parameters(varied, tomllib.loads(dump(model)) if model is not None else None, by)
    plan = Plan(asked, tuple(found), raw=dict(raw))
    if model is not None:
        check_measures(model, asked.measures, by)
        check_turns(model, asked, by)
    if not by.refused and not faults:
        plan = spread(plan, raw.get(POINT, []), by)
    if by.refused or faults or model is None:
        raise ModelError([*by.faults, *faults], known_as)
    return plan, model


def vary_tables(raw: Raw, by: Written) -> dict[str, Varied]:
    """What is varied, by name; a list in the place of a table holds the values of the path that its key is."""
    tables = raw.get(VARY)
    if not isinstance(tables, dict) or not tables:
        what = "nothing is varied" if tables is None or tables == {} else f"this is {kind_of(tables)}"
        by.tell((VARY, ""), Refused(what, "", "a table for each number that varies", 'add one, as in [vary.play] with path = "joint.C.clearance"'))
        return {}
    found = {}
    for name, holder in tables.items():
        if isinstance(holder, list):
            holder = {"path": name, "values": holder}
        if not isinstance(holder, dict):
            remedy = 'give its path and values, as in path = "joint.C.clearance", values = ["0.1 mm", "0.2 mm"]'
            by.tell((VARY, name), Refused(f"this is {kind_of(holder)}", shown(holder), "a table, or a list of values", remedy))
        elif any(sign in name for sign in "[]/\n") or not name.strip():
            by.tell((VARY, name, ""), Refused("a name with signs that name something else", shown(name), "a plain name", "choose another name"))
        else:
            found[name] = by.table((VARY, name), Varied, holder)
    return found


def base_model(asked: Asked, folder: FilePath, base: Mechanism | None, faults: list[Fault]) -> Mechanism | None:
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
        faults += [Fault(f"{article('model')} {name}, {one.where}", one.what, one.value, one.limit, one.remedy) for one in error.faults]
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
