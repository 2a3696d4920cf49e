"""Basins of attraction: the motion to which each start of a grid leads, over two numbers of the start or of
the model.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError
from ..kinematics.start import MISFIT, Misfit
from ..measures.attractors import (
    Attractor,
    attractors,
    change,
    is_attracting,
    period_of,
    step_share,
    tolerance_of,
)
from ..measures.chaos import CHAOTIC, TEST_POINTS, UNDECIDED, Verdict, exponent
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..options import with_options
from ..simulation.turn_steps import refuse_large_frame
from ..solvers.arguments import Arguments
from ..solvers.tangents import Neighbours
from ..solvers.turn_runner import Start
from ..store.studyfile import MapFile
from .maps import (
    MAP_DEFAULTS,
    START,
    TURNED_START,
    MapOptions,
    MapRows,
    MapSpec,
    TurnRun,
    finite,
    models_along,
    neighbours_of,
)
from .series import chosen_series, classified, motion_ranges, with_peaks
from .start_states import StartStates, refuse_contradiction, unit_of_argument, values_between
from .step_check import (
    SAMPLE,
    CheckedMap,
    Companion,
    orbits,
    packed,
    packed_points,
    path_ranges,
    sampled,
    start_companions,
    unpacked,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 100, 30  # starts, and turns of each
COMPANIONS = "beside"  # key of the companions in a map file
COMPANION_POINTS = "beside points"  # key of their points
RANGE = "range {}"  # key of the ranges of the series in the motion of a case
TRANSIENT = (
    "a small difference grows over {turns} turns, as in chaos or in a long transient, and decays from another"
    " start of the same model: take more turns (300)"
)
OF_START = {"position", "angle", "velocity"}  # keys of a body that describe its start


@dataclass(frozen=True)
class BasinSpec(MapSpec):
    """Specification of a grid over two numbers with ``paths`` and ``units``, at the values ``x`` and ``y``.

    Each case has ``turns``, of which the first ``dropped`` are not recorded; ``series`` are recorded once a
    turn of ``steps`` steps, at a ``phase`` (1) of it. ``exponents``: whether a small difference is followed.
    ``companions``: number of cases that are repeated with other steps.
    """

    model: str
    paths: tuple[str, str]
    units: tuple[str, str]
    x: tuple[float, ...]
    y: tuple[float, ...]
    turns: int
    dropped: int
    series: tuple[str, ...]
    phase: float
    steps: int
    exponents: bool
    companions: int

    @property
    def count(self) -> int:
        """Number of cases."""
        return len(self.x) * len(self.y)

    @property
    def varied(self) -> tuple[str, ...]:
        """The paths that belong to the model, not to the start: with them the points of a motion shift."""
        return tuple(
            path
            for path in self.paths
            if not path.startswith("start.") and OF_START.isdisjoint(path.split("."))
        )

    def numbers(self, case: int) -> dict[str, float]:
        """Return the two numbers of a case by path; x varies fastest with the number of the case."""
        return {self.paths[0]: self.x[case % len(self.x)], self.paths[1]: self.y[case // len(self.x)]}

    def model_numbers(self, case: int) -> tuple[float, ...]:
        """Return the numbers of the model in a case, without those of its start."""
        numbers = self.numbers(case)
        return tuple(numbers[path] for path in self.varied)


@dataclass(frozen=True, repr=False)
class Basins(CheckedMap):
    """Basins of attraction.

    ``points`` by number of the case: the series once a turn, shape (turns, series), with no turns where there
    is no start. ``growth`` by number of the case: logarithm of the growth of a small difference in each of
    these turns, shape (turns,). ``ranges`` by number of the case: range of each series within a turn of the
    motion, shape (series,); files of former versions have none.
    """

    file_kind: ClassVar[str] = "basins"
    noun: ClassVar[str] = "starts"
    most_differences: ClassVar[int] = 1  # a start has two long numbers
    points: Mapping[int, Array]
    growth: Mapping[int, Array]
    ranges: Mapping[int, Array] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        name: str,
        spec: BasinSpec,
        legs: Mapping[int, tuple[Array, Array]],
        companions: Sequence[Companion],
        ranges: Mapping[int, Array],
    ) -> Basins:
        """Return the basins that consist of the rows of a map file."""
        points = {k: rows.reshape(-1, len(spec.series)) for k, (rows, _) in legs.items()}
        return cls(
            name,
            spec,
            tuple(companions),
            points,
            {k: logarithms.reshape(-1) for k, (_, logarithms) in legs.items()},
            ranges,
        )

    @classmethod
    def read(cls, file: MapFile) -> Basins:
        """Return the basins in a map file, as far as they are computed."""
        spec, rows = BasinSpec.of(file.spec["asked"]), MapRows(file)
        legs = file.legs(gaps=True)
        return cls.of(file.spec["name"], spec, legs, stored_companions(rows, spec), stored_ranges(rows, legs))

    @property
    def planned(self) -> int:
        """Number of starts of complete basins."""
        return int(self.spec.count)

    @property
    def done(self) -> int:
        """Number of cases that are computed."""
        return len(self.points)

    @cached_property
    def verdicts(self) -> dict[int, Verdict]:
        """Kinds of motion by case, with the evidence; cases without a start are left out.

        A motion may be chaotic for many turns and then become periodic. Where a small difference decays from
        another start of the same model, chaos in fewer than 100 turns may be such a transient, and is not
        decided.
        """
        exponents = {k: exponent(growth) if len(growth) > 1 else None for k, growth in self.growth.items()}
        motions = {
            k: classified(self.spec, points, exponents[k])
            for k, points in sorted(self.points.items())
            if len(points)
        }
        regular = {
            self.spec.model_numbers(k)
            for k, motion in motions.items()
            if motion.period or (motion.exponent is not None and motion.exponent.decays)
        }
        return {
            k: dataclasses.replace(motion, kind=UNDECIDED, reason=TRANSIENT.format(turns=len(self.points[k])))
            if motion.kind == CHAOTIC
            and len(self.points[k]) < TEST_POINTS
            and self.spec.model_numbers(k) in regular
            else motion
            for k, motion in motions.items()
        }

    @cached_property
    def share(self) -> float:
        """Share of the range of a motion within which points of two motions are equal: four times the median
        change of points with another step, from 0.1 % to 1 %; 1 % without companions.
        """
        changes = [
            change(
                (self.verdicts[case.number].kind, self.points[case.number]),
                (case.kind, case.points),
                self.ranges_of(case.number),
            )
            for case in self.companions
            if len(case.points) and case.number in self.verdicts
        ]
        return step_share([value for value in changes if value is not None])

    @cached_property
    def attractors(self) -> list[Attractor]:
        """The motions to which cases lead, beginning with the most frequent.

        Two cases lead to the same motion if their points agree within the share :attr:`share` of the range of
        the motion (:func:`~vfife.measures.attractors.attractors`). Over a parameter of the model points shift
        from case to case; there all motions of one kind count as one.
        """
        cases, tolerance = range(self.spec.count), math.inf if self.spec.varied else self.share
        points = [self.points[k] if k in self.verdicts else None for k in cases]
        ranges = [None if orbit is None else self.ranges_of(k) for k, orbit in enumerate(points)]
        return attractors(points, [self.verdicts.get(k) for k in cases], tolerance, ranges)

    def ranges_of(self, case: int) -> Array:
        """Return the range of each series within a turn of the motion of a case, shape (series,)."""
        points = self.points[case]
        if case not in self.ranges:
            return motion_ranges(self.spec, points)
        return with_peaks(self.ranges[case], self.spec.series, points)

    @property
    def transients(self) -> list[int]:
        """Indices of the periodic :attr:`attractors` whose exponents do not show that a small difference
        decays: they may be transients near an unstable motion.
        """
        return [
            k
            for k, attractor in enumerate(self.attractors)
            if period_of(attractor.kind) and not is_attracting([self.verdicts[n] for n in attractor.members])
        ]

    @property
    def labels(self) -> Array:
        """Number of the attractor of each case, shape (y, x); NaN without a start or a result."""
        labels = np.full(self.spec.count, np.nan)
        for k, attractor in enumerate(self.attractors):
            labels[list(attractor.members)] = k
        return labels.reshape(len(self.spec.y), len(self.spec.x))

    @cached_property
    def misfit(self) -> Misfit | None:
        """Of the corners, the middles of edges and the middle of the grid: the given velocity that differs
        most from that of the run, by more than 1 % of itself and of its axis.
        """
        spec = self.spec
        states, axes = StartStates(self.mechanism, spec.steps), (spec.x, spec.y)
        cases = [len(spec.x) * row + column for row in thirds(spec.y) for column in thirds(spec.x)]
        spans = {path: max(axis) - min(axis) for path, axis in zip(spec.paths, axes, strict=True)}
        misfits = [
            misfit
            for case in cases
            for misfit in states.misfits(spec.numbers(case))
            if misfit.size > MISFIT * max(spans.get(path, 0.0) for path in misfit.paths)
        ]
        return max(misfits, key=lambda misfit: misfit.size, default=None)

    def kind_of(self, case: Companion) -> str:
        """Return the kind of the motion that a companion's case reached; empty if it is not computed."""
        return self.reached(case.number).kind if case.number in self.verdicts else ""

    def reached(self, case: int) -> Attractor:
        """Return the motion that a case reached."""
        return next(attractor for attractor in self.attractors if case in attractor.members)

    def motion_of(self, case: Companion) -> tuple[Array, Array]:
        """Return the points of the motion that a companion's case reached, and their tolerance."""
        points, attractor = self.points[case.number], self.reached(case.number)
        tolerance = tolerance_of(points, self.ranges_of(case.number), self.share)
        if self.spec.varied or not period_of(attractor.kind) or attractor.tolerance is None:
            return points, tolerance
        return attractor.points, attractor.tolerance

    def name_of(self, case: Companion) -> str:
        """Return the numbers of a companion's case as text, angles in degrees as in the figure."""
        units = dict(zip(self.spec.paths, self.spec.units, strict=True))
        return ", ".join(
            f"{path} = {np.degrees(value):.4g} deg" if units[path] == "rad" else f"{path} = {value:.4g}"
            for path, value in self.spec.numbers(case.number).items()
        )

    def plot(self) -> Figure:
        """Return a figure of the grid with one colour for each attractor."""
        from ..plots.dynamics import basins as figure_of

        return figure_of(self)

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a heading and a row for each case: its two numbers, attractor (counted from 1), kind of
        motion, exponent, and the series in the last turn.
        """
        yield [*self.spec.paths, "attractor", "kind", "exponent", *self.spec.series]
        labels = self.labels.reshape(-1)
        for case, motion in self.verdicts.items():
            value = "" if motion.exponent is None else finite(motion.exponent.value)
            numbers = self.spec.numbers(case).values()
            yield [*numbers, int(labels[case]) + 1, motion.words, value, *self.points[case][-1].tolist()]


def thirds(values: Sequence[float]) -> list[int]:
    """Return the first, the middle and the last index of some values, each once."""
    return sorted({0, len(values) // 2, len(values) - 1})


Axis = tuple[str, float | str, float | str]  # path of a number, its lowest and its highest value


@with_options(MapOptions, **MAP_DEFAULTS, turns=60)
def basins(
    mechanism: Mechanism, x: Axis, y: Axis, *, count: int | tuple[int, int] = (16, 16),
    exponents: bool = True, companions: int = SAMPLE,
    **options: Unpack[MapOptions],
) -> Basins:  # fmt: skip
    """Find the motion to which each start of a grid leads.

    >>> basins(m, ("start.crank", 0, "90 deg"), ("start.C.x", "-0.1 mm", "0.1 mm")).plot()  # doctest: +SKIP

    mechanism: the mechanism
    x: (path, from, to) of the first axis: ``start.crank`` (rad, from the model's own start),
    ``start.JOINT.x`` and ``.y`` (m, the journal's centre relative to its bearing's), ``start.JOINT.vx`` and
    ``.vy`` (m/s), or any parameter of the model, such as ``joint.pin.clearance``
    y: the same of the second axis
    count: number of values of each axis, or one number for both
    exponents: True follows a small difference of each motion; without it, chaos is detected by the 0-1 test
    only, which needs 100 turns or more
    companions: number of cases that are repeated with 1.25 times and with half the step
    progress: ``progress(done, total)`` is called after each case
    confirm: True permits work of more than an hour
    turns: number of turns of each case (60)
    series: names of the recorded series, as in :func:`~vfife.bifurcation`
    step: time step, as in :func:`~vfife.bifurcation`
    file: stores what is computed; the same call continues it
    dropped: number of turns at the start that are not recorded, by default two thirds
    phase: share of a turn beyond the model's own start at which the series are recorded (1)

    Returns the motions; after Ctrl-C as far as they are computed. Cases with a journal outside its bearing
    have no start and are left out. Raises ModelError for a grid that cannot be computed and for all faults of
    the arguments or of the mechanism, HeldError if another process writes the file, AssemblyError for a
    mechanism that cannot be assembled, StepError for an unstable step and KeyboardInterrupt if Ctrl-C comes
    before the step is found.
    """
    arguments = Arguments("basins")
    arguments.mechanism(mechanism)
    axis_words = 'path and ends, as in ("start.crank", "0 deg", "90 deg")'
    axes: dict[str, Any] = {"x": x, "y": y}  # anything, in a script
    for name, axis in axes.items():
        if not isinstance(axis, list | tuple) or len(axis) != 3 or not isinstance(axis[0], str):
            arguments.fault(name, "this is no axis", axis, axis_words, "give three entries")
    counts = arguments.pair("count", count)
    arguments.count("companions", companions, optional=False, low=0)
    arguments.kind("exponents", exponents, (bool,), "True or False")
    arguments.check()
    run = TurnRun("basins", **options)
    paths, units = (x[0], y[0]), grid_units(mechanism, x[0], y[0])
    xs, ys = (
        values_between("basins", mechanism, path, ends, number)
        for (path, *ends), number in zip((x, y), counts, strict=True)
    )
    steps = run.step_count(models_along(mechanism, ((x[0], xs[0], xs[-1]), (y[0], ys[0], ys[-1]))))
    own_starts = StartStates(mechanism, steps)
    first = own_starts.at({})
    refuse_large_frame(first)
    start = TURNED_START if "start.crank" in paths else START
    work = run.work(
        "start", counts[0] * counts[1], steps, 4, companions=companions, growth=exponents, start=start,
        first_look=FIRST_LOOK, note=few_points(run.turns - run.dropped),
    )  # fmt: skip
    run.begin(work, first)
    series, _ = chosen_series(first, run.series)
    spec = BasinSpec(
        dump(mechanism),
        paths,
        units,
        xs,
        ys,
        run.turns,
        run.dropped,
        series,
        run.phase,
        steps,
        exponents,
        companions,
    )
    neighbours = neighbours_of(mechanism, first, steps) if exponents else None
    states = {steps: own_starts}

    def start_of(case: int, steps: int) -> Start:
        state = states.setdefault(steps, StartStates(mechanism, steps))
        return Start(case, partial(state.at, spec.numbers(case)), state.ahead(spec.numbers(case), run.phase))

    return follow_starts(run, mechanism.name, spec, start_of, neighbours)


def few_points(recorded: int) -> str:
    """Return what remains open with so few ``recorded`` turns of each start; empty for enough of them."""
    if recorded >= TEST_POINTS:
        return ""
    return (
        f"; with fewer than {TEST_POINTS} recorded turns of each start, here {recorded}, chaos beside other"
        f" motions is not decided: {3 * TEST_POINTS} turns record enough"
    )


def follow_starts(
    run: TurnRun,
    name: str,
    spec: BasinSpec,
    start_of: Callable[[int, int], Start],
    neighbours: Neighbours | None,
) -> Basins:
    """Simulate the starts of a grid that are not in the file yet, then a sample of them with other steps.

    ``start_of(case, steps)`` returns the start of a case with ``steps`` steps in a turn; ``neighbours``
    follow a small difference; None for none.
    """
    with run.rows(Basins, name, spec) as rows:
        legs, checked = rows.done, stored_companions(rows, spec)
        legs |= rows.legs(gaps=True)
        ranges = stored_ranges(rows, legs)
        for orbit, points in orbits(
            spec, neighbours, [start_of(case, spec.steps) for case in range(spec.count)], done=tuple(legs)
        ):
            legs[orbit.number] = points, orbit.growth
            if orbit.assembly is not None:
                ranges[orbit.number] = path_ranges(spec, orbit)
                rows.write("arrays", RANGE.format(orbit.number), ranges[orbit.number])
            rows.write("legs", orbit.number, points, orbit.growth, np.zeros(0))
            run.job.count(len(legs), spec.count, "starts")
        if not checked and spec.companions:
            cases = [case for case, (points, _) in sorted(legs.items()) if len(points)]
            checked += list(
                start_companions(
                    spec, [cases[k] for k in sampled(len(cases), spec.companions)], start_of, neighbours
                )
            )
            rows.write("arrays", COMPANION_POINTS, packed_points(checked))
            rows.write("arrays", COMPANIONS, packed(checked))
    return Basins.of(name, spec, legs, checked, ranges)


def stored_companions(rows: MapRows, spec: BasinSpec) -> list[Companion]:
    """Return the companions in a map file; those of former versions have no points."""
    return unpacked(rows.array(COMPANIONS), rows.array(COMPANION_POINTS), len(spec.series))


def stored_ranges(rows: MapRows, cases: Iterable[int]) -> dict[int, Array]:
    """Return the ranges of motions in a map file by case; those of former versions are not known."""
    ranges = ((case, rows.array(RANGE.format(case))) for case in cases)
    return {case: values.reshape(-1) for case, values in ranges if values is not None}


def grid_units(mechanism: Mechanism, x: str, y: str) -> tuple[str, str]:
    """Return the units of the numbers at the paths ``x`` and ``y``.

    Raises ModelError for a path that leads to no number, for equal paths, and for two velocities of one body.
    """
    units = unit_of_argument("x", mechanism, x), unit_of_argument("y", mechanism, y)
    if x == y:
        raise ModelError(
            [Fault("y", "x and y are the same number", x, "two numbers", "name another one")], mechanism.name
        )
    refuse_contradiction(mechanism, (x, y))
    return units
