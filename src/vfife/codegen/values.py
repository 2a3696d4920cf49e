"""Kinds of values in a plain function, and their conversion: truths, integers of 64 bits, numbers, arrays of these, tuples of all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..errors import SourceError

TYPES = {"b": "i1", "i": "i64", "d": "double", "u": "i32"}  # u: an item of an array, read as an integer
ORDER = "bid"  # each holds what stands before it


@dataclass(frozen=True)
class Array:
    """Kind of a contiguous array: its items (``d``, or ``u`` for unsigned integers of 32 bits) and its number of dimensions."""

    item: str
    dimensions: int


Kind = str | Array | tuple["Kind", ...]


class Value(NamedTuple):
    """A value: a kind, and the names of what it is made of. An array is its address and its shape, a tuple its values."""

    kind: Kind
    parts: tuple[str, ...]


def types_of(kind: Kind) -> list[str]:
    """LLVM's types of what a value of a kind is made of."""
    if isinstance(kind, Array):
        return ["ptr", *["i64"] * kind.dimensions]
    if isinstance(kind, tuple):
        return [one for member in kind for one in types_of(member)]
    return [TYPES[kind]]


def members(value: Value) -> list[Value]:
    """The values of a tuple."""
    if not isinstance(value.kind, tuple):
        raise SourceError("a number is taken apart like a tuple")
    found, place = [], 0
    for kind in value.kind:
        size = len(types_of(kind))
        found.append(Value(kind, value.parts[place : place + size]))
        place += size
    return found


def joined(values: list[Value]) -> Value:
    """A tuple of values."""
    return Value(tuple(value.kind for value in values), tuple(part for value in values for part in value.parts))


def wider(first: Kind, second: Kind) -> Kind:
    """The kind that holds both; SourceError where there is none."""
    if isinstance(first, tuple) and isinstance(second, tuple) and len(first) == len(second):
        return tuple(wider(a, b) for a, b in zip(first, second, strict=True))
    if isinstance(first, str) and isinstance(second, str):
        return max(first, second, key=ORDER.index)
    if first == second:
        return first
    raise SourceError("one name stands for values of two kinds")


def answered(kind: Kind) -> str:
    """LLVM's type of what a function returns."""
    types = types_of(kind)
    return types[0] if len(types) == 1 else f"{{ {', '.join(types)} }}"
