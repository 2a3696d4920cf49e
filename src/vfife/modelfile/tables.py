"""The tables of a model file: which noun each one is, which keys it has, and how to walk them. All of it
comes from the nouns' own fields.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from ..errors import Path
from ..laws import Law, Material
from ..model.bodies import LINK_MODELS, Frame, Link, PointMass, RigidBody
from ..model.drivers import Driver
from ..model.joints import Gear, IdealRevolute, Joint
from ..model.loads import Load, PointForce
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.reading import LAWS
from ..model.springs import ForceElement, Spring
from ..schema import Chosen, Field, Inner, Many, Value, described_fields, key_of, required, value_of

Raw = dict[str, Any]

NAMED = ("material", "ground", "body", "joint", "gear", "spring", "driver", "load")
# Sections of several kinds, told by a word, and the kind that needs none.
FAMILIES: dict[str, tuple[Any, type]] = {
    "joint": (Joint, IdealRevolute),
    "spring": (ForceElement, Spring),
    "load": (Load, PointForce),
}
BODIES: dict[type, str] = {
    Link: "",
    RigidBody: "rigid",
    PointMass: "particle",
    Frame: "frame",
}  # and the model that says so
TARGETS = {"body": ("body", "against"), "slider": ("slider",), "point": ("point", "direction")}


CSV = "table"  # the key of a CSV file beside the model, whose numbers take its place when it is read


@dataclass(frozen=True)
class Table:
    """A table: its noun, and what a file has beside the noun's fields: the key ``tag`` that is the ``word``
    of the kind.

    ``optional``: the tag may be left out. ``beside`` are the words of other kinds. ``target`` is what a
    driver drives. A ``whole`` table gives all its keys, whatever the noun has by default, but those that may
    stay unknown.
    """

    noun: Any
    tag: str = ""
    word: str = ""
    optional: bool = False
    beside: tuple[str, ...] = ()
    target: str = ""
    whole: bool = False

    @property
    def along(self) -> bool:
        """Whether a driver acts along a line."""
        return self.target in ("slider", "point")

    @property
    def fields(self) -> Mapping[str, Field]:
        """Fields by key."""
        return fields_of(self.noun, self.target, self.along)

    @property
    def keys(self) -> tuple[str, ...]:
        """Every key."""
        return keys_of(self)

    @property
    def needed(self) -> tuple[str, ...]:
        """Keys that must be there; a section may be given by a shape."""
        if hasattr(self.noun, "shapes"):
            return ()
        tag = (self.tag,) if self.tag and not self.optional else ()
        return (
            *tag,
            *(
                key
                for key, field in self.fields.items()
                if (self.whole and field.default is not None) or required(field)
            ),
        )

    def value(self, key: str) -> Value:
        """What a key holds."""
        return value_of(self.fields[key], self.along)

    def idle(self, key: str, holder: Raw) -> tuple[str, ...]:
        """The words of which one would give the key a use, where what the table says gives it none."""
        only = self.fields[key].metadata["only"] if key in self.fields else ()
        if not only:
            return ()
        chooser = next(field for field in self.fields.values() if field.name == self.noun.selected_by)
        word = holder.get(key_of(chooser), chooser.default)
        return () if word in only or word not in chooser.metadata["choices"] else tuple(only)


@functools.lru_cache(maxsize=512)
def fields_of(noun: Any, target: str, along: bool) -> Mapping[str, Field]:
    """Fields of a noun by key, of a driver those for what it drives; asked of the same nouns for every table
    of a file, and of every other file.
    """
    found = {key_of(field, along): field for field in described_fields(noun)}
    strange = {key for other, keys in TARGETS.items() if other != target for key in keys} if target else set()
    return MappingProxyType({key: field for key, field in found.items() if key not in strange})


@functools.lru_cache(maxsize=512)
def keys_of(what: Table) -> tuple[str, ...]:
    """Every key of a table."""
    tag, beside = (what.tag,) if what.tag else (), (CSV,) if getattr(what.noun, "tabled", False) else ()
    return tuple(dict.fromkeys((*tag, *what.fields, *getattr(what.noun, "shapes", ()), *beside)))


def tables(section: str) -> tuple[Table, ...]:
    """The kinds of table that a section has: of whatever is registered."""
    registered = FAMILIES[section][0].registry if section in FAMILIES else Driver.registry
    return _tables(section, tuple(registered.items()))


@functools.lru_cache(maxsize=64)
def _tables(section: str, registered: tuple[tuple[str, Any], ...]) -> tuple[Table, ...]:
    if section in FAMILIES:
        plain = FAMILIES[section][1]
        words = tuple(word for word, _ in registered)
        return tuple(
            Table(noun, "kind", word, noun is plain, tuple(other for other in words if other != word))
            for word, noun in registered
        )
    if section == "body":
        words = (*LINK_MODELS, "particle", "frame")
        return tuple(
            Table(
                noun,
                "model" if word else "",
                word,
                word == "rigid",
                tuple(one for one in words if one != word),
            )
            for noun, word in BODIES.items()
        )
    if section == "material":
        return (Table(Material, whole=True),)
    if section == "driver":
        return tuple(
            Table(noun, target=target)
            for _, noun in registered
            for target in TARGETS
            if target in noun.drives
        )
    known = {"gear": Gear, "run": Settings, "start": StartSettings}
    return (Table(known[section]),) if section in known else ()


def body_table(holder: Any) -> Table:
    """Which table a [body.NAME] is, told by its model, its length, or by what only one kind of body has."""
    link, rigid, particle, frame = tables("body")
    keys = set(holder) if isinstance(holder, dict) else set()
    model = holder.get("model", "rigid") if keys else "rigid"
    if model in ("particle", "frame"):
        return particle if model == "particle" else frame
    if model not in LINK_MODELS and "length" not in keys and {"nodes", "members", "masses"} & keys:
        return frame
    own = model == "rigid" and not (set(link.keys) - set(rigid.keys)) & keys
    return rigid if own and {"inertia", "pins", *(set(rigid.keys) - set(link.keys))} & keys else link


def kind_table(section: str, holder: Any) -> Table:
    """Which table a [joint.NAME] or [spring.NAME] is: told by its kind, else the one that its keys suit best."""
    every = tables(section)
    kind = holder.get("kind") if isinstance(holder, dict) else None
    plain = next(table for table in every if table.optional)
    if not isinstance(holder, dict):
        return plain
    return next((table for table in every if table.word == kind), None) or min(
        every, key=lambda table: (strangeness(table, holder), table != plain)
    )


def strangeness(table: Table, holder: Raw) -> int:
    """How many keys a table does not know, or knows otherwise, or misses; what it misses weighs less."""
    keys = set(holder) - {table.tag}
    known = keys & set(table.fields)
    missing = set(table.needed) - {table.tag} - keys
    return 3 * (len(keys - known) + sum(not table.value(key).suits(holder[key]) for key in known)) + len(
        missing
    )


def target_of(holder: Any) -> str:
    """What a [driver.NAME] drives."""
    return next(
        (target for target in ("slider", "point") if isinstance(holder, dict) and target in holder), "body"
    )


def table(raw: Any, *path: str | int) -> Raw:
    """The table at a path, empty if there is none."""
    for key in path:
        if isinstance(raw, list) and isinstance(key, int) and 0 <= key < len(raw):
            raw = raw[key]
        else:
            raw = raw.get(key) if isinstance(raw, dict) else None
    return raw if isinstance(raw, dict) else {}


def entries(raw: Raw, section: str) -> Iterator[tuple[str, Raw]]:
    """Names and tables of a section such as "body"; what is no table is left out."""
    return ((name, entry) for name, entry in table(raw, section).items() if isinstance(entry, dict))


def law_fields(law: type[Law]) -> tuple[str, ...]:
    """Parameters of a law."""
    return tuple(field.name for field in dataclasses.fields(law))


def known_keys(path: Path) -> tuple[str, ...] | None:
    """Keys that the table at a path can have, of whatever kind it is; None where keys are names that the user
    gives.
    """
    if not path:
        return (*Table(Mechanism).keys, "material")
    depth = 1 if path[0] in ("run", "start") else 2
    return keys_at(tables(str(path[0])), path[depth:]) if len(path) >= depth else None


def keys_at(found: tuple[Table, ...], path: Path) -> tuple[str, ...] | None:
    """Keys of tables, or of what is in them."""
    if not found:
        return None
    if not path:
        return tuple(dict.fromkeys(key for one in found for key in one.keys))
    values = [one.value(str(path[0])) for one in found if path[0] in one.fields]
    rest = path[1:]
    while rest and isinstance(rest[0], int):
        values, rest = [value.part for value in values if isinstance(value, Many)], rest[1:]
    laws = [value for value in values if isinstance(value, Chosen)]
    if laws and not rest:
        return (
            "law",
            *dict.fromkeys(name for law in LAWS[laws[0].word].known().values() for name in law_fields(law)),
        )
    return keys_at(tuple(Table(value.noun) for value in values if isinstance(value, Inner)), rest)
