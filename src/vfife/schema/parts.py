"""What a field with parts holds: lists, tables by name, nouns within nouns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import Path, kind_of, shown
from .values import Json, Measure, Value, any_none, is_list

if TYPE_CHECKING:
    from .described import Reading


@dataclass(frozen=True)
class Each(Value):
    """A list with a place for each of its parts."""

    parts: tuple[Value, ...]

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A tuple, None where a part is refused."""
        if not is_list(value):
            return no_list(value, path, by)
        parts = [
            part.read(one, (*path, k), by)
            for k, (part, one) in enumerate(zip(self.parts, value, strict=False))
        ]
        for k in range(len(parts), len(self.parts)):
            by.refuse((*path, k), "this value of the list is missing", "", "", "give the list all its values")
        if len(value) > len(self.parts):
            by.refuse(
                path, "too many values", shown(value), f"{len(self.parts)} values", "remove what is too many"
            )
        return None if any_none(parts) or len(value) != len(self.parts) else tuple(parts)

    def suits(self, value: Any) -> bool:
        """A list."""
        return isinstance(value, list)

    def json(self) -> Json:
        """A list of that length."""
        count = len(self.parts)
        items = [part.json() for part in self.parts]
        return {
            "type": "array",
            "minItems": count,
            "maxItems": count,
            "items": items,
            "additionalItems": False,
        }

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
        parts = super().read(value, path, by)
        if parts is not None and max(map(abs, parts)) < 1e-9:
            remedy = "give it a part along x or y, as in [1, 0]"
            by.refuse(path, "a direction of no length points nowhere", shown(value), "", remedy)
            return None
        return parts


@dataclass(frozen=True)
class Many(Value):
    """A list of any length of one kind of value."""

    part: Value

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A tuple, None where a part is refused; nouns are kept, as far as they go."""
        if not is_list(value):
            return no_list(value, path, by)
        parts = tuple(self.part.read(one, (*path, k), by) for k, one in enumerate(value))
        return parts if isinstance(self.part, Inner) or not any_none(parts) else None

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
class Curve(Many):
    """Points of a curve, ``columns`` and their units; in a file also the name of a CSV file beside it, whose
    numbers take its place.
    """

    columns: tuple[str, str] = ("", "")

    @property
    def unit(self) -> str:
        """Both units."""
        return ", ".join(self.part.units())

    def suits(self, value: Any) -> bool:
        """A list, or the name of a file."""
        return isinstance(value, list | str)

    def json(self) -> Json:
        """A list of points, or the name of a file."""
        name = {
            "type": "string",
            "description": f"a CSV file beside the model with the columns {', '.join(self.columns)}",
        }
        return {"anyOf": [super().json(), name]}


@dataclass(frozen=True)
class Names(Value):
    """Values by names that the user gives."""

    part: Value

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A dict; a part that is refused is None under its name."""
        if not isinstance(value, Mapping):
            by.refuse(
                path,
                f"this is {kind_of(value)}",
                shown(value),
                "a table",
                "write its keys in a table of that name",
            )
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


def no_list(value: Any, path: Path, by: Reading) -> None:
    """Tells that a value is no list."""
    by.refuse(path, f"this is {kind_of(value)}", shown(value), "a list", "put the values in square brackets")


LENGTH, SCALAR = Measure("m"), Measure("1")
PLACE = Each((LENGTH, LENGTH))
