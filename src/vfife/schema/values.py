"""What a field without parts holds: quantities, whole numbers, words, texts, switches."""

from __future__ import annotations

import difflib
import math
import numbers
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import Fault, Path, kind_of, shown
from ..units import dimension_of, number

if TYPE_CHECKING:
    from .described import Reading

Json = dict[str, Any]
# Least and largest size of a quantity, by SI unit: what is beyond can only be a slip of units.
SIZES = {
    "m": (1e-12, 1e12),
    "s": (1e-15, 1e12),
    "kg": (1e-18, 1e15),
    "1": (1e-20, 1e14),
    "rad": (1e-15, 1e12),
    "rad/s": (1e-15, 1e9),
    "m/s": (1e-15, 3e8),
    "": (1e-40, 1e40),
}
WEIGHED = ("kg", "kg m^2")  # none or a sound one: nobody's mass is left over from rounding


@dataclass(frozen=True)
class Value:
    """What a field holds, and how it is read."""

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """The value as the noun holds it, None where it is refused, which ``by`` is told."""
        try:
            return self.take(value, by.written)
        except Fault as fault:
            by.add(fault.at(path))
            return None

    def take(self, value: Any, written: bool) -> Any:
        """The value of a field without parts. Raises Fault."""
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
    """A quantity: SI unit and limits (above, at least, at most). One of ``words`` may stand in its place;
    ``series`` allows several as well.
    """

    unit: str
    above: float | None = None
    low: float | None = None
    high: float | None = None
    words: tuple[str, ...] = ()
    series: bool = False

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """SI value, one of the words, or a tuple of values."""
        if self.series and is_list(value):
            return (
                None
                if any_none(parts := [Value.read(self, one, path, by) for one in value])
                else tuple(parts)
            )
        return super().read(value, path, by)

    def take(self, value: Any, written: bool) -> Any:
        """SI value, or one of the words."""
        if isinstance(value, str) and value in self.words:
            return value
        other = f", or {shown(self.words[0])}" if self.words else ""
        try:
            if not written and not (isinstance(value, numbers.Real) and not isinstance(value, bool)):
                raise Fault("", kind_of(value), shown(value), *spoken_limit(self.unit))
            plain = not written or (
                isinstance(value, numbers.Real) and not isinstance(value, int | float)
            )  # a number of NumPy
            result = number(float(value) if plain else value, self.unit)
        except Fault as error:
            remedy = error.remedy if error.remedy.startswith("give") else f"write {error.remedy}"
            raise Fault("", f"this is {error.what}", shown(value), error.limit + other, remedy) from None
        if fault := beyond(result, self.unit, self.above == 0.0 or self.unit in WEIGHED):
            remedy = (
                f'correct the value or its unit (as in "{dimension_of(self.unit)[1]}")'
                if self.unit != "1"
                else "correct the value"
            )
            raise Fault("", f"this is {fault[0]} for any mechanism", shown(value), fault[1], remedy)
        if not self.allows(result):
            low, high = self.above if self.above is not None else self.low, self.high
            what = (
                "too large"
                if high is not None and result > high
                else "zero or negative"
                if not low
                else "too small"
            )
            what = "negative" if low == 0.0 and result < 0.0 else what
            of_unit = (
                f' or its unit (as in "{dimension_of(self.unit)[1]}")'
                if written
                else f", which is in {self.unit}"
            )
            remedy = "correct the value" if self.unit == "1" else f"correct the value{of_unit}"
            raise Fault("", f"this is {what}", shown(value), self.limits(), remedy)
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
        """A number in SI units or a text with a unit; that ``above`` itself is excluded, drafts of JSON
        Schema say differently.
        """
        low = self.above if self.above is not None else self.low
        bare: Json = {"type": "number"}
        bare |= {key: limit for key, limit in (("minimum", low), ("maximum", self.high)) if limit is not None}
        one: list[Json] = [bare, {"type": "string"}]
        lists = [{"type": "array", "items": {"anyOf": one}}] if self.series else []
        return {"anyOf": [*one, *lists], "x-unit": self.unit, "x-limits": self.limits()}

    def units(self) -> Iterator[str]:
        """Unit and limits."""
        yield ", ".join(
            part for part in ("a number" if self.unit == "1" else self.unit, self.limits()) if part
        )


