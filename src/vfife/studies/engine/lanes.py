"""Cases of a study in lanes: the rows kept of each while it is stepped, and its measures at the end."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly, limited_rows
from ...kinematics.batch import Structures
from ...measures.catalogue import RequestedMeasures, peaks_by_output
from ...measures.energy import open_share
from ...measures.trust import DEEP_HALVINGS
from ...model.mechanism import Mechanism
from ...report.case_cautions import case_cautions
from ...results.case_errors import changes_between_turns
from ...solvers.arguments import Loop
from ...solvers.companions import measured_rows
from ...solvers.record import Columns, Record, places, recorded_rows
from ...solvers.repeating import LONGEST, Settling, outputs_of_a_turn
from ...solvers.streaming import Lane, stepped
from ...solvers.transient import choose_loop
from ..spec.plan import CaseSpec

Array = NDArray[np.float64]

# Ends of turns whose energy balance is examined. When there are more, every second one is dropped, so that
# memory stays bounded while the ends remain spread over the whole run.
ENDS = 64
AT_ONCE = 16  # turns between two calls of take(), if nothing is decided at the end of each
# A case whose balance at the ends of turns reaches this share of the energy limit is run again by itself,
# where the balance is examined at every output and may be larger.
DOUBTFUL = 0.1
COMPARED_TURNS = 3  # last turns of a case whose measures are compared where one turn is measured


def streams(assembly: Assembly, loop: Loop = "auto") -> bool:
    """Return whether a case can be stepped in a lane: turns of a crank at constant speed in whole outputs,
    and a step short enough for straight-line code.
    """
    settings = assembly.mechanism.settings
    return (
        settings.analysis != "static"
        and outputs_of_a_turn(assembly) is not None
        and choose_loop(assembly, loop) == "generated"
    )


class Plan:
    """The rows that lanes hand out for cases with one layout, and the columns of blocks in them.

    If one row per turn suffices for all requested measures, and turns are not compared with each other, a
    turn is one output.
    """

    def __init__(self, assembly: Assembly, spec: CaseSpec, measures: RequestedMeasures) -> None:
        self.wanted, self.measures = spec, measures
        self.recorded = recorded_rows(assembly)
        self.fine = spec.settle is not None or not measures.by_turn or spec.examine
        peaks_only = measures.by_turn and self.fine and not spec.examine
        self.handed = rows_by_turn(assembly) if peaks_only else self.recorded
        self.told, self.ends = Columns(assembly.layout, self.handed), Columns(assembly.layout, self.recorded)
        self.limited = places(self.handed, limited_rows(assembly))
        self.deep = assembly.layout["contact_deep"]


class Stepped(Lane):
    """A case in a lane. ``assemble_again`` assembles it with another step; ``reference`` are the measures of
    the ideal mechanism.

    A case is ``doubtful`` if only a run of its own can determine its outcome: numbers became non-finite or
    exceeded bounds, or the energy balance may be open.
    """

    def __init__(
        self,
        number: int,
        assembly: Assembly,
        plan: Plan,
        reference: Mapping[str, float] | None,
        assemble_again: Callable[[Mechanism, float], Assembly],
    ) -> None:
        super().__init__(number, assembly, plan.handed, limited=plan.limited)
        self.plan, self.reference, self.assemble_again = plan, reference, assemble_again
        if not plan.fine:
            self.every *= self.per
        self.rows = self.per if plan.fine else 1  # of a turn
        self.turns, self.measured_turns = 0, 1
        self.values, self.ranges = dict[str, float](), dict[str, float]()
        self.settling: Settling | None = None
        self.cautions: tuple[str, ...] | None = None

    @property
    def outputs(self) -> int:
        """Rows until the next call of :meth:`take`: those of one turn or, with one row per turn, of several
        turns.
        """
        return self.rows if self.plan.fine else min(AT_ONCE, self.plan.wanted.turns - self.turns)

    def start(self, state: Array) -> None:
        """Take the first output."""
        plan, settle = self.plan, self.plan.wanted.settle
        if settle is not None:
            self.settling = Settling(self.assembly, self.handed, settle)
        self.last: deque[Array] = deque(maxlen=max(plan.wanted.last, LONGEST))
        self.before, self.ends = state[None, self.handed], [(0, state[self.plan.recorded])]

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Take the rows of a turn, or of several turns with one row each."""
        # A lane does not know at which step its numbers left their bounds; finding out would need all rows of
        # the turn. The case gets a run of its own instead, which reports the step.
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
        needed = max(self.plan.wanted.last, turns_compared(self.plan.wanted, self.settling, self.turns))
        while len(self.last) > max(needed, max(self.settling.streaks, default=0) if self.settling else 0):
            self.last.popleft()
        self.final = state

    @property
    def finished(self) -> bool:
        """Whether no turn is left."""
        return (
            self.doubtful
            or self.turns == self.plan.wanted.turns
            or (self.settling is not None and self.settling.settled)
        )

    @property
    def settled(self) -> int | None:
        """The turn after which the case ended because turns repeat, else None."""
        return self.turns if self.settling is not None and self.settling.settled else None

    @property
    def period(self) -> int | None:
        """The number of turns after which the motion repeats, None if it does not or is not examined."""
        return None if self.settling is None else self.settling.motion_period

    def end(self) -> Stepped | None:
        """Compute the measures; return the case with half the step if first contacts were too deep for an
        automatic step.
        """
        choice, assembly = self.assembly.choice, self.assembly
        if self.doubtful:
            return None
        # The same rule as for a run without companions: too deep a first contact halves an automatic step,
        # and the case starts again, in another lane.
        deep = bool(np.any(self.final[self.plan.deep]))
        if deep and choice.automatic and len(choice.tried) < DEEP_HALVINGS[0]:
            return Stepped(self.number, self._halved(), self.plan, self.reference, self.assemble_again)
        size = self.per * choice.outputs_every
        steps, rows = zip(*self.ends, strict=True)
        ends = Record(
            assembly,
            np.array(steps, dtype=np.int64) * size,
            np.array(rows),
            self.plan.recorded,
            columns=self.plan.ends,
        )
        self.doubtful = open_share(ends) > DOUBTFUL * assembly.mechanism.settings.energy_limit
        spec, measures, records = self.plan.wanted, self.plan.measures, []
        for k, turn_rows in enumerate(self.last, self.turns - len(self.last)):
            at = np.arange(k * self.rows, (k + 1) * self.rows + 1, dtype=np.int64) * self.every
            records.append(Record(assembly, at, turn_rows, self.handed, columns=self.plan.told))
        self.measured_turns = min(turns_measured(spec, self.settling), self.turns)
        self.values = measures.turn_means(records[-self.measured_turns :], self.reference)
        if compared := turns_compared(spec, self.settling, self.turns):
            self.ranges = measures.turn_ranges(records[-compared:], self.reference)
        if spec.examine:
            repeats = turns_repeat(self.turns, self.values, self.ranges)
            self.cautions = case_cautions(records[-1], self.reference, repeats)
        # Thousands of ended cases may wait for their turn to be saved; only their measures are kept.
        del self.final, self.before
        self.last.clear()
        self.ends.clear()
        return None

    def _halved(self) -> Assembly:
        """Return the assembly with half the step, still marked as automatic."""
        choice = self.assembly.choice
        result = self.assemble_again(self.assembly.mechanism, 0.5 * choice.step)
        tried = (*choice.tried, (choice.step, None))
        return dataclasses.replace(
            result, choice=dataclasses.replace(result.choice, automatic=True, tried=tried)
        )


