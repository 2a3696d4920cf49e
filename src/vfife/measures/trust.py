"""Judgement of a run: whether its step is fine enough by its companions or error estimate, and the step to
try next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..assembly.assembled import CONTINUED
from ..solvers.companions import SENSITIVE, Parting
from ..solvers.record import Record
from ..solvers.status import Status
from .catalogue import PEAKS
from .energy import is_unstable, open_share, own_floor, unstable_companions
from .error_ranges import largest, later_spread, ranged, spreads, step_hulls
from .repetition import turns
from .statics import spreads as static_spreads
from .values import Measured
from .zero_limits import scales_of_run

# How often an automatic step is halved at the most: for companions that diverge, and for a smooth run with
# large errors.
HALVINGS = 2
SMOOTH_HALVINGS = 3
# For first contacts that land too deep: from the step of a run without companions, and from that of one with
# them.
DEEP_HALVINGS = 3, 4
# For an energy ledger that does not close, or a motion that is not periodic: without companions, and with
# them, where a run begins with twice the step.
OPEN_HALVINGS = 2, 1
# In the place of the spread (at most 1) of a try whose run or companions diverged or blew up.
UNSTABLE_TRY = 2.0
# Share of the largest energy by which a ledger may be open before the step is halved.
OPEN = 1e-3


@dataclass(frozen=True)
class Trust:
    """Judgement of a run by its companions, or by runs at half the step.

    ``measure`` has the largest uncertainty: its values at all step sizes differ by the share ``apart`` of its
    size (1), and ``low`` to ``high`` is the range that estimates its error. ``parting`` is where companions
    diverge; ``lost`` of the ``companions`` have infinite numbers or blew up, and ``unstable``
    is True where the run itself did. For a smooth or static run, which has none,
    ``apart`` is the estimated error, ``order`` that of the step, and ``converges`` is False where runs at
    smaller steps do not converge.
    """

    companions: int
    measure: str
    apart: float
    low: float
    high: float
    parting: Parting | None
    lost: int
    order: float | None = None
    converges: bool = True
    unstable: bool = False

    @property
    def sensitive(self) -> bool:
        """Whether the steps decide the motion."""
        return self.apart > SENSITIVE or not self.converges


def trust(record: Record, measures: dict[str, Measured] | None = None) -> Trust | None:
    """Judge a run by its companions or its estimate, None without any; ``measures``: its own, if known."""
    companions, estimate = record.companions, record.estimate
    if companions is None and estimate is None:
        return None
    measures = ranged(record, groups=PEAKS) if measures is None else measures
    if record.static:
        widths = static_spreads(record, measures)
    else:
        hulls = step_hulls(record, measures)
        widths = spreads(hulls, record.assembly.choice.step, scales_of_run(record))
    name, spread = largest(widths)
    if not record.static and spread <= SENSITIVE:  # perhaps because they part after their largest values
        name, spread = later_spread(record, hulls, (name, spread))
    low, high = (measures[name].low, measures[name].high) if name else (0.0, 0.0)
    if companions is None:
        return Trust(
            0,
            name,
            0.5 * spread,
            low,
            high,
            None,
            0,
            *(() if estimate is None else (estimate.order, estimate.converges)),
        )
    lost = len(unstable_companions(record))
    return Trust(
        len(companions.counts),
        name,
        1.0 if lost else spread,
        low,
        high,
        companions.parting,
        lost,
        unstable=is_unstable(record),
    )


def finer(record: Record) -> tuple[tuple[float, float | None], ...] | None:
    """Return the tries of an automatic step so far, with this run, if half its step should be tried next,
    else None.

    A step is halved if companions disagree on a measure by more than the tolerance, if first contacts are
    deeper than their joints allow, or if the energy balance is open; each a limited number of times, and less
    often for a motion that is not periodic, because no step makes its companions agree. Companions that go on
    from those of a former run halve no step that is kept from it: they differ from the start on.
    """
    # Halvings are counted by their cause, because they help differently: a spread of periodic motions shrinks
    # with the step; an open balance or one of motions that are not periodic seldom does, so few are tried.
    choice = record.assembly.choice
    if not choice.automatic or record.status not in (Status.COMPLETE, Status.DIVERGED, Status.ENERGY):
        return None
    judgement, diverged = trust(record), record.status == Status.DIVERGED
    spread = 0.0 if judgement is None else 1.0 if diverged or not judgement.converges else judgement.apart
    accompanied = record.companions is not None
    open_halvings = OPEN_HALVINGS[accompanied]
    limit = open_halvings if not_periodic(record) else HALVINGS if accompanied else SMOOTH_HALVINGS
    limit += judgement is not None and judgement.lost > 0  # a step that is not stable is no try
    inherits_step = record.assembly.companion_states is not None and choice.culprit.startswith(CONTINUED)
    if (
        not inherits_step
        and spread > record.assembly.mechanism.settings.tolerance
        and sum(share is not None for _, share in choice.tried) < limit
    ):
        unstable = diverged or (judgement is not None and judgement.lost > 0)
        return (*choice.tried, (choice.step, UNSTABLE_TRY if unstable else spread))
    if diverged:
        return None
    may_close = len(choice.tried) < open_halvings and not own_floor(record)
    is_open = (accompanied or record.status == Status.ENERGY) and may_close and open_share(record) > OPEN
    if is_open or (too_deep(record) and len(choice.tried) < DEEP_HALVINGS[judgement is not None]):
        return (*choice.tried, (choice.step, None))
    return None


def not_periodic(record: Record) -> bool:
    """Return whether measures are means over turns of a motion that is not periodic."""
    motion = turns(record)
    return motion is not None and motion.motion == "not repeating"


def too_deep(record: Record) -> bool:
    """Return whether a first contact was deeper than its joint allows."""
    return record.final is not None and bool(np.any(record.final[record.assembly.layout["contact_deep"]]))
