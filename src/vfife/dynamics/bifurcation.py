"""What a bifurcation diagram has, as far as it is known: points, growth, motions in words, companions;
written as a table, read from a map file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError
from ..files import write_rows
from ..job.job import job_of
from ..measures.chaos import Verdict, exponent, verdict
from ..model.above import NotebookDocument
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter
from ..solvers.tangents import Neighbours
from ..solvers.turn_runner import Start, Sweep, carried_on, side_by_side
from ..store.mapfile import MapFile
from .section_series import (
    MapWork,
    chosen_series,
    kept_in,
    law_words,
    left_out,
    looked,
    models_along,
    refuse_idle,
    refuse_large_frame,
    seed,
    step_count,
    stepped,
    tupled,
    unit_at,
)
from .starts import Starts, refuse_contradiction, spoken
from .step_check import (
    SAMPLE,
    Companion,
    alike,
    carried_companions,
    observed,
    packed,
    sampled,
    started_companions,
    told,
    unpacked,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 30, 45  # values and turns at each
CHAINS = ("up", "down")
WHAT = "bifurcation"


@dataclass(frozen=True)
class SweepSpec:
    """What is asked: the number's ``path`` and its ``values`` in the order of the way up, ``turns`` at each,
    the first of them ``dropped``; ``series`` are looked at once a turn at ``phase`` (1) of it; ``steps`` in a
    turn. ``unit`` is that of the number, ``units`` are those of series. ``starts``: numbers of each start
    from which every value begins; without any the state is carried on, up and down. So many values have
    ``companions``.
    """

    model: str
    path: str
    values: tuple[float, ...]
    turns: int
    dropped: int
    series: tuple[str, ...]
    phase: float
    steps: int
    unit: str = "SI"
    units: tuple[str, ...] = ()
    starts: tuple[tuple[tuple[str, float], ...], ...] = ()
    companions: int = 0

    @property
    def ways(self) -> tuple[str, ...]:
        """How a value is reached, in words: on the ways up and down, or from its starts."""
        return tuple(spoken(one) or "own start" for one in self.starts) or CHAINS


@dataclass(frozen=True)
class Spell:
    """A motion in words, the ``first`` and the ``last`` of the values at which it is found, and how many they
    are.
    """

    kind: str
    first: float
    last: float
    count: int


@dataclass(frozen=True)
class Bifurcation(NotebookDocument):
    """A diagram, its values in the order of the way up and NaN where it is not known yet; chains are the way
    up and the way down, or the starts.

    Of each of ``asked.series`` its ``points`` in SI units, shape (chains, values, turns); ``growth`` of a
    small difference in each of these turns, its logarithm; the largest Lyapunov ``exponents`` (1/turn), each
    with the lower and the higher of its two halves, shape (chains, values, 3); ``kinds`` of the motion in
    words, shape (chains, values). So many values are ``done`` in each chain. ``companions``: members with
    other steps.
    """

    name: str
    asked: SweepSpec
    points: Mapping[str, Array]
    growth: Array
    exponents: Array
    kinds: tuple[tuple[str, ...], ...]
    done: int
    companions: tuple[Companion, ...] = field(default=())

    def spells(self, chain: int) -> list[Spell]:
        """Values next to each other at which the motion is called the same, in the order of the way up."""
        known = [
            (value, kind) for value, kind in zip(self.asked.values, self.kinds[chain], strict=True) if kind
        ]
        found: list[Spell] = []
        for kind, some in groupby(known, key=lambda one: one[1]):
            values = [value for value, _ in some]
            found.append(Spell(kind, values[0], values[-1], len(values)))
        return found

    def verdict(self, chain: int, value: int) -> Verdict:
        """What the motion at a value is, with its evidence."""
        points = np.stack([one[chain, value] for one in self.points.values()], axis=1)
        return verdict(points, exponent(self.growth[chain, value]))

    @property
    def laws(self) -> str:
        """Contact and friction laws, in words."""
        return law_words(loads(self.asked.model))

    @property
    def alike(self) -> str:
        """How many companions are told to be the same, in a few words."""
        return alike(self._known, lambda one: self.kinds[one.way][one.number])

    @property
    def _known(self) -> list[Companion]:
        return [one for one in self.companions if self.kinds[one.way][one.number]]

    @property
    def told(self) -> str:
        """What companions come to, in words; empty where there are none."""
        asked, known = self.asked, self._known
        name = lambda one: f"{asked.path} = {asked.values[one.number]:.5g} ({asked.ways[one.way]})"  # noqa: E731
        return told(known, lambda one: self.kinds[one.way][one.number], name)

    def plot(self) -> Figure:
        """The diagram as a figure, with the exponents below it."""
        from ..plots.maps import diagram

        return diagram(self)

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for every value, direction and turn that was looked at, with the exponent and the kind
        of the motion.
        """
        rows: list[list[object]] = [[self.asked.path, "way", "turn", *self.asked.series, "exponent", "kind"]]
        for k, way in enumerate(self.asked.ways):
            for place, value in enumerate(self.asked.values):
                if self.kinds[k][place]:
                    said = float(self.exponents[k, place, 0]), self.kinds[k][place]
                    for turn, row in enumerate(
                        np.stack([one[k, place] for one in self.points.values()], axis=1).tolist()
                    ):
                        rows.append([value, way, self.asked.dropped + turn + 1, *row, *said])
        write_rows(path, rows)


