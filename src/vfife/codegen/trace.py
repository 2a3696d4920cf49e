"""Straight-line code from the data-driven loop: the same text is run once with symbols for numbers.

Integers (the topology) are known, so every loop over entities and every choice of a kind is carried out; what remains is one long list of
additions, products, roots and selects in the very order of the data-driven loop, hence the same bits. Terms that the topology makes zero (the
ground's velocity, the arm of an elastic link's end) drop out, which can change the sign of a zero and nothing else.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from .schedule import Line


class Branch(ValueError):
    """A statement chose its way by a number that is only known in the run; write it as ``a if condition else b``."""


class Tape:
    """Lines of single assignments; equal expressions are written once."""

    def __init__(self) -> None:
        self.lines: list[tuple[str, str, tuple[Any, ...]]] = []
        self.known: dict[tuple[Any, ...], Symbol] = {}
        self.loads: dict[int, Symbol] = {}
        self.rare: list[Any] = []

    def emit(self, pattern: str, *operands: Any) -> Symbol:
        """A symbol for ``pattern`` with its operands put in."""
        key = (pattern, *(o.name if isinstance(o, Symbol) else repr(o) for o in operands))
        if key not in self.known:
            symbol = Symbol(self, f"t{len(self.lines)}")
            self.lines.append((symbol.name, pattern, operands))
            self.known[key] = symbol
        return self.known[key]

    def load(self, row: int) -> Symbol:
        """The value a row has before the step."""
        if row not in self.loads:
            self.loads[row] = Symbol(self, f"v{row}")
        return self.loads[row]

    def needed(self, wanted: list[Any]) -> list[Line]:
        """The lines that ``wanted`` depends on."""
        used = {value.name for value in wanted if isinstance(value, Symbol)}
        kept: list[Line] = []
        for name, pattern, operands in reversed(self.lines):
            if name in used:
                uses = tuple(o.name for o in operands if isinstance(o, Symbol))
                used.update(uses)
                kept.append(Line(name, pattern.format(*(text(o) for o in operands)), uses))
        return kept[::-1]


def text(value: Any) -> str:
    """A symbol's name, or a number as a literal that reads back to the same bits."""
    if isinstance(value, Symbol):
        return value.name
    return repr(value) if value >= 0 else f"({value!r})"


def _operator(pattern: str, fold: Callable[[Any, Any], Any] | None = None, swap: bool = False) -> Callable[[Symbol, Any], Any]:
    def method(self: Symbol, other: Any) -> Any:
        a, b = (other, self) if swap else (self, other)
        folded = fold(a, b) if fold else None
        return self.tape.emit(pattern, a, b) if folded is None else folded

    return method


def _zero(x: Any) -> bool:
    return not isinstance(x, Symbol) and x == 0


def _one(x: Any) -> bool:
    return not isinstance(x, Symbol) and x == 1


def _add(a: Any, b: Any) -> Any:
    return b if _zero(a) else a if _zero(b) else None


def _subtract(a: Any, b: Any) -> Any:
    return a if _zero(b) else -b if _zero(a) else None


def _multiply(a: Any, b: Any) -> Any:
    if _zero(a) or _zero(b):
        return 0.0
    return b if _one(a) else a if _one(b) else None


def _divide(a: Any, b: Any) -> Any:
    return 0.0 if _zero(a) else a if _one(b) else None


class Symbol:
    """A number of the run."""

    def __init__(self, tape: Tape, name: str) -> None:
        self.tape, self.name = tape, name

    __add__ = _operator("{} + {}", _add)
    __radd__ = _operator("{} + {}", _add, swap=True)
    __sub__ = _operator("{} - {}", _subtract)
    __rsub__ = _operator("{} - {}", _subtract, swap=True)
    __mul__ = _operator("{} * {}", _multiply)
    __rmul__ = _operator("{} * {}", _multiply, swap=True)
    __truediv__ = _operator("{} / {}", _divide)
    __rtruediv__ = _operator("{} / {}", _divide, swap=True)
    __gt__ = _operator("{} > {}")
    __lt__ = _operator("{} < {}")
    __ge__ = _operator("{} >= {}")
    __le__ = _operator("{} <= {}")
    __eq__ = _operator("{} == {}")
    __ne__ = _operator("{} != {}")
    __hash__ = object.__hash__

    def __mod__(self, other: int) -> int:
        return 0 if other == 1 else NotImplemented

    def __neg__(self) -> Symbol:
        return self.tape.emit("-{}", self)

    def __abs__(self) -> Symbol:
        return self.tape.emit("abs({})", self)

    def __bool__(self) -> bool:
        raise Branch("a branch on a number of the run cannot be written into straight-line code; use a conditional expression")


