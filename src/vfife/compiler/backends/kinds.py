"""Kinds of values in a plain function, and their types in LLVM's language: truth values, 64-bit integers,
doubles, arrays of these, and tuples of all of them.

Python's values carry their kinds; compiled ones do not. A function is therefore written once for each list of
kinds with which it is called.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ...kernels import advance as kernel
from ...kernels.arrays import Counts, Integers, Numbers

# LLVM's types of truth values, integers, doubles, and of items of arrays of unsigned 32-bit (u) and 64-bit
# integers (l), which are read as integers.
TYPES = {"b": "i1", "i": "i64", "d": "double", "u": "i32", "l": "i64"}


@dataclass(frozen=True)
class Array:
    """Kind of a contiguous array: its items (``d`` doubles, ``l`` 64-bit integers, ``u`` unsigned 32-bit
    integers) and its number of dimensions.
    """

    item: str
    dimensions: int


Kind = str | Array | tuple["Kind", ...]


class External(NamedTuple):
    """A function of another module: the kinds of its arguments, the indices of the parts that are passed, and
    the kind of its answer.
    """

    kinds: tuple[Kind, ...]
    passed: tuple[int, ...]
    answer: Kind | None = None

    def declared(self, name: str) -> str:
        """Return the declaration of the function."""
        types = types_of(self.kinds)
        answer = "void" if self.answer is None else answered(self.answer)
        return f"declare {answer} @{name}({', '.join(types[k] for k in self.passed)})\n"


class Value(NamedTuple):
    """A value: its kind, and the names of its parts in LLVM's text.

    The parts of an array are its address and its shape, those of a tuple the parts of its values.
    """

    kind: Kind
    parts: tuple[str, ...]


def types_of(kind: Kind) -> list[str]:
    """Return LLVM's types of the parts of a value of this kind."""
    if isinstance(kind, Array):
        return ["ptr", *["i64"] * kind.dimensions]
    if isinstance(kind, tuple):
        return [part_type for member in kind for part_type in types_of(member)]
    return [TYPES[kind]]


def members(value: Value) -> list[Value]:
    """Return the values of a tuple."""
    values, place = [], 0
    for kind in value.kind if isinstance(value.kind, tuple) else ():
        size = len(types_of(kind))
        values.append(Value(kind, value.parts[place : place + size]))
        place += size
    return values


def joined(values: list[Value]) -> Value:
    """Return a tuple of values."""
    return Value(
        tuple(value.kind for value in values), tuple(part for value in values for part in value.parts)
    )


def answered(kind: Kind) -> str:
    """Return LLVM's type of a function's answer of this kind."""
    types = types_of(kind)
    return types[0] if len(types) == 1 else f"{{ {', '.join(types)} }}"


NOUNS = {"b": "a truth", "i": "an integer", "d": "a number"}


def named(kind: Kind) -> str:
    """Return a kind in words, for messages."""
    if isinstance(kind, Array):
        return "an array"
    return NOUNS[kind] if isinstance(kind, str) else f"({', '.join(map(named, kind))})"


class Entry(NamedTuple):
    """A function that is called from outside: kinds of its arguments, and whether it returns an integer."""

    kinds: tuple[Kind, ...]
    returns: bool = False


ITEMS = {"f": "d", "u": "u", "l": "l"}


def entry_of(words: str) -> Entry:
    """Return an entry from words for the kinds of its arguments: ``d`` a double, ``i`` an integer, ``f2`` a
    two-dimensional array of doubles, ``u1`` and ``l1`` arrays of unsigned 32-bit and of 64-bit integers.
    """
    return Entry(
        tuple(Array(ITEMS[word[0]], int(word[1:])) if word[0] in ITEMS else word for word in words.split())
    )


ANNOTATED: dict[Any, Kind] = {
    int: "i",
    float: "d",
    Numbers: Array("d", 1),
    Integers: Array("u", 1),
    Counts: Array("l", 1),
}


def annotated(function: Callable[..., Any]) -> Entry:
    """Return the entry of a function with annotations; a NamedTuple is one argument, with its fields."""
    annotations = dict(function.__annotations__)
    returns = annotations.pop("return", None) is not None
    return Entry(
        tuple(
            ANNOTATED[annotation] if annotation in ANNOTATED else annotated(annotation).kinds
            for annotation in annotations.values()
        ),
        returns,
    )


# The loop driver's functions.
ENTRIES = {function.__name__: annotated(function) for function in (kernel.advance, kernel.stream)}
