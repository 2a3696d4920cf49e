"""The measures by which a run is judged, as a map of names to numbers: ``<joint or
body>.<quantity>.<statistic>``.

A *group* of measures is a function from a record and a window of its outputs to numbers by name.
:data:`OVER_TURN` lists the groups that are computed turn by turn, for the run and its companions,
:data:`OVER_RUN` those that are counted over the whole run. Each states the units of its measures and the
blocks of the state that it needs, so that a new measure is one function and one entry here. Static analyses
have their own (:mod:`~vfife.measures.statics`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any, TypeAlias

import numpy as np

from ..model.bodies import PointMass
from ..solvers.record import Record
from .contacts import knock_speeds, largest_pressures, largest_sliding, losses
from .elastic import largest_deflections, largest_stresses
from .energy import actuator_powers, driving, efficiency, largest_actuator_forces
from .forces import joint_force_max, joint_rows, largest_shaking, shares, shares_between
from .motion import largest_strokes
from .statics import static_measures
from .turns import Window, after_first, full_run, last_turn, named, of_turn
from .wear import wear_depths, wear_volumes

# An ideal maximum below this share of the largest of its kind is round-off, and a ratio to it means nothing.
NEGLIGIBLE = 1e-6
COUNTS = {
    "impacts": "onsets", "grazing": "grazing", "deep_landings": "deep", "landing_depth.max": "deepest",
    "approach_speed.max": "fastest"
}  # fmt: skip
IMPACT_SPEED = ".approach_speed.max"  # end of the name of a measure that is 0 without impacts
NO_IMPACT = "no impact"
SUMS = ("onsets", "grazing", "deep")  # of the rows of COUNTS: numbers of contacts since the start


def is_no_impact(name: str, value: float | None) -> bool:
    """Return whether a measure of a case is the largest impact speed of one without impacts: it is no speed,
    and no mean or median counts it as 0.
    """
    return value == 0.0 and name.endswith(IMPACT_SPEED)


@dataclass(frozen=True, eq=False)
class MeasureGroup:
    """Measures that one function computes.

    ``units``: unit of each by the ending of its name. ``needs``: blocks that a record must hold, or it has
    none of them.
    """

    compute: Callable[[Record, Window], dict[str, float]]
    units: Mapping[str, str]
    needs: tuple[str, ...] = ()

    def has(self, name: str) -> bool:
        """Return whether a measure of this name belongs to the group."""
        return name.endswith(tuple(f".{ending}" for ending in self.units))


Groups: TypeAlias = tuple[MeasureGroup, ...]

# ------------------------------------------------------------------------------ measures of recorded extremes


def largest_loads(record: Record, window: Window) -> dict[str, float]:
    """Return ``<joint>.force.max`` (N), and ``<joint>.moment.max`` (N m) of ideal joints that have one.

    sqrt(max(F_x^2 + F_y^2)) and max|M| over all steps of the window, not over its outputs only.
    """
    loads = named(joint_rows(record), {"force.max": joint_force_max(record)[window].max(axis=0)})
    moments = named(
        record.assembly.ideals, {"moment.max": record.block("joint_moment_max")[window].max(axis=0)}
    )
    return loads | {name: moment for name, moment in moments.items() if np.max(moment) > 0.0}


def deepest_penetrations(record: Record, window: Window) -> dict[str, float]:
    """Return ``<contact>.penetration.max`` (m): the largest penetration (Eq. 21 of the paper) over all steps
    of the window.
    """
    return named(
        record.assembly.contacts,
        {"penetration.max": record.block("contact_penetration_max")[window].max(axis=0)},
    )


def largest_accelerations(record: Record, window: Window) -> dict[str, float]:
    """Return ``<body>.angular_acceleration.max`` (rad/s^2) and ``<driven body>.torque.max`` (N m), largest
    sizes over all steps.
    """
    rotations, torques = (
        record.block(name)[window].max(axis=0) for name in ("body_alpha_max", "driven_torque_max")
    )
    values = {}
    for name, body in record.assembly.bodies.items():
        item = record.assembly.mechanism.bodies[name]
        if not (isinstance(item, PointMass) and item.inertia == 0.0):
            values[f"{name}.angular_acceleration.max"] = rotations[..., body.row].tolist()
        if body.driven is not None:
            values[f"{name}.torque.max"] = torques[..., body.driven].tolist()
    return values


def contact_counts(record: Record, window: Window) -> dict[str, float]:
    """Numbers of contacts of a whole run, and how it divides among the modes of Eq. 19 of the paper.

    ``<contact>.impacts``, ``.grazing``, ``.deep_landings`` (1), ``.landing_depth.max`` (m, penetration after
    the first step of a contact), ``.approach_speed.max`` (m/s), ``.share.free_flight``, ``.impact`` and
    ``.continuous_contact`` (1).
    """
    if not record.assembly.contacts:
        return {}
    counts = {
        name: record.last(f"contact_{row}") for name, row in COUNTS.items() if record.keeps(f"contact_{row}")
    }
    modes = {f"share.{mode}": values for mode, values in shares(record).items()}
    return named(record.assembly.contacts, counts | modes)


def last_counts(turns: Sequence[Record]) -> dict[str, float]:
    """Return the measures of :func:`contact_counts` over turns at the end of a run, records that begin with
    the output before each: without the contacts that began before.

    ``.landing_depth.max`` is that of the whole run, because the step keeps no landing by itself. Turns from
    the start of the run on have all its contacts.
    """
    first, last = turns[0], turns[-1]
    if len(turns) == 1:
        first = last = of_turn(last, last_turn(last))
    if first.steps[0] == 0 or not last.assembly.contacts:
        return over_run(last)
    parts = turns if len(turns) > 1 else [last]
    counts = {
        name: last.last(f"contact_{row}") - first.block(f"contact_{row}")[0]
        for name, row in COUNTS.items()
        if row in SUMS and last.keeps(f"contact_{row}")
    }
    if last.keeps("contact_fastest") and last.keeps("contact_approach"):
        counts["approach_speed.max"] = np.max([knock_speeds(part)[0] for part in parts], axis=0)
    modes = {f"share.{mode}": values for mode, values in shares_between(first, last).items()}
    return over_run(last) | named(last.assembly.contacts, counts | modes)


# -------------------------------------------------------------------------------------------------- the table

LOADS = MeasureGroup(largest_loads, {"force.max": "N", "moment.max": "N m"})
PENETRATIONS = MeasureGroup(deepest_penetrations, {"penetration.max": "m"})
ACCELERATIONS = MeasureGroup(
    largest_accelerations, {"angular_acceleration.max": "rad/s^2", "torque.max": "N m"}
)
LOSSES = MeasureGroup(
    losses,
    {
        "friction_energy.total": "J",
        "impact_energy.total": "J",
        "friction_power.mean": "W",
        "impact_power.mean": "W",
    },
    ("contact_friction_work",),
)
VOLUMES = MeasureGroup(wear_volumes, {"bearing_wear.total": "m^3", "journal_wear.total": "m^3"})
ACTUATORS = MeasureGroup(
    largest_actuator_forces,
    {"actuator_force.max": "N", "actuator_torque.max": "N m"},
    ("actuator_force_max",),
)
FORCES: Groups = (LOADS, ACCELERATIONS, ACTUATORS)  # the largest forces and torques of all steps
PEAKS: Groups = (LOADS, PENETRATIONS, ACCELERATIONS)  # extremes between outputs, by which a step is judged
OVER_TURN: Groups = (
    *PEAKS,
    MeasureGroup(
        driving,
        {
            "torque.mean": "N m", "torque.ripple": "1", "torque.rms": "N m", "energy_fluctuation": "J",
            "power.mean": "W",
        },
        ("driven_work", "particle_theta"),
    ),
    ACTUATORS,
    MeasureGroup(
        actuator_powers, {"actuator_power.mean": "W"}, ("actuator_work", "actuator_power", "particle_x")
    ),
    LOSSES,
    MeasureGroup(
        largest_sliding, {"sliding_velocity.max": "m/s", "sliding_distance.total": "m"}, ("particle_u",)
    ),
    MeasureGroup(
        largest_pressures,
        {
            "contact_pressure.max": "Pa", "contact_half_width.max": "m", "pressure_velocity.max": "W/m^2",
            "pressure_velocity.mean": "W/m^2",
        },
    ),
    MeasureGroup(
        largest_strokes,
        {"position.low": "m", "position.high": "m", "velocity.max": "m/s", "acceleration.max": "m/s^2"},
        ("particle_u",),
    ),
    MeasureGroup(largest_shaking, {"shaking_force.max": "N", "shaking_moment.max": "N m"}, ("particle_x",)),
    MeasureGroup(
        largest_stresses, {"tension.max": "Pa", "compression.max": "Pa", "stress.place": "m"},
        ("frame_axial_force",)
    ),
    MeasureGroup(largest_deflections, {"deflection.max": "m"}, ("frame_moment_1", "particle_x")),
    MeasureGroup(efficiency, {"efficiency": "1"}, ("driven_work", "particle_x")),
    VOLUMES,
    MeasureGroup(wear_depths, {"bearing_wear_depth.max": "m", "journal_wear_depth.max": "m"}, ("wear_x",)),
)  # fmt: skip
OVER_RUN: Groups = (
    MeasureGroup(
        contact_counts,
        {
            "impacts": "1", "grazing": "1", "deep_landings": "1", "landing_depth.max": "m",
            "approach_speed.max": "m/s",
            "share.free_flight": "1", "share.impact": "1", "share.continuous_contact": "1",
        },
    ),
)  # fmt: skip
# Groups for which one row a turn suffices: the largest of the extremes, and the sums at the end of the turn.
BY_TURN: Groups = (*PEAKS, LOSSES, VOLUMES)
NEGLIGIBLE_IDEAL = 1e-9  # of the largest of its kind: an ideal force or acceleration below it is rounding
CASE, LAST = "case", "last"  # over which contacts are counted: a whole case, or the turns of its measures
COUNTS_KEY = f'counts = "{LAST}"'  # of a study file
INFLUENCES = {"force.lip": "%", "angular_acceleration.lip": "%"}
INFLUENCE = tuple(f".{ending}" for ending in INFLUENCES)
COUNTED = tuple(f".{ending}" for group in OVER_RUN for ending in group.units)
DEEPEST = ".landing_depth.max"  # known of a whole run only
COUNTED_ENDINGS = frozenset(ending for group in OVER_RUN for ending in group.units)
UNITS = {
    ending: unit for group in (*OVER_TURN, *OVER_RUN) for ending, unit in group.units.items()
} | INFLUENCES


# Measures whose zero is where the model puts it, and channels of which this holds, with their units.
COORDINATES = (".position.low", ".position.high", ".stress.place")
COORDINATE_CHANNELS = {
    "x": "m", "y": "m", "position": "m", "angle": "rad", "theta": "rad", "contact_angle": "rad",
    "journal_contact_angle": "rad",
}  # fmt: skip


def is_reduction(measure: str) -> bool:
    """Return whether a measure is a statistic of a channel, as in ``max(C.force)``."""
    return measure.endswith(")")


def reduced_coordinate(measure: str) -> str:
    """Return the unit of a statistic of a position or an angle that moves with its zero, as
    ``max(rocker.angle)``, but not ``range(rocker.angle)``; "" for any other measure.
    """
    if not is_reduction(measure) or measure.startswith("range("):
        return ""
    return COORDINATE_CHANNELS.get(measure.removesuffix(")").rpartition(".")[2], "")


def is_coordinate(measure: str) -> bool:
    """Return whether the zero of a measure is arbitrary, as of positions and angles: a share of its value
    means nothing, only a difference.
    """
    return measure.endswith(COORDINATES) or bool(reduced_coordinate(measure))


def unit_of(measure: str) -> str:
    """Return the unit of a measure by its name: ``C.force.max``, or ``guide.1.penetration.max`` of one of
    several contacts of a joint.
    """
    if unit := reduced_coordinate(measure):
        return unit
    ending = measure.partition(".")[2]
    return UNITS.get(ending) or UNITS.get(ending.partition(".")[2], "1")


def differentiable(measure: str) -> bool:
    """Return whether measures of this name or pattern can have derivatives: any of them is computed turn by
    turn, not counted over the whole run, as knocks are.
    """
    tail = measure.partition(".")[2]
    tails = tail, tail.partition(".")[2]
    counted, by_turn = (
        any(fnmatchcase(ending, tail) for tail in tails for ending in endings)
        for endings in (COUNTED_ENDINGS, UNITS.keys() - COUNTED_ENDINGS)
    )
    return by_turn or not counted


# ------------------------------------------------------------------------------------------------- evaluation

SINGLE_OUTPUTS: Any = (
    None  # as a window: each output is one of its own, and the largest of it is a list of outputs
)


def measures(
    record: Record, reference: Mapping[str, float] | None = None, groups: Groups | None = None
) -> dict[str, float]:
    """Compute the measures of a run: largest values and sums over its last full crank turn, and counts of all
    of it.

    With the measures of a ``reference``, the ideal mechanism, also ``<joint>.force.lip`` and
    ``<body>.angular_acceleration.lip`` (per cent).
    """
    if record.static:
        return static_measures(record)
    values = over_turn(record, last_turn(record), groups)
    return values | compared(record, values, reference) | over_run(record)


def over_turn(record: Record, window: Window, groups: Groups | None = None) -> dict[str, float]:
    """Compute the measures of a turn, or those of some ``groups``; those that are not finite are left out."""
    values: dict[str, float] = {}
    for group in OVER_TURN if groups is None else groups:
        if all(record.keeps(block) for block in group.needs):
            values |= group.compute(record, window)
    return {name: value for name, value in values.items() if math.isfinite(value)}


def peaks_by_output(record: Record) -> list[dict[str, float]]:
    """Return the measures PEAKS of the steps up to each output."""
    columns: dict[str, Any] = {}
    for group in PEAKS:
        columns |= group.compute(record, SINGLE_OUTPUTS)
    # A mechanism has the moments that are not zero.
    return [
        {name: value for name, value in zip(columns, row, strict=True) if value or ".moment." not in name}
        for row in zip(*columns.values(), strict=True)
    ]


def over_run(record: Record) -> dict[str, float]:
    """Compute the measures of a whole run, up to its last output."""
    return over_turn(record, full_run(record), OVER_RUN)


def is_ideal_zero(value: float, values: Iterable[float | None]) -> bool:
    """Return whether a largest force or acceleration of the ideal mechanism is rounding beside ``values`` of
    its kind.
    """
    return 0.0 < value <= NEGLIGIBLE_IDEAL * max((abs(size or 0.0) for size in values), default=0.0)


def lip(largest: float, ideal: float) -> float:
    """Return the local influence parameter (max - ideal max)/ideal max * 100, in per cent: Eq. 38 for forces,
    Eq. 39 for accelerations.
    """
    return (largest - ideal) / ideal * 100.0


def influence(
    measures: Mapping[str, float], ideal: Mapping[str, float], driven: Iterable[str] = ()
) -> dict[str, float]:
    """Return ``<joint>.force.lip`` and ``<body>.angular_acceleration.lip`` (per cent) for what both
    mechanisms have.

    Driven bodies are left out, because their motion is prescribed, and so is what neither moves nor bears a
    load in the ideal mechanism.
    """
    driven_bodies, influences = set(driven), {}
    for quantity in ("force", "angular_acceleration"):
        ending = f".{quantity}.max"
        names = [key.removesuffix(ending) for key in measures if key.endswith(ending) and key in ideal]
        floor = NEGLIGIBLE * max((ideal[name + ending] for name in names), default=0.0)
        for name in names:
            if name not in driven_bodies and ideal[name + ending] > floor:
                influences[f"{name}.{quantity}.lip"] = lip(measures[name + ending], ideal[name + ending])
    return influences


def compared(
    record: Record, values: Mapping[str, float], reference: Mapping[str, float] | None
) -> dict[str, float]:
    """Return the local influence parameters of the measures of a turn against those of the ideal mechanism;
    none without any.
    """
    if reference is None:
        return {}
    return influence(
        values, reference, [body.name for body in record.assembly.bodies.values() if body.driven is not None]
    )


def of_full_runs(names: Sequence[str]) -> list[str]:
    """Return the names of measures of a whole run, which do not depend on the turns evaluated."""
    return [name for name in names if name.endswith(COUNTED) and "(" not in name]


def counted_from_start(names: Sequence[str], counts: str) -> list[str]:
    """Return the names of measures that include the start of a case; ``counts``: :data:`CASE` or
    :data:`LAST`.
    """
    return [name for name in of_full_runs(names) if counts == CASE or name.endswith(DEEPEST)]


def counts_of(measure: str) -> str:
    """Return over which turns a measure is counted that shall be of the machine: contacts over the last
    turns, without the fall of the journals onto their bearings with which a run starts.
    """
    return LAST if not differentiable(measure) and not counted_from_start([measure], LAST) else CASE


class RequestedMeasures:
    """Evaluation of the measures ``names`` over turns; all measures if empty. ``reduced`` computes further
    values from turns recorded output by output. ``counts``: contacts are counted over the whole
    :data:`CASE`, or over the :data:`LAST` turns that are evaluated.
    """

    def __init__(
        self,
        names: Sequence[str] = (),
        reduced: Callable[[Sequence[Record]], dict[str, float]] | None = None,
        counts: str = CASE,
    ) -> None:
        self.names, self.reduced = tuple(names), reduced
        self.of_last = counts == LAST
        self.peaks = not names or any(name.endswith(INFLUENCE) for name in names)
        self.counts = not names or any(name.endswith(COUNTED) for name in names)
        self.groups = tuple(
            group for group in OVER_TURN
            if not names or (self.peaks and group in PEAKS) or any(group.has(name) for name in names)
        )  # fmt: skip

    @property
    def by_turn(self) -> bool:
        """Whether one recorded row for each turn suffices: not for the speeds of knocks of some turns."""
        by_output = self.reduced is not None or (self.counts and self.of_last)
        return not by_output and set(self.groups) <= set(BY_TURN)

    def turn_ranges(self, turns: Sequence[Record], reference: Mapping[str, float] | None) -> dict[str, float]:
        """Return by how much each measure differs between single turns; counts of contacts are left out."""
        single = RequestedMeasures([name for name in self.names if not name.endswith(COUNTED)], self.reduced)
        if not single.names:
            return {}
        values = [single.turn_means([turn], reference) for turn in turns]
        names = [name for name in values[-1] if all(name in of_turn for of_turn in values)]
        series = {name: [of_turn[name] for of_turn in values] for name in names}
        return {name: max(column) - min(column) for name, column in series.items()}

    def turn_means(self, turns: Sequence[Record], reference: Mapping[str, float] | None) -> dict[str, float]:
        """Return the means over turns, each a record that begins with the output before it; counts up to the
        end of the last one.
        """
        each_turn = []
        for turn in turns:
            window = after_first(turn) if len(turns) > 1 else last_turn(turn)
            values_of_turn = over_turn(turn, window, self.groups)
            each_turn.append(
                values_of_turn | (compared(turn, values_of_turn, reference) if self.peaks else {})
            )
        mean: dict[str, float] = {}
        for name in each_turn[-1]:
            values = [turn[name] for turn in each_turn if name in turn]
            mean[name] = values[0] if len(values) == 1 else math.fsum(values) / len(values)
        if self.counts:
            mean |= last_counts(turns) if self.of_last else over_run(turns[-1])
        mean |= self.reduced(turns) if self.reduced is not None else {}
        return {name: mean[name] for name in self.names if name in mean} if self.names else mean