@dataclass(frozen=True)
class Integer(Value):
    """A whole number between two limits; the upper one catches typing errors. One of ``words`` may stand in
    its place.
    """

    low: int
    high: int
    words: tuple[str, ...] = ()

    def take(self, value: Any, written: bool) -> int | str:
        """The number, or one of the words."""
        if isinstance(value, str) and value in self.words:
            return value
        limit = f"a whole number from {self.low} to {self.high}" + (
            f", or {shown(self.words[0])}" if self.words else ""
        )
        if isinstance(value, float) and math.isfinite(value) and value == int(value):
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int | numbers.Integral):
            raise Fault(
                "",
                f"this is {kind_of(value)}",
                shown(value),
                limit,
                "write a whole number without quotes" if written else "give one",
            )
        result = int(value)
        if not self.low <= result <= self.high:
            raise Fault(
                "",
                f"this is {'too small' if result < self.low else 'too large'}",
                shown(value),
                limit,
                "correct the number",
            )
        return result

    def json(self) -> Json:
        """A whole number."""
        bare: Json = {"type": "integer", "minimum": self.low, "maximum": self.high}
        return {"anyOf": [bare, {"enum": list(self.words)}]} if self.words else bare

    def units(self) -> Iterator[str]:
        """Its limits."""
        yield f"a whole number from {self.low} to {self.high}"


@dataclass(frozen=True)
class Choice(Value):
    """One of some words; ``others`` are words that another kind of table has for this key."""

    options: tuple[str, ...]
    others: tuple[str, ...] = ()

    def take(self, value: Any, written: bool) -> str:
        """The word."""
        if isinstance(value, str) and value in self.options:
            return value
        every = self.options + self.others
        near = difflib.get_close_matches(value.lower(), every, 1, 0.5) if isinstance(value, str) else []
        what = "an unknown word" if isinstance(value, str) else kind_of(value)
        limit = " or ".join(shown(word) for word in every)
        remedy = (
            f'did you mean "{near[0]}"?' if near else f"{'write' if written else 'give'} one of these words"
        )
        raise Fault("", f"this is {what}", shown(value), limit, remedy)

    def json(self) -> Json:
        """One of the words."""
        return {"enum": list(self.options)}


@dataclass(frozen=True)
class Text(Value):
    """Any text; in a reference a ``pin`` ("body.pin" or "ground.point"), a ``body`` or a ``joint``, or
    Python's object with this name.
    """

    refers: str = ""

    def take(self, value: Any, written: bool) -> str:
        """The text."""
        if self.refers and written and not isinstance(value, str):
            value = getattr(value, "name", value)
        if not isinstance(value, str):
            raise Fault("", f"this is {kind_of(value)}", shown(value), "a text", "put it in quotes")
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
            raise Fault("", f"this is {kind_of(value)}", shown(value), "true or false", remedy)
        return value

    def json(self) -> Json:
        """true or false."""
        return {"type": "boolean"}


def beyond(value: float, unit: str, sized: bool) -> tuple[str, str] | None:
    """What is wrong with the size of a quantity of a unit, and what is allowed; None where it can be meant.

    What may be zero may be as small as rounding leaves it; what is ``sized`` may not (nor a mass, beside
    zero).
    """
    least, most = SIZES.get(unit, SIZES[""])
    size, unit_text = abs(value), "" if unit == "1" else f" {unit}"
    if size > most:
        return "too large", f"at most {most:g}{unit_text} in size"
    if sized and 0.0 < size < least:
        return "too small", f"at least {least:g}{unit_text}"
    return None


def spoken_limit(unit: str) -> tuple[str, str]:
    """What Python may give in a unit, and how."""
    words, _ = dimension_of(unit)
    return words, "give a number" if unit == "1" else f"give a number in {unit}"


def is_list(value: Any) -> bool:
    """Whether a value is a list, a tuple or an array."""
    return isinstance(value, list | tuple) or (hasattr(value, "__array__") and getattr(value, "ndim", 0) > 0)


def any_none(values: Iterable[Any]) -> bool:
    """Whether one of the values was refused."""
    return any(value is None for value in values)
