"""Mechanisms rich in contacts, tables, drivers and frames, each in lanes with parameters of their own: what
loops are compared by.
"""

import dataclasses
import math

import mechanisms
from support import CONTACT_LAWS, SQUARE, contact_law, four_bar, with_settings
from vfife.laws import Ambrosio, Frictionless, Hydrodynamic, LankaraniNikravesh, Pereira
from vfife.model.drivers import Harmonic, Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.wear import Wear

LANES = 4


def rigid_bars(lane: int) -> Mechanism:
    """Case c: three clearance joints that share bodies, friction with its moments."""
    return four_bar(
        "BCD",
        clearance=2e-4 * (1 + 0.4 * lane),
        joint={"friction_moment": ("mid-overlap", "surface", "off", "mid-overlap")[lane]},
    )


def worn_bars(lane: int) -> Mechanism:
    """The same of worn bearings and journals, of which more wears off; one joint of the three
    is round still.
    """
    m = rigid_bars(0)
    for name, worn in (
        ("B", ((2e-5, 1e-5, 3e-6, 0.0, 4e-6), ())),
        ("C", ((1e-5, 0.0, 8e-6), (1.5e-5, 1e-6 * lane, 0.0, 3e-6, 2e-6, 0.0, 1e-6))),
    ):
        wear = Wear(bearing=1e-14, journal=1e-15, bearing_profile=worn[0], journal_profile=worn[1])
        m.joints[name] = dataclasses.replace(m.joints[name], wear=wear)
    m.joints["D"] = dataclasses.replace(m.joints["D"], wear=Wear(bearing=1e-14))
    return m


def two_particle_bars(lane: int) -> Mechanism:
    """The paper's links: a frame element each, joints with particles of their own and other laws each, one
    with a power of the depth.
    """
    m = four_bar(
        "BCD",
        "two-particle",
        clearance=1e-4 * (1 + lane),
        friction=Ambrosio(coefficient=0.1, v0=0.01, v1=0.1),
        section=SQUARE,
    )
    m.joints["C"] = dataclasses.replace(m.joints["C"], contact=Pereira(restitution=0.5))
    m.joints["D"] = dataclasses.replace(m.joints["D"], friction=Frictionless())
    return m


def one_clearance(lane: int) -> Mechanism:
    """Case b: a clearance joint between bodies that hang in ideal joints."""
    return four_bar(
        "C",
        clearance=2e-4 * (1 + 0.4 * lane),
        contact=LankaraniNikravesh(restitution=0.9 - 0.2 * lane, stiffness=6.6e10),
    )


def elastic_bars(lane: int) -> Mechanism:
    """Frame elements and ideal joints."""
    return four_bar("", "elastic", speed=50 * math.pi * (1 - 0.1 * lane), elements=2, section=SQUARE)


def swing(lane: int) -> Mechanism:
    """Drivers and loads over time, damping, a joint with clearance on one without."""
    return mechanisms.swing(LankaraniNikravesh(restitution=0.8, stiffness=1e9), lane)