@dataclass
class Legs:
    """What is known of a map: points and growth by the number of a value, of all chains (carried on) or of
    one (from starts), and companions.
    """

    asked: SweepSpec
    legs: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    companions: list[Companion] = field(default_factory=list)

    @classmethod
    def of(cls, asked: SweepSpec, kept: MapFile) -> Legs:
        """Those of a file; of what is carried on, up to the first that is missing."""
        legs = kept.legs(gaps=bool(asked.starts))
        return cls(asked, legs, [one for number in legs for one in unpacked(kept.array(f"beside {number}"))])

    @property
    def count(self) -> int:
        """Legs that there will be."""
        return len(self.asked.values) * max(1, len(self.asked.starts))

    def add(self, number: int, points: Array, growth: Array, beside: Sequence[Companion]) -> None:
        """One more."""
        self.legs[number] = points, growth
        self.companions += beside

    def each(self) -> Iterator[tuple[int, int, Array, Array]]:
        """Chain, value, points (turns, series) and growth (turns,) of all that is known."""
        count, series = len(self.asked.values), len(self.asked.series)
        for number, (points, growth) in self.legs.items():
            if self.asked.starts:
                yield number // count, number % count, points, growth.reshape(-1)
                continue
            shaped = points.reshape(len(points), series, 2)
            for k, place in enumerate((number, count - 1 - number)):
                yield k, place, shaped[:, :, k], growth[:, k]

    def diagram(self, name: str) -> Bifurcation:
        """The diagram; chains that go down have their values in the order of the way up."""
        asked = self.asked
        shape = len(asked.ways), len(asked.values), asked.turns - asked.dropped
        points, growth = {series: np.full(shape, np.nan) for series in asked.series}, np.full(shape, np.nan)
        exponents, kinds = np.full((*shape[:2], 3), np.nan), [[""] * shape[1] for _ in asked.ways]
        for k, place, values, grown in self.each():
            for j, series in enumerate(asked.series):
                points[series][k, place] = values[:, j]
            growth[k, place] = grown
            found = exponent(grown)
            exponents[k, place] = found.value, found.low, found.high
            kinds[k][place] = verdict(values, found).kind
        done, beside = (
            len(self.legs) // max(1, len(asked.starts)),
            sorted(self.companions, key=lambda one: (one.way, one.number, one.ratio)),
        )
        return Bifurcation(
            name, asked, points, growth, exponents, tuple(map(tuple, kinds)), done, tuple(beside)
        )


def read_diagram(kept: MapFile) -> Bifurcation:
    """The diagram in a map file, as far as it is known."""
    said = kept.spec
    asked = SweepSpec(**tupled(said["asked"]))
    return Legs.of(asked, kept).diagram(said["name"])


Leg: TypeAlias = tuple[int, Array, Array, Array, list[Companion]]
NEAR = 1e-6  # of the range, by which the difference begins that is watched


