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
        types = [one for kind in self.kinds for one in types_of(kind)]
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
        return [one for member in kind for one in types_of(member)]
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


# Words for kinds, by the types of annotations; those of arrays begin with a letter for their items.
WORDS: dict[Any, str] = {int: "i", float: "d", Numbers: "f1", Integers: "u1", Counts: "l1"}
ITEMS = {"f": "d", "u": "u", "l": "l"}


def arguments_of(function: Callable[..., Any]) -> str:
    """Return the kinds of the annotated arguments of a function as words; a NamedTuple is one argument, with
    the kinds of its fields in brackets.
    """
    kinds = dict(function.__annotations__)
    returned = "->" if kinds.pop("return", None) is not None else ""
    return returned + " ".join(
        WORDS[one] if one in WORDS else f"({arguments_of(one)})" for one in kinds.values()
    )


def listed(arguments: str) -> list[str]:
    """Return the kinds of the arguments one by one, with the fields of NamedTuples in their places."""
    return arguments.removeprefix("->").replace("(", "").replace(")", "").split()


def kinds_of(arguments: str) -> list[Any]:
    """Return the kinds for which words stand."""
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
