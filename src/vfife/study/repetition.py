"""Repetition of a sample of members with another step size, by which a study knows the numerical error of its measures."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Generator, Mapping, Sequence
from typing import Any

from ..model.mechanism import Mechanism
from ..results.member_errors import sample_of
from ..results.studyfile import WHAT, Kept, StudyFile
from ..solvers.status import Status
from .carry import Runner, complete, runner_of
from .engine import Wanted

STEP = "run.step"  # path of the step in a model
RATIO = 1.5  # step of a repetition over that of its member; the coarser run costs two thirds of the member


def repeat_sample(file: StudyFile, base: Mechanism, *, workers: int | None = None, lanes: int | None = None, runner: Runner | None = None) -> bool:
    """Compute the members of the sample again with other steps, and keep what they come to; those that are kept are not repeated.

    A member that is not stable with the coarser step is repeated with a finer one, and one that fails with both is kept as failed. A static
    analysis has no step, and is not repeated. ``runner`` is as in :func:`~vfife.study.carry.carry_out`.

    Returns whether the sample is complete: after Ctrl-C it is not. Raises StorageError if nothing can be written.
    """
    if base.settings.analysis == "static":
        return True
    outcomes, known = file.outcomes(), file.repeats()
    left = [one for one in sample_of(file.members(), outcomes) if known.get(one.number, {}).get("hash") != one.hash]
    if not left:
        return True
    file.begin_repeats({"order": 1 if base.contacts else 2, "ratio": RATIO})
    run = Repetition(file, base, outcomes, workers, lanes, runner_of(runner))
    try:
        finer = run.repeat(left, RATIO, last=False)
        run.repeat(finer, 1.0 / RATIO, last=True)
    except KeyboardInterrupt:
        file.flush()
        return False
    file.flush()
    return True


@dataclasses.dataclass
class Repetition:
    """Members that are repeated into a study file, ``outcomes`` being those of their own steps."""

    file: StudyFile
    base: Mechanism
    outcomes: Mapping[int, Mapping[str, Any]]
    workers: int | None
    lanes: int | None
    runner: Runner

    def repeat(self, members: Sequence[Kept], ratio: float, last: bool) -> list[Kept]:
        """Run members with about so many times their step; return those that failed, which are kept only the ``last`` time."""
        if not members:
            return []
        asked = self.file.meta[WHAT]["wanted"]
        wanted = Wanted(**{**asked, "measures": tuple(asked["measures"]), "step": None})
        numbers = [{**one.numbers, STEP: self.step(one, ratio)} for one in members]
        failed, stop = list[Kept](), threading.Event()
        found = self.runner(self.base, numbers, wanted, workers=self.workers, lanes=self.lanes, stop=stop)
        try:
            for k, outcome in found:
                if outcome.status == Status.COMPLETE or last:
                    self.file.record_repeat(members[k], complete(outcome, wanted))
                else:
                    failed.append(members[k])
        finally:
            stop.set()
            if isinstance(found, Generator):
                found.close()
        return sorted(failed, key=lambda one: one.number)

    def step(self, member: Kept, ratio: float) -> float:
        """The step (s) nearest ``ratio`` times that of a member by which a turn has a whole number of outputs, and each of these of steps."""
        outcome, per = self.outcomes[member.number], self.base.settings.outputs
        turn = outcome["steps"] // outcome["turns"]
        every = turn // per if turn % per == 0 else 0
        count = per * max(1, round(every / ratio)) if every > 1 else round(turn / ratio)
        return float(outcome["step"] * turn / max(1, count))
