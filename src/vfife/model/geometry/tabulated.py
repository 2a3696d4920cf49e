"""Functions given by tables or expressions, as piecewise polynomials."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...numerics import splines
from ...numerics.dense import inverse, times
from ...numerics.elementwise import cos
from .expression import Expression, parse
from .polynomials import Polynomials, moved

Array: TypeAlias = NDArray[np.float64]

Interpolation = Literal["monotone", "linear", "spline"]
INTERPOLATIONS: tuple[Interpolation, ...] = ("monotone", "linear", "spline")
JOINING = (
    "how a table's values are joined: monotone (never beyond them), linear, or a spline, which is smoother"
    " and may overshoot"
)
GAP_RANGES = 64.0  # ranges of a table by which that of the way back lies before that of the way out
CLOSED = 1e-8  # largest difference of first and last value of a periodic table, over its largest value

Places = Sequence[float]
Rows = tuple[tuple[float, ...], ...]


def rows_between(
    places: Places, values: Places, interpolation: Interpolation = "monotone", *, repeated: bool = False
) -> Rows:
    """Return the coefficients, constant first, of the polynomial from each place to the next.

    ``monotone``: cubic pieces after Fritsch and Carlson (1980), monotone where the values are, without
    overshoot; ``linear``; ``spline``: a cubic spline with continuous curvature, natural at its ends, which
    may overshoot. A ``repeated`` table is continued periodically. Needs at least two ascending places.
    """
    count = len(places) - 1
    if interpolation == "linear" or (count == 1 and not repeated):
        slopes = [(values[k + 1] - values[k]) / (places[k + 1] - places[k]) for k in range(count)]
        return tuple((float(values[k]), float(slopes[k])) for k in range(count))
    if interpolation == "spline":
        return tuple(splines.periodic(places, values) if repeated else splines.natural(places, values))
    if repeated:
        period, overlap = places[-1] - places[0], min(count, 2)
        around = (
            *(p - period for p in places[-1 - overlap : -1]),
            *places,
            *(p + period for p in places[1 : 1 + overlap]),
        )
        rows = splines.monotone(
            around, (*values[-1 - overlap : -1], *values[:-1], values[0], *values[1 : 1 + overlap])
        )
        return tuple(rows[overlap : overlap + count])
    return tuple(splines.monotone(places, values))


@dataclass(frozen=True)
class Pieces:
    """Polynomials over a range: the beginning of each, its coefficients from there (constant first), and the
    end of the last.

    ``edges`` are the pieces at whose beginning the function may jump or kink; by default all but the first.
    """

    starts: tuple[float, ...]
    rows: Rows
    end: float
    edges: tuple[int, ...] | None = None

    @property
    def inner(self) -> tuple[int, ...]:
        """Indices of the pieces at whose beginning the function may jump or kink."""
        return tuple(range(1, len(self.starts))) if self.edges is None else self.edges

    @property
    def ends(self) -> tuple[float, float]:
        """First and last value."""
        return self.rows[0][0], polynomial_at(self.rows[-1], self.end - self.starts[-1])

    @property
    def largest(self) -> float:
        """Largest absolute value at the ends of pieces."""
        return max(abs(value) for value in (*(row[0] for row in self.rows), self.ends[1]))

    @property
    def closes(self) -> bool:
        """Whether the first and last value agree, as those of a function over its periods do."""
        first, last = self.ends
        return abs(last - first) <= CLOSED * self.largest

    @property
    def span(self) -> float:
        """Length of the range."""
        return self.end - self.starts[0]


def polynomial_at(row: tuple[float, ...], x: float) -> float:
    """Return the value of a polynomial, constant first."""
    value = 0.0
    for c in reversed(row):
        value = value * x + c
    return value


def table(
    places: Places, values: Places, interpolation: Interpolation = "monotone", *, repeated: bool = False
) -> Pieces:
    """Return the pieces of a table; arguments as in :func:`rows_between`."""
    return Pieces(
        tuple(map(float, places[:-1])),
        rows_between(places, values, interpolation, repeated=repeated),
        float(places[-1]),
    )


def extended(pieces: Pieces) -> Polynomials:
    """Return the function that keeps its end values beyond its ends."""
    first, last = pieces.ends
    starts = (pieces.starts[0] - pieces.span, *pieces.starts, pieces.end)
    rows = ((first,), *pieces.rows, (last,))
    return Polynomials(starts, rows, order=0, edges=(1, *(k + 1 for k in pieces.inner), len(starts) - 1))


def repeated(pieces: Pieces) -> Polynomials:
    """Return the function continued periodically."""
    starts = tuple(start - pieces.starts[0] for start in pieces.starts)
    return moved(
        Polynomials(starts, pieces.rows, pieces.span, order=0, edges=(0, *pieces.inner)), pieces.starts[0]
    )


def two_ways(out: Pieces, back: Pieces) -> tuple[Polynomials, float]:
    """Return a function of the travel with different values on the forward and the return stroke, and the gap
    (m) by which the part for the return stroke lies before the other.

    Each part keeps its end values beyond its ends. Between the parts is a kink, so that a step in which the
    direction reverses is divided.
    """
    gap = GAP_RANGES * out.span
    returning, forward = moved(extended(back), -gap), extended(out)
    halfway = 0.5 * (back.end - gap + out.starts[0])
    starts = (*returning.starts, halfway, *forward.starts[1:])
    turn = len(returning.starts)
    edges = (*(returning.edges or ()), turn, *(turn + k for k in forward.edges or ()))
    return (
        Polynomials(
            starts, (*returning.coefficients, *forward.coefficients), order=0, breaks=(turn,), edges=edges
        ),
        gap,
    )


def closes(values: Places) -> bool:
    """Return whether the first and last value of a table agree."""
    return abs(values[-1] - values[0]) <= CLOSED * max(abs(value) for value in values)


def full_turns(angles: Places) -> bool:
    """Return whether the angles (rad) of a table cover a whole number of turns."""
    turns = (angles[-1] - angles[0]) / (2.0 * math.pi)
    return round(turns) >= 1 and abs(turns - round(turns)) < 1e-9


RIGHT = 1e-9  # error of a piece that is accepted, over the largest value of the function
ROUGH = 1e-6  # error that is accepted in a piece that cannot be halved, such as next to the root of sqrt(x)
GRID = 4001  # places at which a range is searched for changes of sign
MOST_PIECES = 4000  # pieces
COUNT, LOOKED = 7, 23  # places of a piece that its polynomial interpolates, and at which its error is checked


class ApproximationError(ValueError):
    """A function that polynomials cannot approximate, and where."""


@lru_cache(maxsize=64)
def sampled(text: str, first: float, last: float) -> Pieces:
    """Return an expression over a range as pieces, each halved until it agrees with the expression.

    Raises Fault for an invalid text, and ApproximationError, with the place, if the function is singular,
    jumps without a known switch or oscillates too much.
    """
    expression = parse(text)
    grid = np.linspace(first, last, GRID)
    values = expression(grid)
    if not np.isfinite(values).all():
        raise ApproximationError(
            f"it has no finite value at {expression.variable or 'x'} = {grid[~np.isfinite(values)][0]:.6g}"
        )
    size = float(np.abs(values).max()) or 1.0
    edges = [first, *breaks(expression, grid), last]
    pending = [(low, high) for low, high in zip(edges, edges[1:], strict=False)][::-1]
    starts: list[float] = []
    rows: list[tuple[float, ...]] = []
    while pending:
        low, high = pending.pop()
        row, missed = fitted(expression, low, high)
        missed = max(
            missed, missed_between(row, low, grid, values, *np.searchsorted(grid, (low, high)).tolist())
        )
        smallest = high - low <= 8.0 * float(np.spacing(max(abs(low), abs(high))))
        if missed <= RIGHT * size or (smallest and missed <= ROUGH * size):
            starts.append(low)
            rows.append(row)
        elif smallest or len(starts) + len(pending) > MOST_PIECES:
            location = f"{expression.variable} = {0.5 * (low + high):.6g}"
            raise ApproximationError(
                f"it cannot be approximated near {location}: it jumps, grows without bound, or oscillates too"
                " often"
            )
        else:
            pending += [(0.5 * (low + high), high), (low, 0.5 * (low + high))]
    return Pieces(
        tuple(starts), tuple(rows), last, tuple(k for k, start in enumerate(starts) if start in edges[1:-1])
    )


@lru_cache(maxsize=1)
def scheme() -> tuple[Array, Array, Array, Array]:
    """Return the interpolation scheme of a piece from 0 to 1: places of values, the matrix from values to
    coefficients, places of checks, the matrix from coefficients to values there. No place is at an end, where
    the function may jump.
    """
    nodes = 0.5 - 0.5 * cos(np.pi * (np.arange(COUNT) + 0.5) / COUNT)
    checks = (np.arange(LOOKED) + 0.5) / LOOKED
    fit: Array = inverse(np.vander(nodes, COUNT, increasing=True))
    return nodes, fit, checks, np.vander(checks, COUNT, increasing=True)


def fitted(expression: Callable[[Array], Array], low: float, high: float) -> tuple[tuple[float, ...], float]:
    """Return the polynomial from ``low`` to ``high`` and its largest error at the places of checks; infinite
    where the function is undefined.
    """
    nodes, fit, checks, powers = scheme()
    width = high - low
    row: Array = times(fit, expression(low + width * nodes))
    values: Array = expression(low + width * checks)
    missed = float(np.abs(np.subtract(times(powers, row), values)).max())
    return tuple(float(value) for value in row / np.vander([width], COUNT, increasing=True)[0]), (
        missed if np.isfinite(missed) else np.inf
    )


def missed_between(
    row: tuple[float, ...], low: float, grid: Array, values: Array, first: int, last: int
) -> float:
    """Return the largest error of a polynomial from ``low`` at the grid points of its piece: a pulse may lie
    between the places of :func:`fitted`.
    """
    inside = slice(first + (grid[first] == low), last)
    return float(
        np.abs(np.polynomial.polynomial.polyval(grid[inside] - low, row) - values[inside]).max(initial=0.0)
    )


def breaks(expression: Expression, grid: Array) -> list[float]:
    """Return where the function may kink or jump between points of the grid, to the last bit."""
    places = set()
    with np.errstate(all="ignore"):
        for switch in expression.tree.switches():
            values = switch.at(grid)
            for k in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0):
                places.add(crossing(switch.at, float(grid[k]), float(grid[k + 1])))
            places |= {float(grid[k]) for k in np.flatnonzero(values[1:-1] == 0.0) + 1}
    return sorted(place for place in places if grid[0] < place < grid[-1])


def crossing(function: Callable[[Array], Array], low: float, high: float) -> float:
    """Return the zero of a function that changes sign between two places, by bisection."""
    negative = float(function(np.array([low]))[0]) < 0.0
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (
            (middle, high) if (float(function(np.array([middle]))[0]) < 0.0) == negative else (low, middle)
        )
    return high
