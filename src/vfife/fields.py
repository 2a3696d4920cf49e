"""What the fields of laws and nouns hold: unit, meaning, limits and default, said once, beside the field.

Whoever reads, checks, writes or describes a law or a noun asks its fields: model files, their JSON Schema, the checks of what Python
makes, the lists of defaults.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import numbers
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass
from typing import Any

from .errors import Path, QuantityError, kind_of, shown
from .units import dimension_of, number

Json = dict[str, Any]
Field = dataclasses.Field[Any]
# A unit such as N/m^n is known only once a law has its exponent: such a parameter is a bare number in SI units.
SYMBOLIC = re.compile(r"\^\(?-?[a-z]")


class Refused(ValueError):
    """A value that a field does not take: what it is ("negative"), the value as written, what is allowed, what to do."""

    def __init__(self, what: str, value: str = "", limit: str = "", remedy: str = "") -> None:
        super().__init__(what)
        self.what, self.value, self.limit, self.remedy = what, value, limit, remedy


class Reading:
    """Who reads values: keeps what was refused, with its path. From Python numbers are numbers; a ``written`` one may be a text with a unit."""

    written = False

    def __init__(self) -> None:
        self.refused: list[tuple[Path, Refused]] = []

    def tell(self, path: Path, refused: Refused) -> None:
        """Keeps a refusal."""
        self.refused.append((path, refused))

    def noun(self, path: Path, kind: type, value: Any) -> Any:
        """A noun in a field of another."""
        return self.one_of(path, kind, value)

    def named(self, path: Path, kind: type, value: Any) -> Any:
        """A noun that a file calls by its name."""
        return self.one_of(path, kind, value)

    def chosen(self, path: Path, base: type, value: Any) -> Any:
        """A law, of those that there are."""
        return self.one_of(path, base, value)

    def one_of(self, path: Path, kind: type, value: Any) -> Any:
        """The value if it is of the kind, its own fields being read."""
        if not isinstance(value, kind):
            what = kind_of(value) if type(value).__module__ == "builtins" else f"a {type(value).__name__}"
            self.tell(path, Refused(f"this is {what}", "", f"a {kind.__name__}", f"give a {kind.__name__}"))
            return None
        return self.fields(path, value)

    def fields(self, path: Path, noun: Any, along: bool = False) -> Any:
        """The noun, with None in place of every value that is refused."""
        before, found = len(self.refused), {}
        for field in described_fields(type(noun)):
            value = getattr(noun, field.name)
            if not (value is None and field.default is None):
                found[field.name] = value_of(field, along).read(value, (*path, key_of(field, along)), self)
        return noun if len(self.refused) == before else partial(type(noun), vars(noun) | found)


@dataclass(frozen=True)
class Value:
    """What a field holds, and how it is read."""

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """The value as the noun holds it, None where it is refused, which ``by`` is told."""
        try:
            return self.take(value, by.written)
        except Refused as refused:
            by.tell(path, refused)
            return None

    def take(self, value: Any, written: bool) -> Any:
        """The value of a field without parts. Raises Refused."""
        return value

    def suits(self, value: Any) -> bool:
        """Whether a value of a file has the shape: a list, a table or neither."""
        return not isinstance(value, list | dict)

    def json(self) -> Json:
        """JSON Schema of what stands in a file."""
        return {}

    def units(self) -> Iterator[str]:
        """Units and limits, in words."""
        return iter(())


@dataclass(frozen=True)
class Measure(Value):
    """A quantity: SI unit and limits (above, at least, at most). One of ``words`` may stand in its place; ``series`` allows several as well."""

    unit: str
    above: float | None = None
    low: float | None = None
    high: float | None = None
    words: tuple[str, ...] = ()
    series: bool = False

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """SI value, one of the words, or a tuple of values."""
        if self.series and is_list(value):
            return None if any_none(parts := [Value.read(self, one, path, by) for one in value]) else tuple(parts)
        return super().read(value, path, by)

    def take(self, value: Any, written: bool) -> Any:
        """SI value, or one of the words."""
        if isinstance(value, str) and value in self.words:
            return value
        other = f", or {shown(self.words[0])}" if self.words else ""
        try:
            if not written and not (isinstance(value, numbers.Real) and not isinstance(value, bool)):
                raise QuantityError(value, kind_of(value), *spoken_limit(self.unit))
            result = number(value if written else float(value), self.unit)
        except QuantityError as error:
            remedy = error.remedy if error.remedy.startswith("give") else f"write {error.remedy}"
            raise Refused(f"this is {error.what}", shown(value), error.limit + other, remedy) from None
        if not self.allows(result):
            low, high = self.above if self.above is not None else self.low, self.high
            what = "too large" if high is not None and result > high else "zero or negative" if not low else "too small"
            what = "negative" if low == 0.0 and result < 0.0 else what
            remedy = f'correct the value or its unit (as in "{dimension_of(self.unit)[1]}")'
            if not written:
                remedy = "correct the value" if self.unit == "1" else f"correct the value, which is in {self.unit}"
            raise Refused(f"this is {what}", shown(value), self.limits(), remedy)
        return result

    def allows(self, result: float) -> bool:
        """Whether the limits are kept."""
        over = (self.above is None or result > self.above) and (self.low is None or result >= self.low)
        return over and (self.high is None or result <= self.high)

    def limits(self) -> str:
        """The limits in words."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        parts = ((self.above, "above"), (self.low, "at least"), (self.high, "at most"))
        return " and ".join(f"{word} {limit:g}{unit}" for limit, word in parts if limit is not None)

    def suits(self, value: Any) -> bool:
        """A number or a text; of a series also a list."""
        return super().suits(value) or (self.series and isinstance(value, list))

    def json(self) -> Json:
        """A number in SI units or a text with a unit; that ``above`` itself is excluded, drafts of JSON Schema say differently."""
        low = self.above if self.above is not None else self.low
        bare: Json = {"type": "number"}
        bare |= {key: limit for key, limit in (("minimum", low), ("maximum", self.high)) if limit is not None}
        one: list[Json] = [bare, {"type": "string"}]
        more = [{"type": "array", "items": {"anyOf": one}}] if self.series else []
        return {"anyOf": [*one, *more], "x-unit": self.unit, "x-limits": self.limits()}

    def units(self) -> Iterator[str]:
        """Unit and limits."""
        yield ", ".join(part for part in ("a number" if self.unit == "1" else self.unit, self.limits()) if part)


