"""Tangent stiffness and stored energy of a contact law, from its elastic force."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..compiler.trace.tape import Tape, needed, operand_of
from ..compiler.trace.traceable import WRITING, Traceable
from ..numerics.elementwise import interpolate
from .law import ContactLaw

Array = NDArray[np.float64]

BISECTIONS = 60  # of an interval of depths with a ratio of two: to the last bit


def tangent(law: ContactLaw, slots: tuple[float, ...], force: float) -> tuple[float, float]:
    """Return the penetration (m) at which a contact law carries ``force`` (N) at rest, and its tangent
    stiffness (N/m) there.
    """
    kind: Any = type(law)
    return _tangent(kind, tuple(slots), force)  # a class has a hash, whatever its instances have


@lru_cache(maxsize=4096)
def _tangent(law: type[ContactLaw], slots: tuple[float, ...], load: float) -> tuple[float, float]:
    """Return the same from the law's class and its parameters, which decide it.

    The depth is searched by doubling, then by bisection on a logarithmic scale, because laws cover many
    orders of magnitude. A static analysis calls this thousands of times, so it uses plain numbers.
    """
    force = law.force
    low, high = 1e-15, 1e-9
    while force(high, 0.0, slots)[0] < load and high < 1.0:
        low, high = high, 2.0 * high
    for _ in range(BISECTIONS):
        middle = math.sqrt(low * high)
        if force(middle, 0.0, slots)[0] < load:
            low = middle
        else:
            high = middle
    return high, (float(force(1.001 * high, 0.0, slots)[0]) - float(force(0.999 * high, 0.0, slots)[0])) / (
        0.002 * high
    )


def tangents(
    laws: Sequence[ContactLaw], slots: Sequence[tuple[float, ...]], forces: Sequence[float]
) -> list[tuple[float, float]]:
    """Return the result of :func:`tangent` for many laws, those of one class side by side if their elastic
    force is arithmetic.
    """
    result: dict[int, tuple[float, float]] = {}
    groups: dict[Any, list[int]] = {}
    for k, law in enumerate(laws):
        groups.setdefault((type(law), len(slots[k])), []).append(k)
    for (kind, count), numbers in groups.items():
        elastic = on_arrays(kind, count) if len(numbers) >= FEWEST_LAWS else None
        if elastic is not None:
            load = np.array([forces[k] for k in numbers])
            values = np.array([slots[k] for k in numbers]).T
            result |= zip(numbers, _side_by_side(elastic, values, load), strict=True)
        else:
            result |= {k: tangent(laws[k], slots[k], forces[k]) for k in numbers}
    return [result[k] for k in range(len(laws))]


FEWEST_LAWS = 8  # from which arrays are faster than plain numbers


ARITHMETIC = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "sqrt": np.sqrt, "neg": np.negative,
}  # fmt: skip
Elastic: TypeAlias = Callable[[Array, Array], Array]


@lru_cache(maxsize=256)
def on_arrays(law: type[ContactLaw], count: int) -> Elastic | None:
    """Return the elastic force (N) of a law as a function of arrays of penetrations (m), shape (cases,), and
    of ``count`` slots, shape (slots, cases), from the operations of its step; None if it needs more than
    arithmetic and square roots, which have the same bits for arrays and numbers.
    """
    if law.tabled:
        return None
    tape = Tape()
    depth, *slots = (tape.load(row) for row in range(count + 1))
    with WRITING:
        traceable = Traceable(tape)
        force = operand_of(traceable.exactly(traceable(law.force))(depth, 0.0, tuple(slots))[0])
    operations = needed(tape.operations, [force])
    if not isinstance(force, str) or not {operation.operator for operation in operations} <= {*ARITHMETIC}:
        return None

    def elastic(depths: Array, numbers: Array) -> Array:
        values: dict[Any, Any] = {"v0": depths} | {f"v{k}": row for k, row in enumerate(numbers, 1)}
        for name, operator, operands in operations:
            values[name] = ARITHMETIC[operator](*(values.get(operand, operand) for operand in operands))
        return np.asarray(values[force])

    return elastic


def _side_by_side(elastic: Elastic, slots: Array, load: Array) -> list[tuple[float, float]]:
    """Search the depths of all loads at once, each by the steps of :func:`_tangent`."""
    with np.errstate(all="ignore"):
        low, high = np.full(load.shape, 1e-15), np.full(load.shape, 1e-9)
        while (doubled := (elastic(high, slots) < load) & (high < 1.0)).any():
            low, high = np.where(doubled, high, low), np.where(doubled, 2.0 * high, high)
        for _ in range(BISECTIONS):
            middle = np.sqrt(low * high)
            shallow = elastic(middle, slots) < load
            low, high = np.where(shallow, middle, low), np.where(shallow, high, middle)
        upper, lower = (elastic(share * high, slots) for share in (1.001, 0.999))
        slope = (upper - lower) / (0.002 * high)
    return list(zip(high.tolist(), slope.tolist(), strict=True))


def elastic_energy(law: ContactLaw, depth: Array, slots: tuple[float, ...]) -> Array:
    """Return the elastic energy (J) at penetrations (m): the law's own formula, or the integral of its
    elastic force by the trapezoidal rule.
    """
    try:
        return np.asarray(law.elastic_energy(depth, slots), dtype=float)
    except NotImplementedError:
        grid = np.linspace(0.0, max(float(depth.max()), 1e-12), 2001)
        force = np.array([law.force(float(d), 0.0, slots)[0] for d in grid])
        steps = 0.5 * (force[1:] + force[:-1]) * np.diff(grid)
        return np.asarray(interpolate(depth, grid, np.concatenate([[0.0], np.cumsum(steps)])), dtype=float)
