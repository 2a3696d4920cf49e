"""Companions of maps: a sample of members gone through again with a coarser and a finer step, whether they
are told to be the same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..measures.chaos import CHAOTIC, DIVERGED, QUASI, UNDECIDED, UNSETTLED, exponent, verdict
from ..solvers.lyapunov import steps_of_turn
from ..solvers.record import recorded_rows
from ..solvers.tangents import Neighbours
from ..solvers.turn_runner import Orbit, Orbits, Start, TurnRunner, restepped
from .section_series import looked, stepped

if TYPE_CHECKING:
    from .basins import BasinSpec
    from .bifurcation import SweepSpec

    MapSpec: TypeAlias = BasinSpec | SweepSpec

Array = NDArray[np.float64]
RATIOS = (0.8, 2.0)  # steps in a turn for each of the map
SAMPLE = 5  # members that are gone through again, unless said
WORDS = (CHAOTIC, QUASI, UNSETTLED, DIVERGED, UNDECIDED)  # map files hold their places


@dataclass(frozen=True)
class Companion:
    """A member told again with so many times the steps, ``ratio``: its ``number``, the ``way`` in which it
    was reached, what it is (``kind``).
    """

    number: int
    way: int
    ratio: float
    kind: str


def sampled(count: int, some: int) -> tuple[int, ...]:
    """Numbers of so many members, evenly among all."""
    some = min(some, count)
    return tuple(sorted({int((k + 0.5) * count / some) for k in range(some)}))


def coded(kind: str) -> float:
    """A motion as a number: its period, or less than zero."""
    return float(kind.removeprefix("period ")) if kind.startswith("period ") else -1.0 - WORDS.index(kind)


def worded(code: float) -> str:
    """A motion from its number."""
    return f"period {code:.0f}" if code > 0.0 else WORDS[int(-1.0 - code)]


def packed(found: Iterable[Companion]) -> Array:
    """Companions as rows of numbers."""
    return np.array([(one.number, one.way, one.ratio, coded(one.kind)) for one in found]).reshape(-1, 4)


def unpacked(rows: Array | None) -> list[Companion]:
    """Companions from their rows."""
    every = [] if rows is None else rows.reshape(-1, 4).tolist()
    return [Companion(int(number), int(way), ratio, worded(code)) for number, way, ratio, code in every]


def restepped_models(models: Sequence[Assembly]) -> Iterator[tuple[float, list[Assembly]]]:
    """The same models with other steps, where they are stable with them."""
    steps = steps_of_turn(models[0])
    for ratio in RATIOS:
        with suppress(VfifeError):
            yield ratio, [stepped(one.mechanism, round(ratio * steps)) for one in models]


def observed(
    asked: MapSpec,
    near: Neighbours | None,
    starts: Sequence[Start],
    steps: int | None = None,
    known: Collection[int] = (),
) -> Iterator[tuple[Orbit, Array]]:
    """Motions from starts that are not ``known``, as they end, with their series once a turn, shape (turns,
    series); no turns without a start.
    """
    steps = steps or asked.steps
    for one in Orbits(steps, asked.turns, asked.dropped, near).each(starts, known):
        nothing = np.zeros((0, len(asked.series)))
        model = one.assembly
        yield (
            one,
            nothing if model is None else looked(model, recorded_rows(model), one.rows, asked.series, steps),
        )


def carried_companions(
    asked: MapSpec, numbers: Sequence[int], models: Sequence[Assembly], near: Sequence[Neighbours], state: Array, done: int,
    look: Callable[[], None] | None,
) -> list[Companion]:  # fmt: skip
    """The chains again at their values, of such ``numbers``, from the state before these, shape (rows,
    chains), after so many steps.
    """
    found = []
    for ratio, again in restepped_models(models):
        both = [restepped(state[:, k], done, one) for k, one in enumerate(again)]
        runner = TurnRunner(again, look=look)
        runner.restore(np.stack([one for one, _ in both], axis=1), both[0][1])
        rows, growth = runner.growing(asked.turns, asked.dropped, near)
        for k, one in enumerate(again):
            points = looked(one, runner.kept, rows[:, :, k], asked.series, runner.turn)
            found.append(Companion(numbers[k], k, ratio, verdict(points, exponent(growth[:, k])).kind))
    return found


def started_companions(
    asked: MapSpec, sample: Sequence[int], make: Callable[[int, int], Start], near: Neighbours | None
) -> Iterator[Companion]:
    """Members again from their starts, which are made by their number and the steps in a turn; those that are
    not stable with them are left out.
    """
    for ratio in RATIOS:
        own = round(ratio * asked.steps)
        for one, points in observed(asked, near, [make(number, own) for number in sample], own):
            if one.assembly is not None:
                yield Companion(
                    one.number,
                    0,
                    ratio,
                    verdict(points, exponent(one.growth) if len(one.growth) else None).kind,
                )


def alike(companions: Sequence[Companion], kinds: Callable[[Companion], str]) -> str:
    """How many companions are told to be what their member is, in a few words for a figure."""
    same = sum(one.kind == kinds(one) for one in companions)
    return f"{same} of {len(companions)} companions alike" if companions else "no companions"


def told(
    companions: Sequence[Companion], kinds: Callable[[Companion], str], name: Callable[[Companion], str]
) -> str:
    """What companions come to in words: of how many members, and where they are told to be something else.
    Empty where there are none.
    """
    if not companions:
        return ""
    pairs = [(one, kinds(one)) for one in companions]
    other = [(one, kind) for one, kind in pairs if one.kind != kind]
    counts = Counter(one.ratio for one in companions)
    steps = " and ".join(f"{1.0 / ratio:g}" for ratio in sorted(counts))
    members = len({(one.number, one.way) for one in companions})
    same = f"{len(pairs) - len(other)} of {len(pairs)} companions are told the same"
    said = f"{members} member{'s' * (members != 1)} again with {steps} times the step: {same}"
    where = [
        f"{name(one)} is {kind}, with {1.0 / one.ratio:g} times the step {one.kind}" for one, kind in other
    ]
    return f"{said}; {'; '.join(where)}." if where else f"{said}."
