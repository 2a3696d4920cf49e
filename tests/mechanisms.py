"""Mechanisms that hold one of each kind, and others that several rooms run."""

from __future__ import annotations

import math

from support import CONTACT_LAWS, contact_law, with_settings
from vfife.laws import Ambrosio, ContactLaw, FrictionLaw
from vfife.model.bodies import Section
from vfife.model.drivers import Harmonic, Ramp, Torque
from vfife.model.joints import ClearanceCurvedSlot, CurvedSlot
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism


def everything() -> Mechanism:
    """Every kind of joint, spring, gear and load beside each other."""
    m = Mechanism("everything", gravity=(0.0, -9.81))
    for name, x, y in (
        ("A", 0.0, 0.0),
        ("B", 1.0, 0.0),
        ("C", 2.0, 0.0),
        ("W", 0.0, -0.5),
        ("G", 1.5, -0.8),
        ("E", 0.3, 0.8),
        ("F", 0.6, 0.8),
    ):
        m.point(name, x, y)
    m.link("one", length=0.3, mass=1.0, angle=-0.3)
    m.link("two", length=0.3, mass=1.0, angle=0.5)
    m.revolute("a", "ground.A", "one.start")
    m.revolute("b", "ground.B", "two.start")
    m.gear("wheels", "one", "two", ratio=-0.5)
    for name, at in (("e", "E"), ("f", "F")):
        m.rigid_body(name, mass=1.0, inertia=0.01, position=m.points[at])
        m.revolute(name, f"ground.{at}", f"{name}.center")
    m.gear("belt", "e", "f", ratio=2.0)
    m.spring("coil", "one.end", "two.end", stiffness=300.0, damping=2.0, free_length=0.9)
    m.torsional_spring("spiral", "ground", "two", stiffness=2.0, damping=0.01)
    m.link("beam", length=0.5, model="elastic", elements=3, section=Section.round(0.004))
    m.weld("clamp", "ground.C", "beam.start")
    m.rigid_body("tip", mass=0.2, inertia=1e-3, position=(2.5, 0.0), pins={"q": (0.05, 0.02)})
    m.bushing("rubber", "beam.end", "tip.center", stiffness=(2e4, 2e4, 5.0), damping=(3.0, 3.0, 0.01))
    m.rigid_body("ball", mass=0.5, inertia=2e-4, position=(0.1, -0.44), velocity=(0.5, 0.0, 0.0))
    m.rigid_body("other", mass=0.5, inertia=2e-4, position=(0.5, -0.44), velocity=(-0.5, 0.0, 0.0))
    m.external_contact("floor", "ground.W", "ball.center", journal_radius=0.05, direction=(1.0, 0.0))
    m.external_contact("ledge", "ground.W", "other.center", journal_radius=0.05, direction=(1.0, 0.0))
    m.external_contact("balls", "ball.center", "other.center", journal_radius=0.05, bearing_radius=0.05)
    m.rigid_body("block", mass=0.5, inertia=1e-3, position=(1.5, -0.8))
    m.clearance_slider("guide", "ground.G", "block.center", clearance=1e-3, length=0.1, height=0.06)
    m.stop("cheeks", "ground", "one", low=-0.5, high=-0.2, stiffness=50.0, damping=0.1)
    m.loads["f"] = PointForce(name="f", at="tip.q", force=(0.0, 3.0), moment=0.1)
    m.drivers["one"] = Torque(body="one", value=(1.0, 0.0), speeds=(0.0, 50.0))
    return m


UNLOADING = ((0.0, 0.0), (1e-5, 1e3), (3e-4, 3e5))  # of the law that is a table


def every_law() -> Mechanism:
    """A spinning journal that flies against its bearing for each contact law, each with
    another friction law.
    """
    frictions = [law for law in FrictionLaw.registry.values() if law.__module__.startswith("vfife.")]
    m = Mechanism("every law")
    m.point("O", 0.0, 0.0)
    for k, law in enumerate(CONTACT_LAWS):
        m.rigid_body(law.name, mass=1.0, inertia=1e-4, velocity=(2.0, 0.5, 30.0), pins={"eye": (0.0, 0.0)})
        options = {
            "contact": contact_law(law, viscosity=0.4, unloading=UNLOADING),
            "friction": frictions[k % len(frictions)](),
        }
        m.clearance_joint(
            law.name,
            "ground.O",
            f"{law.name}.eye",
            clearance=2e-4,
            bearing_radius=0.01,
            axial_length=0.02,
            **options,
        )
    return m


