"""Bifurcation diagrams: a number of the model is swept up and down, and the motion at each value is looked at
once a turn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Unpack

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError
from ..measures.chaos import Verdict, exponent, verdict
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter
from ..options import with_options
from ..simulation.turn_steps import refuse_large_frame, with_steps
from ..solvers.tangents import Neighbours
from ..solvers.turn_runner import Start, Sweep, discontinuity, side_by_side
from ..store.mapfile import MapFile
from .maps import (
    MAP_DEFAULTS,
    MapOptions,
    MapRows,
    MapSpec,
    TurnRun,
    chosen_series,
    models_along,
    neighbours_of,
    series_values,
    unit_at,
)
from .start_states import StartStates, refuse_contradiction, start_words, values_between
from .step_check import (
    SAMPLE,
    CheckedMap,
    Companion,
    chain_companions,
    orbits,
    packed,
    sampled,
    start_companions,
    unpacked,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 30, 45  # values, and turns at each
CHAINS = ("up", "down")
NEAR = 1e-6  # of the range, by which the difference begins that is followed


@dataclass(frozen=True)
class SweepSpec(MapSpec):
    """A sweep of the number at ``path``, with its ``unit``, over ``values`` in the order of the way up.

    Of ``turns`` at each value the first are ``dropped``; ``series`` with their ``units`` are looked at once a
    turn of so many ``steps``, at a ``phase`` (1) of it. ``starts``: numbers of each start from which every
    value begins; without any the state is carried on, up and down. ``companions``: number of values that are
    repeated with other steps.
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
        return tuple(start_words(one) or "own start" for one in self.starts) or CHAINS

    @property
    def count(self) -> int:
        """Number of rows in a map file: values of both chains, or of each start."""
        return len(self.values) * max(1, len(self.starts))


@dataclass(frozen=True)
class Spell:
    """A motion, the ``first`` and the ``last`` of neighbouring values at which it is found, and their
    ``count``.
    """

    kind: str
    first: float
    last: float
    count: int


