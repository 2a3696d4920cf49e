"""The energy ledger: what drivers and loads put in, what is stored, lost and left over; torque, power and
efficiency of the machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..kernels import frame
from ..kernels.topology import CURRENT
from ..laws.elasticity import elastic_energy
from ..numerics import products
from ..numerics.elementwise import exp, hypot, sincos
from ..solvers.record import Record
from ..solvers.relaxation import extent
from .contacts import of_window
from .motion import AXES, is_free, times, velocities

Array = NDArray[np.float64]
REST = 1e-6
LAST = 20  # outputs
STORED = ("kinetic", "strain", "contact", "spring")
LOST = ("contact_loss", "friction_loss", "damping_loss", "spring_loss")
SUPPLIED = ("external", "driver")


@dataclass(frozen=True)
class Ledger:
    """Energies (J) at the outputs, each of shape (outputs,), by name: what is stored, lost and supplied."""

    terms: dict[str, Array]

    @cached_property
    def residual(self) -> Array:
        """Stored + lost - supplied - stored at output 0 (J); zero if the ledger closes."""
        stored = sum((self.terms[name] for name in STORED), np.zeros(1))
        lost = sum((self.terms[name] for name in LOST), np.zeros(1))
        supplied = sum((self.terms[name] for name in SUPPLIED), np.zeros(1))
        return np.asarray(stored + lost - supplied - stored[0], dtype=float)

    @property
    def largest(self) -> float:
        """Largest absolute energy of all terms (J)."""
        return max(float(np.abs(values).max()) for values in self.terms.values())

    @property
    def error(self) -> float:
        """Largest absolute residual over the largest energy; 0 where there is no energy at all."""
        largest = self.largest
        return float(np.abs(self.residual).max()) / largest if largest > 0.0 else 0.0


def too_open(record: Record, found: Ledger | None = None) -> bool:
    """Whether more energy came or went than the settings allow (``energy_limit`` of the largest energy there
    was).

    Where nothing moves there is no energy to speak of, and nothing is judged: less than REST of what it takes
    to lift the whole by its own size. ``found`` is the ledger where it is known already.
    """
    assembly = record.assembly
    if record.static or len(record.steps) < 2:
        return False
    found = ledger(record) if found is None else found
    mass = sum(body.mass for body in assembly.bodies.values())
    rest = REST * mass * hypot(*assembly.mechanism.gravity) * extent(assembly, assembly.state)
    return found.largest > rest and found.error > assembly.mechanism.settings.energy_limit


def drifting(assembly: Assembly, kept: NDArray[np.uint32], steps: NDArray[np.int64], rows: Array) -> bool:
    """Whether the ledger is open by more than the settings allow at the last outputs, one and all, of which
    output 0 stands before the others.
    """
    some = Record(assembly, steps, rows, kept)
    limit, found = assembly.mechanism.settings.energy_limit, ledger(some)
    return too_open(some, found) and bool((np.abs(found.residual[-LAST:]) > limit * found.largest).all())


def own_floor(record: Record) -> bool:
    """Whether part of what the ledger leaves open is the method's own, so that no step closes it.

    Moments of elements whose stiffness counts on their present length belong to no energy.
    """
    return CURRENT in record.assembly.topology.strains


def ledger(record: Record) -> Ledger:
    """All energies and works of a record, from its state at t_n.

    A work row sums span * power up to and including all of step n, so the work at t_n is the row less dt/2
    power; the first step, whose span is dt/2, gives zero.
    """
    return Ledger(
        {
            "kinetic": kinetic(record),
            "strain": strain(record),
            "contact": contact(record),
            "spring": record.block("spring_energy").sum(axis=1),
            "contact_loss": _work(record, "contact_damping"),
            "friction_loss": _work(record, "contact_friction"),
            "damping_loss": _work(record, "damping"),
            "spring_loss": _work(record, "spring_damping"),
            "external": _work(record, "external") + constant_loads(record),
            "driver": _work(record, "driven"),
        }
    )


def _work(record: Record, name: str) -> Array:
    half = 0.5 * record.assembly.choice.step
    return np.asarray(
        (record.block(f"{name}_work") - half * record.block(f"{name}_power")).sum(axis=1), dtype=float
    )


def kinetic(record: Record) -> Array:
    """Kinetic energy (J): sum of m/4 (v_(n-1/2)^2 + v_(n+1/2)^2) over free particles, and I w^2/2 of the
    driven bodies.

    The mean of both half steps is what the central difference keeps; output 0 has m v_0^2/2, the velocity it
    starts from.
    """
    free = is_free(record)
    now = velocities(record)
    inertia = {"u": "particle_inverse_mass", "v": "particle_inverse_mass", "w": "particle_inverse_inertia"}
    total = np.zeros(len(record.steps))
    for _, rate, _ in AXES:
        inverse = record.parameter(inertia[rate])
        moves = free & (inverse > 0.0)
        after = record.block(f"particle_{rate}")[:, moves]
        before = 2.0 * now[rate][:, moves] - after
        mean = 0.5 * (before * before + after * after)
        mean[0] = now[rate][0, moves] * now[rate][0, moves]
        total += 0.5 * products.times(mean, 1.0 / inverse[moves])
    driven = list(record.assembly.topology.driven)
    turning = now["w"][:, driven]
    return np.asarray(
        total + 0.5 * products.times(turning * turning, record.parameter("driven_inertia")), dtype=float
    )


def strain(record: Record) -> Array:
    """Strain energy of the elements (J): N^2 l/(2 E A) + (m_1 theta_1 + m_2 theta_2)/2 = N^2 l/(2 E A) + l/(6
    E I) (m_1^2 - m_1 m_2 + m_2^2).

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
    """e - 1 + exp(-e), by its series e^2/2! - e^3/3! + ... where the difference would lose digits."""
    small = np.clip(strain, -0.5, 0.5)
    series = np.ones_like(small)
    for k in range(15, 2, -1):
        series = 1.0 - small / k * series
    return np.where(np.abs(strain) <= 0.5, 0.5 * small * small * series, (strain - 1.0) + exp(-strain))


