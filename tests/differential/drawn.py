"""Mechanisms made up from a seed, family by family."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np

from differential import constrained as plain
from differential.pencil import SOFT, Drawn, Pencil
from vfife.laws import Ambrosio, LankaraniNikravesh


def drawn(seed: int, family: str, again: int = 0) -> Drawn:
    """The mechanism of a seed and a family, or the next one of the same seed."""
    p = Pencil(seed, family, again)
    found: Drawn = {
        "chain": chain,
        "loop": loop,
        "gears": gears,
        "redundant": redundant,
        "contact": contact,
        "linked": linked,
        "between": between,
    }[family](p, seed)
    return found


def add_forces(p: Pencil, names: list[str]) -> None:
    for _ in range(int(p.rng.integers(0, 3))):
        one, two = p.rng.permutation([*names, "ground"])[:2]
        p.spring(str(one), str(two))
    if p.rng.integers(2):
        p.load(names[-1])


def chain(p: Pencil, seed: int) -> Drawn:
    """A tree of bodies in joints of every kind, with springs, a load, and a motor or a drive."""
    names: list[str] = []
    first = ""
    for _ in range(int(p.rng.integers(1, 5))):
        name = p.body()
        kind = p.one_of("revolute", "revolute", "slider", "slot", "weld")
        if names:
            p.join(p.one_of(*names, "ground"), name, kind)
        else:
            kind = p.one_of("revolute", "slider")
            first = p.join("ground", name, kind)
        names.append(name)
        if len(names) == 1:
            what = p.one_of("none", "motor", "drive", "drive")
            if what == "motor" and kind == "revolute":
                p.motor(name)
            elif what == "drive":
                p.turn_by_motor(name) if kind == "revolute" else p.push_by_motor(first)
    add_forces(p, names)
    return p.done(seed, "chain")


def loop(p: Pencil, seed: int) -> Drawn:
    """Four bars, five bars, slider-cranks: a chain from the ground and back, free or driven, with a body on
    it.
    """
    count = int(p.rng.integers(2, 5))
    corners = [
        0.5 * cmath.rect(1.0, 2.0 * math.pi * (k + p.real(-0.3, 0.3)) / (count + 1)) for k in range(count + 1)
    ]
    names: list[str] = []
    last = "ground"
    for k in range(count):
        name = p.body(0.5 * (corners[k] + corners[k + 1]) + p.spot(0.1))
        p.join(last, name, "revolute", corners[k])
        names.append(name)
        last = name
    p.join("ground", last, p.one_of("revolute", "slot") if count > 2 else "slot", corners[-1])
    if p.rng.integers(2):
        rider = p.body()
        p.join(p.one_of(*names), rider, p.one_of("revolute", "slider", "weld"))
        names.append(rider)
    what = p.one_of("none", "motor", "drive")
    if what == "motor":
        p.motor(names[0])
    elif what == "drive":
        p.turn_by_motor(names[0])
    add_forces(p, names)
    return p.done(seed, "loop")


def gears(p: Pencil, seed: int) -> Drawn:
    """Wheels on the ground in a train, with a rod hung on the last and a spring."""
    names: list[str] = []
    for k in range(int(p.rng.integers(2, 4))):
        wheel = p.body(complex(0.8 * k, 0.0))
        p.join("ground", wheel, "revolute")
        if names:
            p.gear(names[-1], wheel, p.one_of(-1.0, -0.4, 2.0, 0.7))
        names.append(wheel)
    rod = p.body()
    p.join(names[-1], rod, p.one_of("revolute", "slot"))
    p.motor(names[0]) if p.rng.integers(2) else p.turn_by_motor(names[0])
    add_forces(p, [*names, rod])
    return p.done(seed, "gears")


def redundant(p: Pencil, seed: int) -> Drawn:
    """More than is needed: a beam on three parallel cranks, a ring of wheels, a block in two guides, a weld
    beside a pin.
    """
    kind = ("cranks", "ring", "guides", "welds")[seed % 4]
    if kind == "cranks":
        arm, beam = cmath.rect(0.3, p.real(0.5, 2.6)), p.body()
        cranks = []
        for k in range(3):
            crank = p.body(complex(0.4 * k, 0.0))
            p.join("ground", crank, "revolute", complex(0.4 * k, 0.0))
            p.join(crank, beam, "revolute", 0.4 * k + arm)
            cranks.append(crank)
        names = [*cranks, beam]
    elif kind == "ring":
        names = []
        for k in range(3):
            wheel = p.body(complex(0.8 * k, 0.0))
            p.join("ground", wheel, "revolute")
            names.append(wheel)
        for one, two, ratio in ((0, 1, -0.5), (1, 2, -0.4), (0, 2, 0.2)):
            p.gear(names[one], names[two], ratio)
    elif kind == "guides":
        block = p.body()
        way = p.join("ground", block, "slider")
        guide = next(c for c in p.system.constraints if c.name == way)
        name, at = p.fresh("j"), p.near(block)
        (bearing, a, arm), (journal, b, brm) = p.pin("ground", at), p.pin(block, at)
        direction = guide.normal / 1j
        p.m.slider(name, bearing, journal, direction=(direction.real, direction.imag), turning=True)
        p.system.constraints.append(plain.Guide(name, a, arm, b, brm, guide.normal))
        rider = p.body()
        p.join(block, rider, "revolute")
        names = [block, rider]
    else:
        arm, other, rod = p.body(), p.body(), p.body()
        p.join("ground", arm, "revolute")
        p.join(arm, other, "weld")
        p.join(other, rod, "weld")
        p.join(rod, arm, "weld")
        names = [arm, other, rod]
    if kind != "guides":
        p.motor(names[0]) if p.rng.integers(2) else p.turn_by_motor(names[0])
    p.load(names[-1])
    return p.done(seed, "redundant")


def contact(p: Pencil, seed: int) -> Drawn:
    """A ball on a floor, two balls, a journal in a bearing, or an arm that strikes; friction grows over a
    range of speeds.
    """
    stiffness, e = SOFT[0] * p.real(0.5, 2.0), SOFT[1]
    friction = (p.real(0.05, 0.4), 0.0, p.real(0.05, 0.3))
    laws: dict[str, Any] = {
        "contact": LankaraniNikravesh(restitution=e, stiffness=stiffness),
        "friction": Ambrosio(coefficient=friction[0], v0=friction[1], v1=friction[2]),
    }
    kind = ("line", "round", "bearing", "arm")[seed % 4]
    r, name = p.real(0.05, 0.1), p.fresh("c")

    def touch(
        kind: str,
        one: tuple[str, int, complex],
        two: tuple[str, int, complex],
        other: float = 0.0,
        way: complex = 1.0 + 0j,
    ) -> None:
        p.system.touches.append(
            plain.Touch(
                name, kind, one[1], one[2], two[1], two[2], r, other, stiffness, e, friction, way / 1j
            )
        )

    ball = p.body(at=complex(0.0, 0.0))
    middle = p.where(ball)[0]
    if kind in ("line", "arm"):
        way = cmath.rect(1.0, p.real(-3.0, 3.0))
        up = 1j * way
        ground, journal = p.pin("ground", middle - (r + 0.002) * up + 0.1 * way), p.pin(ball, middle)
        p.m.external_contact(
            name, ground[0], journal[0], journal_radius=r, direction=(way.real, way.imag), **laws
        )
        touch("line", ground, journal, way=way)
        v = -p.real(0.3, 1.0) * up + p.real(-1.0, 1.0) * way
        if kind == "arm":
            p.join("ground", ball, "revolute", middle + p.real(0.3, 0.6) * way)
    elif kind == "round":
        other = p.body()
        target, r2 = p.where(other)[0], p.real(0.05, 0.1)
        toward = (target - middle) / abs(target - middle)
        place = target - toward * (r + r2 + 0.002)
        angle = p.turned(ball)
        p.system.q[p.number[ball]] = (place.real, place.imag, angle)
        origin = place - p.centre[ball] * cmath.rect(1.0, angle)
        object.__setattr__(p.m.bodies[ball], "position", (origin.real, origin.imag))
        bearing, journal = p.pin(other, target), p.pin(ball, place)
        p.m.external_contact(name, bearing[0], journal[0], journal_radius=r, bearing_radius=r2, **laws)
        touch("round", bearing, journal, r2)
        v = p.real(0.3, 1.0) * toward + 0.3 * p.spot(1.0)
    else:
        clearance = 0.002
        bearing, journal = p.pin("ground", middle), p.pin(ball, middle)
        p.m.clearance_joint(
            name, bearing[0], journal[0], clearance=clearance, bearing_radius=r + clearance, **laws
        )
        touch("bearing", bearing, journal, r + clearance)
        v = p.real(0.2, 0.6) * cmath.rect(1.0, p.real(-3.0, 3.0))
    wish = np.zeros((len(p.system.mass) - 1, 3))
    wish[0] = v.real, v.imag, p.real(-5.0, 5.0)
    if kind == "arm":  # about its pin, so that the round goes into the floor
        wish[0, 2] = 0.0
    velocity = p.system.projected(wish)
    for body, given in zip(list(p.m.bodies), velocity, strict=True):
        object.__setattr__(p.m.bodies[body], "velocity", tuple(float(x) for x in given))
    found = Drawn(seed, "contact", p.m, p.system, velocity)
    found.duration = 0.03
    return found


def between(p: Pencil, seed: int) -> Drawn:
    """A chain that swings from the ground, with a motion prescribed between two of its bodies: an angle, or
    the travel of a slider.
    """
    names: list[str] = []
    joint, count = "", int(p.rng.integers(2, 5))
    moved, sliding = int(p.rng.integers(1, count)), bool(seed % 2)
    for k in range(count):
        name = p.body()
        made = p.join(
            names[-1] if names else "ground", name, "slider" if k == moved and sliding else "revolute"
        )
        joint = made if k == moved else joint
        names.append(name)
    if sliding:
        p.push_by_motor(joint)
    else:
        p.turn_by_motor(names[moved], names[moved - 1])
    add_forces(p, names)
    return p.done(seed, "between")


def linked(p: Pencil, seed: int) -> Drawn:
    """An arm, a rod with clearance on it, another hung on that without, with clearance in the ground: forces
    of one joint with clearance move the other.
    """
    stiffness, e, friction = p.real(2e6, 6e6), 0.7, (p.real(0.05, 0.4), 0.0, p.real(0.1, 0.3))
    arm, rod, last = p.body(), p.body(), p.body()
    p.join("ground", arm, "revolute")
    p.join(rod, last, "revolute")
    for one, two in ((arm, rod), ("ground", last)):
        name, where, play, r = p.fresh("c"), p.near(two), p.real(5e-4, 1e-3), p.real(0.03, 0.05)
        bearing, journal = p.pin(one, where), p.pin(two, where)
        p.m.clearance_joint(
            name, bearing[0], journal[0], clearance=play, bearing_radius=r + play,
            contact=LankaraniNikravesh(restitution=e, stiffness=stiffness),
            friction=Ambrosio(coefficient=friction[0], v0=friction[1], v1=friction[2]),
        )  # fmt: skip
        touch = plain.Touch(
            name,
            "bearing",
            bearing[1],
            bearing[2],
            journal[1],
            journal[2],
            r,
            r + play,
            stiffness,
            e,
            friction,
        )
        p.system.touches.append(touch)
    found = p.done(seed, "linked")
    found.duration, found.finer, p.system.longest = 0.008, 4, 1e-4
    return found
