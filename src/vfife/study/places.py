"""Places of a model: what the number at a path may be, from the nouns' own fields, so that a study is checked before it is run."""

from __future__ import annotations

import dataclasses
from typing import Any

from ..errors import Path
from ..fields import Chosen, Each, Inner, Many, Measure, Names, Value, value_of
from ..model.lawtables import DEFAULTS, LAWS
from ..model.mechanism import Mechanism
from ..modelfile.tables import FAMILIES, TARGETS, Raw, Table, body_table, kind_table, table, tables, target_of

LENGTH_OF = {"material": 2, "body": 2, "joint": 2, "gear": 2, "spring": 2, "driver": 2, "load": 2, "run": 1, "start": 1}


def held_at(raw: Raw, path: Path) -> Value | None:
    """What stands at a path of a model's tables; None where a table does, or nothing that a model knows."""
    section = str(path[0])
    depth = LENGTH_OF.get(section, 0)
    if depth and len(path) <= depth:
        return None
    top = Table(Mechanism)
    if not depth:
        return inside(top.value(section), path[1:], raw.get(section)) if section in top.fields else None
    holder, key = table(raw, *path[:depth]), str(path[depth])
    for one in candidates(section, holder):
        if key in one.fields:
            return inside(one.value(key), path[depth + 1 :], holder.get(key))
    return None


def candidates(section: str, holder: Raw) -> tuple[Table, ...]:
    """Tables that a noun may be read by, the likeliest first."""
    if section == "body":
        return (body_table(holder),)
    if section in FAMILIES:
        return (kind_table(section, holder),)
    if section == "driver":
        target = target_of(holder)
        own = [one for one in tables("driver") if one.target == target]
        return tuple(sorted(own, key=lambda one: len(set(holder) - set(one.fields) - set(TARGETS[target]))))
    return tables(section)


def inside(held: Value, rest: Path, holder: Any) -> Value | None:
    """What stands deeper in a value."""
    for depth, part in enumerate(rest):
        if isinstance(held, Each) and isinstance(part, int) and part < len(held.parts):
            held = held.parts[part]
        elif isinstance(held, Many | Names):
            held = held.part
        elif isinstance(held, Measure) and held.series and isinstance(part, int):
            held = dataclasses.replace(held, series=False)
        else:
            within = table(holder, *rest[:depth])
            found = of_law(held, str(part), within) if isinstance(held, Chosen) else of_noun(held, str(part))
            if found is None:
                return None
            held = found
    return None if isinstance(held, Inner | Chosen | Each | Names) else held


def of_noun(held: Value, key: str) -> Value | None:
    """A field of a noun within a noun; a section may be given by its shape."""
    if not isinstance(held, Inner):
        return None
    shapes: Any = getattr(held.noun, "shapes", {})
    known = Table(held.noun)
    return known.value(key) if key in known.fields else shapes[key][0] if key in shapes else None


def of_law(held: Chosen, key: str, holder: Raw) -> Value | None:
    """A parameter of the law that is named there, or its name."""
    registry = LAWS[held.word].known()
    if key == "law":
        from ..fields import Choice

        return Choice(tuple(sorted(registry)))
    law = registry.get(str(holder.get("law", DEFAULTS[held.word].name)))
    return next((value_of(one) for one in dataclasses.fields(law) if one.name == key), None) if law is not None else None
