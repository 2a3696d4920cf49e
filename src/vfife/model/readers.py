"""How a value of a model file is read: quantities with limits, whole numbers, words. The schema annotates keys so."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from annotated_types import GroupedMetadata
from pydantic import PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from ..errors import QuantityError, kind_of, shown
from ..units import dimension_of, number


def refuse(value: Any, what: str, limit: str = "", remedy: str = "") -> PydanticCustomError:
    """The error of a key: what its value is ("a mass", "negative"), what is allowed, what to do."""
    ctx = {"what": f"this is {what}", "limit": limit, "remedy": remedy, "value": shown(value)}
    return PydanticCustomError("fault", "{what}", ctx)


@dataclass(frozen=True)
class Reader(GroupedMetadata):
    """Annotation of a key: how a value of the file is read, and what JSON Schema says about it."""

    def read(self, value: Any) -> Any:
        """The value as the models hold it; raises the error of :func:`refuse`."""
        raise NotImplementedError

    def json(self) -> dict[str, Any]:
        """JSON Schema of what stands in the file."""
        raise NotImplementedError

    def __iter__(self) -> Iterator[object]:
        yield PlainValidator(self.read)
        yield WithJsonSchema(self.json())


@dataclass(frozen=True)
class Measure(Reader):
    """A quantity: SI unit and limits (above, at least, at most).

    One of ``words`` may stand in its place; ``series`` allows a list of quantities as well.
    """

    unit: str
    above: float | None = None
    low: float | None = None
    high: float | None = None
    words: tuple[str, ...] = ()
    series: bool = False

    def read(self, value: Any) -> Any:
        """SI value, or one of the words."""
        if isinstance(value, str) and value in self.words:
            return value
        if self.series and isinstance(value, list | tuple):
            return tuple(self.read_one(entry) for entry in value)
        return self.read_one(value)

    def read_one(self, value: Any) -> float:
        """SI value."""
        try:
            result = number(value, self.unit)
        except QuantityError as error:
            other = f", or {shown(self.words[0])}" if self.words else ""
            raise refuse(value, error.what, error.limit + other, f"write {error.remedy}") from None
        if not self.allows(result):
            low, high = self.above if self.above is not None else self.low, self.high
            what = "too large" if high is not None and result > high else "zero or negative" if not low else "too small"
            what = "negative" if low == 0.0 and result < 0.0 else what
            example = dimension_of(self.unit)[1]
            raise refuse(value, what, self.limits(), f'correct the value or its unit (as in "{example}")')
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

    def json(self) -> dict[str, Any]:
        """A number in SI units or a text with a unit; that ``above`` itself is excluded, drafts of JSON Schema say differently."""
        low = self.above if self.above is not None else self.low
        bare: dict[str, Any] = {"type": "number"}
        bare |= {key: limit for key, limit in (("minimum", low), ("maximum", self.high)) if limit is not None}
        one: list[dict[str, Any]] = [bare, {"type": "string"}]
        more = [{"type": "array", "items": {"anyOf": one}}] if self.series else []
        return {"anyOf": [*one, *more], "x-unit": self.unit, "x-limits": self.limits()}


@dataclass(frozen=True)
class Whole(Reader):
    """A whole number between two limits; the upper one catches typing errors."""

    low: int
    high: int

    def read(self, value: Any) -> int:
        """The number."""
        limit = f"a whole number from {self.low} to {self.high}"
        if isinstance(value, float) and math.isfinite(value) and value == int(value):
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise refuse(value, kind_of(value), limit, "write a whole number without quotes")
        if not self.low <= value <= self.high:
            raise refuse(value, "too small" if value < self.low else "too large", limit, "correct the number")
        return value

    def json(self) -> dict[str, Any]:
        """A whole number."""
        return {"type": "integer", "minimum": self.low, "maximum": self.high}


@dataclass(frozen=True)
class Choice(Reader):
    """One of some words; ``beside`` are words that another kind of table has for this key."""

    options: tuple[str, ...]
    beside: tuple[str, ...] = ()

    def read(self, value: Any) -> str:
        """The word."""
        if isinstance(value, str) and value in self.options:
            return value
        every = self.options + self.beside
        near = difflib.get_close_matches(value.lower(), every, 1, 0.5) if isinstance(value, str) else []
        what = "an unknown word" if isinstance(value, str) else kind_of(value)
        limit = " or ".join(shown(word) for word in every)
        raise refuse(value, what, limit, f'did you mean "{near[0]}"?' if near else "write one of these words")

    def json(self) -> dict[str, Any]:
        """One of the words."""
        return {"enum": list(self.options)}
