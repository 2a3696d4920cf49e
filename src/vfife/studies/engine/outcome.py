"""Outcome of a case of a study, and the run of a case that no lane can step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ...errors import VfifeError
from ...measures.turns import each_turn
from ...report.case_cautions import case_cautions
from ...report.divergence import soft_contact
from ...simulation.simulate import prepare, run_prepared
from ...solvers.arguments import RunArguments
from ...solvers.record import Record
from ...solvers.repeating import Settling, turn_grid
from ...solvers.status import Status
from .lanes import turns_compared, turns_measured, turns_repeat

if TYPE_CHECKING:
    from .cases import Cases

FAILED = "failed"


@dataclass(frozen=True)
class Outcome:
    """Outcome of a case: ``values`` by measure (SI units; none if it failed), number of whole turns, and the
    turn from which on turns repeat.

    ``period``: number of turns after which they do, None if they do not or were not compared; measures are
    means over ``measured_turns``. ``ranges``: by how much measures of single turns differ between the last
    turns, where one turn or a period of several is measured. ``cautions``: kinds of those
    that it would have as a run (:mod:`~vfife.report.case_cautions`), None if they were not examined.

    ``status``: that of a run ("complete", "diverged", "energy"), or "failed" if it could not be assembled;
    ``reason``: a sentence if it is not complete. ``step`` (s) and ``steps``: size and number of its steps.
    """

    values: dict[str, float] = field(default_factory=dict)
    turns: int = 0
    settled: int | None = None
    status: str = "complete"
    reason: str | None = None
    step: float = math.nan
    steps: int = 0
    period: int | None = None
    measured_turns: int = 1
    ranges: dict[str, float] = field(default_factory=dict)
    cautions: tuple[str, ...] | None = None


def sentence(error: VfifeError) -> str:
    """Return the message of an error in one line."""
    return " ".join(line.strip() for line in str(error).splitlines() if line.strip())


def single(cases: Cases, numbers: Mapping[str, float | str]) -> Outcome:
    """Run a case as ``vfife run`` does without companions."""
    spec = cases.wanted
    try:
        mechanism = cases.mechanism(numbers)
        arguments = RunArguments(**spec.length, step=spec.step, companions=0, settle=spec.settle)
        result = run_prepared(prepare(mechanism, arguments))
    except VfifeError as error:
        return Outcome(status=FAILED, reason=sentence(error))
    record, choice = result.record, result.record.assembly.choice
    grid, steps = turn_grid(record.assembly), int(record.steps[-1])
    turns = 0 if grid is None else grid.count(len(record.steps) - 1)
    if record.status != Status.COMPLETE:
        return Outcome({}, turns, None, str(record.status), unsound(record), choice.step, steps)
    # A single turn is the last one of the record, as that of a run: it ends with the run, which need not end
    # with a turn counted from the start.
    settling = None if spec.settle is None else Settling(record.assembly, record.row_numbers, spec.settle)
    if settling is not None:
        settling.restore(record.rows)
    last = min(turns_measured(spec, settling), max(turns, 1))
    reference = None if result.reference is None else result.reference.measures
    parts = list(each_turn(record, turns - last + 1, turns)) if last > 1 else [record]
    values, ranges = cases.measures.turn_means(parts, reference), dict[str, float]()
    if compared := turns_compared(spec, settling, turns):
        ranges = cases.measures.turn_ranges(list(each_turn(record, turns - compared + 1, turns)), reference)
    settled = turns if settling is not None and settling.settled else None
    period = None if settling is None else settling.motion_period
    cautions = None
    if spec.examine and not record.static:
        cautions = case_cautions(record, reference, turns_repeat(turns, values, ranges))
    return Outcome(
        values, turns, settled, str(Status.COMPLETE), None, choice.step, steps, period, last, ranges, cautions
    )


def unsound(record: Record) -> str:
    """Return why a run is not complete."""
    time = record.steps[-1] * record.assembly.choice.step
    if record.status == Status.DIVERGED:
        if soft := soft_contact(record):
            return soft
        remedy = "take a smaller step, or look for parts that are far too stiff or light"
        return f"numbers grew without bound after step {record.reached}, {time:.4g} s: {remedy}"
    return f"it ended as {record.status} after step {record.reached}, {time:.4g} s"
