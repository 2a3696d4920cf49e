"""Further step sizes for the sample of a study whose measures depend on the step.

The first repetition of a sampled case shows whether its measures depend on the step. Where they do, a single
change says little: two values that scatter may agree by chance. Each case of the sample is then computed with
VALUES more steps, those of TRIALS in this order that differ from its former ones. A step that is not stable
gives no values, and the next one replaces it. In a sample of few cases all first repetitions may agree by
chance, so that each of them has VALUES more steps in any event, four values as of a run and its companions.
Its largest error is that of few values too: where measures depend on the step it has VALUES_OF_FEW more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from ...results.case_errors import SAME_STEP, SMALL_SAMPLE, repeated_cases
from ...solvers.status import Status

if TYPE_CHECKING:
    from ...store.studyfile import StudyCase, StudyFile

# Steps over that of the case: coarser ones first, which cost less. With the case and its first repetition
# there are four values, as of a run and its companions.
TRIALS = (2.0, 1.25, 0.8, 1.0 / 1.5, 0.5)
VALUES = 2
VALUES_OF_FEW = 4  # of each case of a sample of less than SMALL_SAMPLE
ROUNDING = 1e-9  # of the steps in a turn: a number that is as near to a whole one is that
Outcomes = Mapping[int, Mapping[str, Any]]
StepOf: TypeAlias = "Callable[[StudyCase, float], float]"


def trials_cost(sample: int, step_dependent: bool) -> float:
    """Return the cost of the trials of a case of a ``sample``, over that of the case."""
    return math.fsum(1.0 / ratio for ratio in TRIALS[: trial_count(sample, step_dependent)])


def trial_count(sample: int, step_dependent: bool) -> int:
    """Return how many more values each case of a ``sample`` needs; ``step_dependent``: measures depend on
    the step.
    """
    if sample < SMALL_SAMPLE:
        return VALUES_OF_FEW if step_dependent else VALUES
    return VALUES if step_dependent else 0


class Trial(NamedTuple):
    """A repetition that is missing: the place in TRIALS, and the step (s)."""

    case: StudyCase
    trial: int
    step: float


def steps_of_turn(outcome: Mapping[str, Any], turn: float | None) -> int:
    """Return the number of steps in a turn of a case; 0 if it has no turns, or the step does not divide them.

    ``turn`` (s): of the crank of a case with a duration, which need not end with a turn; None for a case with
    a whole number of turns, or without a crank.
    """
    if turn is not None:
        exact = turn / outcome["step"]
        return round(exact) if abs(exact - round(exact)) <= ROUNDING * exact else 0
    turns, steps = outcome["turns"], outcome["steps"]
    return int(steps // turns) if turns and steps % turns == 0 else 0


def repeated_step(outcome: Mapping[str, Any], turn_steps: int, outputs: int, ratio: float) -> float:
    """Return the step (s) nearest ``ratio`` times that of a case by which a turn has a whole number of
    ``outputs``, and each of these of steps; of a case without ``turn_steps``, ``ratio`` times its step.
    """
    if not turn_steps:
        return float(outcome["step"] * ratio)
    interval = turn_steps // outputs if turn_steps % outputs == 0 else 0
    count = outputs * max(1, round(interval / ratio)) if interval > 1 else round(turn_steps / ratio)
    return float(outcome["step"] * turn_steps / max(1, count))


def missing_trials(
    file: StudyFile, sample: Sequence[StudyCase], outcomes: Outcomes, step_of: StepOf
) -> list[Trial]:
    """Return the next trial of each case of the sample that lacks values; ``step_of``: the step (s) of a case
    at a ratio to its own.
    """
    repeats, trials = file.repeats(), file.step_trials()
    repeated = repeated_cases(file.cases(), outcomes, repeats, trials)
    count, missing = trial_count(len(sample), any(case.changed_measures for case in repeated)), list[Trial]()
    for case in sample:
        done = {
            trial: outcome
            for trial, outcome in trials.get(case.number, {}).items()
            if outcome["hash"] == case.hash
        }
        if sum(outcome["status"] == Status.COMPLETE for outcome in done.values()) < count:
            missing += next_trial(case, outcomes[case.number], repeats[case.number], done, step_of)
    return missing


def next_trial(
    case: StudyCase,
    outcome: Mapping[str, Any],
    repeat: Mapping[str, Any],
    done: Mapping[int, Mapping[str, Any]],
    step_of: StepOf,
) -> list[Trial]:
    """Return the first trial that is not ``done`` and whose step differs from all former ones."""
    steps = [outcome["step"], repeat["step"]]
    for trial, ratio in enumerate(TRIALS):
        step = step_of(case, ratio)
        if all(abs(step / size - 1.0) >= SAME_STEP for size in steps if size > 0.0):
            if trial not in done:
                return [Trial(case, trial, step)]
            steps.append(step)
    return []
