"""The derivative of a step in several directions at once, by forward differentiation of its trace.

A direction is a change of the numbers of a model. Row r of the state has its derivative in direction k at row
r + (k + 1) R, where R is the number of rows. The result is a trace like any other: it is ordered, written and
compiled as one. Comparisons and choices are those of the numbers themselves, and rounding to an integer has
the derivative zero, so the step is differentiated as it was taken. If a contact would begin in another step,
or a law is at a kink, the derivative is one-sided.

:func:`tangent` differentiates operation by operation. :func:`shared_tangent` needs fewer operations. The
derivative of an operation is a sum of weights times the slopes of its operands, and weights are the same in
all directions: they are computed once. A result that depends on few others and that few depend on is
eliminated: each of its users gets the products of weights instead (vertex elimination in the order of least
cost: Griewank and Walther, Evaluating Derivatives, 2008, chapter 9). A choice is kept as a choice of slopes,
because the slope that is not chosen may be infinite, and zero times infinity is NaN.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from .schedule import depth_first, ordered
from .tape import JUMP, Operand, Operation, Symbol, Tape, Trace, choose, is_row

# Derivatives of one number in each direction; 0.0 where it does not depend on that direction.
Directions: TypeAlias = "tuple[Any, ...]"


class Tangents:
    """Repeat operations together with their derivatives in ``count`` directions on a new tape, for a state of
    ``rows`` rows. ``slopes`` may be given the derivatives of names that are no rows. Slopes contain the
    ``jumps`` of forces or not.
    """

    def __init__(self, rows: int, count: int, tape: Tape | None = None, jumps: bool = True) -> None:
        self.tape, self.rows, self.count, self.jumps = tape or Tape(), rows, count, jumps
        self.zero: Directions = (0.0,) * count
        self.values: dict[str, Any] = {}
        self.slopes: dict[str, Directions] = {}

    def value(self, operand: Operand) -> Any:
        """Return an operand as a number, a truth value or a symbol on the new tape."""
        if not isinstance(operand, str):
            return operand
        if operand not in self.values:
            self.values[operand] = (
                self.tape.load(int(operand[1:])) if is_row(operand) else Symbol(self.tape, operand)
            )
        return self.values[operand]

    def slope(self, operand: Operand) -> Directions:
        """Return the derivatives of an operand: those of a row are rows, too."""
        if not isinstance(operand, str):
            return self.zero
        if operand not in self.slopes:
            row = int(operand[1:]) if is_row(operand) else None
            self.slopes[operand] = (
                self.zero
                if row is None
                else tuple(self.tape.load(row + k * self.rows) for k in range(1, self.count + 1))
            )
        return self.slopes[operand]

    def run(self, operations: Iterable[Operation]) -> None:
        """Record operations and their derivatives in the given order."""
        for name, operator, operands in operations:
            values = [self.value(operand) for operand in operands]
            if operator == JUMP:
                self.values[name] = values[0]
                slopes = self.slope(operands[0]), self.slope(operands[2])
                self.slopes[name] = (
                    tuple(a + values[1] * b for a, b in zip(*slopes, strict=True))
                    if self.jumps
                    else slopes[0]
                )
                continue
            # emit, not the operator of the symbols: without simplification the numbers keep their bits.
            self.values[name] = result = self.tape.emit(operator, *values)
            rule = RULES.get(operator)
            self.slopes[name] = (
                rule(result, values, [self.slope(operand) for operand in operands]) if rule else self.zero
            )


def _sum(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(da + db for da, db in zip(*slopes, strict=True))


def _difference(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(da - db for da, db in zip(*slopes, strict=True))


def _product(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    a, b = values
    return tuple(da * b + a * db for da, db in zip(*slopes, strict=True))


def _quotient(quotient: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    """Return (da - q db) / b, with one division for all directions."""
    if not any(isinstance(slope, Symbol) for both_slopes in slopes for slope in both_slopes):
        return slopes[0]
    reciprocal = 1.0 / values[1]
    return tuple((da - quotient * db) * reciprocal for da, db in zip(*slopes, strict=True))


def _root(root: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    """Return da / (2 root), and zero where the root is zero: there a magnitude has no derivative."""
    (slope,) = slopes
    if not any(isinstance(direction, Symbol) for direction in slope):
        return slope
    half = choose(root > 0.0, 0.5 / root, 0.0)
    return tuple(da * half for da in slope)


def _negative(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(-da for da in slopes[0])


def _magnitude(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    negative = values[0] < 0.0
    return tuple(choose(negative, -da, da) if isinstance(da, Symbol) else da for da in slopes[0])


def _choice(_: Any, values: list[Any], slopes: list[Directions]) -> Directions:
    return tuple(choose(values[0], da, db) for da, db in zip(slopes[1], slopes[2], strict=True))


RULES: dict[str, Callable[[Any, list[Any], list[Directions]], Directions]] = {
    "+": _sum, "-": _difference, "*": _product, "/": _quotient, "sqrt": _root, "neg": _negative,
    "abs": _magnitude, "select": _choice,
}  # fmt: skip
"""Derivatives by operator; comparisons, truths and rounding have none."""


def tangent(
    step: Trace,
    rows: int,
    count: int,
    slopes_of_names: Callable[[Tangents], Mapping[str, Directions]] | None = None,
) -> Trace:
    """Return a trace with its derivatives in ``count`` directions, for a state of ``rows`` rows, operation by
    operation; ``slopes_of_names`` gives the derivatives of names that are no rows.
    """
    run = Tangents(rows, count)
    run.slopes |= slopes_of_names(run) if slopes_of_names else {}
    run.run(step.operations)
    return with_slopes(run, step)


def tangent_with_jumps(step: Trace, rows: int, count: int, velocities: Collection[int]) -> Trace:
    """Return the result of :func:`tangent` in which the slopes of the rows ``velocities`` contain the jumps
    of forces (:mod:`~vfife.compiler.trace.jumps`).

    A jump changes the velocities of neighbours by an impulse. Forces and accelerations stay without it: the
    next step, or a change of the step size, would use the impulse again.
    """
    with_impulse = Tangents(rows, count)
    with_impulse.run(step.operations)
    without = Tangents(rows, count, with_impulse.tape, jumps=False)
    without.run(step.operations)
    return with_slopes(without, step, dict.fromkeys(velocities, with_impulse))


def with_slopes(run: Tangents, step: Trace, runs: Mapping[int, Tangents] | None = None) -> Trace:
    """Return the trace that stores the results of ``step`` and their slopes; ``runs`` has those of some
    rows.
    """
    stores: dict[int, Any] = {}
    for row, operand in step.stores.items():
        stores[row] = run.value(operand)
        slopes = (runs or {}).get(row, run).slope(operand)
        stores |= {row + k * run.rows: slope for k, slope in enumerate(slopes, 1)}
    return run.tape.trace_of(stores, run.value(step.rare))


def of_size(step: int) -> Callable[[Tangents], Mapping[str, Directions]]:
    """Return the derivatives of ``size``, a fixed share of the step in row ``step``."""

    def slopes_of_names(run: Tangents) -> Mapping[str, Directions]:
        ratio = run.value("size") / run.value(f"v{step}")
        return {"size": tuple(slope * ratio for slope in run.slope(f"v{step}"))}

    return slopes_of_names


def of_time(step: int) -> Callable[[Tangents], Mapping[str, Directions]]:
    """Return the derivatives of times, which are multiples of the step in row ``step``."""

    def slopes_of_names(run: Tangents) -> Mapping[str, Directions]:
        reciprocal = 1.0 / run.value(f"v{step}")
        return {
            name: tuple(run.value(name) * (slope * reciprocal) for slope in run.slope(f"v{step}"))
            for name in ("time", "ahead", "after")
        }

    return slopes_of_names


Sum: TypeAlias = "dict[str, Any]"  # weights, symbols or constants, by the names whose slopes they multiply


@dataclass
class Node:
    """The slope of a result: one sum, or a choice between two by the truth of ``condition``; ``users`` are
    the results whose sums contain it, in a fixed order, so that every process writes the same text.
    """

    sums: list[Sum]
    condition: Any = None
    users: dict[str, None] = field(default_factory=dict)


class Elimination:
    """The slopes of a trace as sums, and the elimination of results from them.

    ``outputs`` are results that are stored, whose slopes are needed by themselves.
    """

    def __init__(self, run: Tangents, operations: Iterable[Operation], outputs: set[str]) -> None:
        self.run, self.outputs = run, outputs
        self.nodes: dict[str, Node] = {}
        # Slopes that are a multiple of a single other slope: its name and the factor.
        self.chains: dict[str, tuple[str, Any]] = {}
        for operation in operations:
            self._note(operation)

    def _note(self, operation: Operation) -> None:
        """Record an operation on the new tape; add a node for its slope unless that is zero."""
        name, operator, operands = operation
        values = [self.run.value(operand) for operand in operands]
        result = self.run.values[name] = self.run.tape.emit(operator, *values)
        # Comparisons, truth values and rounding have no slope, and so has everything that depends on rows by
        # them alone.
        if operator not in PARTIALS and operator != "select":
            return
        moving = [
            isinstance(operand, str) and (is_row(operand) or operand in self.nodes) for operand in operands
        ]
        if not any(moving):
            return
        if operator == "select":
            node = self._chosen(values[0], [str(operands[k]) if moving[k] else None for k in (1, 2)])
        else:
            total: Sum = {}
            for operand, weight, moves in zip(
                operands, PARTIALS[operator](result, values), moving, strict=True
            ):
                if moves:
                    total[str(operand)] = total[str(operand)] + weight if operand in total else weight
            node = Node([total])
        self.nodes[name] = node
        if node.condition is None:
            self._join(name, node.sums[0])
        self._used(name, node)

    def _join(self, name: str, terms: Sum) -> None:
        """Record a slope that is a multiple of a single other slope, however many operations are between."""
        chains = {operand: self._chain(operand) for operand in terms}
        first = {root for root, _ in chains.values()}
        if len(first) == 1:
            products = [_scaled(weight, chains[operand][1]) for operand, weight in terms.items()]
            self.chains[name] = first.pop(), sum(products[1:], start=products[0])

    def _chain(self, name: str) -> tuple[str, Any]:
        """Return the name and the factor of the slope of which ``name`` is a multiple, as far back as
        possible; itself and 1 if there is none.
        """
        return self.chains.get(name, (name, 1.0))

    def _chosen(self, condition: Any, arms: list[str | None]) -> Node:
        """Return the node of a choice between the slopes of ``arms`` (None for zero).

        If both are multiples of one slope, or one is zero and the other always finite, it is a choice of
        factors: a sum, which can be eliminated.
        """
        chains = [None if arm is None else self._chain(arm) for arm in arms]
        if chains[0] is not None and chains[1] is not None and chains[0][0] == chains[1][0]:
            return Node([{chains[0][0]: choose(condition, chains[0][1], chains[1][1])}])
        (moving,) = {arm for arm in arms if arm is not None} if arms.count(None) == 1 else (None,)
        if moving is not None and (is_row(moving) or moving in self.outputs):
            return Node([{moving: choose(condition, *(0.0 if arm is None else 1.0 for arm in arms))}])
        return Node([{arm: 1.0} if arm is not None else {} for arm in arms], condition)

    def _used(self, name: str, node: Node) -> None:
        for total in node.sums:
            for operand in total:
                if operand in self.nodes:
                    self.nodes[operand].users[name] = None

    def eliminate(self) -> None:
        """Eliminate results as long as this saves operations, the largest saving first.

        The heap is not updated: an entry whose gain has become smaller is put back when it is reached, and
        neighbours whose gain may have grown are added again.
        """
        waiting = [
            (-gain, place, name)
            for place, name in enumerate(self.nodes)
            if (gain := self._gain(name)) is not None and gain >= 0
        ]
        places = {name: place for place, name in enumerate(self.nodes)}
        heapq.heapify(waiting)
        while waiting:
            expected, place, name = heapq.heappop(waiting)
            gain = self._gain(name)
            if gain is None or gain < 0:
                continue
            # The gain has become smaller since the entry was made: others may be better now.
            if -gain > expected:
                heapq.heappush(waiting, (-gain, place, name))
                continue
            for neighbour in self._leave_out(name):
                if (better := self._gain(neighbour)) is not None and better >= 0:
                    heapq.heappush(waiting, (-better, places[neighbour], neighbour))

    def _gain(self, name: str) -> int | None:
        """Return the number of operations saved by eliminating a result; None if it has to stay."""
        node = self.nodes.get(name)
        if node is None or name in self.outputs or node.condition is not None:
            return None
        (terms,) = node.sums
        # Elimination trades operations of each direction (the sum of this result, and longer sums in its
        # users) for products of weights, which all directions share.
        directions, shared = _cost(terms), 0
        for user in node.users:
            for total in self.nodes[user].sums:
                if name in total:
                    outer, plain = (
                        total[name],
                        {operand: weight for operand, weight in total.items() if operand != name},
                    )
                    directions += _cost(total)
                    for operand, weight in terms.items():
                        shared += (not _unit(weight) and not _unit(outer)) + (operand in plain)
                        plain[operand] = (
                            OTHER_WEIGHT if operand in plain or not (_unit(weight) and _unit(outer)) else 1.0
                        )
                    directions -= _cost(plain)
        return SHARED_BY * directions - shared

    def _leave_out(self, name: str) -> set[str]:
        """Eliminate a result: replace it in the sums of its users; return the names of its neighbours."""
        node = self.nodes.pop(name)
        (terms,) = node.sums
        for user in node.users:
            for total in self.nodes[user].sums:
                if name in total:
                    outer = total.pop(name)
                    for operand, weight in terms.items():
                        product = _scaled(outer, weight)
                        total[operand] = total[operand] + product if operand in total else product
            self._used(user, self.nodes[user])
        neighbours = set(node.users)
        for operand in terms:
            if operand in self.nodes:
                self.nodes[operand].users.pop(name, None)
                neighbours.add(operand)
        return neighbours

    def slopes(self) -> None:
        """Record the slopes of all remaining results, in each direction."""
        place = {name: k for k, name in enumerate(self.nodes)}
        for name, node in self.nodes.items():
            parts = [
                self._sum(dict(sorted(total.items(), key=lambda item: place.get(item[0], -1))))
                for total in node.sums
            ]
            if node.condition is None:
                self.run.slopes[name] = parts[0]
            else:
                self.run.slopes[name] = tuple(
                    choose(node.condition, a, b) for a, b in zip(*parts, strict=True)
                )

    def _sum(self, total: Sum) -> Directions:
        sums: list[Any] = [0.0] * self.run.count
        for operand, weight in total.items():
            for k, slope in enumerate(self.run.slope(operand)):
                if _unit(weight) or not isinstance(slope, Symbol) or not isinstance(sums[k], Symbol):
                    sums[k] = sums[k] - slope if _minus(weight) else sums[k] + _scaled(weight, slope)
                else:
                    sums[k] = self.run.tape.emit("fused", weight, slope, sums[k])
        return tuple(sums)


# Number of directions for which operations are counted. It is fixed: with the actual number, the bits of a
# slope would depend on how many others are computed with it.
SHARED_BY = 4
HUGE = 1e150  # factors beyond this have squares that overflow
OTHER_WEIGHT = None  # stands for a weight that is neither 1 nor -1


def _minus(weight: Any) -> bool:
    return isinstance(weight, float) and weight == -1.0


def _unit(weight: Any) -> bool:
    return isinstance(weight, float) and abs(weight) == 1.0


def _scaled(a: Any, b: Any) -> Any:
    return -b if _minus(a) else -a if _minus(b) else a * b


def _cost(total: Sum) -> int:
    """Return the number of operations of a sum in each direction."""
    return max(0, len(total) - 1) + sum(not _unit(weight) for weight in total.values())


def _of_quotient(quotient: Any, values: list[Any]) -> tuple[Any, ...]:
    """Return the two partial derivatives of a quotient; zero if the divisor is nearly zero.

    Such a divisor was protected from being zero (1e-300) and its result is not used; the product of two such
    factors would overflow.
    """
    reciprocal = 1.0 / values[1]
    reciprocal = choose(abs(reciprocal) < HUGE, reciprocal, 0.0)
    return reciprocal, -(quotient * reciprocal)


def _of_root(root: Any, values: list[Any]) -> tuple[Any, ...]:
    return (choose(root > 1.0 / HUGE, 0.5 / root, 0.0),)


PARTIALS: dict[str, Callable[[Any, list[Any]], tuple[Any, ...]]] = {
    "+": lambda result, values: (1.0, 1.0),
    "-": lambda result, values: (1.0, -1.0),
    "*": lambda result, values: (values[1], values[0]),
    "/": _of_quotient,
    "sqrt": _of_root,
    "neg": lambda result, values: (-1.0,),
    "abs": lambda result, values: (choose(values[0] < 0.0, -1.0, 1.0),),
}
"""Derivatives of a result by each of its operands."""


def shared_tangent(step: Trace, rows: int, count: int) -> Trace:
    """Return the result of :func:`tangent` with fewer operations and other rounding, in a fast order.

    The numbers come first, then slope after slope, each in all directions at once, so that a factor is read
    once for all of them.
    """
    run = Tangents(rows, count)
    outputs = {operand for operand in step.stores.values() if isinstance(operand, str)}
    sums = Elimination(run, step.operations, outputs)
    sums.eliminate()
    shared = len(run.tape.operations)
    sums.slopes()
    total = with_slopes(run, step)
    stores = {row: value for row, value in total.stores.items() if row < rows}
    values = run.tape.needed([run.value(operand) for operand in [*step.stores.values(), step.rare]])
    first = ordered(Trace(values, stores, total.rare))
    slopes = [operation.name for operation in run.tape.operations[shared:]]
    return Trace((*first, *_lazily(total.operations, first, slopes)), total.stores, total.rare)


def _lazily(
    operations: Iterable[Operation], first: Iterable[Operation], slopes: Iterable[str]
) -> list[Operation]:
    """Return the operations that are not among ``first``: ``slopes`` in their order, and each factor just
    before the first slope that needs it.
    """
    results = {operation.name: operation for operation in operations}
    done = {operation.name for operation in first}

    def missing(name: str) -> list[str]:
        return [used for used in results[name].uses if used in results and used not in done]

    roots = [name for name in slopes if name in results and name not in done]
    return [results[name] for name in depth_first(roots, missing)]
