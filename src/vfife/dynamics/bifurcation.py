"""Bifurcation diagrams: vary a parameter of the model up and down, record the motion at each value once a
turn, and classify it.

Two ways lead to a value. In a chain, the state continues from the value before: the diagram follows one
attractor until it ends, and the way up and the way down differ where two attractors coexist (hysteresis).
From starts, each value begins anew: values are independent, run in lanes, and show which attractor a start
leads to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import groupby
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Unpack

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError
from ..measures.attractors import tolerance_of
from ..measures.chaos import Verdict, exponent
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter
from ..options import with_options
from ..simulation.turn_steps import refuse_large_frame, with_steps
from ..solvers.arguments import Arguments
from ..solvers.tangents import Neighbours
from ..solvers.turn_runner import Start, Sweep, discontinuity, side_by_side
from ..store.studyfile import MapFile
from ..units import unit_factor, unit_written
from .maps import (
    MAP_DEFAULTS,
    MapOptions,
    MapRows,
    MapSpec,
    TurnRun,
    finite,
    models_along,
    neighbours_of,
    unit_at,
)
from .series import chosen_series, classified, motion_ranges, series_values
from .start_states import StartStates, refuse_contradiction, start_words, unit_of_argument, values_between
from .step_check import (
    SAMPLE,
    CheckedMap,
    Companion,
    chain_companions,
    orbits,
    packed,
    packed_points,
    sampled,
    start_companions,
    unpacked,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 30, 45  # values and turns of a quick trial
CHAINS = ("up", "down")
UNIT = "unit"  # key in a map file
# Difference of the swept parameter in two neighbouring motions, as a share of its range.
NEIGHBOUR_SHARE = 1e-6


@dataclass(frozen=True)
class SweepSpec(MapSpec):
    """Specification of a sweep of the parameter at ``path``, with its ``unit``, over ``values`` in the order
    of the first way: up, or down if the range is given from its upper end.

    ``turns`` are simulated at each value, of which the first ``dropped`` are not recorded; ``series`` with
    their ``units`` are recorded once a turn of ``steps`` steps, at a ``phase`` (1) of it. ``starts``: numbers
    (path, value) of each start from which every value begins; if there are none, the state continues from
    value to value, up and down. ``companions``: number of values that are repeated with other steps.
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
        """Names of the ways that lead to a value: up and down, or the starts."""
        chains = CHAINS if self.values[0] <= self.values[-1] else CHAINS[::-1]
        return tuple(start_words(start) or "own start" for start in self.starts) or chains

    @property
    def count(self) -> int:
        """Number of rows in a map file: one for each value of both chains, or for each value and start."""
        return len(self.values) * max(1, len(self.starts))


@dataclass(frozen=True)
class Spell:
    """A range of neighbouring values with the same ``kind`` of motion, in words: its ``first`` and ``last``
    value and their ``count``.
    """

    kind: str
    first: float
    last: float
    count: int


