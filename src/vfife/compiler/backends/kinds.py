"""What a function in LLVM's language is made of: instructions, blocks, places in memory, conversions.

Kinds of values in a plain function, and what they are made of: truths, integers of 64 bits, numbers, arrays
of these, tuples of all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ...kernels import advance as kernel
from ...kernels.arrays import Counts, Integers, Numbers

TYPES = {
    "b": "i1",
    "i": "i64",
    "d": "double",
    "u": "i32",
    "l": "i64",
}  # u, l: items of arrays, read as integers


@dataclass(frozen=True)
class Array:
    """Kind of a contiguous array: its items (``d``, ``l`` for integers of 64 bits, ``u`` for unsigned ones of
    32) and its number of dimensions.
    """

    item: str
    dimensions: int


Kind = str | Array | tuple["Kind", ...]


class External(NamedTuple):
    """A function of another module: kinds of its arguments, which of their parts it is called with, and the
    kind of what it returns.
    """

    kinds: tuple[Kind, ...]
    passed: tuple[int, ...]
    answer: Kind | None = None

    def declared(self, name: str) -> str:
        """Its declaration."""
        types = [one for kind in self.kinds for one in types_of(kind)]
        answer = "void" if self.answer is None else answered(self.answer)
        return f"declare {answer} @{name}({', '.join(types[k] for k in self.passed)})\n"


class Value(NamedTuple):
    """A value: a kind, and the names of what it is made of.

    An array is its address and its shape, a tuple its values.
    """

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
    values, place = [], 0
    for kind in value.kind if isinstance(value.kind, tuple) else ():
        size = len(types_of(kind))
        values.append(Value(kind, value.parts[place : place + size]))
        place += size
    return values


def joined(values: list[Value]) -> Value:
    """A tuple of values."""
    return Value(
        tuple(value.kind for value in values), tuple(part for value in values for part in value.parts)
    )


def answered(kind: Kind) -> str:
    """LLVM's type of what a function returns."""
    types = types_of(kind)
    return types[0] if len(types) == 1 else f"{{ {', '.join(types)} }}"


NOUNS = {"b": "a truth", "i": "an integer", "d": "a number"}


def named(kind: Kind) -> str:
    """A kind in words."""
    if isinstance(kind, Array):
        return "an array"
    return NOUNS[kind] if isinstance(kind, str) else f"({', '.join(map(named, kind))})"


# Words for kinds, by the types of annotations; those of arrays begin with a letter for their items.
WORDS: dict[Any, str] = {int: "i", float: "d", Numbers: "f1", Integers: "u1", Counts: "l1"}
ITEMS = {"f": "d", "u": "u", "l": "l"}


def arguments_of(function: Callable[..., Any]) -> str:
    """Kinds of the arguments of a function that are annotated; a NamedTuple is one argument, with the kinds
    of its fields in brackets.
    """
    kinds = dict(function.__annotations__)
    returned = "->" if kinds.pop("return", None) is not None else ""
    return returned + " ".join(
        WORDS[one] if one in WORDS else f"({arguments_of(one)})" for one in kinds.values()
    )


def listed(arguments: str) -> list[str]:
    """Kinds of the arguments one by one, those of a NamedTuple too."""
    return arguments.removeprefix("->").replace("(", "").replace(")", "").split()


def kinds_of(arguments: str) -> list[Any]:
    """The kinds that words stand for."""
    kinds: list[Any] = []
    for word in arguments.removeprefix("->").replace("(", "( ").replace(")", " )").split():
        if word == "(":
            outer, kinds = kinds, []
        elif word == ")":
            kinds = [*outer, tuple(kinds)]
        else:
            kinds.append(Array(ITEMS[word[0]], int(word[1:])) if word[0] in ITEMS else word)
    return kinds


# The loop driver's functions, and the kinds of their arguments.
ENTRIES = {function.__name__: arguments_of(function) for function in (kernel.advance, kernel.stream)}
