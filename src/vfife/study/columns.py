"""Numbers of members as columns: what a path means is worked out once, values are read one by one, and nouns hold those of all members."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import Fault, Path
from ..fields import Each, Measure, Names, described_fields, key_of, value_of
from ..fields.members import Members
from ..fields.members import members as of_members
from ..model.drivers import Driver
from ..model.mechanism import Mechanism
from ..modelfile.paths import parsed, resolve

Numbers = Mapping[str, float | str]
SECTIONS = {key_of(field): field.name for field in described_fields(Mechanism)}
APART = ("run", "start", "material", "name", "note")  # how it is calculated, and what several nouns share


class Unfit(Exception):
    """A path or value that only the reader of a model understands."""


@dataclasses.dataclass(frozen=True)
class Column:
    """Where a number of a mechanism is, and what it may be: the attribute and the name of the noun, the way inside of it."""

    at: Path
    attribute: str
    name: str | None
    way: tuple[str | int, ...]
    held: Measure

    def read(self, value: float | str) -> float:
        """A value as a model file has it. Raises Unfit where it is none."""
        try:
            found = self.held.take(parsed(value) if isinstance(value, str) else value, written=True)
        except Fault as error:
            raise Unfit from error
        if not isinstance(found, float):
            raise Unfit
        return found


def column(mechanism: Mechanism, raw: dict[str, Any], path: str) -> Column:
    """The number of a mechanism at a path. Raises Unfit where only the reader of a model knows it."""
    try:
        at = resolve(raw, path)
    except Fault as error:
        raise Unfit from error
    section = str(at[0])
    if section in APART or section not in SECTIONS or len(at) < 2:
        raise Unfit
    attribute, held = SECTIONS[section], getattr(mechanism, SECTIONS[section])
    if not isinstance(held, dict):
        raise Unfit
    if section == "ground":
        if len(at) != 3 or str(at[1]) not in held:
            raise Unfit
        return Column(at, attribute, str(at[1]), (int(at[2]),), Measure("m"))
    if len(at) < 3 or str(at[1]) not in held:
        raise Unfit
    return Column(at, attribute, str(at[1]), *_inside(held[str(at[1])], at[2:]))


def _inside(noun: Any, rest: Path) -> tuple[tuple[str | int, ...], Measure]:
    """The way to a number inside a noun, by attributes, names and places, and what it may be."""
    along = isinstance(noun, Driver) and noun.along
    field = next((one for one in described_fields(type(noun)) if key_of(one, along) == rest[0]), None)
    if field is None:
        raise Unfit
    value, held = getattr(noun, field.name), value_of(field, along) if along else value_of(field)
    way: tuple[str | int, ...] = (field.name,)
    for k, part in enumerate(rest[1:], start=1):
        if dataclasses.is_dataclass(value):
            inner, found = _inside(value, rest[k:])
            return (*way, *inner), found
        if isinstance(held, Names) and isinstance(value, dict) and part in value:
            value, held = value[str(part)], held.part
        elif isinstance(held, Each) and isinstance(value, tuple) and isinstance(part, int) and part < len(value):
            value, held = value[part], held.parts[part]
        else:
            raise Unfit
        way = (*way, part)
    if not isinstance(held, Measure) or held.series or not isinstance(value, float | None):
        raise Unfit
    return way, held


def put(value: Any, way: Sequence[str | int], number: Any) -> Any:
    """A noun, or a part of one, with another number."""
    if not way:
        return number
    step, rest = way[0], way[1:]
    if isinstance(value, dict):
        return {**value, step: put(value[str(step)], rest, number)}
    if isinstance(value, tuple):
        return (*value[: int(step)], put(value[int(step)], rest, number), *value[int(step) + 1 :])
    inner = put(getattr(value, str(step)), rest, number)
    if not isinstance(number, Members):
        return dataclasses.replace(value, **{str(step): inner})
    found = object.__new__(type(value))  # nouns refuse what is no number
    for field in dataclasses.fields(value):
        object.__setattr__(found, field.name, inner if field.name == step else getattr(value, field.name))
    return found


def varied(mechanism: Mechanism, given: Sequence[tuple[Column, Any]]) -> Mechanism:
    """A mechanism with other numbers, or with those of all members."""
    nouns: dict[str, dict[str, Any]] = {}
    for one, number in given:
        held = nouns.setdefault(one.attribute, dict(getattr(mechanism, one.attribute)))
        held[str(one.name)] = put(held[str(one.name)], one.way, number)
    changed: dict[str, Any] = {**nouns, "source": None}
    return dataclasses.replace(mechanism, **changed) if nouns else mechanism


def table(columns: Sequence[Column], paths: Sequence[str], numbers: Sequence[Numbers]) -> tuple[Any, list[int]]:
    """Values (members, columns) of those that can be read, and which these are."""
    rows, which = [], []
    for k, one in enumerate(numbers):
        try:
            rows.append([held.read(one[path]) for held, path in zip(columns, paths, strict=True)])
        except Unfit:
            continue
        which.append(k)
    return np.array(rows, dtype=float).reshape(len(rows), len(columns)), which


def together(mechanism: Mechanism, columns: Sequence[Column], values: Any) -> tuple[Mechanism, Callable[[int], Mechanism]]:
    """The mechanism with the numbers of all members, and what makes that of one."""
    held: list[tuple[Column, Members]] = [(one, of_members(values[:, k])) for k, one in enumerate(columns)]

    def one_of(k: int) -> Mechanism:
        return varied(mechanism, [(one, numbers[k].item()) for one, numbers in held])

    return varied(mechanism, held), one_of
