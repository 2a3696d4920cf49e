"""Local search from the best case of a study: by derivatives of the measures, or by pattern search where
these cannot be trusted.

Pattern search finds the least of a function from its values alone.

All points at one distance along each axis are evaluated, both ways; the best of them is the next centre, and
where none is better the distance is halved (compass search: Kolda, Lewis and Torczon, SIAM Review 45, 2003,
pp. 385-482).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...errors import VfifeError
from ...measures.catalogue import COUNTED
from ...modelfile import dump, loads
from ..spec.plan import Plan
from .derivatives import sensitivity
from .optimise import Ask, Found, Numbers, Search, best, judged

Array = NDArray[np.float64]
Rank: TypeAlias = tuple[
    float, float
]  # by how much limits are exceeded, and the value: less is better, limits first

FIRST_DISTANCE = 0.05  # of the way between the bounds of an axis
LAST_DISTANCE = 1e-3  # noise of a measure with contact hides less than this


def pattern_search(start: Array, rank: Callable[[Sequence[Array]], Sequence[Rank]]) -> Array:
    """Return the best point that was found, from ``start`` on, in the unit cube.

    ``rank`` evaluates points side by side; what it raises ends the search.
    """
    centre = np.clip(start, 0.0, 1.0)
    (best,) = rank([centre])
    distance = FIRST_DISTANCE
    while distance >= LAST_DISTANCE:
        points = _around(centre, distance)
        ranks = rank(points)
        least = min(range(len(points)), key=lambda k: ranks[k], default=None)
        if least is not None and ranks[least] < best:
            centre, best = points[least], ranks[least]
        else:
            distance *= 0.5
    return centre


def _around(centre: Array, distance: float) -> list[Array]:
    """Points at a distance along each axis, both ways, that lie within the bounds and are not the centre."""
    found = []
    for axis in range(len(centre)):
        for sign in (1.0, -1.0):
            point = centre.copy()
            point[axis] = min(max(point[axis] + sign * distance, 0.0), 1.0)
            if point[axis] != centre[axis]:
                found.append(point)
    return found


Slopes = Callable[
    [Numbers], Mapping[str, Mapping[str, float]]
]  # derivatives of measures by parameters, SI; VfifeError where there are none

WITHIN = 1e-6  # of a limit, by which members are kept inside of it
CLOSE, STANDING = (
    1e-7,
    3,
)  # of the way between bounds: so close to another, so many members one after the other are of no use
ENOUGH = 1e-9  # of the measure: a step that makes no more of it is the last


# Of the largest effect on a measure: an effect that is not known leads nowhere, but one so small changes no
# direction.
INSIGNIFICANT = 0.05


class Contradiction(VfifeError):
    """Finite changes contradict the derivatives at a point."""


@dataclass(frozen=True)
class Refined:
    """Members that a search took by derivatives, or by values where these do not hold, and why there are
    none, or no more, in a sentence.

    The sentence is empty where the search came to an end.
    """

    members: tuple[Found, ...] = ()
    why: str = ""


class Ended(Exception):
    """No more members, and why."""


def refined(
    search: Search,
    found: Sequence[Found],
    ask: Ask,
    slopes: Slopes,
    told: Callable[[list[Found]], None] | None = None,
) -> Refined:
    """From the best of the members ``found`` on, by ``slopes``; at most ``search.refine`` members more.
    ``ask`` and ``told`` as of a search.
    """
    from scipy.optimize import minimize

    if why := refuses(search):
        return Refined(why=why)
    first = nearest(search, found)
    if first is None:
        return Refined(why="no member has all that is sought")
    walk = _Walk(search, first, len(found), ask, slopes, told)
    limits = [
        {
            "type": "ineq",
            "fun": lambda x, k=k: walk.values(x)[1][k],
            "jac": lambda x, k=k: walk.slopes_at(x)[1][k],
        }
        for k in range(len(walk.ends))
    ]
    try:
        last = minimize(
            lambda x: walk.values(x)[0], walk.start, jac=lambda x: walk.slopes_at(x)[0], method="SLSQP", bounds=[(0.0, 1.0)] * len(walk.axes),
            constraints=limits, options={"maxiter": 1000, "ftol": ENOUGH},
        )  # fmt: skip
    except Contradiction as why:
        return by_values(walk, " ".join(str(why).split()))
    except (Ended, VfifeError) as why:
        return Refined(tuple(walk.members), " ".join(str(why).split()))
    return Refined(tuple(walk.members), "" if last.success else f"the method ended early ({last.message})")


def by_values(walk: _Walk, why: str) -> Refined:
    """Go on from the best point so far without derivatives."""
    known = list(walk.known.items())
    ranks = walk.rank([np.frombuffer(key) for key, _ in known])
    start = np.frombuffer(known[min(range(len(known)), key=lambda k: ranks[k])][0])
    try:
        pattern_search(start, walk.rank)
    except Ended as end:
        return Refined(tuple(walk.members), f"{why}; by values, {end}")
    return Refined(tuple(walk.members), f"{why}; values alone led to the end")


def nearest(search: Search, found: Sequence[Found]) -> Found | None:
    """The best member; where none keeps the limits, the one that is least beyond them, as shares of these."""
    names = [*(name for name, _ in search.aims), *(bound.measure for bound in search.bounds)]
    whole = [
        one for one in found if all(math.isfinite((one.values or {}).get(name, math.nan)) for name in names)
    ]

    def beyond(one: Found) -> float:
        sizes = [
            max((abs(end) for end in (bound.low, bound.high) if math.isfinite(end)), default=0.0) or 1.0
            for bound in search.bounds
        ]
        return sum(
            max(bound.excess((one.values or {})[bound.measure]), 0.0) / size
            for bound, size in zip(search.bounds, sizes, strict=True)
        )

    return next(iter(best(search, found) or sorted(whole, key=beyond)), None)


def refuses(search: Search) -> str:
    """Why a search cannot go on by derivatives; empty where it can, or is not to."""
    if not search.refine:
        return ""
    if len(search.aims) > 1:
        return "several measures are sought, and derivatives lead to one point"
    names = [*(name for name, _ in search.aims), *(bound.measure for bound in search.bounds)]
    if odd := [name for name in names if name.endswith(COUNTED) or "(" in name]:
        return f"{', '.join(dict.fromkeys(odd))} has no derivatives"
    if not any(axis.continuous for axis in search.axes):
        return "nothing varies continuously"
    return ""


@dataclass
class _Walk:
    """What the method asks, in the scales that it likes: shares of ways, measures as shares of their size at
    the start.
    """

    search: Search
    first: Found
    count: int
    ask: Ask
    slopes: Slopes
    told: Callable[[list[Found]], None] | None
    members: list[Found] = field(default_factory=list)
    standing: int = 0

    def __post_init__(self) -> None:
        self.axes = [axis for axis in self.search.axes if axis.continuous]
        self.start = np.array([axis.share(float(self.first.parameters[axis.name])) for axis in self.axes])
        self.known: dict[bytes, Found] = {self.start.tobytes(): self.first}
        self.steep: dict[bytes, Any] = {}
        ((self.aim, self.sign),) = self.search.aims
        here = self.first.values or {}
        self.scale = abs(here[self.aim]) or 1.0
        self.ends = [
            (bound, sign, end)
            for bound in self.search.bounds
            for sign, end in ((1.0, bound.low), (-1.0, bound.high))
            if math.isfinite(end)
        ]
        self.sizes = [abs(end) or abs(here[bound.measure]) or 1.0 for bound, _, end in self.ends]

    def parameters(self, x: Array) -> Numbers:
        """Those of the best member, but for what varies continuously."""
        return {
            **self.first.parameters,
            **{axis.name: axis.value(float(share)) for axis, share in zip(self.axes, x, strict=True)},
        }

    def member(self, x: Array) -> Found:
        """The member at such shares. Raises Ended where there may be no more of them, or this one failed."""
        x = np.clip(x, 0.0, 1.0)
        if x.tobytes() not in self.known:
            if len(self.members) >= self.search.refine:
                raise Ended(f"refine = {self.search.refine} members are taken; with more it goes on")
            close = any(np.abs(x - np.frombuffer(key)).max() < CLOSE for key in self.known)
            self.standing = self.standing + 1 if close else 0
            if self.standing > STANDING:
                raise Ended(
                    "steps lead nowhere any more: the measure has a kink here, or limits cannot be kept"
                )
            numbers = self.parameters(x)
            (values,) = self.ask([numbers])
            one = judged(self.search, self.count + len(self.members), numbers, values)
            self.members.append(one)
            self.known[x.tobytes()] = one
            if self.told is not None:
                self.told([one])
        found = self.known[x.tobytes()]
        if not all(math.isfinite((found.values or {}).get(name, math.nan)) for name in self.measures):
            raise Ended("a member failed on the way that derivatives led")
        return found

    @property
    def measures(self) -> list[str]:
        """What has to be known of a member."""
        return [self.aim, *(bound.measure for bound, _, _ in self.ends)]

    def values(self, x: Array) -> tuple[float, list[float]]:
        """The measure that shall be small, and what is left up to each limit."""
        found = self.member(x).values or {}
        left = [
            sign * (found[bound.measure] - end) / size - WITHIN
            for (bound, sign, end), size in zip(self.ends, self.sizes, strict=True)
        ]
        return self.sign * found[self.aim] / self.scale, left

    def rank(self, points: Sequence[Array]) -> list[Rank]:
        """How good members are, evaluated side by side. Raises Ended where no more of them may be taken."""
        new = [x for x in points if np.clip(x, 0.0, 1.0).tobytes() not in self.known]
        room = self.search.refine - len(self.members)
        if new and room < 1:
            raise Ended(f"refine = {self.search.refine} members are taken; with more it goes on")
        numbers = [self.parameters(np.clip(x, 0.0, 1.0)) for x in new[:room]]
        batch = []
        for x, own, values in zip(new, numbers, self.ask(numbers) if numbers else (), strict=False):
            one = judged(self.search, self.count + len(self.members), own, values)
            self.members.append(one)
            self.known[np.clip(x, 0.0, 1.0).tobytes()] = one
            batch.append(one)
        if batch and self.told is not None:
            self.told(batch)
        if len(new) > room:
            raise Ended(f"refine = {self.search.refine} members are taken; with more it goes on")
        return [self._rank(self.known[np.clip(x, 0.0, 1.0).tobytes()]) for x in points]

    def _rank(self, one: Found) -> Rank:
        values = one.values or {}
        if not all(math.isfinite(values.get(name, math.nan)) for name in self.measures):
            return math.inf, math.inf
        beyond = [
            max(-sign * (values[bound.measure] - end) / size, 0.0)
            for (bound, sign, end), size in zip(self.ends, self.sizes, strict=True)
        ]
        return sum(beyond), self.sign * values[self.aim] / self.scale

    def slopes_at(self, x: Array) -> tuple[Array, list[Array]]:
        """Derivatives of both by the shares."""
        x = np.clip(x, 0.0, 1.0)
        if x.tobytes() not in self.steep:
            found = self.slopes(self.parameters(x))
            ways = np.array([axis.slope(float(share)) for axis, share in zip(self.axes, x, strict=True)])
            rows = {
                name: np.array([found[name][axis.name] for axis in self.axes]) * ways
                for name in self.measures
            }
            of_limits = [
                sign * rows[bound.measure] / size
                for (bound, sign, _), size in zip(self.ends, self.sizes, strict=True)
            ]
            self.steep[x.tobytes()] = self.sign * rows[self.aim] / self.scale, of_limits
        found_there: tuple[Array, list[Array]] = self.steep[x.tobytes()]
        return found_there


def slopes_of(plan: Plan, search: Search, numbers_at: Callable[[Numbers], Numbers]) -> Slopes:
    """Derivatives of what a search is for by what it varies, of its members: those of
    :func:`~vfife.studies.methods.derivatives.sensitivity`.

    ``numbers_at``: numbers of a member by path from its parameters by name.
    """
    text, known = dump(plan.base), {one.name: one for one in plan.parameters}
    varied = [known[axis.name] for axis in search.axes if axis.continuous]
    names = list(
        dict.fromkeys([*(name for name, _ in search.aims), *(bound.measure for bound in search.bounds)])
    )
    asked: dict[str, Any] = {"turns": float(plan.asked.turns), "step": plan.asked.step}

    def slopes(parameters: Numbers) -> Mapping[str, Mapping[str, float]]:
        if plan.asked.last > 1:
            raise VfifeError("measures are means of several turns, and derivatives are of the last one")
        mechanism = loads(text, set=list(numbers_at(parameters).items()))
        found = sensitivity(mechanism, names, [path for one in varied for path in one.paths], **asked)
        if parted := sorted(found.doubtful | found.rounding):
            raise VfifeError(
                f"derivatives of {', '.join(parted)} mean nothing: companions part, or it is rounding"
            )
        for path, why in found.refused.items():
            raise VfifeError(f"{path} has no derivatives: {why}")
        has = {one.path for one in found.derivatives}

        def by(name: str, path: str) -> float:
            """The derivative, or nothing where the effect is too small to matter."""
            if path not in has:
                return 0.0
            if found.kind(name, path) == "derivative":
                return found.derivative(name, path)
            one = found.effect(name, path)
            largest = max(
                (abs(other.value) for other in found.effects(name) if math.isfinite(other.value)), default=0.0
            )
            if max(abs(one.low), abs(one.high)) <= INSIGNIFICANT * largest:
                return 0.0
            raise Contradiction(f"finite changes of {path} contradict the derivative of {name}")

        return {
            name: {one.name: sum(by(name, path) for path in one.paths) for one in varied} for name in names
        }

    return slopes