def bifurcation(
    mechanism: Mechanism,
    path: str,
    low: float,
    high: float,
    *,
    count: int = 60,
    turns: int = 90,
    dropped: int | None = None,
    series: Sequence[str] = (),
    phase: float = 0.0,
    step: float | None = None,
    starts: Sequence[Mapping[str, float]] = (),
    companions: int = SAMPLE,
    file: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    confirm: bool = False,
) -> Bifurcation:
    """Sweeps the number at ``path`` from ``low`` to ``high`` (SI) and back in ``count`` values, the state
    carried on from one to the next.

    At each ``turns`` turns, of which ``dropped`` are not looked at, two thirds unless said. ``series``: what
    is looked at once a turn, by its name in ``result.series``; the penetration and the largest force of a
    contact, or a place or speed, that vary, unless said. ``step`` (s): the finest that a run of ten turns
    finds at both ends and in the middle, unless said; a turn has a whole number of them, the same for all
    values. With ``starts`` each value begins anew from each of them: ``{}`` is the model's own,
    ``{"start.crank": 1.57, "start.pin.x": 1e-4}`` another (:func:`~vfife.basins` says which numbers there
    are). ``companions``: so many values are gone through again, with 1.25 times and half the step. With a
    ``file`` what is known is kept in it after each value, and the same call goes on there. Ctrl-C leaves what
    is complete. ``confirm``: make it even where it takes more than an hour, or half of the disk. Raises
    ModelError for a number that cannot be swept so, HeldError where another process writes the file.
    """
    values, dropped = np.linspace(low, high, count), left_out(dropped, turns)
    job = job_of("bifurcation", file, confirm, progress, lambda one: progress(one.done, one.steps))  # type: ignore[misc]

    def begin(first: Assembly, steps: int) -> None:
        lanes, chains = (4, 1) if starts else (2, 2)
        numbers = (len(series or (1, 1)) + 1) * chains
        work = MapWork(
            "value",
            count * max(len(starts), 1),
            turns,
            dropped,
            steps,
            lanes,
            numbers,
            companions,
            first_look=FIRST_LOOK,
        )
        job.begin(work.forecast(first, file))

    own = tuple(tuple(sorted((name, float(value)) for name, value in one.items())) for one in starts)
    asked = SweepSpec(
        dump(mechanism),
        path,
        tuple(map(float, values)),
        turns,
        dropped,
        tuple(series),
        phase,
        0,
        starts=own,
        companions=companions,
    )
    asked, every = planned(mechanism, asked, step, begin)
    refuse(asked, every)
    with job, kept_in(file, {"what": WHAT, "name": mechanism.name, "asked": asked}) as kept:
        known = Legs(asked) if kept is None else Legs.of(asked, kept)
        try:
            for number, points, growth, state, beside in (anew if starts else carried)(
                asked, every, known, kept
            ):
                if kept is not None:
                    kept.write_row("arrays", f"beside {number}", packed(beside))
                    kept.write_row("legs", number, points, growth, state)
                known.add(number, points, growth, beside)
                job.count(len(known.legs), known.count, "values")
        except KeyboardInterrupt:
            if not known.legs:
                raise
    return known.diagram(mechanism.name)


def planned(
    mechanism: Mechanism, asked: SweepSpec, step: float | None, begin: Callable[[Assembly, int], None]
) -> tuple[SweepSpec, list[Assembly]]:
    """What is asked, with steps, series and units, and the model at each value, stepped alike; ``begin`` sees
    the first of them and the steps of a turn before the others.
    """
    path, values = asked.path, asked.values
    refuse_idle(mechanism, asked.turns, asked.dropped)
    for one in asked.starts:
        refuse_contradiction(mechanism, (path, *dict(one)))
    steps = step_count(models_along(mechanism, ((path, values[0], values[-1]),)), step, search=True)
    begin(stepped(loads(asked.model, set=[(path, values[0])]), steps), steps)
    every = assembled(asked.model, path, values, steps)
    series, units = chosen_series(every[0], asked.series)
    return replace(asked, series=series, steps=steps, unit=unit_at(mechanism, path), units=units), every


