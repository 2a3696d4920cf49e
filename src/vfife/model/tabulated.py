"""Tables of values as piecewise polynomials: joined linearly, by a spline or monotonely, held at their ends, repeated, or different on two ways."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from .polynomials import Polynomials, moved

Interpolation = Literal["monotone", "linear", "spline"]
INTERPOLATIONS: tuple[Interpolation, ...] = ("monotone", "linear", "spline")
JOINING = "how a table's values are joined: monotone (never beyond them), linear, or a spline, which is smoother and may overshoot"
APART = 64.0  # ranges of a table by which that of the way back lies before that of the way out
CLOSED = 1e-9  # of the largest value, by which the first and the last value of a table that repeats may differ

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
    from scipy.interpolate import CubicSpline, PchipInterpolator

    if how == "spline":
        closing = (*values[:-1], values[0])
        fit, first = CubicSpline(places, closing if repeated else values, bc_type="periodic" if repeated else "natural"), 0
    elif repeated:
        period, more = places[-1] - places[0], min(count, 2)
        around = (*(p - period for p in places[-1 - more : -1]), *places, *(p + period for p in places[1 : 1 + more]))
        fit, first = PchipInterpolator(around, (*values[-1 - more : -1], *values[:-1], values[0], *values[1 : 1 + more])), more
    else:
        fit, first = PchipInterpolator(places, values), 0
    return tuple(tuple(float(c) for c in fit.c[::-1, first + k]) for k in range(count))


def held(places: Places, values: Places, how: Interpolation = "monotone") -> Polynomials:
    """A table of forces that keeps its end values beyond its ends."""
    return Polynomials(
        (float(2.0 * places[0] - places[-1]), *map(float, places)),
        ((float(values[0]),), *rows_between(places, values, how), (float(values[-1]),)),
        order=0,
    )


def repeated(places: Places, values: Places, how: Interpolation = "monotone") -> Polynomials:
    """A table of forces that repeats itself, from its first place to its last."""
    period = float(places[-1] - places[0])
    starts = tuple(float(place - places[0]) for place in places[:-1])
    return moved(Polynomials(starts, rows_between(places, values, how, repeated=True), period, order=0), float(places[0]))


def two_ways(places: Places, out: Places, back: Places, how: Interpolation = "monotone") -> tuple[Polynomials, float]:
    """A table of forces over a travel with values for the way out and for the way back, and the gap (m) by which the second lies before the first.

    Each keeps its end values beyond its ends; between them is a kink, so that a step in which the way changes is taken in parts.
    """
    first, last = float(places[0]), float(places[-1])
    gap = APART * (last - first)
    halves = held([place - gap for place in places], back, how), held(places, out, how)
    halfway = 0.5 * (last - gap + first)
    starts = (*halves[0].starts, halfway, *halves[1].starts[1:])
    rows = (*halves[0].coefficients, *halves[1].coefficients)
    return Polynomials(starts, rows, order=0, breaks=(len(places) + 1,)), gap


def closes(values: Places) -> bool:
    """Whether a table's first and last values are the same."""
    return abs(values[-1] - values[0]) <= CLOSED * max(abs(value) for value in values)


def whole_turns(angles: Places) -> bool:
    """Whether a table's angles (rad) go round once, or a whole number of times."""
    turns = (angles[-1] - angles[0]) / (2.0 * math.pi)
    return round(turns) >= 1 and abs(turns - round(turns)) < 1e-9
