"""Tables of a model file: the class and keys of each, derived from the fields of the classes."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

from ..errors import Path
from ..laws import Law, Material
from ..laws.law import LAWS
from ..model.bodies import LINK_MODELS, Frame, Link, PointMass, RigidBody
from ..model.drivers import Driver
from ..model.joints import Gear, IdealRevolute, Joint
from ..model.loads import Load, PointForce
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.readers import DEFAULTS, users_of
from ..model.springs import ForceElement, Spring
from ..schema import (
    Choice,
    Chosen,
    Field,
    FixedList,
    FreeList,
    Inner,
    Measure,
    Names,
    Value,
    described_fields,
    key_of,
    required,
    value_of,
)

Raw = dict[str, Any]

SECTIONS = ("body", "joint", "gear", "spring", "driver", "load")  # of what a mechanism consists of
NAMED = ("material", "ground", *SECTIONS)  # sections whose keys are names chosen by the user
# Sections with several kinds, which a word selects: base class, and the kind that needs no word.
FAMILIES: dict[str, tuple[Any, type]] = {
    "joint": (Joint, IdealRevolute),
    "spring": (ForceElement, Spring),
    "load": (Load, PointForce),
}
# Classes of bodies with the value of the key ``model`` that selects each.
BODIES: dict[type, str] = {Link: "", RigidBody: "rigid", PointMass: "particle", Frame: "frame"}
TARGETS = {"body": ("body", "against"), "slider": ("slider",), "point": ("point", "direction")}


# How many keys of a path name a table; the next one is a key in it.
DEPTHS = {"run": 1, "start": 1, **dict.fromkeys(("material", *SECTIONS), 2)}
CSV = "table"  # the key of a CSV file beside the model, whose numbers take its place when it is read


@dataclass(frozen=True)
class Table:
    """A table: its class, and the key ``tag`` with the ``word`` of the kind.

    ``optional``: the tag may be left out. ``foreign`` are the words of other kinds. ``target`` is what a
    driver drives. A ``complete`` table has all its keys regardless of defaults, except those that may remain
    unknown.
    """

    model_class: Any
    tag: str = ""
    word: str = ""
    optional: bool = False
    foreign: tuple[str, ...] = ()
    target: str = ""
    complete: bool = False

    @property
    def is_linear(self) -> bool:
        """Whether a driver acts along a line."""
        return self.target in ("slider", "point")

    @property
    def fields(self) -> Mapping[str, Field]:
        """Fields by key."""
        return fields_of(self.model_class, self.target, self.is_linear)

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys."""
        return keys_of(self)

    @property
    def needed(self) -> tuple[str, ...]:
        """Required keys; a section may be given by a shape."""
        if hasattr(self.model_class, "shapes"):
            return ()
        tag = (self.tag,) if self.tag and not self.optional else ()
        return (
            *tag,
            *(
                key
                for key, field in self.fields.items()
                if (self.complete and field.default is not None) or required(field)
            ),
        )

    def value(self, key: str) -> Value:
        """Return the type of value of a key."""
        return value_of(self.fields[key], self.is_linear)

    def idle(self, key: str, holder: Raw) -> tuple[str, ...]:
        """Return the words of the selecting key for which a key would be used, if the present word does not
        use it.
        """
        chooser = self.fields.get(getattr(self.model_class, "selected_by", ""))
        if chooser is None or key not in self.fields:
            return ()
        return users_of(self.model_class, self.fields[key], holder.get(chooser.name, chooser.default))


@functools.lru_cache(maxsize=512)
def fields_of(model_class: Any, target: str, linear: bool) -> Mapping[str, Field]:
    """Return the fields of a class by key, for a driver those of its target; cached, because every table of
    every file needs them.
    """
    fields = {key_of(field, linear): field for field in described_fields(model_class)}
    strange = (
        {key for foreign_target, keys in TARGETS.items() if foreign_target != target for key in keys}
        if target
        else set()
    )
    return MappingProxyType({key: field for key, field in fields.items() if key not in strange})


