"""Small faults in the text of the kernels, made from its syntax: each is one expression written otherwise."""

from __future__ import annotations

import ast
import copy
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

DECLARED = ("__init__", "arrays", "topology")  # left alone: what is wrong in them does not run
OTHER = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
FLIPPED = {
    ast.Lt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Gt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
}
SHARE = 1.05  # of a constant


@dataclass(frozen=True)
class Mutant:
    """One expression of a file, and what stands in its place."""

    file: str
    function: str
    line: int
    kind: str
    before: str
    after: str
    span: tuple[int, int]
    text: str = ""

    @property
    def place(self) -> str:
        """The label with the line of the text, which tells two faults of one function apart."""
        return f"{self.label} | {self.text}"

    @property
    def label(self) -> str:
        """Where and what, without the number of the line, which moves."""
        return f"{self.file}.{self.function}: {self.before} -> {self.after}"

    def applied(self, text: str) -> str:
        """The text of the file with the fault."""
        first, last = self.span
        return f"{text[:first]}({self.after}){text[last:]}"


def numeric(node: ast.AST) -> bool:
    """Whether an expression is a number of the physics: one with a name of a record outside brackets is a sum
    of indices.
    """
    if isinstance(node, ast.Subscript):
        return not (isinstance(node.value, ast.Name) and node.value.id == "I")
    if isinstance(node, ast.Attribute):
        return isinstance(node.value, ast.Name) and node.value.id == "math"
    return all(numeric(part) for part in ast.iter_child_nodes(node))


def otherwise(node: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    """What can stand in the place of an expression, and what kind of fault that is."""
    if isinstance(node, ast.BinOp) and type(node.op) in OTHER:
        yield "operator", ast.BinOp(node.left, OTHER[type(node.op)](), node.right)
        if isinstance(node.op, ast.Add | ast.Sub):
            yield "dropped", node.left
            yield (
                "dropped",
                node.right if isinstance(node.op, ast.Add) else ast.UnaryOp(ast.USub(), node.right),
            )
    elif isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value:
        yield "constant", ast.Constant(SHARE * node.value)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "sign", node.operand
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in FLIPPED:
        yield "comparison", ast.Compare(node.left, [FLIPPED[type(node.ops[0])]()], node.comparators)


class Finder(ast.NodeVisitor):
    """Walks through the functions of a file; indices, slices, ranges and annotations are passed by."""

    def __init__(self, file: str, text: str) -> None:
        self.file, self.function, self.found = file, "", []
        self.starts = [0]
        for line in text.encode().splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.bytes = text.encode()

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        before, self.function = self.function, node.name
        for part in node.body:
            self.visit(part)
        self.function = before

    def visit_Subscript(self, node: ast.Subscript) -> None:
        """An index is no physics."""

    def visit_For(self, node: ast.For) -> None:
        for part in node.body:
            self.visit(part)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if (
            isinstance(node.op, ast.Add | ast.Sub)
            and self.function
            and numeric(node.value)
            and not isinstance(node.target, ast.Name)
        ):
            turned = ast.UnaryOp(ast.USub(), copy.deepcopy(node.value))
            self._add(node.value, "sign", turned)
        self.generic_visit(node)

    def generic_visit(self, node: ast.AST) -> None:
        if self.function and isinstance(node, ast.expr) and numeric(node):
            for kind, new in otherwise(node):
                self._add(node, kind, copy.deepcopy(new))
        super().generic_visit(node)

    def _add(self, node: ast.expr, kind: str, new: ast.expr) -> None:
        ends = [
            len(self.bytes[: self.starts[line - 1] + column].decode())
            for line, column in (
                (node.lineno, node.col_offset),
                (node.end_lineno or 0, node.end_col_offset or 0),
            )
        ]
        before, after = ast.unparse(node), ast.unparse(ast.fix_missing_locations(new))
        if before != after:
            self.found.append(
                Mutant(self.file, self.function, node.lineno, kind, before, after, (ends[0], ends[1]))
            )


def every(folder: Path) -> list[Mutant]:
    """All mutants of the kernels in a folder, in the order of the text."""
    found: list[Mutant] = []
    for name in sorted({file.stem for file in folder.glob("*.py")} - {*DECLARED}):
        text = (folder / f"{name}.py").read_text()
        finder = Finder(name, text)
        finder.visit(ast.parse(text))
        found += finder.found
    return found


def drawn(folder: Path, seed: int, count: int) -> list[Mutant]:
    """Some of them, the same for the same text and seed."""
    return random.Random(seed).sample(every(folder), count)