@dataclass(frozen=True, repr=False)
class Bifurcation(CheckedMap):
    """A bifurcation diagram; values are in the order of the way up, and numbers are NaN where nothing is
    computed yet.

    Chains are the way up and the way down, or the starts. ``points`` by series, in SI units, shape (chains,
    values, turns). ``growth``: logarithm of the growth of a small difference in each of these turns, shape
    (chains, values, turns). ``exponents``: the largest Lyapunov exponent (1/turn) with the lower and the
    higher mean of its two halves, shape (chains, values, 3); the uncertainty due to the step is not
    estimated. ``verdicts``: kinds of motion with their evidence, shape (chains, values), None where nothing
    is computed. ``done``: number of values that are computed in each chain. ``unit``: the unit in which the
    ends of a range of angles or speeds were written; empty if that is the SI unit.
    """

    file_kind: ClassVar[str] = "bifurcation"
    points: Mapping[str, Array]
    growth: Array
    exponents: Array
    verdicts: tuple[tuple[Verdict | None, ...], ...]
    done: int
    unit: str = ""

    @classmethod
    def of(
        cls,
        name: str,
        spec: SweepSpec,
        legs: Mapping[int, tuple[Array, Array]],
        companions: Sequence[Companion],
        unit: str = "",
    ) -> Bifurcation:
        """Return the diagram that consists of the rows of a map file."""
        shape = len(spec.ways), len(spec.values), spec.turns - spec.dropped
        points, growth = {series: np.full(shape, np.nan) for series in spec.series}, np.full(shape, np.nan)
        exponents = np.full((*shape[:2], 3), np.nan)
        verdicts: list[list[Verdict | None]] = [[None] * shape[1] for _ in spec.ways]
        for chain, value, values, logarithms in chain_values(spec, legs):
            for j, series in enumerate(spec.series):
                points[series][chain, value] = values[:, j]
            growth[chain, value] = logarithms
            largest = exponent(logarithms)
            exponents[chain, value] = largest.value, *largest.halves
            verdicts[chain][value] = classified(spec, values, largest)
        ordered = tuple(
            sorted(companions, key=lambda companion: (companion.way, companion.number, companion.ratio))
        )
        done = len(legs) // max(1, len(spec.starts))
        return cls(name, spec, ordered, points, growth, exponents, tuple(map(tuple, verdicts)), done, unit)

    @classmethod
    def read(cls, file: MapFile) -> Bifurcation:
        """Return the diagram in a map file, as far as it is computed."""
        spec, rows = SweepSpec.of(file.spec["asked"]), MapRows(file)
        companions = load_rows(rows, spec)
        return cls.of(file.spec["name"], spec, rows.done, companions, unit_in(rows))

    @property
    def shown(self) -> tuple[float, str]:
        """Factor and unit in which values of the parameter are shown."""
        if not self.unit:
            return 1.0, self.spec.unit
        return 1.0 / unit_factor(self.unit, self.spec.unit), self.unit

    @cached_property
    def kinds(self) -> tuple[tuple[str, ...], ...]:
        """Kinds of motion, shape (chains, values); empty where nothing is computed."""
        return tuple(tuple(verdict.kind if verdict else "" for verdict in chain) for chain in self.verdicts)

    def spells(self, chain: int) -> list[Spell]:
        """Return the ranges of neighbouring values with the same motion, in the order of the way up."""
        kinds = [
            (value, kind) for value, kind in zip(self.spec.values, self.kinds[chain], strict=True) if kind
        ]
        if self.spec.values[0] > self.spec.values[-1]:
            kinds.reverse()
        spells: list[Spell] = []
        for kind, pairs in groupby(kinds, key=lambda pair: pair[1]):
            values = [value for value, _ in pairs]
            spells.append(Spell(self.words_of(kind), values[0], values[-1], len(values)))
        return spells

    def _series(self, chain: int, value: int) -> Array:
        """Return the series at a value of a chain, shape (turns, series)."""
        return np.stack([series[chain, value] for series in self.points.values()], axis=1)

    def kind_of(self, case: Companion) -> str:
        """Return the kind of motion at a companion's value; empty if it is not computed."""
        return self.kinds[case.way][case.number]

    def motion_of(self, case: Companion) -> tuple[Array, Array]:
        """Return the points at a companion's value, and the difference below which they are equal."""
        points = self._series(case.way, case.number)
        return points, tolerance_of(points, motion_ranges(self.spec, points))

    def name_of(self, case: Companion) -> str:
        """Return a companion's value as text."""
        factor, unit = self.shown
        value = f"{factor * self.spec.values[case.number]:.5g}{f' {unit}' if self.unit else ''}"
        return f"{self.spec.path} = {value} ({self.spec.ways[case.way]})"

    def plot(self) -> Figure:
        """Return a figure of the diagram, with the exponents below it."""
        from ..plots.dynamics import diagram

        return diagram(self)

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a heading and a row for every value, way and recorded turn, with the exponent and the kind of
        motion.
        """
        yield [self.spec.path, "way", "turn", *self.spec.series, "exponent", "kind"]
        for chain, way in enumerate(self.spec.ways):
            for k, value in enumerate(self.spec.values):
                if kind := self.kinds[chain][k]:
                    points, words = self._series(chain, k).tolist(), self.words_of(kind)
                    for turn, row in enumerate(points, self.spec.dropped + 1):
                        yield [value, way, turn, *row, finite(self.exponents[chain, k, 0]), words]


def unit_in(rows: MapRows) -> str:
    """Return the unit in which the ends of the range were written; it is no part of the specification, so
    that files of former versions continue.
    """
    codes = rows.array(UNIT)
    return "" if codes is None else bytes(codes.astype(int).tolist()).decode()


def load_rows(rows: MapRows, spec: SweepSpec) -> list[Companion]:
    """Read the rows of a map file into ``rows.done``, and return their companions.

    In a chain, rows after a missing one are not used, because the state of the missing one is not known.
    """
    rows.done |= rows.legs(gaps=bool(spec.starts))
    return [
        companion
        for number in rows.done
        for companion in unpacked(
            rows.array(f"beside {number}"), rows.array(f"beside points {number}"), len(spec.series)
        )
    ]


def chain_values(
    spec: SweepSpec, legs: Mapping[int, tuple[Array, Array]]
) -> Iterator[tuple[int, int, Array, Array]]:
    """Yield chain, value, points (turns, series) and growth (turns,) of all rows of a map file.

    With starts, a row holds one value of one chain. Otherwise it holds a value of the way up and one of the
    way down, which are computed together.
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
    """Sweep the parameter at ``path`` from ``low`` to ``high`` and back in ``count`` values; the state
    continues from each value to the next.

    >>> bifurcation(mechanism, "joint.C.clearance", "0.1 mm", "1 mm", count=30).plot()  # doctest: +SKIP

    ``turns`` (90) are simulated at each value. The first ``dropped`` of them, two thirds unless given, are
    not recorded. ``series``, by their names in ``result.series``, are recorded once a turn at a ``phase`` (1)
    of it; the default is the penetration and the largest force of a contact, or a place or speed, that vary.
    ``step`` (s): by default the finest of the automatic steps of runs of ten turns at both ends and in the
    middle of the range; a turn has a whole number of steps, the same for all values.

    With ``starts`` each value begins anew from each of them: ``{}`` is the model's own start,
    ``{"start.crank": 1.57, "start.pin.x": 1e-4}`` another (:func:`~vfife.dynamics.basins` lists the numbers).
    ``companions``: number of values that are repeated with 1.25 times and with half the step.

    ``file`` stores each value, and the same call continues it. ``progress(done, total)`` is called after each
    value. Ctrl-C ends the computation and returns what is complete. While the step is searched for, it raises
    KeyboardInterrupt. ``confirm`` permits work of more than an hour or half of the disk. Raises ModelError
    for a parameter that cannot be swept, HeldError if another process writes the file.
    """
    arguments = Arguments("bifurcation")
    arguments.count("companions", companions, optional=False, low=0)
    sorted_starts = read_starts(arguments, starts)
    arguments.check()
    run = TurnRun("bifurcation", **options)
    values = values_between("bifurcation", mechanism, path, (low, high), count)
    for k, start in enumerate(sorted_starts):
        for name, _ in start:
            unit_of_argument(f"starts[{k}]", mechanism, name)
        refuse_contradiction(mechanism, (path, *dict(start)))
    steps = run.step_count(models_along(mechanism, ((path, values[0], values[-1]),)))
    text = dump(mechanism)
    parameter = Parameter(loads(text), path)
    lanes, chains = (4, 1) if sorted_starts else (2, 2)
    numbers = (len(run.series or (1, 1)) + 1) * chains
    work = run.work(
        "value",
        count * max(len(sorted_starts), 1),
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
        units, sorted_starts, companions
    )  # fmt: skip
    refuse_other_mechanisms(spec, models)
    unit = unit_written((low, high), spec.unit) if spec.unit in ("rad", "rad/s") else ""
    with run.rows(Bifurcation, mechanism.name, spec) as rows:
        repeats = load_rows(rows, spec)
        if unit and not unit_in(rows):
            rows.write("arrays", UNIT, np.array([*map(float, unit.encode())]))
        for leg in (from_starts if sorted_starts else from_neighbours)(spec, models, rows):
            rows.write("arrays", f"beside {leg.number}", packed(leg.companions))
            if leg.companions:
                rows.write("arrays", f"beside points {leg.number}", packed_points(leg.companions))
            rows.write("legs", leg.number, leg.points, leg.growth, leg.state)
            rows.done[leg.number] = leg.points, leg.growth
            repeats += leg.companions
            run.job.count(len(rows.done), spec.count, "values")
    return Bifurcation.of(mechanism.name, spec, rows.done, repeats, unit)


