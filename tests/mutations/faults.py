"""Small faults in packages other than the kernels, made from the syntax of their text.

A fault is one expression written otherwise: a sum as a difference, a limit that is met as one that is not, a
constant one and a half times as large, an index or a count off by one, ``and`` for ``or``, the least for the
largest, a sign, a factor or a term left out. Texts, messages of errors and annotations are left alone.
"""

from __future__ import annotations

import ast
import copy
import hashlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from mutations.mutants import Mutant

# Packages, and the modules of each that state numbers and how far they hold, wherever in the package they
# lie:
# faults are drawn from these unless others are named.
MODULES: dict[str, tuple[str, ...]] = {
    "measures": (),  # all of them
    "assembly": (
        "assembled", "checks", "fill", "linearised", "input_functions", "possible", "prestress", "stability",
        "timestep",
    ),
    "studies": (
        "allocation", "derivatives", "finite_difference", "iso286", "distributions", "limits",
        "sensitivity_indices", "tolerance",
    ),
    "solvers": (
        "companions", "impact_section", "record", "refinement", "relaxation", "repeating", "statics",
        "tangents", "turn_runner",
    ),
    "results": (
        "channels", "derivatives", "fit", "case_errors", "series", "spectra", "study",
        "run_data",
    ),
}  # fmt: skip
PACKAGES = tuple(MODULES)
SHARE = 1.5  # of a constant
SWAPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
EQUAL = {ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}
# Of counts only: two numbers that were computed are hardly ever the same.
BOUNDARY = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, **EQUAL}
TURNED = {ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt}
OPPOSITE = {
    "min": "max",
    "max": "min",
    "minimum": "maximum",
    "maximum": "minimum",
    "argmin": "argmax",
    "argmax": "argmin",
}
# Calls whose arguments are words for people, or what says how something is written.
WORDS = ("Fault", "refuse", "shown", "suggestion", "print", "warn", "round", "cast", "TypeVar", "lru_cache")
# Arguments that check or guard, and change no number.
SPARED = ("strict", "repr", "compare", "stacklevel", "dtype", "copy", "allow_pickle")
TEXTS = (ast.JoinedStr, ast.List, ast.Tuple, ast.Dict, ast.Set, ast.ListComp)


def is_text(node: ast.expr) -> bool:
    """Whether an expression is a text or a collection, of which a sum is no arithmetic."""
    if isinstance(node, ast.BinOp):
        return is_text(node.left) or is_text(node.right)
    return isinstance(node, TEXTS) or (
        isinstance(node, ast.Constant) and not isinstance(node.value, int | float)
    )


def counts(node: ast.expr) -> bool:
    """Whether an expression is a whole number for sure: written as one, or a length, or a sum of these with
    anything.
    """
    if isinstance(node, ast.BinOp):
        return counts(node.left) or counts(node.right)
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id in ("len", "int", "round")
    return isinstance(node, ast.Constant) and isinstance(node.value, int)


def otherwise(node: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    """Every other way of writing an expression, and what kind of fault that is."""
    if isinstance(node, ast.BinOp) and not is_text(node):
        if type(node.op) in SWAPPED:
            yield "operator", ast.BinOp(node.left, SWAPPED[type(node.op)](), node.right)
        if isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div):
            yield "dropped", node.left
        if isinstance(node.op, ast.Add | ast.Mult):
            yield "dropped", node.right
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield (
            "constant",
            ast.Constant(
                node.value + 1 if isinstance(node.value, int) else SHARE * node.value if node.value else 1.0
            ),
        )
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield "constant", ast.Constant(not node.value)
    elif (
        isinstance(node, ast.UnaryOp)
        and isinstance(node.op, ast.USub | ast.Not)
        and not isinstance(node.operand, ast.Constant)
    ):
        yield "sign", node.operand
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        for table in (
            (BOUNDARY, TURNED) if counts(node.left) or counts(node.comparators[0]) else (TURNED, EQUAL)
        ):
            if type(node.ops[0]) in table:
                yield "comparison", ast.Compare(node.left, [table[type(node.ops[0])]()], node.comparators)
    elif isinstance(node, ast.BoolOp):
        yield "logic", ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    elif isinstance(node, ast.Call):
        yield from extremes(node)


def extremes(node: ast.Call) -> Iterator[tuple[str, ast.expr]]:
    """The least in place of the largest, of a function or a method."""
    function = node.func
    if isinstance(function, ast.Name) and function.id in OPPOSITE:
        yield "extreme", ast.Call(ast.Name(OPPOSITE[function.id]), node.args, node.keywords)
    elif isinstance(function, ast.Attribute) and function.attr in OPPOSITE:
        yield (
            "extreme",
            ast.Call(ast.Attribute(function.value, OPPOSITE[function.attr]), node.args, node.keywords),
        )


class Finder(ast.NodeVisitor):
    """Walk through a file and collect its faults; ``module`` is its name within the package, such as
    ``measures.turns``.
    """

    def __init__(self, module: str, text: str) -> None:
        self.module, self.function, self.found = module, "", []
        self.bytes, self.starts, self.lines = text.encode(), [0], text.splitlines()
        for line in self.bytes.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        if node.name in ("__repr__", "__str__"):
            return
        before, self.function = self.function, node.name
        for part in (
            *node.args.defaults,
            *(one for one in node.args.kw_defaults if one is not None),
            *node.body,
        ):
            self.visit(part)
        self.function = before

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        for part in node.body:  # and not its decorators
            self.visit(part)

    def visit_keyword(self, node: ast.keyword) -> None:
        if node.arg not in SPARED:
            self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" not in ast.unparse(node.test):
            self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        """What is told of an error is no arithmetic."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Nor is a text."""

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name not in WORDS:
            self.generic_visit(node)

    def generic_visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.expr):
            for kind, new in otherwise(node):
                self._add(node, kind, copy.deepcopy(new))
        super().generic_visit(node)

    def _add(self, node: ast.expr, kind: str, new: ast.expr) -> None:
        places = (node.lineno, node.col_offset), (node.end_lineno or 0, node.end_col_offset or 0)
        first, last = (len(self.bytes[: self.starts[line - 1] + column].decode()) for line, column in places)
        before, after = ast.unparse(node), ast.unparse(ast.fix_missing_locations(new))
        if before != after:
            text = self.lines[node.lineno - 1].strip()
            self.found.append(
                Mutant(self.module, self.function, node.lineno, kind, before, after, (first, last), text)
            )


def every(source: Path, package: str, modules: tuple[str, ...] = ()) -> list[Mutant]:
    """All faults of some modules of a package below ``source`` (such as ``turns``), in the order of the text;
    ``MODULES`` unless said.
    """
    modules, found = modules or MODULES[package], []
    for file in sorted((source / package).rglob("*.py")):
        if file.stem == "__init__" or (modules and file.stem not in modules):
            continue
        text = file.read_text()
        finder = Finder(".".join(file.relative_to(source).with_suffix("").parts), text)
        finder.visit(ast.parse(text))
        found += finder.found
    return found


def drawn(source: Path, package: str, seed: int, count: int, modules: tuple[str, ...] = ()) -> list[Mutant]:
    """Some of them: those whose labels have the least hashes with the seed, so that a change of the text
    elsewhere leaves the draw as it is.
    """
    seen: Counter[str] = Counter()
    ranked = []
    for one in every(source, package, modules):
        seen[one.label] += 1
        ranked.append((hashlib.sha256(f"{seed} {one.label} {seen[one.label]}".encode()).hexdigest(), one))
    ranked.sort(key=lambda pair: pair[0])
    return [one for _, one in ranked[:count]]
