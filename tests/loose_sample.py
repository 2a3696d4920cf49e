"""A sample of mechanisms with contact: each drawn once in the package's nouns and, where its laws allow, once
as plain equations.

Kinds: driven six-bars, slider-cranks with an offset, scotch yokes with loose pins, chains of one to four hung
bodies, a crank turned by a torque, quick-returns, pins in curved slots, blocks in loose guides, cams, balls
and arms on floors, shaken journals, rods on springs.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from differential import constrained as plain
from differential.pencil import Drawn, Pencil
from support import with_settings
from vfife.laws import (
    Ambrosio,
    BengisuAkay,
    BrownMcPhee,
    Coulomb,
    Flores,
    Frictionless,
    Gonthier,
    HuntCrossley,
    LankaraniNikravesh,
    Threlfall,
)
from vfife.model.drivers import Harmonic, Torque
from vfife.model.mechanism import Mechanism

EACH = 18  # of a kind in a sample
# Seeds below this were looked at when the constants of measures/convergence.py were chosen; those from it on
# were not.
FRESH = 18


class Draft(Pencil):
    """Draws rods between places, ideal pins and loose ones, and what drives them."""

    def __init__(self, seed: int, kind: int) -> None:
        self.rng = np.random.default_rng([seed, kind, 25])
        self.at_rest = False
        self.gravity = complex(0.0, -9.81)
        self.m = Mechanism(f"kind {kind}, {seed}", gravity=(0.0, -9.81))
        self.system = plain.System()
        self.system.forces.append(plain.weight(self.system.mass, self.gravity))
        self.number = {"ground": 0}
        self.centre = {"ground": 0j}
        self.count = 0
        self.plain = True
        friction = (
            (0.0, 0.0, 1.0)
            if self.rng.integers(3) == 0
            else (self.real(0.02, 0.2), 1e-3, self.real(0.02, 0.1))
        )
        self.touching = self.real(0.5, 0.95), 10.0 ** self.real(7.5, 9.5), friction

    def rod(self, p: complex, q: complex, mass: float | None = None) -> str:
        """A rod from a place to another."""
        name, way = self.fresh("b"), q - p
        mass = self.real(0.2, 1.5) if mass is None else mass
        middle, angle, inertia = 0.5 * (p + q), cmath.phase(way), mass * abs(way) ** 2 / 12.0 + 1e-5
        self.m.rigid_body(name, mass=mass, inertia=inertia, angle=angle, position=(middle.real, middle.imag))
        self.number[name], self.centre[name] = len(self.system.mass), 0j
        self.system.mass.append((mass, inertia))
        self.system.q.append((middle.real, middle.imag, angle))
        return name

    def laws(self) -> dict[str, Any]:
        e, stiffness, (coefficient, v0, v1) = self.touching
        friction = Ambrosio(coefficient=coefficient, v0=v0, v1=v1) if coefficient else Frictionless()
        return {"contact": LankaraniNikravesh(restitution=e, stiffness=stiffness), "friction": friction}

    def other_laws(self) -> dict[str, Any]:
        """Laws that the plain equations do not have."""
        self.plain = False
        e, rub = self.real(0.5, 0.95), self.real(0.02, 0.2)
        contact = self.one_of(
            Flores(restitution=e),
            HuntCrossley(restitution=e),
            Gonthier(restitution=e),
            LankaraniNikravesh(restitution=e),
        )
        friction = self.one_of(
            Frictionless(),
            Coulomb(coefficient=rub),
            BrownMcPhee(coefficient=rub, static_coefficient=1.2 * rub, transition_speed=1e-2),
            Threlfall(coefficient=rub, v1=0.05),
            BengisuAkay(coefficient=rub, static_coefficient=1.2 * rub, v0=1e-2, decay=100.0),
        )
        return {"contact": contact, "friction": friction}

    def loose(self, one: str, two: str, at: complex, clearance: float | None = None) -> None:
        """A revolute with clearance."""
        name, play, r = self.fresh("c"), self.real(5e-5, 4e-4) if clearance is None else clearance, 0.01
        (bearing, a, arm), (journal, b, brm) = self.pin(one, at), self.pin(two, at)
        e, stiffness, friction = self.touching
        laws = self.laws() if self.plain else self.other_laws()
        self.m.clearance_joint(name, bearing, journal, clearance=play, bearing_radius=r + play, **laws)
        self.system.touches.append(
            plain.Touch(name, "bearing", a, arm, b, brm, r, r + play, stiffness, e, friction)
        )

    def drive_at(self, body: str, speed: float) -> None:
        self.m.drive(body, speed=speed)
        self.system.constraints.append(
            plain.Turn("motor", 0, self.number[body], 1.0, lambda t: (speed * t, speed, 0.0))
        )

    def finished(
        self, kind: str, seed: int, *, turns: float | None = None, duration: float | None = None
    ) -> Drawn:
        """With the velocities of the mechanism without clearance, unless it has none to move with."""
        pins = [plain.Pin(t.name, t.a, t.at, t.b, t.bt) for t in self.system.touches if t.kind == "bearing"]
        self.system.constraints += pins
        velocity = self.system.projected(np.zeros((len(self.system.mass) - 1, 3)))
        self.system.constraints = [one for one in self.system.constraints if one not in pins]
        driven = {driver.body for driver in self.m.drivers.values() if driver.moves}
        for name, body in self.m.bodies.items():
            if name not in driven:
                object.__setattr__(body, "velocity", tuple(float(x) for x in velocity[self.number[name] - 1]))
        m = with_settings(self.m, **({"turns": turns} if turns else {"duration": duration}))
        found = Drawn(seed, kind, m, self.system, velocity)
        found.reactions = ["plain"] if self.plain else []
        return found


def meeting(p: complex, r: float, q: complex, s: float, side: float) -> complex:
    """The corner of two rods from p and q, to the left (1) or the right (-1) of the way between."""
    d = abs(q - p)
    x = (d * d + r * r - s * s) / (2.0 * d)
    return p + (q - p) / d * complex(x, side * math.sqrt(r * r - x * x))


def hung(p: Draft, seed: int) -> Drawn:
    """A chain of one to four bodies let go; some or all of its pins are loose."""
    at, angle = 0j, p.real(-2.2, -0.9)
    last, count = "ground", 1 + seed % 4
    for k in range(count):
        end = at + p.real(0.1, 0.3) * cmath.rect(1.0, angle + p.real(-0.3, 0.3))
        rod = p.rod(at, end)
        if k == 0 or p.rng.integers(2):
            p.loose(last, rod, at)
        else:
            p.join(last, rod, "revolute", at)
        last, at = rod, end
    return p.finished("hung", seed, duration=0.12)


def six_bar(p: Draft, seed: int) -> Drawn:
    """A driven four-bar with a dyad on its rocker; one or two pins are loose."""
    r = p.real(0.04, 0.07)
    b, d = cmath.rect(r, p.real(-3.0, 3.0)), 0.25 + 0j
    c = meeting(b, p.real(0.21, 0.25), d, 0.18, 1.0)
    g = d + complex(p.real(0.28, 0.32), p.real(0.0, 0.06))
    e = d + 0.5 * (c - d)
    f = meeting(e, 0.3, g, 0.26, 1.0)
    crank, coupler, rocker, link, last = p.rod(0j, b), p.rod(b, c), p.rod(d, c), p.rod(e, f), p.rod(g, f)
    loose = ("c", "e", "f", "cf", "ef")[p.rng.integers(5)]
    p.join("ground", crank, "revolute", 0j)
    p.join(crank, coupler, "revolute", b)
    p.join("ground", rocker, "revolute", d)
    p.join("ground", last, "revolute", g)
    for name, one, two, at in (("c", coupler, rocker, c), ("e", rocker, link, e), ("f", link, last, f)):
        p.loose(one, two, at) if name in loose else p.join(one, two, "revolute", at)
    p.drive_at(crank, p.real(20.0, 100.0))
    return p.finished("six-bar", seed, turns=1.5)


def offset_crank(p: Draft, seed: int, speed: bool = True) -> Drawn:
    """A slider-crank with an offset; crank pin or wrist pin is loose."""
    r, offset = p.real(0.03, 0.06), p.real(-0.03, 0.03)
    b = cmath.rect(r, p.real(-3.0, 3.0))
    length = p.real(0.15, 0.25)
    c = complex(b.real + math.sqrt(length**2 - (offset - b.imag) ** 2), offset)
    crank, rod, block = p.rod(0j, b), p.rod(b, c), p.rod(c - 0.02, c + 0.02)
    loose = ("b", "c", "bc")[p.rng.integers(3)]
    p.join("ground", crank, "revolute", 0j)
    p.loose(crank, rod, b) if "b" in loose else p.join(crank, rod, "revolute", b)
    p.loose(rod, block, c) if "c" in loose else p.join(rod, block, "revolute", c)
    name, ((bearing, a, arm), (journal, k, brm)) = p.fresh("j"), (p.pin("ground", c), p.pin(block, c))
    p.m.slider(name, bearing, journal, direction=(1.0, 0.0))
    p.system.constraints += [plain.Guide(name, a, arm, k, brm, 1j), plain.Turn(name, a, k)]
    if speed:
        p.drive_at(crank, p.real(20.0, 120.0))
        return p.finished("offset slider-crank", seed, turns=1.5)
    torque = p.real(1.0, 5.0)
    p.m.drivers["motor"] = Torque(body=crank, value=torque)
    number = p.number[crank]

    def push(t: float, s: plain.Now, force: np.ndarray) -> None:
        force[number, 2] += torque

    p.system.forces.append(push)
    return p.finished("torque", seed, duration=0.1)


def torque(p: Draft, seed: int) -> Drawn:
    """The same turned by a torque."""
    return offset_crank(p, seed, speed=False)


def yoke(p: Draft, seed: int) -> Drawn:
    """A scotch yoke: the crank's pin is loose in a block that slides in the yoke, or the block is loose on
    nothing and the pin ideal.
    """
    r = p.real(0.03, 0.06)
    b = cmath.rect(r, p.real(-3.0, 3.0))
    crank, block, slide = (
        p.rod(0j, b),
        p.rod(b - 0.01, b + 0.01, 0.3),
        p.rod(complex(b.real, -0.1), complex(b.real, 0.1)),
    )
    p.join("ground", crank, "revolute", 0j)
    p.loose(crank, block, b)
    for one, two, way in ((slide, block, 1j), ("ground", slide, 1.0 + 0j)):
        name, ((bearing, a, arm), (journal, k, brm)) = p.fresh("j"), (p.pin(one, b), p.pin(two, b))
        local = way * cmath.rect(1.0, -(p.turned(one) if one != "ground" else 0.0))
        p.m.slider(name, bearing, journal, direction=(local.real, local.imag))
        p.system.constraints += [plain.Guide(name, a, arm, k, brm, 1j * local), plain.Turn(name, a, k)]
    p.drive_at(crank, p.real(20.0, 100.0))
    return p.finished("yoke", seed, turns=1.5)


def quick_return(p: Draft, seed: int) -> Drawn:
    """A crank whose pin, loose in a block, drives a slotted lever."""
    r = p.real(0.03, 0.06)
    b, o = cmath.rect(r, p.real(-3.0, 3.0)), complex(0.0, -0.15)
    lever_way = (b - o) / abs(b - o)
    crank, block, lever = (
        p.rod(0j, b),
        p.rod(b - 0.01 * lever_way, b + 0.01 * lever_way, 0.3),
        p.rod(o, o + 0.3 * lever_way),
    )
    p.join("ground", crank, "revolute", 0j)
    p.join("ground", lever, "revolute", o)
    p.loose(crank, block, b)
    name, ((bearing, a, arm), (journal, k, brm)) = p.fresh("j"), (p.pin(lever, b), p.pin(block, b))
    p.m.slider(name, bearing, journal, direction=(1.0, 0.0))
    p.system.constraints += [plain.Guide(name, a, arm, k, brm, 1j), plain.Turn(name, a, k)]
    p.drive_at(crank, p.real(20.0, 80.0))
    return p.finished("quick-return", seed, turns=1.5)


def sprung(p: Draft, seed: int) -> Drawn:
    """A rod in a loose bearing, held by a spring, with another hung on it."""
    end = p.real(0.15, 0.3) * cmath.rect(1.0, p.real(-0.5, 0.5))
    rod = p.rod(0j, end)
    p.loose("ground", rod, 0j)
    k, c = p.real(200.0, 3000.0), p.real(0.5, 5.0)
    (first, a, arm), (second, b, brm) = p.pin("ground", end + 0.2j), p.pin(rod, end)
    p.m.spring("spring", first, second, stiffness=k, damping=c, free_length=0.18)
    p.system.forces.append(plain.spring(a, arm, b, brm, k, c, 0.18))
    if seed % 2:
        other = p.rod(end, end - 0.15j)
        p.loose(rod, other, end)
    return p.finished("sprung", seed, duration=0.12)


def thrown(p: Draft, seed: int) -> Drawn:
    """A ball on a sloping floor, or an arm that strikes it."""
    r, way, name = p.real(0.03, 0.06), cmath.rect(1.0, p.real(-0.3, 0.3)), p.fresh("c")
    ball = p.rod(-0.01 + 0j, 0.01 + 0j, p.real(0.3, 1.5))
    up = 1j * way
    e, stiffness, friction = p.touching
    (bearing, a, arm), (journal, b, brm) = p.pin("ground", -(r + p.real(0.002, 0.01)) * up), p.pin(ball, 0j)
    p.m.external_contact(name, bearing, journal, journal_radius=r, direction=(way.real, way.imag), **p.laws())
    p.system.touches.append(
        plain.Touch(name, "line", a, arm, b, brm, r, 0.0, stiffness, e, friction, way / 1j)
    )
    if seed % 2:
        p.join("ground", ball, "revolute", p.real(0.2, 0.5) * way)
    found = p.finished("thrown", seed, duration=0.1)
    wish = np.array([[p.real(-0.5, 0.5), -p.real(0.2, 1.0), 0.0 if seed % 2 else p.real(-10.0, 10.0)]])
    found.velocity = p.system.projected(wish)
    object.__setattr__(found.m.bodies[ball], "velocity", tuple(float(x) for x in found.velocity[0]))
    return found


def guide(p: Draft, seed: int) -> Drawn:
    """A slider-crank whose block has clearance in its guide."""
    r, length = p.real(0.03, 0.06), p.real(0.15, 0.25)
    b = cmath.rect(r, p.real(-3.0, 3.0))
    c = complex(b.real + math.sqrt(length**2 - b.imag**2), 0.0)
    crank, rod, block = p.rod(0j, b), p.rod(b, c), p.rod(c - 0.03, c + 0.03)
    p.join("ground", crank, "revolute", 0j)
    p.join(crank, rod, "revolute", b)
    p.join(rod, block, "revolute", c)
    (bearing, *_), (journal, *_) = p.pin("ground", c), p.pin(block, c)
    p.m.clearance_slider(
        "guide", bearing, journal, clearance=p.real(5e-5, 4e-4), length=0.06, height=0.04, **p.other_laws()
    )
    name = "guide"
    p.system.constraints += [
        plain.Guide(name, 0, c, p.number[block], 0j, 1j),
        plain.Turn(name, 0, p.number[block]),
    ]
    p.drive_at(crank, p.real(20.0, 100.0))
    return p.finished("guide", seed, turns=1.5)


def slot(p: Draft, seed: int) -> Drawn:
    """A driven crank and a rod whose end runs with clearance in a round slot."""
    r, radius = p.real(0.03, 0.05), 0.3
    centre = complex(0.0, -0.15)  # so far from the crank that rod and slot never line up
    b = cmath.rect(r, p.real(-3.0, 3.0))
    c = meeting(b, 0.25, centre, radius, -1.0)
    crank, rod = p.rod(0j, b), p.rod(b, c)
    p.join("ground", crank, "revolute", 0j)
    p.join(crank, rod, "revolute", b)
    (bearing, *_), (journal, *_) = p.pin("ground", centre), p.pin(rod, c)
    p.m.clearance_curved_slot(
        "slot",
        bearing,
        journal,
        clearance=p.real(5e-5, 4e-4),
        journal_radius=0.01,
        radius=radius,
        **p.other_laws(),
    )
    p.drive_at(crank, p.real(20.0, 80.0))
    p.system.constraints.append(
        plain.Pin(
            "hold", 0, centre, p.number[rod], (centre - c) * cmath.rect(1.0, -p.turned(rod)) + abs(c - b) / 2
        )
    )
    found = p.finished("slot", seed, turns=1.5)
    return found


def cam(p: Draft, seed: int) -> Drawn:
    """An eccentric round that turns at constant speed under a lever with a spring, or one that falls back on
    it.
    """
    ecc, r = p.real(0.003, 0.008), p.real(0.03, 0.05)
    at = cmath.rect(ecc, p.real(-3.0, 3.0))
    shaft = p.rod(0j, at)
    p.join("ground", shaft, "revolute", 0j)
    roller = 0.02
    top = at + complex(0.0, r + roller + p.real(1e-4, 1e-3))
    pivot = top - complex(0.2, 0.0)
    lever = p.rod(pivot, top)
    p.join("ground", lever, "revolute", pivot)
    (bearing, *_), (journal, *_) = p.pin(shaft, at), p.pin(lever, top)
    p.m.external_contact("cam", bearing, journal, journal_radius=roller, bearing_radius=r, **p.other_laws())
    (first, *_), (second, *_) = p.pin("ground", top + 0.2j), p.pin(lever, top)
    p.m.spring(
        "spring", first, second, stiffness=p.real(500.0, 4000.0), damping=p.real(1.0, 5.0), free_length=0.3
    )
    p.drive_at(shaft, p.real(20.0, 80.0))
    return p.finished("cam", seed, turns=1.5)


def shaken(p: Draft, seed: int) -> Drawn:
    """A rod in a loose bearing on a body that is shaken."""
    p.plain = False
    base = p.rod(-0.05 + 0j, 0.05 + 0j)
    (bearing, *_), (journal, *_) = p.pin("ground", 0j), p.pin(base, 0j)
    p.m.slider("way", bearing, journal, direction=(1.0, 0.0))
    p.system.constraints += [
        plain.Guide("way", 0, 0j, p.number[base], 0j, 1j),
        plain.Turn("way", 0, p.number[base]),
    ]
    p.m.drivers["shaker"] = Harmonic(slider="way", amplitude=p.real(1e-3, 8e-3), frequency=p.real(10.0, 30.0))
    rod = p.rod(0j, p.real(0.1, 0.25) * cmath.rect(1.0, p.real(-2.0, -1.2)))
    p.loose(base, rod, 0j)
    return p.finished("shaken", seed, duration=0.15)


def other_four_bar(p: Draft, seed: int) -> Drawn:
    """A driven four-bar of other laws with loose pins at its ground and its rocker."""
    p.plain = False
    b, d = cmath.rect(p.real(0.04, 0.07), p.real(-3.0, 3.0)), 0.25 + 0j
    c = meeting(b, 0.23, d, 0.18, -1.0)
    crank, coupler, rocker = p.rod(0j, b), p.rod(b, c), p.rod(d, c)
    p.join("ground", crank, "revolute", 0j)
    p.join(crank, coupler, "revolute", b)
    p.loose(coupler, rocker, c)
    p.loose("ground", rocker, d) if seed % 2 else p.join("ground", rocker, "revolute", d)
    p.drive_at(crank, p.real(20.0, 120.0))
    return p.finished("other laws", seed, turns=1.5)


KINDS: dict[str, Callable[[Draft, int], Drawn]] = {
    "hung": hung, "six-bar": six_bar, "offset": offset_crank, "torque": torque, "yoke": yoke,
    "quick-return": quick_return, "sprung": sprung, "thrown": thrown, "guide": guide, "slot": slot,
    "cam": cam, "shaken": shaken, "other laws": other_four_bar,
}  # fmt: skip


def drawn(kind: str, seed: int) -> Drawn:
    """The mechanism of a kind and a seed."""
    return KINDS[kind](Draft(seed, list(KINDS).index(kind)), seed)
