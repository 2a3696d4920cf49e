"""Numerical error of the cases of a study, from a sample of them that was repeated with other step sizes.

A case has no companions, so its own run cannot show its error. A sample of cases is computed a second time
with about 1.5 times the step. Where the motion repeats, the error of a case follows from the change of each
measure: with r the ratio of the steps and p the order of the method, error = change / (r^p - 1). Contact
onsets make the method first order, so that the error is twice the change at r = 1.5; without contacts it is
of second order. The estimate is never smaller than the change.

Where the motion does not repeat, values scatter with the step, and two of them may agree by chance. If a
measure of any case changes by more than SENSITIVE, the whole sample is repeated with further steps
(:mod:`~vfife.studies.engine.step_trials`). A case whose values then change monotonically with the step
has a coarse step; any other is called sensitive. Its error follows from the width of the values at all
steps (SCATTER_OF_CASE).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from ..measures.extrapolation import (
    COUNTS,
    LANES_OF_MEANS,
    LEAST_COUNT,
    LEAST_ERROR,
    SAFETY,
    VANISHING,
    error_factor,
    observed_order,
)
from ..solvers.companions import SENSITIVE
from ..solvers.status import Status
from ..store.studyfile import REPEATS

if TYPE_CHECKING:
    from ..store.studyfile import StudyCase

Outcomes = Mapping[int, Mapping[str, Any]]
TrialOutcomes = Mapping[int, Mapping[int, Mapping[str, Any]]]  # by case and trial
# Cases of a sample: at least so many, all if there are fewer, and of a large study this share. Of 20
# cases the largest error exceeds that of 86 % of all cases with 95 % confidence (1 - 0.05^(1/20) = 0.14).
LEAST_SAMPLE = 20
SHARE_OF_SAMPLE = 1 / 100
# Two values that scatter by 3 % agree within 1 % with a probability of 0.19: in one case, hardly in four. The
# cases of smaller samples have four steps in any event, because three values of one measure may agree too.
SMALL_SAMPLE = 4
# Times the width of the values of a sensitive case, of which some lie far from all others. How often an error
# holds is in docs/study.md; with twice the width it holds for 0.1 to 1.3 % fewer values of each measure.
SCATTER_OF_CASE = 3.0
SAME_STEP = 1e-3  # steps whose ratio is nearer to 1 tell nothing
NOT_ESTIMATED = "not estimated"
# Measures that change with the step although the motion does not: how deep a first step lands, and numbers of
# contacts, of which a grazing one more is no other motion.
STEP_DEPENDENT = (*VANISHING, *COUNTS)
# Values below this share of the largest of their measure in the study are compared with that share.
LEAST_SHARE = 0.1


@dataclass(frozen=True)
class ErrorEstimate:
    """Numerical error of one measure of a case, from a sample of ``count`` repeated cases.

    ``typical``, ``rms`` and ``most``: median, root mean square and largest error in the sample, in the unit
    of the measure. ``step_ratio``: median step of the repetitions over the step of their cases (1).
    ``failed``: cases of the sample that have no value at another step, of which nothing is known.
    ``sensitive``: cases of the sample whose motion depends on the step; ``steps``: the most step sizes that a
    case was computed with. ``floor``: median of the least bounds of an error; a typical one below it is told
    as less than it.
    """

    count: int
    typical: float
    rms: float
    most: float
    step_ratio: float
    failed: int = 0
    sensitive: int = 0
    steps: int = 2
    floor: float = 0.0

    @property
    def words(self) -> str:
        """Description of how the error was estimated."""
        missing = f"; {self.failed:,} more gave no value" if self.failed else ""
        scatter = f"; {self.sensitive:,} sensitive" if self.sensitive else ""
        steps = f"{self.steps} steps" if self.steps > 2 else f"step {self.step_ratio:.3g} times"
        return f"sample of {self.count:,}, {steps}{scatter}{missing}"

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


def has_single_turn(outcome: Mapping[str, Any]) -> bool:
    """Return whether measures of a case are means over a part of its period, or of a turn of a motion that
    does not repeat.
    """
    period, turns = outcome.get("period"), outcome.get("measured_turns") or 1
    return bool(outcome.get("ranges")) and (period is None or turns % period != 0)


def uncertain_ranges(request: Mapping[str, Any], outcomes: Outcomes) -> dict[int, Mapping[str, float]]:
    """Return by how much measures differ between turns, by number of the cases with ``settle`` whose measures
    are of one turn although turns do not repeat one by one: their values are as uncertain.

    ``request``: what is computed of each case.
    """
    if request.get("settle") is None:
        return {}
    return {number: outcome["ranges"] for number, outcome in outcomes.items() if has_single_turn(outcome)}


def turn_changes(cases: Outcomes, outcomes: Outcomes) -> dict[int, dict[str, float]]:
    """Return by what share (1) of their size measures of single turns differ between the last turns, by
    number of the case, where that is more than SENSITIVE. ``outcomes``: of the whole study.
    """
    sizes = sizes_of(outcomes)
    changes = {number: changes_between_turns(outcome, sizes) for number, outcome in cases.items()}
    return {number: shares for number, shares in changes.items() if shares}


def changes_between_turns(outcome: Mapping[str, Any], sizes: Mapping[str, float]) -> dict[str, float]:
    """Return these shares of one case. ``sizes``: the largest magnitudes of the measures in the study."""
    shares = {}
    for name, width in outcome.get("ranges", {}).items():
        size = max(abs(outcome["measures"].get(name, 0.0)), LEAST_SHARE * sizes.get(name, 0.0))
        if width > SENSITIVE * size and not name.endswith(STEP_DEPENDENT):
            shares[name] = width / size if size > 0.0 else math.inf
    return shares


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
    """Return whether a case is complete and took steps, so that it can have another one."""
    return bool(outcome["status"] == Status.COMPLETE and outcome["steps"] > 0 and outcome["step"] > 0.0)


def error_over_change(ratio: float, order: int) -> float:
    """Return the factor from the change of a measure between two step sizes to the error at the first of
    them, at least 1.

    ``ratio``: the second step over the first (1), not 1. ``order``: order of convergence.
    """
    power = 1.0
    for _ in range(order):
        power *= ratio
    return max(1.0, 1.0 / abs(power - 1.0))


@dataclass(frozen=True)
class RepeatedCase:
    """A case of the sample: its ``number`` and ``outcome``, and those of its ``repeats`` that are complete
    with another step; ``sizes`` are the largest magnitudes of the measures in the study.
    """

    number: int
    outcome: Mapping[str, Any]
    repeats: tuple[Mapping[str, Any], ...]
    sizes: Mapping[str, float]

    def values(self, name: str) -> tuple[list[float], list[float]]:
        """Return the step ratios (1) and values of a measure, the case first; empty if it has no value."""
        ratios, values = [], []
        for outcome in (self.outcome, *self.repeats):
            value = outcome["measures"].get(name)
            if value is not None:
                ratios.append(outcome["step"] / self.outcome["step"])
                values.append(value)
            elif not values:
                return [], []
        return ratios, values

    def differs(self, name: str) -> bool:
        """Return whether a measure differs between the steps by more than SENSITIVE of its size, as with a
        run and its companions.
        """
        _, values = self.values(name)
        if len(values) < 2 or name.endswith(STEP_DEPENDENT):
            return False
        size = max(*map(abs, values), LEAST_SHARE * self.sizes[name])
        return max(values) - min(values) > SENSITIVE * size

    @cached_property
    def changed_measures(self) -> tuple[str, ...]:
        """Measures that differ between the steps."""
        return tuple(name for name in self.outcome["measures"] if self.differs(name))

    @cached_property
    def sensitive(self) -> bool:
        """Whether the motion depends on the step: a measure differs, and its values do not converge."""
        series = [self.values(name) for name in self.changed_measures]
        return any(
            len(values) < LANES_OF_MEANS or observed_order(ratios, values) is None
            for ratios, values in series
        )

    def error(self, name: str, order: int) -> CaseError | None:
        """Return the error of a measure; None without two values."""
        ratios, values = self.values(name)
        if len(values) < 2:
            return None
        changes = [abs(value - values[0]) for value in values[1:]]
        pairs = zip(changes, ratios[1:], strict=True)
        estimates = [change * error_over_change(ratio, order) for change, ratio in pairs]
        size, bound, floor = rms(estimates), estimates[0], 0.0
        width = max(values) - min(values)
        if order == 1 or (len(values) > 2 and self.sensitive):
            floor = LEAST_COUNT if name.endswith(COUNTS) else LEAST_ERROR * max(map(abs, values))
        if self.sensitive:
            # Of values that scatter, the changes are the errors.
            factor = max(SCATTER_OF_CASE, error_factor(ratios, values))
            size, bound = rms(changes), max(*changes, estimates[0]) + factor * width
        elif order == 1 or len(values) > 2:
            bound = SAFETY * max(estimates)
            if order == 1 and len(values) > 2:
                bound = max(bound, width * error_factor(ratios, values))
        return CaseError(size, max(bound, floor), median(ratios[1:]), len(values), floor)


class CaseError(NamedTuple):
    """Error of a measure of one case: what to expect (``size``), what it does not exceed (``bound``), the
    median ratio of the steps of its repeats (1), and the number of step sizes. ``floor``: least bound, below
    which steps tell nothing.
    """

    size: float
    bound: float
    ratio: float
    steps: int
    floor: float = 0.0


class SampleErrors:
    """Numerical errors of the cases of a ``sample`` and, from them, of any case of the study.

    ``meta``: of the study file; without its entry of repetitions there are no errors. ``ranges``: by how much
    measures differ between turns, of cases whose values are of one of these turns.
    """

    def __init__(
        self,
        sample: Sequence[RepeatedCase],
        measures: Sequence[str],
        meta: Mapping[str, Any],
        ranges: Mapping[int, Mapping[str, float]] | None = None,
    ) -> None:
        self.sample, self.meta, self.ranges = sample, meta, dict(ranges or {})
        self.by_measure = {name: self._by_case(name) for name in measures} if REPEATS in meta else {}

    def _by_case(self, name: str) -> dict[int, CaseError]:
        """Return the error of a measure by number of the case, where it has two values to compare."""
        order, sizes = int(self.meta[REPEATS]["order"]), dict[int, float]()
        errors = {
            case.number: error for case in self.sample if (error := case.error(name, order)) is not None
        }
        for case in self.sample:
            if case.number in errors:
                value = case.outcome["measures"][name]
                sizes[case.number] = max(abs(value), LEAST_SHARE * case.sizes[name])
        # Two values of a case may agree by chance, those of all cases do not: none is known better than the
        # root mean square of the sample, as a share of its size.
        pairs = [number for number, error in errors.items() if error.steps == 2 and sizes[number] > 0.0]
        if order > 1 or not pairs:
            return errors
        share = rms([errors[number].bound / sizes[number] for number in pairs])
        floors = {number: share * sizes[number] for number in pairs}
        return {
            number: error._replace(bound=max(error.bound, floors.get(number, 0.0)))
            for number, error in errors.items()
        }

    @cached_property
    def sensitive(self) -> tuple[int, int]:
        """Number of cases whose motion depends on the step, and of all."""
        return sum(case.sensitive for case in self.sample), len(self.sample)

    @cached_property
    def estimates(self) -> dict[str, ErrorEstimate]:
        """Estimate of each measure; one without two values to compare is left out."""
        return {name: self._estimate(name, by_case) for name, by_case in self.by_measure.items() if by_case}

    def _estimate(self, name: str, by_case: Mapping[int, CaseError]) -> ErrorEstimate:
        errors = list(by_case.values())
        ranges = [turns.get(name, 0.0) for turns in self.ranges.values()]
        return ErrorEstimate(
            len(errors),
            median([error.size for error in errors]),
            rms([error.size for error in errors]),
            max(*(error.bound for error in errors), *ranges, 0.0),
            median([error.ratio for error in errors]),
            len(self.sample) - len(errors),
            sum(case.sensitive for case in self.sample if case.number in by_case),
            max(error.steps for error in errors),
            median([error.floor for error in errors]),
        )

    def bars(self, name: str, numbers: Sequence[int]) -> list[float]:
        """Return the error that a figure shows at the value of each case: the typical one; where the motion
        is sensitive, the largest of the case, or that of the sample for a case that was not repeated.
        """
        estimate = self.estimates[name]
        if estimate.sensitive:
            return self.bounds(name, numbers)
        return [max(estimate.typical, self.ranges.get(number, {}).get(name, 0.0)) for number in numbers]

    def bounds(self, name: str, numbers: Sequence[int]) -> list[float]:
        """Return the largest error of the value of each case: its own, or that of the sample for a case that
        was not repeated.
        """
        by_case = self.by_measure[name]
        largest = max(error.bound for error in by_case.values())
        bounds = ((number, by_case[number].bound if number in by_case else largest) for number in numbers)
        return [max(bound, self.ranges.get(number, {}).get(name, 0.0)) for number, bound in bounds]


def repeated_cases(
    cases: Sequence[StudyCase], outcomes: Outcomes, repeats: Outcomes, trials: TrialOutcomes
) -> list[RepeatedCase]:
    """Return the cases of the sample that were repeated.

    ``repeats``: outcomes at another step, by the number of the case; ``trials``: at more steps.
    """
    sizes = sizes_of(outcomes)
    sample = [case for case in sample_of(cases, outcomes) if case.number in repeats]

    def repeated(case: StudyCase, trials: Mapping[int, Mapping[str, Any]]) -> RepeatedCase:
        outcome = outcomes[case.number]
        runs = (repeats[case.number], *(trials[trial] for trial in sorted(trials)))
        complete = [run for run in runs if run["hash"] == case.hash and run["status"] == Status.COMPLETE]
        distinct = (run for run in complete if abs(run["step"] / outcome["step"] - 1.0) >= SAME_STEP)
        return RepeatedCase(case.number, outcome, tuple(distinct), sizes)

    # A study that grew has the estimates of one made at once, which has no trials if it needs none.
    first = [repeated(case, {}) for case in sample]
    if len(sample) >= SMALL_SAMPLE and not any(case.changed_measures for case in first):
        return first
    return [repeated(case, trials.get(case.number, {})) for case in sample]


def sizes_of(outcomes: Outcomes) -> dict[str, float]:
    """Return the largest magnitude of each measure in a study."""
    sizes: dict[str, float] = {}
    for outcome in outcomes.values():
        for name, value in outcome["measures"].items():
            sizes[name] = max(sizes.get(name, 0.0), abs(value))
    return sizes


def rms(values: Sequence[float]) -> float:
    """Return the root mean square."""
    return math.sqrt(math.fsum(value * value for value in values) / len(values))


def median(values: Sequence[float]) -> float:
    """Return the median."""
    ranked, half = sorted(values), len(values) // 2
    return ranked[half] if len(ranked) % 2 else 0.5 * (ranked[half - 1] + ranked[half])