class Rows:
    """The array S during a trace: the present value of each row, a symbol where it is only known in the run."""

    def __init__(self, tape: Tape, known: dict[int, float], state: set[int]) -> None:
        self.tape, self.values, self.state = tape, dict(known), state

    def __getitem__(self, row: int) -> Any:
        return self.values.get(row) if row in self.values else self.tape.load(row)

    def __setitem__(self, row: int, value: Any) -> None:
        self.values[row] = value

    def stores(self) -> dict[int, Any]:
        """Rows that a step leaves changed."""
        same = {row: symbol.name for row, symbol in self.tape.loads.items()}
        return {
            row: value
            for row, value in self.values.items()
            if row in self.state and not (isinstance(value, Symbol) and same.get(row) == value.name)
        }


class Mathematics:
    """Stands for the module math."""

    @staticmethod
    def sqrt(x: Any) -> Any:
        """Square root."""
        return x.tape.emit("math.sqrt({})", x) if isinstance(x, Symbol) else x**0.5


def select(condition: Any, first: Callable[[], Any], second: Callable[[], Any]) -> Any:
    """``first if condition else second``; both are carried out where the condition is only known in the run."""
    if not isinstance(condition, Symbol):
        return first() if condition else second()
    a, b = first(), second()
    if isinstance(a, tuple):
        return tuple(_choose(condition, x, y) for x, y in zip(a, b, strict=True))
    return _choose(condition, a, b)


def _choose(condition: Symbol, a: Any, b: Any) -> Any:
    same = a is b or (not isinstance(a, Symbol) and not isinstance(b, Symbol) and a == b)
    return a if same else condition.tape.emit("{} if {} else {}", a, condition, b)


def both(a: Any, b: Any) -> Any:
    """``a and b``."""
    if isinstance(a, Symbol) and isinstance(b, Symbol):
        return a.tape.emit("{} & {}", a, b)
    return (b if a else False) if not isinstance(a, Symbol) else (a if b else False)


def either(a: Any, b: Any) -> Any:
    """``a or b``."""
    if isinstance(a, Symbol) and isinstance(b, Symbol):
        return a.tape.emit("{} | {}", a, b)
    return (True if a else b) if not isinstance(a, Symbol) else (True if b else a)


class _Conditions(ast.NodeTransformer):
    """Turns conditional expressions and boolean operators into calls that symbols can pass through."""

    def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
        self.generic_visit(node)
        arms = [ast.Lambda(ast.arguments([], [], None, [], [], None, []), arm) for arm in (node.body, node.orelse)]
        return ast.Call(ast.Name("select", ast.Load()), [node.test, *arms], [])

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        self.generic_visit(node)
        name = "both" if isinstance(node.op, ast.And) else "either"
        result = node.values[0]
        for value in node.values[1:]:
            result = ast.Call(ast.Name(name, ast.Load()), [result, value], [])
        return result


def traced(body: str, tape: Tape) -> dict[str, Any]:
    """The functions of a gathered text, ready to be run with symbols; branches marked ``seldom`` are noted on the tape and not taken."""
    tree = ast.fix_missing_locations(_Conditions().visit(ast.parse(body)))
    space: dict[str, Any] = {"math": Mathematics, "jit": lambda f: f, "select": select, "both": both, "either": either}
    exec(compile(tree, "<vfife trace>", "exec"), space)  # the text is our own and the user's laws, never a model file's

    def seldom(condition: Any) -> bool:
        tape.rare.append(condition)
        return False

    space["seldom"] = seldom
    return space