@dataclass(frozen=True, repr=False)
class Bifurcation(CheckedMap):
    """A bifurcation diagram, its values in the order of the way up, NaN where they are not known yet.

    Chains are the way up and the way down, or the starts. Of each of ``spec.series`` the ``points`` in SI
    units, shape (chains, values, turns); ``growth`` of a small difference in each of these turns, its
    logarithm; the largest Lyapunov ``exponents`` (1/turn), each with the lower and the higher of its two
    halves, shape (chains, values, 3); ``kinds`` of the motion, shape (chains, values). ``done`` values are
    known in each chain.
    """

    kind: ClassVar[str] = "bifurcation"
    points: Mapping[str, Array]
    growth: Array
    exponents: Array
    kinds: tuple[tuple[str, ...], ...]
    done: int

    @classmethod
    def of(
        cls,
        name: str,
        spec: SweepSpec,
        legs: Mapping[int, tuple[Array, Array]],
        companions: Sequence[Companion],
    ) -> Bifurcation:
        """The diagram of the rows of a map file."""
        shape = len(spec.ways), len(spec.values), spec.turns - spec.dropped
        points, growth = {series: np.full(shape, np.nan) for series in spec.series}, np.full(shape, np.nan)
        exponents, kinds = np.full((*shape[:2], 3), np.nan), [[""] * shape[1] for _ in spec.ways]
        for chain, value, values, logarithms in chain_values(spec, legs):
            for j, series in enumerate(spec.series):
                points[series][chain, value] = values[:, j]
            growth[chain, value] = logarithms
            largest = exponent(logarithms)
            exponents[chain, value] = largest.value, largest.low, largest.high
            kinds[chain][value] = verdict(values, largest).kind
        ordered = tuple(sorted(companions, key=lambda one: (one.way, one.number, one.ratio)))
        done = len(legs) // max(1, len(spec.starts))
        return cls(name, spec, ordered, points, growth, exponents, tuple(map(tuple, kinds)), done)

    @classmethod
    def read(cls, file: MapFile) -> Bifurcation:
        """The diagram in a map file, as far as it is known."""
        spec, rows = SweepSpec.of(file.spec["asked"]), MapRows(file)
        companions = load_rows(rows, spec)
        return cls.of(file.spec["name"], spec, rows.done, companions)

    def spells(self, chain: int) -> list[Spell]:
        """Neighbouring values with the same motion, in the order of the way up."""
        kinds = [
            (value, kind) for value, kind in zip(self.spec.values, self.kinds[chain], strict=True) if kind
        ]
        spells: list[Spell] = []
        for kind, pairs in groupby(kinds, key=lambda one: one[1]):
            values = [value for value, _ in pairs]
            spells.append(Spell(kind, values[0], values[-1], len(values)))
        return spells

    def verdict(self, chain: int, value: int) -> Verdict:
        """The motion at a value, with its evidence."""
        points = np.stack([one[chain, value] for one in self.points.values()], axis=1)
        return verdict(points, exponent(self.growth[chain, value]))

    def kind_of(self, case: Companion) -> str:
        """Motion of the value of a companion, empty if it is not known."""
        return self.kinds[case.way][case.number]

    def name_of(self, case: Companion) -> str:
        """The value of a companion in words."""
        return f"{self.spec.path} = {self.spec.values[case.number]:.5g} ({self.spec.ways[case.way]})"

    def plot(self) -> Figure:
        """The diagram as a figure, with the exponents below it."""
        from ..plots.dynamics import diagram

        return diagram(self)

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a row for every value, way and turn that was looked at, with the exponent and the kind of the
        motion.
        """
        yield [self.spec.path, "way", "turn", *self.spec.series, "exponent", "kind"]
        for chain, way in enumerate(self.spec.ways):
            for k, value in enumerate(self.spec.values):
                if kind := self.kinds[chain][k]:
                    points = np.stack([one[chain, k] for one in self.points.values()], axis=1)
                    for turn, row in enumerate(points.tolist(), self.spec.dropped + 1):
                        yield [value, way, turn, *row, float(self.exponents[chain, k, 0]), kind]


def load_rows(rows: MapRows, spec: SweepSpec) -> list[Companion]:
    """Read the rows of a map file into ``rows.done``, and return their companions.

    Where the state is carried on, a missing row ends them.
    """
    rows.done |= rows.legs(gaps=bool(spec.starts))
    return [one for number in rows.done for one in unpacked(rows.array(f"beside {number}"))]


def chain_values(
    spec: SweepSpec, legs: Mapping[int, tuple[Array, Array]]
) -> Iterator[tuple[int, int, Array, Array]]:
    """Chain, value, points (turns, series) and growth (turns,) of all rows; each is of one chain from starts,
    else of both chains.
    """
    count, series = len(spec.values), len(spec.series)
    for number, (points, growth) in legs.items():
        if spec.starts:
            yield number // count, number % count, points, growth.reshape(-1)
            continue
        shaped = points.reshape(len(points), series, 2)
        for k, value in enumerate((number, count - 1 - number)):
            yield k, value, shaped[:, :, k], growth[:, k]


@with_options(MapOptions, **MAP_DEFAULTS, turns=90)
def bifurcation(
    mechanism: Mechanism, path: str, low: float | str, high: float | str, *, count: int = 60,
    starts: Sequence[Mapping[str, float]] = (),
    companions: int = SAMPLE, **options: Unpack[MapOptions],
) -> Bifurcation:  # fmt: skip
    """Sweep the number at ``path`` from ``low`` to ``high`` and back in ``count`` values, the state carried
    on
    from one to the next.

    >>> bifurcation(mechanism, "joint.C.clearance", "0.1 mm", "1 mm", count=30).plot()  # doctest: +SKIP

    ``turns`` (90) are simulated at each value, of which the first ``dropped``, two thirds unless given, are
    not looked at. ``series`` are looked at once a turn, at a ``phase`` (1) of it, by their names in
    ``result.series``; unless given, the penetration and the largest force of a contact, or a place or speed,
    that vary. ``step`` (s): the finest that a run of ten turns finds at both ends and in the middle, unless
    given; a turn has a whole number of steps, the same for all values.

    With ``starts`` each value begins anew from each of them: ``{}`` is the model's own,
    ``{"start.crank": 1.57, "start.pin.x": 1e-4}`` another (:func:`~vfife.dynamics.basins` lists the numbers).
    ``companions``: number of values that are repeated with 1.25 times and with half the step.

    A ``file`` keeps each value, and the same call continues it. ``progress(done, total)`` is called after
    each value. Ctrl-C leaves what is complete. ``confirm``: compute even what takes more than an hour, or
    half of the disk. Raises ModelError for a number that cannot be swept so, HeldError where another process
    writes the file.
    """
    run = TurnRun("bifurcation", **options)
    values = values_between("bifurcation", mechanism, path, (low, high), count)
    own = tuple(tuple(sorted((name, float(value)) for name, value in one.items())) for one in starts)
    for one in own:
        refuse_contradiction(mechanism, (path, *dict(one)))
    steps = run.step_count(models_along(mechanism, ((path, values[0], values[-1]),)))
    text = dump(mechanism)
    parameter = Parameter(loads(text), path)
    lanes, chains = (4, 1) if own else (2, 2)
    numbers = (len(run.series or (1, 1)) + 1) * chains
    work = run.work(
        "value",
        count * max(len(own), 1),
        steps,
        lanes,
        numbers=numbers,
        companions=companions,
        first_look=FIRST_LOOK,
    )
    run.begin(work, with_steps(parameter.set(values[0]), steps))
    models = [with_steps(parameter.set(value), steps) for value in values]
    series, units = chosen_series(models[0], run.series)
    spec = SweepSpec(
        text, path, values, run.turns, run.dropped, series, run.phase, steps, unit_at(mechanism, path),
        units, own, companions
    )  # fmt: skip
    refuse_other_mechanisms(spec, models)
    with run.rows(Bifurcation, mechanism.name, spec) as rows:
        repeats = load_rows(rows, spec)
        for leg in (from_starts if own else from_neighbours)(spec, models, rows):
            rows.write("arrays", f"beside {leg.number}", packed(leg.companions))
            rows.write("legs", leg.number, leg.points, leg.growth, leg.state)
            rows.done[leg.number] = leg.points, leg.growth
            repeats += leg.companions
            run.job.count(len(rows.done), spec.count, "values")
    return Bifurcation.of(mechanism.name, spec, rows.done, repeats)


class SweepRow(NamedTuple):
    """A row of a map file, with the companions of its value."""

    number: int
    points: Array
    growth: Array
    state: Array
    companions: Sequence[Companion]


def refuse_other_mechanisms(spec: SweepSpec, models: Sequence[Assembly]) -> None:
    """Raises ModelError where the motion of one value cannot go on at the next, or beside it in a lane."""
    for value, one in zip(spec.values, models, strict=True):
        why = side_by_side(models[0], one) if spec.starts else discontinuity(models[0], one)
        if why is not None:
            what = f"at {value:g} the mechanism is another than at {spec.values[0]:g}: {why()}"
            remedy = (
                "sweep play, a law, a mass, a load or the speed, or begin each value anew (--start own,"
                " starts=[{}])"
            )
            raise ModelError(
                [Fault(spec.path, what, "", "", "use vfife study" if spec.starts else remedy)],
                one.mechanism.name,
            )
    refuse_large_frame(models[0])


def end_neighbours(spec: SweepSpec, chain: int) -> Neighbours:
    """The first model of a chain, a little to both sides; inside the range, so that both can be assembled."""
    low, high = spec.values[0], spec.values[-1]
    span = NEAR * (high - low)
    inner = low + span if chain == 0 else high - 2.0 * span
    up, down = (
        with_steps(loads(spec.model, set=[(spec.path, value)]), spec.steps) for value in (inner + span, inner)
    )
    return Neighbours(up, down, span)


def from_neighbours(spec: SweepSpec, models: list[Assembly], rows: MapRows) -> Iterator[SweepRow]:
    """The rows that are not known yet, their state continued from value to value, with companions of some."""
    chains, count, last = [models, models[::-1]], len(rows.done), len(models) - 1
    if count > last:
        return
    near, sample = (
        [end_neighbours(spec, k) for k in range(len(chains))],
        sampled(len(models), spec.companions),
    )

    def companions(number: int, state: Array, done: int, look: Callable[[], None]) -> list[Companion]:
        if number not in sample or number < count:
            return []
        return chain_companions(
            spec, (number, last - number), [chain[number] for chain in chains], near, state, done, look
        )

    sweep = Sweep(chains, near, spec.phase, companions)
    last_leg = sweep.complete_legs(count) - 1
    resume = (
        (last_leg, rows.file.state(last_leg).reshape(sweep.states.shape))
        if rows.file is not None and last_leg >= 0
        else None
    )
    for leg in sweep.legs(spec.turns, spec.dropped, resume):
        if leg.number >= count:
            here = [chain[leg.number] for chain in chains]
            points = [
                series_values(one, sweep.row_numbers, leg.rows[:, :, k], spec.series, spec.steps)
                for k, one in enumerate(here)
            ]
            yield SweepRow(
                leg.number,
                np.stack(points, axis=2).reshape(len(leg.rows), -1),
                leg.growth,
                leg.state,
                leg.check,
            )


def from_starts(spec: SweepSpec, models: list[Assembly], rows: MapRows) -> Iterator[SweepRow]:
    """The rows that are not known yet, each from a start of its own; companions come first, so that an
    interrupted map has them.
    """
    near, count = end_neighbours(spec, 0), len(models)
    if (
        discontinuity(models[0], near.up) is not None
    ):  # pins move with the number: a difference by it would open the joints
        near = neighbours_of(models[0].mechanism, models[0], spec.steps)

    def start_of(number: int, steps: int) -> Start:
        numbers, model = dict(spec.starts[number // count]), models[number % count]
        state = StartStates(model.mechanism, steps)
        own = not numbers and steps == spec.steps
        return Start(
            number, (lambda: model) if own else partial(state.at, numbers), state.ahead(numbers, spec.phase)
        )

    done = tuple(rows.done)
    companions: dict[int, list[Companion]] = {
        number: [] for number in sampled(spec.count, spec.companions) if number not in done
    }
    for own in start_companions(spec, tuple(companions), start_of, near):
        companions[own.number].append(Companion(own.number % count, own.number // count, own.ratio, own.kind))
    for one, points in orbits(
        spec, near, [start_of(number, spec.steps) for number in range(spec.count)], done=done
    ):
        if one.assembly is None:
            raise ModelError([Fault("starts", one.why)], models[0].mechanism.name)
        yield SweepRow(one.number, points, one.growth, np.zeros(0), companions.get(one.number, []))