def turns_measured(spec: CaseSpec, settling: Settling | None) -> int:
    """Return over how many turns at the end the measures of a case are means."""
    if settling is None:
        return spec.last
    count = settling.turns_of_period() if spec.period_means else 1
    return count if count > 1 else settling.turns_of_means(spec.last)


def turns_compared(spec: CaseSpec, settling: Settling | None, turns: int) -> int:
    """Return how many of the last turns of a case that made ``turns`` are compared by their measures: those
    of whole periods, or a few where one turn is measured; 0 where turns repeat, or means are wanted.

    The first turn, with the start, is compared with the second alone.
    """
    period = None if settling is None else settling.motion_period
    if period == 1 or spec.duration is not None or turns < 2:
        return 0
    if spec.last > 1:
        parts = settling is not None and period is not None and settling.turns_of_means(spec.last) % period
        return period if period is not None and parts else 0
    if settling is not None and spec.period_means and period is not None:
        return settling.turns_of_period()
    return min(max(COMPARED_TURNS, period or 0), max(turns - 1, 2))


def turns_repeat(turns: int, values: Mapping[str, float], ranges: Mapping[str, float]) -> bool:
    """Return whether a case made several turns, and no measure is known to differ between the last ones."""
    return turns > 1 and not changes_between_turns({"measures": values, "ranges": ranges}, {})


def rows_by_turn(assembly: Assembly) -> NDArray[np.uint32]:
    """Return the rows of S that suffice for measures of extremes and totals of a turn, for comparing turns,
    and for detecting a broken run.
    """
    forces = np.asarray(assembly.layout.rows_of("contact_normal_force"), dtype=np.uint32)
    return np.unique(np.concatenate([measured_rows(assembly), limited_rows(assembly), forces]))


class PeakLane(Lane):
    """An ideal mechanism in a lane with one output per turn: the extremes of the turn.

    ``columns`` locate blocks among its rows, for all mechanisms of one layout.
    """

    def __init__(self, number: int, assembly: Assembly, columns: Columns, limited: NDArray[np.intp]) -> None:
        super().__init__(number, assembly, columns.row_numbers, limited=limited)
        self.columns, self.every = columns, self.every * self.per

    @property
    def outputs(self) -> int:
        """All outputs, in one call."""
        return self.assembly.choice.outputs // self.per

    @property
    def finished(self) -> bool:
        """Whether all turns are done."""
        return self.doubtful or self.done >= self.outputs


def peaks_of(ideals: Mapping[int, Assembly], structures: Structures) -> dict[int, dict[str, float]]:
    """Return the largest values of ideal mechanisms over their last turn, by number, stepped side by side; a
    mechanism that diverges is left out. ``structures``: those of the mechanisms, if they are known already.
    """
    lanes, shared = [], dict[int, tuple[Columns, NDArray[np.intp]]]()
    for k, assembly in ideals.items():
        if id(assembly.layout) not in shared:
            rows = recorded_rows(assembly)
            shared[id(assembly.layout)] = Columns(assembly.layout, rows), places(rows, limited_rows(assembly))
        lanes.append(PeakLane(k, assembly, *shared[id(assembly.layout)]))
    done = stepped(lanes, len(lanes), workers=0) if lanes else ()
    groups: dict[Any, list[PeakLane]] = {}
    for lane in done:
        if not lane.doubtful:
            key = structures.mechanism(lane.assembly.mechanism), id(lane.assembly.layout)
            groups.setdefault(key, []).append(lane)
    result: dict[int, dict[str, float]] = {}
    for group in groups.values():  # the last turns of a group are evaluated as outputs of one record
        first, last = group[0], np.array([lane.parts[-1][-1] for lane in group])
        record = Record(first.assembly, np.arange(len(last)), last, first.handed, columns=first.columns)
        result |= zip((lane.number for lane in group), peaks_by_output(record), strict=True)
    return result
