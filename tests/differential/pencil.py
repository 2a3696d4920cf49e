"""Draws a mechanism body by body, once in the package's nouns and once as plain equations; both are closed as
they are drawn.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from differential import constrained as plain
from vfife.model.drivers import ConstantSpeed, Harmonic, Ramp, StepTo, Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism

FAMILIES = ("chain", "loop", "gears", "redundant", "contact", "linked", "between")
DURATION = 0.06  # s
SOFT = (2e4, 0.7)  # N/m^1.5 and restitution of what touches


@dataclass
class Drawn:
    """A mechanism, its equations, the velocities of its free bodies at the start, and which of its joints
    have reactions of their own.
    """

    seed: int
    family: str
    m: Mechanism
    system: plain.System
    velocity: np.ndarray
    duration: float = DURATION
    finer: int = 1  # times as many steps as others
    reactions: list[str] = field(default_factory=list)

    @property
    def label(self) -> str:
        return f"{self.family}-{self.seed}"


class Pencil:
    """Draws body by body; each joint is put where it is closed."""

    def __init__(self, seed: int, family: str, again: int = 0) -> None:
        self.rng = np.random.default_rng([seed, FAMILIES.index(family), again])
        self.at_rest = seed % 3 == 0 and family not in (
            "contact",
            "linked",
        )  # only then a centre of mass is not at its body's origin
        g = complex(*self.rng.uniform(-10.0, 10.0, 2))
        self.m = Mechanism(f"{family} {seed}", gravity=(g.real, g.imag))
        self.system = plain.System()
        self.system.forces.append(plain.weight(self.system.mass, g))
        self.number = {"ground": 0}
        self.centre: dict[str, complex] = {"ground": 0j}  # of mass, in the body's frame
        self.count = 0

    def fresh(self, letter: str) -> str:
        self.count += 1
        return f"{letter}{self.count}"

    def real(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def spot(self, size: float) -> complex:
        return complex(*self.rng.uniform(-size, size, 2))

    def one_of(self, *options: Any) -> Any:
        return options[self.rng.integers(len(options))]

    # ------------------------------------------------------------------------------------------------- bodies

    def body(self, at: complex | None = None) -> str:
        """A rigid body somewhere."""
        name, origin, angle = self.fresh("b"), self.spot(1.0) if at is None else at, self.real(-3.0, 3.0)
        mass, inertia, centre = (
            self.real(0.3, 3.0),
            self.real(0.05, 0.5),
            self.spot(0.3) if self.at_rest else 0j,
        )
        self.m.rigid_body(
            name,
            mass=mass,
            inertia=inertia,
            center=(centre.real, centre.imag),
            angle=angle,
            position=(origin.real, origin.imag),
        )
        self.number[name], self.centre[name] = len(self.system.mass), centre
        self.system.mass.append((mass, inertia))
        middle = origin + centre * cmath.rect(1.0, angle)
        self.system.q.append((middle.real, middle.imag, angle))
        return name

    def where(self, body: str) -> tuple[complex, float]:
        x, y, angle = self.system.q[self.number[body]]
        return complex(x, y), angle

    def near(self, body: str, size: float = 0.5) -> complex:
        return (self.where(body)[0] if body != "ground" else 0j) + self.spot(size)

    def pin(self, body: str, world: complex) -> tuple[str, int, complex]:
        """A pin of a body at a place: what the package calls it, the body's number, and the pin seen from the
        centre of mass.
        """
        name = self.fresh("p")
        middle, angle = self.where(body)
        arm = (world - middle) * cmath.rect(1.0, -angle)
        local = arm + self.centre[body]
        if body == "ground":
            self.m.point(name, local.real, local.imag)
        else:
            self.m.bodies[body].pins[name] = (local.real, local.imag)  # type: ignore[union-attr]
        return f"{body}.{name}", self.number[body], arm

    def turned(self, body: str) -> float:
        return self.where(body)[1]

    # ------------------------------------------------------------------------------------------------- joints

    def join(self, one: str, two: str, kind: str, at: complex | None = None) -> str:
        name, where = self.fresh("j"), self.near(two) if at is None else at
        (bearing, a, arm), (journal, b, brm) = self.pin(one, where), self.pin(two, where)
        if kind in ("revolute", "weld"):
            self.system.constraints.append(plain.Pin(name, a, arm, b, brm))
            getattr(self.m, kind)(name, bearing, journal)
        else:
            way = cmath.rect(1.0, self.real(-3.0, 3.0))
            self.m.slider(name, bearing, journal, direction=(way.real, way.imag), turning=kind == "slot")
            self.system.constraints.append(plain.Guide(name, a, arm, b, brm, 1j * way))
        if kind in ("weld", "slider"):
            self.system.constraints.append(plain.Turn(name, a, b))
        return name

    def gear(self, one: str, two: str, ratio: float) -> str:
        name = self.fresh("g")
        self.m.gear(name, one, two, ratio=ratio)
        self.system.constraints.append(plain.Turn(name, self.number[one], self.number[two], ratio))
        return name

    # ------------------------------------------------------------------------------------------------- forces

    def spring(self, one: str, two: str) -> None:
        kind, name = self.one_of("spring", "coil", "rubber"), self.fresh("s")
        k, c = self.real(10.0, 300.0), self.real(0.1, 8.0)
        if kind == "coil":
            free = self.turned(two) - self.turned(one) + self.real(-1.0, 1.0)
            self.m.torsional_spring(name, one, two, stiffness=0.1 * k, damping=0.1 * c, free_angle=free)
            self.system.forces.append(plain.coil(self.number[one], self.number[two], 0.1 * k, 0.1 * c, free))
            return
        (first, a, arm), (second, b, brm) = self.pin(one, self.near(one)), self.pin(two, self.near(two))
        if kind == "spring":
            free = self.real(0.2, 1.0)
            self.m.spring(name, first, second, stiffness=k, damping=c, free_length=free)
            self.system.forces.append(plain.spring(a, arm, b, brm, k, c, free))
        else:
            stiffness, damping = (k, 0.5 * k, 0.1 * k), (c, 2.0 * c, 0.1 * c)
            self.m.bushing(name, first, second, stiffness=stiffness, damping=damping)
            self.system.forces.append(
                plain.rubber(a, arm, b, brm, stiffness, damping, self.turned(two) - self.turned(one))
            )

    def load(self, body: str) -> None:
        name, (pin, number, arm) = self.fresh("f"), self.pin(body, self.near(body))
        force, moment, follow = 20.0 * self.spot(1.0), self.real(-3.0, 3.0), bool(self.rng.integers(2))
        self.m.loads[name] = PointForce(
            name=name, at=pin, force=(force.real, force.imag), moment=moment, follow=follow
        )
        self.system.forces.append(plain.load(number, arm, force, moment, follow))

    def motor(self, body: str) -> None:
        stall, fastest = self.real(-5.0, 5.0), self.real(5.0, 20.0)
        self.m.drivers["motor"] = Torque(body=body, value=(stall, 0.0), speeds=(0.0, fastest))
        self.system.forces.append(plain.motor(self.number[body], stall, fastest))
        self.system.breaks.append(DURATION)  # it has kinks at rest and at its fastest

    # ------------------------------------------------------------------------------------------------- drives

    def drive(self, **target: Any) -> plain.Law:
        """A prescribed motion, and its value, rate and second derivative written out."""
        kind = (
            self.one_of("ramp", "step")
            if self.at_rest
            else self.one_of("constant", "ramp", "step", "harmonic")
        )
        if kind == "constant":
            speed = self.real(-8.0, 8.0)
            self.m.drivers["motor"] = ConstantSpeed(**target, speed=speed)
            return lambda t: (speed * t, speed, 0.0)
        if kind == "harmonic":
            size, hertz, phase = self.real(0.02, 0.2), self.real(2.0, 15.0), self.real(-3.0, 3.0)
            self.m.drivers["motor"] = Harmonic(**target, amplitude=size, frequency=hertz, phase=phase)
            w = 2.0 * math.pi * hertz
            return lambda t: (
                size * math.sin(w * t + phase),
                size * w * math.cos(w * t + phase),
                -size * w * w * math.sin(w * t + phase),
            )
        long = self.real(0.3, 0.8) * DURATION  # a kink is felt for some steps
        self.system.breaks.append(long)
        if kind == "step":
            way = self.real(-0.4, 0.4)
            self.m.drivers["motor"] = StepTo(**target, travel=way, duration=long)

            def step(t: float) -> tuple[float, float, float]:
                s = min(t / long, 1.0)
                rate, second = 30.0 * s**2 * (1.0 - s) ** 2, 60.0 * s - 180.0 * s**2 + 120.0 * s**3
                return (
                    way * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5),
                    way * rate / long,
                    way * second / long**2,
                )

            return step
        speed = self.real(-8.0, 8.0)
        self.m.drivers["motor"] = Ramp(**target, speed=speed, duration=long)

        def ramp(t: float) -> tuple[float, float, float]:
            s = min(t / long, 1.0)
            return (
                0.0,
                speed * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5),
                speed * 30.0 * s**2 * (1.0 - s) ** 2 / long,
            )

        return ramp

    def turn_by_motor(self, body: str, against: str = "ground") -> None:
        law = self.drive(body=body, against=against)
        self.system.constraints.append(plain.Turn("motor", self.number[against], self.number[body], 1.0, law))

    def push_by_motor(self, slider: str) -> None:
        guide = next(c for c in self.system.constraints if c.name == slider and isinstance(c, plain.Guide))
        law = self.drive(slider=slider)
        self.system.constraints.append(
            plain.Guide("motor", guide.a, guide.at, guide.b, guide.bt, guide.normal / 1j, law)
        )

    # ------------------------------------------------------------------------------------------------------
    # velocities

    def done(self, seed: int, family: str) -> Drawn:
        """With velocities that the constraints allow, those of the bodies that no drive turns being given to
        the package.
        """
        wish = self.rng.uniform(-3.0, 3.0, (len(self.system.mass) - 1, 3)) * (not self.at_rest)
        velocity = self.system.projected(wish)
        turned = {
            driver.body for driver in self.m.drivers.values() if driver.moves and driver.against == "ground"
        }
        for name, body in list(self.m.bodies.items()):
            if name in turned:
                continue
            given = velocity[self.number[name] - 1]
            object.__setattr__(body, "velocity", tuple(float(x) for x in given))
        return Drawn(seed, family, self.m, self.system, velocity)
