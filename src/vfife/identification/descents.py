"""Screening and local searches of a fit, side by side.

The sum of squares has many local minima: a wrong speed or phase makes all curves equally wrong. Points spread
over the bounds (Sobol' sequence) therefore come first, and Gauss-Newton searches (scipy's trust region
method) start from the best of them that are not close to each other. If the residuals of the best end are
correlated, they are not noise, and more points are screened. A global method alone would need many more runs
near the minimum, where least squares converges fast.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..studies.spec.distributions import sobol
from .batched_queries import BatchedQueries, Evaluations, Outcome, Query
from .curve_sensitivity import RANK_TOLERANCE
from .other_minima import Search, excess_of
from .residuals import Slopes, columns_agree
from .step_uncertainty import autocorrelation, curves_of, without_own

Array = NDArray[np.float64]
Ask = Callable[[list[Query]], list[Outcome]]
Derivatives = Literal["auto", "tangents", "differences"]
DISTANCE = 0.05  # least distance between two starts, as a share of the diagonal of the bounds
CLOSE = 1e-6  # relative change of cost and of the parameters at which a search ends
# A search is abandoned if, after PATIENCE points, its cost is more than HOPELESS_COST times the best one.
PATIENCE, HOPELESS_COST = 8, 30.0
MOST_EVALUATIONS = 40  # points of one local search; the runs of their derivatives are not counted
MOST_RESTARTS = 3  # usual limit; usual numbers of screened points and starts are in fit_task.py
# Residuals are more than noise if they exceed the first share of the data's deviation and successive ones
# have a correlation above the second.
NEGLIGIBLE, CORRELATED = 0.01, 0.2
# Parameters with an error this many times smaller than the largest keep their values in a new screening.
SHARPER = 5.0
BATCH = 16  # points of a screening that run at once: progress is visible, and lanes are full
# Points around the best one that are tried in the end, up to REACH standard deviations away, and how often
# the search goes on from a better one. A contact that begins at a value of a parameter makes a jump in the
# sum of squares: a descent stops there, and derivatives know one side of it only.
EXPLORED, REACH, MOST_ROUNDS = 48, 5.0, 2
ALIKE = 0.999  # share of a cost from which on another one is no better, and worth no other round
# Where contacts make the sum of squares rough: points further away, up to where a smooth sum would leave so
# many times the residual, and searches from the best of them. Three searches of a four-bar ended in one
# minimum that left 2.6 % of curves with 2 % noise. Points at a third of this distance did not lead out of it.
WIDER, WIDER_RESIDUAL, HOPS = 16, 3.5, 3
LONGEST_REACH = 0.1  # of the bounds: data that do not determine a parameter have larger standard deviations
MIDDLE = 0.5  # share of its interval at which a parameter of a single record starts


# For forecast and progress only: points of a long search and of a usual one, and runs that judge the result.
LONG_SEARCH, USUAL_SEARCH, CONCLUDING_RUNS = 20, 8, 4
# For progress only: searches are hard if the best screened point leaves more than this share of the data's
# deviation, and searches then begin again. Residuals may be noise after each restart: half of them count.
HARD, HALF = 0.25, 0.5


@dataclass(frozen=True)
class Budget:
    """Runs that a fit needs if it takes all restarts and its searches are long.

    ``records``: number of measured records; ``slopes``: runs of a point and its derivatives in all of them;
    ``screened`` points and ``starts`` of searches as in :meth:`Descents.run`; ``hops``: searches of each
    round of :meth:`Descents.explore` beside that from a better point.
    """

    records: int
    slopes: int
    screened: int
    starts: int
    hops: int = 0

    @classmethod
    def of(cls, parameters: Sequence[int], screened: int, starts: int, has_contacts: bool = False) -> Budget:
        """Return the budget of a fit to records with these numbers of ``parameters``, with derivatives by
        differences.
        """
        slopes = sum(2 * count + 1 for count in parameters)
        return cls(len(parameters), slopes, screened, starts, HOPS if has_contacts else 0)

    def searches(self, count: int) -> int:
        """Return the runs of some searches."""
        return count * LONG_SEARCH * self.slopes

    def search_points(self, restarts: int) -> int:
        """Return the points of all searches, each with derivatives: of the first, of restarts and rounds."""
        return LONG_SEARCH * (self.starts * (1 + restarts) + MOST_ROUNDS * (1 + self.hops))

    @property
    def first(self) -> int:
        """Runs of the first screening, of the choice of derivatives and of the first searches."""
        return self.screened * self.records + self.slopes + self.searches(self.starts)

    @property
    def repetition(self) -> int:
        """Runs of a restart."""
        return max(self.screened // 2, self.starts) * self.records + self.searches(self.starts)

    @property
    def exploration(self) -> int:
        """Runs of a round of :meth:`Descents.explore`."""
        return self.explored * self.records + self.searches(1 + self.hops)

    @property
    def explored(self) -> int:
        """Points of a round of :meth:`Descents.explore`."""
        return EXPLORED + (WIDER if self.hops else 0)

    def later(self, restarts: int) -> int:
        """Return the runs of some restarts, of all rounds, and of the end of a fit."""
        return restarts * self.repetition + MOST_ROUNDS * self.exploration + CONCLUDING_RUNS * self.records

    def usual(self, screened: int, searches: float) -> Array:
        """Return the numbers of runs, without and with derivatives, of a stage of usual length."""
        return np.array([screened * self.records, searches * USUAL_SEARCH * self.slopes])

    def usual_end(self, hard: bool, rounds: int = MOST_ROUNDS) -> Array:
        """Return the runs of :meth:`Descents.explore`: of one round, or, if searches are ``hard``, of all,
        each with one more search.
        """
        return (rounds if hard else 1) * self.usual(self.explored, self.hops + float(hard))


class Hopeless(Exception):
    """Raised to end a search whose cost remains far above the best one."""


@dataclass
class Descents:
    """Screening and local searches of a fit.

    Searches run side by side and see each other only through the best point so far, at the moments when they
    get answers. These moments do not depend on which search is quicker, so the result has the same bits.
    """

    evaluations: Evaluations
    search: Search
    derivatives: Derivatives

    @property
    def common(self) -> list[int]:
        """Places of the parameters that all records have in common."""
        return [k for k, parameter in enumerate(self.evaluations.parameters) if not parameter.record]

    def run(self, screened: int, starts: int, seed: int, restarts: int = MOST_RESTARTS) -> None:
        """Screen ``screened`` points and search from the best ``starts`` of them. While the residuals are
        more than noise, repeat this with half as many other points, up to ``restarts`` times; ``seed`` of the
        points. In the end :meth:`explore` the surroundings of the best point.

        Raises VfifeError if no point has a motion.
        """
        parameters, common = self.evaluations.parameters, self.common
        counts = [len(record.parameters) for record in self.evaluations.records]
        budget = Budget.of(counts, screened, starts, self.evaluations.records[0].curves.has_contacts)
        self.evaluations.begin(budget.usual(screened, starts), budget.usual_end(False))
        places = self.places(sobol(screened, len(common), seed) if common else np.zeros((1, 0)))
        if all(parameters[k].initial is not None for k in common):
            places = np.concatenate([[self.model_shares], places[: max(screened - 1, 0)]])
        chosen = self.distant(self.screen(places), starts, [])
        if not chosen:
            reason = self.evaluations.reasons[0]
            raise VfifeError(f"none of {len(places)} cases has a motion: {reason}; correct the bounds")
        self.choose_derivatives(*chosen[0])
        if self.search.tangents:
            budget = replace(budget, slopes=2 * len(counts))
        repetition = budget.usual(max(screened // 2, starts), starts)
        hard = self.evaluations.share > HARD
        later = budget.usual_end(hard) + (HALF * restarts * repetition if hard else 0.0)
        self.evaluations.begin(budget.usual(0, len(chosen)), later)
        self.descend(chosen)
        for attempt in range(1, restarts + 1):
            if not self.unexplained or self.evaluations.best is None:
                break
            later = HALF * (restarts - attempt) * repetition + budget.usual_end(True)
            self.evaluations.begin(repetition, later)
            best = self.evaluations.best[1]
            points = self.screen(self.new_points(max(screened // 2, starts), seed + attempt))
            self.descend(self.distant(points, starts, [best]))
        self.explore(seed, budget)

    def explore(self, seed: int, budget: Budget) -> None:
        """Try points around the best one, and search on from the best of them while that is a better one.

        Limits cover those that fit as well (:func:`~.step_uncertainty.widened`).
        """
        for attempt in range(MOST_ROUNDS):
            former = self.evaluations.best
            if not self.common or former is None or not former[2].fitted:
                return
            left = budget.usual_end(self.unexplained, MOST_ROUNDS - attempt)
            self.evaluations.begin(left, budget.usual(CONCLUDING_RUNS, 0.0))
            places = self.surroundings(seed + attempt, EXPLORED, REACH)
            for first in range(0, len(places), BATCH):
                batch = places[first : first + BATCH]
                self.evaluations([Query(tuple(shares), former[2].offsets) for shares in batch])
            chosen = list[tuple[Array, Outcome]]()
            if budget.hops:
                reach = math.sqrt((WIDER_RESIDUAL**2 - 1.0) * self.evaluations.residuals)
                chosen = self.screen(self.surroundings(seed + attempt, WIDER, reach))[: budget.hops]
            best = self.evaluations.best or former
            if best[0] < former[0]:
                chosen.insert(0, (np.array(best[1]), best[2]))
            if not chosen:
                return
            later = budget.usual_end(False) if attempt + 1 < MOST_ROUNDS else np.zeros(2)
            self.evaluations.begin(budget.usual(0, len(chosen)), later)
            self.descend(chosen)
            if (self.evaluations.best or former)[0] >= ALIKE * former[0]:
                return

    def surroundings(self, seed: int, count: int, reach: float) -> Array:
        """Return points around the best one, shape (points, parameters): in random directions of the
        principal axes of the covariance, at distances that are spread evenly up to ``reach`` standard
        deviations.
        """
        cost, shares, best = self.evaluations.best or (0.0, np.zeros(0), Outcome(()))
        slopes = self.evaluations.slopes(Query(tuple(shares), best.offsets, self.search.tangents), best)
        jacobian = without_own(slopes.jacobian, self.evaluations.parameters)
        _, sizes, rows = np.linalg.svd(jacobian, full_matrices=False)
        deviation = math.sqrt(2.0 * cost / max(len(jacobian) - len(sizes), 1))
        axes = np.minimum(reach * deviation / np.maximum(sizes, 1e-100), LONGEST_REACH)[:, None] * rows
        numbers = sobol(count, len(sizes) + 1, seed)
        directions = 2.0 * numbers[:, :-1] - 1.0
        directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-100)
        places = np.tile(shares, (count, 1))
        places[:, self.common] += numbers[:, -1:] * directions @ axes
        return np.clip(places, 0.0, 1.0)

    @property
    def model_shares(self) -> list[float]:
        """Shares of the parameters where the model has them, else in the middle of their bounds."""
        return [
            MIDDLE if parameter.initial is None else parameter.share(parameter.initial)
            for parameter in self.evaluations.parameters
        ]

    def places(self, common: Array) -> Array:
        """Points with such shares of the common parameters, shape (points, parameters); those of one record
        are :attr:`model_shares`.
        """
        places = np.tile(self.model_shares, (len(common), 1))
        places[:, self.common] = common
        return places

    @property
    def unexplained(self) -> bool:
        """Whether the residuals of the best point are more than noise, as is typical for a wrong local
        minimum: successive ones are correlated, or :func:`~.other_minima.excess_of` says so.
        """
        records, best = self.evaluations.records, self.evaluations.best
        if (
            best is None
            or not best[2].fitted
            or records[0].misfit.comparison != "curve"
            or self.evaluations.share < NEGLIGIBLE
        ):
            return False
        parts = curves_of(records, best[2])
        correlated = autocorrelation(parts) > CORRELATED + 2.0 / math.sqrt(min(map(len, parts)))
        return correlated or bool(excess_of(records, best[2]))

    def new_points(self, count: int, seed: int) -> Array:
        """More points. Parameters known much better than the rest, as the speed of a drive, stay as they are
        at the best point, and so do those of one record.

        With another speed all curves are out of step, and equally wrong.
        """
        _, shares, best = self.evaluations.best or (0.0, np.zeros(0), Outcome(()))
        slopes = self.evaluations.slopes(Query(tuple(shares), None, self.search.tangents), best)
        jacobian = without_own(slopes.jacobian, self.evaluations.parameters)
        _, sizes, rows = np.linalg.svd(jacobian, full_matrices=False)
        spread = np.ones(len(self.common))
        if sizes[0] > 0.0:
            spread = np.sqrt(((rows.T / np.maximum(sizes, RANK_TOLERANCE * sizes[0])) ** 2).sum(axis=1))
        uncertain = np.array(self.common)[spread >= spread.max() / SHARPER]
        places = np.tile(shares, (count, 1))
        places[:, uncertain] = sobol(count, len(uncertain), seed)
        return places

    def screen(self, places: Array) -> list[tuple[Array, Outcome]]:
        """Run points, shape (points, parameters); return those with a motion, the best first."""
        screened: list[tuple[Array, Outcome]] = []
        for first in range(0, len(places), BATCH):
            batch = places[first : first + BATCH]
            points = self.evaluations([Query(tuple(shares)) for shares in batch])
            screened += [(at, outcome) for at, outcome in zip(batch, points, strict=True) if outcome.fitted]
        return sorted(screened, key=lambda pair: pair[1].cost)

    def distant(
        self, points: list[tuple[Array, Outcome]], count: int, former: list[Array]
    ) -> list[tuple[Array, Outcome]]:
        """Return up to ``count`` of the best points that are far enough from each other and from the
        ``former`` ones.
        """
        chosen: list[tuple[Array, Outcome]] = []
        common = self.common
        for at, outcome in points:
            places = [*former, *(place for place, _ in chosen)]
            if len(chosen) < count and all(
                np.linalg.norm((at - place)[common]) > DISTANCE * math.sqrt(len(common)) for place in places
            ):
                chosen.append((at, outcome))
        return chosen

    def choose_derivatives(self, shares: Array, outcome: Outcome) -> None:
        """Decide for tangents if they agree with differences of runs at one point.

        A tangent is the derivative of one run, at the cost of about one run. If impacts begin or end between
        neighbouring values, or the motion is chaotic, it differs from the trend over a small interval, which
        a search needs; differences follow that trend.
        """
        if self.derivatives == "differences":
            return
        at, offsets, slopes = tuple(shares), outcome.offsets, self.evaluations.slopes
        try:
            tangents = slopes(Query(at, offsets, True), outcome)
        except VfifeError as error:
            if self.derivatives == "tangents":
                raise
            self.search.notes.append(f"tangents cannot be computed: {' '.join(str(error).split())}")
            return
        self.search.tangents = self.derivatives == "tangents" or columns_agree(
            tangents, slopes(Query(at, offsets, False), outcome)
        )

    def descend(self, chosen: list[tuple[Array, Outcome]]) -> None:
        """Search from several points side by side; ``chosen`` are shares of the bounds with their curves."""
        BatchedQueries(self.evaluations).run([lambda ask, at=at: self.descent(ask, *at) for at in chosen])  # type: ignore[misc]

    def descent(self, ask: Ask, start: Array, first: Outcome) -> None:
        """Search from one start by nonlinear least squares; ``ask`` computes points.

        scipy asks for residuals first and for derivatives later. Both are computed at once, because lanes
        have room for both.
        """
        from scipy.optimize import least_squares

        offsets, count, evaluations = first.offsets, 0, self.evaluations
        cache: dict[bytes, tuple[Array, Slopes | None]] = {}

        def at(shares: Array) -> tuple[Array, Slopes | None]:
            nonlocal offsets, count
            if (key := shares.tobytes()) not in cache:
                (point,) = ask([Query(tuple(shares), offsets, self.search.tangents)])
                if not point.fitted:
                    cache[key] = evaluations.penalty, None
                else:
                    offsets, count = point.offsets, count + 1
                    cache[key] = point.residuals, point.slopes
                    best = evaluations.best
                    if count > PATIENCE and best is not None and point.cost > HOPELESS_COST * best[0]:
                        raise Hopeless
            return cache[key]

        def jacobian(shares: Array) -> Array:
            slopes = at(shares)[1]
            return slopes.jacobian if slopes is not None else np.zeros((evaluations.residuals, len(shares)))

        # The trust region method needs a start strictly inside of the bounds.
        inside = np.clip(start, 1e-6, 1.0 - 1e-6)
        limits = {"ftol": CLOSE, "xtol": CLOSE, "gtol": 1e-12, "max_nfev": MOST_EVALUATIONS}
        try:
            minimum: Any = least_squares(
                lambda shares: at(shares)[0], inside, jacobian, (0.0, 1.0), "trf", **limits
            )
        except Hopeless:
            return
        values = (
            float(parameter.value(x))
            for parameter, x in zip(self.evaluations.parameters, minimum.x, strict=True)
        )
        self.search.ends.append((float(minimum.cost), tuple(values)))