def assembled(text: str, path: str, values: Sequence[float], steps: int) -> list[Assembly]:
    """The model of a text at each value, with so many steps in a turn."""
    parameter = Parameter(loads(text), path)
    return [stepped(parameter.set(value), steps) for value in values]


def refuse(asked: SweepSpec, every: Sequence[Assembly]) -> None:
    """Raises ModelError where the motion of one value cannot go on at the next, or beside it."""
    for value, one in zip(asked.values, every, strict=True):
        why = side_by_side(every[0], one) if asked.starts else carried_on(every[0], one)
        if why is not None:
            what = f"at {value:g} the mechanism is another than at {asked.values[0]:g}: {why()}"
            remedy = (
                "sweep play, a law, a mass, a load or the speed, or begin each value anew (--start own,"
                " starts=[{}])"
            )
            raise ModelError(
                [Fault(asked.path, what, "", "", "use vfife study" if asked.starts else remedy)],
                one.mechanism.name,
            )
    refuse_large_frame(every[0])


def neighbours(asked: SweepSpec, chain: int) -> Neighbours:
    """The first model of a chain, a little to both sides; inside the range, so that both can be assembled."""
    low, high = asked.values[0], asked.values[-1]
    span = NEAR * (high - low)
    inner = low + span if chain == 0 else high - 2.0 * span
    up, down = (
        stepped(loads(asked.model, set=[(asked.path, value)]), asked.steps) for value in (inner + span, inner)
    )
    return Neighbours(up, down, span)


def carried(asked: SweepSpec, every: list[Assembly], known: Legs, kept: MapFile | None) -> Iterator[Leg]:
    """The legs that are not known yet, their state carried on from value to value, with companions of some."""
    chains, there = [every, every[::-1]], len(known.legs)
    if there == len(every):
        return
    near, sample = [neighbours(asked, k) for k in range(len(chains))], sampled(len(every), asked.companions)

    def again(number: int, state: Array, done: int, look: Callable[[], None]) -> list[Companion]:
        if number not in sample or number < there:
            return []
        numbers, here = (number, len(every) - 1 - number), [chain[number] for chain in chains]
        return carried_companions(asked, numbers, here, near, state, done, look)

    sweep = Sweep(chains, near, asked.phase, again)
    last = sweep.whole(there) - 1
    resume = None if kept is None or last < 0 else (last, kept.state(last).reshape(sweep.states.shape))
    for leg in sweep.legs(asked.turns, asked.dropped, resume):
        if leg.number >= there:
            here = [chain[leg.number] for chain in chains]
            points = [
                looked(one, sweep.kept, leg.rows[:, :, k], asked.series, asked.steps)
                for k, one in enumerate(here)
            ]
            yield (
                leg.number,
                np.stack(points, axis=2).reshape(len(leg.rows), -1),
                leg.growth,
                leg.state,
                leg.beside,
            )


def anew(asked: SweepSpec, every: list[Assembly], known: Legs, kept: MapFile | None) -> Iterator[Leg]:
    """The legs that are not known yet, each from a start of its own; companions of some come before them, so
    that they are not missing then.
    """
    near, count = neighbours(asked, 0), len(every)
    if (
        carried_on(every[0], near.up) is not None
    ):  # pins move with the number: a difference by it would open the joints
        near = seed(every[0].mechanism, every[0], asked.steps)

    def made(number: int, steps: int) -> Start:
        numbers, model = dict(asked.starts[number // count]), every[number % count]
        starts = Starts(model.mechanism, steps)
        own = not numbers and steps == asked.steps
        return Start(
            number,
            (lambda: model) if own else partial(starts.at, numbers),
            starts.ahead(numbers, asked.phase),
        )

    beside: dict[int, list[Companion]] = {
        number: [] for number in sampled(known.count, asked.companions) if number not in known.legs
    }
    for own in started_companions(asked, tuple(beside), made, near):
        beside[own.number].append(Companion(own.number % count, own.number // count, own.ratio, own.kind))
    for one, points in observed(
        asked, near, [made(number, asked.steps) for number in range(known.count)], known=tuple(known.legs)
    ):
        if one.assembly is None:
            raise ModelError([Fault("starts", one.why)], every[0].mechanism.name)
        yield one.number, points, one.growth, np.zeros(0), beside.get(one.number, [])
