"""Check of a map's step: a sample of its cases is repeated with a coarser and a finer step, and their motions
are classified again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..measures.chaos import CHAOTIC, DIVERGED, QUASI, UNDECIDED, UNSETTLED, exponent, verdict
from ..simulation.turn_steps import with_steps
from ..solvers.record import recorded_rows
from ..solvers.tangents import Neighbours, steps_of_turn
from ..solvers.turn_runner import Orbit, Orbits, Start, TurnRunner, restepped
from .maps import Map, series_values

if TYPE_CHECKING:
    from .basins import BasinSpec
    from .bifurcation import SweepSpec

    TurnSpec: TypeAlias = BasinSpec | SweepSpec

Array = NDArray[np.float64]
# Steps in a turn of the companions, over those of the map.
RATIOS = (0.8, 2.0)
# Cases that are repeated unless given.
SAMPLE = 5
# Motions without a period; a map file holds their places in this list.
OTHER_KINDS = (CHAOTIC, QUASI, UNSETTLED, DIVERGED, UNDECIDED)


@dataclass(frozen=True)
class Companion:
    """A case repeated with ``ratio`` times the steps: its ``number``, the ``way`` in which its value was
    reached, and its motion, ``kind``.
    """

    number: int
    way: int
    ratio: float
    kind: str


@dataclass(frozen=True, repr=False)
class CheckedMap(Map):
    """A map of which some cases were repeated with other steps (``companions``)."""

    companions: tuple[Companion, ...]

    def kind_of(self, case: Companion) -> str:
        """Motion that the map has for the case of a companion, empty if it is not known."""
        raise NotImplementedError

    def name_of(self, case: Companion) -> str:
        """The case of a companion in words."""
        raise NotImplementedError

    @property
    def comparisons(self) -> list[tuple[Companion, str]]:
        """Companions, each with the motion of its case in the map."""
        return [(one, kind) for one in self.companions if (kind := self.kind_of(one))]

    @property
    def agreement(self) -> str:
        """How many companions agree with the map, in a few words."""
        return agreement(self.comparisons)

    @property
    def step_report(self) -> str:
        """What companions show, in a sentence; empty if there are none."""
        return step_report(self.comparisons, self.name_of)


def agreement(comparisons: Sequence[tuple[Companion, str]]) -> str:
    """How many companions agree with the map, in a few words."""
    same = sum(one.kind == kind for one, kind in comparisons)
    return f"{same} of {len(comparisons)} companions alike" if comparisons else "no companions"


def step_report(comparisons: Sequence[tuple[Companion, str]], name: Callable[[Companion], str]) -> str:
    """How many companions agree with the map, and what those are that do not; empty if there are none."""
    if not comparisons:
        return ""
    differing = [(one, kind) for one, kind in comparisons if one.kind != kind]
    steps = " and ".join(f"{1.0 / ratio:g}" for ratio in sorted(Counter(one.ratio for one, _ in comparisons)))
    members = len({(one.number, one.way) for one, _ in comparisons})
    same = f"{len(comparisons) - len(differing)} of {len(comparisons)} companions are told the same"
    text = f"{members} member{'s' * (members != 1)} again with {steps} times the step: {same}"
    where = [
        f"{name(one)} is {kind}, with {1.0 / one.ratio:g} times the step {one.kind}"
        for one, kind in differing
    ]
    return f"{text}; {'; '.join(where)}." if where else f"{text}."


def sampled(count: int, sample: int) -> tuple[int, ...]:
    """Numbers of a sample of cases, spread evenly over all."""
    sample = min(sample, count)
    return tuple(sorted({int((k + 0.5) * count / sample) for k in range(sample)}))


def packed(companions: Iterable[Companion]) -> Array:
    """Companions as rows of a map file. A motion is its period, or a number below zero."""

    def code(kind: str) -> float:
        return (
            float(kind.removeprefix("period "))
            if kind.startswith("period ")
            else -1.0 - OTHER_KINDS.index(kind)
        )

    return np.array([(one.number, one.way, one.ratio, code(one.kind)) for one in companions]).reshape(-1, 4)


def unpacked(rows: Array | None) -> list[Companion]:
    """Companions from the rows of a map file."""

    def kind(code: float) -> str:
        return f"period {code:.0f}" if code > 0.0 else OTHER_KINDS[int(-1.0 - code)]

    table = [] if rows is None else rows.reshape(-1, 4).tolist()
    return [Companion(int(number), int(way), ratio, kind(code)) for number, way, ratio, code in table]


def orbits(
    spec: TurnSpec,
    near: Neighbours | None,
    starts: Sequence[Start],
    steps: int | None = None,
    done: Collection[int] = (),
) -> Iterator[tuple[Orbit, Array]]:
    """Simulate motions from starts that are not ``known``, and yield each when it ends, with its series once
    a turn.

    The series have the shape (turns, series), without turns for what is no start.
    """
    steps = steps or spec.steps
    for one in Orbits(steps, spec.turns, spec.dropped, near).each(starts, done):
        model, none = one.assembly, np.zeros((0, len(spec.series)))
        yield (
            one,
            (
                none
                if model is None
                else series_values(model, recorded_rows(model), one.rows, spec.series, steps)
            ),
        )


def chain_companions(
    spec: TurnSpec, numbers: Sequence[int], models: Sequence[Assembly], near: Sequence[Neighbours],
    state: Array, done: int,
    look: Callable[[], None] | None,
) -> list[Companion]:  # fmt: skip
    """Repeat the values with these ``numbers`` of both chains, from the ``state`` before them, shape (rows,
    chains), after ``done`` steps.

    Ratios with which a model is unstable are left out.
    """
    companions, steps = list[Companion](), steps_of_turn(models[0])
    for ratio in RATIOS:
        try:
            again = [with_steps(one.mechanism, round(ratio * steps)) for one in models]
        except VfifeError:
            continue
        states = [restepped(state[:, k], done, one) for k, one in enumerate(again)]
        runner = TurnRunner(again, look=look)
        runner.restore(np.stack([one for one, _ in states], axis=1), states[0][1])
        rows, growth = runner.growing(spec.turns, spec.dropped, near)
        for k, one in enumerate(again):
            points = series_values(one, runner.row_numbers, rows[:, :, k], spec.series, runner.turn)
            companions.append(Companion(numbers[k], k, ratio, verdict(points, exponent(growth[:, k])).kind))
    return companions


def start_companions(
    spec: TurnSpec, sample: Sequence[int], make: Callable[[int, int], Start], near: Neighbours | None
) -> Iterator[Companion]:
    """Repeat cases from their starts, which ``make`` assembles by number and steps in a turn, except where
    they are unstable.
    """
    for ratio in RATIOS:
        steps = round(ratio * spec.steps)
        for one, points in orbits(spec, near, [make(number, steps) for number in sample], steps):
            if one.assembly is not None:
                yield Companion(
                    one.number,
                    0,
                    ratio,
                    verdict(points, exponent(one.growth) if len(one.growth) else None).kind,
                )
