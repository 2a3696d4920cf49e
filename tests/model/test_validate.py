"""What cannot be meant is told of nouns as of files: all at once, with place, value and limit, before
anything is run.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import vfife
from vfife.errors import Fault, LawError, ModelError
from vfife.laws import Ambrosio, ContactLaw, Coulomb, FrictionLaw, LankaraniNikravesh, Material, Pereira
from vfife.model.bodies import Frame, Link, Member, RigidBody, Section
from vfife.model.drivers import AngleTable, ConstantSpeed, Harmonic, Torque
from vfife.model.joints import ClearanceRevolute, Slider
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings, StartSettings
from vfife.model.springs import Bushing
from vfife.model.validation import faults, validate


def crank() -> Mechanism:
    """A crank with a rod on it that hangs in a joint with clearance."""
    m = Mechanism("crank", gravity=(0.0, -9.81), settings=Settings(turns=1.0))
    m.point("O", 0.0, 0.0)
    m.link("arm", length=0.1, mass=1.0, material=Material("steel", 2.0e11))
    m.link("rod", length=0.2, mass=1.0, material=Material("steel", 2.1e11))
    m.revolute("A", "ground.O", "arm.start")
    m.clearance_joint("B", "arm.end", "rod.start", clearance=1e-4, bearing_radius=0.01)
    m.drive("arm", speed=10.0)
    return m


def told(m: Mechanism) -> list[str]:
    return [str(fault) for fault in faults(m)]


def changed(m: Mechanism, joint: str = "B", **values: Any) -> None:
    m.joints[joint] = dataclasses.replace(m.joints[joint], **values)


def body(m: Mechanism, which: str, **values: Any) -> None:
    m.bodies[which] = dataclasses.replace(m.bodies[which], **values)


def settings(m: Mechanism, **values: Any) -> None:
    m.settings = dataclasses.replace(m.settings, **values)


def test_a_sound_mechanism_has_no_fault() -> None:
    """Two materials of one name, which no file can hold, are none."""
    assert told(crank()) == []
    validate(crank())


def test_all_is_told_at_once_and_nothing_is_run() -> None:
    m = crank()
    changed(m, axial_length=-0.02, friction_moment="surfce")
    body(m, "arm", length="long", velocity=(1.0, 0.0, 0.0))
    m.joints["C"] = dataclasses.replace(m.joints["A"], journal="rood.start")
    with pytest.raises(ModelError) as caught:
        vfife.simulate(m)
    said = str(caught.value).splitlines()
    assert said[0] == "crank has 6 faults:"
    for words in (
        ('[body.arm] length = "long"', "this is a text; allowed: a length. Give a number in m."),
        ("[joint.B] axial_length = -0.02", "negative; allowed: above 0 m"),
        ('[joint.B] friction_moment = "surfce"', 'Did you mean "surface"?'),
        ('[joint.C] name = "A"', 'the joint "C" has another name, "A"'),
        ("[body.arm] velocity = [1.0, 0.0, 0.0]", "a driven body has no initial velocity"),
        ('[joint.C] journal = "rood.start"', "there is no body 'rood'"),
    ):
        assert sum(all(word in line for word in words) for line in said) == 1, (words, said)


# What is done to the crank, and where and what is told: that alone.
FAULTS: dict[str, tuple[Callable[[Mechanism], object], str, str]] = {
    "axial length": (lambda m: changed(m, axial_length=-0.02), "[joint.B] axial_length = -0.02", "above 0 m"),
    "word": (
        lambda m: changed(m, friction_moment="surfce"),
        '[joint.B] friction_moment = "surfce"',
        'Did you mean "surface"?',
    ),
    "nan": (lambda m: body(m, "rod", mass=math.nan), "[body.rod] mass = nan", "not a finite number"),
    "infinite": (lambda m: body(m, "rod", mass=math.inf), "[body.rod] mass = inf", "not a finite number"),
    "switch for a number": (
        lambda m: body(m, "rod", mass=True),
        "[body.rod] mass = true",
        "true or false; allowed: a mass. Give a number in kg",
    ),
    "quantity as a text": (
        lambda m: changed(m, clearance="0.2 mm"),
        '[joint.B] clearance = "0.2 mm"',
        "give a number in m".capitalize(),
    ),
    "none": (lambda m: body(m, "rod", length=None), "[body.rod] length = None", "a length"),
    "gravity": (lambda m: setattr(m, "gravity", (0.0,)), "gravity[1]", "this value of the list is missing"),
    "gravity of three": (lambda m: setattr(m, "gravity", (0.0, 0.0, 1.0)), "gravity", "too many values"),
    "point": (lambda m: m.points.update(P=(0.0, "1 m")), '[ground] P[1] = "1 m"', "a text"),
    "elements": (
        lambda m: body(m, "rod", elements=2.5),
        "[body.rod] elements = 2.5",
        "a whole number from 1 to 100000",
    ),
    "another name": (
        lambda m: changed(m, name="Z"),
        '[joint.B] name = "Z"',
        'the joint "B" has another name, "Z"',
    ),
    "body of another name": (
        lambda m: body(m, "rod", name="bar"),
        '[body.rod] name = "bar"',
        'the body "rod" has another name, "bar"',
    ),
    "no body": (lambda m: m.bodies.update(x=3), "[body] x", "this is a whole number; allowed: a Body"),  # type: ignore[dict-item]
    "joint for a body": (lambda m: m.bodies.update(x=m.joints["A"]), "[body] x", "this is a IdealRevolute"),  # type: ignore[dict-item]
    "no law": (lambda m: changed(m, contact="pereira"), "[joint.B] contact", "allowed: a ContactLaw"),
    "friction for contact": (
        lambda m: changed(m, contact=Ambrosio()),
        "[joint.B] contact",
        "this is a Ambrosio; allowed: a ContactLaw",
    ),
    "material": (lambda m: body(m, "rod", material="steel"), "[body.rod] material", "allowed: a Material"),
    "modulus": (
        lambda m: body(m, "rod", material=Material("x", -1.0)),
        "[body.rod.material] youngs_modulus = -1.0",
        "above 0 Pa",
    ),
    "section": (
        lambda m: body(m, "rod", model="elastic", section=Section(1e-4, -1e-9)),
        "[body.rod.section] second_moment = -1e-09",
        "above 0 m^4",
    ),
    "pin": (lambda m: body(m, "rod", pins={"start": (0.0, 0.0)}), "[body.rod.pins] start", "already"),
    "guide of no length": (
        lambda m: m.joints.update(
            G=Slider(name="G", bearing="ground.O", journal="rod.end", direction=(0.0, 0.0))
        ),
        "[joint.G] direction",
        "this direction has no length",
    ),
    "speed": (
        lambda m: m.drivers.update(arm=ConstantSpeed(body="arm", speed="25 Hz")),
        '[driver.arm] speed = "25 Hz"',
        "rad/s",
    ),  # type: ignore[arg-type]
    "frequency": (
        lambda m: m.drivers.update(arm=Harmonic(body="arm", amplitude=1.0, frequency=-5.0)),
        "[driver.arm] frequency",
        "above 0 1/s",
    ),
    "table": (
        lambda m: m.drivers.update(arm=AngleTable(body="arm", times=(0.0, 0.0), values=(0.0, 1.0))),
        "[driver.arm] times",
        "ascend",
    ),
    "travels": (
        lambda m: m.drivers.update(d=AngleTable(point="rod.end", times=(0.0, 1.0), values=(0.0,))),
        "[driver.d] travels",
        "1 for 2 times",
    ),
    "force on a slider": (
        lambda m: m.drivers.update(d=Torque(slider="A", value=1.0)),
        "[driver.d] slider",
        "does not act on a slider",
    ),
    "load": (
        lambda m: m.loads.update(f=PointForce(name="f", at="rod.end", force=(1.0, math.nan))),
        "[load.f] force[1] = nan",
        "a force",
    ),
    "load of another name": (
        lambda m: m.loads.update(f=PointForce(name="g", at="rod.end")),
        "[load.f] name",
        'has another name, "g"',
    ),
    "bushing": (
        lambda m: m.springs.update(
            s=Bushing(name="s", first="ground.O", second="rod.end", stiffness=(1.0, -1.0, 1.0))
        ),
        "[spring.s] stiffness[1] = -1.0",
        "at least 0 N/m",
    ),
    "outputs": (
        lambda m: settings(m, outputs=-3),
        "[run] outputs = -3",
        "too small; allowed: a whole number from 1",
    ),
    "turns": (lambda m: settings(m, turns=-1.0), "[run] turns = -1.0", "above 0"),
    "step": (lambda m: settings(m, step="automatic"), '[run] step = "automatic"', 'a time, or "auto"'),
    "two lengths": (lambda m: settings(m, duration=1.0), "[run] duration", "exclude each other"),
    "mode": (
        lambda m: setattr(m, "start", StartSettings(mode="ruogh")),
        '[start] mode = "ruogh"',
        'Did you mean "rough"?',
    ),  # type: ignore[arg-type]
    "settings": (lambda m: setattr(m, "start", "rough"), "start", "allowed: a StartSettings"),
    "small clearance": (
        lambda m: changed(m, clearance=5e-7, contact=Pereira()),
        "[joint.B] contact",
        "no exponent",
    ),
}


@pytest.mark.parametrize("case", FAULTS)
def test_one_fault_of_a_noun_is_told_once_with_its_place(case: str) -> None:
    change, where, words = FAULTS[case]
    m = crank()
    try:
        change(m)
        (said,) = told(m)
    except ModelError as error:  # a text that is no quantity is told at once
        (said,) = map(str, error.faults)
    assert said.startswith(where), said
    assert words in said, said


def test_a_faulty_noun_is_checked_for_the_rest_and_gives_no_second_fault() -> None:
    m = crank()
    section = Section(1e-4, 1e-9)
    m.bodies["truss"] = Frame(
        name="truss", nodes={"A": (0.0, 0.0), "B": (1.0, None)}, section=section,  # type: ignore[dict-item]
        members=(Member("A", "B", mass=-1.0), Member("B", "X")),
    )  # fmt: skip
    m.joints["T"] = ClearanceRevolute(
        name="T", bearing="ground.O", journal="truss.B", clearance=math.nan, bearing_radius=0.01
    )
    m.bodies["plate"] = RigidBody(name="plate", mass=0.0, inertia=1.0, pins={"p": (0.0, "x")})  # type: ignore[dict-item]
    m.revolute("P", "rod.end", "plate.p")
    places = sorted(line.partition(" = ")[0].partition(":")[0] for line in told(m))
    assert places == sorted(
        [
            "[body.truss.nodes] B[1]",
            "[body.truss] members[0].mass",
            "[body.truss] members[1].end",
            "[joint.T] clearance",
            "[body.plate] mass",
        ]
        + ["[body.plate.pins] p[1]"]
    )


def test_numbers_of_numpy_are_numbers() -> None:
    m = crank()
    body(m, "rod", mass=np.float32(1.0), elements=np.int64(4), velocity=np.zeros(3))
    m.gravity = np.array([0.0, -9.81])  # type: ignore[assignment]
    assert told(m) == []


# ------------------------------------------------------------------------------------------------------- laws

BAD: list[Any] = [-3.0, 1.5, 0.0, math.nan, math.inf, "0.5", True, None]


@pytest.mark.parametrize("value", BAD, ids=str)
def test_a_law_refuses_what_its_parameter_cannot_be(value: Any) -> None:
    with pytest.raises(LawError, match=r'law "lankarani-nikravesh": restitution = .*; allowed: ') as caught:
        LankaraniNikravesh(restitution=value)
    assert [fault.where for fault in caught.value.faults] == ["restitution"]


def test_a_law_tells_all_its_faults_at_once() -> None:
    with pytest.raises(LawError) as caught:
        LankaraniNikravesh(restitution=-3.0, stiffness="stiff")  # type: ignore[arg-type]
    assert [fault.where for fault in caught.value.faults] == ["restitution", "stiffness"]
    assert "above 0 and at most 1" in str(caught.value)


@pytest.mark.parametrize(
    "law", [*ContactLaw.registry.values(), *FrictionLaw.registry.values()], ids=lambda law: law.name
)
def test_every_number_of_every_law_is_checked(law: Any) -> None:
    """Whatever it is, no parameter may be nan."""
    needed = {field.name: 1e-3 for field in dataclasses.fields(law) if field.default is dataclasses.MISSING}
    for field in dataclasses.fields(law):
        if not isinstance(field.default, str | bool):
            with pytest.raises(LawError, match=rf"{field.name} = nan"):
                law(**needed | {field.name: math.nan})


def test_parameters_that_do_not_go_together() -> None:
    with pytest.raises(
        LawError, match=r"v1 = 0.01: friction would have no ramp between v0 and v1; allowed: above v0 = 1 m/s"
    ):
        Ambrosio(v0=1.0)
    with pytest.raises(LawError, match="coefficient = -0.1"):
        Coulomb(coefficient=-0.1)


# ----------------------------------------------------------------------------------------------------- adders

TWICE: dict[str, Callable[[Mechanism], object]] = {
    "point": lambda m: m.point("O", 1.0, 0.0),
    "drive": lambda m: m.drive("arm", speed=3.0),
    "body": lambda m: m.link("arm", length=1.0, mass=1.0),
    "joint": lambda m: m.revolute("A", "ground.O", "arm.end"),
}


@pytest.mark.parametrize("what", TWICE)
def test_a_second_one_of_a_name_is_refused(what: str) -> None:
    m = crank()
    before = dict(m.points), dict(m.drivers), dict(m.bodies), dict(m.joints)
    with pytest.raises(ValueError, match="already"):
        TWICE[what](m)
    assert (m.points, m.drivers, m.bodies, m.joints) == before


def test_fields_of_a_link_are_those_of_the_table() -> None:
    """Unit, meaning and limits stand beside the field."""
    told = {field.name: field.metadata for field in dataclasses.fields(Link) if field.name != "name"}
    assert (told["length"]["unit"], told["length"]["above"], told["length"]["meaning"]) == (
        "m",
        0.0,
        "distance from start to end",
    )
    assert all(one["meaning"] for one in told.values())


def test_a_main_bearing_with_clearance_is_offered_a_torque() -> None:
    m = crank()
    m.joints["A"] = dataclasses.replace(m.joints["B"], bearing="ground.O", journal="arm.start")
    words = "with clearance there, let a torque accelerate the body"
    assert any("Make A ideal" in fault and words in fault for fault in told(m)), told(m)
    m.joints["A"] = dataclasses.replace(m.joints["A"], bearing="rod.end")
    assert not any(words in fault for fault in told(m))


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (("vary", "speed", "values", 3), '[vary.speed] values[3] = "1450 U/min" (entry 4): not a speed.'),
        (
            ("load", "f", "travels", 0, 1),
            '[load.f] travels[0][1] = "1450 U/min" (entry 1, in it 2): not a speed.',
        ),
        (("driver", "d", "speed"), '[driver.d] speed = "1450 U/min": not a speed.'),
    ],
)
def test_a_fault_counts_the_entries_of_a_list_from_one(place: tuple, words: str) -> None:
    fault = Fault(place, "not a speed", '"1450 U/min"')
    assert str(fault) == words and "entry" not in fault.where
