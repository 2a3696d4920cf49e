"""Described fields, and reading of all fields of an object."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import MISSING
from typing import Any, TypedDict

from ..errors import Fault, Path, kind_of, shown, suggestion
from ..options import with_faults
from .parts import SCALAR
from .values import Choice, Measure, Switch, Text, Value

Field = dataclasses.Field[Any]
MOST_BARE = 3  # values without a unit that a fault lists
# A unit such as N/m^n is known only once a law has its exponent: such a parameter is a bare number in SI
# units.
SYMBOLIC = re.compile(r"\^\(?-?[a-z]")


class FieldSettings(TypedDict, total=False):
    """What :func:`described` keeps of a field beside its value, meaning and default."""

    factory: Any
    key: str
    only: tuple[str, ...]
    linear: Any


def described(
    value: Value,
    meaning: str,
    default: Any = MISSING,
    *,
    factory: Any = MISSING,
    key: str = "",
    only: tuple[str, ...] = (),
    linear: Any = None,
) -> Any:
    """Return a dataclass field with a description: its type of value, meaning and default.

    ``key``: its name in a model file, if different; ``only``: the link models or analyses that use it;
    ``linear``: the field that replaces it for a driver along a line instead of about an axis.
    """
    metadata_of_value = {name: getattr(value, name, None) for name in ("unit", "low", "high", "above")} | {
        "choices": getattr(value, "options", None)
    }
    metadata_of_value["unit"] = metadata_of_value["unit"] or "1"
    metadata = {
        **metadata_of_value,
        "value": value,
        "meaning": meaning,
        "key": key,
        "only": only,
        "linear": linear.metadata if linear is not None else None,
    }
    return dataclasses.field(default=default, default_factory=factory, metadata=metadata)


@with_faults(FieldSettings)
def quantity(
    unit: str,
    meaning: str,
    default: Any = MISSING,
    *,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    choices: Collection[str] | None = None,
    **settings: Any,
) -> Any:
    """Return a field for a number: unit ("1" for none), meaning, default, and limits (at least ``low``, at
    most ``high``, greater than ``above``).

    A field of a law may also hold one of the words ``choices``, or a truth value if that is its default.
    ``settings`` as in :func:`described`.
    """
    value: Value = Measure("1" if SYMBOLIC.search(unit) else unit, above=above, low=low, high=high)
    if choices is not None:
        value = Choice(tuple(choices))
    elif isinstance(default, bool):
        value = Switch()
    elif isinstance(default, str):
        value = Text()
    field = described(value, meaning, default, **settings)
    limits = {"unit": unit, "choices": choices} | (
        {} if isinstance(value, Measure) else {"low": low, "high": high, "above": above}
    )
    return dataclasses.field(
        default=field.default, default_factory=field.default_factory, metadata={**field.metadata, **limits}
    )


def described_fields(model_class: type) -> tuple[Field, ...]:
    """Return the described fields of a model class, or all fields of a law."""
    fields: tuple[Field, ...] = dataclasses.fields(model_class)
    return tuple(field for field in fields if "meaning" in field.metadata)


def value_of(field: Field, linear: bool = False) -> Value:
    """Return the type of value of a field; without description it follows from annotation and default."""
    metadata = field.metadata
    if linear and metadata.get("linear") is not None:
        metadata = metadata["linear"]
    value = metadata.get("value")
    plain = isinstance(value, Measure) and field.default in (None, MISSING)
    if isinstance(value, Value) and not (plain and field.type in (bool, "bool", str, "str")):
        return value
    if field.type in (bool, "bool") or isinstance(field.default, bool):
        return Switch()
    if field.type in (str, "str") or isinstance(field.default, str):
        return Text()
    return SCALAR


def key_of(field: Field, linear: bool = False) -> str:
    """Return the name of a field in a model file."""
    if linear and field.metadata.get("linear") is not None:
        return str(field.metadata["linear"]["key"] or field.metadata["key"] or field.name)
    return str(field.metadata.get("key") or field.name)


def meaning_of(field: Field, linear: bool = False) -> str:
    """Return the meaning of a field."""
    if linear and field.metadata.get("linear") is not None:
        return str(field.metadata["linear"]["meaning"])
    return str(field.metadata.get("meaning", ""))


def default_of(field: Field) -> Any:
    """Return the default of a field, a new object if a factory makes it; MISSING without one."""
    return field.default if field.default_factory is MISSING else field.default_factory()


def required(field: Field) -> bool:
    """Return whether a field has no default."""
    return field.default is MISSING and field.default_factory is MISSING


def contains_text(value: Any) -> bool:
    """Return whether a value is a text, or a list that contains one at any depth."""
    return isinstance(value, str) or (isinstance(value, tuple | list) and any(map(contains_text, value)))


def contains_unit(value: Any) -> bool:
    """Return whether a value is a text that is no plain number, or a list that contains one at any depth."""
    if isinstance(value, str):
        with suppress(ValueError):
            float(value)
            return False
        return True
    return isinstance(value, tuple | list) and any(map(contains_unit, value))


class Reader:
    """Reads values by the descriptions of their fields and collects all faults with their paths. ``written``:
    numbers may be texts with a unit.
    """

    def __init__(self, written: bool = False) -> None:
        self.written = written
        self.faults: list[Fault] = []

    def add(self, fault: Fault) -> None:
        """Add a fault."""
        self.faults.append(fault)

    def refuse(self, path: Path, problem: str, value: str = "", limit: str = "", remedy: str = "") -> None:
        """Add a fault about the value at a path."""
        self.add(Fault(path, problem, value, limit, remedy))

    def same_units(self, values: Iterable[Any], path: Path, unit: str) -> None:
        """Report valid values of a list that have no unit where others have one; 0 needs none."""
        written = [value for value in values if contains_unit(value)]
        bare = [shown(value) for value in values if not contains_unit(value) and float(value) != 0.0]
        if unit != "1" and written and bare:
            self.refuse(
                path,
                f"{len(bare)} of the values have no unit, others have one, as {shown(written[0])}",
                ", ".join(bare[:MOST_BARE]) + ", ..." * (len(bare) > MOST_BARE),
                "a unit at each value but 0, or at none",
                f"write the unit; without one a value is in {unit}",
            )

    def unexpected(self, path: Path, value: Any, limit: str, remedy: str) -> None:
        """Report a value of another type than ``limit``."""
        self.refuse(path, f"this is {kind_of(value)}", shown(value), limit, remedy)

    def values(
        self,
        path: Path,
        fields: Mapping[str, Field],
        table: Mapping[str, Any],
        foreign_keys: Collection[str] = (),
    ) -> dict[str, Any]:
        """Return the values of a table by field name; ``foreign_keys`` are keys that are read elsewhere."""
        values = {}
        for key, value in table.items():
            if key in fields:
                values[fields[key].name] = value_of(fields[key]).read(value, (*path, key), self)
            elif key not in foreign_keys:
                self.unknown((*path, key), value, (*fields, *foreign_keys))
        for key, field in fields.items():
            if key not in table and required(field):
                self.missing((*path, key), field)
        return values

    def unknown(self, path: Path, value: Any, names: Iterable[str] = ()) -> None:
        """Report a key that the table does not have."""
        problem = "unknown table" if isinstance(value, Mapping) else "unknown key"
        self.refuse(path, problem, shown(value), "", suggestion(str(path[-1]), names, "remove it"))

    def missing(self, path: Path, field: Field) -> None:
        """Report a missing key."""
        self.refuse(path, "this key is missing", remedy="add it")

    def build(self, kind: type, values: Mapping[str, Any], fault_count: int) -> Any:
        """Return the object with these values; only with the valid ones if there are more faults than
        ``fault_count``.
        """
        return kind(**values) if len(self.faults) == fault_count else partial(kind, values)

    def inner(self, path: Path, kind: type, value: Any) -> Any:
        """Return an object nested in another."""
        return self.one_of(path, kind, value)

    def named(self, path: Path, kind: type, value: Any) -> Any:
        """Return an object that a file refers to by name."""
        return self.one_of(path, kind, value)

    def chosen(self, path: Path, base: type, value: Any) -> Any:
        """Return a law from the registry of ``base``; a name of one is refused with the law as the remedy."""
        law = getattr(base, "registry", {}).get(value) if isinstance(value, str) else None
        if law is None:
            return self.one_of(path, base, value)
        library = "vfife.laws." if law.__module__.startswith(f"{__package__.partition('.')[0]}.laws.") else ""
        remedy = f"give the law itself: {library}{law.__name__}()"
        self.refuse(path, "this is the name of a law", shown(value), f"a {base.__name__}", remedy)
        return None

    def one_of(self, path: Path, kind: type, value: Any) -> Any:
        """Return the value if it is of the class, with its own fields read."""
        if not isinstance(value, kind):
            type_name = (
                kind_of(value) if type(value).__module__ == "builtins" else f"a {type(value).__name__}"
            )
            self.refuse(path, f"this is {type_name}", "", f"a {kind.__name__}", f"give a {kind.__name__}")
            return None
        return self.fields(path, value)

    def fields(self, path: Path, item: Any, linear: bool = False) -> Any:
        """Return the object with its fields read, and None for every invalid value."""
        values = {}
        for field in described_fields(type(item)):
            value = getattr(item, field.name)
            if not (value is None and field.default is None):
                values[field.name] = value_of(field, linear).read(value, (*path, key_of(field, linear)), self)
        return partial(type(item), vars(item) | values)


def partial(model_class: type, values: Mapping[str, Any]) -> Any:
    """Return an object of which only some values are known, with None for all others, so that independent
    checks can still run.
    """
    partial_object: Any = object.__new__(model_class)
    for field in dataclasses.fields(model_class):
        default = None if required(field) else default_of(field)
        object.__setattr__(partial_object, field.name, values.get(field.name, default))
    return partial_object
