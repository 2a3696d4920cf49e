"""The numbers a run is judged by, as one flat map of names to floats:
``<joint or body>.<quantity>.<statistic>``.

A measure is a function from a record and a window, a choice of its outputs, to numbers by name. Those of a
turn are taken turn by turn, of the run and of its companions; those of a run are counted over all of it;
those of a static analysis are the largest over its load factors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..model.bodies import PointMass
from ..numerics.elementwise import hypot
from ..solvers.record import Record
from .contacts import largest_pressures, largest_sliding, losses
from .elastic import largest_deflections, largest_stresses
from .energy import driving, efficiency
from .forces import joint_force, joint_force_max, joint_moment, joint_rows, shares
from .ground import largest_shaking
from .guides import largest_strokes
from .motion import is_free, times
from .wear import worn_depths, worn_volumes

# an ideal maximum this small beside the largest of its kind is round-off or nothing, and no share of it says
# anything
NEGLIGIBLE = 1e-6


def lip(largest: float, ideal: float) -> float:
    """(max - ideal max)/ideal max * 100, in per cent: Eq. 38 for forces, Eq. 39 for accelerations."""
    return (largest - ideal) / ideal * 100.0


def influence(
    own: Mapping[str, float], ideal: Mapping[str, float], driven: Iterable[str] = ()
) -> dict[str, float]:
    """``<joint>.force.lip`` and ``<body>.angular_acceleration.lip`` (per cent) for what both mechanisms have.

    Driven bodies are left out, their motion is prescribed; so is what does not move or carry anything in the
    ideal mechanism.
    """
    prescribed = set(driven)
    found = {}
    for kind in ("force", "angular_acceleration"):
        ending = f".{kind}.max"
        names = [key.removesuffix(ending) for key in own if key.endswith(ending) and key in ideal]
        floor = NEGLIGIBLE * max((ideal[name + ending] for name in names), default=0.0)
        for name in names:
            if name not in prescribed and ideal[name + ending] > floor:
                found[f"{name}.{kind}.lip"] = lip(own[name + ending], ideal[name + ending])
    return found


Array = NDArray[np.float64]


def displacement(record: Record) -> Array:
    """Largest way of a free particle from its start (m), shape (outputs,)."""
    free = is_free(record)
    x, y = (
        record.block(f"particle_{axis}") - record.assembly.state[record.assembly.layout[f"particle_{axis}"]]
        for axis in ("x", "y")
    )
    return np.asarray(hypot(x, y)[:, free].max(axis=1, initial=0.0), dtype=float)


def equilibria(record: Record) -> list[dict[str, Any]]:
    """For each output: load factor, iterations, unbalanced force over the largest, displacement (m), reaction
    of each joint (N, N, N m).
    """
    moved, force, moment = displacement(record), joint_force(record), joint_moment(record)
    found = []
    for k, factor in enumerate(times(record)):
        reactions = {
            name: {
                "force_x": float(force[k, j, 0]),
                "force_y": float(force[k, j, 1]),
                "moment": float(moment[k, j]),
            }
            for j, name in enumerate(joint_rows(record))
        }
        found.append(
            {
                "load_factor": float(factor),
                "iterations": int(record.block("iterations")[k, 0]),
                "unbalanced": float(record.block("unbalanced")[k, 0]),
                "displacement": float(moved[k]),
                "reactions": reactions,
            }
        )
    return found


def static_measures(record: Record) -> dict[str, float]:
    """Largest absolute values over all load factors.

    ``displacement.max`` (m), ``<joint>.force.max`` (N), ``<joint>.moment.max`` (N m),
    ``<joint>.penetration.max`` (m), ``<driven body>.torque.max`` (N m), ``iterations`` of all factors,
    ``unbalanced.max`` (1), and the last ``load_factor`` that was reached.
    """
    found = {
        "load_factor": float(times(record)[-1]),
        "displacement.max": float(displacement(record).max()),
        "iterations": float(record.block("iterations").sum()),
        "unbalanced.max": float(record.block("unbalanced").max()),
    }
    force, moment = joint_force(record), np.abs(joint_moment(record))
    for k, name in enumerate(joint_rows(record)):
        found[f"{name}.force.max"] = float(hypot(force[:, k, 0], force[:, k, 1]).max())
        if moment[:, k].any():
            found[f"{name}.moment.max"] = float(moment[:, k].max())
    for k, name in enumerate(record.assembly.contacts):
        found[f"{name}.penetration.max"] = float(record.block("contact_penetration")[:, k].max())
    for body in record.assembly.bodies.values():
        if body.driven is not None:
            found[f"{body.name}.torque.max"] = float(
                np.abs(record.block("driven_torque")[:, body.driven]).max()
            )
    return {name: value for name, value in found.items() if math.isfinite(value)}


Window: TypeAlias = NDArray[np.bool_]
Measure: TypeAlias = Callable[[Record, Window], dict[str, float]]
Values: TypeAlias = NDArray[np.float64]
MOMENT = ".moment.max"
COUNTS = {
    "impacts": "onsets", "grazing": "grazing", "deep_landings": "deep", "landing_depth.max": "deepest", "approach_speed.max": "fastest"
}  # fmt: skip


def last_turn(record: Record) -> Window:
    """Outputs whose intervals make up the last full crank turn, shape (outputs,): the turn that ends with the
    run.

    All outputs where there is no crank, or where the run is shorter than a turn.
    """
    turn = record.assembly.choice.turn
    steps = record.steps
    if turn is None or len(steps) < 2:
        return np.ones(len(steps), dtype=bool)
    begin = steps[-1] - turn / record.assembly.choice.step
    if begin < -0.5:
        return np.ones(len(steps), dtype=bool)
    chosen = np.zeros(len(steps), dtype=bool)
    chosen[1:] = steps[:-1] > begin - 0.5
    return chosen


def measures(
    record: Record, reference: Mapping[str, float] | None = None, every: tuple[Measure, ...] | None = None
) -> dict[str, float]:
    """Largest absolute values over the last full crank turn, from the extremes within the output intervals;
    counts of the whole run.

    ``<joint>.force.max`` (N), ``<joint>.moment.max`` (N m; of sliders, welds, gears and drivers),
    ``<joint>.penetration.max`` (m), ``<body>.angular_acceleration.max`` (rad/s^2),
    ``<driven body>.torque.max`` (N m); of the whole run ``<joint>.impacts``, ``.grazing``, ``.deep_landings``
    (1), ``<joint>.landing_depth.max`` (m), ``.approach_speed.max`` (m/s), ``<joint>.share.free_flight``,
    ``.impact``, ``.continuous_contact`` (1); with the measures of a ``reference`` also ``<joint>.force.lip``
    and ``<body>.angular_acceleration.lip`` (per cent).
    """
    if record.static:
        return static_measures(record)
    found = over_turn(record, last_turn(record), every)
    return found | compared(record, found, reference) | over_run(record)


def over_turn(record: Record, window: Window, every: tuple[Measure, ...] | None = None) -> dict[str, float]:
    """The measures of a turn, or ``every`` one of some of them."""
    return taken(OVER_TURN if every is None else every, record, window)


def over_run(record: Record) -> dict[str, float]:
    """The measures of a whole run, up to its last output."""
    return taken(OVER_RUN, record, np.ones(len(record.steps), dtype=bool))


def taken(every: tuple[Measure, ...], record: Record, window: Window) -> dict[str, float]:
    """Measures over a window; what is not finite is left out."""
    found: dict[str, float] = {}
    for measure in every:
        found |= measure(record, window)
    return {name: value for name, value in found.items() if math.isfinite(value)}


def compared(
    record: Record, found: Mapping[str, float], reference: Mapping[str, float] | None
) -> dict[str, float]:
    """Local influence parameters of measures of a turn against those of the ideal mechanism; nothing without
    any.
    """
    if reference is None:
        return {}
    driven = [body.name for body in record.assembly.bodies.values() if body.driven is not None]
    return influence(found, reference, driven)


def largest_loads(record: Record, window: Window) -> dict[str, float]:
    """Largest force of each joint (N), and largest moment (N m) of those that have one."""
    return highest(loads(record), window)


def deepest_penetrations(record: Record, window: Window) -> dict[str, float]:
    """Deepest penetration of each contact (m)."""
    return highest(depths(record), window)


def largest_accelerations(record: Record, window: Window) -> dict[str, float]:
    """Largest angular acceleration of each body (rad/s^2), and largest torque of each driver (N m)."""
    return highest(turnings(record), window)


def highest(every: Mapping[str, Values], window: Window) -> dict[str, float]:
    """The largest within a window of what stands in the rows of a record; a moment of nothing is none."""
    found = {name: float(values[window].max()) for name, values in every.items()}
    return {name: value for name, value in found.items() if value > 0.0 or not name.endswith(MOMENT)}


def loads(record: Record) -> dict[str, Values]:
    """Largest force of each joint (N) and moment of each ideal one (N m) up to each output, shape (outputs,)."""
    forces, found = joint_force_max(record), {}
    for k, name in enumerate(joint_rows(record)):
        found[f"{name}.force.max"] = forces[:, k]
    if record.assembly.ideals:
        moments = record.block("joint_moment_max")
        found |= {f"{name}{MOMENT}": moments[:, k] for k, name in enumerate(record.assembly.ideals)}
    return found


def depths(record: Record) -> dict[str, Values]:
    """Deepest penetration of each contact (m) up to each output, shape (outputs,)."""
    if not record.assembly.contacts:
        return {}
    depth = record.block("contact_penetration_max")
    return {f"{name}.penetration.max": depth[:, k] for k, name in enumerate(record.assembly.contacts)}


def turnings(record: Record) -> dict[str, Values]:
    """Largest angular acceleration of each body (rad/s^2) and torque of each driver (N m) up to each output,
    shape (outputs,).
    """
    found: dict[str, Values] = {}
    turning = record.block("body_alpha_max")
    for name, body in record.assembly.bodies.items():
        noun = record.assembly.mechanism.bodies[name]
        if not (isinstance(noun, PointMass) and noun.inertia == 0.0):
            found[f"{name}.angular_acceleration.max"] = turning[:, body.row]
        if body.driven is not None:
            found[f"{name}.torque.max"] = record.block("driven_torque_max")[:, body.driven]
    return found


def contact_counts(record: Record, window: Window) -> dict[str, float]:
    """How often contacts began, and how: counts of the whole run, and the shares of its time in each mode."""
    found: dict[str, float] = {}
    if not record.assembly.contacts:
        return found
    totals = {
        name: record.block(f"contact_{row}")[-1]
        for name, row in COUNTS.items()
        if record.keeps(f"contact_{row}")
    }
    parts = shares(record)
    for k, name in enumerate(record.assembly.contacts):
        found |= {f"{name}.{kind}": float(values[k]) for kind, values in totals.items()}
        found |= {f"{name}.share.{mode}": float(values[k]) for mode, values in parts.items()}
    return found


PEAKS: tuple[Measure, ...] = (
    largest_loads,
    deepest_penetrations,
    largest_accelerations,
)  # of extremes; a step is judged by them
OVER_TURN: tuple[Measure, ...] = (
    *PEAKS, driving, losses, largest_sliding, largest_pressures, largest_strokes,
    largest_shaking, largest_stresses, largest_deflections, efficiency, worn_volumes, worn_depths,
)  # fmt: skip
OVER_RUN: tuple[Measure, ...] = (contact_counts,)


Beside = Callable[[Sequence[Record]], dict[str, float]]
ENDINGS: dict[str, tuple[str, ...]] = {
    "largest_loads": (".force.max", ".moment.max"),
    "deepest_penetrations": (".penetration.max",),
    "largest_accelerations": (".angular_acceleration.max", ".torque.max"),
    "driving": (".torque.mean", ".torque.ripple", ".power.mean"),
    "losses": (
        ".friction_energy.total",
        ".impact_energy.total",
        ".friction_power.mean",
        ".impact_power.mean",
    ),
    "largest_sliding": (".sliding_velocity.max", ".sliding_distance.total"),
    "largest_pressures": (
        ".contact_pressure.max",
        ".contact_half_width.max",
        ".pressure_velocity.max",
        ".pressure_velocity.mean",
    ),
    "largest_strokes": (".position.low", ".position.high", ".velocity.max", ".acceleration.max"),
    "largest_shaking": (".shaking_force.max", ".shaking_moment.max"),
    "largest_stresses": (".tension.max", ".compression.max", ".stress.place"),
    "largest_deflections": (".deflection.max",),
    "efficiency": ("mechanism.efficiency",),
    "worn_volumes": (".bearing_wear.total", ".journal_wear.total"),
    "worn_depths": (".bearing_wear_depth.max", ".journal_wear_depth.max"),
}  # of names, by the measure that gives them
INFLUENCE = (".force.lip", ".angular_acceleration.lip")
COUNTED = (
    ".impacts", ".grazing", ".deep_landings", ".landing_depth.max", ".approach_speed.max",
    ".share.free_flight", ".share.impact", ".share.continuous_contact",
)  # fmt: skip
BY_TURN: tuple[Measure, ...] = (
    *PEAKS,
    losses,
    worn_volumes,
)  # what the largest of extremes and the last of all else in a turn tell


def of_whole_runs(names: Sequence[str]) -> list[str]:
    """Those names that measures of a whole run have, whichever of its turns are looked at."""
    return [name for name in names if name.endswith(COUNTED) and "(" not in name]


class WantedMeasures:
    """Measures by ``names``, all without any; ``beside`` gives more of turns that are recorded output by
    output.
    """

    def __init__(self, names: Sequence[str] = (), beside: Beside | None = None) -> None:
        self.names, self.beside = tuple(names), beside
        self.peaks = not names or any(name.endswith(INFLUENCE) for name in names)
        self.counts = not names or any(name.endswith(COUNTED) for name in names)
        self.every = tuple(
            measure
            for measure in OVER_TURN
            if not names
            or (self.peaks and measure in PEAKS)
            or any(name.endswith(ENDINGS[measure.__name__]) for name in names)
        )

    @property
    def by_turn(self) -> bool:
        """Whether one row for each turn tells them all."""
        return self.beside is None and set(self.every) <= set(BY_TURN)

    def over(self, turns: Sequence[Record], reference: Mapping[str, float] | None) -> dict[str, float]:
        """Means over turns, each a record that begins with the output before it; counts up to the end of the
        last one.
        """
        turnly = []
        for turn in turns:
            found = taken(self.every, turn, last_turn(turn))
            turnly.append(found | (compared(turn, found, reference) if self.peaks else {}))
        mean: dict[str, float] = {}
        for name in turnly[-1]:
            values = [turn[name] for turn in turnly if name in turn]
            mean[name] = values[0] if len(values) == 1 else math.fsum(values) / len(values)
        mean |= over_run(turns[-1]) if self.counts else {}
        mean |= self.beside(turns) if self.beside is not None else {}
        return {name: mean[name] for name in self.names if name in mean} if self.names else mean
