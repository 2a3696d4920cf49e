"""Types of fields with parts: lists, tables by name, nested objects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from ..errors import Path, shown
from .values import Json, Measure, Value, any_none, is_list

if TYPE_CHECKING:
    from .described import Reader

# Limits and remedies of values of another type.
A_LIST = ("a list", "put the values in square brackets")
A_TABLE = ("a table", "write its keys in a table of that name")


@dataclass(frozen=True)
class FixedList(Value):
    """A list of fixed length with a type for each part."""

    forms = (list,)

    parts: tuple[Value, ...]

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return a tuple, with None for an invalid part."""
        if not is_list(value):
            by.unexpected(path, value, f"a list of {len(self.parts)} values", A_LIST[1])
            return None
        parts = [
            part.read(entry, (*path, k), by)
            for k, (part, entry) in enumerate(zip(self.parts, value, strict=False))
        ]
        for k in range(len(parts), len(self.parts)):
            by.refuse((*path, k), "this value of the list is missing", remedy="give the list all its values")
        if len(value) > len(self.parts):
            by.refuse(
                path,
                "too many values",
                shown(value),
                f"{len(self.parts)} values",
                "remove the surplus values",
            )
        return None if any_none(parts) or len(value) != len(self.parts) else tuple(parts)

    def json(self) -> Json:
        """Return the schema of a list of that length."""
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
        """Yield the units of the parts."""
        for part in self.parts:
            yield from part.units()


@dataclass(frozen=True)
class Direction(FixedList):
    """A direction in the plane, of any length above 0."""

    parts: tuple[Value, ...] = (Measure("1"), Measure("1"))

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return a pair of numbers."""
        parts = super().read(value, path, by)
        if parts is not None and max(map(abs, parts)) < 1e-9:
            remedy = "give it a part along x or y, as in [1, 0]"
            by.refuse(path, "this direction has no length", shown(value), "", remedy)
            return None
        return parts


@dataclass(frozen=True)
class FreeList(Value):
    """A list of any length with parts of one type."""

    forms: ClassVar[tuple[type, ...]] = (list,)

    part: Value

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return a tuple, with None for an invalid part; objects with faults keep their valid fields."""
        if not is_list(value):
            by.unexpected(path, value, *A_LIST)
            return None
        parts = tuple(self.part.read(entry, (*path, k), by) for k, entry in enumerate(value))
        if isinstance(self.part, Measure) and not any_none(parts):
            by.same_units(value, path, self.part.unit)
        return parts if isinstance(self.part, Inner) or not any_none(parts) else None

    def json(self) -> Json:
        """Return the schema of a list."""
        return {"type": "array", "items": self.part.json()}

    def units(self) -> Iterator[str]:
        """Yield the units of the parts."""
        return self.part.units()


@dataclass(frozen=True)
class Curve(FreeList):
    """Points of a curve with ``columns`` and units; in a file also the name of a CSV file, whose numbers
    replace it.
    """

    forms = (list, str)

    columns: tuple[str, str] = ("", "")

    @property
    def unit(self) -> str:
        """Both units."""
        return ", ".join(self.part.units())

    def json(self) -> Json:
        """Return the schema of a list of points or a file name."""
        name = {
            "type": "string",
            "description": f"a CSV file beside the model with the columns {', '.join(self.columns)}",
        }
        return {"anyOf": [super().json(), name]}


@dataclass(frozen=True)
class Names(Value):
    """Values by names that the user chooses."""

    forms = (dict,)

    part: Value

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return a dict, with None for an invalid part."""
        if not isinstance(value, Mapping):
            by.unexpected(path, value, *A_TABLE)
            return None
        return {name: self.part.read(entry, (*path, name), by) for name, entry in value.items()}

    def json(self) -> Json:
        """Return the schema of a table with any keys."""
        return {"type": "object", "additionalProperties": self.part.json()}

    def units(self) -> Iterator[str]:
        """Yield the units of the parts."""
        return self.part.units()


@dataclass(frozen=True)
class Inner(Value):
    """An object nested in another."""

    forms = (dict,)

    model_class: type

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return the object."""
        return by.inner(path, self.model_class, value)

    def json(self) -> Json:
        """Return the schema of its table."""
        return {"$ref": f"#/definitions/{self.model_class.__name__}Table"}


@dataclass(frozen=True)
class Named(Value):
    """An object that a file refers to by name, such as a material."""

    model_class: type

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return the object."""
        return by.named(path, self.model_class, value)

    def json(self) -> Json:
        """Return the schema of a name."""
        return {"type": "string"}


@dataclass(frozen=True)
class Chosen(Value):
    """A law from the registry of ``base``."""

    forms = (dict,)

    base: type
    word: str

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return the law."""
        return by.chosen(path, self.base, value)

    def json(self) -> Json:
        """Return the schema of the table of any of the laws."""
        return {"allOf": [{"$ref": f"#/definitions/{self.word}_law"}]}


@dataclass(frozen=True)
class Entries(Value):
    """Objects by name, of one class or of those in the registry of ``base``."""

    forms = (dict,)

    base: type


LENGTH, SCALAR = Measure("m"), Measure("1")
PLACE = FixedList((LENGTH, LENGTH))
