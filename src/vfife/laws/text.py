"""How the function of a user's own law is written: what of Python goes into a compiled step, and what to write for what does not."""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import textwrap
from collections.abc import Callable, Iterator
from types import FunctionType, ModuleType
from typing import Any

from ..kernels import elementary
from .law import Law

ELEMENTARY = tuple(name for name, value in vars(elementary).items() if isinstance(value, FunctionType) and not name.startswith("_"))
REMEDY = (
    "A law's function may use + - * /, math.sqrt, abs, comparisons, `a if condition else b`, numbers and plain functions of its file, "
    f"and {', '.join(ELEMENTARY)} of vfife.kernels.elementary"
)
ALLOWED = (
    ast.FunctionDef, ast.arguments, ast.arg, ast.Return, ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Pass, ast.Tuple, ast.Name, ast.Constant,
    ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.Attribute, ast.Subscript, ast.For, ast.expr_context, ast.operator,
    ast.unaryop, ast.boolop, ast.cmpop, ast.keyword,
)  # fmt: skip
INSTEAD = {
    ast.If: ("an `if` statement", "compute both and choose by `a if condition else b`"),
    ast.While: ("a `while` loop", "take a fixed number of rounds, `for _ in range(4):`"),
    ast.FloorDiv: ("`//`", "use / and numbers that are not whole"),
    ast.Mod: ("`%`", "use + - * /"),
    ast.Not: ("`not`", "turn the comparison round"),
    ast.Lambda: ("a lambda", "write a function in the file"),
    ast.List: ("a list", "use single numbers and tuples"),
    ast.Try: ("`try`", "choose by `a if condition else b`"),
    ast.Raise: ("`raise`", "check parameters in parameters(); in the step nothing can be raised"),
    ast.Import: ("an import", "import at the top of the file"),
    ast.ImportFrom: ("an import", "import at the top of the file"),
    ast.JoinedStr: ("a text", "use numbers"),
    ast.In: ("`in`", "compare numbers"),
    ast.Is: ("`is`", "compare numbers"),
}
FUNCTIONS = {
    "exp": "write exp2 of vfife.kernels.elementary, e^x = 2^(x/ln 2)",
    "log": "see what vfife.kernels.elementary has, or work it out in parameters()",
    "pow": "write power(x, n) of vfife.kernels.elementary, or x * x",
    "sin": "write sincos(x) of vfife.kernels.elementary, which gives both",
    "cos": "write sincos(x) of vfife.kernels.elementary, which gives both",
    "sqrt": "import math, and write math.sqrt",
    "min": "write `a if a < b else b`",
    "max": "write `a if a > b else b`",
    "fabs": "write abs(x)",
    "float": "leave it out: every argument is a number",
    "sum": "write a + b",
}


def place(law: type[Law]) -> str:
    """Which law is meant: its name, class, file and line."""
    function = getattr(law, "force", None)
    code = getattr(function, "__code__", None)
    where = f"{code.co_filename}, line {code.co_firstlineno}, " if code is not None and law.__module__ != "vfife.laws.law" else ""
    return f"{where}law {law.name!r} ({law.__name__})"


def faults_of_text(function: Callable[..., Any]) -> list[str]:
    """What cannot be compiled in a function and in the plain functions that it calls; raises OSError where a text cannot be read."""
    found: dict[str, None] = {}
    seen: set[Any] = set()
    waiting = [function]
    while waiting:
        one = waiting.pop()
        if one in seen or one.__module__.startswith("vfife."):
            continue
        seen.add(one)
        if one.__closure__:
            found[f"function {one.__name__} uses {', '.join(one.__code__.co_freevars)} from around it. Make it a field of the law"] = None
            continue
        walk = Walk(one)
        found |= dict.fromkeys(walk.faults())
        waiting += walk.calls
    return list(found)


class Walk:
    """A walk through the text of one function; ``calls`` are the plain functions that it uses."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.code = function.__code__
        self.local = {*self.code.co_varnames}
        self.calls: list[Callable[..., Any]] = []

    def faults(self) -> Iterator[str]:
        """Each fault, with its line."""
        tree = ast.parse(textwrap.dedent(inspect.getsource(self.function))).body[0]
        if not isinstance(tree, ast.FunctionDef):
            yield f"{self.function.__name__} is no def. Write it as one"
            return
        tree.decorator_list, tree.returns = [], None
        for argument in ast.walk(tree.args):
            if isinstance(argument, ast.arg):
                argument.annotation = None
        body = tree.body[1:] if ast.get_docstring(tree) is not None else tree.body
        for statement in body:
            for node in ast.walk(statement):
                fault = self.fault(node)
                if fault:
                    line = getattr(node, "lineno", statement.lineno) + self.code.co_firstlineno - 1
                    yield f"function {self.function.__name__}, line {line}: {fault}"

    def fault(self, node: ast.AST) -> str:
        """What is wrong with a node, and what to write instead."""
        for kind, (what, instead) in INSTEAD.items():
            if isinstance(node, kind):
                return f"{what} cannot be compiled into the step; {instead}"
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not all(isinstance(x, ast.Constant) for x in (node.left, node.right)):
            return "`**` differs between machines in its last bits; write x * x, or power(x, n) of vfife.kernels.elementary"
        if isinstance(node, ast.Compare) and len(node.ops) > 1:
            return f"`{ast.unparse(node)}` compares twice; write `a < x and x < b`"
        if isinstance(node, ast.Attribute):
            return self.attribute(node)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id not in self.local:
            return self.name(node.id)
        if isinstance(node, ast.Constant) and not isinstance(node.value, int | float):
            return f"{node.value!r} is no number"
        return "" if isinstance(node, ALLOWED) else f"`{ast.unparse(node).splitlines()[0][:40]}` cannot be compiled into the step. {REMEDY}"

    def attribute(self, node: ast.Attribute) -> str:
        """math.sqrt and the constants of math are all that a dot leads to."""
        space = self.function.__globals__
        owner = space.get(node.value.id) if isinstance(node.value, ast.Name) else None
        if isinstance(node.value, ast.Name) and node.value.id not in space and node.value.id not in self.local:
            return ""  # the name itself is told
        if owner is math and (node.attr == "sqrt" or isinstance(getattr(math, node.attr, None), float)):
            return ""
        if owner is math:
            instead = FUNCTIONS.get(node.attr, REMEDY)
            return f"math.{node.attr} differs between machines in its last bits; {instead}"
        if isinstance(owner, ModuleType):
            instead = FUNCTIONS.get(node.attr, REMEDY)
            return f"{owner.__name__}.{node.attr} cannot be compiled into the step; {instead}"
        return f"`{ast.unparse(node)}` cannot be compiled into the step. {REMEDY}"

    def name(self, name: str) -> str:
        """A name from outside the function: math, a number, a plain function, abs or range."""
        space = self.function.__globals__
        if name in space:
            value = space[name]
            if isinstance(value, FunctionType):
                self.calls.append(value)
                return ""
            if isinstance(value, bool | int | float | ModuleType):
                return ""  # what is taken from a module is told where it stands
            instead = FUNCTIONS.get(getattr(value, "__name__", name), REMEDY)
            return f"{name} ({type(value).__name__}) cannot be compiled into the step; {instead}"
        if name in ("abs", "range"):
            return ""
        if hasattr(builtins, name):
            return f"{name}() cannot be compiled into the step; {FUNCTIONS.get(name, REMEDY)}"
        return f"there is nothing called {name} in the file"
