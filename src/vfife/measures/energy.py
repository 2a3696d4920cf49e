"""Energy balance (ledger): work of drivers and loads, stored and lost energies, and the residual; torque,
power and efficiency.

stored + lost - supplied is constant in an exact motion. Every term is computed without the others: works are
sums over all steps, which the loop keeps, and stored energies follow from the state at an output. The
residual is therefore an independent check of step, contacts and constraints. It cannot show errors that
conserve energy, such as a wrong phase.

Companions whose step was not stable show in energies too: what blew up is no draw from the scatter of a
sensitive motion, and has no part in ranges.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..kernels import frame
from ..kernels.topology import CURRENT, FREE
from ..laws.elasticity import elastic_energy
from ..model.functions import turning_speed
from ..numerics import dense
from ..numerics.elementwise import exp, hypot, sincos
from ..solvers.record import Record, release
from ..solvers.relaxation import extent
from .motion import AXES, at_rest, is_free, times, velocities
from .turns import Window, of_turn, of_window

Array = NDArray[np.float64]
REST_SHARE = 1e-6  # share of m g times the size of the mechanism below which energies are not judged
PIECE = 8192  # outputs whose energies are computed together, so that memory does not grow with a run
LAST = 20  # outputs at all of which a drifting ledger is open
STORED = ("kinetic", "strain", "contact", "spring")
LOSSES = ("contact_loss", "friction_loss", "damping_loss", "spring_loss")
SUPPLIED = ("external", "driver")


@dataclass(frozen=True)
class Ledger:
    """Stored, lost and supplied energies (J) at the outputs by name, shape (outputs,) each."""

    terms: dict[str, Array]

    def __repr__(self) -> str:
        return f"<Ledger of {', '.join(self.terms)}; error {self.error:.2g}; see .terms, .residual>"

    @cached_property
    def residual(self) -> Array:
        """Stored + lost - supplied - stored at output 0 (J), shape (outputs,); zero if the ledger closes."""
        stored = sum((self.terms[name] for name in STORED), np.zeros(1))
        losses = sum((self.terms[name] for name in LOSSES), np.zeros(1))
        supplied = sum((self.terms[name] for name in SUPPLIED), np.zeros(1))
        return np.asarray(stored + losses - supplied - stored[0], dtype=float)

    @property
    def largest(self) -> float:
        """Largest absolute energy of all terms (J)."""
        return max(float(np.abs(values).max()) for values in self.terms.values())

    @property
    def error(self) -> float:
        """Largest absolute residual over the largest energy; 0 where there is no energy at all."""
        largest = self.largest
        return float(np.abs(self.residual).max()) / largest if largest > 0.0 else 0.0


def too_open(record: Record, energies: Ledger | None = None) -> bool:
    """Return whether the residual exceeds the ``energy_limit`` of the settings, as a share of the largest
    energy.

    ``energies`` is its ledger, if known.
    """
    if record.static or len(record.steps) < 2:
        return False
    return open_share(record, energies) > record.assembly.mechanism.settings.energy_limit


def open_share(record: Record, energies: Ledger | None = None) -> float:
    """Return the largest residual over the largest energy (1); 0 where energies are those of rounding.

    A mechanism at rest has no energy to compare with: the largest energy must exceed REST_SHARE times the
    work that lifts the mechanism by its own size, and something must move. ``energies`` is its ledger, if
    known.
    """
    assembly = record.assembly
    energies = ledger(record) if energies is None else energies
    mass = sum(body.mass for body in assembly.bodies.values())
    negligible = REST_SHARE * mass * hypot(*assembly.mechanism.gravity) * extent(assembly, assembly.state)
    return 0.0 if energies.largest <= negligible or at_rest(record) else energies.error


def drifting(assembly: Assembly, recorded: NDArray[np.uint32], steps: NDArray[np.int64], rows: Array) -> bool:
    """Return whether the residual exceeds the limit at each of the last outputs; ``rows`` begin with output
    0.
    """
    record = Record(assembly, steps, rows, recorded)
    limit, energies = assembly.mechanism.settings.energy_limit, ledger(record)
    return too_open(record, energies) and bool(
        (np.abs(energies.residual[-LAST:]) > limit * energies.largest).all()
    )


def own_floor(record: Record) -> bool:
    """Return whether the method itself leaves a residual, so that no step closes the balance: the moments of
    elements whose stiffness refers to their present length have no potential.
    """
    return CURRENT in record.assembly.topology.strains


def ledger(record: Record) -> Ledger:
    """Compute all energies and works of a record at its outputs."""
    count = len(record.steps)
    if count <= PIECE:
        return Ledger(_terms(record))
    # Each piece follows output 0, from which energies are counted, and has at least two outputs of its own.
    pieces, rows = np.array_split(np.arange(1, count), math.ceil(count / PIECE)), record.rows
    first = np.array(rows[:1])
    terms: dict[str, list[Array]] = {}
    for k, piece in enumerate(pieces):
        part = slice(int(piece[0]), int(piece[-1]) + 1)
        steps = np.concatenate([record.steps[:1], record.steps[part]])
        source = np.concatenate([first, rows[part]])
        for name, values in _terms(dataclasses.replace(record, steps=steps, source=source)).items():
            terms.setdefault(name, []).append(values[min(k, 1) :])
        release(rows)
    joined = {name: np.concatenate(values) for name, values in terms.items()}
    return Ledger(joined | {"contact": contact(record)})  # a law without formula is integrated to its depth


def _terms(record: Record) -> dict[str, Array]:
    """Return the energies and works of a record or a piece of one."""
    return {
        "kinetic": kinetic(record),
        "strain": strain(record),
        "contact": contact(record),
        "spring": record.block("spring_energy").sum(axis=1),
        "contact_loss": _work(record, "contact_damping"),
        "friction_loss": _work(record, "contact_friction"),
        "damping_loss": _work(record, "damping"),
        "spring_loss": _work(record, "spring_damping"),
        "external": _work(record, "external") + constant_loads(record),
        "driver": driver_work(record),
    }


def driver_work(record: Record) -> Array:
    """Return the work of all drivers (J), shape (outputs,)."""
    work = _work(record, "driven")
    return work + _work(record, "actuator") if record.assembly.topology.joint_actuator else work


def _work(record: Record, name: str) -> Array:
    """Return the work at t_n (J), shape (outputs,).

    The loop adds power times dt for the whole step n, which reaches to t_(n+1/2), because the velocity of
    that step is known there; the work at t_n is the sum less dt/2 times the power. The first step, of length
    dt/2, gives zero.
    """
    half = 0.5 * record.assembly.choice.step
    return np.asarray(
        (record.block(f"{name}_work") - half * record.block(f"{name}_power")).sum(axis=1), dtype=float
    )


def kinetic(record: Record) -> Array:
    """Return the kinetic energy (J): sum of m/4 (v_(n-1/2)^2 + v_(n+1/2)^2) over free particles, and I w^2/2
    of the driven bodies.

    The central difference conserves the mean of both half steps, not m v_n^2/2 with the mean velocity. Output
    0 has m v_0^2/2, because the motion starts from v_0.
    """
    free = is_free(record)
    velocity = velocities(record)
    inertia = {"u": "particle_inverse_mass", "v": "particle_inverse_mass", "w": "particle_inverse_inertia"}
    total = np.zeros(len(record.steps))
    for _, rate, _ in AXES:
        inverse = record.parameter(inertia[rate])
        moves = free & (inverse > 0.0)
        next_rate = record.block(f"particle_{rate}")[:, moves]
        former_rate = 2.0 * velocity[rate][:, moves] - next_rate
        mean = 0.5 * (former_rate * former_rate + next_rate * next_rate)
        mean[0] = velocity[rate][0, moves] * velocity[rate][0, moves]
        total += 0.5 * dense.times(mean, 1.0 / inverse[moves])
    driven = list(record.assembly.topology.driven)
    turning = velocity["w"][:, driven]
    return np.asarray(
        total + 0.5 * dense.times(turning * turning, record.parameter("driven_inertia")), dtype=float
    )


def strain(record: Record) -> Array:
    """Return the strain energy of the elements (J): N^2 l/(2 E A) + (m_1 theta_1 + m_2 theta_2)/2 = N^2 l/(2
    E A) + l/(6 E I) (m_1^2 - m_1 m_2 + m_2^2).

    With one end released its moment is zero, and what is left, l m^2/(6 E I), is the energy of the condensed
    stiffness 3 E I/l. Where E A counts on the reference length l_0, l is that, and the energy is that of the
    force law. Where it counts on the present length, dN = E A dl/l, the integral of N dl at N = E A ln(l/l_0)
    is E A l (e - 1 + exp(-e)), e = N/EA; moments then belong to no energy while the length changes, dm = E
    I/l dtheta, and what is told is that at the present length.
    """
    topology = record.assembly.topology
    if not topology.frame_nodes:
        return np.zeros(len(record.steps))
    present = np.array(topology.strains) == CURRENT
    length = np.where(
        present, record.block("reference_length"), 1.0 / record.parameter("reference_inverse_length")
    )
    n, m1, m2 = (record.block(f"frame_{name}") for name in ("axial_force", "moment_1", "moment_2"))
    axial, bending = record.parameter("frame_axial_stiffness"), record.parameter("frame_bending_stiffness")
    flexible = np.where(bending > 0.0, bending, 1.0)  # without bending stiffness there is no moment
    theta_1, theta_2 = frame.end_rotations(m1, m2, 1.0 / length, flexible)
    stretch = n / axial
    shares = np.where(present, _of_logarithm(stretch), 0.5 * (stretch * stretch))
    energy = axial * length * shares + 0.5 * (m1 * theta_1 + m2 * theta_2)
    return np.asarray(energy.sum(axis=1), dtype=float)


def _of_logarithm(strain: Array) -> Array:
    """Return e - 1 + exp(-e), by its series e^2/2! - e^3/3! + ... where the difference would lose digits."""
    small = np.clip(strain, -0.5, 0.5)
    series = np.ones_like(small)
    for k in range(15, 2, -1):
        series = 1.0 - small / k * series
    return np.where(np.abs(strain) <= 0.5, 0.5 * small * small * series, (strain - 1.0) + exp(-strain))


def contact(record: Record) -> Array:
    """Return the elastic energy of the contacts (J)."""
    assembly = record.assembly
    total = np.zeros(len(record.steps))
    if not assembly.contacts:
        return total
    depth = np.maximum(record.block("contact_penetration"), 0.0)
    for index, name in enumerate(assembly.contact_joints):
        law = assembly.mechanism.contacts[name].contact
        total += elastic_energy(law, depth[:, index], assembly.contact_slots(index))
    return total


def constant_loads(record: Record) -> Array:
    """Return the work of constant loads and of the weight since output 0 (J): force dot displacement.

    The weight of a driven body acts at its centre of mass, whose place times mass is ``driven_moment``,
    turned with the body.
    """
    total = np.zeros(len(record.steps))
    for axis, load in (("x", "x"), ("y", "y"), ("theta", "m")):
        place = record.block(f"particle_{axis}")
        total += dense.times(place - place[0], record.parameter(f"particle_load_{load}"))
    driven = list(record.assembly.topology.driven)
    if driven:
        angle = record.block("particle_theta")[:, driven]
        mx, my, gx, gy = (
            record.parameter(f"driven_{name}") for name in ("moment_x", "moment_y", "weight_x", "weight_y")
        )
        s, c = sincos(angle)
        height = gx * (c * mx - s * my) + gy * (s * mx + c * my)
        total += (height - height[0]).sum(axis=1)
    return total


def actuators(record: Record) -> dict[str, bool]:
    """Return the names of the actuators in the order of their records, and whether each acts along a line."""
    topology, ideals = record.assembly.topology, record.assembly.ideals
    turns = [turn for _, turn in topology.held]
    return {ideals[k]: turns[k] == FREE for k, index in enumerate(topology.joint_actuator) if index >= 0}


def quantity_of(linear: bool) -> tuple[str, str]:
    """Return the name of what an actuator exerts, and its unit."""
    return ("actuator_force", "N") if linear else ("actuator_torque", "N m")


def largest_actuator_forces(record: Record, window: Window) -> dict[str, float]:
    """Return ``<driver>.actuator_force.max`` (N), or ``.actuator_torque.max`` (N m): largest sizes over all
    steps.
    """
    return named_forces(record, record.block("actuator_force_max")[window].max(axis=0).tolist())


def named_forces(record: Record, largest: Sequence[float]) -> dict[str, float]:
    """Return the ``largest`` forces and torques of the actuators, one for each, by the names of measures."""
    names = actuators(record).items()
    return {
        f"{name}.{quantity_of(linear)[0]}.max": value
        for (name, linear), value in zip(names, largest, strict=True)
    }


def actuator_powers(record: Record, window: Window) -> dict[str, float]:
    """Return ``<driver>.actuator_power.mean`` (W) over the window: work/time, where the work is that of every
    step.
    """
    names = actuators(record)
    if not names:
        return {}
    part, _ = of_window(record, window)
    turn = of_turn(record, window, part)
    half, time = 0.5 * part.assembly.choice.step, times(turn)
    if len(time) < 2:
        return {}
    work = turn.block("actuator_work") - half * turn.block("actuator_power")
    means = (work[-1] - work[0]) / (time[-1] - time[0])
    return {f"{name}.actuator_power.mean": float(means[k]) for k, name in enumerate(names)}


IDLE = 1e-3  # share of output and losses below which the output is rounding
OPEN = 1e-5  # share of the largest energy below which the output is the remainder of an exchange
ONE_WAY = 0.99  # share of its path by which a body advances that turns one way
SPEED_TOLERANCE = 1e-6  # share of its speed by which the mean speed of a body that turns evenly may be less
ROUNDING_OF_WORK = 1e-9  # share of the work of a driver below which its fluctuation is rounding
ZERO_MEAN = 1e-6  # share of the torque's range below which its mean is zero


def driving(record: Record, window: Window) -> dict[str, float]:
    """Return the mean torque, ripple and power of each driver over the window; the work is that of every
    step.

    ``<driven body>.torque.mean`` (N m) = work/angle, ``.torque.ripple`` (1) = (max - min of the torque at the
    outputs) over the size of the mean, ``.power.mean`` (W) = work/time. A body that turns back has no mean
    torque: it would be the work over what remains of the angle. One that turns at constant speed also has
    ``.torque.rms`` (N m), the root of the mean square, and ``.energy_fluctuation`` (J).
    """
    values: dict[str, float] = {}
    has_torque = record.keeps("driven_torque")  # companions do not record it
    part, inside = of_window(record, window)
    turn = of_turn(record, window, part)
    half, time = 0.5 * part.assembly.choice.step, times(turn)
    for name, body in record.assembly.bodies.items():
        if body.driven is None or len(time) < 2:
            continue
        work = turn.block("driven_work")[:, body.driven] - half * turn.block("driven_power")[:, body.driven]
        angle = turn.block("particle_theta")[:, part.assembly.topology.driven[body.driven]]
        values[f"{name}.power.mean"] = float((work[-1] - work[0]) / (time[-1] - time[0]))
        turned, path = float(angle[-1] - angle[0]), float(np.abs(np.diff(angle)).sum())
        if abs(turned) > max(1e-9, ONE_WAY * path):
            mean = values[f"{name}.torque.mean"] = float(work[-1] - work[0]) / turned
            torque = part.block("driven_torque")[inside, body.driven] if has_torque else np.zeros(1)
            reach = float(torque.max() - torque.min())
            if has_torque and abs(mean) > ZERO_MEAN * reach:
                values[f"{name}.torque.ripple"] = reach / abs(mean)
            if has_torque and turns_evenly(record, name, abs(turned), float(time[-1] - time[0])):
                values[f"{name}.torque.rms"] = root_mean_square(
                    turn.block("driven_torque")[:, body.driven], time
                )
                values[f"{name}.energy_fluctuation"] = energy_fluctuation(work, angle)
    return values


def turns_evenly(record: Record, body: str, turned: float, duration: float) -> bool:
    """Return whether a driver makes a ``body`` turn by a full turn or more at constant speed: by the angle
    ``turned`` (rad) in a ``duration`` (s).
    """
    drivers = record.assembly.mechanism.drivers.values()
    speed = max((turning_speed(driver) for driver in drivers if driver.body == body), default=0.0)
    return turned > max(ONE_WAY * 2.0 * math.pi, (1.0 - SPEED_TOLERANCE) * speed * duration) and speed > 0.0


def root_mean_square(torque: Array, time: Array) -> float:
    """Return the root mean square over ``time`` (s) of a torque at the outputs, shape (outputs,)."""
    squares = torque * torque
    means = 0.5 * (squares[1:] + squares[:-1])
    return math.sqrt(float((means * np.diff(time)).sum() / (time[-1] - time[0])))


def energy_fluctuation(work: Array, angle: Array) -> float:
    """Return the largest less the least energy (J) at the outputs that a driver has supplied beyond its mean
    torque, the integral of torque less mean torque over the ``angle``; 0 for rounding.
    """
    share = (angle - angle[0]) / (angle[-1] - angle[0])
    excess = work - work[0] - (work[-1] - work[0]) * share
    size = float(np.abs(work - work[0]).max())
    return reach if (reach := float(excess.max() - excess.min())) > ROUNDING_OF_WORK * size else 0.0


def zero_mean_limits(largest: Mapping[str, float]) -> dict[str, float]:
    """Return the mean torques and powers of drivers that are about zero beside the torque that masses and
    springs exchange, with the limits (N m, W) below which they lie.

    ``largest``: the largest magnitudes of measures at all step sizes. The limit of a torque is the share
    ZERO_MEAN of its largest value, that of a power the same torque at the mean speed.
    """
    limits: dict[str, float] = {}
    for name in largest:
        body, _, kind = name.rpartition(".torque.")
        mean, torque = largest.get(f"{body}.torque.mean", 0.0), largest.get(f"{body}.torque.max", 0.0)
        if kind == "mean" and 0.0 < mean <= (limit := ZERO_MEAN * torque):
            limits[name] = limit
            limits[f"{body}.power.mean"] = limit * largest.get(f"{body}.power.mean", 0.0) / mean
    return limits


def efficiency(record: Record, window: Window) -> dict[str, float]:
    """Return ``mechanism.efficiency`` (1) over a full turn: output/(output + losses); none for a machine
    without output.

    Drivers and loads (with the weight) each do or take work over the window: a press is driven and its load
    takes work, an engine's gas drives and its driver takes work. In a periodic motion output + losses =
    input.
    """
    turn = record.assembly.choice.turn
    part = of_turn(record, window)
    time = times(part)
    if turn is None or time[-1] - time[0] < (1.0 - 1e-9) * turn:
        return {}
    energies = ledger(part)
    done = {name: float(values[-1] - values[0]) for name, values in energies.terms.items()}
    output = sum(max(-done[name], 0.0) for name in ("driver", "external"))
    losses = sum(done[name] for name in LOSSES)
    if not output > max(IDLE * (output + losses), OPEN * energies.largest) or losses < 0.0:
        return {}
    return {"mechanism.efficiency": output / (output + losses)}


# Largest contact force over that of the run, and work over the largest energy of the run, from which a
# companion blew up. A force alone may be small in the run by chance, as where a contact begins with its end;
# but no work exceeds what there is.
BURST, BURST_WORK = 30.0, 10.0
COMPANION_WORKS = ("contact_damping_work", "contact_friction_work", "driven_work", "actuator_work")
# Share of the largest energy by which the ledger of a run beside lost companions is open if it blew up too.
LEDGER_LIMIT = 1e-3


def unstable_companions(record: Record) -> tuple[int, ...]:
    """Return the numbers of the companions that are not finite, or that have larger steps than the run and
    blew up.
    """
    companions = record.companions
    if companions is None:
        return ()
    if companions.burst is None:
        companions.burst = _burst(record)
    return tuple(sorted({*companions.divergent, *companions.burst}))


def is_unstable(record: Record) -> bool:
    """Return whether the step of the run itself is not stable: all companions are lost, or some are and its
    ledger is open.
    """
    omissions = unstable_companions(record)
    if record.companions is None or not omissions:
        return False
    return len(omissions) == len(record.companions.counts) or not ledger(record).error <= LEDGER_LIMIT


def _burst(record: Record) -> tuple[int, ...]:
    """Return the numbers of the finite companions that blew up."""
    companions, layout = record.companions, record.assembly.layout
    if companions is None or not record.assembly.contacts or not len(companions.counts):
        return ()
    squares = _largest_rows(record, layout["contact_force_squared_max"])
    largest = float(record.block("contact_force_squared_max").max(initial=0.0))
    coarser = companions.counts < record.assembly.choice.outputs_every
    with np.errstate(invalid="ignore"):
        suspects = np.flatnonzero(coarser & (squares > BURST * BURST * largest) & (largest > 0.0))
    if not len(suspects):
        return ()
    rows = np.array(
        [row for name in COMPANION_WORKS for row in layout.rows_of(name).tolist()], dtype=np.uint32
    )
    works, energy = _largest_rows(record, rows), ledger(record).largest
    return tuple(int(k) for k in suspects if math.isfinite(energy) and works[k] > BURST_WORK * energy)


def _largest_rows(record: Record, rows: NDArray[Any]) -> Array:
    """Return the largest magnitude of some rows of S of each companion, over its turns and last outputs."""
    companions = record.companions
    if companions is None:
        return np.zeros(0)
    columns = np.isin(companions.row_numbers, rows)
    parts = [part for part in (companions.rows, companions.turns) if part.ndim == 3 and part.size]
    result: Array = np.max(
        [np.abs(part[:, columns]).max(axis=(0, 1), initial=0.0) for part in parts]
        or [np.zeros(len(companions.counts))],
        axis=0,
    )
    return result
