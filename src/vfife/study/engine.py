"""Members of a study: one mechanism with other numbers each, run on all that the machine has; of each the measures that are wanted are left.

A member is what its own run would be, to the bit, whatever runs beside it.
"""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field

from ..analysis.measures import compared, last_turn, over_run, over_turn
from ..analysis.turns import each_turn
from ..errors import VfifeError
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..result import Result
from ..simulation import carry_out, prepare
from ..solvers.arguments import Asked
from ..solvers.record import Record
from ..solvers.repeating import outputs_of_a_turn
from ..solvers.status import Status


@dataclass(frozen=True)
class Wanted:
    """What is asked of every member: ``measures`` by the names that ``vfife run --json`` gives them, all where there are none.

    It is stepped for so many ``turns`` at the most, and ends before where turns repeat within ``settle`` (1). Measures of a turn are means over the
    ``last`` turns. ``step`` (s): None takes the automatic step of each.
    """

    measures: tuple[str, ...]
    turns: int
    settle: float | None = None
    last: int = 1
    step: float | None = None


@dataclass(frozen=True)
class Outcome:
    """What a member leaves: ``values`` by measure, SI units, none where it failed; whole turns made, the one from which on turns repeat.

    ``status`` as of a run ("complete", "diverged", "energy"), or "failed" where it could not be assembled; ``reason``: one sentence where it is
    not complete. ``step`` (s) and ``steps`` are those it was run with.
    """

    values: dict[str, float] = field(default_factory=dict)
    turns: int = 0
    settled: int | None = None
    status: str = "complete"
    reason: str | None = None
    step: float = math.nan
    steps: int = 0


def run_members(
    base: Mechanism,
    numbers: Sequence[Mapping[str, float | str]],
    wanted: Wanted,
    *,
    workers: int | None = None,
    lanes: int | None = None,
    stop: threading.Event | None = None,
) -> Iterator[tuple[int, Outcome]]:
    """Runs a mechanism with each of ``numbers``, values by path as ``--set`` takes them (SI, or texts with a unit); outcomes come as they end.

    A member that cannot be assembled or diverges is an outcome with its reason; the others go on. ``workers``: threads, one a core unless given;
    ``lanes``: simulations side by side in each. With ``stop`` set, members that have not ended are left out.
    """
    text, stop = dump(base), stop or threading.Event()

    def one(k: int) -> tuple[int, Outcome | None]:
        return k, None if stop.is_set() else single(text, numbers[k], wanted)

    pool = ThreadPoolExecutor(workers or os.cpu_count() or 1)
    try:
        left: set[Future[tuple[int, Outcome | None]]] = {pool.submit(one, k) for k in range(len(numbers))}
        while left:
            done, left = wait(left, return_when=FIRST_COMPLETED)
            for future in done:
                k, found = future.result()
                if found is not None:
                    yield k, found
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


def single(text: str, numbers: Mapping[str, float | str], wanted: Wanted) -> Outcome:
    """A member run by itself."""
    try:
        mechanism = loads(text, set=list(numbers.items()))
        asked = Asked(turns=float(wanted.turns), step=wanted.step, companions=0, settle=wanted.settle, force_step=wanted.step is not None)
        result = carry_out(prepare(mechanism, asked))
    except VfifeError as error:
        return Outcome(status="failed", reason=sentence(error))
    return outcome(result, wanted)


def sentence(error: VfifeError) -> str:
    """An error in one line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return " ".join(lines)


def outcome(result: Result, wanted: Wanted) -> Outcome:
    """What is wanted of a run."""
    record, choice = result.record, result.record.assembly.choice
    per = outputs_of_a_turn(record.assembly) or 0
    made = (len(record.steps) - 1) // per if per else 0
    steps = int(record.steps[-1])
    if record.status != Status.COMPLETE:
        return Outcome({}, made, None, str(record.status), f"{record.status} after {steps} steps", choice.step, steps)
    settled = None if wanted.settle is None or made == wanted.turns else made
    values = mean_measures(record, None if result.reference is None else result.reference.measures, made, wanted.last)
    chosen = {name: values[name] for name in wanted.measures if name in values} if wanted.measures else values
    return Outcome(chosen, made, settled, "complete", None, choice.step, steps)


def mean_measures(record: Record, reference: Mapping[str, float] | None, made: int, last: int) -> dict[str, float]:
    """Means over the last turns, and counts of the whole run."""
    parts = list(each_turn(record, max(1, made - last + 1), made)) if made else [record]
    turnly = []
    for part in parts:
        found = over_turn(part, last_turn(part))
        turnly.append(found | compared(part, found, reference))
    mean = {}
    for name in turnly[-1]:
        values = [turn[name] for turn in turnly if name in turn]
        mean[name] = math.fsum(values) / len(values)
    return mean | over_run(record)
