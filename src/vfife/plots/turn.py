"""Abscissae of curves: the turn over which measures are taken, cut open where forces vary least; time; load
factors; outputs by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, VfifeError, shown
from ..measures.forces import joint_force_max
from ..solvers.repeating import outputs_of_a_turn
from ..units import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..results.view import View

Array = NDArray[np.float64]
AROUND = 25.0  # degrees to both sides of an angle that have to be quiet for a turn to be opened there
EVERY = 30  # degrees: where a turn may be opened
# A turn stays open at 0 unless another place has less than this part of its variation, and this much less
BETTER = (1.5, 0.05)
ROUNDED = 1e-6  # degrees by which an angle may be off where the turn is opened
FULL = 300.0  # degrees from which on a turn is one


@dataclass(frozen=True)
class Span:
    """The outputs ``first`` to ``last`` of a run and their abscissa ``x``; a whole turn is cut open at the
    angle ``cut`` (degrees).
    """

    first: int
    last: int
    x: Array
    cut: float | None
    title: str
    origin: float = 0.0  # degrees before the turn
    turns: tuple[int, int] | None = (
        None  # first and last turn of the means, counted from 1, of as many outputs as this one
    )

    def placed(self, values: Array) -> tuple[Array, Array]:
        """Abscissa and values of a curve over the span; interrupted where the turn is cut open."""
        if self.cut is None:
            return self.x, values
        at = self.cut + np.mod(self.x - self.cut + ROUNDED, 360.0) - ROUNDED
        crossing = int(np.argmax(np.abs(np.diff(at)))) + 1
        if abs(at[crossing] - at[crossing - 1]) < 180.0:
            return at, values
        if crossing == len(at) - 1:  # opened where it ends
            return np.append(at[:-1], self.cut + (360.0 if at[1] > at[0] else 0.0)), values
        order = [*range(crossing, len(at)), -1, *range(crossing)]
        broken = np.where(np.array(order) < 0, np.nan, values[order])
        return np.where(np.array(order) < 0, at[-1], at[order]), broken

    def curve_of(self, reference: View, values: Array) -> tuple[Array, Array]:
        """The curve of a reference over the same angles: its last turn; times and load factors are compared
        as they are.
        """
        over, chosen = abscissa(reference)[reference.last_turn], values[reference.last_turn]
        if reference.crank is None or reference.record.static or np.ptp(over) < FULL:
            over = over - self.origin
            inside = (over >= min(self.x) - 1e-6) & (over <= max(self.x) + 1e-6)
            return over[inside], chosen[inside]
        low = min(self.x) if self.cut is None else self.cut
        at = low + np.mod(over - low - 1e-6, 360.0) + 1e-6
        order = np.argsort(at, kind="stable")
        at, chosen = at[order], chosen[order]
        at, chosen = np.concatenate([[at[-1] - 360.0], at]), np.concatenate([chosen[-1:], chosen])
        inside = at <= (max(self.x) if self.cut is None else low + 360.0) + 1e-6
        return at[inside], chosen[inside]

    def overlaid(self, values: Array) -> Array:
        """Values of the turns over which measures are means, shape (turns, outputs of a turn and the one
        before).
        """
        if self.turns is None:
            return values[None, self.first : self.last + 1]
        count = self.last - self.first
        return np.stack(
            [values[k * count : (k + 1) * count + 1] for k in range(self.turns[0] - 1, self.turns[1])]
        )

    def set_limits(self, ax: Axes) -> None:
        """Limits and ticks of an axis of angles: whole sixties, counted within one turn."""
        low, high = (min(self.x), max(self.x)) if self.cut is None else (self.cut, self.cut + 360.0)
        ax.set_xlim(low, high if high > low else low + 1.0)
        if self.title.endswith("(degrees)") and high - low > FULL:
            ticks = np.arange(
                np.ceil(low / 60.0 - 1e-6) * 60.0, high + 1e-6, 60.0 if high - low <= 361.0 else 180.0
            )
            ax.set_xticks(ticks, [f"{tick % 360.0 if self.cut is not None else tick:.0f}" for tick in ticks])


def span(result: View) -> Span:
    """The span of the curves of a result: the last turn over which measures are taken, or all outputs."""
    over, title = abscissa(result), axis_title(result)
    inside = result.last_turn
    first, last = max(int(np.argmax(inside)) - 1, 0), len(over) - 1
    motion, turns = result.motion, None
    if motion is not None and motion.several:
        count = outputs_of_a_turn(result.record.assembly) or 0
        first, last, turns = (motion.last - 1) * count, motion.last * count, (motion.first, motion.last)
    x, origin = one_turn(over[first : last + 1], result)
    full_turn = result.crank is not None and not result.record.static and FULL < np.ptp(x) <= 361.0
    return Span(
        first, last, x, _quietest(result, first, last, x) if full_turn else None, title, origin, turns
    )


def _quietest(result: View, first: int, last: int, x: Array) -> float:
    """The angle (degrees) around which the joint forces vary least, as shares of the largest of each; 0
    unless it is much quieter elsewhere.
    """
    forces = joint_force_max(result.record)[first + 1 : last + 1]
    most = forces.max(axis=0) if forces.size else np.zeros(0)
    loaded = most > 1e-9 * max(most.max(initial=0.0), 1e-300)
    share = forces[:, loaded] / most[loaded]
    if not share.size:
        return 0.0
    angles, varied = np.mod(x[1:], 360.0), {}
    for cut in range(0, 360, EVERY):
        near = np.abs(np.mod(angles - cut + 180.0, 360.0) - 180.0) <= AROUND
        varied[cut] = float(np.ptp(share[near], axis=0).max()) if near.any() else np.inf
    best = min(varied, key=lambda cut: varied[cut])
    return 0.0 if varied[0] <= BETTER[0] * varied[best] + BETTER[1] else float(best)


def shown_part(result: View, over: Span) -> str:
    """The part of the run that curves show, for a title."""
    if over.turns is not None:
        return f", turn {over.turns[1]}; bands over turns {over.turns[0]} to {over.turns[1]}"
    return "" if result.crank is None or result.record.static or result.last_turn.all() else ", last turn"


def shown_turn(result: View, over: Span) -> str:
    """The same without the turns of bands."""
    return f", turn {over.turns[1]}" if over.turns is not None else shown_part(result, over)


def axis_title(result: View) -> str:
    """Label of the abscissa."""
    if result.record.static:
        return "load factor"
    return "time (ms)" if result.crank is None else f"angle of {result.crank} (degrees)"


def abscissa(result: View) -> Array:
    """Crank angle (degrees), or time (ms) without a crank, at the outputs; load factors of a static
    analysis.
    """
    if result.record.static:
        return result.time
    return 1e3 * result.time if result.crank_angle is None else result.crank_angle


def one_turn(angle: Array, result: View) -> tuple[Array, float]:
    """Angles of a turn counted from the last whole turn before it, and that whole turn's angle; times as they
    are.
    """
    if result.crank is None or result.record.static:
        return angle, 0.0
    origin = 360.0 * np.floor(min(angle[0], angle[-1]) / 360.0 + 1e-6)
    return angle - origin, float(origin)


def output_at(result: View, text: str) -> int:
    """The output nearest to a moment: ``90deg`` or ``0.25 turn`` in the last turn, ``12ms`` or a bare number
    of seconds; a load factor.

    Raises VfifeError for what is no moment of the run.
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


def _at_angle(result: View, angle: float, text: str) -> int:
    if result.crank is None:
        raise VfifeError(
            f"at {shown(text)}: nothing is driven, so there is no crank with an angle; give a time, as 12ms"
        )
    inside = np.flatnonzero(result.last_turn)
    off = np.abs(np.mod(abscissa(result)[inside] - angle + 180.0, 360.0) - 180.0)
    k = int(np.argmin(off))
    spacing = float(np.abs(np.diff(abscissa(result)[inside])).max()) if len(inside) > 1 else 0.0
    if off[k] > spacing:
        low, high = np.sort(abscissa(result)[inside[[0, -1]]])
        raise VfifeError(
            f"at {shown(text)}: {result.crank} goes from {low:.4g} to {high:.4g} degrees in this run"
        )
    return int(inside[k])


def _read(text: str, unit: str) -> float | None:
    try:
        return number(text, unit)
    except Fault:
        return None