@functools.lru_cache(maxsize=512)
def keys_of(kind: Table) -> tuple[str, ...]:
    """Return all keys of a table."""
    tag, csv_key = (
        (kind.tag,) if kind.tag else (),
        (CSV,) if getattr(kind.model_class, "tabled", False) else (),
    )
    return tuple(dict.fromkeys((*tag, *kind.fields, *getattr(kind.model_class, "shapes", ()), *csv_key)))


def tables(section: str) -> tuple[Table, ...]:
    """Return the kinds of table in a section: of all registered classes."""
    registered = FAMILIES[section][0].registry if section in FAMILIES else Driver.registry
    return _tables(section, tuple(registered.items()))


@functools.lru_cache(maxsize=64)
def _tables(section: str, registered: tuple[tuple[str, Any], ...]) -> tuple[Table, ...]:
    if section in FAMILIES:
        plain = FAMILIES[section][1]
        words = tuple(word for word, _ in registered)
        return tuple(
            Table(
                model_class,
                "kind",
                word,
                model_class is plain,
                tuple(foreign_word for foreign_word in words if foreign_word != word),
            )
            for word, model_class in registered
        )
    if section == "body":
        words = (*LINK_MODELS, "particle", "frame")
        return tuple(
            Table(
                model_class,
                "model" if word else "",
                word,
                word == "rigid",
                tuple(foreign_word for foreign_word in words if foreign_word != word),
            )
            for model_class, word in BODIES.items()
        )
    if section == "material":
        return (Table(Material, complete=True),)
    if section == "driver":
        return tuple(
            Table(model_class, target=target)
            for _, model_class in registered
            for target in TARGETS
            if target in model_class.drives
        )
    classes = {"gear": Gear, "run": Settings, "start": StartSettings}
    return (Table(classes[section]),) if section in classes else ()


def body_table(holder: Any) -> Table:
    """Return the table of [body.NAME], determined by its model, its length, or keys that only one class of
    body has.
    """
    link, rigid, particle, frame = tables("body")
    keys = set(holder) if isinstance(holder, dict) else set()
    model = holder.get("model", "rigid") if keys else "rigid"
    if model in ("particle", "frame"):
        return particle if model == "particle" else frame
    if model not in LINK_MODELS and "length" not in keys and {"nodes", "members", "masses"} & keys:
        return frame
    rigid_model = model == "rigid" and not (set(link.keys) - set(rigid.keys)) & keys
    return rigid if rigid_model and {"inertia", "pins", *(set(rigid.keys) - set(link.keys))} & keys else link


def kind_table(section: str, holder: Any) -> Table:
    """Return the table of [joint.NAME] or [spring.NAME]: that of its kind, else the one that fits its keys
    best.
    """
    kinds = tables(section)
    kind = holder.get("kind") if isinstance(holder, dict) else None
    plain = next(table for table in kinds if table.optional)
    if not isinstance(holder, dict):
        return plain
    return next((table for table in kinds if table.word == kind), None) or min(
        kinds, key=lambda table: (strangeness(table, holder), table != plain)
    )


def strangeness(table: Table, holder: Raw) -> int:
    """Return a penalty for keys that are unknown, of another type or missing; missing ones weigh less."""
    keys = set(holder) - {table.tag}
    expected = keys & set(table.fields)
    missing = set(table.needed) - {table.tag} - keys
    return 3 * (
        len(keys - expected) + sum(not table.value(key).suits(holder[key]) for key in expected)
    ) + len(missing)


def target_of(holder: Any) -> str:
    """Return what a [driver.NAME] drives."""
    return next(
        (target for target in ("slider", "point") if isinstance(holder, dict) and target in holder), "body"
    )


def table(raw: Any, *path: str | int) -> Raw:
    """Return the table at a path, empty if there is none."""
    for key in path:
        if isinstance(raw, list) and isinstance(key, int) and 0 <= key < len(raw):
            raw = raw[key]
        else:
            raw = raw.get(key) if isinstance(raw, dict) else None
    return raw if isinstance(raw, dict) else {}


