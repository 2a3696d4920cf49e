"""The gallery: example mechanisms, each a model file of ``examples/`` and a function that loads it.

Keyword parameters (SI units) replace numbers of the file; None keeps those of the file. :func:`load` sets any
number by its path.

>>> from vfife import gallery
>>> gallery.jansen_leg(speed=3.0).name
'Jansen leg'
>>> gallery.load("jansen_leg", {"run.turns": 2}).settings.turns
2.0
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from . import Mechanism
from .files import GALLERY
from .laws import ContactLaw, FrictionLaw
from .model.bodies import Link, RigidBody
from .model.joints import ClearanceRevolute, ClearanceSlider, ExternalContact
from .modelfile.read import load as read
from .numerics.scalar import atan2, cos, sin
from .options import with_faults

Number = float | None  # None: as in the file
Numbers = Sequence[float] | None

__all__ = [
    "block_on_incline", "compressor", "double_pendulum", "elastic_pendulum", "elastica_circle", "four_bar",
    "four_bar_case_b", "four_bar_case_c", "four_bar_ideal", "four_bar_loose", "gear_train", "jansen_leg",
    "jansen_leg_loose", "journal_in_bearing", "lee_frame", "piston_slap", "quick_return", "scissor_lift",
    "scotch_yoke", "six_bar_press", "slider_crank", "slider_crank_free", "slider_crank_loose_guide",
    "slider_crank_loose_pin", "squeezer", "toggle_press", "williams_toggle",
]  # fmt: skip


def path(name: str) -> Path:
    """Return the model file of a mechanism of the gallery."""
    return GALLERY / f"{name}.toml"


def load(name: str, changes: Mapping[str, Any] | None = None) -> Mechanism:
    """Load a mechanism of the gallery; ``changes`` sets values by path, as in
    ``{"joint.C.clearance": "0.3 mm"}``, where they are not None.
    """
    items = [(path, value) for path, value in (changes or {}).items() if value is not None]
    return replace(read(path(name), set=items), source=None)


_load = load  # for a function that has a parameter of this name


def _crank(speed: float | None, turns: float | None) -> dict[str, Any]:
    return {"driver.crank.speed": speed, "run.turns": turns}


@with_faults()
def block_on_incline(
    *,
    slope: Number = None,
    friction: Number = None,
    mass: Number = None,
    duration: Number = None,
    law: FrictionLaw | None = None,
) -> Mechanism:
    """Build a block that slides g (sin(slope) - friction cos(slope)) t²/2 from rest, or stays where the
    friction is larger than tan(slope).

    slope: angle of the incline (rad); mass: of the block (kg); duration: of the run (s)
    friction: coefficient of friction; law: friction law, Coulomb's if None
    """
    changes: dict[str, Any] = {"run.duration": duration, "body.block.mass": mass, "body.block.angle": slope}
    changes["body.block.inertia"] = None if mass is None else 0.004 * mass
    changes["body.block.position"] = None if slope is None else [-0.05 * sin(slope), 0.05 * cos(slope)]
    for joint in ("joint.lower", "joint.upper"):
        changes[f"{joint}.direction"] = None if slope is None else [cos(slope), sin(slope)]
        changes[f"{joint}.friction.coefficient"] = friction
    m = load("block_on_incline", changes)
    if law is not None:
        m.joints.update(
            {
                name: replace(joint, friction=law)
                for name, joint in m.joints.items()
                if isinstance(joint, ExternalContact)
            }
        )
    return m


@with_faults()
def compressor(*, wear: float = 1.0, speed: Number = None, turns: Number = None) -> Mechanism:
    """Build an air compressor whose clearances are those of new parts times ``wear``; with 0 its joints are
    ideal.

    speed: of the crank (rad/s); turns: of the crank
    """
    m = load("compressor", _crank(speed, turns))
    for name, joint in m.joints.items():
        if isinstance(joint, ClearanceRevolute | ClearanceSlider):
            m.joints[name] = replace(joint, clearance=wear * joint.clearance) if wear else joint.ideal()
    return m


@with_faults()
def four_bar(
    *, clearance: Number = None, loose: str = "BCD", speed: Number = None, turns: Number = None
) -> Mechanism:
    """Build the four-bar of the VFIFE paper, with clearance (m) in the joints that ``loose`` names and
    parameters inferred from its Table 3.

    speed: of the crank (rad/s); turns: of the crank
    """
    m = load("four_bar", {f"joint.{name}.clearance": clearance for name in "BCD"} | _crank(speed, turns))
    m.joints.update({name: joint.ideal() for name, joint in m.clearances.items() if name not in loose})
    return m


@with_faults()
def four_bar_ideal(*, speed: Number = None, turns: Number = None) -> Mechanism:
    """Four-bar with rigid links and ideal joints, joint C above the line of the ground's pivots."""
    return load("four_bar_ideal", _crank(speed, turns))