def journals(lane: int) -> Mechanism:
    """Every contact law there is, in one topology: laws of one form take turns in the lanes of as many joints
    as that needs.
    """
    forms: dict[type, list[type]] = {}
    for law in CONTACT_LAWS:
        forms.setdefault(law.form(), []).append(law)
    m = Mechanism("journals")
    m.point("O", 0.0, 0.0)
    for form, laws in forms.items():
        for k in range(-(-len(laws) // LANES)):
            name, law = f"{form.__name__}{k}", laws[(LANES * k + lane) % len(laws)]
            m.rigid_body(
                name, mass=0.5, inertia=2e-5, pins={"eye": (0.0, 0.0)}, velocity=(0.6, 0.2 + 0.1 * lane, 30.0)
            )
            chosen = contact_law(law, restitution=0.8 + 0.04 * lane)
            m.clearance_joint(
                name, "ground.O", f"{name}.eye", clearance=2e-4, bearing_radius=0.01, contact=chosen
            )
    return m


def machinery(lane: int) -> Mechanism:
    """Gears, a guide, springs, a stop, torques over speed and angle, a motion that repeats itself, an oil
    film beside a dry joint.
    """
    f = 1.0 + 0.05 * lane
    m = Mechanism("machinery", gravity=(0.2, -9.81 * f))
    for k, at in enumerate(((0.0, 0.0), (1.0, 0.2), (2.0, 0.1), (3.0, 0.0))):
        m.point(f"O{k}", *at)
    m.rigid_body(
        "wheel",
        mass=1.0,
        inertia=0.02,
        position=(0.0, 0.0),
        pins={"eye": (0.05, 0.0)},
        velocity=(0.0, 0.0, 9.0 * f),
    )
    m.rigid_body("pinion", mass=0.5, inertia=0.004, position=(1.0, 0.2))
    m.revolute("O0", "ground.O0", "wheel.center")
    m.revolute("O1", "ground.O1", "pinion.center")
    m.gear("mesh", "wheel", "pinion", ratio=-2.5)
    m.drivers["motor"] = Torque(body="wheel", value=(3.0 * f, 0.0, -1.0), speeds=(-5.0, 0.0, 30.0))
    m.rigid_body("arm", mass=1.0, inertia=0.1, pins={"far": (0.3, 0.02)}, position=(2.0, 0.1), angle=0.2)
    m.revolute("O2", "ground.O2", "arm.center")
    m.rigid_body("block", mass=0.4, inertia=2e-3, pins={"pin": (0.01, 0.03)}, position=(2.2, 0.15), angle=0.5)
    m.slider("along", "arm.far", "block.center", direction=(1.0, 0.2))
    m.drivers["push"] = Harmonic(slider="along", amplitude=0.03 * f, frequency=900.0)
    m.drivers["cam"] = Torque(body="arm", against="wheel", value=(0.4, -0.6, 0.1), angles=(-1.0, 0.5, 2.0))
    m.spring("s", "wheel.eye", "block.pin", stiffness=900.0, damping=4.0, free_length=0.3)
    m.torsional_spring("t", "ground", "arm", stiffness=5.0, damping=0.02, free_angle=0.2)
    m.stop("st", "arm", "pinion", low=-0.2, high=0.1, stiffness=80.0, damping=0.05)
    m.rigid_body(
        "shaft",
        mass=0.05,
        inertia=1e-3,
        pins={"eye": (0.0, 0.0)},
        position=(3.0, 0.0),
        velocity=(0.1, 0.0, 300.0 * f),
    )
    film = Hydrodynamic(viscosity=0.03)
    m.clearance_joint(
        "journal",
        "ground.O3",
        "shaft.eye",
        clearance=1e-4,
        bearing_radius=0.02,
        axial_length=0.02,
        contact=film,
    )
    m.rigid_body(
        "ring",
        mass=0.3,
        inertia=1e-4,
        pins={"eye": (0.0, 0.0)},
        position=(3.0, 0.0),
        velocity=(0.4, 0.3 * f, -40.0),
    )
    dry = {
        "contact": LankaraniNikravesh(restitution=0.7, stiffness=1e9),
        "friction": Ambrosio(coefficient=0.2, v0=1e-3, v1=1e-2),
    }
    m.clearance_joint("dry", "shaft.eye", "ring.eye", clearance=1e-4, bearing_radius=0.01, **dry)
    m.loads["follow"] = PointForce(name="follow", at="ring.eye", force=(3.0, 1.0), moment=0.1, follow=True)
    return with_settings(m, damping=0.5)


def cylinder(lane: int) -> Mechanism:
    """A slider-crank under loads over a travel with two ways, its speed and its crank's angle, its piston
    pinned with clearance.
    """
    f = 1.0 + 0.1 * lane
    m = Mechanism("cylinder")
    m.point("O", 0.01, 0.02)
    m.link("crank", length=0.05, mass=0.5, angle=0.2)
    m.link("rod", length=0.2, mass=0.4, angle=0.2)
    m.rigid_body(
        "piston", mass=0.6, inertia=1e-3, pins={"eye": (0.01, 0.0)}, position=(0.24, 0.05), angle=0.2
    )
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    m.clearance_joint("C", "rod.end", "piston.eye", clearance=1e-4, bearing_radius=0.01)
    m.slider("guide", "ground.O", "piston.eye", direction=(0.98, 0.2))
    m.drive("crank", speed=200.0 * f)
    m.guide_force(
        "gas",
        "guide",
        bore=0.05,
        travels=(0.15, 0.2, 0.25),
        pressure=(1e5, 3e5 * f, 1e6),
        pressure_back=(1e5, 2e5, 1e6),
        reverse=True,
    )
    m.guide_force("drag", "guide", expression="-3*v*abs(v)", speeds=(-20.0, 20.0))
    m.force(
        "tooth",
        "rod.end",
        force=(2.0, 5.0 * f),
        expression="max(0, sin(angle))",
        angles=(0.0, 2.0 * math.pi),
        zero_angle=0.7,
    )
    return m
