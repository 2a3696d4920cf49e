"""Response of a single law: a free impact through a contact law, steady and small sliding through a friction
law.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..laws import ContactLaw, FrictionLaw, Pair

Array = NDArray[np.float64]

STEPS = 500  # steps in the time to the deepest point at the impact speed
LONGEST = 60  # such times after which an impact without separation ends


@dataclass(frozen=True)
class FreeImpact:
    """A free impact at a ``speed`` (m/s): time (s), penetration (m), rate (m/s) and force (N), shape
    (samples,) each.
    """

    time: Array
    penetration: Array
    rate: Array
    force: Array
    speed: float

    @property
    def restitution(self) -> float:
        """Separation speed over impact speed (1), which the law delivers; 0 without separation."""
        return max(-float(self.rate[-1]), 0.0) / self.speed if self.penetration[-1] <= 0.0 else 0.0

    @property
    def deepest(self) -> float:
        """Largest penetration (m)."""
        return float(self.penetration.max())

    @property
    def largest(self) -> float:
        """Largest force (N)."""
        return float(self.force.max())

    @property
    def duration(self) -> float:
        """Time in contact (s)."""
        return float(self.time[-1])


def free_impact(law: ContactLaw, pair: Pair, mass: float, speed: float, steps: int = STEPS) -> FreeImpact:
    """Let a mass (kg) strike at a speed (m/s): m delta'' = -F(delta, delta'), F = max(elastic + damping
    delta', 0), until separation.

    Classical Runge-Kutta of fourth order, with about so many ``steps`` to the deepest point; independent of
    the step of a run.
    """
    p = law.parameters(pair)
    dt = deepest_without_loss(law, p, 0.5 * mass * speed * speed) / speed / steps

    def force(depth: float, rate: float) -> float:
        elastic, damping = law.force(depth, law.slowness(speed, rate), p) if depth > 0.0 else (0.0, 0.0)
        return max(elastic + damping * rate, 0.0)

    x, v, push = 0.0, speed, 0.0
    rows = [(0.0, x, v, force(1e-300, v))]
    for n in range(1, LONGEST * steps):
        former = x, v
        v1, a1 = v, -push / mass
        v2, a2 = v + 0.5 * dt * a1, -force(x + 0.5 * dt * v1, v + 0.5 * dt * a1) / mass
        v3, a3 = v + 0.5 * dt * a2, -force(x + 0.5 * dt * v2, v + 0.5 * dt * a2) / mass
        v4, a4 = v + dt * a3, -force(x + dt * v3, v + dt * a3) / mass
        x, v = x + dt * (v1 + 2.0 * v2 + 2.0 * v3 + v4) / 6.0, v + dt * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0
        if x <= 0.0:  # separation inside this step, in which the motion is almost straight
            share = former[0] / (former[0] - x)
            rows.append(((n - 1 + share) * dt, 0.0, former[1] + share * (v - former[1]), 0.0))
            break
        push = force(x, v)
        rows.append((n * dt, x, v, push))
    time, depth, rate, load = np.array(rows).T
    return FreeImpact(time, depth, rate, load, speed)


def deepest_without_loss(law: ContactLaw, p: tuple[float, ...], energy: float) -> float:
    """Return the penetration (m) at which the elastic force has stored an energy (J)."""
    depth, stored = 1e-12, 0.0
    while stored < energy and depth < 1.0:
        stored += 0.05 * depth * law.force(1.025 * depth, 0.0, p)[0]
        depth *= 1.05
    return depth


def with_restitution(law: ContactLaw, value: float) -> ContactLaw:
    """Replace the coefficient of restitution of a law. Raises ValueError if it has none."""
    if "restitution" not in {field.name for field in dataclasses.fields(law)}:
        raise ValueError(f"the law {law.name!r} has no coefficient of restitution")
    return dataclasses.replace(law, **{"restitution": value})


# --------------------------------------------------------------------------------------------------- friction


def initial_memory(law: FrictionLaw) -> Any:
    """Return the memory of a law at its start: a number, or a tuple of several."""
    return 0.0 if len(law.memory) < 2 else (0.0,) * len(law.memory)


def steady_sliding(law: FrictionLaw, pair: Pair, normal: float, speeds: Sequence[float] | Array) -> Array:
    """Return the friction force (N) at constant sliding velocities (m/s), after the memory has settled, shape
    of ``speeds``.
    """
    p = law.parameters(pair)
    return np.array([steady_force(law, p, normal, float(speed)) for speed in speeds])


def steady_force(law: FrictionLaw, p: tuple[float, ...], normal: float, speed: float) -> float:
    """Return the friction force (N) at one sliding velocity, after at most 0.1 mm if the law has a memory."""
    mobility = 1e-9 * max(abs(speed), 1e-12) / normal  # so small that the force does not change the velocity
    dt, memory, last = 1e-8 / max(abs(speed), 1e-12), initial_memory(law), np.inf
    force = 0.0
    for n in range(10_000):
        force, next_memory = law.force(normal, speed, mobility, memory, dt, p)
        if next_memory == memory or (n % 100 == 99 and abs(force - last) <= 1e-9 * abs(force)):
            break
        last = force if n % 100 == 99 else last
        memory = next_memory
    return float(force)


def breakaway(law: FrictionLaw, pair: Pair, normal: float, speed: float = 1e-4) -> float:
    """Return the displacement (m) at which a law with memory, pulled slowly from rest, reaches 95 % of its
    largest force.
    """
    p = law.parameters(pair)
    for step in np.geomspace(1e-10, 1e-5, 26):
        memory, forces = initial_memory(law), []
        for _ in range(400):
            force, memory = law.force(normal, speed, 1e-9 * speed / normal, memory, float(step) / speed, p)
            forces.append(abs(force))
        reached = int(np.argmax(np.array(forces) >= 0.95 * max(forces)))
        if reached < 100:  # the 400 steps reach well beyond, so they contain the largest force
            return float((reached + 1) * step)
    return 1e-5


def presliding(
    law: FrictionLaw, pair: Pair, normal: float, amplitude: float, speed: float = 1e-4
) -> tuple[Array, Array]:
    """Return the displacement (m) and friction force (N), shape (samples,) each, of two slow cycles about the
    start.
    """
    p, count, memory, place = law.parameters(pair), 400, initial_memory(law), 0.0
    step = amplitude / count
    rows = [(0.0, 0.0)]
    for sense, strokes in ((1, 1), (-1, 2), (1, 2), (-1, 2), (1, 2)):
        for _ in range(strokes * count):
            force, memory = law.force(normal, sense * speed, 1e-9 * speed / normal, memory, step / speed, p)
            place += sense * step
            rows.append((place, float(force)))
    displacement, force_ = np.array(rows).T
    return displacement, force_
