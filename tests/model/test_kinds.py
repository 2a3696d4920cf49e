"""A kind of joint, spring or driver is one file. Each kind that there is goes all the way here: file, start,
steps, measures, drawing, words.

A kind is found by its presence, as a law is. Its ``sample`` gives sizes to those of its fields that have no
default.
"""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import vfife
from vfife.assembly.assemble import assemble
from vfife.kinematics.initial import ideal_motion
from vfife.kinematics.system import equations
from vfife.measures.forces import joint_rows
from vfife.model.drivers import Driver
from vfife.model.joints import Contact, Joint
from vfife.model.loads import Load, PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.springs import ForceElement
from vfife.model.validation import validate
from vfife.modelfile import dump, loads
from vfife.plots import figures
from vfife.report import check as described
from vfife.simulation.result import Result
from vfife.solvers.transient import run

SOURCE = Path(vfife.__file__).parent
JOINTS, SPRINGS, DRIVERS, LOADS = (dict(base.registry) for base in (Joint, ForceElement, Driver, Load))


def with_joint(kind: str) -> Mechanism:
    """A body of 1 kg that falls, held by the joint or just beside what it may touch."""
    joint = JOINTS[kind](name="joint", bearing="ground.O", journal="body.center", **JOINTS[kind].sample)
    x, y = joint.first_place
    if isinstance(joint, Contact):
        beside = (y + gap for gap in (0.0, 1e-3, 1e-2, 0.1, 1.0))
        y = next(
            at
            for at in beside
            if all(one.depth(x + one.offset[0], at + one.offset[1]) <= 0.0 for one in joint.touchings(0.0))
        )
    m = Mechanism(kind, gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("body", mass=1.0, inertia=0.02, position=(x, y))
    m.joints["joint"] = joint
    return m


def pendulum() -> Mechanism:
    """A link on a pivot."""
    m = Mechanism("pendulum", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.point("P", 0.3, -0.4)
    m.link("arm", length=0.5, mass=1.0, angle=-0.3)
    m.revolute("pivot", "ground.O", "arm.start")
    return m


def with_spring(kind: str) -> Mechanism:
    """A link on a pivot and a spring."""
    m, made = pendulum(), SPRINGS[kind]
    ends = (
        ("ground.P", "arm.end")
        if made(name="spring", first="", second="", **made.sample).between_pins
        else ("ground", "arm")
    )
    m.springs["spring"] = made(name="spring", first=ends[0], second=ends[1], **made.sample)
    return m


def with_driver(kind: str) -> Mechanism:
    """A link on a pivot that is driven."""
    m = pendulum()
    m.drivers["arm"] = DRIVERS[kind](body="arm", **DRIVERS[kind].sample)
    return m


def with_load(kind: str) -> Mechanism:
    """A link on a pivot, with a pin in a slot at its end, and a load there or along the slot."""
    m = pendulum()
    if "guide" in LOADS[kind].sample.values():
        m.rigid_body("block", mass=0.1, inertia=1e-4, position=(0.5 * np.cos(0.3), -0.5 * np.sin(0.3)))
        m.revolute("pin", "arm.end", "block.center")
        m.slider(
            "guide",
            "ground.P",
            "block.center",
            direction=(0.5 * np.cos(0.3) - 0.3, 0.4 - 0.5 * np.sin(0.3)),
            turning=True,
        )
    m.loads["load"] = LOADS[kind](name="load", **LOADS[kind].sample)
    return m


CASES = (
    [(with_joint, kind) for kind in JOINTS]
    + [(with_spring, kind) for kind in SPRINGS]
    + [(with_driver, kind) for kind in DRIVERS]
)
CASES += [(with_load, kind) for kind in LOADS]
EVERY = pytest.mark.parametrize(
    ("make", "kind"), CASES, ids=[f"{make.__name__[5:]} {kind}" for make, kind in CASES]
)


@cache
def result(make, kind) -> Result:
    """A short run."""
    record = run(assemble(make(kind), 1e-5, duration=2e-3, outputs=20, force_step=True), loop="data-driven")
    assert record.status == "complete"
    return Result(record)


def test_there_are_kinds_to_walk_with():
    assert (
        {"ideal", "clearance", "curved-slot"} <= set(JOINTS)
        and {"linear", "stop"} <= set(SPRINGS)
        and {"ramp", "effort"} <= set(DRIVERS)
    )


@EVERY
def test_it_is_written_and_read_back(make, kind):
    m = make(kind)
    validate(m)
    back = loads(dump(m))
    assert (back.joints, back.springs, back.drivers, back.loads) == (m.joints, m.springs, m.drivers, m.loads)


@EVERY
def test_it_starts_closed_and_runs(make, kind):
    motion = ideal_motion(make(kind))
    position = motion.position * (1.0, motion.hand, motion.hand)  # the system may be the mirror image
    open_distances = equations(motion.system, position, np.zeros_like(position)).phi
    assert np.abs(open_distances).max(initial=0.0) == pytest.approx(0.0, abs=1e-12)
    record = result(make, kind).record
    assert np.isfinite(record.rows).all() and len(record.steps) > 1
    assemble(make(kind).ideal(), 1e-5, duration=1e-3, force_step=True)


@EVERY
def test_it_has_channels_and_measures(make, kind):
    found = result(make, kind)
    names = (
        set(joint_rows(found.record)) | set(found.record.assembly.springs) | set(found.record.assembly.pivots)
    )
    assert {"joint", "spring", "pivot"} & names
    if make is with_joint:
        assert "joint.force.max" in found.measures
        assert {"joint"} == set(found.record.assembly.contact_joints) or found.record.assembly.ideals == (
            "joint",
        )
    if make is with_driver and DRIVERS[kind].moves:
        assert found.measures["arm.torque.max"] > 0.0


@cache
def drawn(make, kind) -> Figure:
    """Its mechanism, drawn with all other figures."""
    return figures(result(make, kind))["mechanism"]


def legend(figure: Figure) -> set[str]:
    """What its legend says."""
    return {text.get_text() for text in figure.legends[0].get_texts()}


@EVERY
def test_it_is_drawn_with_a_sign_and_a_name(make, kind):
    figure = drawn(make, kind)
    figure.canvas.draw()
    plain = legend(drawn(with_driver, "constant-speed"))
    names = {text.get_text() for text in figure.axes[0].texts}
    assert make is with_driver or legend(figure) - {"body", "arm"} - (plain if make is with_spring else set())
    assert {"joint", "pivot"} & names


@pytest.mark.parametrize(("make", "kind"), CASES[: -len(LOADS)])
def test_it_is_told_in_words(make, kind):
    assembly = result(make, kind).record.assembly
    if make is with_joint:
        told = described.joints(assembly, {})[0]
        assert told["kind"] and (not assembly.contacts or told["contact"]["law"] == "lankarani-nikravesh")
    elif make is with_spring:
        assert described.couplings(assembly)[0]["what"] not in ("", kind)
    else:
        assert described.driver(assembly.mechanism.drivers["arm"]) not in ("", kind)


def test_a_load_and_a_gear_go_the_same_way():
    m = pendulum()
    m.point("Q", 0.7, 0.0)
    m.rigid_body("wheel", mass=1.0, inertia=0.01, position=(0.7, 0.0))
    m.revolute("axle", "ground.Q", "wheel.center")
    m.gear("teeth", "arm", "wheel", ratio=-2.0)
    m.loads["push"] = PointForce(name="push", at="arm.end", force=(0.0, 2.0))
    back = loads(dump(m))
    assert (back.gears, back.loads) == (m.gears, m.loads)
    found = Result(run(assemble(m, 1e-5, duration=1e-3, outputs=10, force_step=True), loop="data-driven"))
    assert "teeth.moment.max" in found.measures
    assert {"gears, pitch circles", "load"} <= legend(figures(found)["mechanism"])


# ------------------------------------------------------------------------------------------------- who may
# name a kind

# Files, or whole rooms, that may name the class of a kind, and why. Its own file and the import lines may
# anyway.
ALLOWED = {
    "__init__.py": "public names",
    "model/mechanism.py": "which joints have clearance",
    "model/joints/clearance_revolute.py": "without clearance it is another kind",
    "model/joints/clearance_slider.py": "without clearance it is another kind",
    "modelfile/tables.py": "the kind of a table that names none",
    "kinematics/drives.py": "a static analysis holds driven bodies by a table",
    "gallery.py": "clearances that a parameter multiplies, and laws that it replaces",
}


def named(text: str, kinds: Iterable[str]) -> set[str]:
    """Names that a file uses, import lines aside; one that has not even the letters of a kind is not taken
    apart.
    """
    if not any(kind in text for kind in kinds):
        return set()
    nodes = list(ast.walk(ast.parse(text)))
    return {node.id for node in nodes if isinstance(node, ast.Name)} | {
        node.attr for node in nodes if isinstance(node, ast.Attribute)
    }


def test_no_other_file_names_a_kind():
    kinds = {
        cls.__name__: cls.__module__
        for base in (JOINTS, SPRINGS, DRIVERS, LOADS)
        for cls in base.values()
        if cls.__module__.startswith("vfife.")
    }
    offenders, used = [], set()
    for path in sorted(SOURCE.rglob("*.py")):
        name = path.relative_to(SOURCE).as_posix()
        module = "vfife." + name.removesuffix(".py").replace("/", ".")
        there = {kind for kind in named(path.read_text(), kinds) if kind in kinds and kinds[kind] != module}
        if name.endswith("__init__.py") and name.startswith("model/"):
            continue
        pardon = next(
            (one for one in ALLOWED if name == one or (one.endswith("/") and name.startswith(one))), None
        )
        used |= {pardon} if there and pardon else set()
        offenders += [f"{name}: {', '.join(sorted(there))}"] if there and not pardon else []
    assert offenders == [], "ask the kind; it says what it is in its own file"
    assert used == set(ALLOWED) - {"__init__.py"}, "these need their pardon no longer"
