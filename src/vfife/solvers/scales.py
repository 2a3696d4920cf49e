"""Scales of a mechanism, and the share of them below which a quantity is about zero.

An angular acceleration of 1e-3 rad/s^2 is rounding in a crank mechanism at 30 rad/s, and its relative error
is 100 % whatever the step. It is therefore compared with what the mechanism can have: forces with the largest
of loads, weights and m r w^2; moments with that force on the extent of the mechanism; angular accelerations
of a body with w^2 and with F l/I; speeds with w r. These numbers make the equations of Newton and Euler
dimensionless.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, BodyMap, StepChoice
from ..kinematics.forces import actions
from ..numerics.elementwise import hypot
from .relaxation import extent

Array = NDArray[np.float64]
# Share of its scale below which a quantity is about zero. The start position closes to 1e-12 of the extent;
# the first step closes that gap, which leaves accelerations of 3e-7 F l/I in a parallelogram.
NEGLIGIBLE = 1e-6
# Share of w^2 of a turning crank with which smaller angular accelerations are compared from turn to turn. In
# crank mechanisms the largest is of the order of w^2; what is left of it in a drive that rolls is not.
SHARE_OF_CENTRIPETAL = 1e-2

SPEEDS = ("approach_speed.max", "sliding_velocity.max")


@dataclass(frozen=True)
class Scales:
    """Scales of a mechanism: ``force`` (N), ``length`` (m), ``speed`` (m/s), and ``accelerations`` of its
    bodies by name (rad/s^2): forces are those of loads, weights and m r w^2. ``remainder`` (rad/s^2) is the
    angular acceleration w^3 h that a step h leaves in a body that turns evenly.

    A scale is 0 where nothing gives one: a mechanism at rest without load.
    """

    force: float
    length: float
    speed: float
    accelerations: dict[str, float]
    remainder: float = 0.0

    @property
    def moment(self) -> float:
        """Moment (N m) of the largest force on the extent of the mechanism."""
        return self.force * self.length

    def of(self, measure: str) -> float:
        """Return the scale of a measure, ``<joint or body>.<quantity>``, in its unit; 0 for a kind without
        one.
        """
        name, _, quantity = measure.partition(".")
        if quantity == "angular_acceleration.max":
            return self.accelerations.get(name, 0.0)
        kinds = {
            "force.max": self.force,
            "shaking_force.max": self.force,
            "moment.max": self.moment,
            "torque.max": self.moment,
            "shaking_moment.max": self.moment,
        }
        if quantity.endswith(SPEEDS):  # a block in a guide has four contacts: guide.1.approach_speed.max
            return self.speed
        return kinds.get(quantity, 0.0)


def scales(assembly: Assembly, substitute: float = 0.0) -> Scales:
    """Return the scales of a mechanism from its model: loads, weights, masses, sizes and speeds at the start
    or of its drivers. ``substitute`` (N) is the force where none of these gives one.
    """
    state, layout = assembly.state, assembly.layout
    drivers = assembly.mechanism.drivers.values()
    speeds = [abs(driver.steady_speed or 0.0) for driver in drivers if driver.moves and driver.unit == "rad"]
    turn = assembly.choice.turn
    spin = max([*speeds, 2.0 * math.pi / turn if turn else 0.0, _largest(state[layout["particle_w"]])])
    bodies = list(assembly.bodies.values())
    size, mass = extent(assembly, state), sum(body.mass for body in bodies)
    x, y = (state[layout[f"particle_load_{axis}"]] for axis in "xy")
    weight = mass * float(hypot(*assembly.mechanism.gravity))
    spins = [_spin(body, assembly, spin) for body in bodies]
    circling = (_arm(body, pair=True) * w * w for body, w in zip(bodies, spins, strict=True))
    force = max(
        _largest(hypot(x, y)), _largest_load(assembly, size), weight, mass * max(circling, default=0.0)
    )
    force = force if force > 0.0 else substitute
    start = _largest(hypot(*(state[layout[f"particle_{axis}"]] for axis in "uv")))
    fall = math.sqrt(force / mass * size) if mass > 0.0 else 0.0
    accelerations = {
        body.name: max(spin * spin, force * _arm(body) / body.inertia if body.inertia > 0.0 else 0.0)
        for body in bodies
    }
    remainder = spin * spin * spin * assembly.choice.step
    return Scales(force, size, max(spin * size, start, fall), accelerations, remainder)


def least_compared_acceleration(choice: StepChoice) -> float:
    """Return the least angular acceleration (rad/s^2) with which those of two turns are compared; 0 without
    turns.
    """
    spin = 2.0 * math.pi / choice.turn if choice.turn else 0.0
    return SHARE_OF_CENTRIPETAL * spin * spin


def _largest_load(assembly: Assembly, size: float) -> float:
    """Return the largest force (N) of the loads and torques of the model, where the pieces of their functions
    begin; a moment counts as a couple on the extent ``size`` (m) of the mechanism.
    """
    largest = 0.0
    for action in actions(assembly.mechanism):
        amplitude = max((abs(piece[0]) for piece in action.function.coefficients), default=0.0)
        for _, _, (fx, fy, moment) in action.ends:
            largest = max(largest, amplitude * max(float(hypot(fx, fy)), abs(moment) / size))
    return largest


def _arm(body: BodyMap, pair: bool = False) -> float:
    """Return the distance (m) of the farthest pin of a body from its centre of mass, or from another pin."""
    pins = [*body.pins.values()]
    places = pins if pair else [body.center]
    return max((float(hypot(x - u, y - v)) for x, y in pins for u, v in places), default=0.0)


def _spin(body: BodyMap, assembly: Assembly, driven: float) -> float:
    """Return the angular velocity (rad/s) of a body at the start, of a driven one at least ``driven``."""
    start = _largest(assembly.state[assembly.layout["particle_w"][list(body.particles)]])
    return start if body.driven is None else max(start, driven)


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
