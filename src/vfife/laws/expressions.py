"""Expressions in the language of laws: the kind of each, and the faults of expressions that some loop would
compute differently from Python.
"""

from __future__ import annotations

import ast
import builtins
import math
from collections.abc import Callable
from types import FunctionType, ModuleType
from typing import Any

from ..compiler.trace.powers import LARGEST_EXPONENT, exponent
from .grammar import (
    FUNCTIONS,
    LARGEST,
    NUMBER,
    REMEDY,
    RESERVED,
    TRUTH,
    UNKNOWN,
    Integer,
    Kind,
    TupleKind,
    category,
    exclusion,
    is_typed,
    numeric,
    size,
    words,
)

DEEPEST = 80  # expressions in one another: those who write code walk them by recursion
LARGEST_TUPLE = 32  # numbers: the arguments of a step are fewer
LARGEST_POWER = 64  # of a whole number: no larger one stays below 2^53


class Expressions:
    """Kinds of the expressions of one function; ``place`` are the names that have a value so far."""

    function: Any
    place: dict[str, Kind]
    local: frozenset[str]
    cost: int  # operations so far

    def fault(self, node: ast.AST, text: str) -> Kind:
        """Add a fault of a node; return the kind of a faulty expression."""
        raise NotImplementedError

    def called(self, node: ast.Call, function: FunctionType, kinds: tuple[Kind, ...]) -> Kind:
        """Return the kind of the answer of another function."""
        raise NotImplementedError

    def kind(self, node: ast.expr, depth: int = 0) -> Kind:
        """Return the kind of an expression."""
        if depth > DEEPEST:
            return self.fault(
                node,
                f"more than {DEEPEST} expressions stand in one another; give parts of it names of their own",
            )
        if excluded := exclusion(node):
            return self.fault(node, excluded)
        method: Callable[[Any, int], Kind] | None = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            return self.fault(node, f"`{shown(node)}` cannot be compiled into the step. {REMEDY}")
        return method(node, depth + 1)

    def number(self, node: ast.expr, depth: int, integer: ast.expr) -> Kind:
        """Return the kind of an operand of ``integer``, which takes numbers."""
        kind = self.kind(node, depth)
        if numeric(kind):
            return kind
        if kind == TRUTH:
            return self.fault(
                node,
                f"`{shown(node)}` in `{shown(integer)}` is a truth value; write `1.0 if {shown(node)} else"
                " 0.0`",
            )
        return self.fault(
            node,
            f"`{shown(node)}` in `{shown(integer)}` is {words(kind)}; take it apart first, as in `a, b = p`",
        )

    def truth(self, node: ast.expr, depth: int, integer: ast.expr) -> None:
        """Check that a node is a condition."""
        kind = self.kind(node, depth)
        if kind not in (TRUTH, UNKNOWN):
            text = f"`{shown(node)}` in `{shown(integer)}` is {words(kind)} and no condition"
            self.fault(node, f"{text}; write `{shown(node)} != 0.0`")

    def _constant(self, node: ast.Constant, depth: int) -> Kind:
        return self.constant(node, node.value, shown(node))

    def constant(self, node: ast.AST, value: Any, text: str) -> Kind:
        """Return the kind of a constant of the text or the file."""
        if type(value) is bool:
            return TRUTH
        if type(value) is int:
            return self.within(node, Integer(value, value), text)
        if type(value) is not float:
            return self.fault(node, f"{value!r} is no number")
        return (
            NUMBER
            if value == value
            else self.fault(node, f"{text} is not a number; choose by `a if condition else b` instead")
        )

    def within(self, node: ast.AST, kind: Integer, text: str) -> Kind:
        """Return the kind of an integer, with a fault if a double cannot hold its limits."""
        if max(-kind.low, kind.high) <= LARGEST:
            return kind
        return self.fault(
            node,
            f"`{text}` is a whole number beyond 2^53, which no double has; write it with a point, as in 1e16",
        )

    def _name(self, node: ast.Name, depth: int) -> Kind:
        if node.id in self.local:
            return (
                self.place[node.id]
                if node.id in self.place
                else self.fault(node, f"{node.id} is used before it has a value")
            )
        value = self.outside(node)
        if value is None:
            return UNKNOWN
        if isinstance(value, FunctionType):
            return self.fault(
                node, f"the function {node.id} is used like a number; call it, as in {node.id}(x)"
            )
        if isinstance(value, ModuleType):
            return self.fault(node, f"{node.id} is a module and no number")
        return self.constant(node, value, node.id)

    def outside(self, node: ast.Name) -> Any:
        """Return the value of a global name; None, with a fault, where the language does not allow it."""
        space = self.function.__globals__
        if node.id.startswith("__"):
            self.fault(
                node,
                f"{node.id}: within a class Python gives such a name another one; choose one without `__` in"
                " front",
            )
            return None
        if node.id not in space:
            if hasattr(builtins, node.id):
                self.fault(
                    node, f"{node.id}() cannot be compiled into the step; {FUNCTIONS.get(node.id, REMEDY)}"
                )
            else:
                self.fault(node, f"the file does not define {node.id}; define it, or correct the name")
            return None
        value = space[node.id]
        if isinstance(value, FunctionType):
            user_function = value.__module__ != "vfife" and not value.__module__.startswith("vfife.")
            if value.__name__ != node.id:
                self.fault(
                    node, f"the function {value.__name__} is called {node.id} here; call it by its own name"
                )
                return None
            if user_function and node.id in RESERVED:
                self.fault(
                    node,
                    f"{node.id} is a name that the step itself uses; rename the function, as in my_{node.id}",
                )
                return None
        elif isinstance(value, ModuleType) or type(value) in (bool, int, float):
            if node.id in RESERVED and value is not math:
                self.fault(
                    node, f"{node.id} is a name that the step itself uses; rename it, as in my_{node.id}"
                )
                return None
        elif isinstance(value, bool | int | float):
            self.fault(
                node,
                f"{node.id} ({type(value).__name__}) is no plain number; write {node.id} = {plain(value)!r}"
                " in the file",
            )
            return None
        else:
            instead = FUNCTIONS.get(getattr(value, "__name__", node.id), REMEDY)
            self.fault(
                node, f"{node.id} ({type(value).__name__}) cannot be compiled into the step; {instead}"
            )
            return None
        return value

    def _tuple(self, node: ast.Tuple, depth: int) -> Kind:
        if not node.elts:
            return self.fault(node, "an empty tuple is of no use in the step; leave it out")
        kind = TupleKind(tuple(self.kind(part, depth) for part in node.elts))
        if size(kind) > LARGEST_TUPLE:
            return self.fault(
                node,
                f"`{shown(node)}` has {size(kind)} numbers; a tuple may have {LARGEST_TUPLE}: give some of"
                " them names of their own",
            )
        return kind

    def _unaryop(self, node: ast.UnaryOp, depth: int) -> Kind:
        if isinstance(node.op, ast.Not):
            return self.fault(node, "`not` cannot be compiled into the step; reverse the comparison")
        if not isinstance(node.op, ast.USub):
            sign = "~" if isinstance(node.op, ast.Invert) else "+"
            return self.fault(
                node,
                f"`{sign}` in front of `{shown(node.operand)}` cannot be compiled into the step; leave"
                " it out",
            )
        self.cost += 1
        kind = self.number(node.operand, depth, node)
        return Integer(-kind.high, -kind.low) if isinstance(kind, Integer) else kind

    def _binop(self, node: ast.BinOp, depth: int) -> Kind:
        self.cost += 1
        if excluded := exclusion(node.op):
            return self.fault(node, excluded)
        if isinstance(node.op, ast.Pow):
            return self.power(node)
        left, right = (self.number(operand, depth, node) for operand in (node.left, node.right))
        if UNKNOWN in (left, right):
            return UNKNOWN
        if isinstance(node.op, ast.Div):
            if isinstance(right, Integer) and right.low <= 0 <= right.high:
                return self.fault(
                    node,
                    f"`{shown(node)}` divides by zero; Python ends there, so choose by `a if condition"
                    " else b`",
                )
            return NUMBER
        if not isinstance(left, Integer) or not isinstance(right, Integer):
            return NUMBER
        return self.within(node, combined(node.op, left, right), shown(node))

    def power(self, node: ast.BinOp) -> Kind:
        """Return the kind of a power that is no product: of two integer literals, or a faulty expression."""
        values = [
            operand.value
            for operand in (node.left, node.right)
            if isinstance(operand, ast.Constant) and type(operand.value) is int
        ]
        if len(values) < 2:
            return self.fault(node, f"`{shown(node)}`: {power_remedy(node)}")
        if values[1] > LARGEST_POWER:
            return self.within(node, Integer(LARGEST + 1, LARGEST + 1), shown(node))
        value = values[0] ** values[1]
        return self.within(node, Integer(value, value), shown(node))

    def _compare(self, node: ast.Compare, depth: int) -> Kind:
        self.cost += 1
        for operator in node.ops:
            if excluded := exclusion(operator):
                return self.fault(node, excluded)
        if len(node.ops) > 1:
            return self.fault(node, f"`{shown(node)}` compares twice; write `a < x and x < b`")
        for operand in (node.left, *node.comparators):
            kind = self.kind(operand, depth)
            if kind == TRUTH:
                return self.fault(
                    node,
                    f"`{shown(node)}` compares truth values; choose by `a if condition else b`, or join them"
                    " with `and`, `or`",
                )
            if not numeric(kind):
                return self.fault(
                    node, f"`{shown(node)}` compares {words(kind)}; compare its numbers one by one"
                )
        return TRUTH

    def _boolop(self, node: ast.BoolOp, depth: int) -> Kind:
        self.cost += len(node.values) - 1
        kinds = [self.kind(operand, depth) for operand in node.values]
        if all(kind in (TRUTH, UNKNOWN) for kind in kinds):
            return TRUTH
        k = next(k for k, kind in enumerate(kinds) if kind not in (TRUTH, UNKNOWN))
        first, second = (
            f"({shown(operand)})" if isinstance(operand, ast.IfExp | ast.BoolOp) else shown(operand)
            for operand in node.values[max(k - 1, 0) :][:2]
        )
        tested = first if kinds[max(k - 1, 0)] == TRUTH else f"{first} != 0.0"
        true_value = "1.0" if kinds[max(k - 1, 0)] == TRUTH else first
        chosen = f"{second} if {tested} else {'0.0' if true_value == '1.0' else first}"
        instead = chosen if isinstance(node.op, ast.And) else f"{true_value} if {tested} else {second}"
        word = "and" if isinstance(node.op, ast.And) else "or"
        return self.fault(
            node,
            f"`{shown(node)}`: `{word}` joins conditions, and `{shown(node.values[k])}` is {words(kinds[k])};"
            f" write `{instead}`",
        )

    def _ifexp(self, node: ast.IfExp, depth: int) -> Kind:
        self.cost += 1
        self.truth(node.test, depth, node)
        kinds = [self.kind(branch, depth) for branch in (node.body, node.orelse)]
        if not all(is_typed(kind) for kind in kinds):
            return UNKNOWN
        for arm, kind in zip((node.body, node.orelse), kinds, strict=True):
            inner = kind.kinds if isinstance(kind, TupleKind) else (kind,)
            if any(isinstance(part, Integer) for part in inner):
                text = f"`{shown(arm)}` in `{shown(node)}` is a whole number, and others are not"
                return self.fault(
                    arm,
                    (
                        f"{text}; write it with a point, as in 1.0"
                        if not isinstance(kind, TupleKind)
                        else f"{text}; write 1.0 for 1"
                    ),
                )
            if any(isinstance(part, TupleKind) for part in inner):
                return self.fault(
                    arm,
                    f"`{shown(arm)}` has tuples within a tuple; choose each by an `a if condition else b` of"
                    " its own",
                )
        if category(kinds[0]) != category(kinds[1]):
            return self.fault(
                node,
                f"`{shown(node)}` is {words(kinds[0])} or {words(kinds[1])}; both have to be the same kind of"
                " thing",
            )
        return kinds[0]

    def _attribute(self, node: ast.Attribute, depth: int) -> Kind:
        space = self.function.__globals__
        outer = isinstance(node.value, ast.Name) and node.value.id not in self.local
        if not isinstance(node.value, ast.Name) or not outer:
            return self.fault(node, f"`{shown(node)}` cannot be compiled into the step. {REMEDY}")
        if node.value.id not in space:
            return self._name(node.value, depth)
        owner = space[node.value.id]
        if owner is math and isinstance(getattr(math, node.attr, None), float):
            return self.constant(node, getattr(math, node.attr), f"math.{node.attr}")
        if owner is math:
            instead = (
                "call it, as in math.sqrt(x)" if node.attr == "sqrt" else FUNCTIONS.get(node.attr, REMEDY)
            )
            return self.fault(node, f"math.{node.attr} differs between machines in its last bits; {instead}")
        if isinstance(owner, ModuleType):
            instead = FUNCTIONS.get(node.attr, REMEDY)
            return self.fault(
                node, f"{owner.__name__}.{node.attr} cannot be compiled into the step; {instead}"
            )
        return self.fault(node, f"`{shown(node)}` cannot be compiled into the step. {REMEDY}")

    def _subscript(self, node: ast.Subscript, depth: int) -> Kind:
        kind = self.kind(node.value, depth)
        if not isinstance(kind, TupleKind):
            text = f"`{shown(node)}`: {shown(node.value)} is {words(kind)} and has no parts"
            return UNKNOWN if kind == UNKNOWN else self.fault(node, f"{text}; leave the brackets out")
        index, sign = node.slice, 1
        if isinstance(index, ast.UnaryOp) and isinstance(index.op, ast.USub):
            index, sign = index.operand, -1
        if not isinstance(index, ast.Constant) or type(index.value) is not int:
            text = f"`{shown(node)}` takes a part whose place is no literal"
            return self.fault(
                node, f"{text}; take the tuple apart, `a, b = p`, or loop over it, `for x in p:`"
            )
        place = sign * index.value
        if not -len(kind.kinds) <= place < len(kind.kinds):
            return self.fault(
                node,
                f"`{shown(node)}`: {shown(node.value)} has {len(kind.kinds)} parts, the first at 0; correct"
                " the number",
            )
        return kind.kinds[place]

    def _call(self, node: ast.Call, depth: int) -> Kind:
        self.cost += 1
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            return self.fault(
                node, f"`{shown(node)}` names or unpacks arguments; write them in their order, as in f(a, b)"
            )
        if isinstance(node.func, ast.Attribute):
            owner = (
                self.function.__globals__.get(node.func.value.id)
                if isinstance(node.func.value, ast.Name)
                else None
            )
            if (
                owner is not math
                or node.func.attr != "sqrt"
                or getattr(node.func.value, "id", "") in self.local
            ):
                return self._attribute(node.func, depth)
            return self.one_number(node, "math.sqrt", depth)
        if not isinstance(node.func, ast.Name):
            return self.fault(node, f"`{shown(node)}` cannot be compiled into the step. {REMEDY}")
        name = node.func.id
        if name in self.local:
            return self.fault(
                node, f"`{shown(node)}` calls {name}, which is a value in this function; rename one of them"
            )
        if name == "abs" and name not in self.function.__globals__:
            return self.one_number(node, name, depth)
        if name == "range" and name not in self.function.__globals__:
            return self.fault(node, "range stands in `for k in range(4):` alone")
        function = self.outside(node.func)
        kinds = tuple(self.kind(argument, depth) for argument in node.args)
        if function is None or not all(is_typed(kind) for kind in kinds):
            return UNKNOWN
        if not isinstance(function, FunctionType):
            return self.fault(node, f"`{shown(node)}` calls {name}, which is no function")
        return self.called(node, function, kinds)

    def one_number(self, node: ast.Call, name: str, depth: int) -> Kind:
        """Return the kind of ``abs`` or ``math.sqrt`` of a number."""
        if len(node.args) != 1:
            return self.fault(node, f"`{shown(node)}`: {name} takes one number")
        kind = self.number(node.args[0], depth, node)
        if not isinstance(kind, Integer):
            return kind
        if name == "abs":
            ends = abs(kind.low), abs(kind.high)
            return Integer(0 if kind.low <= 0 <= kind.high else min(ends), max(ends))
        if kind.low < 0:
            return self.fault(
                node,
                f"`{shown(node)}` is a root of a negative number; Python ends there, so choose by `a if"
                " condition else b`",
            )
        return NUMBER


