"""Dynamic relaxation: the step of a run with fictitious masses, one iteration each, damped until nothing moves.

All particles have about the same stable step (``fictitious_mass.py``). Damping is critical for the slowest motion under way. Its frequency is
Rayleigh's quotient of the last change, w^2 = -sum(m dx da)/sum(m dx^2), with dx, da the changes of position and acceleration between two looks:
Underwood, Dynamic relaxation, in Belytschko, Hughes (eds.), Computational Methods for Transient Analysis (1983) 245-265; the accelerations are
those after the reactions, so that joints need no tangent. Where the quotient is negative, as while a structure snaps through, damping is halved
from look to look, and the motion runs off to the next equilibrium.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..codegen.runner import Runner
from ..numerics.products import dot, times
from .fictitious_mass import Floors, demands, extent
from .pace import Pace

Array = NDArray[np.float64]

LOOKS = 4  # in a chunk of iterations
ANGLE = 0.4  # rad of the slowest motion between two looks
SHORTEST, LONGEST, FEW = 8, 4000, 50  # iterations between two looks; few of them where contacts may begin
BEYOND = 1.1  # of the mass for which iterations are stable, OMEGA being 3.6 of 4
LOADED = 100.0  # what nothing but loads holds is moved by a hundredth of the size in the first iteration
FLAT = 100.0  # times the masses where joints come apart
NOISE = 1e-14  # of size and stiffness: forces that rounding alone makes
REMEMBERED = ("frequency", "iterations", "kinetic", "kinetic_max", "between")
FORCES = (
    "particle_load_x", "particle_load_y", "frame_axial_force", "joint_fx", "joint_fy", "contact_normal_force",
    "spring_fx", "spring_fy", "driven_fx", "driven_fy",
)  # fmt: skip
MOMENTS = ("frame_moment_1", "frame_moment_2", "joint_moment", "spring_moment", "driven_torque", "particle_load_m")
HEAVIER, MOST_HEAVIER = 1.5, 16.0  # factors by which masses grow where a stiffness has outgrown them


@dataclass
class Balance:
    """Unbalanced force and moment, the largest force and moment there are, and the size (m) by which the two are compared."""

    force: float
    moment: float
    largest_force: float
    largest_moment: float
    size: float

    @property
    def ratio(self) -> float:
        """The larger of unbalanced force over largest force and the same for moments; 0 where there are no forces."""
        force = max(self.largest_force, self.largest_moment / self.size)
        moment = max(self.largest_moment, self.largest_force * self.size)
        return max(self.force / force if force > 0.0 else 0.0, self.moment / moment if moment > 0.0 else 0.0)


class Relaxation:
    """State of an assembled mechanism that is relaxed; ``force`` (N) is the size of its loads."""

    def __init__(self, assembly: Assembly, force: float, loop: str = "data-driven") -> None:
        self.assembly, self.layout, self.force = assembly, assembly.layout, force
        state = assembly.state[:, None].copy()
        self.size = extent(assembly, assembly.state)
        moving = {"x": "particle_inverse_mass", "y": "particle_inverse_mass", "theta": "particle_inverse_inertia"}
        free = {axis: np.flatnonzero(state[self.layout[name], 0] > 0.0) for axis, name in moving.items()}
        rates = {"x": ("u", "ax"), "y": ("v", "ay"), "theta": ("w", "aw")}
        self.places = np.concatenate([self.layout[f"particle_{axis}"][free[axis]] for axis in moving])
        self.speeds, self.pushes = (np.concatenate([self.layout[f"particle_{rates[axis][k]}"][free[axis]] for axis in moving]) for k in (0, 1))
        self.inverse = np.concatenate([self.layout[name][free[axis]] for axis, name in moving.items()])
        self.turning = np.concatenate([np.full(len(free[axis]), axis == "theta") for axis in moving])
        for block in ("u", "v", "w"):
            state[self.layout[f"particle_{block}"]] = 0.0
        state[self.layout["step"]] = 1.0
        state[self.layout["damping"]] = 0.0
        state[self.layout["contact_floor"]] = 1e30  # contacts press by their elastic part alone
        watched = np.concatenate([self.places, self.speeds, self.pushes, self.layout["contact_force_squared_max"]]).astype(np.uint32)
        self.forces, self.moments = (np.concatenate([self.layout[name] for name in some]) for some in (FORCES, MOMENTS))
        self.ends = self.layout["frame_moment_1"], self.layout["frame_moment_2"]
        self.floors = Floors(assembly)
        self.longest = FEW if assembly.contacts else LONGEST
        self.pressed = np.zeros(len(assembly.contacts))
        self.runner = Runner(assembly.topology, state, assembly.tables[None, :].copy(), loop, watched, parts=1)
        self.mass, self.inertia = np.zeros(assembly.topology.particles), np.zeros(assembly.topology.particles)
        self.pace = Pace()
        self.frequency, self.iterations, self.kinetic, self.kinetic_max = 0.0, 0, 0.0, 0.0
        self.between = SHORTEST
        self.reweigh()

    @property
    def state(self) -> Array:
        """S, shape (rows,)."""
        return self.runner.states[:, 0]

    def reweigh(self) -> bool:
        """Gives particles that are too light for their stiffness more mass. True where any was so light that iterations were unstable."""
        wanted = demands(self.assembly, self.state, self.force, self.pressed)
        needed = self.floors(*wanted, LOADED * self.force / self.size)
        unstable, first = False, not self.mass.any()
        for name, need in zip(("mass", "inertia"), needed, strict=True):
            own = getattr(self, name)
            short = need > own
            unstable |= bool((need > BEYOND * own).any()) and not first
            own = np.where(short, np.minimum(HEAVIER * need, own * MOST_HEAVIER) if not first else need, own)
            setattr(self, name, own)
            rows = self.layout[f"particle_inverse_{name}"]
            self.state[rows] = np.where(self.state[rows] > 0.0, 1.0 / own, 0.0)
        return unstable

    @property
    def whole(self) -> bool:
        """Whether all numbers are finite: what is loose goes far away, but what is held and flat comes apart at once."""
        return bool(np.isfinite(self.state[self.places]).all())

    def go_back(self, before: Array) -> None:
        """Goes back to a state at rest, with masses so much larger that a flat structure is moved by less than its rise in one iteration."""
        self.state[:] = before
        self.rest()
        for name in ("mass", "inertia"):
            setattr(self, name, FLAT * getattr(self, name))
            self.state[self.layout[f"particle_inverse_{name}"]] /= FLAT
        self.frequency, self.kinetic, self.kinetic_max, self.between = 0.0, 0.0, 0.0, SHORTEST
        self.state[self.layout["damping"]] = 0.0

    @property
    def remembered(self) -> dict[str, Any]:
        """What it takes to go on beside S, for JSON."""
        numbers = {name: getattr(self, name) for name in REMEMBERED}
        arrays = {name: getattr(self, name).tolist() for name in ("mass", "inertia", "pressed")}
        return {**numbers, **arrays, "done": self.runner.done, "functions": self.runner.functions.tolist()}

    def restore(self, state: Array, rows: NDArray[np.intp], remembered: Mapping[str, Any]) -> None:
        """Goes on from ``rows`` of a former S and what was :attr:`remembered` with it."""
        self.state[rows] = state
        for name in REMEMBERED:
            setattr(self, name, remembered[name])
        for name in ("mass", "inertia", "pressed"):
            setattr(self, name, np.array(remembered[name], dtype=float))
        self.runner.done, self.runner.functions[:] = remembered["done"], remembered["functions"]

    def rest(self) -> None:
        """Takes all velocities away."""
        self.state[self.speeds] = 0.0

    def advance(self, count: int) -> None:
        """Iterations without a look."""
        self.pace.advance(self.runner, count, 1)
        self.iterations += count

    def relax(self) -> Array:
        """A chunk of iterations with looks between; damping follows the slowest motion. Returned: unbalanced forces, shape (looks, coordinates).

        Where a contact turned out stiffer than its bodies' masses allow, the chunk is undone and made again, from rest, with larger ones.
        """
        while True:
            before = self.state.copy()
            rows = self.pace.advance(self.runner, self.between, LOOKS)[:, :, 0]
            self.iterations += LOOKS * self.between
            seen = rows[:, : 3 * len(self.places)].reshape(LOOKS, 3, -1)
            with np.errstate(invalid="ignore"):
                self.pressed = np.nan_to_num(np.sqrt(rows[:, 3 * len(self.places) :].max(axis=0)), nan=1e300, posinf=1e300)
            if not self.reweigh():
                break
            inverse = [self.layout["particle_inverse_mass"], self.layout["particle_inverse_inertia"]]
            lighter = [self.state[block].copy() for block in inverse]
            self.state[:] = before
            for block, values in zip(inverse, lighter, strict=True):
                self.state[block] = values
            self.rest()
            self.between = max(SHORTEST, self.between // 4)
        mass = 1.0 / self.state[self.inverse]
        place, speed, push = seen[:, 0], seen[:, 1], seen[:, 2]
        energy = 0.5 * times(speed * speed, mass)
        self.kinetic, self.kinetic_max = float(energy[-1]), max(self.kinetic_max, float(energy.max()))
        moved = np.diff(place, axis=0)
        weight = float(times(moved * moved, mass).sum())
        if math.isfinite(weight) and weight > self.rounding(mass):
            self._damp(-float(times(moved * np.diff(push, axis=0), mass).sum()) / weight)
        return np.asarray(push * mass, dtype=float)

    def rounding(self, mass: Array) -> float:
        """Kinetic energy (and sum of m dx^2) that rounding alone makes."""
        return float(dot(mass, np.square(np.where(self.turning, 1.0, self.size))) * (100.0 * NOISE * NOISE))

    @property
    def still(self) -> float:
        """Kinetic energy over the largest met; 0 where it is rounding."""
        energy = self.kinetic
        return energy / self.kinetic_max if energy > self.rounding(1.0 / self.state[self.inverse]) else 0.0

    def _damp(self, square: float) -> None:
        """Damping for the frequency whose square (rad/iteration)^2 was seen."""
        found = math.sqrt(square) if square > 0.0 else 0.5 * self.frequency
        if self.frequency > 0.0:
            found = min(max(found, 0.25 * self.frequency), 4.0 * self.frequency)
        self.frequency = min(found, 1.0)
        self.state[self.layout["damping"]] = 2.0 * self.frequency
        between = ANGLE / self.frequency if self.frequency > 0.0 else 2.0 * self.between
        self.between = int(min(max(between, SHORTEST, 0.5 * self.between), 2.0 * self.between, self.longest))

    def balance(self, pushes: Array) -> Balance:
        """How far from equilibrium the unbalanced forces (coordinates,) are."""
        noise = NOISE * np.where(self.turning, 10.0, self.size) / self.state[self.inverse]
        size = np.where(np.abs(pushes) > noise, np.abs(pushes), 0.0)
        forces, moments = self.largest()
        turning, straight = size[self.turning], size[~self.turning]
        return Balance(float(straight.max(initial=0.0)), float(turning.max(initial=0.0)), forces, moments, self.size)

    def largest(self) -> tuple[float, float]:
        """Largest force (N) and moment (N m) among loads, elements, joints, contacts and springs."""
        layout, state = self.layout, self.state

        def top(rows: NDArray[np.intp]) -> float:
            return float(np.fmax.reduce(np.abs(state[rows]), initial=0.0))

        value = np.abs(state[layout["function_value"]])[list(self.assembly.topology.load_function)]
        loads = [float((value * np.abs(state[layout[f"load_{axis}"]])).max(initial=0.0)) for axis in ("fx", "fy", "m")]
        first, second = self.ends
        shear = (state[first] + state[second]) / state[layout["reference_length"]]
        return max(top(self.forces), *loads[:2], float(np.abs(shear).max(initial=0.0))), max(top(self.moments), loads[2])