@dataclass(frozen=True)
class Whole(Value):
    """A whole number between two limits; the upper one catches typing errors."""

    low: int
    high: int

    def take(self, value: Any, written: bool) -> int:
        """The number."""
        limit = f"a whole number from {self.low} to {self.high}"
        if isinstance(value, float) and math.isfinite(value) and value == int(value):
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int | numbers.Integral):
            raise Refused(f"this is {kind_of(value)}", shown(value), limit, "write a whole number without quotes" if written else "give one")
        result = int(value)
        if not self.low <= result <= self.high:
            raise Refused(f"this is {'too small' if result < self.low else 'too large'}", shown(value), limit, "correct the number")
        return result

    def json(self) -> Json:
        """A whole number."""
        return {"type": "integer", "minimum": self.low, "maximum": self.high}

    def units(self) -> Iterator[str]:
        """Its limits."""
        yield f"a whole number from {self.low} to {self.high}"


@dataclass(frozen=True)
class Choice(Value):
    """One of some words; ``beside`` are words that another kind of table has for this key."""

    options: tuple[str, ...]
    beside: tuple[str, ...] = ()

    def take(self, value: Any, written: bool) -> str:
        """The word."""
        if isinstance(value, str) and value in self.options:
            return value
        every = self.options + self.beside
        near = difflib.get_close_matches(value.lower(), every, 1, 0.5) if isinstance(value, str) else []
        what = "an unknown word" if isinstance(value, str) else kind_of(value)
        limit = " or ".join(shown(word) for word in every)
        remedy = f'did you mean "{near[0]}"?' if near else f"{'write' if written else 'give'} one of these words"
        raise Refused(f"this is {what}", shown(value), limit, remedy)

    def json(self) -> Json:
        """One of the words."""
        return {"enum": list(self.options)}


@dataclass(frozen=True)
class Text(Value):
    """Any text; in a reference a ``pin`` ("body.pin" or "ground.point"), a ``body`` or a ``joint``."""

    refers: str = ""

    def take(self, value: Any, written: bool) -> str:
        """The text."""
        if not isinstance(value, str):
            raise Refused(f"this is {kind_of(value)}", shown(value), "a text", "put it in quotes")
        return value

    def json(self) -> Json:
        """A text."""
        return {"type": "string"}


@dataclass(frozen=True)
class Switch(Value):
    """true or false."""

    def take(self, value: Any, written: bool) -> bool:
        """The switch."""
        if not isinstance(value, bool):
            remedy = "write it without quotes" if written else "give True or False"
            raise Refused(f"this is {kind_of(value)}", shown(value), "true or false", remedy)
        return value

    def json(self) -> Json:
        """true or false."""
        return {"type": "boolean"}


@dataclass(frozen=True)
class Each(Value):
    """A list with a place for each of its parts."""

    parts: tuple[Value, ...]

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A tuple, None where a part is refused."""
        if not is_list(value):
            return no_list(value, path, by)
        found = [part.read(one, (*path, k), by) for k, (part, one) in enumerate(zip(self.parts, value, strict=False))]
        for k in range(len(found), len(self.parts)):
            by.tell((*path, k), Refused("this value of the list is missing", "", "", "give the list all its values"))
        if len(value) > len(self.parts):
            by.tell(path, Refused("too many values", shown(value), f"{len(self.parts)} values", "remove what is too many"))
        return None if any_none(found) or len(value) != len(self.parts) else tuple(found)

    def suits(self, value: Any) -> bool:
        """A list."""
        return isinstance(value, list)

    def json(self) -> Json:
        """A list of that length."""
        count = len(self.parts)
        items = [part.json() for part in self.parts]
        return {"type": "array", "minItems": count, "maxItems": count, "items": items, "additionalItems": False}

    def units(self) -> Iterator[str]:
        """Those of its parts."""
        for part in self.parts:
            yield from part.units()


@dataclass(frozen=True)
class Direction(Each):
    """A direction in the plane: of any length but none."""

    parts: tuple[Value, ...] = (Measure("1"), Measure("1"))

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A pair of numbers."""
        found = super().read(value, path, by)
        if found is not None and max(map(abs, found)) < 1e-9:
            remedy = "give it a part along x or y, as in [1, 0]"
            by.tell(path, Refused("a direction of no length points nowhere", shown(value), "", remedy))
            return None
        return found


