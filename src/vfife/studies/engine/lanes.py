"""Cases of a study in lanes: what is kept of each while it is stepped, and its measures when it ends."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly, limited_rows
from ...measures.catalogue import PEAKS, RequestedMeasures, over_turn
from ...measures.energy import ledger
from ...measures.trust import DEEP_HALVINGS
from ...measures.turns import last_turn
from ...model.mechanism import Mechanism
from ...solvers.arguments import Loop
from ...solvers.companions import measured_rows
from ...solvers.record import Columns, Record, places, recorded_rows
from ...solvers.repeating import Settling, outputs_of_a_turn
from ...solvers.streaming import Lane, stepped
from ...solvers.transient import choose_loop
from ..spec.plan import CaseSpec

Array = NDArray[np.float64]

# ends of turns that are kept to see whether energy is accounted for; every second of them goes when there are
# more
ENDS = 64
AT_ONCE = 16  # turns between two looks, where nothing is asked for at their ends
DOUBTFUL = (
    0.1  # of the energy limit: a ledger that is as open at the ends of turns is looked at output by output
)


def streams(assembly: Assembly, loop: Loop = "auto") -> bool:
    """Whether a member may be stepped in a lane: turns of a crank at constant speed, in whole outputs, and a
    step that is written out.
    """
    settings = assembly.mechanism.settings
    return (
        settings.analysis != "static"
        and outputs_of_a_turn(assembly) is not None
        and choose_loop(assembly, loop) == "generated"
    )


class Plan:
    """What is kept of members that differ in numbers of play: the rows that their lanes hand out, and where
    blocks stand among them.

    Where one row for each turn tells all that is ``wanted``, and nobody asks whether turns repeat, a turn is
    handed out as one output.
    """

    def __init__(self, assembly: Assembly, spec: CaseSpec, measures: RequestedMeasures) -> None:
        self.wanted, self.measures = spec, measures
        self.recorded = recorded_rows(assembly)
        self.fine = spec.settle is not None or not measures.by_turn
        self.handed = rows_by_turn(assembly) if measures.by_turn and self.fine else self.recorded
        self.told, self.ends = Columns(assembly.layout, self.handed), Columns(assembly.layout, self.recorded)
        self.limited = places(self.handed, limited_rows(assembly))
        self.deep = assembly.layout["contact_deep"]


class Stepped(Lane):
    """A member in a lane. ``again`` assembles it with another step, ``reference`` are measures of the ideal
    mechanism.

    It is ``doubtful`` where its own run has to tell what became of it: where numbers left all bounds, or
    energy may be unaccounted for.
    """

    def __init__(
        self,
        number: int,
        assembly: Assembly,
        plan: Plan,
        reference: Mapping[str, float] | None,
        again: Callable[[Mechanism, float], Assembly],
    ) -> None:
        super().__init__(number, assembly, plan.handed, limited=plan.limited)
        self.plan, self.reference, self.again = plan, reference, again
        if not plan.fine:
            self.every *= self.per
        self.rows = self.per if plan.fine else 1  # of a turn
        self.turns, self.values = 0, dict[str, float]()
        self.settling: Settling | None = None

    @property
    def outputs(self) -> int:
        """Rows up to the next look: those of a turn, or where they are one, of several turns."""
        return self.rows if self.plan.fine else min(AT_ONCE, self.plan.wanted.turns - self.turns)

    def start(self, state: Array) -> None:
        """The first output."""
        plan, settle = self.plan, self.plan.wanted.settle
        if settle is not None:
            self.settling = Settling(self.assembly, self.handed, settle)
        self.last: deque[Array] = deque(maxlen=plan.wanted.last)
        self.before, self.ends = state[None, self.handed], [(0, state[self.plan.recorded])]

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """A turn, or several of a row each."""
        self.doubtful = (
            broken >= 0
            or bool(self.bounds.unsound(rows).any())
            or not np.isfinite(state[self.plan.recorded]).all()
        )
        if self.doubtful:
            return
        for turn in np.split(rows, len(rows) // self.rows):
            self.turns += 1
            self.last.append(np.concatenate([self.before, turn]))
            self.before = turn[-1:]
            self.ends.append((self.turns, state[self.plan.recorded] if self.plan.fine else turn[-1]))
            if len(self.ends) > ENDS:
                del self.ends[1::2]
        if self.settling is not None:
            self.settling.take(rows)
        self.final = state

    @property
    def finished(self) -> bool:
        """Whether no turn is left to make."""
        return (
            self.doubtful
            or self.turns == self.plan.wanted.turns
            or (self.settling is not None and self.settling.settled)
        )

    @property
    def settled(self) -> int | None:
        """The turn after which it ended because turns repeat."""
        return self.turns if self.settling is not None and self.settling.settled else None

    def end(self) -> Stepped | None:
        """Takes its measures; where first contacts landed too deep for an automatic step, it is made again
        with half of that.
        """
        choice, assembly = self.assembly.choice, self.assembly
        if self.doubtful:
            return None
        deep = bool(np.any(self.final[self.plan.deep]))
        if deep and choice.automatic and len(choice.tried) < DEEP_HALVINGS[0]:
            return Stepped(self.number, self._halved(), self.plan, self.reference, self.again)
        size = self.per * choice.outputs_every
        steps, rows = zip(*self.ends, strict=True)
        ends = Record(
            assembly,
            np.array(steps, dtype=np.int64) * size,
            np.array(rows),
            self.plan.recorded,
            columns=self.plan.ends,
        )
        self.doubtful = ledger(ends).error > DOUBTFUL * assembly.mechanism.settings.energy_limit
        first = self.turns - len(self.last)
        records = []
        for k, own in enumerate(self.last, first):
            at = np.arange(k * self.rows, (k + 1) * self.rows + 1, dtype=np.int64) * self.every
            records.append(Record(assembly, at, own, self.handed, columns=self.plan.told))
        self.values = self.plan.measures.over(records, self.reference)
        del self.final, self.before
        self.last.clear()
        self.ends.clear()
        return None

    def _halved(self) -> Assembly:
        """The same with half the step, which stays an automatic one."""
        choice = self.assembly.choice
        result = self.again(self.assembly.mechanism, 0.5 * choice.step)
        tried = (*choice.tried, (choice.step, None))
        return dataclasses.replace(
            result, choice=dataclasses.replace(result.choice, automatic=True, tried=tried)
        )


def rows_by_turn(assembly: Assembly) -> NDArray[np.uint32]:
    """Rows of S that tell the measures of a turn of which its extremes and its end are enough, whether turns
    repeat, and whether it broke.
    """
    forces = np.asarray(assembly.layout.rows_of("contact_normal_force"), dtype=np.uint32)
    return np.unique(np.concatenate([measured_rows(assembly), limited_rows(assembly), forces]))


class PeakLane(Lane):
    """An ideal mechanism in a lane, which hands out one output for each turn: extremes since the one before.

    ``columns`` tell where blocks stand among its rows, for all mechanisms of one layout.
    """

    def __init__(self, number: int, assembly: Assembly, columns: Columns, limited: NDArray[np.intp]) -> None:
        super().__init__(number, assembly, columns.row_numbers, limited=limited)
        self.columns, self.every = columns, self.every * self.per

    @property
    def outputs(self) -> int:
        """All of them, at once."""
        return self.assembly.choice.outputs // self.per

    @property
    def finished(self) -> bool:
        """Whether it needs no further step."""
        return self.doubtful or self.done >= self.outputs

    @property
    def record(self) -> Record:
        """The record of its turns."""
        return dataclasses.replace(super().record, columns=self.columns)


def peaks_of(ideals: Mapping[int, Assembly]) -> dict[int, dict[str, float]]:
    """Largest values of ideal mechanisms over their last turn, stepped side by side, by number; none of those
    whose numbers leave all bounds.
    """
    lanes, shared = [], dict[int, tuple[Columns, NDArray[np.intp]]]()
    for k, one in ideals.items():
        if id(one.layout) not in shared:
            rows = recorded_rows(one)
            shared[id(one.layout)] = Columns(one.layout, rows), places(rows, limited_rows(one))
        lanes.append(PeakLane(k, one, *shared[id(one.layout)]))
    done = stepped(lanes, len(lanes), workers=1) if lanes else ()
    records = {lane.number: lane.record for lane in done if not lane.doubtful}
    return {k: over_turn(one, last_turn(one), PEAKS) for k, one in records.items()}
