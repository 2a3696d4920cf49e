"""Prepare kernels and laws to run with symbols: their own code in another namespace, with conditional
expressions turned into calls.

Python asks a condition for its truth value, which a symbol has not. In functions with conditions, conditional
expressions become calls of :func:`~vfife.compiler.trace.tape.select`, ``and`` and ``or`` calls of ``both``
and ``either``, and ``if unlikely(...)`` is bracketed by two calls. A function without conditions keeps its
compiled code.

A file is parsed once for all of its functions; ``inspect.getsource`` tokenises it again for each. Only one
thread at a time parses and compiles code (``WRITING``), because Python 3.11 loses count of its recursion
depth when two do so at once.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import linecache
import math
import re
import textwrap
import threading
from collections.abc import Callable
from functools import lru_cache
from types import CodeType, FunctionType
from typing import Any

from ...kernels.elementary import nearest
from .powers import Powers
from .tape import Mathematics, Symbol, Tape, Unlikely, logical_and, logical_or, select

WRITING = threading.RLock()


_files: dict[str, tuple[list[str], dict[int, int]]] = {}


def function_text(function: Any) -> str:
    """Return the text of a plain function's definition, without the indentation of its class.

    Raises OSError if it cannot be found.
    """
    code = function.__code__
    with WRITING:
        lines = linecache.getlines(code.co_filename, function.__globals__)
        cached = _files.get(code.co_filename)
        if cached is None or cached[0] is not lines:
            cached = _files[code.co_filename] = lines, _ends(lines)
    end = cached[1].get(code.co_firstlineno)
    text = inspect.getsource(function) if end is None else "".join(lines[code.co_firstlineno - 1 : end])
    return textwrap.dedent(text)


def function_tree(function: Any) -> ast.AST:
    """Return the syntax tree of a function's definition, without decorators and annotations, and with powers
    as products.
    """
    tree = parsed(function_text(function))
    if isinstance(tree, ast.FunctionDef):
        tree.decorator_list, tree.returns = [], None
        for argument in [*tree.args.args, *tree.args.kwonlyargs, *tree.args.posonlyargs]:
            argument.annotation = None
    return tree


def parsed(text: str) -> ast.AST:
    """Return the syntax tree of the first statement of a text, with powers as products."""
    with WRITING:
        return with_products(text).body[0]


def with_products(text: str) -> ast.Module:
    """Return the syntax tree of a text, in which powers with literal exponents are products."""
    tree = ast.parse(text)
    if "**" in text:
        Powers().visit(tree)
    return tree


def _ends(lines: list[str]) -> dict[int, int]:
    """Return the last line of each definition by its first line, decorators included."""
    try:
        tree = ast.parse("".join(lines))
    except SyntaxError:
        return {}
    ends: dict[int, int] = {}
    waiting: list[Any] = list(tree.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef) and node.end_lineno is not None:
            ends[min([node.lineno, *(d.lineno for d in node.decorator_list)])] = node.end_lineno
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.If | ast.Try | ast.With):
            waiting += node.body
    return ends


TEXTS = re.compile(r'"""(.|\n)*?"""|#.*')  # docstrings and comments
CONDITION = re.compile(r"\band\b|\bor\b|\bunlikely\(|\belse\b(?!:)")


class _Conditions(ast.NodeTransformer):
    """Rewrite conditional expressions, boolean operators and rare branches as calls that accept symbols."""

    def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
        self.generic_visit(node)
        no_arguments = ast.arguments([], [], None, [], [], None, [])
        arms = [ast.copy_location(ast.Lambda(no_arguments, arm), arm) for arm in (node.body, node.orelse)]
        return _call("select", node, [node.test, *arms])

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        self.generic_visit(node)
        result = node.values[0]
        for value in node.values[1:]:
            result = _call("both" if isinstance(node.op, ast.And) else "either", node, [result, value])
        return result

    def visit_If(self, node: ast.If) -> ast.AST:
        self.generic_visit(node)
        test = node.test
        if isinstance(test, ast.Call) and isinstance(test.func, ast.Name) and test.func.id == "unlikely":
            end = _call("unlikely_ends", test, [])
            node.body = [*node.body, ast.copy_location(ast.Expr(end), test)]
        return node


def _call(name: str, node: ast.AST, arguments: list[ast.expr]) -> ast.Call:
    return ast.copy_location(
        ast.Call(ast.copy_location(ast.Name(name, ast.Load()), node), arguments, []), node
    )


def _code(tree: ast.AST) -> CodeType:
    """Return the code of a function with rewritten conditions."""
    if isinstance(tree, ast.FunctionDef):
        tree.args.defaults = []
    with WRITING:
        module = compile(ast.Module([_Conditions().visit(tree)], []), "<vfife trace>", "exec")
    return next(constant for constant in module.co_consts if isinstance(constant, CodeType))


@lru_cache(maxsize=512)
def function_code(function: FunctionType) -> CodeType:
    """Return the code of a function that accepts symbols: its own code if nothing has to be rewritten."""
    if CONDITION.search(TEXTS.sub("", function_text(function))):
        return _code(function_tree(function))
    return function.__code__


@lru_cache(maxsize=64)
def text_code(text: str) -> CodeType:
    """Return the code, accepting symbols, of the function that a text defines."""
    return _code(parsed(text))


def is_own(function: Callable[..., Any]) -> bool:
    """Return whether a function is part of vfife."""
    return function.__module__.startswith("vfife.")


def symbolic(tape: Tape, value: Any) -> Any:
    """Return a number, or a tuple of numbers, as symbols: x - 0.0, which is x with its sign."""
    if isinstance(value, tuple):
        return tuple(symbolic(tape, item) for item in value)
    return value if isinstance(value, Symbol) else tape.emit("-", float(value), 0.0)


class Traceable:
    """Make functions traceable, each once.

    ``given`` maps names to the functions that replace them wherever they are called: ``nearest``,
    ``unlikely``, and the choices between laws.
    """

    def __init__(self, tape: Tape, unlikely: Unlikely | None = None) -> None:
        self.tape = tape
        self.given: dict[str, Any] = {
            "nearest": lambda x: tape.emit("round", x) if isinstance(x, Symbol) else nearest(x)
        }
        self.ends: Callable[[], None] = lambda: None
        if unlikely is not None:
            self.given["unlikely"], self.ends = unlikely.begin, unlikely.end
        self.made: dict[FunctionType, Any] = {}

    def __call__(self, function: Any) -> Any:
        """Return a function with its code in a namespace in which all that it calls is traceable."""
        if function in self.made:
            return self.made[function]
        space = self._space()
        result = self.made[function] = FunctionType(
            function_code(function), space, function.__name__, function.__defaults__
        )
        for name in function.__code__.co_names:
            if name in self.given:
                space[name] = self.given[name]
            elif name in function.__globals__:
                value = function.__globals__[name]
                space[name] = (
                    Mathematics
                    if value is math
                    else self(value)
                    if isinstance(value, FunctionType)
                    else value
                )
        return result

    def written(self, text: str, calls: dict[str, Any]) -> Any:
        """Return the function that a text defines, with access to the functions in ``calls``."""
        named = {
            name: self(function) if is_own(function) else self.exactly(self(function))
            for name, function in calls.items()
        }
        return FunctionType(text_code(text), self._space() | self.given | named)

    def exactly(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function with every operation noted, even those that only affect the sign of a zero;
        numbers of the topology become symbols.
        """

        def run(*arguments: Any) -> Any:
            former, self.tape.exact = self.tape.exact, True
            try:
                return function(*(symbolic(self.tape, argument) for argument in arguments))
            finally:
                self.tape.exact = former

        return run

    def _space(self) -> dict[str, Any]:
        return {
            "__builtins__": builtins,
            "select": select,
            "both": logical_and,
            "either": logical_or,
            "unlikely_ends": self.ends,
        }
