"""Check of a map's step: repeat a sample of its cases with a coarser and a finer step, and classify their
motions again.

The step shifts bifurcations a little. One step on each side of the map's shows whether the kind of a motion
depends on it. Both together cost 2.8 times a case, so a sample is checked and not every case.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..measures.attractors import same_motion
from ..measures.chaos import CHAOTIC, DIVERGED, QUASI, UNDECIDED, UNSETTLED, exponent, kind_words
from ..simulation.turn_steps import with_steps
from ..solvers.record import recorded_rows
from ..solvers.tangents import Neighbours, steps_of_turn
from ..solvers.turn_runner import PATH_OUTPUTS, Orbit, Orbits, Start, TurnRunner, restepped
from .maps import Map
from .series import classified, series_values

if TYPE_CHECKING:
    from .basins import BasinSpec
    from .bifurcation import SweepSpec

    TurnSpec: TypeAlias = BasinSpec | SweepSpec

Array = NDArray[np.float64]
# Ratios of the companions' steps in a turn to the map's: 1.25 times and half the step.
RATIOS = (0.8, 2.0)
# Default number of cases that are repeated.
SAMPLE = 5
# Motions without a period. A map file stores them as indices of this tuple: append only.
OTHER_KINDS = (CHAOTIC, QUASI, UNSETTLED, DIVERGED, UNDECIDED)


@dataclass(frozen=True)
class Companion:
    """A case that was repeated with ``ratio`` times the steps: its ``number``, its ``way`` (the index of the
    chain or start by which its value was reached), the ``kind`` of its motion, and its ``points``, shape
    (turns, series); files of former versions have none.
    """

    number: int
    way: int
    ratio: float
    kind: str
    points: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False, compare=False)


@dataclass(frozen=True, repr=False)
class CheckedMap(Map):
    """A map with ``companions``: cases that were repeated with other steps; ``most_differences`` that do not
    agree are named in a sentence.
    """

    most_differences: ClassVar[int] = 12
    companions: tuple[Companion, ...]

    def kind_of(self, case: Companion) -> str:
        """Return the kind of motion that the map has for a companion's case; empty if it is not computed."""
        raise NotImplementedError

    def motion_of(self, case: Companion) -> tuple[Array, Array] | None:
        """Return the points of the motion that the map has for a companion's case, shape (turns, series), and
        the difference below which they are equal, shape (series,); None if only kinds can be compared.
        """
        return None

    def agrees(self, case: Companion) -> bool:
        """Return whether a companion reaches the motion that the map has for its case."""
        kind, motion = self.kind_of(case), self.motion_of(case) if len(case.points) else None
        if motion is None:
            return case.kind == kind
        points, tolerance = motion
        return same_motion((kind, points), (case.kind, case.points), tolerance)

    def words_of(self, kind: str) -> str:
        """Return a kind of motion in words."""
        return kind_words(kind, self.spec.turns)

    def name_of(self, case: Companion) -> str:
        """Return a companion's case as text, for example a parameter and its value."""
        raise NotImplementedError

    @property
    def comparisons(self) -> list[tuple[Companion, str]]:
        """Companions, each with the kind of motion of its case in the map."""
        return [(companion, kind) for companion in self.companions if (kind := self.kind_of(companion))]

    @property
    def agreement(self) -> str:
        """Number of companions that agree with the map, as text."""
        comparisons = self.comparisons
        count = sum(self.agrees(companion) for companion, _ in comparisons)
        return f"{count} of {len(comparisons)} companions alike" if comparisons else "no companions"

    @property
    def step_report(self) -> str:
        """How many companions agree with the map, and the kinds of those that do not, as a sentence; of many
        the first. Empty if there are no companions.
        """
        comparisons = self.comparisons
        if not comparisons:
            return ""
        differing = [(companion, kind) for companion, kind in comparisons if not self.agrees(companion)]
        steps = " and ".join(
            f"{1.0 / ratio:g}" for ratio in sorted(Counter(companion.ratio for companion, _ in comparisons))
        )
        cases = len({(companion.number, companion.way) for companion, _ in comparisons})
        agreeing = f"{len(comparisons) - len(differing)} of {len(comparisons)} companions agree"
        text = f"{cases} case{'s' * (cases != 1)} repeated with {steps} times the step: {agreeing}"
        differences = [
            f"{self.name_of(case)} is {self.words_of(kind)}, with {1.0 / case.ratio:g} times the step"
            f" {f'another motion of {kind}' if case.kind == kind else self.words_of(case.kind)}"
            for case, kind in differing[: self.most_differences]
        ]
        if left_out := len(differing) - len(differences):
            differences.append(f"{left_out} more differ (.companions)")
        return f"{text}; {'; '.join(differences)}." if differences else f"{text}."


def sampled(count: int, sample: int) -> tuple[int, ...]:
    """Return the numbers of a ``sample`` of ``count`` cases, spread evenly over all."""
    sample = min(sample, count)
    return tuple(sorted({int((k + 0.5) * count / sample) for k in range(sample)}))


def packed(companions: Iterable[Companion]) -> Array:
    """Return companions as rows of a map file, shape (companions, 4): number, way, ratio, and the motion as
    its period or, without a period, as -1 minus its index in OTHER_KINDS.
    """

    def code(kind: str) -> float:
        return (
            float(kind.removeprefix("period "))
            if kind.startswith("period ")
            else -1.0 - OTHER_KINDS.index(kind)
        )

    return np.array(
        [(companion.number, companion.way, companion.ratio, code(companion.kind)) for companion in companions]
    ).reshape(-1, 4)