@dataclass(frozen=True)
class Many(Value):
    """A list of any length of one kind of value."""

    part: Value

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A tuple, None where a part is refused; nouns are kept, as far as they go."""
        if not is_list(value):
            return no_list(value, path, by)
        found = tuple(self.part.read(one, (*path, k), by) for k, one in enumerate(value))
        return found if isinstance(self.part, Inner) or not any_none(found) else None

    def suits(self, value: Any) -> bool:
        """A list."""
        return isinstance(value, list)

    def json(self) -> Json:
        """A list."""
        return {"type": "array", "items": self.part.json()}

    def units(self) -> Iterator[str]:
        """Those of its parts."""
        return self.part.units()


@dataclass(frozen=True)
class Names(Value):
    """Values by names that the user gives."""

    part: Value

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A dict; a part that is refused is None under its name."""
        if not isinstance(value, Mapping):
            by.tell(path, Refused(f"this is {kind_of(value)}", shown(value), "a table", "write its keys in a table of that name"))
            return None
        return {name: self.part.read(one, (*path, name), by) for name, one in value.items()}

    def suits(self, value: Any) -> bool:
        """A table."""
        return isinstance(value, dict)

    def json(self) -> Json:
        """A table of any keys."""
        return {"type": "object", "additionalProperties": self.part.json()}

    def units(self) -> Iterator[str]:
        """Those of its parts."""
        return self.part.units()


@dataclass(frozen=True)
class Inner(Value):
    """A noun in a field of another."""

    noun: type

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """The noun."""
        return by.noun(path, self.noun, value)

    def suits(self, value: Any) -> bool:
        """A table."""
        return isinstance(value, dict)

    def json(self) -> Json:
        """The noun's own table."""
        return {"$ref": f"#/definitions/{self.noun.__name__}Table"}


@dataclass(frozen=True)
class Named(Value):
    """A noun that a file calls by its name, as a material."""

    noun: type

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """The noun."""
        return by.named(path, self.noun, value)

    def json(self) -> Json:
        """A name."""
        return {"type": "string"}


@dataclass(frozen=True)
class Chosen(Value):
    """A law of those that ``base`` has in its registry."""

    base: type
    word: str

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """The law."""
        return by.chosen(path, self.base, value)

    def suits(self, value: Any) -> bool:
        """A table."""
        return isinstance(value, dict)

    def json(self) -> Json:
        """The table of one of the laws."""
        return {"allOf": [{"$ref": f"#/definitions/{self.word}_law"}]}


@dataclass(frozen=True)
class Entries(Value):
    """Nouns by name, of one kind or of those that ``base`` has in its registry."""

    base: type

    def suits(self, value: Any) -> bool:
        """A table."""
        return isinstance(value, dict)


LENGTH, SCALAR = Measure("m"), Measure("1")
PLACE = Each((LENGTH, LENGTH))


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


def partial(noun: type, values: Mapping[str, Any]) -> Any:
    """A noun of which only some values are known: None stands for the others, so that what does not hang on them can still be checked."""
    made: Any = object.__new__(noun)
    for field in dataclasses.fields(noun):
        default = field.default_factory() if field.default_factory is not MISSING else None if field.default is MISSING else field.default
        object.__setattr__(made, field.name, values.get(field.name, default))
    return made


def required(field: Field) -> bool:
    """Whether a noun cannot do without the field."""
    return field.default is MISSING and field.default_factory is MISSING


def spoken_limit(unit: str) -> tuple[str, str]:
    """What Python may give in a unit, and how."""
    words, _ = dimension_of(unit)
    return words, "give a number" if unit == "1" else f"give a number in {unit}"


def is_list(value: Any) -> bool:
    """Whether a value is a list, a tuple or an array."""
    return isinstance(value, list | tuple) or (hasattr(value, "__array__") and getattr(value, "ndim", 0) > 0)


def no_list(value: Any, path: Path, by: Reading) -> None:
    """Tells that a value is no list."""
    by.tell(path, Refused(f"this is {kind_of(value)}", shown(value), "a list", "put the values in square brackets"))


def any_none(values: Iterable[Any]) -> bool:
    """Whether one of the values was refused."""
    return any(value is None for value in values)
