"""Tables of values as piecewise polynomials: joined linearly, by a spline or monotonely, held at their ends, repeated, or different on two ways."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ..numerics import splines
from .polynomials import Polynomials, moved

Interpolation = Literal["monotone", "linear", "spline"]
INTERPOLATIONS: tuple[Interpolation, ...] = ("monotone", "linear", "spline")
JOINING = "how a table's values are joined: monotone (never beyond them), linear, or a spline, which is smoother and may overshoot"
APART = 64.0  # ranges of a table by which that of the way back lies before that of the way out
CLOSED = 1e-8  # of the largest value, by which the first and the last value of a table that repeats may differ

Places = Sequence[float]
Rows = tuple[tuple[float, ...], ...]


def rows_between(places: Places, values: Places, how: Interpolation = "monotone", *, repeated: bool = False) -> Rows:
    """Coefficients, constant first, of the piece from each place to the next.

    ``monotone``: cubic pieces after Fritsch and Carlson (1980), which rise only where the values do and never leave them; ``linear``;
    ``spline``: a cubic spline with steady curvature, natural at its ends, which may overshoot. Pieces of a table that is ``repeated`` meet at
    its ends as they do inside. Needs at least two ascending places.
    """
    count = len(places) - 1
    if how == "linear" or (count == 1 and not repeated):
        slopes = [(values[k + 1] - values[k]) / (places[k + 1] - places[k]) for k in range(count)]
        return tuple((float(values[k]), float(slopes[k])) for k in range(count))
    if how == "spline":
        return tuple(splines.periodic(places, values) if repeated else splines.natural(places, values))
    if repeated:
        period, more = places[-1] - places[0], min(count, 2)
        around = (*(p - period for p in places[-1 - more : -1]), *places, *(p + period for p in places[1 : 1 + more]))
        there = splines.monotone(around, (*values[-1 - more : -1], *values[:-1], values[0], *values[1 : 1 + more]))
        return tuple(there[more : more + count])
    return tuple(splines.monotone(places, values))


@dataclass(frozen=True)
class Pieces:
    """Polynomials over a range: where each begins, its coefficients from there, constant first, and where the last one ends.

    ``edges`` are those at whose begin the function may leap or bend; all but the first unless said.
    """

    starts: tuple[float, ...]
    rows: Rows
    end: float
    edges: tuple[int, ...] | None = None

    @property
    def inner(self) -> tuple[int, ...]:
        """The pieces at whose begin the function may leap or bend."""
        return tuple(range(1, len(self.starts))) if self.edges is None else self.edges

    @property
    def ends(self) -> tuple[float, float]:
        """Its first and its last value."""
        return self.rows[0][0], polynomial_at(self.rows[-1], self.end - self.starts[-1])

    @property
    def largest(self) -> float:
        """Its largest absolute value where pieces begin and end."""
        return max(abs(value) for value in (*(row[0] for row in self.rows), self.ends[1]))

    @property
    def span(self) -> float:
        """Length of the range."""
        return self.end - self.starts[0]


def polynomial_at(row: tuple[float, ...], x: float) -> float:
    """Value of a polynomial, constant first."""
    value = 0.0
    for c in reversed(row):
        value = value * x + c
    return value


def table(places: Places, values: Places, how: Interpolation = "monotone", *, repeated: bool = False) -> Pieces:
    """A table's pieces, as :func:`rows_between` has them."""
    return Pieces(tuple(map(float, places[:-1])), rows_between(places, values, how, repeated=repeated), float(places[-1]))


def held(pieces: Pieces) -> Polynomials:
    """A force that keeps its end values beyond its ends."""
    first, last = pieces.ends
    starts, rows = (pieces.starts[0] - pieces.span, *pieces.starts, pieces.end), ((first,), *pieces.rows, (last,))
    return Polynomials(starts, rows, order=0, edges=(1, *(k + 1 for k in pieces.inner), len(starts) - 1))


def repeated(pieces: Pieces) -> Polynomials:
    """A force that repeats itself, from the first place to the last."""
    starts = tuple(start - pieces.starts[0] for start in pieces.starts)
    return moved(Polynomials(starts, pieces.rows, pieces.span, order=0, edges=(0, *pieces.inner)), pieces.starts[0])


def two_ways(out: Pieces, back: Pieces) -> tuple[Polynomials, float]:
    """A force over a travel on the way out and on the way back, and the gap (m) by which the second lies before the first.

    Each keeps its end values beyond its ends; between them is a kink, so that a step in which the way changes is taken in parts.
    """
    gap = APART * out.span
    before, after = moved(held(back), -gap), held(out)
    halfway = 0.5 * (back.end - gap + out.starts[0])
    starts = (*before.starts, halfway, *after.starts[1:])
    turn = len(before.starts)
    edges = (*(before.edges or ()), turn, *(turn + k for k in after.edges or ()))
    return Polynomials(starts, (*before.coefficients, *after.coefficients), order=0, breaks=(turn,), edges=edges), gap


def closes(values: Places) -> bool:
    """Whether a table's first and last values are the same."""
    return abs(values[-1] - values[0]) <= CLOSED * max(abs(value) for value in values)


def whole_turns(angles: Places) -> bool:
    """Whether a table's angles (rad) go round once, or a whole number of times."""
    turns = (angles[-1] - angles[0]) / (2.0 * math.pi)
    return round(turns) >= 1 and abs(turns - round(turns)) < 1e-9
