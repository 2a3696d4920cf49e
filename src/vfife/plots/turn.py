"""Abscissae of curves: crank angle from 0 to 360 degrees over the turn of the measures, time, load factors;
outputs by moment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from ..errors import Fault, VfifeError, shown
from ..measures.motion import within_turn
from ..results.run_data import RunData
from ..solvers.repeating import outputs_of_a_turn
from ..units import number
from .style import GREY, Array

CRANK_ANGLE = "crank angle (degrees)"  # label of an axis
END_MARGIN = 1.0  # degrees from an end of the axis, where a turn that begins needs no mark
FULL = 300.0  # degrees from which on a turn is one


@dataclass(frozen=True)
class Span:
    """The outputs ``first`` to ``last`` of a run and their abscissa ``x``: the crank's rotation (degrees),
    the time (ms) or a load factor. Rotations are drawn over the crank angle, from 0 to 360 degrees.
    """

    first: int
    last: int
    x: Array
    angular: bool
    title: str
    turns: tuple[int, int] | None = None  # first and last turn of the means, counted from 1

    @property
    def outputs(self) -> slice:
        """The outputs as part of a series over the run."""
        return slice(self.first, self.last + 1)

    @property
    def full_turn(self) -> bool:
        """Whether the outputs are those of a turn."""
        return self.angular and bool(FULL < np.ptp(self.x) <= 361.0)

    @property
    def limits(self) -> tuple[float, float]:
        """Ends of the axis: a turn, or the part of it that a shorter run covers."""
        at = within_turn(self.x) if self.angular else self.x
        if self.angular and (np.ptp(self.x) > FULL or np.any(np.abs(np.diff(at)) > 180.0)):
            return 0.0, 360.0
        low, high = float(at.min()), float(at.max())
        return low, high if high > low else low + 1.0

    def placed(self, values: Array) -> tuple[Array, Array]:
        """Return the abscissa and values of a curve over the span, shape (points,)."""
        return over_turn(self.x, values) if self.angular else (self.x, values)

    def curve_of(self, reference: RunData, values: Array) -> tuple[Array, Array]:
        """Return the curve of a reference over the same angles: its last turn; times, load factors and parts
        of a turn are compared as they are.
        """
        first = max(int(np.argmax(reference.last_turn)) - 1, 0)
        rotations, chosen = abscissa(reference)[first:], values[first:]
        if not self.angular or np.ptp(rotations) < FULL:
            inside = (rotations >= min(self.x) - 1e-6) & (rotations <= max(self.x) + 1e-6)
            rotations, chosen = rotations[inside], chosen[inside]
        else:
            chosen = np.append(chosen[-1:], chosen[1:])  # a turn begins as it ends; forces of a start differ
        at, chosen = over_turn(rotations, chosen) if self.angular else (rotations, chosen)
        low, high = self.limits
        return at, np.where((at >= low - 1e-6) & (at <= high + 1e-6), chosen, np.nan)

    def overlaid(self, values: Array) -> Array:
        """Return the values of the turns over which measures are means, shape (turns, outputs of a turn and
        the one before).
        """
        if self.turns is None:
            return values[None, self.outputs]
        count = self.last - self.first
        return np.stack(
            [values[k * count : (k + 1) * count + 1] for k in range(self.turns[0] - 1, self.turns[1])]
        )

    def set_limits(self, ax: Axes) -> None:
        """Limits of the axis, and ticks at whole sixties of a turn; a mark where a turn begins that does not
        end as it began.
        """
        ax.set_xlim(*self.limits)
        begin = float(within_turn(self.x[0])) if self.angular else 0.0
        if self.turns is not None and min(begin, 360.0 - begin) > END_MARGIN:
            ax.axvline(begin, color=GREY, lw=0.8, ls=(0, (1.0, 2.0)), zorder=1.5, label="start of the turn")
        if self.angular and self.limits == (0.0, 360.0):
            ax.set_xticks(np.arange(0.0, 361.0, 60.0))


def over_turn(rotation: Array, values: Array) -> tuple[Array, Array]:
    """Return a curve over the crank angle (degrees): it is interrupted by NaN where a turn ends, and reaches
    both ends of the axis there by linear interpolation.
    """
    at = within_turn(rotation)
    k = np.flatnonzero(np.abs(np.diff(at)) > 180.0)
    end = np.where(at[k] > 180.0, 360.0, 0.0)
    share = np.clip((end - at[k]) / (rotation[k + 1] - rotation[k]), 0.0, 1.0)
    at_end = values[k] + share * (values[k + 1] - values[k])
    inserted_angles = np.stack([end, end, 360.0 - end], axis=1).ravel()
    inserted_values = np.stack([at_end, np.full(len(k), np.nan), at_end], axis=1).ravel()
    positions = np.repeat(k + 1, 3)
    return np.insert(at, positions, inserted_angles), np.insert(
        np.asarray(values, dtype=float), positions, inserted_values
    )


def shown_span(result: RunData) -> Span:
    """Return the span of the curves of a result: the last turn of the measures, or all outputs."""
    inside = result.last_turn
    first, last = max(int(np.argmax(inside)) - 1, 0), len(result.record.steps) - 1
    motion, turns, count = result.motion, None, outputs_of_a_turn(result.record.assembly)
    if motion is not None and motion.has_several and count is not None:
        first, last, turns = (motion.last - 1) * count, motion.last * count, (motion.first, motion.last)
    return span_of(result, first, last, turns)


def span_of(result: RunData, first: int, last: int, turns: tuple[int, int] | None = None) -> Span:
    """Return the span of some outputs of a result."""
    angular = result.crank is not None and not result.record.static
    return Span(first, last, abscissa(result)[first : last + 1], angular, axis_title(result), turns)


def shown_part(result: RunData, span: Span) -> str:
    """Return the part of the run that curves show, for a title."""
    if span.turns is not None:
        return f", turn {span.turns[1]}; bands over turns {span.turns[0]} to {span.turns[1]}"
    return "" if result.crank is None or result.record.static or result.last_turn.all() else ", last turn"


def shown_turn(result: RunData, span: Span) -> str:
    """Return the same without the turns of bands."""
    return f", turn {span.turns[1]}" if span.turns is not None else shown_part(result, span)


def axis_title(result: RunData) -> str:
    """Return the label of the abscissa."""
    if result.record.static:
        return "load factor"
    if result.crank is None:
        return "time (ms)"
    return CRANK_ANGLE if result.crank == "crank" else f"{CRANK_ANGLE}, body {result.crank}"


def abscissa(result: RunData) -> Array:
    """Return the rotation of the crank (degrees), or time (ms) without a crank, at the outputs; load factors
    of a static analysis.
    """
    if result.record.static:
        return result.time
    return 1e3 * result.time if result.crank_rotation is None else result.crank_rotation


def output_at(result: RunData, text: str) -> int:
    """Return the output nearest to a moment: ``90deg`` or ``0.25 turn`` in the last turn, ``12ms`` or a bare
    number of seconds; a load factor.

    Raises VfifeError for a text that is no moment of the run.
    """
    moments = result.time
    if result.record.static:
        at = _read(text, "1")
        if at is None:
            raise VfifeError(
                f"at {shown(text)}: this is a static analysis; give a load factor, up to {moments[-1]:g}"
            )
    else:
        at, angle = _read(text, "s"), _read(text, "rad")
        if at is None and angle is not None:
            return _at_angle(result, float(np.degrees(angle)), text)
        if at is None:
            raise VfifeError(f"at {shown(text)}: this is neither an angle nor a time; give 90deg, or 12ms")
    if not moments[0] <= at <= moments[-1]:
        unit = "" if result.record.static else " s"
        raise VfifeError(f"at {shown(text)}: the run goes from {moments[0]:g} to {moments[-1]:g}{unit}")
    return int(np.argmin(np.abs(moments - at)))


def _at_angle(result: RunData, angle: float, text: str) -> int:
    if result.crank is None:
        raise VfifeError(
            f"at {shown(text)}: nothing is driven, so there is no crank with an angle; give a time, as 12ms"
        )
    inside = np.flatnonzero(result.last_turn)
    rotation = abscissa(result)[inside]
    off = np.abs(np.mod(rotation - angle + 180.0, 360.0) - 180.0)
    k = int(np.argmin(off))
    spacing = float(np.abs(np.diff(rotation)).max()) if len(inside) > 1 else 0.0
    if off[k] > spacing:
        low, high = within_turn(np.sort(rotation[[0, -1]]))
        raise VfifeError(
            f"at {shown(text)}: {result.crank} goes from {low:.4g} to {high:.4g} degrees in this run"
        )
    return int(inside[k])


def _read(text: str, unit: str) -> float | None:
    try:
        return number(text, unit)
    except Fault:
        return None
