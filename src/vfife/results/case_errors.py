"""Numerical error of the cases of a study, from a sample of them that was repeated with another step size.

A case has no companions, so its own run cannot show its error. A sample of cases is computed a second time
with about 1.5 times the step. The error of a case is estimated from the change of each measure: with r the
ratio of the steps and p the order of the method, error = change / (r^p - 1). Contact onsets make the method
first order, so that the error is twice the change at r = 1.5; without contacts it is of second order. The
estimate is never smaller than the change.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..solvers.status import Status
from ..store.studyfile import REPEATS

if TYPE_CHECKING:
    from ..store.studyfile import StudyCase

Outcomes = Mapping[int, Mapping[str, Any]]
# Cases of a sample: at least so many, all if there are fewer, and of a large study this share. Of 20
# cases the largest error exceeds that of 86 % of all cases with 95 % confidence (1 - 0.05^(1/20) = 0.14).
LEAST_SAMPLE = 20
SHARE_OF_SAMPLE = 1 / 100
SAME_STEP = 1e-3  # steps whose ratio is nearer to 1 tell nothing
NOT_ESTIMATED = "not estimated"


@dataclass(frozen=True)
class ErrorEstimate:
    """Numerical error of one measure of a case, from a sample of ``count`` repeated cases.

    ``typical``, ``rms`` and ``most``: median, root mean square and largest error in the sample, in the unit
    of the measure. ``step_ratio``: median step of the repetitions over the step of their cases (1).
    ``failed``: cases of the sample that have no value at another step, of which nothing is known.
    """

    count: int
    typical: float
    rms: float
    most: float
    step_ratio: float
    failed: int = 0

    @property
    def words(self) -> str:
        """Description of how the error was estimated."""
        missing = f"; {self.failed:,} more gave no value" if self.failed else ""
        return f"sample of {self.count:,}, step {self.step_ratio:.3g} times{missing}"

    def at_quantile(self, share: float) -> float:
        """Bound the numerical error of a quantile (unit of the measure).

        Let e be the errors of all cases. The quantile functions of the exact and of the computed values
        differ by at most rms(e) in the root mean square over all shares (Wasserstein distance of order 2,
        cases paired with themselves). A difference at q that is as large in all of the smaller tail, of
        mass m = min(q, 1 - q), is therefore at most rms / sqrt(m). No quantile moves by more than the largest
        error.

        ``share``: q, between 0 and 1.
        """
        return min(self.most, self.rms / math.sqrt(min(share, 1.0 - share)))


def sample_of(cases: Sequence[StudyCase], outcomes: Outcomes) -> list[StudyCase]:
    """Choose the cases to repeat: of all complete ones, those with the least hashes of their hashes.

    The choice depends only on the numbers of the cases, so a study that grew in pieces has the same sample as
    one made at once.
    """
    sound = [case for case in cases if case.number in outcomes and can_repeat(outcomes[case.number])]
    ranked = sorted(sound, key=lambda case: hashlib.blake2b(case.hash.encode(), digest_size=16).digest())
    return ranked[: sample_size(len(cases))]


def sample_size(count: int) -> int:
    """Return how many of ``count`` cases are repeated."""
    return min(count, max(LEAST_SAMPLE, math.ceil(SHARE_OF_SAMPLE * count)))


def can_repeat(outcome: Mapping[str, Any]) -> bool:
    """Return whether a case is complete and its turns, if it has some, have a whole number of steps."""
    turns, steps = outcome["turns"], outcome["steps"]
    divisible = steps % turns == 0 if turns > 0 else steps > 0
    return bool(outcome["status"] == Status.COMPLETE and divisible and outcome["step"] > 0.0)


def error_over_change(ratio: float, order: int) -> float:
    """Return the factor from the change of a measure between two step sizes to the error at the first of
    them, at least 1.

    ``ratio``: the second step over the first (1), not 1. ``order``: order of convergence.
    """
    power = 1.0
    for _ in range(order):
        power *= ratio
    return max(1.0, 1.0 / abs(power - 1.0))


def case_errors(
    cases: Sequence[StudyCase],
    outcomes: Outcomes,
    repeats: Outcomes,
    measures: Sequence[str],
    meta: Mapping[str, Any],
) -> dict[str, ErrorEstimate]:
    """Estimate the numerical error of each measure; a measure without two values to compare is left out.

    ``repeats``: outcomes at another step, by the number of the case. ``meta``: of the study file.
    """
    if REPEATS not in meta:
        return {}
    order = int(meta[REPEATS]["order"])
    pairs = [
        (outcomes[case.number], repeats[case.number])
        for case in sample_of(cases, outcomes)
        if case.number in repeats
    ]
    estimates = {}
    for name in measures:
        errors, ratios = [], []
        for outcome, repeat in pairs:
            values = outcome["measures"].get(name), repeat["measures"].get(name)
            ratio = repeat["step"] / outcome["step"]
            if (
                values[0] is None
                or values[1] is None
                or repeat["status"] != Status.COMPLETE
                or abs(ratio - 1.0) < SAME_STEP
            ):
                continue
            ratios.append(ratio)
            errors.append(abs(values[1] - values[0]) * error_over_change(ratios[-1], order))
        if errors:
            rms = math.sqrt(math.fsum(error * error for error in errors) / len(errors))
            missing = len(pairs) - len(errors)
            estimates[name] = ErrorEstimate(
                len(errors), median(errors), rms, max(errors), median(ratios), missing
            )
    return estimates


def median(values: Sequence[float]) -> float:
    """Return the median."""
    ranked, half = sorted(values), len(values) // 2
    return ranked[half] if len(ranked) % 2 else 0.5 * (ranked[half - 1] + ranked[half])
