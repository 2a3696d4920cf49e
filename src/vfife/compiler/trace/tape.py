"""The step as data: the kernels run once with symbols in place of numbers, and a tape records every
operation.

Integers (the topology) are known, so every loop over entities is unrolled and every choice of a kind is
decided. What remains is one list of additions, products, roots and selects, in the order of the data-driven
loop and hence with the same bits. Terms that the topology makes zero (the velocity of the ground, the arm of
an elastic link's end) are dropped, which can change the sign of a zero and nothing else.

A generator of code for each kind of joint would have to repeat the kernels' text; here the text itself is the
only source, and a new joint needs nothing in the compiler.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

Operand: TypeAlias = "str | float | bool"  # the name of a symbol, or a constant

COMPARISONS = frozenset((">", "<", ">=", "<=", "==", "!="))
TRUTHS = COMPARISONS | {"and", "or"}
OPERATORS = TRUTHS | {"+", "-", "*", "/", "sqrt", "neg", "abs", "select", "round"}
JUMP = "jump"  # in traces to be differentiated only, see compiler/trace/jumps.py
STEP_NUMBER = "n"  # the name of the number of the step, a whole number as a double


class Branch(ValueError):
    """Raised for a statement that branches on a number known only in the run; write it as ``a if condition
    else b``.
    """


class Operation(NamedTuple):
    """One line of a step: the ``name`` of its result, an operator and its operands.

    ``round`` returns the nearest integer (x + 1.5 2^52 - 1.5 2^52); ``select`` its second operand if the
    first is true, else the third. ``fused`` occurs in derivatives only: a b + c in one line, rounded twice,
    since not every processor can round it once.
    """

    name: str
    operator: str
    operands: tuple[Operand, ...]

    @property
    def uses(self) -> tuple[str, ...]:
        """Names of the operands that are symbols."""
        # A list is made in half the time of a generator, and this is called five times a line.
        return tuple([o for o in self.operands if type(o) is str])


@dataclass(frozen=True)
class Trace:
    """A step: ``operations`` in an order in which they can be executed, ``stores`` (the new value of each
    row), and the condition ``rare``.

    Names: ``v7`` is row 7 before the step, ``n`` the number of the step, ``t...`` the result of an operation.
    If ``rare`` is true, this step must not be taken: a branch that it leaves out would be needed. It is the
    constant False in a step that has all branches.
    """

    operations: tuple[Operation, ...]
    stores: dict[int, Operand]
    rare: Operand = False

    @cached_property
    def uses(self) -> dict[str, tuple[str, ...]]:
        """Names of the symbols that each operation uses, by its name."""
        return {operation.name: operation.uses for operation in self.operations}

    @property
    def truths(self) -> set[str]:
        """Names of truth values; all others are numbers."""
        names: set[str] = set()
        for name, operator, operands in self.operations:
            chosen = operator == "select" and all(isinstance(o, bool) or o in names for o in operands[1:])
            if chosen or operator in TRUTHS:
                names.add(name)
        return names


def is_row(name: Operand) -> bool:
    """Return whether an operand is a row before the step."""
    return isinstance(name, str) and name[0] == "v"


def rows_used(operations: Iterable[Operation]) -> list[str]:
    """Return the names of the rows that operations read, sorted."""
    return sorted({name for operation in operations for name in operation.uses if is_row(name)})


def needed(operations: Sequence[Operation], results: Iterable[Operand]) -> tuple[Operation, ...]:
    """Return the operations on which ``results`` depend, in their order."""
    used = set(results)
    result: list[Operation] = []
    for operation in reversed(operations):
        name, _, operands = operation
        if name in used:
            used.update([o for o in operands if type(o) is str])
            result.append(operation)
    return tuple(result[::-1])


def operand_of(value: Any) -> Operand:
    """Return the name of a symbol, or a constant."""
    return value.name if isinstance(value, Symbol) else value if isinstance(value, bool) else float(value)


NEW = tuple.__new__  # makes an operation in a third of the time of its own constructor


class Tape:
    """The record of operations; equal operations are recorded once (common subexpressions).

    If ``exact``, no simplification is made that could change a bit: a product with zero is NaN for infinity,
    and a sum with zero can change the sign of a zero. Users' laws are traced so. In the kernels' own text
    products with zero mean terms that the topology leaves out, and are dropped.
    """

    def __init__(self) -> None:
        self.exact = False
        self.operations: list[Operation] = []
        self.known: dict[tuple[Any, ...], Symbol] = {}
        self.loads: dict[int, Symbol] = {}
        self.opposites: dict[str, Symbol] = {}
        self.rare: list[Any] = []

    def emit(self, operator: str, *operands: Any) -> Symbol:
        """Return the symbol for the result of an operator; record the operation if it is new."""
        names: tuple[Operand, ...] = tuple([o.name for o in operands if type(o) is Symbol])
        key: tuple[Any, ...] = (operator, *names)
        if len(names) < len(operands):
            names = tuple(
                [o.name if type(o) is Symbol else o if type(o) is bool else float(o) for o in operands]
            )
            # 0.0 equals -0.0 and 1.0 equals True, but they are different operands: repr tells them apart.
            key = (operator, *[o if o and o is not True else repr(o) for o in names])
        symbol = self.known.get(key)
        if symbol is None:
            name = f"t{len(self.operations)}"
            symbol = self.known[key] = Symbol(self, name)
            self.operations.append(NEW(Operation, (name, operator, names)))
        return symbol

    def load(self, row: int) -> Symbol:
        """Return the symbol for the value of a row before the step."""
        if row not in self.loads:
            self.loads[row] = Symbol(self, f"v{row}")
        return self.loads[row]

    def needed(self, results: Iterable[Any]) -> tuple[Operation, ...]:
        """Return the operations on which ``results`` depend, in their order."""
        return needed(self.operations, {value.name for value in results if isinstance(value, Symbol)})

    def trace_of(self, stores: Mapping[int, Any], rare: Any = False) -> Trace:
        """Return the operations on which the new values of rows, ``stores``, and ``rare`` depend.

        Values that no stored row depends on (reactions of a body that nothing moves, say) are dropped only
        here, because while tracing nobody knows which ones these are.
        """
        operations = self.needed([*stores.values(), rare])
        return Trace(operations, {row: operand_of(value) for row, value in stores.items()}, operand_of(rare))


def _tape(a: Any, b: Any) -> Tape:
    """Return the tape of two operands, one of which is a symbol."""
    tape: Tape = a.tape if type(a) is Symbol else b.tape
    return tape


def _opposite(x: Any) -> Any:
    """Return the symbol of which ``x`` is the negative, None for anything else.

    Signs are moved through products to a sum, which becomes a difference with the same bits: a negation costs
    an operation, a difference none.
    """
    return x.tape.opposites.get(x.name) if type(x) is Symbol else None


# Simplifications of each operator, for a constant operand and for one that is a negative; None if there is
# nothing to simplify.


def _add(a: Any, b: Any) -> Any:
    if type(a) is not Symbol or type(b) is not Symbol:
        number, term = (b, a) if type(a) is Symbol else (a, b)
        if number == 0 and (
            not _tape(a, b).exact or math.copysign(1.0, number) < 0.0
        ):  # x + -0.0 is x, whatever x is
            return term
    first, second = _opposite(a), _opposite(b)
    return a - second if second is not None else b - first if first is not None else None


def _subtract(a: Any, b: Any) -> Any:
    if type(b) is not Symbol and b == 0 and (not a.tape.exact or math.copysign(1.0, b) > 0.0):  # x - 0.0 is x
        return a
    if (
        type(a) is not Symbol and a == 0 and (not b.tape.exact or math.copysign(1.0, a) < 0.0)
    ):  # -0.0 - x is -x
        return -b
    second = _opposite(b)
    return a + second if second is not None else None


def _multiply(a: Any, b: Any) -> Any:
    if type(a) is not Symbol or type(b) is not Symbol:
        number, factor = (b, a) if type(a) is Symbol else (a, b)
        if number == 0 and not _tape(a, b).exact:
            return 0.0
        if number == 1:
            return factor
        if type(a) is not Symbol and number == -1:
            return -b
    first, second = _opposite(a), _opposite(b)
    return -(first * b) if first is not None else -(a * second) if second is not None else None


def _divide(a: Any, b: Any) -> Any:
    if type(a) is not Symbol and a == 0 and not b.tape.exact:
        return 0.0
    if type(b) is not Symbol and b == 1:
        return a
    first, second = _opposite(a), _opposite(b)
    return -(first / b) if first is not None else -(a / second) if second is not None else None


def _operator(
    operator: str, fold: Callable[[Any, Any], Any] | None = None, swap: bool = False
) -> Callable[[Symbol, Any], Any]:
    def method(self: Symbol, operand: Any) -> Any:
        a, b = (operand, self) if swap else (self, operand)
        folded = fold(a, b) if fold else None
        return self.tape.emit(operator, a, b) if folded is None else folded

    return method


class Symbol:
    """A number or a truth value that is known only in the run; arithmetic on it is recorded on its tape."""

    __slots__ = ("name", "tape")

    def __init__(self, tape: Tape, name: str) -> None:
        self.tape, self.name = tape, name

    __add__ = _operator("+", _add)
    __radd__ = _operator("+", _add, swap=True)
    __sub__ = _operator("-", _subtract)
    __rsub__ = _operator("-", _subtract, swap=True)
    __mul__ = _operator("*", _multiply)
    __rmul__ = _operator("*", _multiply, swap=True)
    __truediv__ = _operator("/", _divide)
    __rtruediv__ = _operator("/", _divide, swap=True)
    __gt__ = _operator(">")
    __lt__ = _operator("<")
    __ge__ = _operator(">=")
    __le__ = _operator("<=")
    __eq__ = _operator("==")
    __ne__ = _operator("!=")
    __hash__ = object.__hash__

    def __mod__(self, other: int) -> int:
        return 0 if other == 1 else NotImplemented

    def __neg__(self) -> Symbol:
        opposite: Symbol | None = _opposite(self)
        if opposite is not None:
            return opposite
        result = self.tape.emit("neg", self)
        self.tape.opposites[result.name] = self
        return result

    def __abs__(self) -> Symbol:
        opposite: Symbol | None = _opposite(self)
        return self.tape.emit("abs", self if opposite is None else opposite)

    def __bool__(self) -> bool:
        raise Branch(
            "a branch on a number of the run cannot be written into straight-line code; use a conditional"
            " expression"
        )


class Rows:
    """The array S during a trace: the present value of each row, a constant or a symbol.

    ``values`` are rows with known values at the start, ``state`` the rows that a step has to write.
    """

    def __init__(self, tape: Tape, values: dict[int, float], state: set[int]) -> None:
        self.tape, self.values, self.state = tape, dict(values), state

    def __getitem__(self, row: int) -> Any:
        return self.values[row] if row in self.values else self.tape.load(row)

    def __setitem__(self, row: int, value: Any) -> None:
        self.values[row] = value

    def stores(self) -> dict[int, Any]:
        """Return the new values of the rows of ``state`` that the step changes."""
        loaded = {row: symbol.name for row, symbol in self.tape.loads.items()}
        return {
            row: value
            for row, value in self.values.items()
            if row in self.state and not (isinstance(value, Symbol) and loaded.get(row) == value.name)
        }


class Mathematics:
    """Stand-in for the module math in traced functions."""

    pi, e, tau, inf, nan = math.pi, math.e, math.tau, math.inf, math.nan

    @staticmethod
    def sqrt(x: Any) -> Any:
        """Return the square root of a number or a symbol."""
        return x.tape.emit("sqrt", x) if isinstance(x, Symbol) else math.sqrt(x)


def select(condition: Any, first: Callable[[], Any], second: Callable[[], Any]) -> Any:
    """Return ``first() if condition else second()``; both are executed if the condition is a symbol."""
    if not isinstance(condition, Symbol):
        return first() if condition else second()
    a, b = first(), second()
    if isinstance(a, tuple):
        return tuple(choose(condition, x, y) for x, y in zip(a, b, strict=True))
    return choose(condition, a, b)


def choose(condition: Symbol, a: Any, b: Any) -> Any:
    """Return ``a`` where the condition is true, else ``b``; no operation if both are the same."""
    equal = a is b or (not isinstance(a, Symbol) and not isinstance(b, Symbol) and a == b)
    if (
        equal and a is not b and a == 0 and math.copysign(1.0, a) != math.copysign(1.0, b)
    ):  # 0.0 and -0.0 are equal
        equal = False
    return a if equal else condition.tape.emit("select", condition, a, b)


def logical_and(a: Any, b: Any) -> Any:
    """Return ``a and b``."""
    if isinstance(a, Symbol) and isinstance(b, Symbol):
        return a.tape.emit("and", a, b)
    return (b if a else False) if not isinstance(a, Symbol) else (a if b else False)


def logical_or(a: Any, b: Any) -> Any:
    """Return ``a or b``."""
    if isinstance(a, Symbol) and isinstance(b, Symbol):
        return a.tape.emit("or", a, b)
    return (True if a else b) if not isinstance(a, Symbol) else (True if b else a)


class Unlikely:
    """Replacement of ``if unlikely(condition): ...`` in a trace.

    For the fast step the branch is left out and its condition is recorded as rare. For the full step it is
    ``written_out``: executed, with selects between the rows after and before it.
    """

    def __init__(self, tape: Tape, rows: Rows, written_out: bool) -> None:
        self.tape, self.rows, self.written_out = tape, rows, written_out
        self.branches: list[tuple[Any, dict[int, Any]]] = []

    def begin(self, condition: Any) -> bool:
        """Return whether to execute the branch; if so, :meth:`end` must be called after it."""
        if isinstance(condition, Symbol) and not self.written_out:
            self.tape.rare.append(condition)
            return False
        if isinstance(condition, Symbol) or condition:
            self.branches.append((condition, dict(self.rows.values)))
            return True
        return False

    def end(self) -> None:
        """Make all rows that the branch changed selects between their values after and before it."""
        condition, old_rows = self.branches.pop()
        if not isinstance(condition, Symbol):
            return
        for row, value in list(self.rows.values.items()):
            old = old_rows[row] if row in old_rows else self.tape.load(row)
            if value is not old:
                self.rows[row] = choose(condition, value, old)