def contact(record: Record) -> Array:
    """Energy stored in the contacts (J)."""
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
    """Work of constant loads and of the weight since output 0 (J): force dot displacement.

    The weight of a driven body acts at its centre of mass, whose place times mass is ``driven_moment``,
    turned with the body.
    """
    total = np.zeros(len(record.steps))
    for axis, load in (("x", "x"), ("y", "y"), ("theta", "m")):
        place = record.block(f"particle_{axis}")
        total += products.times(place - place[0], record.parameter(f"particle_load_{load}"))
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


IDLE = 1e-3  # of what is given off and lost together: a machine that gives off less does no work
OPEN = 1e-5  # of the largest energy: what a turn leaves over that only goes to and fro
STILL = 1e-6  # of the torque's range: a mean below it is none


def driving(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<driven body>.torque.mean`` (N m), work over angle; ``.torque.ripple`` (1), highest less lowest at
    the outputs over the size of the mean; ``.power.mean`` (W). The work is that of every step.
    """
    found: dict[str, float] = {}
    if (
        not record.assembly.topology.driven
        or not record.keeps("driven_work")
        or not record.keeps("particle_theta")
    ):
        return found
    torque_kept = record.keeps("driven_torque")  # not of companions
    part, inside = of_window(record, window)
    half, time = 0.5 * part.assembly.choice.step, times(part)
    for name, body in record.assembly.bodies.items():
        if body.driven is None or len(time) < 2:
            continue
        work = part.block("driven_work")[:, body.driven] - half * part.block("driven_power")[:, body.driven]
        torque = part.block("driven_torque")[inside, body.driven] if torque_kept else np.zeros(1)
        angle = part.block("particle_theta")[:, part.assembly.topology.driven[body.driven]]
        found[f"{name}.power.mean"] = float((work[-1] - work[0]) / (time[-1] - time[0]))
        if abs(turned := float(angle[-1] - angle[0])) > 1e-9:
            mean = found[f"{name}.torque.mean"] = float(work[-1] - work[0]) / turned
            if torque_kept and abs(mean) > STILL * (reach := float(torque.max() - torque.min())):
                found[f"{name}.torque.ripple"] = reach / abs(mean)
    return found


def efficiency(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``mechanism.efficiency`` (1) over a full turn: work given off over the same and all losses; nothing for
    a machine that gives off none.

    Drivers and loads (weight with them) each put in what they do in all over the window, or take it: a press
    is driven and its load takes, an engine's gas drives and its driver takes. In a motion that repeats, given
    off + lost = put in.
    """
    turn = record.assembly.choice.turn
    if turn is None or not record.keeps("driven_work") or not record.keeps("particle_x"):
        return {}
    part, _ = of_window(record, window)
    time = times(part)
    if time[-1] - time[0] < (1.0 - 1e-9) * turn:
        return {}
    kept = ledger(part)
    done = {name: float(values[-1] - values[0]) for name, values in kept.terms.items()}
    given, lost = (
        sum(max(-done[name], 0.0) for name in ("driver", "external")),
        sum(done[name] for name in LOST),
    )
    if not given > max(IDLE * (given + lost), OPEN * kept.largest) or lost < 0.0:
        return {}
    return {"mechanism.efficiency": given / (given + lost)}