def entries(raw: Raw, section: str) -> Iterator[tuple[str, Raw]]:
    """Yield names and tables of a section such as "body", without entries that are no tables."""
    return ((name, entry) for name, entry in table(raw, section).items() if isinstance(entry, dict))


class Slot(NamedTuple):
    """What may be at a path: a table, or a value and its field; parts of values have no field."""

    content: Table | Value
    field: Field | None = None


def slots_at(path: Path, raw: Raw | None = None) -> list[Slot]:
    """Return what may be at a path, the most likely first; without the tables ``raw`` for all kinds
    and laws.
    """
    if not path:
        return [Slot(Table(Mechanism))]
    section = str(path[0])
    depth = DEPTHS.get(section, 0)
    if len(path) < depth:
        return []
    holder = table(raw, *path[:depth])
    kinds = (
        (Table(Mechanism),) if not depth else tables(section) if raw is None else kinds_of(section, holder)
    )
    slots = [Slot(kind) for kind in kinds]
    for at in range(depth, len(path)):
        holder = {} if raw is None else table(raw, *path[:at])
        law = None if raw is None else str(holder.get("law", ""))
        slots = [inner for slot in slots for inner in slots_in(slot.content, path[at], law)]
    return slots


def slots_in(content: Table | Value, part: str | int, law: str | None) -> Iterator[Slot]:
    """Yield what may be at a key or index of a table or value; for a law that of the name ``law``, "" for the
    default, None for any.
    """
    if isinstance(content, Inner):
        shapes = getattr(content.model_class, "shapes", {})
        if part in shapes:
            yield Slot(shapes[part][0])
        content = Table(content.model_class)
    if isinstance(content, Table):
        if part in content.fields:
            yield Slot(content.value(str(part)), content.fields[str(part)])
    elif isinstance(content, FixedList):
        if isinstance(part, int) and part < len(content.parts):
            yield Slot(content.parts[part])
    elif isinstance(content, FreeList | Names):
        yield Slot(content.part)
    elif isinstance(content, Measure) and content.series and isinstance(part, int):
        yield Slot(dataclasses.replace(content, series=False))
    elif isinstance(content, Chosen) and part == "law":
        yield Slot(Choice(tuple(sorted(LAWS[content.word].known()))))
    elif isinstance(content, Chosen):
        laws_by_name = LAWS[content.word].known()
        laws = (
            list(laws_by_name.values())
            if law is None
            else [
                laws_by_name[name] for name in (law or DEFAULTS[content.word].name,) if name in laws_by_name
            ]
        )
        yield from (
            Slot(value_of(field), field)
            for law_class in laws
            for field in dataclasses.fields(law_class)
            if field.name == part
        )


def kinds_of(section: str, holder: Raw) -> tuple[Table, ...]:
    """Return the kinds of table by which an entry may be read, the most likely first."""
    if section == "body":
        return (body_table(holder),)
    if section in FAMILIES:
        return (kind_table(section, holder),)
    if section == "driver":
        target = target_of(holder)
        kinds = [kind for kind in tables("driver") if kind.target == target]
        return tuple(
            sorted(kinds, key=lambda kind: len(set(holder) - set(kind.fields) - set(TARGETS[target])))
        )
    return tables(section)


def law_fields(law: type[Law]) -> tuple[str, ...]:
    """Return the parameters of a law."""
    return tuple(field.name for field in dataclasses.fields(law))


def keys_at(path: Path) -> tuple[str, ...] | None:
    """Return the keys of the table at a path, over all kinds; None if keys are names chosen by the user."""
    keys = list[str]()
    for content, _ in slots_at(path):
        if isinstance(content, Table | Inner):
            keys += (content if isinstance(content, Table) else Table(content.model_class)).keys
        elif isinstance(content, Chosen):
            keys += (
                "law",
                *(name for law in LAWS[content.word].known().values() for name in law_fields(law)),
            )
    return tuple(dict.fromkeys((*keys, *(() if path else ("material",))))) or None