def read_starts(arguments: Arguments, starts: Any) -> tuple[tuple[tuple[str, float], ...], ...]:
    """Return starts as sorted pairs of a path and a number (SI); add a fault for anything else."""
    limit = 'a list of starts in SI units, as in [{}, {"start.crank": 1.57}]'
    arguments.kind("starts", starts, (list, tuple), limit)
    result = []
    for k, start in enumerate(starts if isinstance(starts, list | tuple) else ()):
        try:
            result.append(tuple(sorted((str(name), float(value)) for name, value in start.items())))
        except (AttributeError, TypeError, ValueError):
            arguments.fault(f"starts[{k}]", "this is no start", start, limit, "give numbers by their paths")
    return tuple(result)


class SweepRow(NamedTuple):
    """A row of a map file: its number, points, growth, the state after it, and the companions of its
    value.
    """

    number: int
    points: Array
    growth: Array
    state: Array
    companions: Sequence[Companion]


def refuse_other_mechanisms(spec: SweepSpec, models: Sequence[Assembly]) -> None:
    """Raise ModelError if the motion at one value cannot continue at the next, or, with starts, cannot run
    in a lane of the same loop.
    """
    for value, model in zip(spec.values, models, strict=True):
        difference = side_by_side(models[0], model) if spec.starts else discontinuity(models[0], model)
        if difference is not None:
            message = f"at {value:g} the mechanism differs from that at {spec.values[0]:g}: {difference()}"
            remedy = (
                "sweep clearance, a law, a mass, a load or the speed, or start anew at each value (--start"
                " own, starts=[{}])"
            )
            raise ModelError(
                [Fault(spec.path, message, "", "", "use vfife study" if spec.starts else remedy)],
                model.mechanism.name,
            )
    refuse_large_frame(models[0])