def packed_points(companions: Sequence[Companion]) -> Array:
    """Return the points of companions as an array of a map file, shape (companions, turns x series)."""
    return (
        np.stack([companion.points.ravel() for companion in companions]) if companions else np.zeros((0, 0))
    )


def unpacked(rows: Array | None, points: Array | None = None, series: int = 1) -> list[Companion]:
    """Return the companions in the rows of a map file, with their ``points`` of some ``series``; the inverse
    of :func:`packed` and :func:`packed_points`.
    """

    def kind(code: float) -> str:
        return f"period {code:.0f}" if code > 0.0 else OTHER_KINDS[int(-1.0 - code)]

    table = [] if rows is None else rows.reshape(-1, 4).tolist()
    orbits = np.zeros((len(table), 0, series))
    if points is not None and table:
        orbits = points.reshape(len(table), -1, series)
    return [
        Companion(int(number), int(way), ratio, kind(code), orbit)
        for (number, way, ratio, code), orbit in zip(table, orbits, strict=True)
    ]


def orbits(
    spec: TurnSpec,
    neighbours: Neighbours | None,
    starts: Sequence[Start],
    steps: int | None = None,
    done: Collection[int] = (),
) -> Iterator[tuple[Orbit, Array]]:
    """Simulate motions from ``starts``, except for the numbers ``done``, and yield each when it ends, with
    its series once a turn.

    ``neighbours`` follow a small difference, None for none; ``steps`` in a turn: those of the specification
    unless given. The series have the shape (turns, series), with no turns where there is no start.
    """
    steps = steps or spec.steps
    for orbit in Orbits(steps, spec.turns, spec.dropped, neighbours).run_cases(starts, done):
        model, no_points = orbit.assembly, np.zeros((0, len(spec.series)))
        yield (
            orbit,
            (
                no_points
                if model is None
                else series_values(model, recorded_rows(model), orbit.rows, spec.series, steps)
            ),
        )


def path_ranges(spec: TurnSpec, orbit: Orbit) -> Array:
    """Return the range of each series within a turn of a motion, shape (series,)."""
    model = orbit.assembly
    if model is None:
        return np.zeros(len(spec.series))
    interval = max(1, steps_of_turn(model) // PATH_OUTPUTS)
    path = series_values(model, recorded_rows(model), orbit.path, spec.series, interval)
    return np.asarray(np.ptp(path, axis=0))


def chain_companions(
    spec: TurnSpec, numbers: Sequence[int], models: Sequence[Assembly], neighbours: Sequence[Neighbours],
    state: Array, done: int,
    look: Callable[[], None] | None,
) -> list[Companion]:  # fmt: skip
    """Repeat one value of each chain with other steps, from the state in which the chain reached it.

    ``numbers`` and ``models`` are those of the values, ``neighbours`` follow a small difference, ``state`` is
    that before the values, shape (rows, chains), after ``done`` steps. ``look`` is called a few times a
    second. Ratios with which a model is unstable are left out.
    """
    companions, steps = list[Companion](), steps_of_turn(models[0])
    for ratio in RATIOS:
        try:
            variants = [with_steps(model.mechanism, round(ratio * steps)) for model in models]
        except VfifeError:
            continue
        states, count = companion_states(models, variants, state, done)
        runner = TurnRunner(variants, look=look)
        runner.restore(states, count)
        rows, growth = runner.growing(spec.turns, spec.dropped, neighbours)
        for k, variant in enumerate(variants):
            points = series_values(variant, runner.row_numbers, rows[:, :, k], spec.series, runner.turn)
            kind = classified(spec, points, exponent(growth[:, k])).kind
            companions.append(Companion(numbers[k], k, ratio, kind, points))
    return companions


def companion_states(
    models: Sequence[Assembly], variants: Sequence[Assembly], state: Array, done: int
) -> tuple[Array, int]:
    """Return the states, shape (rows, chains), and the number of steps with which ``variants`` of the models
    of some chains, with other steps, continue from ``state`` after ``done`` steps.

    Each model first takes up the motion as it does in its chain, at the same share of a turn: with another
    speed it has another time there, and the crank would be at another angle at the same time.
    """
    layout = models[0].layout
    parameters, shift = np.array(layout.of("parameter"), dtype=np.intp), layout.row("shift")
    states, counts = [], []
    for k, (model, variant) in enumerate(zip(models, variants, strict=True)):
        changed = state[:, k].copy()
        changed[parameters] = model.state[parameters]
        values, count = restepped(changed, done, variant)
        # All lanes count the same steps. Of times in the middle of two steps, rounding may choose either.
        counts.append(count)
        values[shift] += count - counts[0]
        states.append(values)
    return np.stack(states, axis=1), counts[0]


def start_companions(
    spec: TurnSpec, sample: Sequence[int], make: Callable[[int, int], Start], neighbours: Neighbours | None
) -> Iterator[Companion]:
    """Repeat the cases ``sample`` from their starts with other steps, and yield each when it ends.

    ``make`` assembles a start by its number and the steps in a turn. Cases that are unstable with a step are
    left out.
    """
    for ratio in RATIOS:
        steps = round(ratio * spec.steps)
        for orbit, points in orbits(spec, neighbours, [make(number, steps) for number in sample], steps):
            if orbit.assembly is not None:
                growth = exponent(orbit.growth) if len(orbit.growth) else None
                kind = classified(spec, points, growth).kind
                yield Companion(orbit.number, 0, ratio, kind, points)
