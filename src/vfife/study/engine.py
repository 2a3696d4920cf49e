"""Members of a study: one mechanism with other numbers each, run on all that the machine has; of each the measures that are wanted are left.

A member is what its own run would be, to the bit, whatever runs beside it.
"""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import partial

from ..analysis.turns import each_turn
from ..codegen.cuda import WITHOUT, card
from ..errors import DeviceError, VfifeError
from ..model.mechanism import Mechanism
from ..simulation import carry_out, prepare
from ..solvers.arguments import RunArguments
from ..solvers.record import Record
from ..solvers.repeating import Settling, outputs_of_a_turn
from ..solvers.status import Status
from ..solvers.streaming import PATIENCE, stepped
from .cases import Cases, NoLane, Numbers, sentence
from .member import Stepped, Wanted

FAILED = "failed"

__all__ = ["Outcome", "Wanted", "run_members"]


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
    numbers: Sequence[Numbers],
    wanted: Wanted,
    *,
    workers: int | None = None,
    lanes: int | None = None,
    stop: threading.Event | None = None,
    device: str | None = None,
) -> Iterator[tuple[int, Outcome]]:
    """Runs a mechanism with each of ``numbers``, values by path as ``--set`` takes them (SI, or texts with a unit); outcomes come as they end.

    A member that cannot be assembled or diverges is an outcome with its reason; the others go on. ``workers``: threads, one a core unless given;
    ``lanes``: simulations side by side in each. With ``stop`` set, members that have not ended are left out. ``device``: "cuda" steps them on an
    NVIDIA card, but for those that have a run of their own; it raises DeviceError.
    """
    stop, cases = stop or threading.Event(), Cases(base, wanted)
    alone: list[int] = []
    for one in stepped(cases.each(numbers), len(numbers), lanes=lanes, workers=workers, stop=stop, device=device):
        if isinstance(one, NoLane) and one.reason is not None:
            yield one.number, Outcome(status=FAILED, reason=one.reason)
        elif isinstance(one, Stepped) and not one.doubtful:
            step, every = one.assembly.choice.step, one.per * one.assembly.choice.outputs_every
            yield one.number, Outcome(one.values, one.turns, one.settled, str(Status.COMPLETE), None, step, one.turns * every)
        else:
            alone.append(one.number)
    yield from by_themselves(cases, numbers, alone, workers, stop)


def on_device(name: str | None) -> Callable[..., Iterator[tuple[int, Outcome]]] | None:
    """What runs members on a device; None for the processor. Raises DeviceError where it cannot be used, before anything is done."""
    if name is None:
        return None
    if name != "cuda":
        raise DeviceError(f'device {name}: there is no such device; there is "cuda", an NVIDIA card; {WITHOUT}')
    card()
    return partial(run_members, device=name)


def by_themselves(
    cases: Cases, numbers: Sequence[Numbers], which: Sequence[int], workers: int | None, stop: threading.Event
) -> Iterator[tuple[int, Outcome]]:
    """Members that have runs of their own: those that go into no lane, and those of which a lane cannot tell what became of them."""

    def one(k: int) -> tuple[int, Outcome | None]:
        return k, None if stop.is_set() else single(cases, numbers[k])

    pool = ThreadPoolExecutor(workers or os.cpu_count() or 1)
    try:
        left = {pool.submit(one, k) for k in which}
        while left:
            done, left = wait(left, timeout=PATIENCE, return_when=FIRST_COMPLETED)
            for k, found in (future.result() for future in done):
                if found is not None:
                    yield k, found
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def single(cases: Cases, numbers: Numbers) -> Outcome:
    """A member run by itself, as ``vfife run`` does without companions."""
    wanted = cases.wanted
    try:
        mechanism = cases.mechanism(numbers)
        asked = RunArguments(turns=float(wanted.turns), step=wanted.step, companions=0, settle=wanted.settle)
        result = carry_out(prepare(mechanism, asked))
    except VfifeError as error:
        return Outcome(status=FAILED, reason=sentence(error))
    record, choice = result.record, result.record.assembly.choice
    per = outputs_of_a_turn(record.assembly) or 0
    made, steps = (len(record.steps) - 1) // per if per else 0, int(record.steps[-1])
    if record.status != Status.COMPLETE:
        return Outcome({}, made, None, str(record.status), unsound(record), choice.step, steps)
    parts = list(each_turn(record, max(1, made - wanted.last + 1), made)) if made else [record]
    values = cases.measures.over(parts, None if result.reference is None else result.reference.measures)
    settling = None if wanted.settle is None else Settling(record.assembly, record.kept, wanted.settle)
    if settling is not None:
        settling.restore(record.rows)
    settled = made if settling is not None and settling.ended else None
    return Outcome(values, made, settled, str(Status.COMPLETE), None, choice.step, steps)


def unsound(record: Record) -> str:
    """Why a run is not complete, in a sentence."""
    time = record.steps[-1] * record.assembly.choice.step
    if record.status == Status.DIVERGED:
        remedy = "take a smaller step, or look for parts that are far too stiff or light"
        return f"numbers left all bounds after step {record.reached}, {time:.4g} s: {remedy}"
    return f"it ended as {record.status} after step {record.reached}, {time:.4g} s"
