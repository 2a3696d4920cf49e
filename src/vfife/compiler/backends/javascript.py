"""The straight-line step and the loop driver as JavaScript: a page opened from disk, without a server, runs a
mechanism with the same bits.

JavaScript's numbers are IEEE 754 doubles; its four operations, ``Math.sqrt`` and comparisons are rounded as
everywhere, and a trace uses nothing else.

The driver is translated from the same plain functions that :mod:`~vfife.compiler.backends.plain` compiles.
Integers are doubles there, so they must stay below 2^53. Anything that means something else in JavaScript is
refused with its line: conditions that are no truth values, ``%``, powers, and all else that is not listed
here.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable
from typing import NoReturn

from ...errors import SourceError
from ...kernels.arrays import Layout
from ...kernels.topology import Topology
from ..trace.schedule import Line, Load, Store, Test, in_place, ordered, streamed
from ..trace.straight_line import Function, steps_of
from ..trace.tape import Operand, rows_used
from .expressions import written as written_integer
from .modules import ONE_LANE, STEPS, driver_source

OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.And: "&&", ast.Or: "||", ast.Gt: ">",
    ast.Lt: "<", ast.GtE: ">=", ast.LtE: "<=",
    ast.Eq: "===", ast.NotEq: "!==", ast.USub: "-", ast.UAdd: "+", ast.Not: "!",
}  # fmt: skip
CALLS = {
    "len": "{}.length",
    "float": "{}",
    "int": "Math.trunc({})",
    "abs": "Math.abs({})",
    "math.sqrt": "Math.sqrt({})",
}


def script(text: str, external: Iterable[str] = ()) -> str:
    """Return the functions of a text as JavaScript; they may call each other and the ``external``.

    Raises SourceError for anything that cannot be translated exactly.
    """
    trees = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)]
    names = {*(tree.name for tree in trees), *external}
    return "\n".join(_Function(tree, names).text() for tree in trees)


class _Function:
    def __init__(self, tree: ast.FunctionDef, functions: set[str]) -> None:
        self.tree, self.functions, self.loops = tree, functions, 0

    def text(self) -> str:
        arguments = [argument.arg for argument in self.tree.args.args]
        nodes = [
            node
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        ]
        variables = sorted({node.id for node in nodes} - set(arguments))
        lines = [f"let {', '.join(variables)};"] if variables else []
        lines += self.block(self.tree.body)
        return "\n".join(
            [
                f"function {self.tree.name}({', '.join(arguments)}) {{",
                *(f"  {line}" for line in lines),
                "}",
                "",
            ]
        )

    def refuse(self, node: ast.AST) -> NoReturn:
        line = getattr(node, "lineno", self.tree.lineno) - self.tree.lineno + 1
        raise SourceError(
            f"{self.tree.name}, line {line}: {ast.unparse(node).splitlines()[0]!r}: this is not translated to"
            " JavaScript"
        )

    def block(self, statements: list[ast.stmt]) -> list[str]:
        """Return the lines of statements."""
        return [line for statement in statements for line in self.statement(statement)]

    def statement(self, node: ast.stmt) -> list[str]:
        """Return the lines of a statement."""
        match node:
            case ast.Assign(targets=[target]):
                return [f"{self.target(target)} = {self.value(node.value)};"]
            case ast.AugAssign(op=ast.Add() | ast.Sub() | ast.Mult()):
                return [f"{self.target(node.target)} {OPERATORS[type(node.op)]}= {self.value(node.value)};"]
            case ast.Expr(value=ast.Call()):
                return [f"{self.value(node.value)};"]
            case ast.Return():
                return [f"return {self.value(node.value)};" if node.value else "return;"]
            case ast.If():
                alternative = ["} else {", *self.block(node.orelse)] if node.orelse else []
                return [f"if ({self.condition(node.test)}) {{", *self.block(node.body), *alternative, "}"]
            case ast.While(orelse=[]):
                return [f"while ({self.condition(node.test)}) {{", *self.block(node.body), "}"]
            case ast.For(
                orelse=[],
                target=ast.Name(),
                iter=ast.Call(func=ast.Name(id="range"), args=bounds, keywords=[]),
            ):
                return self.counted(node, bounds)
            case ast.Break() | ast.Continue():
                return [f"{type(node).__name__.lower()};"]
        return self.refuse(node)

    def counted(self, node: ast.For, bounds: list[ast.expr]) -> list[str]:
        """Return the lines of a loop over a range: as in Python, its end is computed once, and its name keeps
        the last value.
        """
        self.loops += 1
        at, end = f"at{self.loops}$", f"end{self.loops}$"
        first, last = ("0", bounds[0]) if len(bounds) == 1 else (self.value(bounds[0]), bounds[1])
        step = written_integer(bounds[2]) if len(bounds) > 2 else 1
        if not step:
            self.refuse(node)
        head = (
            f"for (let {at} = {first}, {end} = {self.value(last)}; {at} {'<' if step > 0 else '>'} {end};"
            f" {at} += {step}) {{"
        )
        return [head, f"{self.target(node.target)} = {at};", *self.block(node.body), "}"]

    def target(self, node: ast.expr) -> str:
        """Return the text of the target of an assignment."""
        if isinstance(node, ast.Tuple):
            return f"[{', '.join(map(self.target, node.elts))}]"
        return self.value(node) if isinstance(node, ast.Name | ast.Subscript) else self.refuse(node)

    def condition(self, node: ast.expr) -> str:
        """Return the text of a condition: a comparison, a truth value, or a combination. Other values are
        refused, because JavaScript has other rules for their truth.
        """
        truth = isinstance(node, ast.Compare | ast.BoolOp | ast.Name | ast.Call | ast.UnaryOp)
        return (
            self.value(node)
            if truth and not (isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Not))
            else self.refuse(node)
        )

    def value(self, node: ast.expr) -> str:
        """Return the text of an expression."""
        match node:
            case ast.Name():
                return node.id
            case ast.Constant(value=bool()):
                return str(node.value).lower()
            case ast.Constant(value=int() | float() as number) if math.isfinite(number) and (
                isinstance(number, float) or abs(number) < 1 << 53
            ):
                return repr(number)
            case ast.Tuple():
                return f"[{', '.join(map(self.value, node.elts))}]"
            case ast.Subscript() if not isinstance(node.slice, ast.Slice | ast.Tuple | ast.UnaryOp):
                return f"{self.value(node.value)}[{self.value(node.slice)}]"
            case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
                return f"({OPERATORS[type(node.op)]}{self.value(node.operand)})"
            case ast.UnaryOp(op=ast.Not()):
                return f"!({self.condition(node.operand)})"
            case ast.BinOp(op=ast.FloorDiv(), right=ast.Constant()):
                return f"Math.floor({self.value(node.left)} / {self.value(node.right)})"
            case ast.BinOp() if type(node.op) in OPERATORS:
                return f"({self.value(node.left)} {OPERATORS[type(node.op)]} {self.value(node.right)})"
            case ast.BoolOp():
                return f"({f' {OPERATORS[type(node.op)]} '.join(map(self.condition, node.values))})"
            case ast.Compare(ops=[operator], comparators=[other]) if type(operator) in OPERATORS:
                return f"({self.value(node.left)} {OPERATORS[type(operator)]} {self.value(other)})"
            case ast.IfExp():
                return f"({self.condition(node.test)} ? {self.value(node.body)} : {self.value(node.orelse)})"
            case ast.Call(keywords=[]):
                return self.call(node)
        return self.refuse(node)

    def call(self, node: ast.Call) -> str:
        """Return the text of a call. ``min`` and ``max`` are written as comparisons, because ``Math.min``
        treats NaN and the sign of zero in another way than Python.
        """
        name, values = ast.unparse(node.func), [self.value(argument) for argument in node.args]
        if name in self.functions:
            return f"{name}({', '.join(values)})"
        if name in CALLS and len(values) == 1:
            return CALLS[name].format(*values)
        if (
            name in ("min", "max")
            and len(values) == 2
            and not any(isinstance(part, ast.Call) for argument in node.args for part in ast.walk(argument))
        ):
            first, second = values
            return f"({second} {'<' if name == 'min' else '>'} {first} ? {second} : {first})"
        return self.refuse(node)


PATTERNS = {
    "sqrt": "Math.sqrt({})", "neg": "-({})", "abs": "Math.abs({})", "and": "{} && {}", "or": "{} || {}",
    "select": "{} ? {} : {}",
    "round": "({} + 6755399441055744) - 6755399441055744", "==": "{} === {}", "!=": "{} !== {}",
}  # fmt: skip


def operand(value: Operand) -> str:
    """Return the text of a name, or of a number that reads back to the same bits."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return "(0 / 0)" if value != value else "(1 / 0)" if value > 0.0 else "(-1 / 0)"
    return value if isinstance(value, str) else f"({value!r})"


