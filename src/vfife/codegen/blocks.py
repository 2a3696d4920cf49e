"""What a function in LLVM's language is made of: instructions, blocks, places in memory, conversions."""

from __future__ import annotations

import ast
from typing import NoReturn

from ..errors import SourceError
from .values import Kind, Value, named, types_of


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
            self.refuse(node, f"one is {named(first)}, the other {named(second)}; write both as one kind, such as 0.0 for 0")
        return first

    def refuse(self, node: ast.AST, reason: str) -> NoReturn:
        """Raise SourceError with function, line of its text, what stands there and why it cannot be translated exactly."""
        line = getattr(node, "lineno", self.line) - self.line + 1
        raise SourceError(f"{self.name}, line {line}: {ast.unparse(node).splitlines()[0]!r}: {reason}")

    def _unknown(self, node: ast.AST) -> NoReturn:
        self.refuse(node, "this is no part of the language that is compiled")