def end_neighbours(spec: SweepSpec, chain: int) -> Neighbours:
    """Return the models that follow a small difference in a chain: its first value changed slightly, towards
    the inside of the range, so that both can be assembled.
    """
    low, high = spec.values[0], spec.values[-1]
    # A single value has no range; its size takes the place.
    span = NEIGHBOUR_SHARE * (high - low or abs(low) or 1.0)
    inner = low + span if chain == 0 else high - 2.0 * span
    up, down = (
        with_steps(loads(spec.model, set=[(spec.path, value)]), spec.steps) for value in (inner + span, inner)
    )
    return Neighbours(up, down, span)


def from_neighbours(spec: SweepSpec, models: list[Assembly], rows: MapRows) -> Iterator[SweepRow]:
    """Yield the rows that are not in the file yet, the state continued from value to value, with companions
    of a sample.

    Both chains advance together in two lanes, the way down from the other end of the range. An interrupted
    sweep continues from the state of the last complete row.
    """
    chains, count, last = [models, models[::-1]], len(rows.done), len(models) - 1
    if count > last:
        return
    neighbours = [end_neighbours(spec, k) for k in range(len(chains))]
    sample = sampled(len(models), spec.companions)

    def companions(number: int, state: Array, done: int, look: Callable[[], None]) -> list[Companion]:
        if number not in sample or number < count:
            return []
        return chain_companions(
            spec, (number, last - number), [chain[number] for chain in chains], neighbours, state, done, look
        )

    sweep = Sweep(chains, neighbours, spec.phase, companions)
    last_leg = sweep.complete_legs(count) - 1
    resume = (
        (last_leg, rows.file.state(last_leg).reshape(sweep.states.shape))
        if rows.file is not None and last_leg >= 0
        else None
    )
    for leg in sweep.legs(spec.turns, spec.dropped, resume):
        if leg.number >= count:
            leg_models = [chain[leg.number] for chain in chains]
            points = [
                series_values(model, sweep.row_numbers, leg.rows[:, :, k], spec.series, spec.steps)
                for k, model in enumerate(leg_models)
            ]
            yield SweepRow(
                leg.number,
                np.stack(points, axis=2).reshape(len(leg.rows), -1),
                leg.growth,
                leg.state,
                leg.check,
            )


def from_starts(spec: SweepSpec, models: list[Assembly], rows: MapRows) -> Iterator[SweepRow]:
    """Yield the rows that are not in the file yet, each from a start of its own. Companions are computed
    first, so that an interrupted map has them.
    """
    neighbours, count = end_neighbours(spec, 0), len(models)
    # If pins move with the swept parameter, a difference in it would open the joints: take another one.
    if discontinuity(models[0], neighbours.up) is not None:
        neighbours = neighbours_of(models[0].mechanism, models[0], spec.steps)

    def start_of(number: int, steps: int) -> Start:
        numbers, model = dict(spec.starts[number // count]), models[number % count]
        states = StartStates(model.mechanism, steps)
        is_assembled = not numbers and steps == spec.steps
        return Start(
            number,
            (lambda: model) if is_assembled else partial(states.at, numbers),
            states.ahead(numbers, spec.phase),
        )

    done = tuple(rows.done)
    companions: dict[int, list[Companion]] = {
        number: [] for number in sampled(spec.count, spec.companions) if number not in done
    }
    # A row's number counts through the values of each start: companions are stored by value and way.
    for companion in start_companions(spec, tuple(companions), start_of, neighbours):
        companions[companion.number].append(
            replace(companion, number=companion.number % count, way=companion.number // count)
        )
    starts = [start_of(number, spec.steps) for number in range(spec.count)]
    for orbit, points in orbits(spec, neighbours, starts, done=done):
        if orbit.assembly is None:
            raise ModelError([Fault("starts", orbit.reason)], models[0].mechanism.name)
        yield SweepRow(orbit.number, points, orbit.growth, np.zeros(0), companions.get(orbit.number, []))
