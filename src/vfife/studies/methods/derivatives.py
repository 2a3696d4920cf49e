"""Derivatives of the measures of a run by the numbers of its model, from the tangents of its steps, judged by
finite changes.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from types import MappingProxyType
from typing import Unpack

from ...assembly.assemble import assemble
from ...assembly.assembled import Assembly
from ...compiler.runtime.native import CONTACT_LANES
from ...job.cost import LANES, MOST_TRIES, TANGENTS, Forecast, cores, run_cost, timed
from ...job.job import Interrupted, Job, job_of
from ...job.progress import counted
from ...measures.catalogue import INFLUENCE, OVER_TURN, PEAKS, compared, over_turn
from ...measures.landings import start_fall
from ...measures.repetition import part_of
from ...measures.turns import last_turn
from ...model.mechanism import Mechanism
from ...modelfile import dump
from ...modelfile.parameter import numbers
from ...options import Length, Watch, with_options
from ...results.derivatives import Derivative, Sensitivity
from ...simulation.result import Result
from ...simulation.simulate import Prepared, prepare, run_prepared
from ...solvers.arguments import Arguments
from ...solvers.ensemble import step_sizes
from ...solvers.status import Status
from ...solvers.tangents import Pairs, comparable, displaced, pass_size, tangents
from ...solvers.transient import run
from .derivable import doubtful, fits, matching, refuse_unended, refuse_unfit, undetermined
from .finite_difference import (
    SHARES,
    Direction,
    LastTurn,
    Variants,
    compared_with_changes,
    finite_changes,
    ideal_references,
    is_guess,
)
from .rounding import floors, rounding, silent_moments
from .turn_numbers import without_turn_numbers

LARGEST = ("*.force.max", "*.torque.max", "*.angular_acceleration.max")
ROUNDING_ELASTICITY = 1e-9  # per cent by one per cent: what rounding leaves of no dependence
# Per cent for one per cent: rounding of a finite change, 1e-9 of the measure over 1e-3 of the number.
NO_CHANGE = 1e-6
GUESS = "a starting guess: joints and drivers place the body"
ALL_PATHS = ("*",)  # the default of the numbers by which measures are differentiated
POINT_OF = re.compile(r"\.\d+(?:\.|$)")  # the place of a number in a list
LIST_NUMBERS = 4  # numbers of a list that is no table: the places of two pins
MOST_RUNS = 8  # that go side by side in the widest vector
TANGENT = 1.6  # time that derivatives by one number take, by that of a lane's own steps
HALVED_TWICE = 4.0  # steps of a run whose automatic step is halved twice
SIZES = 2.8  # runs at the step and at 1.4, 1.7 and 2 times the step, in steps of the first
# Variants of a model by each number: two for its derivative and four finite changes, each at all step sizes.
VARIANTS, CHANGES = 6, 4.0
DISPLACED = 2  # runs with contact whose derivatives are compared, the run itself among them
NO_REASONS: Mapping[str, str] = MappingProxyType({})
Reference = Mapping[str, float] | None  # measures of the ideal mechanism


class SensitivityOptions(Length, Watch, total=False):
    """Keywords of :func:`sensitivity`."""

    runs: int | None  # with displaced steps, whose mean a derivative with contact is


@with_options(SensitivityOptions, force_step=False, confirm=False)
def sensitivity(
    mechanism: Mechanism,
    of: Sequence[str] | None = ("*",),
    to: Sequence[str] = ("*",),
    **options: Unpack[SensitivityOptions],
) -> Sensitivity:
    """Differentiate measures of a run by numbers of its model.

    mechanism: the mechanism
    of: patterns of names of measures, as ``"*.force.max"``; of None: the largest forces, torques and angular
    accelerations
    to: patterns of paths of numbers, as ``"joint.C.*"``; by default all but the points of tables
    turns, duration, step, force_step: the run, as of :func:`~vfife.simulate`; its measures are of the last
    turn, or of the whole run if no crank turns at constant speed. With a duration there are no derivatives by
    numbers that change the time of a turn
    companions: as of :func:`~vfife.simulate`; with 0 the derivatives are those of the run alone
    runs: number of runs with displaced steps over which derivatives are averaged with contact, two by default
    progress: called with the progress of the run and of the derivatives
    confirm: True goes on even if it takes more than an hour

    The place of an onset or of a reversal of friction within its step leaves each derivative an error of
    first order in the step: with contact the derivative is therefore a mean over displaced runs, with their
    range. Numbers that are zero in the model, and those that nothing depends on, are left out. Derivatives of
    a measure on which the companions of the run disagree mean nothing, and are marked; if they disagree on
    every measure, no derivative is computed. Measures relative to the ideal mechanism take its derivatives
    into account.

    Returns the derivatives and elasticities. Raises ModelError for patterns that fit nothing, VfifeError for
    a run that diverges, :class:`~vfife.Interrupted` on Ctrl-C, with the derivatives so far, unchecked, and
    what simulate raises.
    """
    arguments, runs = Arguments("sensitivity"), options["runs"]
    arguments.mechanism(mechanism)
    of = None if of is None else arguments.names("of", of, minimum=1)
    to = arguments.names("to", to, minimum=1)
    run_arguments = arguments.run(**{name: options.get(name) for name in Length.__annotations__})
    if arguments.count("runs", runs) is not None and runs is not None and runs > MOST_RUNS:
        limit = f"a whole number from 1 to {MOST_RUNS}"
        arguments.fault("runs", "more than go side by side", runs, limit, "give fewer")
    arguments.check()
    refuse_unfit(mechanism, of or ())
    model_numbers = numbers(mechanism)
    chosen = without_points(model_numbers) if tuple(to) == ALL_PATHS else matching("to", to, model_numbers)
    chosen, refused = without_turn_numbers(run_arguments.in_settings(mechanism), chosen)
    count = sum(value != 0.0 for value in chosen.values())
    with job_of("sensitivity", None, options["confirm"], options["progress"]) as job:
        prepared = prepare(mechanism, run_arguments)
        job.begin(forecast(prepared, mechanism, count, runs))
        result = run_prepared(prepared, progress=job)
        if result.record.status == Status.INTERRUPTED:
            part = part_of(result.record, None)
            raise Interrupted(Sensitivity(mechanism.name, {}, part=part, complete=False))
        refuse_unended(result.record)
        assembly = result.record.assembly
        if assembly.choice.steps > prepared.assembly.choice.steps:  # derivatives take as many steps more
            longer = forecast(dataclasses.replace(prepared, assembly=assembly), mechanism, count, runs)
            # The step of the run is found: it is halved no more.
            seconds = longer.seconds if longer.ends is None else longer.ends[0]
            job.begin(dataclasses.replace(longer, seconds=seconds, note="", ends=None))
        return differentiate(dump(mechanism), result, of, chosen, runs, job, refused)


def without_points(values: Mapping[str, float]) -> dict[str, float]:
    """Return the numbers of a model without the points of its tables: lists of more than a few numbers."""
    lists = {path: POINT_OF.split(path)[0] for path in values}
    sizes = Counter(lists.values())
    return {path: value for path, value in values.items() if sizes[lists[path]] <= LIST_NUMBERS}


def differentiate(
    text: str,
    result: Result,
    of: Sequence[str] | None,
    chosen: Mapping[str, float],
    runs: int | None,
    job: Job | None = None,
    refused: Mapping[str, str] = NO_REASONS,
) -> Sensitivity:
    """Differentiate the measures of a run that fit the patterns ``of`` by the numbers ``chosen`` of its
    model; ``job`` shows the progress; ``refused`` are other numbers, with the reasons why.
    """
    record = result.record
    reference = None if result.reference is None else result.reference.measures
    window = last_turn(record)
    by_measure = {group: over_turn(record, window, (group,)) for group in OVER_TURN}
    values = {name: value for part in by_measure.values() for name, value in part.items()}
    values |= compared(record, values, reference)
    values = silent_moments(record.assembly, values) | values
    patterns = [pattern for pattern in LARGEST if fits(pattern, values)] or ["*"] if of is None else of
    names = matching("of", patterns, values)
    relative = any(name.endswith(INFLUENCE) for name in names)
    needed = (
        group
        for group in OVER_TURN
        if names.keys() & by_measure[group].keys() or (relative and group in PEAKS)
    )
    measures = tuple(needed) or PEAKS
    fall = start_fall(record, reference or {}, result.motion)
    if (answer := undetermined(result, values, names, measures)) is not None:
        return dataclasses.replace(answer, refused=refused, fall=fall)
    variants = Variants(text, record.assembly)
    directions, without_neighbours = variants.directions(chosen)
    refused = {**refused, **without_neighbours}
    refused |= {direction.path: GUESS for direction in directions if is_guess(direction)}
    directions = [direction for direction in directions if direction.path not in refused]
    count = 1 if record.companions is None else DISPLACED
    if runs is not None and record.assembly.contacts:
        count = runs
    task = Differentiation(variants, result, tuple(names), LastTurn(measures), count, relative, job)
    try:
        derivatives, complete = task.derivatives(directions), True
    except Interrupted as interrupted:
        derivatives, complete = interrupted.result, False
    sizes = {
        name: max((size_of_change(derivative, name) for derivative in derivatives), default=0.0)
        for name in names
    }
    remainders = rounding(values, sizes, floors(record.assembly, values)) & names.keys()
    significant = {name: value for name, value in names.items() if name not in remainders}
    unsure, part = doubtful(result, significant, measures), part_of(record, None)
    mechanism = record.assembly.mechanism.name
    answer = Sensitivity(
        mechanism, significant, derivatives, refused, unsure, remainders, part, complete, fall
    )
    answer.derivatives = [
        derivative
        for derivative in derivatives
        if any(matters(answer, name, derivative.path) for name in derivative.values if name in significant)
    ]
    if not complete:
        raise Interrupted(answer)
    return answer


def forecast(prepared: Prepared, mechanism: Mechanism, count: int, runs: int | None) -> Forecast:
    """Forecast a run and its derivatives by a ``count`` of numbers: tangents and finite changes at all step
    sizes.
    """
    assembly, lanes = prepared.assembly, CONTACT_LANES
    single_run = run_cost(assembly, companions=prepared.companions, measured=True)
    variant = timed(lambda: assemble(assembly.mechanism, assembly.choice.step, force_step=True))
    displaced = runs or DISPLACED if assembly.contacts else 1
    equivalent_runs = tangent_runs(count, displaced) + (SIZES - 1.0) * tangent_runs(count, 1)
    equivalent_runs += CHANGES * SIZES * count * LANES[lanes] / (lanes * cores())
    seconds = single_run.seconds + single_run.stepping * equivalent_runs + VARIANTS * count * variant
    steps, varied = f"{assembly.choice.steps:,} steps", counted(count, "number")
    work = f"a run of {steps} with derivatives by {varied}, each checked by finite changes"
    longest = MOST_TRIES * single_run.seconds + HALVED_TWICE * (seconds - single_run.seconds)
    remedy = "ask for fewer numbers (to) or turns"
    first = Forecast(
        "run", 1, single_run.seconds, seconds, single_run.memory, threads=cores(), lanes=lanes, work=work,
        remedy=remedy,
    )  # fmt: skip
    return first.with_ends(seconds, longest) if assembly.choice.automatic else first


def tangent_runs(count: int, displaced_runs: int) -> float:
    """Return the time of derivatives by a ``count`` of numbers on all cores, by that of a run in one lane.
    Passes take whole lanes, so one number costs as much as several.
    """
    lanes, size, directions = pass_size(count, displaced_runs)
    passes = math.ceil(count / size)
    pass_cost = LANES[CONTACT_LANES] + directions * (TANGENTS[CONTACT_LANES] - LANES[CONTACT_LANES])
    return math.ceil(passes / cores()) * pass_cost * lanes / CONTACT_LANES


def size_of_change(derivative: Derivative, name: str) -> float:
    """Return the change of a measure (SI) by 100 % of a number: by the finite change where there is one, as a
    derivative may be meaningless.
    """
    return abs(derivative.value * derivative.changes.get(name, derivative.values.get(name, 0.0)))


def matters(answer: Sensitivity, name: str, path: str) -> bool:
    """Return whether a measure depends on a number at all."""
    has_change = (
        name in next(derivative for derivative in answer.derivatives if derivative.path == path).changes
    )
    if has_change and abs(answer.change(name, path)) > NO_CHANGE:
        return True
    return abs(answer.elasticity(name, path)) > ROUNDING_ELASTICITY


@dataclass(frozen=True)
class Differentiation:
    """Derivatives of the measures ``names`` of a run's last turn, as means over a ``count`` of displaced
    runs.

    ``relative``: some of the measures are relative to the ideal mechanism.
    """

    variants: Variants
    result: Result
    names: Sequence[str]
    measures: LastTurn
    count: int
    relative: bool
    job: Job | None = None

    @property
    def reference(self) -> Reference:
        """Measures of the ideal mechanism, where it was run."""
        return None if self.result.reference is None else self.result.reference.measures

    @property
    def ideal(self) -> Variants | None:
        """The ideal mechanism, where the measures need it."""
        if not self.relative or self.result.reference is None:
            return None
        return Variants(self.variants.text, self.result.reference.record.assembly, ideal=True)

    def derivatives(self, directions: list[Direction]) -> list[Derivative]:
        """Return the derivatives by each number: by the tangents of displaced runs and of other step sizes,
        judged by finite changes at all of these sizes. Raises Interrupted on Ctrl-C, with the derivatives of
        displaced runs that are there.
        """
        unchecked: dict[str, Derivative] = {}
        try:
            return self.checked_derivatives(directions, unchecked)
        except KeyboardInterrupt:
            raise Interrupted(list(unchecked.values())) from None

    def checked_derivatives(
        self, directions: list[Direction], unchecked: dict[str, Derivative]
    ) -> list[Derivative]:
        """Return the derivatives by each number; ``unchecked`` takes those of displaced runs as they come."""
        base, chosen, reference = (
            self.variants.assembly,
            {direction.path: direction.value for direction in directions},
            self.reference,
        )
        references, sizes = self.neighbour_references(directions), step_sizes(base)
        tangent_runs = len(sizes) * len(directions)

        def report(done: int, changed: int) -> None:
            if self.job is not None:
                self.job.count(done, tangent_runs + changed, "runs")

        slopes: dict[str, dict[str, list[float]]] = {}  # by path and measure, of all displaced runs and sizes
        for k, size in enumerate(sizes):
            report(k * len(directions), (1 + len(SHARES) * len(chosen)) * len(sizes))
            resized = [direction.with_size(size) for direction in directions] if k else directions
            for direction, pairs in record_pairs(
                size.of(base), resized, self.measures, 1 if k else self.count
            ):
                quotients = self.quotients(
                    direction, pairs, references.get(direction.path, (reference, reference))
                )
                if direction.path not in unchecked:
                    means = {name: fmean(values) for name, values in quotients.items()}
                    ranges = {name: (min(values), max(values)) for name, values in quotients.items()}
                    unchecked[direction.path] = Derivative(
                        direction.path, direction.value, means, ranges, runs=len(pairs)
                    )
                for name, values in quotients.items():
                    slopes.setdefault(direction.path, {}).setdefault(name, []).extend(values)
        ideals = {} if self.ideal is None else ideal_references(self.ideal, chosen, LastTurn(PEAKS))
        changes = finite_changes(
            self.variants, chosen, sizes, self.measures, reference, ideals,
            lambda done, total: report(tangent_runs + done, total),
        )  # fmt: skip
        largest = {name: changes.largest(name, chosen) for name in self.names}
        return [
            compared_with_changes(unchecked[path], slopes[path], changes, largest)
            for path in chosen
            if path in slopes
        ]

    def neighbour_references(self, directions: Sequence[Direction]) -> dict[str, tuple[Reference, Reference]]:
        """Return the largest values of the ideal mechanism to both sides of each number that it has."""
        if (ideal := self.ideal) is None:
            return {}
        peaks, common = (
            LastTurn(PEAKS),
            [direction for direction in directions if ideal.has(direction.path, direction.value)],
        )
        ideal_directions = [
            direction._replace(neighbours=ideal.neighbours(direction.path, direction.value))
            for direction in common
        ]
        pairs = record_pairs(ideal.assembly, ideal_directions, peaks, 1)
        return {direction.path: (peaks(up), peaks(down)) for direction, ((up, down),) in pairs}

    def quotients(
        self, direction: Direction, pairs: Pairs, references: tuple[Reference, Reference]
    ) -> dict[str, list[float]]:
        """Return the change of each measure between two records, over that of the number, for each displaced
        run.

        Where an onset or a reversal falls in its step adds an error of either sign, which a mean over places
        in the step takes off.
        """
        quotients: dict[str, list[float]] = {}
        for pair in pairs:
            up, down = (self.measures(*side) for side in zip(pair, references, strict=True))
            for name in self.names:
                if name in up and name in down:
                    quotients.setdefault(name, []).append(
                        (up[name] - down[name]) / direction.neighbours.distance
                    )
        return quotients


def record_pairs(
    assembly: Assembly, directions: list[Direction], measures: LastTurn, count: int
) -> Iterator[tuple[Direction, Pairs]]:
    """Yield the records to both sides of each number: by tangents, of a ``count`` of displaced runs; by two
    runs where functions of time have other pieces on both sides. Outputs are as few as the measures need.
    """
    smooth = [direction for direction in directions if comparable(assembly, direction.neighbours)]
    shares = displaced(count, assembly.mechanism.settings.parts)
    rows = measures.rows(assembly) if measures.extremes else None
    yield from zip(
        smooth,
        tangents(
            assembly,
            [direction.neighbours for direction in smooth],
            shares,
            recorded=rows,
            last_turn=measures.extremes,
        ),
        strict=True,
    )
    for direction in directions:
        if direction not in smooth:
            yield direction, [(run(direction.neighbours.up), run(direction.neighbours.down))]