def line(item: Line) -> str:
    """Return the text of a line."""
    if isinstance(item, Load):
        return f"const v{item.row} = S[{item.row}];"
    if isinstance(item, Store):
        return f"S[{item.row}] = {operand(item.value)};"
    if isinstance(item, Test):
        return f"if ({operand(item.condition)}) return false;"
    pattern = PATTERNS.get(item.operator, f"{{}} {item.operator} {{}}")
    return f"const {item.name} = {pattern.format(*map(operand, item.operands))};"


def time_functions(functions: list[Function], layout: Layout) -> Iterable[str]:
    """Yield the lines that evaluate functions at step n, as the data-driven loop does."""
    step, shift = (layout.row(name) for name in ("step", "shift"))
    yield (
        f"const dt = S[{step}], ahead = n === 0 ? 0 : dt, time = (n + S[{shift}]) * dt, after = (n + 1 +"
        f" S[{shift}]) * dt;"
    )
    for f in functions:
        yield "{"
        yield from (f"const {name} = S[{name[1:]}];" for name in rows_used(f.operations))
        yield from map(line, f.operations)
        value, rate, acceleration, kinks, following = (f"S[{row}]" for row in f.rows)
        yield f"[{value}, {rate}, {acceleration}, {kinks}] = polynomial(T, {f.table}, {operand(f.argument)});"
        yield f"{following} = polynomial(T, {f.table}, after)[0];" if f.of_time else f"{following} = {value};"
        yield "}"


def definition(head: str, lines: Iterable[str]) -> str:
    """Return the text of a function."""
    return "\n  ".join([f"function {head} {{", *lines]) + "\n}\n"


def module(topology: Topology, extra_rows: Iterable[int] = ()) -> str:
    """Return a text that defines ``advance`` of :mod:`vfife.kernels.advance` for one lane on typed arrays; it
    also stores the scratch rows ``extra_rows``.
    """
    steps = steps_of(topology, tuple(extra_rows))
    fast, full = steps.fast, in_place(steps.full, streamed(steps.full))
    change = map(line, in_place(steps.resize, streamed(steps.resize)))
    parts = [
        script(driver_source("advance") + ONE_LANE, (*STEPS, "fast_step")),
        definition("functions(S, T, I, n)", time_functions(steps.functions, Layout(topology))),
        definition("resize(S, I, C)", ["const [size, shift, repeated] = C;", *change]),
        definition("fast_step(S, n)", [*map(line, in_place(fast, ordered(fast))), "return true;"]),
        definition("full_step(S, T, I, n)", ["functions(S, T, I, n);", *map(line, full)]),
    ]
    return "\n".join(parts)
