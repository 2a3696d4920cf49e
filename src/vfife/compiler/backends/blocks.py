"""What a function in LLVM's language is made of: instructions, blocks, places in memory, conversions.

Kinds of values in a plain function, and what they are made of: truths, integers of 64 bits, numbers, arrays
of these, tuples of all of them.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import NamedTuple, NoReturn

from ...errors import SourceError

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
    found, place = [], 0
    for kind in value.kind if isinstance(value.kind, tuple) else ():
        size = len(types_of(kind))
        found.append(Value(kind, value.parts[place : place + size]))
        place += size
    return found


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


class Blocks:
    """The text of a function as it grows: what makes room comes ``first``, all else is in ``out``."""

    def __init__(self, name: str) -> None:
        self.name, self.line = name, 1
        self.begin_anew()

    def begin_anew(self) -> None:
        """Nothing is written yet."""
        self.first: list[str] = []
        self.out: list[str] = []
        self.count, self.ended = 0, False

    def fresh(self, text: str) -> str:
        """A name of its own for what an instruction gives."""
        self.count += 1
        self.out.append(f"  %x{self.count} = {text}")
        return f"%x{self.count}"

    def label(self, name: str) -> str:
        """A name of its own for a block."""
        self.count += 1
        return f"{name}{self.count}"

    def begin(self, label: str) -> None:
        """A block begins."""
        self.out.append(f"{label}:")
        self.ended = False

    def go(self, label: str) -> None:
        """The block ends, and goes on there."""
        if not self.ended:
            self.out.append(f"  br label %{label}")
        self.ended = True

    def fork(self, truth: str, yes: str, no: str) -> None:
        """The block ends with a choice."""
        self.out.append(f"  br i1 {truth}, label %{yes}, label %{no}")
        self.ended = True

    def room(self, kind: Kind) -> Value:
        """Places in memory for a value, which LLVM turns into registers."""
        names = []
        for one in types_of(kind):
            self.count += 1
            self.first.append(f"  %p{self.count} = alloca {one}")
            names.append(f"%p{self.count}")
        return Value(kind, tuple(names))

    def store(self, place: Value, value: Value) -> None:
        """Puts a value in its place."""
        for one, where, part in zip(types_of(place.kind), place.parts, value.parts, strict=True):
            self.out.append(f"  store {one} {part}, ptr {where}")

    def load(self, place: Value) -> Value:
        """The value in a place."""
        parts = zip(types_of(place.kind), place.parts, strict=True)
        return Value(place.kind, tuple(self.fresh(f"load {one}, ptr {where}") for one, where in parts))

    def same(self, node: ast.AST, first: Kind, second: Kind) -> Kind:
        """The kind of two values, which have to be of one: 0 is no 0.0, whose negative has a sign."""
        if first != second:
            self.refuse(
                node,
                f"one is {named(first)}, the other {named(second)}; write both as one kind, such as 0.0"
                " for 0",
            )
        return first

    def refuse(self, node: ast.AST, reason: str) -> NoReturn:
        """Raise SourceError with function, line of its text, what stands there and why it cannot be
        translated exactly.
        """
        line = getattr(node, "lineno", self.line) - self.line + 1
        raise SourceError(f"{self.name}, line {line}: {ast.unparse(node).splitlines()[0]!r}: {reason}")

    def _unknown(self, node: ast.AST) -> NoReturn:
        self.refuse(node, "this is no part of the language that is compiled")
