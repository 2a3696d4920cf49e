"""A field and what it says of itself."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection
from dataclasses import MISSING
from typing import Any

from .parts import SCALAR
from .values import Choice, Measure, Switch, Text, Value

Field = dataclasses.Field[Any]
# A unit such as N/m^n is known only once a law has its exponent: such a parameter is a bare number in SI units.
SYMBOLIC = re.compile(r"\^\(?-?[a-z]")


def described(
    value: Value, meaning: str, default: Any = MISSING, *, factory: Any = MISSING, key: str = "", only: tuple[str, ...] = (), along: Any = None
) -> Any:
    """A field: what it holds, what it means, its default.

    ``key`` is what a file calls it, where that is not its name; ``only`` names the models or kinds of analysis that have a use for it. What
    drives a body or a pin has ``along``, the same field where it moves along a line.
    """
    told = {name: getattr(value, name, None) for name in ("unit", "low", "high", "above")} | {"choices": getattr(value, "options", None)}
    told["unit"] = told["unit"] or "1"
    metadata = {**told, "value": value, "meaning": meaning, "key": key, "only": only, "along": along.metadata if along is not None else None}
    return dataclasses.field(default=default, default_factory=factory, metadata=metadata)


def quantity(
    unit: str,
    meaning: str,
    default: Any = MISSING,
    *,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    choices: Collection[str] | None = None,
    **more: Any,
) -> Any:
    """A field that is a number: its unit ("1" if it has none), meaning and default, and its limits: at least ``low``, at most ``high``, ``above``.

    A field of a law may also be a word, one of ``choices``, or a switch, as its default tells. ``more`` as in :func:`described`.
    """
    value: Value = Measure("1" if SYMBOLIC.search(unit) else unit, above=above, low=low, high=high)
    if choices is not None:
        value = Choice(tuple(choices))
    elif isinstance(default, bool):
        value = Switch()
    elif isinstance(default, str):
        value = Text()
    field = described(value, meaning, default, **more)
    kept = {"unit": unit, "choices": choices} | ({} if isinstance(value, Measure) else {"low": low, "high": high, "above": above})
    return dataclasses.field(default=field.default, default_factory=field.default_factory, metadata={**field.metadata, **kept})


def described_fields(noun: type) -> tuple[Field, ...]:
    """Fields that are described, and those of a law."""
    every: tuple[Field, ...] = dataclasses.fields(noun)
    return tuple(field for field in every if "meaning" in field.metadata)


def value_of(field: Field, along: bool = False) -> Value:
    """What a field holds; where nothing was said its type or its default tells."""
    metadata = field.metadata
    if along and metadata.get("along") is not None:
        metadata = metadata["along"]
    value = metadata.get("value")
    plain = isinstance(value, Measure) and field.default in (None, MISSING)
    if isinstance(value, Value) and not (plain and field.type in (bool, "bool", str, "str")):
        return value
    if field.type in (bool, "bool") or isinstance(field.default, bool):
        return Switch()
    if field.type in (str, "str") or isinstance(field.default, str):
        return Text()
    return SCALAR


def key_of(field: Field, along: bool = False) -> str:
    """What a file calls a field."""
    if along and field.metadata.get("along") is not None:
        return str(field.metadata["along"]["key"] or field.metadata["key"] or field.name)
    return str(field.metadata.get("key") or field.name)


def meaning_of(field: Field, along: bool = False) -> str:
    """What a field means."""
    if along and field.metadata.get("along") is not None:
        return str(field.metadata["along"]["meaning"])
    return str(field.metadata.get("meaning", ""))


def required(field: Field) -> bool:
    """Whether a noun cannot do without the field."""
    return field.default is MISSING and field.default_factory is MISSING
