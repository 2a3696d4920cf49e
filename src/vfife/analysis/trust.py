"""Whether a run can be trusted: how far it and its companions lie apart, what an automatic step has to become, when a run is sensitive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..solvers.companions import SENSITIVE, Parting
from ..solvers.record import Record
from ..solvers.status import Status
from .energy import ledger, own_floor
from .measured import Measured
from .measures import PEAKS
from .meshes import spreads as static_spreads
from .ranges import over_tries, ranged, spreads
from .turns import turns

HALVINGS = 2  # of an automatic step for companions that lie apart, at the most
SMOOTH_HALVINGS = 3  # of one of a smooth run for errors that are too large
DEEP_HALVINGS = 3, 4  # of one for first contacts that land too deep: from the step of a run without companions, and from that of one with them
# Of one for an energy ledger that stays open, or a motion that is not periodic: of a run without companions, and of one with
# them, which begins with twice the step.
OPEN_HALVINGS = 2, 1
OPEN = 1e-3  # of the largest energy: a ledger that is open by more is not to be trusted


@dataclass(frozen=True)
class Trust:
    """What companions, or a run at half the step, say of a run.

    ``measure`` is known worst: its values at all step sizes lie ``apart`` by that share of its size (1), and the range that estimates its error is
    from ``low`` to ``high``. ``parting`` is where they part, ``lost`` how many of the ``companions`` have infinite numbers. Of a smooth or static
    run, which has none, ``apart`` is the estimated error; ``order`` is that of the step, and ``converges`` is False where runs at smaller steps do
    not come together.
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

    @property
    def sensitive(self) -> bool:
        """Whether the motion is decided by the steps."""
        return self.apart > SENSITIVE or not self.converges


def trust(record: Record, found: dict[str, Measured] | None = None) -> Trust | None:
    """What companions or an estimate say of a run, None without any; ``found`` are its measures where they are known already."""
    left, said = record.companions, record.estimate
    if left is None and said is None:
        return None
    found = ranged(record, every=PEAKS) if found is None else found
    seen = found if left is None else over_tries(record, every=PEAKS)
    widths = static_spreads(record, found) if record.static else spreads(seen, record.assembly.choice.step)
    name, apart = max(widths.items(), key=lambda item: item[1], default=("", 0.0))
    low, high = (found[name].low, found[name].high) if name else (0.0, 0.0)
    if left is None:
        return Trust(0, name, 0.5 * apart, low, high, None, 0, None if said is None else said.order, said is None or said.converges)
    return Trust(len(left.counts), name, 1.0 if left.lost else apart, low, high, left.parting, len(left.lost))


def finer(record: Record) -> tuple[tuple[float, float | None], ...] | None:
    """What was tried of an automatic step so far, this run's with it, where half of it should be tried next; None where it will do, or has to."""
    choice = record.assembly.choice
    if not choice.automatic or record.status not in (Status.COMPLETE, Status.DIVERGED, Status.ENERGY):
        return None
    said = trust(record)
    diverged = record.status == Status.DIVERGED
    apart = 0.0 if said is None else 1.0 if diverged or not said.converges else said.apart
    accompanied = record.companions is not None
    open_halvings = OPEN_HALVINGS[accompanied]
    most = open_halvings if not_periodic(record) else HALVINGS if accompanied else SMOOTH_HALVINGS
    if apart > record.assembly.mechanism.settings.tolerance and sum(one is not None for _, one in choice.tried) < most:
        return (*choice.tried, (choice.step, apart))
    if diverged:
        return None
    stopped = record.status == Status.ENERGY
    closes = len(choice.tried) < open_halvings and not own_floor(record)
    unlike = (record.companions is not None or stopped) and closes and ledger(record).error > OPEN
    if unlike or (too_deep(record) and len(choice.tried) < DEEP_HALVINGS[said is not None]):
        return (*choice.tried, (choice.step, None))
    return None


def not_periodic(record: Record) -> bool:
    """Whether means over turns are told: no step brings companions of such a motion together, and theirs differ by chance."""
    said = turns(record)
    return said is not None and said.motion == "not periodic"


def too_deep(record: Record) -> bool:
    """Whether a first contact landed deeper than its joint allows."""
    return record.final is not None and bool(np.any(record.final[record.assembly.layout["contact_deep"]]))
