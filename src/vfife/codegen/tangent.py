"""The derivative of a step: the operations of a trace, each followed by its derivative in so many directions.

A direction is a way in which the numbers of a model may change; row r of the state has its derivative in direction k at row r + (k + 1) R, where
R is the number of rows. What comes out is a trace like any other: it is ordered, written and compiled as one. Comparisons and choices are those of
the numbers themselves, and rounding to a whole number has derivative zero, so what is differentiated is the step as it was taken; where a contact
begins in another step, or a law passes a kink, the derivative is that from one side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

from .trace import Operand, Operation, Symbol, Tape, Trace, choose, is_row

Directions: TypeAlias = "tuple[Any, ...]"  # derivatives of one number, in each direction; 0.0 where it does not depend on it


class Tangents:
    """Runs operations again with their derivatives, on a tape of its own; ``given`` are derivatives of names that are no rows."""

    def __init__(self, rows: int, count: int, given: Mapping[str, Directions] | None = None, tape: Tape | None = None) -> None:
        self.tape, self.rows, self.count = tape or Tape(), rows, count
        self.zero: Directions = (0.0,) * count
        self.values: dict[str, Any] = {}
        self.slopes: dict[str, Directions] = dict(given or {})

    def value(self, operand: Operand) -> Any:
        """A number, a truth or a symbol on the new tape."""
        if not isinstance(operand, str):
            return operand
        if operand not in self.values:
            self.values[operand] = self.tape.load(int(operand[1:])) if is_row(operand) else Symbol(self.tape, operand)
        return self.values[operand]

    def slope(self, operand: Operand) -> Directions:
        """Its derivatives."""
        if not isinstance(operand, str):
            return self.zero
        if operand not in self.slopes:
            row = int(operand[1:]) if is_row(operand) else None
            self.slopes[operand] = self.zero if row is None else tuple(self.tape.load(row + k * self.rows) for k in range(1, self.count + 1))
        return self.slopes[operand]

    def run(self, operations: Iterable[Operation]) -> None:
        """Takes operations in their order."""
        for name, operator, operands in operations:
            values = [self.value(operand) for operand in operands]
            self.values[name] = result = self.tape.emit(operator, *values)  # unfolded: it has the same bits
            rule = RULES.get(operator)
            self.slopes[name] = rule(result, values, [self.slope(operand) for operand in operands]) if rule else self.zero


def _sum(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(da + db for da, db in zip(*slopes, strict=True))


def _difference(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(da - db for da, db in zip(*slopes, strict=True))


def _product(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    a, b = values
    return tuple(da * b + a * db for da, db in zip(*slopes, strict=True))


def _quotient(quotient: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    """(da - q db) / b, with one division for all directions."""
    if not any(isinstance(slope, Symbol) for both_slopes in slopes for slope in both_slopes):
        return slopes[0]
    each = 1.0 / values[1]
    return tuple((da - quotient * db) * each for da, db in zip(*slopes, strict=True))


def _root(root: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    """da / (2 root), and zero at zero, where a magnitude begins."""
    (slope,) = slopes
    if not any(isinstance(one, Symbol) for one in slope):
        return slope
    half = choose(root > 0.0, 0.5 / root, 0.0)
    return tuple(da * half for da in slope)


def _negative(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(-da for da in slopes[0])


def _magnitude(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    below = values[0] < 0.0
    return tuple(choose(below, -da, da) if isinstance(da, Symbol) else da for da in slopes[0])


def _choice(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(choose(values[0], da, db) for da, db in zip(slopes[1], slopes[2], strict=True))


RULES: dict[str, Callable[[Any, list[Any], list[Directions]], Directions]] = {
    "+": _sum, "-": _difference, "*": _product, "/": _quotient, "sqrt": _root, "neg": _negative, "abs": _magnitude, "select": _choice,
}  # fmt: skip
"""Derivatives by operator; comparisons, truths and rounding have none."""


def tangent(step: Trace, rows: int, count: int, given: Callable[[Tangents], Mapping[str, Directions]] | None = None) -> Trace:
    """A trace with its derivatives in ``count`` directions, for a state of ``rows`` rows; ``given`` says those of names that are no rows."""
    run = Tangents(rows, count)
    run.slopes |= given(run) if given else {}
    run.run(step.operations)
    return with_slopes(run, step)


def with_slopes(run: Tangents, step: Trace) -> Trace:
    """What a run leaves of a trace: its stores, and behind them their slopes."""
    stores: dict[int, Any] = {}
    for row, operand in step.stores.items():
        stores[row] = run.value(operand)
        stores |= {row + k * run.rows: slope for k, slope in enumerate(run.slope(operand), 1)}
    rare = run.value(step.rare)
    operations = run.tape.needed([*stores.values(), rare])
    return Trace(operations, {row: named(value) for row, value in stores.items()}, named(rare))


def named(value: Any) -> Operand:
    """The name of a symbol, or a constant."""
    return value.name if isinstance(value, Symbol) else value if isinstance(value, bool) else float(value)


def of_size(step: int) -> Callable[[Tangents], Mapping[str, Directions]]:
    """Derivative of ``size``, which is a part of the size in row ``step``, or that size again."""

    def given(run: Tangents) -> Mapping[str, Directions]:
        ratio = run.value("size") / run.value(f"v{step}")
        return {"size": tuple(slope * ratio for slope in run.slope(f"v{step}"))}

    return given


def of_time(step: int) -> Callable[[Tangents], Mapping[str, Directions]]:
    """Derivatives of times, which are multiples of the step in row ``step``."""

    def given(run: Tangents) -> Mapping[str, Directions]:
        each = 1.0 / run.value(f"v{step}")
        return {name: tuple(run.value(name) * (slope * each) for slope in run.slope(f"v{step}")) for name in ("time", "ahead", "after")}

    return given
