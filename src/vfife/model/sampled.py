"""Functions as piecewise polynomials of degree 6, to a billionth of their range."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, TypeAlias

from .expression import Expression, parse
from .tabulated import Pieces

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array: TypeAlias = NDArray[np.float64]

RIGHT = 1e-9  # of the largest value: by how much a piece may miss the function
ROUGH = 1e-6  # the same where halving comes to an end: beside the root of a square root, say
GRID = 4001  # places at which a range is looked through for signs that change
MOST = 4000  # pieces
COUNT, LOOKED = 7, 23  # places in a piece that its polynomial goes through, and at which it is checked


class SamplingError(ValueError):
    """A function that polynomials cannot follow, and where."""


@lru_cache(maxsize=64)
def sampled(text: str, first: float, last: float) -> Pieces:
    """An expression over a range as pieces. Raises Fault for a text that is none, and SamplingError where pieces cannot follow it."""
    import numpy as np

    expression = parse(text)
    grid = np.linspace(first, last, GRID)
    values = expression(grid)
    if not np.isfinite(values).all():
        raise SamplingError(f"it has no finite value at {expression.variable or 'x'} = {grid[~np.isfinite(values)][0]:.6g}")
    size = float(np.abs(values).max()) or 1.0
    edges = [first, *breaks(expression, grid), last]
    pending = [(low, high) for low, high in zip(edges, edges[1:], strict=False)][::-1]
    starts: list[float] = []
    rows: list[tuple[float, ...]] = []
    while pending:
        low, high = pending.pop()
        row, missed = fitted(expression, low, high)
        missed = max(missed, missed_between(row, low, grid, values, *np.searchsorted(grid, (low, high)).tolist()))
        ended = high - low <= 8.0 * float(np.spacing(max(abs(low), abs(high))))
        if missed <= RIGHT * size or (ended and missed <= ROUGH * size):
            starts.append(low)
            rows.append(row)
        elif ended or len(starts) + len(pending) > MOST:
            where = f"{expression.variable} = {0.5 * (low + high):.6g}"
            raise SamplingError(f"it cannot be followed near {where}: it leaps, grows beyond all bounds, or has too many waves")
        else:
            pending += [(0.5 * (low + high), high), (low, 0.5 * (low + high))]
    return Pieces(tuple(starts), tuple(rows), last, tuple(k for k, start in enumerate(starts) if start in edges[1:-1]))


@lru_cache(maxsize=1)
def scheme() -> tuple[Array, Array, Array, Array]:
    """In a piece from 0 to 1: places of values, the matrix from these to coefficients, places of checks, that from coefficients to values there.

    No place is at its ends, where the function may leap.
    """
    import numpy as np

    from ..numerics.dense import inverse
    from ..numerics.elementwise import cos

    nodes = 0.5 - 0.5 * cos(np.pi * (np.arange(COUNT) + 0.5) / COUNT)
    checks = (np.arange(LOOKED) + 0.5) / LOOKED
    fit: Array = inverse(np.vander(nodes, COUNT, increasing=True))
    return nodes, fit, checks, np.vander(checks, COUNT, increasing=True)


def fitted(expression: Callable[[Array], Array], low: float, high: float) -> tuple[tuple[float, ...], float]:
    """Coefficients of a polynomial from one place to another, and by how much it misses the function; infinite where that has no value."""
    import numpy as np

    from ..numerics.products import times

    nodes, fit, checks, powers = scheme()
    width = high - low
    row: Array = times(fit, expression(low + width * nodes))
    wanted: Array = expression(low + width * checks)
    missed = float(np.abs(np.subtract(times(powers, row), wanted)).max())
    return tuple(float(value) for value in row / np.vander([width], COUNT, increasing=True)[0]), missed if np.isfinite(missed) else np.inf


def missed_between(row: tuple[float, ...], low: float, grid: Array, values: Array, first: int, last: int) -> float:
    """By how much a polynomial from ``low`` on misses values of the grid within its piece: a pulse may lie between those of :func:`fitted`."""
    import numpy as np

    inside = slice(first + (grid[first] == low), last)
    return float(np.abs(np.polynomial.polynomial.polyval(grid[inside] - low, row) - values[inside]).max(initial=0.0))


def breaks(expression: Expression, grid: Array) -> list[float]:
    """Where the function may bend or leap: between two places of the grid, to the last bit."""
    import numpy as np

    found = set()
    with np.errstate(all="ignore"):
        for switch in expression.tree.switches():
            values = switch.at(grid)
            for k in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0):
                found.add(crossing(switch.at, float(grid[k]), float(grid[k + 1])))
            found |= {float(grid[k]) for k in np.flatnonzero(values[1:-1] == 0.0) + 1}
    return sorted(place for place in found if grid[0] < place < grid[-1])


def crossing(function: Callable[[Array], Array], low: float, high: float) -> float:
    """Where a function that changes its sign between two places does so, by bisection."""
    import numpy as np

    below = float(function(np.array([low]))[0]) < 0.0
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if (float(function(np.array([middle]))[0]) < 0.0) == below else (low, middle)
    return high
