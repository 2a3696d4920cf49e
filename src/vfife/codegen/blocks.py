"""What a function in LLVM's language is made of: instructions, blocks, places in memory, conversions."""

from __future__ import annotations

import ast
from typing import Any

from ..errors import SourceError
from .llvm import literal
from .values import Kind, Value, joined, members, types_of


class Blocks:
    """The text of a function as it grows: what makes room comes ``first``, all else is in ``out``."""

    def __init__(self, name: str) -> None:
        self.name = name
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
        value = self.convert(value, place.kind)
        for one, where, part in zip(types_of(place.kind), place.parts, value.parts, strict=True):
            self.out.append(f"  store {one} {part}, ptr {where}")

    def load(self, place: Value) -> Value:
        """The value in a place."""
        parts = zip(types_of(place.kind), place.parts, strict=True)
        return Value(place.kind, tuple(self.fresh(f"load {one}, ptr {where}") for one, where in parts))

    def convert(self, value: Value, kind: Kind) -> Value:
        """The value as one of a wider kind."""
        if value.kind == kind:
            return value
        if isinstance(kind, tuple):
            return joined([self.convert(one, to) for one, to in zip(members(value), kind, strict=True)])
        (part,) = value.parts
        if value.kind == "b" and kind == "i":
            return Value(kind, (self.fresh(f"zext i1 {part} to i64"),))
        if value.kind in ("b", "i") and kind == "d":
            if part.lstrip("-").isdigit():
                return Value(kind, (literal(float(part)),))
            return Value(kind, (self.fresh(f"{'uitofp i1' if value.kind == 'b' else 'sitofp i64'} {part} to double"),))
        raise SourceError(f"{self.name}: a value of kind {value.kind} is used as one of kind {kind}")

    def _refused(self, node: ast.AST) -> Any:
        raise SourceError(f"{self.name}: {ast.unparse(node)!r} is more than a plain function of numbers may say")
