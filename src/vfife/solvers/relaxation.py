"""Equilibria by dynamic relaxation: fictitious masses, the effect of a load factor, and the iterations.

The structure moves under its loads with fictitious masses and damping until it rests. An iteration is a step
of the same loop that steps motions, with a step size of one. No stiffness matrix is assembled, so contacts,
large rotations and snap-through need no special treatment. The price is the number of iterations, which grows
with the square of the elements in line of a slender frame.

Masses are as small as stability permits, M = K / 3.6, where K is an upper bound of the stiffness at each
particle. The damping is critical for the slowest motion, whose frequency is estimated from the motion itself:
Rayleigh's quotient of displacements and changes of force between two outputs (P. Underwood, Dynamic
relaxation, in: Computational methods for transient analysis (1983)).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..assembly.stability import attached_stiffness, element_stiffness
from ..compiler.runtime.runner import Runner
from ..kernels.polynomial import polynomial
from ..kernels.topology import FREE, SPEED, TIME
from ..kinematics.forces import actions
from ..laws.elasticity import tangent
from ..numerics.dense import dot, times
from ..numerics.elementwise import hypot
from .interrupts import ChunkSize

Array = NDArray[np.float64]

# Square of the highest frequency (rad/iteration)^2; central differences are stable up to 4.
OMEGA = 3.6
# Share of the bending frequency that goes to translations; the rest goes to rotations.
SWAY = 0.8


def demands(assembly: Assembly, state: Array, force: float, pressed: Array) -> tuple[Array, Array]:
    """Return the mass (N s^2/m, an iteration counting as a second) and the inertia with which iterations are
    stable, shape (particles,) each.

    ``state`` is the present S, for lengths and axial forces of elements. ``pressed`` (N) is the recent force
    of each contact, for which at least ``force`` is assumed.
    """
    mass, inertia = _elements(assembly, state)
    load = attached_stiffness(
        assembly.layout, state, assembly.topology, _contacts(assembly, np.maximum(2.0 * pressed, force))
    )
    # springs, axes of bushings and contacts are on four motions, torsional springs on two
    return (mass + 4.0 * load.straight) / OMEGA, (inertia + 4.0 * load.levers + 2.0 * load.torsional) / OMEGA


def _elements(assembly: Assembly, state: Array) -> tuple[Array, Array]:
    """Return the stiffness of elements at each particle, on translations and rotations.

    The axial stiffness acts on two motions; bending on two translations across and two rotations, or one
    rotation if an end is released; the axial force N as N/l across.
    """
    mass, inertia = np.zeros(assembly.topology.particles), np.zeros(assembly.topology.particles)
    if not assembly.topology.frame_nodes:
        return mass, inertia
    k = element_stiffness(assembly.layout, state, assembly.topology)
    pulled = np.abs(state[assembly.layout["frame_axial_force"]]) / state[assembly.layout["reference_length"]]
    turns = np.where(k.coupling > 0.0, 2.0, 1.0) / (1.0 - SWAY)
    for column in (0, 1):
        np.add.at(mass, k.nodes[:, column], 2.0 * (k.axial + pulled) + 2.0 / SWAY * k.transverse)
        np.add.at(inertia, k.nodes[:, column], turns * k.moment[:, column])
    return mass, inertia


def _contacts(assembly: Assembly, force: Array) -> Array:
    """Return the tangent stiffness (N/m) of each contact law under a ``force`` (N) for each contact."""
    stiffness = []
    for index, name in enumerate(assembly.contact_joints):
        law = assembly.mechanism.contacts[name].contact
        stiffness.append(
            tangent(law, assembly.contact_slots(index), float(force[index]))[1] if force[index] > 0.0 else 0.0
        )
    return np.array(stiffness)


class Floors:
    """Lower limits of masses and inertias for the particles of an assembly."""

    def __init__(self, assembly: Assembly) -> None:
        self.size = extent(assembly, assembly.state)
        self.gyration = np.zeros(assembly.topology.particles)
        for body in assembly.bodies.values():
            if body.elements:
                continue
            reach = max(
                [0.0, *(hypot(x - body.reference[0], y - body.reference[1]) for x, y in body.pins.values())]
            )
            self.gyration[body.particles[0]] = max(
                body.inertia / body.mass if body.mass > 0.0 else 0.0, reach * reach
            )

    def __call__(self, mass: Array, inertia: Array, smallest: float) -> tuple[Array, Array]:
        """Return masses and inertias with at least a stiffness of ``smallest`` (N/m) at each particle, for
        bodies that only loads hold: a pendulum, a cable.

        The inertia of a rigid body is at least its mass times the square of its radius of gyration.
        """
        if smallest <= 0.0:
            positive = mass[mass > 0.0]
            smallest = float(np.median(positive)) * OMEGA if len(positive) else OMEGA
        mass = np.maximum(mass, smallest / OMEGA)
        inertia = np.maximum(inertia, self.gyration * mass)
        return mass, np.where(inertia > 0.0, inertia, mass * (self.size * self.size))


def extent(assembly: Assembly, state: Array) -> float:
    """Return the size (m) of a mechanism: the diagonal of the box around its particles and points of the
    ground, and at least the size of the largest body or bearing.
    """
    points = np.array(list(assembly.mechanism.points.values())).reshape(-1, 2)
    places = [state[assembly.layout[f"particle_{axis}"]] for axis in "xy"]
    columns = [np.concatenate([place[1:], points[:, axis]]) for axis, place in enumerate(places)]
    box = float(hypot(*(column.max() - column.min() for column in columns))) if len(columns[0]) else 0.0
    pins = [float(hypot(*at)) for body in assembly.bodies.values() for at in body.pins.values()]
    bearings = [joint.reach for joint in assembly.mechanism.contacts.values()]
    return max([box, *pins, *bearings, 1e-9])


class Loading:
    """Write a load factor into the state and the tables of a relaxation: weights, loads, functions and
    drivers.
    """

    def __init__(self, assembly: Assembly) -> None:
        self.assembly, self.layout, t = assembly, assembly.layout, assembly.topology
        scaled = [action.steady for action in actions(assembly.mechanism) for _ in action.ends]
        self.loads = dict(zip(t.load_function, scaled, strict=True))
        self.arguments = t.function_argument or ((TIME, 0, 0),) * len(t.function_start)
        self.speeds = [k for k, f in enumerate(t.driven_function) if f < 0]
        angles = [f for f, (_, turn) in zip(t.joint_function, t.held, strict=True) if turn != FREE]
        self.turns = {f for f in (*t.driven_function, *angles) if f >= 0}
        self.motions = sorted({f for f in (*t.driven_function, *t.joint_function) if f >= 0})

    def value(self, function: int, factor: float) -> float:
        """Return the value of a function of time under a load factor."""
        start = self.assembly.topology.function_start[function]
        if self.loads.get(function, False):
            return factor * float(polynomial(self.assembly.tables, start, 0.0)[0])
        return float(polynomial(self.assembly.tables, start, factor)[0])

    def force(self, factors: Sequence[float], size: float) -> float:
        """Return the sum of all loads (N) at the largest of ``factors``, with moments as forces on a lever of
        ``size`` (m).
        """
        state, t = self.assembly.state, self.assembly.topology
        total = sum(float(np.abs(state[self.layout[f"particle_load_{axis}"]]).sum()) for axis in "xy") * max(
            abs(f) for f in factors
        )
        for k, function in enumerate(t.load_function):
            fx, fy, moment = (float(state[self.layout.row(f"load_{axis}", k)]) for axis in ("fx", "fy", "m"))
            total += (float(hypot(fx, fy)) + abs(moment) / size) * max(
                abs(self.value(function, f)) for f in factors
            )
        return total

    def motion(self, old: float, new: float) -> tuple[float, float]:
        """Return the largest turn (rad) and travel (m) of the drivers between two load factors."""
        speed = self.assembly.state[self.layout["driven_speed"]]
        turns = [abs(float(speed[k]) * (new - old)) for k in self.speeds]
        moved = {f: abs(self.value(f, new) - self.value(f, old)) for f in self.motions}
        turns += [size for f, size in moved.items() if f in self.turns]
        return max(turns, default=0.0), max(
            (size for f, size in moved.items() if f not in self.turns), default=0.0
        )

    def go(self, relaxation: Relaxation, old: float, new: float, count: int) -> None:
        """Change the load factor from ``old`` to ``new`` in ``count`` iterations, at once if ``count`` is 0.

        Loads take their new values at once. Drivers move uniformly, because a jump would open ideal joints.
        """
        start, state = self.assembly.state, relaxation.state
        iteration = float(relaxation.runner.done)
        for name in (
            "particle_load_x",
            "particle_load_y",
            "particle_load_m",
            "driven_weight_x",
            "driven_weight_y",
        ):
            state[self.layout[name]] = new * start[self.layout[name]]
        for k in self.speeds:
            angle, speed = (float(start[self.layout.row(f"driven_{name}", k)]) for name in ("angle", "speed"))
            rate = speed * (new - old) / count if count else 0.0
            state[self.layout.row("driven_speed", k)] = rate
            state[self.layout.row("driven_angle", k)] = (
                angle + speed * (old if count else new) - rate * iteration
            )
        for function in range(len(self.arguments)):
            self._table(relaxation, function, old, new, count, iteration)

    def _table(
        self, relaxation: Relaxation, function: int, old: float, new: float, count: int, iteration: float
    ) -> None:
        tables, t = relaxation.runner.functions, self.assembly.topology
        at, argument = t.function_start[function], self.arguments[function][0]
        if argument in (TIME, SPEED):
            start_value, end_value = self.value(function, old), self.value(function, new)
            linear = count > 0 and function in self.motions
            line = (
                start_value if linear else end_value,
                (end_value - start_value) / count if linear else 0.0,
            )
            tables[at : at + 10] = 1.0, iteration, *line, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            return
        pieces = int(self.assembly.tables[at])
        first = at + (1 + pieces if pieces > 0 else 3 - pieces)
        last = first + 7 * abs(pieces)
        tables[first:last] = new * self.assembly.tables[first:last]


# Outputs in a chunk of iterations, and angle (rad) by which the slowest motion advances between two: its
# frequency is estimated from them.
LOOKS, ANGLE = 4, 0.4
# Iterations between two outputs: fewest, most, and most if contacts may begin, whose stiffness is not known
# before.
SHORTEST, LONGEST, LONGEST_BEFORE_CONTACT = 8, 4000, 50
# Places at least on the way between two outputs, or every iteration: under far more than its limit load, and
# if it is stiff, a structure snaps through between two outputs.
CLOSE = 64
# Factor by which masses may be too small, OMEGA being 3.6 of 4, before a chunk is repeated with larger ones.
TOO_LIGHT = 1.1
# Bodies that only loads hold move by the size over this number in the first iteration.
LOADED = 100.0
# Masses grow by this factor where joints come apart.
FLAT = 100.0
# Forces that rounding makes, over size and stiffness.
NOISE = 1e-14
CHECKPOINT_NUMBERS = ("frequency", "iterations", "kinetic", "kinetic_max", "between")
FORCES = (
    "particle_load_x", "particle_load_y", "frame_axial_force", "joint_fx", "joint_fy", "contact_normal_force",
    "spring_fx", "spring_fy", "driven_fx", "driven_fy",
)  # fmt: skip
MOMENTS = (
    "frame_moment_1",
    "frame_moment_2",
    "joint_moment",
    "spring_moment",
    "driven_torque",
    "particle_load_m",
)
HEAVIER, MOST_HEAVIER = 1.5, 16.0  # factors by which masses grow where a stiffness has outgrown them


@dataclass
class Balance:
    """Unbalanced ``force`` (N) and ``moment`` (N m), the largest force and moment in the structure, and the
    ``size`` (m) by which forces and moments are compared.
    """

    force: float
    moment: float
    largest_force: float
    largest_moment: float
    size: float

    @property
    def ratio(self) -> float:
        """Larger of the ratios of unbalanced to largest force and of unbalanced to largest moment; 0 without
        forces.
        """
        force = max(self.largest_force, self.largest_moment / self.size)
        moment = max(self.largest_moment, self.largest_force * self.size)
        return max(self.force / force if force > 0.0 else 0.0, self.moment / moment if moment > 0.0 else 0.0)


class Relaxation:
    """The relaxation of an assembled mechanism; ``force`` (N) is the sum of its loads."""

    def __init__(self, assembly: Assembly, force: float, loop: str = "data-driven") -> None:
        self.assembly, self.layout, self.force = assembly, assembly.layout, force
        state = assembly.state[:, None].copy()
        self.size = extent(assembly, assembly.state)
        moving = {
            "x": "particle_inverse_mass",
            "y": "particle_inverse_mass",
            "theta": "particle_inverse_inertia",
        }
        free = {axis: np.flatnonzero(state[self.layout[name], 0] > 0.0) for axis, name in moving.items()}
        rates = {"x": ("u", "ax"), "y": ("v", "ay"), "theta": ("w", "aw")}
        self.places = np.concatenate([self.layout[f"particle_{axis}"][free[axis]] for axis in moving])
        self.speeds, self.pushes = (
            np.concatenate([self.layout[f"particle_{rates[axis][k]}"][free[axis]] for axis in moving])
            for k in (0, 1)
        )
        self.inverse = np.concatenate([self.layout[name][free[axis]] for axis, name in moving.items()])
        loads = {"x": "particle_load_x", "y": "particle_load_y", "theta": "particle_load_m"}
        self.loads = np.concatenate([self.layout[loads[axis]][free[axis]] for axis in moving])
        self.turning = np.concatenate([np.full(len(free[axis]), axis == "theta") for axis in moving])
        self.scale = np.where(self.turning, 1.0, self.size)
        for block in ("u", "v", "w"):
            state[self.layout[f"particle_{block}"]] = 0.0
        state[self.layout["step"]] = 1.0
        state[self.layout["damping"]] = 0.0
        state[self.layout["contact_floor"]] = 1e30  # contacts press by their elastic part alone
        watched = np.concatenate(
            [self.places, self.speeds, self.pushes, self.layout["contact_force_squared_max"]]
        ).astype(np.uint32)
        self.forces, self.moments = (
            np.concatenate([self.layout[name] for name in names]) for names in (FORCES, MOMENTS)
        )
        self.ends = self.layout["frame_moment_1"], self.layout["frame_moment_2"]
        self.floors = Floors(assembly)
        self.longest = LONGEST_BEFORE_CONTACT if assembly.contacts else LONGEST
        self.pressed = np.zeros(len(assembly.contacts))
        self.runner = Runner(
            assembly.topology, state, assembly.tables[None, :].copy(), loop, watched, parts=1
        )
        self.mass, self.inertia = np.zeros(assembly.topology.particles), np.zeros(assembly.topology.particles)
        self.pace = ChunkSize()
        self.frequency, self.iterations, self.kinetic, self.kinetic_max = 0.0, 0, 0.0, 0.0
        # Called after a chunk with its places, accelerations, masses and which contacts touch, per output.
        self.follow: Callable[[Array, Array, Array, NDArray[np.bool_]], None] | None = None
        self.snaps = list[tuple[float, float]]()
        # Load factors, and whether their equilibrium is unstable; None where that is not examined.
        self.unstable = list[tuple[float, bool | None]]()
        self.between = SHORTEST
        self.reweigh()

    @property
    def state(self) -> Array:
        """S, shape (rows,)."""
        return self.runner.states[:, 0]

    def reweigh(self) -> bool:
        """Give particles that are too light for their stiffness more mass. True if any was so light that
        iterations were unstable.
        """
        needed_masses = demands(self.assembly, self.state, self.force, self.pressed)
        needed = self.floors(*needed_masses, LOADED * self.force / self.size)
        unstable, first = False, not self.mass.any()
        for name, need in zip(("mass", "inertia"), needed, strict=True):
            current = getattr(self, name)
            short = need > current
            unstable |= bool((need > TOO_LIGHT * current).any()) and not first
            current = np.where(
                short, np.minimum(HEAVIER * need, current * MOST_HEAVIER) if not first else need, current
            )
            setattr(self, name, current)
            rows = self.layout[f"particle_inverse_{name}"]
            self.state[rows] = np.where(self.state[rows] > 0.0, 1.0 / current, 0.0)
        return unstable

    @property
    def finite(self) -> bool:
        """Whether all places are finite. What is loose goes far away first; what is held and flat comes apart
        at once.
        """
        return bool(np.isfinite(self.state[self.places]).all())

    def go_back(self, state: Array) -> None:
        """Go back to a state at rest, with masses so large that a flat structure moves by less than its rise
        in one iteration.
        """
        self.state[:] = state
        self.zero_velocities()
        for name in ("mass", "inertia"):
            setattr(self, name, FLAT * getattr(self, name))
            self.state[self.layout[f"particle_inverse_{name}"]] /= FLAT
        self.frequency, self.kinetic, self.kinetic_max, self.between = 0.0, 0.0, 0.0, SHORTEST
        self.state[self.layout["damping"]] = 0.0

    @property
    def checkpoint(self) -> dict[str, Any]:
        """What it takes to go on, besides S, for JSON."""
        numbers = {name: getattr(self, name) for name in CHECKPOINT_NUMBERS}
        arrays = {name: getattr(self, name).tolist() for name in ("mass", "inertia", "pressed")}
        arrays["snaps"], arrays["unstable"] = self.snaps, self.unstable
        return {**numbers, **arrays, "done": self.runner.done, "functions": self.runner.functions.tolist()}

    def restore(self, state: Array, rows: NDArray[np.intp], checkpoint: Mapping[str, Any]) -> None:
        """Continue from the ``rows`` of a former S, ``state``, and the :attr:`checkpoint` made with it."""
        self.state[rows] = state
        for name in CHECKPOINT_NUMBERS:
            setattr(self, name, checkpoint[name])
        for name in ("mass", "inertia", "pressed"):
            setattr(self, name, np.array(checkpoint[name], dtype=float))
        self.snaps = [(start, end) for start, end in checkpoint.get("snaps", ())]
        self.unstable = [(factor, state) for factor, state in checkpoint.get("unstable", ())]
        self.runner.done, self.runner.functions[:] = checkpoint["done"], checkpoint["functions"]

    def zero_velocities(self) -> None:
        """Set all velocities to zero."""
        self.state[self.speeds] = 0.0

    def advance(self, count: int) -> None:
        """Iterate ``count`` times without adapting masses and damping."""
        self.pace.advance(self.runner, count, 1)
        self.iterations += count

    def relax(self) -> Array:
        """Iterate a chunk, and adapt the damping to the slowest motion; return the unbalanced forces at its
        outputs, shape (LOOKS, coordinates).

        If a contact was stiffer than the masses of its bodies permit, the chunk is repeated from rest with
        larger masses, because an unstable iteration may have moved bodies anywhere.
        """
        while True:
            start = self.state.copy()
            coarsest = max(1, self.between // CLOSE)
            interval = max(count for count in range(1, coarsest + 1) if self.between % count == 0)
            rows = self.pace.advance(self.runner, interval, LOOKS * self.between // interval)[:, :, 0]
            self.iterations += LOOKS * self.between
            path = rows[:, : 3 * len(self.places)].reshape(len(rows), 3, -1)
            looks = path[self.between // interval - 1 :: self.between // interval]
            with np.errstate(invalid="ignore"):
                self.pressed = np.nan_to_num(
                    np.sqrt(rows[:, 3 * len(self.places) :].max(axis=0)), nan=1e300, posinf=1e300
                )
            weights = 1.0 / self.state[self.inverse]  # those the chunk moved with: heavier ones may follow
            if not self.reweigh():
                break
            inverse = [self.layout["particle_inverse_mass"], self.layout["particle_inverse_inertia"]]
            lighter = [self.state[block].copy() for block in inverse]
            self.state[:] = start
            for block, values in zip(inverse, lighter, strict=True):
                self.state[block] = values
            self.zero_velocities()
            self.between = max(SHORTEST, self.between // 4)
        mass = 1.0 / self.state[self.inverse]
        if self.follow is not None:
            self.follow(path[:, 0], path[:, 2], weights, rows[:, 3 * len(self.places) :] > 0.0)
        place, speed, push = looks[:, 0], looks[:, 1], looks[:, 2]
        energy = 0.5 * times(speed * speed, mass)
        self.kinetic, self.kinetic_max = float(energy[-1]), max(self.kinetic_max, float(energy.max()))
        moved = np.diff(place, axis=0)
        weight = float(times(moved * moved, mass).sum())
        if math.isfinite(weight) and weight > self.rounding(mass):
            self._damp(-float(times(moved * np.diff(push, axis=0), mass).sum()) / weight)
        return np.asarray(push * mass, dtype=float)

    def rounding(self, mass: Array) -> float:
        """Return the kinetic energy, and the sum of m dx^2, that is rounding."""
        return float(dot(mass, np.square(self.scale)) * (100.0 * NOISE * NOISE))

    @property
    def kinetic_share(self) -> float:
        """Kinetic energy over the largest so far; 0 if it is rounding."""
        energy = self.kinetic
        return energy / self.kinetic_max if energy > self.rounding(1.0 / self.state[self.inverse]) else 0.0

    def way(self, moved: Array) -> Array:
        """Return the largest of the displacements (sizes of the mechanism) and turns (rad) of all free
        coordinates; these are the last axis of ``moved``.
        """
        return np.asarray((np.abs(moved) / self.scale).max(axis=-1, initial=0.0))

    def _damp(self, square: float) -> None:
        """Set the critical damping for a frequency from its estimated square (rad/iteration)^2; the frequency
        changes by a factor of four at most.
        """
        frequency = math.sqrt(square) if square > 0.0 else 0.5 * self.frequency
        if self.frequency > 0.0:
            frequency = min(max(frequency, 0.25 * self.frequency), 4.0 * self.frequency)
        self.frequency = min(frequency, 1.0)
        self.state[self.layout["damping"]] = 2.0 * self.frequency
        interval = ANGLE / self.frequency if self.frequency > 0.0 else 2.0 * self.between
        self.between = int(min(max(interval, SHORTEST, 0.5 * self.between), 2.0 * self.between, self.longest))

    def balance(self, pushes: Array) -> Balance:
        """Return the balance for unbalanced forces ``pushes``, shape (coordinates,)."""
        noise = NOISE * np.where(self.turning, 10.0, self.size) / self.state[self.inverse]
        size = np.where(np.abs(pushes) > noise, np.abs(pushes), 0.0)
        forces, moments = self.largest()
        turning, straight = size[self.turning], size[~self.turning]
        return Balance(
            float(straight.max(initial=0.0)), float(turning.max(initial=0.0)), forces, moments, self.size
        )

    def largest(self) -> tuple[float, float]:
        """Return the largest force (N) and moment (N m) among loads, elements, joints, contacts and
        springs.
        """
        layout, state = self.layout, self.state

        def top(rows: NDArray[np.intp]) -> float:
            return float(np.fmax.reduce(np.abs(state[rows]), initial=0.0))

        value = np.abs(state[layout["function_value"]])[list(self.assembly.topology.load_function)]
        loads = [
            float((value * np.abs(state[layout[f"load_{axis}"]])).max(initial=0.0))
            for axis in ("fx", "fy", "m")
        ]
        first, second = self.ends
        shear = (state[first] + state[second]) / state[layout["reference_length"]]
        return max(top(self.forces), *loads[:2], float(np.abs(shear).max(initial=0.0))), max(
            top(self.moments), loads[2]
        )
