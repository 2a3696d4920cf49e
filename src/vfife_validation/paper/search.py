"""The lost Table 2: a search for the parameters that give Table 3 back, by differential evolution over lanes
of simulations.

Storn and Price, Journal of Global Optimization 11 (1997) 341-359; current-to-best, with crossover. A point is
judged by its worst deviation from the six numbers of Table 3 in percentage points. Every point that was tried
is kept, so that the answer is the set that fits.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vfife.assembly.assembled import Assembly
from vfife.assembly.reassemble import reassembled
from vfife.laws import ContactLaw, Pereira
from vfife.measures.catalogue import lip
from vfife.solvers.ensemble import advance, placed

from .influence import STEP, TOLERANCE, ideal_maxima, maxima
from .mechanisms import CLEARANCES, FASTEST, Parameters, four_bar, loosened

Array = NDArray[np.float64]

TABLE_3 = ((6.72, 17.21, 89.95), (13.45, 28.60, 110.32))  # LIP(F), LIP(a) in per cent at 0.1, 0.2 and 0.5 mm
TARGET = np.array(TABLE_3).reshape(-1)
GOAL = 3.0  # percentage points
FAILED = 1000.0  # what a point that loses contact, does not settle or diverges is worse by
TURNS = 8
ANGLE_STEPS = 72  # crank angles at the start are multiples of 5 degrees

# Unknown, unit, limits, on a logarithmic scale.
UNKNOWNS: tuple[tuple[str, str, float, float, bool], ...] = (
    ("axial_length", "m", 1e-3, 5e-2, True),
    ("restitution", "1", 0.02, 0.99, False),
    ("v0", "m/s", 1e-4, 1.0, True),
    ("ratio", "v1/v0", 1.02, 300.0, True),
    ("start", "crank turns", 0.0, 1.0, False),
    ("bearing_radius", "m", 3e-3, 5e-2, True),
)


@dataclass(frozen=True)
class Structure:
    """What is not a number: the links, whether friction turns the bodies, the branch, and whether the crank
    may start at any angle.
    """

    link: str
    moment: bool = False
    below: bool = True
    any_start: bool = False

    @property
    def unknowns(self) -> list[str]:
        """Names of the numbers that are searched."""
        left_out = {"start": not self.any_start, "bearing_radius": not self.moment}
        return [name for name, *_ in UNKNOWNS if not left_out.get(name, False)]

    @property
    def words(self) -> str:
        """The structure in words."""
        parts = [self.link, "friction turns the bodies" if self.moment else "friction at the centres"]
        parts += ["joint 2 below" if self.below else "joint 2 above"]
        return ", ".join(parts + ["any start angle"] * self.any_start)


STRUCTURES = (
    Structure("stiff bars"),
    Structure("stiff bars", any_start=True),
    Structure("bars"),
    Structure("bars", any_start=True),
    Structure("stiff bars", moment=True),
    Structure("uniform rods"),
    Structure("uniform rods", moment=True),
    Structure("frames of 2"),
    Structure("stiff bars", below=False),
    Structure("uniform rods", below=False),
)


def parameters(structure: Structure, unit: Array) -> Parameters:
    """Return the parameters at a point of the unit cube, one coordinate for each unknown of the structure."""
    values: dict[str, float] = {}
    for (name, _, low, high, logarithmic), u in zip(
        [x for x in UNKNOWNS if x[0] in structure.unknowns], unit, strict=True
    ):
        values[name] = float(low * (high / low) ** u) if logarithmic else float(low + (high - low) * u)
    angle = 2.0 * math.pi * math.floor(values.get("start", 0.0) * ANGLE_STEPS) / ANGLE_STEPS
    options: dict[str, Any] = {"bearing_radius": values["bearing_radius"]} if structure.moment else {}
    return Parameters(
        contact=Pereira(restitution=values["restitution"]), axial_length=values["axial_length"],
        v0=values["v0"], v1=values["v0"] * values["ratio"],
        link=structure.link, friction_moment="mid-overlap" if structure.moment else "off",
        below=structure.below, crank_angle=angle, **options,
    )  # fmt: skip


@lru_cache(maxsize=256)
def _base(link: str, is_below: bool, moment: str, angle: float, step: float) -> Assembly:
    return placed(
        four_bar(
            Parameters(link=link, below=is_below, friction_moment=moment, crank_angle=angle),  # type: ignore[arg-type]
            CLEARANCES[0],
        ),
        step,
        TURNS,
        1,
    )


def table_3(
    points: Sequence[Parameters], step: float = STEP, workers: int | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """LIP(F) and LIP(a) at the clearances of Table 3, shape (points, 6), and whether every run settled
    without losing contact.
    """
    assemblies = []
    for p in points:
        base = _base(p.link, p.below, p.friction_moment, p.crank_angle, step)
        assemblies += [reassembled(base, loosened(p, base.mechanism, c)) for c in CLEARANCES]
    cases = advance(assemblies, tolerance=TOLERANCE, workers=workers)
    numbers, sound = [], []
    for case, p in zip(cases, [p for p in points for _ in CLEARANCES], strict=True):
        pair = zip(maxima(case), ideal_maxima(p.link, p.below, FASTEST), strict=True)
        numbers.append([lip(value, ideal) for value, ideal in pair])
        onsets = case.turns.block("contact_onsets")
        sound.append(case.settled is not None and bool((onsets[-1] == onsets[-2]).all()))
    shaped = np.array(numbers).reshape(-1, 3, 2).transpose(0, 2, 1).reshape(-1, 6)
    return np.asarray(shaped, dtype=float), np.all(np.array(sound, dtype=bool).reshape(-1, 3), axis=1)


def misfit(numbers: Array, sound: NDArray[np.bool_]) -> Array:
    """Worst deviation from Table 3 (percentage points), shape (points,)."""
    worst = np.abs(numbers - TARGET).max(axis=1)
    return np.asarray(np.where(np.isfinite(worst), worst, FAILED) + np.where(sound, 0.0, FAILED), dtype=float)


@dataclass
class Search:
    """The search within one structure: a population, and all that was tried."""

    structure: Structure
    generator: np.random.Generator
    size: int = 32
    tried: list[Array] = field(default_factory=list)
    numbers: list[Array] = field(default_factory=list)
    misfits: list[Array] = field(default_factory=list)
    generations: int = 0

    def begin(self) -> None:
        """Points spread over the cube: a stratum of each unknown to each of them, three times as many as the
        population; the best stay.
        """
        n, d = 3 * self.size, len(self.structure.unknowns)
        strata = np.array([self.generator.permutation(n) for _ in range(d)]).T
        points = (strata + self.generator.random((n, d))) / n
        misfits = self._try(points)
        best = np.argsort(misfits)[: self.size]
        self.population, self.misfits_of_population = points[best], misfits[best]

    def generation(self) -> None:
        """Every member meets a rival made from the best ones and the differences between others."""
        n, d = self.population.shape
        g = self.generator
        leaders = self.population[np.argsort(self.misfits_of_population)[g.integers(0, max(2, n // 5), n)]]
        a, b = self.population[g.integers(0, n, n)], self.population[g.integers(0, n, n)]
        scale = g.uniform(0.3, 0.9, (n, 1))
        rivals = (
            self.population
            + scale * (leaders - self.population)
            + scale * (a - b)
            + g.normal(0.0, 2e-3, (n, d))
        )
        cross = g.random((n, d)) < 0.9
        rivals = np.where(cross, rivals, self.population)
        rivals = np.where((rivals < 0.0) | (rivals > 1.0), g.random((n, d)), rivals)
        misfits = self._try(rivals)
        better = misfits <= self.misfits_of_population
        self.population[better], self.misfits_of_population[better] = rivals[better], misfits[better]
        self.generations += 1

    def _try(self, points: Array) -> Array:
        numbers, sound = table_3([parameters(self.structure, point) for point in points])
        misfits = misfit(numbers, sound)
        self.tried.append(points)
        self.numbers.append(numbers)
        self.misfits.append(misfits)
        return misfits

    @property
    def best(self) -> float:
        """Least misfit so far (percentage points)."""
        return float(self.misfits_of_population.min())

    @property
    def count(self) -> int:
        """Points that were tried."""
        return sum(map(len, self.misfits))

    def all_points(self) -> tuple[list[Parameters], Array, Array]:
        """All points that were tried with their six numbers and misfits, best first."""
        points, numbers, misfits = (
            np.concatenate(self.tried),
            np.concatenate(self.numbers),
            np.concatenate(self.misfits),
        )
        order = np.argsort(misfits, kind="stable")
        return [parameters(self.structure, points[k]) for k in order], numbers[order], misfits[order]


def run(
    budget: float,
    seed: int,
    tell: Callable[[str], None],
    structures: Sequence[Structure] = STRUCTURES,
    patience: int = 12,
) -> list[Search]:
    """Search all structures in turns within ``budget`` seconds; structures close to the goal receive more of
    it.

    A structure over three goals away without improvement for ``patience`` generations is abandoned, and its
    share goes to the others. Ctrl-C ends the search early and keeps its results.
    """
    began, searches = time.monotonic(), list[Search]()
    try:
        for k, structure in enumerate(structures):
            search = Search(structure, np.random.default_rng([seed, k]))
            search.begin()
            searches.append(search)
            tell(f"{search.structure.words}: {search.count} points, best misfit {search.best:.2f} points")
            if time.monotonic() - began > budget:
                return searches
        _evolve(searches, began + budget, tell, patience)
    except KeyboardInterrupt:
        if not searches:
            raise
        tell("stopped by Ctrl-C; what was found so far is kept")
    return searches


def _evolve(searches: Sequence[Search], end: float, tell: Callable[[str], None], patience: int) -> None:
    since = dict.fromkeys(range(len(searches)), 0)
    while time.monotonic() < end:
        active = [k for k in since if since[k] < patience or searches[k].best < 3.0 * GOAL]
        if not active:
            return
        for k in active:
            search, former_best = searches[k], searches[k].best
            for _ in range(3 if former_best < 3.0 * GOAL else 1):
                search.generation()
            since[k] = 0 if search.best < former_best else since[k] + 1
            tell(
                f"{search.structure.words}: generation {search.generations}, {search.count} points, best"
                f" misfit {search.best:.2f} points"
            )
            if time.monotonic() > end:
                return


def robust(points: Sequence[Parameters], steps: Sequence[float]) -> Array:
    """Misfit of each point at the worst of several steps (s)."""
    return np.asarray(np.max([misfit(*table_3(points, step)) for step in steps], axis=0))


def as_numbers(p: Parameters) -> dict[str, Any]:
    """Parameters as plain numbers and words."""
    entries = {f.name: getattr(p, f.name) for f in dataclasses.fields(p) if f.name != "contact"}
    return entries | {"contact": p.contact.name, "restitution": p.contact.restitution}  # type: ignore[attr-defined]


def from_numbers(entries: dict[str, Any]) -> Parameters:
    """Convert plain numbers to parameters, the reverse of :func:`as_numbers`."""
    left = {name: value for name, value in entries.items() if name not in ("contact", "restitution")}
    law: Any = ContactLaw.registry[entries["contact"]]
    return Parameters(contact=law(restitution=entries["restitution"]), **left)
