"""Types of fields without parts: quantities, whole numbers, words, texts, truth values."""

from __future__ import annotations

import difflib
import math
import numbers
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from ..errors import Fault, Path, shown, value_fault
from ..units import dimension_of, number

if TYPE_CHECKING:
    from .described import Reader

Json = dict[str, Any]
# Smallest and largest plausible size of a quantity, by SI unit; others are mistakes in the unit.
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
WEIGHED = ("kg", "kg m^2")  # zero or a plausible size: no mass is a rounding error


@dataclass(frozen=True)
class Value:
    """Type of a field: how its value is read, and its JSON Schema."""

    forms: ClassVar[tuple[type, ...]] = ()  # types of a value with parts in a file; none for a single value

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return the value as the object holds it; None, with a fault in ``by``, if it is invalid."""
        try:
            return self.take(value, by.written)
        except Fault as fault:
            by.add(fault.at(path))
            return None

    def take(self, value: Any, written: bool) -> Any:
        """Return the value of a field without parts. Raises Fault."""
        return value

    def suits(self, value: Any) -> bool:
        """Return whether a value of a file has the right form."""
        return isinstance(value, self.forms) if self.forms else not isinstance(value, list | dict)

    def json(self) -> Json:
        """Return the JSON Schema of the value in a file."""
        return {}

    def units(self) -> Iterator[str]:
        """Yield units and limits as text."""
        return iter(())


@dataclass(frozen=True)
class Measure(Value):
    """A quantity with SI unit and limits (greater than, at least, at most). One of ``words`` may replace it;
    ``series`` allows several values.
    """

    unit: str
    above: float | None = None
    low: float | None = None
    high: float | None = None
    words: tuple[str, ...] = ()
    series: bool = False

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return an SI value, a word, or a tuple of values."""
        if self.series and is_list(value):
            if any_none(parts := [Value.read(self, entry, path, by) for entry in value]):
                return None
            by.same_units(value, path, self.unit)
            return tuple(parts)
        return super().read(value, path, by)

    def take(self, value: Any, written: bool) -> Any:
        """Return an SI value or a word."""
        if isinstance(value, str) and value in self.words:
            return value
        if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
            value = value.item()  # an array of NumPy without dimensions is a number
        alternative = f", or {shown(self.words[0])}" if self.words else ""
        if not written and (isinstance(value, bool) or not isinstance(value, numbers.Real)):
            remedy = "give a number" if self.unit == "1" else f"give a number in {self.unit}"
            raise value_fault(value, dimension_of(self.unit)[0] + alternative, remedy)
        # Numbers of NumPy are no int or float, but numbers.Real.
        plain = not written or (isinstance(value, numbers.Real) and not isinstance(value, int | float))
        try:
            result = number(float(value) if plain else value, self.unit)
        except Fault as error:
            remedy = f"write {error.remedy}"
            raise value_fault(value, error.limit + alternative, remedy, error.what) from None
        if fault := implausible_size(result, self.unit, self.above == 0.0 or self.unit in WEIGHED):
            raise value_fault(value, fault[1], self.remedy(True), f"{fault[0]} for any mechanism")
        if not self.allows(result):
            low, high = self.above if self.above is not None else self.low, self.high
            problem = (
                "too large"
                if high is not None and result > high
                else "zero or negative"
                if not low
                else "too small"
            )
            problem = "negative" if low == 0.0 and result < 0.0 else problem
            raise value_fault(value, self.limits(), self.remedy(written), problem)
        return result

    def allows(self, result: float) -> bool:
        """Return whether a value is within the limits."""
        return (
            (self.above is None or result > self.above)
            and (self.low is None or result >= self.low)
            and (self.high is None or result <= self.high)
        )

    def remedy(self, written: bool) -> str:
        """Return the remedy for a value outside its limits; ``written``: it may have a unit."""
        if self.unit == "1":
            return "correct the value"
        if written:
            return f'correct the value or its unit (as in "{dimension_of(self.unit)[1]}")'
        return f"correct the value, which is in {self.unit}"

    def limits(self) -> str:
        """Return the limits as text."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        parts = ((self.above, "above"), (self.low, "at least"), (self.high, "at most"))
        return " and ".join(f"{word} {limit:g}{unit}" for limit, word in parts if limit is not None)

    def suits(self, value: Any) -> bool:
        """Return whether a value is a number or text; for a series also a list."""
        return super().suits(value) or (self.series and isinstance(value, list))

    def json(self) -> Json:
        """Return the schema of a number in SI units or a text with a unit. It cannot exclude the limit
        ``above`` itself, because drafts of JSON Schema disagree on that.
        """
        low = self.above if self.above is not None else self.low
        bare: Json = {"type": "number"}
        bare |= {key: limit for key, limit in (("minimum", low), ("maximum", self.high)) if limit is not None}
        forms: list[Json] = [bare, {"type": "string"}]
        lists = [{"type": "array", "items": {"anyOf": forms}}] if self.series else []
        return {"anyOf": [*forms, *lists], "x-unit": self.unit, "x-limits": self.limits()}

    def units(self) -> Iterator[str]:
        """Yield unit and limits."""
        yield ", ".join(
            part for part in ("a number" if self.unit == "1" else self.unit, self.limits()) if part
        )


@dataclass(frozen=True)
class Share(Measure):
    """A small share of something, of which a bare 1 (100 %) is too much; the refusal asks whether so many per
    cent are meant.
    """

    unit: str = "1"

    def take(self, value: Any, written: bool) -> Any:
        """Return the share (1)."""
        try:
            return super().take(value, written)
        except Fault as fault:
            if not fault.what.endswith("too large") or "%" in str(value):
                raise
            bare = number(value, self.unit) if isinstance(value, str) else float(value)
            share = bare / 100.0
            question = f'; is "{bare:g} %" meant?' if self.allows(share) else ""
            remedy = f"this is {100.0 * bare:g} %{question}"
            raise value_fault(value, self.limits(), remedy, "too large") from None


@dataclass(frozen=True)
class Integer(Value):
    """A whole number between two limits, the upper one to catch typing errors. One of ``words`` may replace
    it.
    """

    low: int
    high: int
    words: tuple[str, ...] = ()

    def take(self, value: Any, written: bool) -> int | str:
        """Return the number or word."""
        if isinstance(value, str) and value in self.words:
            return value
        limit = f"a whole number from {self.low} to {self.high}" + (
            f", or {shown(self.words[0])}" if self.words else ""
        )
        if isinstance(value, float) and math.isfinite(value) and value == int(value):
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int | numbers.Integral):
            remedy = "write a whole number without quotes" if written else "give one"
            raise value_fault(value, limit, remedy)
        result = int(value)
        if not self.low <= result <= self.high:
            problem = "too small" if result < self.low else "too large"
            raise value_fault(value, limit, "correct the number", problem)
        return result

    def json(self) -> Json:
        """Return the schema of a whole number."""
        bare: Json = {"type": "integer", "minimum": self.low, "maximum": self.high}
        return {"anyOf": [bare, {"enum": list(self.words)}]} if self.words else bare

    def units(self) -> Iterator[str]:
        """Yield the limits."""
        yield f"a whole number from {self.low} to {self.high}"


@dataclass(frozen=True)
class Choice(Value):
    """One of some words; ``foreign`` are those that other kinds of table have for this key."""

    options: tuple[str, ...]
    foreign: tuple[str, ...] = ()

    def take(self, value: Any, written: bool) -> str:
        """Return the word."""
        if isinstance(value, str) and value in self.options:
            return value
        words = self.options + self.foreign
        similar = difflib.get_close_matches(value.lower(), words, 1, 0.5) if isinstance(value, str) else []
        problem = "an unknown word" if isinstance(value, str) else ""
        limit = " or ".join(shown(word) for word in words)
        remedy = (
            f'did you mean "{similar[0]}"?'
            if similar
            else f"{'write' if written else 'give'} one of these words"
        )
        raise value_fault(value, limit, remedy, problem)

    def json(self) -> Json:
        """Return the schema of the words."""
        return {"enum": list(self.options)}


@dataclass(frozen=True)
class Text(Value):
    """A text; a reference (``refers``) to a ``pin`` ("body.pin" or "ground.point"), ``body`` or ``joint`` may
    also be the Python object of that name.
    """

    refers: str = ""

    def take(self, value: Any, written: bool) -> str:
        """Return the text."""
        if self.refers and written and not isinstance(value, str):
            value = getattr(value, "name", value)
        if not isinstance(value, str):
            raise value_fault(value, "a text", "put it in quotes")
        return value

    def json(self) -> Json:
        """Return the schema of a text."""
        return {"type": "string"}


@dataclass(frozen=True)
class Switch(Value):
    """true or false."""

    def take(self, value: Any, written: bool) -> bool:
        """Return the truth value."""
        if not isinstance(value, bool):
            remedy = "write it without quotes" if written else "give True or False"
            raise value_fault(value, "true or false", remedy)
        return value

    def json(self) -> Json:
        """Return the schema of a truth value."""
        return {"type": "boolean"}


def implausible_size(value: float, unit: str, sized: bool) -> tuple[str, str] | None:
    """Return what is wrong with the size of a quantity in a unit, and what is allowed; None if it is
    plausible.

    A quantity that may be zero may also be as small as rounding leaves it, but not one that is ``sized``, nor
    a mass other than zero.
    """
    smallest, largest = SIZES.get(unit, SIZES[""])
    size, unit_text = abs(value), "" if unit == "1" else f" {unit}"
    if size > largest:
        return "too large", f"at most {largest:g}{unit_text} in size"
    if sized and 0.0 < size < smallest:
        return "too small", f"at least {smallest:g}{unit_text}"
    return None


def is_list(value: Any) -> bool:
    """Return whether a value is a list, a tuple or an array."""
    return isinstance(value, list | tuple) or (hasattr(value, "__array__") and getattr(value, "ndim", 0) > 0)


def any_none(values: Iterable[Any]) -> bool:
    """Return whether one of the values is None."""
    return any(value is None for value in values)
