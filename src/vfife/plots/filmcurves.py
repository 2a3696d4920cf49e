"""Joint forces that run beside a film."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .quantities import Quantity
from .turn import Span, abscissa, axis_title, one_turn

if TYPE_CHECKING:
    from ..results.view import View

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ForceCurve:
    """Largest force of a joint in each interval (N) over crank angle (degrees), time (ms) or load factor, and the ideal one's."""

    x: Array
    force: Array
    ideal: tuple[Array, Array] | None


def force_from(result: View, reference: View | None, one: Quantity, first: int) -> ForceCurve:
    """The force of a joint from an output on; the ideal one's last turn again for each turn of it."""
    x, origin = one_turn(abscissa(result)[first:], result)
    force = largest(result, one)[first:]
    if reference is None:
        return ForceCurve(x, force, None)
    at, values = Span(first, first + len(x) - 1, x, None, axis_title(result), origin).beside(reference, largest(reference, one))
    if result.crank is not None and not result.record.static:
        turns = range(1 + int(abs(x[-1] - x[0]) / 360.0))
        at, values = np.concatenate([at + 360.0 * k for k in turns]), np.tile(values, len(turns))
    seen = (at >= min(x) - 1e-6) & (at <= max(x) + 1e-6)
    return ForceCurve(x, force, (at[seen], values[seen]) if seen.sum() > 1 else None)


def largest(result: View, one: Quantity) -> Array:
    """The largest force since the output before, or that of an equilibrium."""
    return one.samples(result.record) if one.extremes is None or result.record.static else one.extremes(result.record)
