"""Derivatives of residuals by what is looked for: carried along the run, or as differences of runs in lanes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly
from ...errors import VfifeError
from ...solvers.tangents import Neighbours, comparable, tangents
from .curves import Curves, Trace
from .misfit import Misfit
from .sought import Sought, numbers_at

Array = NDArray[np.float64]
SIDE = 2e-3  # of the way between the bounds, to each side: differences
NEAR = 1e-6  # the same, of the start from which steps carry their derivatives along
ALIKE, SIZED = 0.98, 0.2  # direction of two columns that agree, and by how much their lengths may differ
NOTHING = 1e-6  # of the longest column: what is shorter is not compared


@dataclass(frozen=True)
class Point:
    """Shares of the ways between the bounds; ``sides``: not the trace there, but those to both sides of each parameter, by derivatives."""

    shares: tuple[float, ...]
    sides: bool = False


Ask = Callable[[Sequence[Point]], list[Any]]


def answers(curves: Curves, sought: Sequence[Sought], points: Sequence[Point]) -> list[Any]:
    """Traces of points, all that can be together in lanes; an error for those that have no derivatives."""
    plain = [numbers_at(sought, np.array(one.shares)) for one in points if not one.sides]
    traces = iter(curves.each(plain) if plain else ())
    return [tried(curves, sought, np.array(one.shares)) if one.sides else next(traces) for one in points]


def tried(curves: Curves, sought: Sequence[Sought], shares: Array) -> list[tuple[Trace, Trace]] | VfifeError:
    """Traces to both sides, or why there are none."""
    try:
        return carried(curves, sought, shares)
    except VfifeError as error:
        return error


def carried(curves: Curves, sought: Sequence[Sought], shares: Array) -> list[tuple[Trace, Trace]]:
    """Traces to both sides of each parameter, ``SIDE`` away, as far as first derivatives tell them. Raises VfifeError where there are none."""
    members = curves.members
    here = members.assembled(numbers_at(sought, shares))
    every = [neighbours(curves, sought, shares, k) for k in range(len(sought))]
    for one, near in zip(sought, every, strict=True):
        if not comparable(here, near):
            raise VfifeError(f"{one.name} changes how many steps or pieces there are")
    return [stretched(curves, pairs[0], near.apart) for pairs, near in zip(tangents(here, every), every, strict=True)]


def neighbours(curves: Curves, sought: Sequence[Sought], shares: Array, k: int) -> Neighbours:
    """Assemblies with one parameter a little larger and a little smaller."""
    found: list[Assembly] = []
    for sign in (1.0, -1.0):
        beside = shares.copy()
        beside[k] = np.clip(shares[k] + sign * NEAR, 0.0, 1.0)
        found.append(curves.members.assembled(numbers_at(sought, beside)))
    ends = np.clip([shares[k] + NEAR, shares[k] - NEAR], 0.0, 1.0)
    return Neighbours(found[0], found[1], float(ends[0] - ends[1]))


def stretched(curves: Curves, pair: tuple[Any, Any], apart: float) -> tuple[Trace, Trace]:
    """Traces ``SIDE`` to both sides of the middle of two that are so far ``apart``."""
    up, down = (curves.trace(one) for one in pair)
    ratio = 2.0 * SIDE / apart
    sides = []
    for sign in (0.5, -0.5):
        places = 0.5 * (up.places + down.places) + sign * ratio * (up.places - down.places)
        values = 0.5 * (up.values + down.values) + sign * ratio * (up.values - down.values)
        turn = None if up.turn is None or down.turn is None else 0.5 * (up.turn + down.turn) + sign * ratio * (up.turn - down.turn)
        sides.append(Trace(places, values, turn))
    return sides[0], sides[1]


@dataclass(frozen=True)
class Slopes:
    """Derivatives by shares of the ways between the bounds: of the residuals, shape (residuals, parameters), and of the offset, (parameters,)."""

    jacobian: Array
    offsets: Array

    @staticmethod
    def of(found: Sequence[Any], misfit: Misfit, shares: Array, offset: float, by_steps: bool) -> Slopes:
        """Those of what was asked for; offset, factor and level follow each side, as in variable projection."""
        pairs = [(*sides, 2.0 * SIDE) for sides in found[0]] if by_steps else list(differences(found, shares))
        columns, offsets = [], []
        for up, down, apart in pairs:
            if isinstance(up, str) or isinstance(down, str):
                columns.append(np.zeros(misfit.count))
                offsets.append(0.0)
                continue
            above, below = misfit(up, offset), misfit(down, offset)
            columns.append((above.residuals - below.residuals) / apart)
            offsets.append((above.offset - below.offset) / apart)
        return Slopes(np.stack(columns, axis=1), np.array(offsets))


def questions(shares: Array, by_steps: bool) -> list[Point]:
    """What is asked for derivatives at a point."""
    if by_steps:
        return [Point(tuple(shares), True)]
    return [Point(tuple(np.where(np.arange(len(shares)) == k, end, shares))) for k in range(len(shares)) for end in sides(float(shares[k]))]


def sides(share: float) -> tuple[float, float]:
    """A little more and a little less, within the bounds."""
    return min(share + SIDE, 1.0), max(share - SIDE, 0.0)


def differences(traces: Sequence[Any], shares: Array) -> Iterator[tuple[Any, Any, float]]:
    """Traces to both sides of each parameter, and how far these are apart."""
    for k, share in enumerate(shares):
        high, low = sides(float(share))
        yield traces[2 * k], traces[2 * k + 1], high - low


def compared(one: Slopes, other: Slopes) -> bool:
    """Whether two Jacobians say the same: each column in direction and length."""
    sizes, others = (np.linalg.norm(each.jacobian, axis=0) for each in (one, other))
    largest = max(float(others.max(initial=0.0)), 1e-300)
    for k, (size, beside) in enumerate(zip(sizes, others, strict=True)):
        if beside <= NOTHING * largest:
            continue
        direction = float(one.jacobian[:, k] @ other.jacobian[:, k]) / max(float(size * beside), 1e-300)
        if not (direction >= ALIKE and abs(size / beside - 1.0) <= SIZED):
            return False
    return True