def shown(node: ast.AST) -> str:
    """Return the first line of a node's text, shortened to 60 characters."""
    text = ast.unparse(node).splitlines()[0]
    return text if len(text) <= 60 else f"{text[:57]}..."


def power_remedy(node: ast.BinOp) -> str:
    """Return the replacement of a power that is no product."""
    base, value = shown(node.left), exponent(node.right)
    if value == 0.0:
        return "it is always 1; write 1.0"
    if value is not None and abs(value) <= LARGEST_EXPONENT and value % 0.5 == 0.0:
        return "its base is long; give it a name in a line before"
    if base == "math.e":
        return "write exp(x) of vfife.kernels.elementary"
    return (
        "`**` takes a literal exponent of whole or half numbers up to"
        f" {LARGEST_EXPONENT:g}, as in x ** 2.5; write power({base}, {shown(node.right)}) of"
        " vfife.kernels.elementary, for a base of 0 or more"
    )


def plain(value: Any) -> Any:
    """Convert a number of any class to Python's own."""
    return bool(value) if isinstance(value, bool) else int(value) if isinstance(value, int) else float(value)


def combined(operator: ast.operator, left: Integer, right: Integer) -> Integer:
    """Return the limits of a sum, difference or product."""
    if isinstance(operator, ast.Add):
        return Integer(left.low + right.low, left.high + right.high)
    if isinstance(operator, ast.Sub):
        return Integer(left.low - right.high, left.high - right.low)
    products = [a * b for a in left for b in right]
    return Integer(min(products), max(products))