@with_faults()
def four_bar_loose(
    *, clearance: Number = None, friction: Number = None, duration: Number = None
) -> Mechanism:
    """Load a four-bar whose crank follows a table; three joints have ``clearance`` (m) and ``friction``
    (1).
    """
    changes = {"clearance": clearance, "friction.coefficient": friction}
    values = {f"joint.{name}.{key}": value for name in "BCD" for key, value in changes.items()}
    return load("four_bar_loose", {**values, "run.duration": duration})


@with_faults()
def four_bar_case_b(*, clearance: Number = None, speed: Number = None, turns: Number = None) -> Mechanism:
    """Four-bar with rigid links and one clearance joint, C: reference case b."""
    return load("four_bar_case_b", {"joint.C.clearance": clearance} | _crank(speed, turns))


@with_faults()
def four_bar_case_c(*, clearance: Number = None, speed: Number = None, turns: Number = None) -> Mechanism:
    """Four-bar with rigid links and three clearance joints, B, C and D: reference case c."""
    return load(
        "four_bar_case_c", {f"joint.{name}.clearance": clearance for name in "BCD"} | _crank(speed, turns)
    )


@with_faults()
def elastica_circle(
    *, length: Number = None, elements: int | None = None, factors: Numbers = None
) -> Mechanism:
    """Build a clamped strip of ``length`` (m) that an end moment rolls up; load factor q makes it an arc of q
    · 360°.
    """
    changes = {
        "body.strip.length": length,
        "body.strip.elements": elements,
        "run.load_factors": factors and list(factors),
    }
    m = load("elastica_circle", changes)
    if length is not None:
        m = load("elastica_circle", changes | {"load.end.moment": m.loads["end"].moment / length})  # type: ignore[attr-defined]
    return m


@with_faults()
def williams_toggle(*, elements: int | None = None, drops: Numbers = None) -> Mechanism:
    """Build a shallow clamped toggle whose apex is pushed down by ``drops`` (inches, the load factors); the
    force of the driver is the load.
    """
    members = {f"body.toggle.members.{k}.elements": elements for k in range(2)}
    return load("williams_toggle", {**members, "run.load_factors": drops and list(drops)})


