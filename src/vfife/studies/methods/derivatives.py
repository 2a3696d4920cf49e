"""Derivatives of the measures of a run by the numbers of its model, from the tangents of its steps, judged by
finite changes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from statistics import fmean
from types import MappingProxyType

from ...assembly.assemble import assemble
from ...assembly.assembled import Assembly
from ...assembly.entities import Numbering
from ...assembly.timestep import size_of
from ...compiler.runtime.native import CONTACT_LANES
from ...errors import Fault, ModelError, VfifeError, suggestion
from ...job.amounts import counted
from ...job.cost import LANES, Forecast, cores, run_cost, timed
from ...job.job import job_of
from ...measures.catalogue import INFLUENCE, MOMENT, OVER_TURN, PEAKS, Measure, compared, last_turn, over_turn
from ...measures.ranges import over_tries, ranged
from ...model.mechanism import Mechanism
from ...modelfile import dump
from ...modelfile.parameter import numbers
from ...results.derivatives import Derivative, Sensitivity
from ...results.studied import UNITS, unit_of
from ...results.view import standing
from ...simulation.result import Result
from ...simulation.simulate import Prepared, carry_out, prepare
from ...solvers.arguments import Arguments
from ...solvers.companions import SENSITIVE
from ...solvers.ensemble import step_sizes
from ...solvers.record import Record
from ...solvers.status import Progress, Status
from ...solvers.tangents import Neighbours, Pairs, comparable, displaced, tangents
from ...solvers.transient import choose_loop, run
from ..spec.study_file import known_measures
from .finite_difference import (
    WIDE,
    Direction,
    LastTurn,
    Variants,
    compared_with_changes,
    finite_changes,
    ideal_references,
)

LARGEST = ("*.force.max", "*.torque.max", "*.angular_acceleration.max")
NOTHING = 1e-9  # per cent by one per cent: what rounding leaves of no dependence
NO_CHANGE = (
    1e-6  # per cent by one per cent: rounding of a finite change, 1e-9 of the measure over 1e-3 of the number
)
ROUNDING = 1e-9  # of the largest measure of its unit: below it a measure is what rounding leaves of nothing
PURE = "1", "%"
MOST_RUNS = 8  # that go side by side in the widest vector
TANGENT = 1.6  # time that derivatives by one number take, by that of a lane's own steps
SIZES = 2.8  # runs at the step and at 1.4, 1.7 and 2 times the step, in steps of the first
VARIANTS, CHANGES = (
    6,
    4.0,
)  # of a model by each number: two for its derivative and four finite changes, each at all step sizes
DISPLACED = 2  # runs with contact whose derivatives are compared, the run itself among them
Reference = Mapping[str, float] | None  # measures of the ideal mechanism


def sensitivity(
    mechanism: Mechanism,
    of: Sequence[str] | None = ("*",),
    to: Sequence[str] = ("*",),
    *,
    turns: float | None = None,
    duration: float | str | None = None,
    step: float | str | None = None,
    companions: int | str | None = None,
    runs: int | None = None,
    force_step: bool = False,
    progress: Callable[[Progress], None] | None = None,
    confirm: bool = False,
) -> Sensitivity:
    """How measures ``of`` a run depend on numbers of its model, ``to``: patterns of names and of paths,
    ``"*.force.max"``, ``"joint.C.*"``; of None: of the largest forces, torques and angular accelerations that
    there are.

    The run is that of :func:`~vfife.simulate` with these arguments; derivatives are of its measures over the
    last turn, at the steps that it took. Where an onset or a reversal of friction falls in its step is
    decided by the steps, and leaves each derivative an error of first order in them: with contact it is the
    mean over ``runs`` with displaced steps, two if nothing is said, with their range; without ``companions``,
    of the run alone. A number that the model has as zero is left out, and so are those that nothing depends
    on. Derivatives of a measure that the run's companions do not agree on mean nothing, and are marked. Those
    relative to the ideal mechanism take its own derivatives with them. ``confirm``: go on even where it takes
    more than an hour. Raises ModelError for patterns that fit nothing, VfifeError for a run that diverges,
    KeyboardInterrupt, and what simulate raises.
    """
    given = Arguments("sensitivity")
    given.mechanism(mechanism)
    asked_run = given.run(
        turns=turns,
        duration=duration,
        step=step,
        outputs=None,
        loop="auto",
        force_step=force_step,
        companions=companions,
    )
    if given.count("runs", runs) is not None and runs is not None and runs > MOST_RUNS:
        given.fault(
            "runs", "more than go side by side", runs, f"a whole number from 1 to {MOST_RUNS}", "give fewer"
        )
    given.check()
    refuse_unfit(mechanism, of or ())
    text = dump(mechanism)
    chosen = matching("to", to, numbers(mechanism))
    with job_of("sensitivity", None, confirm, progress) as job:
        prepared = prepare(mechanism, asked_run)
        job.begin(forecast(prepared, mechanism, sum(value != 0.0 for value in chosen.values()), runs))
        result = carry_out(prepared, progress=job)
    refuse_unended(result.record)
    record = result.record
    reference = None if result.reference is None else result.reference.measures
    window = last_turn(record)
    by_measure = {one: over_turn(record, window, (one,)) for one in OVER_TURN}
    values = {name: value for found in by_measure.values() for name, value in found.items()}
    values |= compared(record, values, reference)
    values = silent_moments(record.assembly, values) | values
    names = matching(
        "of", [one for one in LARGEST if fits(one, values)] or ["*"] if of is None else of, values
    )
    relative = any(name.endswith(INFLUENCE) for name in names)
    measures = (
        tuple(
            one for one in OVER_TURN if names.keys() & by_measure[one].keys() or (relative and one in PEAKS)
        )
        or PEAKS
    )
    variants = Variants(text, record.assembly)
    directions, refused = variants.directions(chosen)
    count = (
        runs
        if runs is not None and record.assembly.contacts
        else 1
        if record.companions is None
        else DISPLACED
    )
    derivatives = Differentiation(
        variants, result, tuple(names), LastTurn(measures), count, relative
    ).derivatives(directions)
    sizes = {name: max((size_of_change(one, name) for one in derivatives), default=0.0) for name in names}
    remainders = rounding(values, sizes, floors(record.assembly, values)) & names.keys()
    kept = {name: value for name, value in names.items() if name not in remainders}
    found = Sensitivity(
        mechanism.name, kept, derivatives, refused, doubtful(result, kept, measures), remainders
    )
    found.derivatives = [
        one
        for one in derivatives
        if any(matters(found, name, one.path) for name in kept if name in one.values)
    ]
    return found


def forecast(prepared: Prepared, mechanism: Mechanism, count: int, runs: int | None) -> Forecast:
    """The forecast of a run and of its derivatives by a ``count`` of numbers: steps with derivatives at all
    step sizes, and finite changes.
    """
    assembly, lanes = prepared.assembly, CONTACT_LANES
    alone = run_cost(assembly, companions=prepared.companions, measured=True)
    variant = timed(lambda: assemble(assembly.mechanism, assembly.choice.step, force_step=True))
    displaced = runs or DISPLACED if assembly.contacts else 1
    each = TANGENT * (displaced + SIZES - 1.0) + CHANGES * SIZES
    beside = each * count * LANES[lanes] / (lanes * cores())
    seconds = alone.seconds * (1.0 + beside) + VARIANTS * count * variant
    what = (
        f"a run of {assembly.choice.steps:,} steps and {counted(count, 'number')} by which it has derivatives"
    )
    work = f"{what}, each checked by finite changes"
    note = ", more where an automatic step is halved" if assembly.choice.automatic else ""
    less = "ask for fewer numbers (to) or turns"
    return Forecast(
        "run",
        1,
        alone.seconds,
        seconds,
        alone.memory,
        threads=cores(),
        lanes=lanes,
        work=work,
        less=less,
        note=note,
    )


def size_of_change(one: Derivative, name: str) -> float:
    """By how much of a measure (SI) all of a number would change it: the finite change where there is one, as
    a derivative may be meaningless.
    """
    return abs(one.value * one.changes.get(name, one.values.get(name, 0.0)))


def matters(found: Sensitivity, name: str, path: str) -> bool:
    """Whether a measure depends on a number at all."""
    has_change = name in next(one for one in found.derivatives if one.path == path).changes
    return abs(found.elasticity(name, path)) > NOTHING or (
        has_change and abs(found.change(name, path)) > NO_CHANGE
    )


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

    @property
    def ideal(self) -> Variants | None:
        """The ideal mechanism, where the measures need it."""
        if not self.relative or self.result.reference is None:
            return None
        return Variants(self.variants.text, self.result.reference.record.assembly, ideal=True)

    def derivatives(self, directions: list[Direction]) -> list[Derivative]:
        """Return the derivatives by each number: by the tangents of displaced runs and of other step sizes,
        judged by finite changes at all of these sizes.
        """
        base, reference = (
            self.variants.assembly,
            None if self.result.reference is None else self.result.reference.measures,
        )
        references = self.neighbour_references(directions)
        sizes = step_sizes(base)
        found: dict[str, Derivative] = {}
        slopes: dict[str, dict[str, list[float]]] = {}
        for k, size in enumerate(sizes):
            near = [
                one._replace(near=Neighbours(size.of(one.near.up), size.of(one.near.down), one.near.apart))
                for one in directions
            ]
            for direction, pairs in record_pairs(
                size.of(base), near if k else directions, self.measures, 1 if k else self.count
            ):
                quotients = self.quotients(
                    direction, pairs, references.get(direction.path, (reference, reference))
                )
                if direction.path not in found:
                    means = {name: fmean(values) for name, values in quotients.items()}
                    ranges = {name: (min(values), max(values)) for name, values in quotients.items()}
                    found[direction.path] = Derivative(
                        direction.path, direction.value, means, ranges, runs=len(pairs)
                    )
                for name, values in quotients.items():
                    slopes.setdefault(direction.path, {}).setdefault(name, []).extend(values)
        chosen = {one.path: one.value for one in directions}
        ideal = self.ideal
        ideals = {} if ideal is None else ideal_references(ideal, chosen, LastTurn(PEAKS))
        changes = finite_changes(self.variants, chosen, sizes, self.measures, reference, ideals)
        largest = {
            name: max(
                (
                    abs(central[0] * value)
                    for path, value in chosen.items()
                    if (central := changes.central(name, path, value, WIDE))
                ),
                default=0.0,
            )
            for name in self.names
        }
        return [
            compared_with_changes(found[one.path], slopes[one.path], changes, largest)
            for one in directions
            if one.path in slopes
        ]

    def neighbour_references(self, directions: Sequence[Direction]) -> dict[str, tuple[Reference, Reference]]:
        """Return the largest values of the ideal mechanism to both sides of each number that it has."""
        if (ideal := self.ideal) is None:
            return {}
        own = [
            Direction(one.path, one.value, ideal.neighbours(one.path, one.value))
            for one in directions
            if ideal.has(one.path, one.value)
        ]
        peaks = LastTurn(PEAKS)
        return {
            one.path: (peaks(pairs[0][0]), peaks(pairs[0][1]))
            for one, pairs in record_pairs(ideal.assembly, own, peaks, 1)
        }

    def quotients(
        self, direction: Direction, pairs: Pairs, references: tuple[Reference, Reference]
    ) -> dict[str, list[float]]:
        """Return the change of each measure between two records, over that of the number, for each displaced
        run.

        Where an onset or a reversal falls in its step adds an error of either sign, which a mean over places
        in the step takes off.
        """
        found: dict[str, list[float]] = {}
        for pair in pairs:
            up, down = (
                self.measures(record, reference) for record, reference in zip(pair, references, strict=True)
            )
            for name in self.names:
                if name in up and name in down:
                    found.setdefault(name, []).append((up[name] - down[name]) / direction.near.apart)
        return found


def record_pairs(
    assembly: Assembly, directions: list[Direction], measures: LastTurn, count: int
) -> Iterator[tuple[Direction, Pairs]]:
    """Yield the records to both sides of each number: by tangents, of a ``count`` of displaced runs; by two
    runs where functions of time have other pieces on both sides. Outputs are as few as the measures need.
    """
    smooth = [one for one in directions if comparable(assembly, one.near)]
    shares = displaced(count, assembly.mechanism.settings.parts)
    kept = measures.rows(assembly) if measures.extremes else None
    yield from zip(
        smooth,
        tangents(assembly, [one.near for one in smooth], shares, kept=kept, whole=measures.extremes),
        strict=True,
    )
    for one in directions:
        if one not in smooth:
            yield one, [(run(one.near.up), run(one.near.down))]


def silent_moments(assembly: Assembly, whole: Mapping[str, float]) -> dict[str, float]:
    """Moments that are exactly zero, which a run leaves out, of ideal joints that hold a turn.

    Whether such a moment is 0 or 1e-45 N m is decided by rounding, on which no answer may depend.
    """
    holders = [name for name, turn in zip(assembly.ideals, assembly.topology.joint_turn, strict=True) if turn]
    return {f"{one}{MOMENT}": 0.0 for one in holders if f"{one}{MOMENT}" not in whole}


def floors(assembly: Assembly, whole: Mapping[str, float]) -> dict[str, float]:
    """Scales of moments (N m) and angular accelerations (rad/s^2) that the largest force of a mechanism makes
    on its largest arm.

    Rounding of a force leaves that much, times the precision, of moments and of turning that are zero; the
    largest measure of the same unit may be such a remainder itself.
    """
    force = max((value for name, value in whole.items() if name.endswith(".force.max")), default=0.0)
    moment = force * size_of(assembly.mechanism)
    inertia = min((body.inertia for body in assembly.bodies.values() if body.inertia > 0.0), default=math.inf)
    return {"N m": moment, "rad/s^2": moment / inertia}


def rounding(
    measures: Mapping[str, float],
    changes: Mapping[str, float] = MappingProxyType({}),
    scales: Mapping[str, float] = MappingProxyType({}),
) -> frozenset[str]:
    """Measures that are what rounding leaves of nothing, beside the largest of their unit: forces beside
    forces, moments beside torques.

    ``changes``: by how much of a measure (SI) all of a number would change it, at the most; what crosses zero
    is no rounding. Influence is that of its measure; shares and counts have nothing to stand beside.
    ``scales`` are sizes by unit that are known otherwise (:func:`floors`).
    """
    sizes = {name: max(abs(value), changes.get(name, 0.0)) for name, value in measures.items()}
    units = {name: unit_of(name) for name in measures}
    largest = dict(scales)
    for name, size in sizes.items():
        largest[units[name]] = max(largest.get(units[name], 0.0), size)
    small = {
        name
        for name, size in sizes.items()
        if units[name] not in PURE and size <= ROUNDING * largest[units[name]]
    }
    return frozenset(
        small
        | {
            name
            for name in measures
            if name.endswith(INFLUENCE) and f"{name.removesuffix('lip')}max" in small
        }
    )


def refuse_unended(record: Record) -> None:
    """Raise KeyboardInterrupt for a run that was interrupted, VfifeError for one that did not complete."""
    if record.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    if record.status != Status.COMPLETE:
        what = f"the run ended as {record.status} after step {record.reached}"
        raise VfifeError(f"{what}, so it has no derivatives; see vfife run")


def refuse_unfit(mechanism: Mechanism, of: Sequence[str]) -> None:
    """Raises ModelError for a mechanism whose steps have no derivatives, and for measures that no run of it
    can have, before there is one.
    """
    if mechanism.settings.analysis == "static":
        what, remedy = (
            "a static analysis has no steps that carry derivatives along",
            "vary the number with vfife study instead",
        )
        raise ModelError([Fault("run.analysis", what, "static", "dynamic", remedy)], mechanism.name)
    odd = [one for one in of if not fits(one.partition(".")[2], UNITS)]
    if not odd and not Numbering(mechanism).elements:
        return
    assembly = assemble(mechanism)
    if choose_loop(assembly, "auto") != "generated":
        elements = len(assembly.topology.frame_nodes)
        what = (
            f"its {elements} elements are stepped by the data-driven loop, which carries no derivatives along"
        )
        raise ModelError(
            [Fault("body", what, "", "", "use fewer elements, or vary the number with vfife study")],
            mechanism.name,
        )
    matching("of", odd, dict.fromkeys(known_measures(standing(assembly)), 0.0))


def fits(pattern: str, known: Iterable[str]) -> bool:
    """Whether a pattern fits any name."""
    return any(fnmatchcase(one, pattern) for one in known)


def matching(name: str, patterns: Sequence[str], known: dict[str, float]) -> dict[str, float]:
    """Those that fit any pattern. Raises ModelError with each pattern that fits none."""
    faults = [
        Fault(
            f"{name} {pattern!r}",
            "fits nothing that this model has",
            "",
            "",
            suggestion(pattern, known, "* stands for any characters"),
        )
        for pattern in patterns
        if not fits(pattern, known)
    ]
    if faults:
        raise ModelError(faults, "sensitivity")
    return {
        one: value for one, value in known.items() if any(fnmatchcase(one, pattern) for pattern in patterns)
    }


def doubtful(result: Result, names: Iterable[str], measures: tuple[Measure, ...]) -> frozenset[str]:
    """Measures whose companions lie apart by more than a run may that is not sensitive: their derivatives
    mean nothing.
    """
    ideal = None if result.reference is None else result.reference.measures
    found = (ranged if result.record.companions is None else over_tries)(result.record, ideal, measures)
    return frozenset(
        name
        for name in names
        if name in found
        and found[name].high - found[name].low > SENSITIVE * max(abs(found[name].value), 1e-300)
    )
