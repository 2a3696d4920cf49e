"""Local search from the best case of a search: SLSQP by derivatives of the measures, or pattern search where
these cannot be trusted.

A derivative of a measure with contact costs about three runs and may be meaningless where the motion is
nearly chaotic, which finite changes show. Then values alone lead on: a compass search, which asks for all its
points side by side and needs no smoothness. A model of the measure (Powell's methods) would need fewer cases,
but one after another.

The two end differently: SLSQP by the change of the measure (``PRECISION``), pattern search by its distance
alone (``LAST_DISTANCE``), however little the measure improves; both when ``search.refine`` cases are taken.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import VfifeError
from ...measures.catalogue import COUNTED
from ...modelfile import dump, loads
from ...results.derivatives import Sensitivity
from ..engine.study_engine import Engine
from ..spec.plan import Plan, case_numbers
from .derivatives import sensitivity
from .optimise import Candidate, Evaluate, Parameters, Search, Values, ask_and_tell, candidate, nearest

Array = NDArray[np.float64]
Rank = tuple[float, float]  # excess over the limits, then the measure: less is better, limits first
# Derivatives of measures by parameters (SI) at a point; raises VfifeError.
Derivatives = Callable[[Parameters], Mapping[str, Mapping[str, float]]]

# Of pattern search, as shares of the way between the bounds of an axis.
FIRST_DISTANCE = 0.05
LAST_DISTANCE = 1e-3  # noise of a measure with contact hides less than this

# Of SLSQP.
INSIDE = 1e-6  # margin to a limit, as a share of it: SLSQP ends close to a constraint, on either side
CLOSE = 1e-7  # distance of a point from another, as shares, below which it brings nothing new
MOST_CLOSE = 3  # such points one after another, at a kink of the measure, before the search ends
# Below this the search has converged: change of the measure, as a share of what it was in the best case
# before. SLSQP has one number for this and for the sum by which limits are broken (as shares of them), so it
# has to be far below INSIDE.
PRECISION = 1e-9

# Of the largest effect on a measure: a contradicted derivative of a smaller effect counts as zero, as it
# changes no direction.
INSIGNIFICANT = 0.05


class SearchEnd(Exception):
    """End of the search, with the reason."""


class Contradiction(VfifeError):
    """Finite changes contradict the derivatives at a point."""


@dataclass(frozen=True)
class Refinement:
    """Candidates of a local search, and in a sentence why there are none, or no more; empty where the search
    converged.
    """

    candidates: tuple[Candidate, ...] = ()
    reason: str = ""


def optimise(engine: Engine, plan: Plan, search: Search) -> tuple[list[Candidate], Refinement]:
    """Compute the cases of a search in a study file: all candidates in order, and of these the last, by the
    local search.
    """

    def evaluate(cases: Sequence[Parameters]) -> Sequence[Values | None]:
        return engine.ask([case_numbers(plan.parameters, case) for case in cases])

    candidates = ask_and_tell(search, evaluate)
    if not search.refine:
        return candidates, Refinement()
    refinement = refine(search, candidates, evaluate, partial(measure_derivatives, plan, search))
    return [*candidates, *refinement.candidates], refinement


def refine(
    search: Search, candidates: Sequence[Candidate], evaluate: Evaluate, derivatives: Derivatives
) -> Refinement:
    """Go on from the best of ``candidates``, with at most ``search.refine`` further cases."""
    from scipy.optimize import minimize

    if reason := derivatives_impossible(search):
        return Refinement(reason=reason)
    best = nearest(search, candidates)
    if best is None:
        return Refinement(reason="no case has all measures of the search")
    problem = ScaledProblem(search, best, len(candidates), evaluate, derivatives)
    margins = {"type": "ineq", "fun": problem.margins, "jac": problem.margin_slopes}
    # Cases are limited, by ScaledProblem.cases; iterations have ample room.
    options: dict[str, Any] = {"method": "SLSQP", "options": {"maxiter": 1000, "ftol": PRECISION}}
    options |= {
        "bounds": [(0.0, 1.0)] * len(problem.axes),
        "constraints": [margins] if problem.limits else [],
    }
    try:
        last = minimize(problem.value, problem.start, jac=problem.slope, **options)
        reason = "" if last.success else f"the method ended early ({last.message})"
    except Contradiction as error:
        reason = f"{one_line(error)}; {search_by_values(problem)}"
    except (SearchEnd, VfifeError) as error:
        reason = one_line(error)
    return Refinement(tuple(problem.candidates), reason)


def one_line(error: Exception) -> str:
    """Return the message of an error in one line."""
    return " ".join(str(error).split())


def search_by_values(problem: ScaledProblem) -> str:
    """Go on from the best point so far by pattern search; return in words how it ended."""
    points = [np.frombuffer(key) for key in problem.cache]
    ranks = problem.rank(points)
    try:
        pattern_search(points[min(range(len(points)), key=lambda k: ranks[k])], problem.rank)
    except SearchEnd as reason:
        return f"by values, {reason}"
    return "values alone led to the end"


def pattern_search(start: Array, rank: Callable[[Sequence[Array]], Sequence[Rank]]) -> Array:
    """Return the best point found from ``start`` on in the unit cube, by the ranks of points alone.

    All points at one distance along each axis are ranked, both ways; the best of them is the next centre, and
    where none is better the distance is halved (compass search: Kolda, Lewis and Torczon, SIAM Review 45,
    2003, pp. 385-482). What ``rank`` raises ends it.
    """
    centre = np.clip(start, 0.0, 1.0)
    (best,) = rank([centre])
    distance = FIRST_DISTANCE
    while distance >= LAST_DISTANCE:
        points = compass(centre, distance)
        ranks = rank(points)
        best_index = min(range(len(points)), key=lambda k: ranks[k], default=None)
        if best_index is not None and ranks[best_index] < best:
            centre, best = points[best_index], ranks[best_index]
        else:
            distance *= 0.5
    return centre


def compass(centre: Array, distance: float) -> list[Array]:
    """Return the points at a distance along each axis, both ways, clipped to the unit cube, without the
    centre.
    """
    steps = distance * np.repeat(np.eye(len(centre)), 2, axis=0) * np.tile([[1.0], [-1.0]], (len(centre), 1))
    points = np.clip(centre + steps, 0.0, 1.0)
    return [point for point in points if (point != centre).any()]


def derivatives_impossible(search: Search) -> str:
    """Return why a search cannot go on by derivatives, empty where it can, or is not to."""
    if not search.refine:
        return ""
    if len(search.aims) > 1:
        return "there are several aims, and derivatives lead to one point"
    if names := [name for name in search.measures if name.endswith(COUNTED) or "(" in name]:
        return f"{', '.join(names)} has no derivatives"
    if not any(axis.continuous for axis in search.axes):
        return "nothing varies continuously"
    return ""


class Limit(NamedTuple):
    """One end of a limit of a measure: ``sign`` is 1 for a least value and -1 for a largest; ``size`` makes
    its margin a share.
    """

    measure: str
    sign: float
    end: float
    size: float

    def margin(self, case: Candidate) -> float:
        """Return how far a candidate is within the limit, negative beyond it."""
        return self.sign * (case.measure(self.measure) - self.end) / self.size


@dataclass
class ScaledProblem:
    """The problem as SLSQP takes it: continuous axes as shares of their ways, the measure and the limits as
    shares of their sizes.

    SLSQP asks for value, margins and derivatives of a point separately, so cases (``cache``) and derivatives
    are cached by the bytes of the point. Everything else stays as it is in the ``best`` candidate.
    """

    search: Search
    best: Candidate
    count: int  # candidates before
    evaluate: Evaluate
    derivatives: Derivatives
    candidates: list[Candidate] = field(default_factory=list)
    close: int = 0  # points one after another that were close to another one

    def __post_init__(self) -> None:
        self.axes = [axis for axis in self.search.axes if axis.continuous]
        self.start = np.array([axis.share(float(self.best.parameters[axis.name])) for axis in self.axes])
        self.cache: dict[bytes, Candidate] = {self.start.tobytes(): self.best}
        self.slopes: dict[bytes, dict[str, Array]] = {}
        ((self.aim, self.sign),) = self.search.aims
        self.scale = abs(self.best.measure(self.aim)) or 1.0
        self.limits = [
            Limit(bound.measure, sign, end, abs(end) or abs(self.best.measure(bound.measure)) or 1.0)
            for bound in self.search.bounds
            for sign, end in ((1.0, bound.low), (-1.0, bound.high))
            if math.isfinite(end)
        ]

    def cases(self, points: Sequence[Array]) -> list[Candidate]:
        """Return the candidates at points, computing the new ones side by side. Raises SearchEnd where there
        may be no more of them.
        """
        points = [np.clip(x, 0.0, 1.0) for x in points]
        new = [x for x in points if x.tobytes() not in self.cache]
        remaining = self.search.refine - len(self.candidates)
        parameters = [self.parameters(x) for x in new[:remaining]]
        for x, case_parameters, values in zip(
            new, parameters, self.evaluate(parameters) if parameters else (), strict=False
        ):
            self.cache[x.tobytes()] = case = candidate(
                self.search, self.count + len(self.candidates), case_parameters, values
            )
            self.candidates.append(case)
        if len(new) > remaining:
            raise SearchEnd(
                f"refine = {self.search.refine} cases are used up; a larger number continues the search"
            )
        return [self.cache[x.tobytes()] for x in points]

    def parameters(self, x: Array) -> Parameters:
        """Return the parameters at a point."""
        return {
            **self.best.parameters,
            **{axis.name: axis.value(float(share)) for axis, share in zip(self.axes, x, strict=True)},
        }

    def complete(self, case: Candidate) -> bool:
        """Return whether a candidate has the minimised and all limited measures."""
        return all(
            math.isfinite(case.measure(name))
            for name in (self.aim, *(limit.measure for limit in self.limits))
        )

    def case(self, x: Array) -> Candidate:
        """Return the candidate at a point that SLSQP asks for. Raises SearchEnd where it failed, or points no
        longer move.
        """
        clipped = np.clip(x, 0.0, 1.0)
        if clipped.tobytes() not in self.cache:
            is_close = any(np.abs(clipped - np.frombuffer(key)).max() < CLOSE for key in self.cache)
            self.close = self.close + 1 if is_close else 0
            if self.close > MOST_CLOSE:
                raise SearchEnd(
                    "steps give no further improvement: the measure has a kink here, or limits cannot be kept"
                )
        (case,) = self.cases([x])
        if not self.complete(case):
            raise SearchEnd("a case failed on the way that derivatives led")
        return case

    def value(self, x: Array) -> float:
        """Return the measure, less of which is better."""
        return self.sign * self.case(x).measure(self.aim) / self.scale

    def margins(self, x: Array) -> Array:
        """Return the margin to each limit, which SLSQP keeps positive."""
        case = self.case(x)
        return np.array([limit.margin(case) - INSIDE for limit in self.limits])

    def slope(self, x: Array) -> Array:
        """Return the derivatives of :meth:`value`."""
        return np.asarray(self.sign * self.gradients(x)[self.aim] / self.scale)

    def margin_slopes(self, x: Array) -> Array:
        """Return the derivatives of :meth:`margins`, a row for each."""
        rows = self.gradients(x)
        return np.array([limit.sign * rows[limit.measure] / limit.size for limit in self.limits])

    def gradients(self, x: Array) -> dict[str, Array]:
        """Return the derivatives of the measures by the shares. Raises VfifeError where they cannot be
        trusted.
        """
        x = np.clip(x, 0.0, 1.0)
        if x.tobytes() not in self.slopes:
            by_parameter = self.derivatives(self.parameters(x))
            ways = np.array([axis.slope(float(share)) for axis, share in zip(self.axes, x, strict=True)])
            self.slopes[x.tobytes()] = {
                name: np.array([by_parameter[name][axis.name] for axis in self.axes]) * ways
                for name in (self.aim, *(limit.measure for limit in self.limits))
            }
        return self.slopes[x.tobytes()]

    def rank(self, points: Sequence[Array]) -> list[Rank]:
        """Rank points for pattern search. Raises SearchEnd where there may be no more of them."""
        return [
            (
                sum(max(-limit.margin(case), 0.0) for limit in self.limits),
                self.sign * case.measure(self.aim) / self.scale,
            )
            if self.complete(case)
            else (math.inf, math.inf)
            for case in self.cases(points)
        ]


def measure_derivatives(plan: Plan, search: Search, parameters: Parameters) -> dict[str, dict[str, float]]:
    """Return the derivatives of a search's measures by its continuous parameters at a case
    (:func:`~vfife.sensitivity`).

    Raises VfifeError where there are none, Contradiction where finite changes contradict them.
    """
    if plan.spec.of_case().last > 1:
        raise VfifeError("measures are means of several turns, and derivatives are of the last one")
    mechanism = loads(dump(plan.base), set=list(case_numbers(plan.parameters, parameters).items()))
    continuous = {axis.name for axis in search.axes if axis.continuous}
    varied = [parameter for parameter in plan.parameters if parameter.name in continuous]
    paths = [path for parameter in varied for path in parameter.paths]
    sensitivities = sensitivity(
        mechanism, list(search.measures), paths, step=plan.spec.step, **plan.spec.of_case().length
    )
    if meaningless := sorted(sensitivities.doubtful | sensitivities.rounding):
        raise VfifeError(
            f"derivatives of {', '.join(meaningless)} are meaningless: runs with other time steps disagree"
            " on it, or it is a rounding error"
        )
    for path, reason in sensitivities.refused.items():
        raise VfifeError(f"{path} has no derivatives: {reason}")
    return {
        name: {
            parameter.name: sum(trusted_derivative(sensitivities, name, path) for path in parameter.paths)
            for parameter in varied
        }
        for name in search.measures
    }


def trusted_derivative(sensitivities: Sensitivity, name: str, path: str) -> float:
    """Return the derivative of a measure by a number; 0 where the effect is too small to matter. Raises
    Contradiction.
    """
    if not any(derivative.path == path for derivative in sensitivities.derivatives):
        return 0.0
    if sensitivities.kind(name, path) == "derivative":
        return sensitivities.derivative(name, path)
    effect = sensitivities.effect(name, path)
    largest = max(
        (
            abs(path_effect.value)
            for path_effect in sensitivities.effects(name)
            if math.isfinite(path_effect.value)
        ),
        default=0.0,
    )
    if max(abs(effect.low), abs(effect.high)) <= INSIGNIFICANT * largest:
        return 0.0
    raise Contradiction(f"finite changes of {path} contradict the derivative of {name}")