@with_faults()
def lee_frame(*, elements: int | None = None, drops: Numbers = None) -> Mechanism:
    """Build a hinged right-angled frame, pushed down at a fifth of its beam by ``drops`` (m, the load
    factors), with ``elements`` on each side.
    """
    counts = (elements, max(2, elements // 5), elements - elements // 5) if elements else (None,) * 3
    members = {f"body.frame.members.{k}.elements": count for k, count in enumerate(counts)}
    return load("lee_frame", {**members, "run.load_factors": drops and list(drops)})


@with_faults()
def gear_train(
    *,
    stall_torque: Number = None,
    idle_speed: Number = None,
    ratios: Numbers = None,
    inertias: Numbers = None,
    duration: Number = None,
) -> Mechanism:
    """Build a motor, a middle shaft and a flywheel, connected by gears. The motor's torque falls linearly
    with speed.

    stall_torque: of the motor at rest (N m); idle_speed: at which its torque is 0 (rad/s)
    ratios: of the two meshes; inertias: of the three shafts (kg m²); duration: of the run (s)
    """
    bodies = ("motor", "middle", "flywheel")
    return load("gear_train", {
        "run.duration": duration,
        "driver.curve.torque.0": stall_torque,
        "driver.curve.speeds.1": idle_speed,
        **dict(zip(
            ("gear.first-stage.ratio", "gear.second-stage.ratio"), ratios or (None, None), strict=True,
        )),
        **dict(zip((f"body.{name}.inertia" for name in bodies), inertias or (None,) * 3, strict=True)),
    })  # fmt: skip


@with_faults()
def jansen_leg(
    *, unit: float = 0.01, speed: Number = None, turns: Number = None, density: float = 0.5
) -> Mechanism:
    """Build a leg of rods and of plates made of rods, of ``density`` (kg/m); ``unit`` (m) is that of Jansen's
    numbers.

    speed: of the crank (rad/s); turns: of the crank
    """
    m = load("jansen_leg", _crank(speed, turns))
    size, weight = unit / 0.01, density / 0.5 * unit / 0.01

    def scaled(point: Sequence[float]) -> tuple[float, float]:
        return size * point[0], size * point[1]

    m.points.update({name: scaled(point) for name, point in m.points.items()})
    for name, body in m.bodies.items():
        if isinstance(body, Link):
            m.bodies[name] = replace(body, length=size * body.length, mass=weight * (body.mass or 0.0))
        elif isinstance(body, RigidBody):
            pins = {pin: scaled(point) for pin, point in body.pins.items()}
            position = scaled(body.position or (0.0, 0.0))
            m.bodies[name] = replace(
                body, mass=weight * body.mass, inertia=weight * size * size * body.inertia,
                center=scaled(body.center), position=position, pins=pins,
            )  # fmt: skip
    return m


@with_faults()
def jansen_leg_loose(
    *, clearance: Number = None, speed: Number = None, turns: Number = None, strut: Number = None
) -> Mechanism:
    """Load a leg whose ``strut`` (m) has ``clearance`` (m) in both pins, on frame and lower rod."""
    changes = {f"joint.{name}.clearance": clearance for name in "CG"}
    return load("jansen_leg_loose", {"body.strut.length": strut, **changes, **_crank(speed, turns)})


@with_faults()
def journal_in_bearing(
    *, mass: Number = None, speed: Number = None, clearance: Number = None, contact: ContactLaw | None = None
) -> Mechanism:
    """Build a journal of ``mass`` (kg) that flies from the middle of its fixed bearing against the wall with
    ``speed`` (m/s) and rebounds.
    """
    changes = {"body.journal.mass": mass, "body.journal.velocity.0": speed, "joint.O.clearance": clearance}
    m = load("journal_in_bearing", changes)
    way, pace = m.clearances["O"].clearance, m.bodies["journal"].velocity[0]
    m = load("journal_in_bearing", changes | {"run.duration": 2.0 * way / pace})
    if contact is not None:
        m.joints["O"] = replace(m.clearances["O"], contact=contact)
    return m


@with_faults()
def double_pendulum(
    *, lengths: Numbers = None, masses: Numbers = None, angles: Numbers = None, duration: Number = None
) -> Mechanism:
    """Two uniform rods (m, kg), upper and lower, let go at rest; angles in rad from the horizontal."""
    changes: dict[str, Any] = {"run.duration": duration}
    for key, values in (("length", lengths), ("mass", masses), ("angle", angles)):
        changes |= zip((f"body.upper.{key}", f"body.lower.{key}"), values or (None, None), strict=True)
    return load("double_pendulum", changes)


@with_faults()
def elastic_pendulum(
    *, length: Number = None, diameter: Number = None, youngs_modulus: Number = None, density: Number = None,
    elements: int | None = None, duration: Number = None,
) -> Mechanism:  # fmt: skip
    """Build a round rod of soft rubber, released from rest in the horizontal.

    length, diameter: of the rod (m); youngs_modulus: of the rubber (Pa); density: of the rubber
    (kg/m³)
    duration: of the run (s)
    """
    return load("elastic_pendulum", {
        "body.rod.length": length, "body.rod.section.round": diameter, "body.rod.elements": elements,
        "run.duration": duration,
        "material.rubber.youngs_modulus": youngs_modulus, "material.rubber.density": density,
    })  # fmt: skip


@with_faults()
def six_bar_press(*, speed: Number = None, turns: Number = None) -> Mechanism:
    """Build a crank-rocker whose hanging rocker, extended beyond its coupler pin, drives a ram
    through a rod.

    speed: of the crank (rad/s); turns: of the crank
    """
    return load("six_bar_press", _crank(speed, turns))


@with_faults()
def toggle_press(
    *, arm: float = 0.20, angle: float = math.radians(20.0), force: Number = None, stiffness: Number = None
) -> Mechanism:
    """Two equal arms (m), bent by ``angle`` (rad) from their line, closed by a ``force`` (N) at the knee,
    press a work piece (N/m).
    """
    return load("toggle_press", {
        "ground.guide.1": -1.6 * arm, "ground.table.1": -2.5 * arm,
        "body.ram.position.1": -2.0 * arm * cos(angle),
        "body.upper.length": arm, "body.upper.angle": -0.5 * math.pi - angle,
        "body.lower.length": arm, "body.lower.angle": -0.5 * math.pi + angle,
        "load.hand.force.0": force, "spring.work-piece.stiffness": stiffness,
    })  # fmt: skip


@with_faults()
def quick_return(
    *,
    crank: float = 0.10,
    distance: float = 0.25,
    rocker: float = 0.50,
    speed: Number = None,
    turns: Number = None,
) -> Mechanism:
    """Build a quick-return mechanism: a crank at ``distance`` above the pivot of a slotted rocker, which
    moves a ram through a link.

    crank, distance, rocker: lengths (m); speed: of the crank (rad/s); turns: of the crank
    """
    return load("quick_return", {
        "ground.O.1": distance, "ground.guide.1": 1.02 * rocker, "body.crank.length": crank,
        "body.rocker.length": rocker, "body.rocker.angle": atan2(distance, crank),
        "body.link.length": 0.4 * rocker, "body.ram.position": [-0.1 * rocker, 1.02 * rocker],
        **_crank(speed, turns),
    })  # fmt: skip


@with_faults()
def scissor_lift(
    *,
    arm: float = 1.0,
    angle: float = math.radians(20.0),
    travel: Number = None,
    duration: Number = None,
    load: Number = None,
    mass: Number = None,
) -> Mechanism:
    """Two stages of crossed arms (m, kg each) lift a platform (``load``, kg) while an actuator pulls the
    rolling foot in by ``travel`` (m).
    """
    changes: dict[str, Any] = {
        "run.duration": duration, "driver.actuator.duration": duration, "driver.actuator.travel": travel,
        "body.platform.mass": load, "body.platform.center.0": 0.5 * arm * cos(angle),
        "body.platform.position.1": 2.0 * arm * sin(angle), "body.platform.pins.edge.0": arm,
    }  # fmt: skip
    for name, side in (("rising-1", 1.0), ("falling-1", -1.0), ("rising-2", 1.0), ("falling-2", -1.0)):
        values = {"length": arm, "mass": mass, "angle": side * angle, "pins.middle.0": 0.5 * arm}
        changes |= {f"body.{name}.{key}": value for key, value in values.items()}
    return _load("scissor_lift", changes)


@with_faults()
def scotch_yoke(
    *, crank: float = 0.05, mass: Number = None, speed: Number = None, turns: Number = None
) -> Mechanism:
    """x = crank cos(speed t): crank in m, mass of the yoke in kg. The crank's torque is -m r^2 w^2 sin(2 w
    t)/2.
    """
    return load("scotch_yoke", {
        "body.crank.length": crank, "body.yoke.mass": mass, "body.yoke.position.0": crank,
        "body.yoke.pins.rod.0": 3.0 * crank,
        "body.yoke.pins.top.1": 1.3 * crank, "body.yoke.pins.bottom.1": -1.3 * crank, **_crank(speed, turns),
    })  # fmt: skip


@with_faults()
def slider_crank(*, speed: Number = None, turns: Number = None) -> Mechanism:
    """Slider-crank with ideal joints; speed of the crank in rad/s."""
    return load("slider_crank", _crank(speed, turns))


@with_faults()
def piston_slap(*, restitution: Number = None, speed: Number = None, turns: Number = None) -> Mechanism:
    """Load a slider-crank whose small block has clearance between two walls; ``restitution`` (1)."""
    return load("piston_slap", {"joint.guide.contact.restitution": restitution, **_crank(speed, turns)})


@with_faults()
def slider_crank_free(
    *, clearance: Number = None, friction: Number = None, duration: Number = None
) -> Mechanism:
    """Load a slider-crank without a motor; its block has ``clearance`` (m) on each side in its guide."""
    changes = {"joint.guide.clearance": clearance, "joint.guide.friction.coefficient": friction}
    return load("slider_crank_free", {**changes, "run.duration": duration})


def _surfaces(
    joint: str, clearance: float | None, restitution: float | None, friction: float
) -> dict[str, Any]:
    rub = {"law": "ambrosio", "coefficient": friction, "v0": 1e-4, "v1": 1e-2} if friction else None
    return {
        f"{joint}.clearance": clearance,
        f"{joint}.contact.restitution": restitution,
        f"{joint}.friction": rub,
    }


@with_faults()
def slider_crank_loose_pin(
    *,
    clearance: Number = None,
    restitution: Number = None,
    friction: float = 0.0,
    speed: Number = None,
    turns: Number = None,
) -> Mechanism:
    """Slider-crank whose pin between rod and block has clearance (m)."""
    return load(
        "slider_crank_loose_pin",
        _surfaces("joint.pin", clearance, restitution, friction) | _crank(speed, turns),
    )


@with_faults()
def slider_crank_loose_guide(
    *,
    clearance: Number = None,
    restitution: Number = None,
    friction: float = 0.0,
    speed: Number = None,
    turns: Number = None,
) -> Mechanism:
    """Slider-crank whose block has clearance (m, on each side) in its guide."""
    return load(
        "slider_crank_loose_guide",
        _surfaces("joint.guide", clearance, restitution, friction) | _crank(speed, turns),
    )


@with_faults()
def squeezer(
    *, torque: Number = None, stiffness: Number = None, duration: Number = None, **settings: Any
) -> Mechanism:
    """Andrews' squeezer: seven bodies closed in three loops at E, a motor (N m), a spring (N/m); ``settings``
    are those of the run.
    """
    changes = {"driver.motor.torque": torque, "spring.spring.stiffness": stiffness, "run.duration": duration}
    return load("squeezer", changes | {f"run.{key}": value for key, value in settings.items()})