def every_drive() -> Mechanism:
    """Bars beside each other, each moved in another way: prescribed, or by a torque or a force over time,
    speed or angle.
    """
    m = Mechanism("every drive", gravity=(0.3, -9.81))
    for name in ("ramp", "turned", "timed", "slowed", "hung", "pulled"):
        m.point(name, 0.0, 0.0)
        m.link(name, length=0.2, mass=1.0, angle=0.3)
        if name != "hung":
            m.revolute(name, f"ground.{name}", f"{name}.start")
    m.rigid_body("block", mass=1.0, inertia=1e-3)
    m.slider("rail", "ground.ramp", "block.center", direction=(0.6, 0.8))
    m.drivers["ramp"] = Ramp(body="ramp", speed=40.0, duration=4e-3)
    m.drivers["block"] = Harmonic(slider="rail", amplitude=0.01, frequency=50.0)
    m.drivers["hung"] = Harmonic(point="hung.start", direction=(0.0, 1.0), amplitude=0.01, frequency=100.0)
    m.drivers["turned"] = Torque(body="turned", value=(1.0, 0.0, 1.0), angles=(-math.pi, 0.0, math.pi))
    m.drivers["timed"] = Torque(body="timed", value=(0.0, 5.0, -3.0), times=(0.0, 2e-3, 5e-3))
    m.drivers["slowed"] = Torque(body="slowed", value=(1.0, 0.0), speeds=(0.0, 50.0))
    m.loads["along"] = PointForce(name="along", at="pulled.end", force=(3.0, 4.0), moment=0.1, follow=True)
    over_time = {"times": (0.0, 3e-3, 6e-3), "factors": (1.0, -1.0, 0.5)}
    m.loads["across"] = PointForce(
        name="across", at="slowed.end", force=(20.0, 5.0), follow=True, **over_time
    )
    return with_settings(m, damping=2.0)


def swing(contact: ContactLaw, lane: int = 0) -> Mechanism:
    """A ramp that drives, a torque and a force over time, gravity, damping, a pendulum with clearance hung
    from one without; other in each lane.
    """
    m = Mechanism("swing", gravity=(0.3, -9.81 - lane))
    m.point("O", 0.1, 0.2)
    m.link("arm", length=0.2, mass=1.0, angle=0.4)
    m.link("upper", length=0.3, mass=0.8, angle=-1.2)
    m.rigid_body(
        "lower",
        mass=0.5,
        inertia=2e-3,
        center=(0.1, 0.01),
        pins={"eye": (0.0, 0.0), "tip": (0.2, 0.05)},
        angle=-0.9,
    )
    m.revolute("O", "ground.O", "arm.start")
    m.revolute("P", "arm.end", "upper.start")
    friction = Ambrosio(coefficient=0.2, v0=1e-3, v1=1e-2)
    m.clearance_joint(
        "Q", "upper.end", "lower.eye", clearance=3e-4, bearing_radius=0.01, contact=contact, friction=friction
    )
    m.drivers["arm"] = Ramp(body="arm", speed=40.0 + lane, duration=0.004)
    m.drivers["lower"] = Torque(body="lower", value=(0.0, 5.0, -3.0, 1.0), times=(0.0, 0.002, 0.005, 0.01))
    m.loads["pull"] = PointForce(
        name="pull",
        at="lower.tip",
        force=(20.0, 5.0),
        moment=0.3,
        times=(0.0, 0.003, 0.006),
        factors=(1.0, -1.0, 0.5),
    )
    return with_settings(m, damping=2.0)


def geared_ring() -> Mechanism:
    """Three wheels on ground pins, geared in a ring: any two gears make the third superfluous."""
    m = Mechanism("ring")
    for k, name in enumerate("abc"):
        m.point(f"O{name}", 0.3 * k, 0.0)
        m.rigid_body(name, mass=1.0, inertia=0.01, pins={"axis": (0.0, 0.0)}, position=(0.3 * k, 0.0))
        m.revolute(f"J{name}", f"ground.O{name}", f"{name}.axis")
    for first, second, ratio in (("a", "b", -0.5), ("b", "c", -0.4), ("a", "c", 0.2)):
        m.gear(f"{first}{second}", first, second, ratio=ratio)
    m.drive("a", speed=100.0)
    return m


def beads() -> Mechanism:
    """One bead on a circle and one in a slot with clearance, which its wall stops within a few microseconds;
    a massless link between two more.
    """
    m = Mechanism("beads", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.point("P", 2.0, 0.0)
    m.rigid_body("bead", mass=1.0, inertia=0.01, position=(0.5, 0.0), velocity=(0.0, 1.0, 3.0))
    m.joints["slot"] = CurvedSlot(name="slot", bearing="ground.O", journal="bead.center", radius=0.5)
    m.rigid_body("loose", mass=1.0, inertia=0.01, position=(2.5, 0.0), velocity=(0.5, 0.2, -2.0))
    m.joints["play"] = ClearanceCurvedSlot(
        name="play",
        bearing="ground.P",
        journal="loose.center",
        radius=0.5,
        clearance=2e-6,
        journal_radius=0.01,
    )
    m.rigid_body("bob", mass=1.0, inertia=0.01, position=(0.0, -1.0), velocity=(1.0, 0.0, 1.0))
    m.distance("rope", "ground.O", "bob.center", length=1.0)
    return m


def snapping() -> Mechanism:
    """A damped block on a line, pushed off by a spring too long for its place: it comes to rest on one of two
    sides. A crank turns beside it.
    """
    m = Mechanism("snapping")
    m.point("O", 2.0, 0.0)
    m.point("P", 0.0, 0.0)
    m.point("Q", 0.0, 1.0)
    m.point("R", 0.0, 0.0)
    m.link("crank", length=0.1, mass=0.1)
    m.revolute("O", "ground.O", "crank.start")
    m.drive("crank", speed=20.0)
    m.rigid_body(
        "block",
        mass=1.0,
        inertia=0.01,
        position=(0.3, 0.0),
        velocity=(1.0, 0.0, 0.0),
        pins={"pin": (0.0, 0.0)},
    )
    m.slider("guide", "ground.P", "block.pin")
    m.spring("spring", "ground.Q", "block.pin", stiffness=800.0, damping=100.0, free_length=1.1)
    return m
