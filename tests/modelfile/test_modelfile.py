"""Model files: what they mean, what is set by path, that laws and keys come from the nouns."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pytest

from model_texts import DEMO, EXAMPLES, FILES, FOUR_BAR, faults, only, with_lines
from support import CONTACT_LAWS, contact_law
from vfife.fields import PLACE, Many, Value, described, meaning_of
from vfife.laws import Ambrosio, ContactLaw, Frictionless, LankaraniNikravesh, Material, Pereira, quantity
from vfife.model import bodies, drivers, joints, loads, mechanism
from vfife.model.mechanism import Settings, StartSettings
from vfife.modelfile import dump, load
from vfife.modelfile import loads as read
from vfife.modelfile.jsonschema import model_schema
from vfife.modelfile.tables import NAMED, Table, tables

# ------------------------------------------------------------------------------------------------------------- meaning


def test_a_file_means_what_it_says() -> None:
    model = read(FOUR_BAR)
    assert model.name == "four-bar"
    assert model.points == {"A": (0.0, 0.0), "D": (0.15, 0.0)}
    assert model.bodies["coupler"] == bodies.Link(name="coupler", length=0.26, mass=2.028, angle=51 / 180 * math.pi)
    assert model.joints["B"] == joints.IdealRevolute(name="B", bearing="crank.end", journal="coupler.start")
    assert model.joints["C"] == joints.ClearanceRevolute(
        name="C",
        bearing="coupler.end",
        journal="follower.end",
        clearance=2e-4,
        bearing_radius=0.01,
        contact=Pereira(restitution=0.5),
        friction=Ambrosio(v0=0.01, v1=0.1),
    )
    assert model.drivers == {"crank": drivers.ConstantSpeed(body="crank", speed=50 * math.pi)}
    assert model.settings == Settings(turns=2.0)
    assert model.start == StartSettings()


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ('speed = "10 rad/s"', drivers.ConstantSpeed(body="crank", speed=10.0)),
        ('speed = 10\nramp = "20 ms"', drivers.Ramp(body="crank", speed=10.0, duration=0.02)),
        (
            'times = [0, "10 ms", 0.03]\nangles = [0, "90 deg", 2]',
            drivers.AngleTable(body="crank", times=(0.0, 0.01, 0.03), values=(0.0, math.pi / 2, 2.0)),
        ),
        ('torque = "-5 N m"', drivers.Torque(body="crank", value=-5.0)),
        (
            'torque = [0, "1 kN m"]\ntimes = [0, 1]',
            drivers.Torque(body="crank", value=(0.0, 1000.0), times=(0.0, 1.0)),
        ),
    ],
)
def test_drivers(lines: str, expected: drivers.Driver) -> None:
    text = with_lines(replace=('speed = "1500 rpm"', lines)).replace("turns = 2", "duration = 1")
    assert read(text).drivers["crank"] == expected


@pytest.mark.parametrize(
    ("section", "area", "second_moment"),
    [
        ('{ area = "1 cm^2", second_moment = "100 mm^4" }', 1e-4, 1e-10),
        ('{ square = "1000 mm^2" }', 1e-3, 1e-6 / 12),
        ('{ rectangle = ["20 mm", "50 mm"] }', 1e-3, 0.02 * 0.05**3 / 12),
        ('{ round = "20 mm" }', math.pi * 1e-4, math.pi * 0.02**4 / 64),
    ],
)
def test_sections(section: str, area: float, second_moment: float) -> None:
    text = with_lines(replace=("mass = 2.028", f'model = "elastic"\nelements = 8\nsection = {section}'))
    link = read(text).bodies["coupler"]
    assert isinstance(link, bodies.Link)
    assert link.section is not None
    assert (link.section.area, link.section.second_moment) == pytest.approx((area, second_moment), rel=1e-14)
    assert (link.elements, link.mass) == (8, None)


def test_other_bodies_materials_and_loads() -> None:
    model = read("""
        gravity = [0, "-9.81 m/s^2"]
        [run]
        duration = "0.5 s"
        step = "1 us"
        [start]
        mode = "rough"
        journals = "seated"
        [material.bronze]
        youngs_modulus = "105 GPa"
        poissons_ratio = 0.34
        density = 8800
        [ground]
        O = [0, 0]
        [body.plate]
        model = "rigid"
        mass = "2 kg"
        inertia = "100 kg cm^2"
        center = ["1 mm", 0]
        velocity = [1, 0, "2 rad/s"]
        [body.plate.pins]
        P = [0.1, "20 mm"]
        [body.weight]
        model = "particle"
        mass = 1
        position = [0, 1]
        material = "bronze"
        [joint.O]
        kind = "clearance"
        bearing = "ground.O"
        journal = "plate.P"
        clearance = "0.1 mm"
        bearing_radius = 0.01
        bearing_material = "bronze"
        friction = { law = "none" }
        [load.push]
        at = "plate.center"
        force = ["1 kN", 0]
        moment = 3
        times = [0, 1]
        factors = [0, 1]
    """)
    bronze = Material("bronze", 105e9, 0.34, 8800.0)
    assert model.gravity == (0.0, -9.81)
    assert model.settings == Settings(duration=0.5, step=1e-6)
    assert model.start == StartSettings("rough", "seated")
    assert model.bodies["plate"] == bodies.RigidBody(
        name="plate", mass=2.0, inertia=0.01, center=(1e-3, 0.0), velocity=(1.0, 0.0, 2.0), pins={"P": (0.1, 0.02)}
    )
    assert model.bodies["weight"] == bodies.PointMass(name="weight", mass=1.0, position=(0.0, 1.0), material=bronze)
    joint = model.clearances["O"]
    assert (joint.bearing_material, joint.journal_material) == (bronze, None)
    assert (joint.contact, joint.friction) == (LankaraniNikravesh(), Frictionless())
    assert model.loads["push"] == loads.PointForce(
        name="push", at="plate.center", force=(1000.0, 0.0), moment=3.0, times=(0.0, 1.0), factors=(0.0, 1.0)
    )


def test_steel_can_be_redefined_for_bodies_and_ground() -> None:
    """The ground is of steel too, so its bearing must not keep the other steel."""
    steel = "[material.steel]\nyoungs_modulus = 100e9\npoissons_ratio = 0.25\ndensity = 7000"
    text = with_lines(
        steel,
        replace=(
            'bearing = "ground.D"',
            'kind = "clearance"\nclearance = 1e-4\nbearing_radius = 0.01\nbearing = "ground.D"',
        ),
    )
    model = read(text)
    expected = Material("steel", 100e9, 0.25, 7000.0)
    assert model.bodies["coupler"].material == expected
    assert model.clearances["D"].bearing_material == expected
    assert read(dump(model)) == model
    assert read(FOUR_BAR, [("material.steel.density", 7000)]).bodies["crank"].material.density == 7000.0


# ------------------------------------------------------------------------------------------------------------ examples


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_examples_load_and_come_back(path: Path) -> None:
    model = load(path)
    assert read(dump(model)) == model
    assert model.source == str(path)


def test_all_examples_are_there() -> None:
    names = {"four_bar", "four_bar_ideal", "four_bar_case_b", "four_bar_case_c", "journal_in_bearing"}
    assert names <= {path.stem for path in FILES}


@pytest.mark.parametrize("path", [path for path in FILES if path.stem.startswith("four_bar")], ids=lambda path: path.stem)
def test_four_bars_are_that_of_table_1(path: Path) -> None:
    model = load(path)
    assert model.points == {"A": (0.0, 0.0), "D": (0.15, 0.0)}
    lengths = {name: (body.length, body.mass) for name, body in model.bodies.items() if isinstance(body, bodies.Link)}
    assert lengths == {"crank": (0.4, 3.12), "coupler": (0.26, 2.028), "follower": (0.46, 3.588)}
    assert {name: (joint.bearing, joint.journal) for name, joint in model.joints.items()} == {
        "A": ("ground.A", "crank.start"),
        "B": ("crank.end", "coupler.start"),
        "C": ("coupler.end", "follower.end"),
        "D": ("ground.D", "follower.start"),
    }
    assert model.drivers["crank"] == drivers.ConstantSpeed(body="crank", speed=50 * math.pi)
    clearances = {"four_bar": "BCD", "four_bar_ideal": "", "four_bar_case_b": "C", "four_bar_case_c": "BCD"}
    assert "".join(model.clearances) == clearances[path.stem]
    assert all((joint.clearance, joint.bearing_radius) == (2e-4, 0.01) for joint in model.clearances.values())


def test_the_demo_is_the_first_inferred_set_and_says_so() -> None:
    model = load(DEMO)
    assert "INFERRED" in model.note
    assert "INFERRED" in DEMO.read_text(encoding="utf-8")
    for joint in model.clearances.values():
        assert (joint.contact, joint.friction) == (Pereira(restitution=0.5), Ambrosio(coefficient=0.1, v0=0.01, v1=0.1))
        assert (joint.axial_length, joint.friction_moment) == (0.005, "off")
    for name in ("coupler", "follower"):
        link = model.bodies[name]
        assert isinstance(link, bodies.Link)
        assert (link.model, link.release) == ("two-particle", "both")
        assert link.section is not None
        assert link.material.youngs_modulus * link.stiffness_factor * link.section.area == pytest.approx(2.07e11, rel=1e-14)


def test_reference_cases_have_their_laws() -> None:
    for case in "bc":
        for joint in load(EXAMPLES / f"four_bar_case_{case}.toml").clearances.values():
            assert joint.contact == LankaraniNikravesh(restitution=0.9, stiffness=6.6e10)
            assert joint.friction == Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2)
            assert (joint.friction_moment, joint.impact_speed_floor) == ("mid-overlap", 1e-3)


def test_examples_need_neither_pint_nor_numba() -> None:
    code = (
        "import sys\nfrom vfife.modelfile import load\n"
        f"for path in {[str(path) for path in FILES]!r}: load(path)\n"
        "heavy = {'pint', 'numba', 'scipy', 'xarray', 'matplotlib'} & set(sys.modules)\n"
        "sys.exit(' '.join(heavy) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


# --------------------------------------------------------------------------------------------------------- set by path


def test_numbers_and_texts_are_set_by_path() -> None:
    model = read(
        FOUR_BAR,
        [
            ("joint.C.clearance", "0.5 mm"),
            ("joint.C.contact.restitution", 0.8),
            ("joint.C.axial_length", '"6 mm"'),
            ("body.crank.mass", "2"),
            ("ground.D.0", "16 cm"),
            ("gravity", "[0, -9.81]"),
            ("run.step", "1e-6"),
            ("start.journals", "seated"),
            ("name", "another"),
        ],
    )
    joint = model.clearances["C"]
    assert (joint.clearance, joint.contact, joint.axial_length) == (5e-4, Pereira(restitution=0.8), 6e-3)
    assert model.bodies["crank"].mass == 2.0  # type: ignore[attr-defined]
    assert model.points["D"] == (0.16, 0.0)
    assert model.gravity == (0.0, -9.81)
    assert (model.settings.step, model.start.journals, model.name) == (1e-6, "seated", "another")


@pytest.mark.parametrize("alias", ["coupler-follower", "follower-coupler"])
def test_a_joint_is_named_by_its_two_bodies(alias: str) -> None:
    assert read(FOUR_BAR, [(f"joint.{alias}.clearance", "0.5 mm")]).clearances["C"].clearance == 5e-4


def test_the_ground_is_a_body_in_such_a_name() -> None:
    sets = [
        ("joint.ground-follower.kind", "clearance"),
        ("joint.follower-ground.clearance", "1 mm"),
        ("joint.D.bearing_radius", 0.01),
    ]
    assert read(FOUR_BAR, sets).clearances["D"].clearance == 1e-3


def test_what_is_set_stays_as_it_was() -> None:
    contact = {"law": "pereira"}
    model = read(FOUR_BAR, [("joint.C.contact", contact), ("joint.C.contact.restitution", 0.7)])
    assert model.clearances["C"].contact == Pereira(restitution=0.7)
    assert contact == {"law": "pereira"}


def test_two_joints_between_two_bodies_must_be_told_apart() -> None:
    text = with_lines('[joint.E]\nbearing = "coupler.start"\njournal = "follower.end"')
    assert "C or E" in only(text, [("joint.coupler-follower.clearance", "0.5 mm")])


@pytest.mark.parametrize(
    ("path", "meant"),
    [
        ("joint.C.clearence", "joint.C.clearance"),
        ("joint.coupler-folower.clearance", "joint.coupler-follower.clearance"),
        ("run.trns", "run.turns"),
        ("jiont.C.clearance", "joint.C.clearance"),
        ("body.cranc.mass", "body.crank.mass"),
        ("body.crank.mas", "body.crank.mass"),
        ("driver.crank.sped", "driver.crank.speed"),
        ("ground.D.2", "a number from 0 to 1"),
        ("name.x", "is a value, not a table"),
        ("joint", "a table, not a number"),
        ("joint..clearance", "names joined by dots"),
    ],
)
def test_a_path_that_leads_nowhere_is_told(path: str, meant: str) -> None:
    told = only(FOUR_BAR, [(path, "1 mm")])
    assert meant in told
    assert path in told


def test_a_value_that_was_set_is_not_looked_for_in_the_file() -> None:
    assert "given by set" in only(FOUR_BAR, [("joint.C.clearance", "-1 mm")])
    assert "given by set" not in only(with_lines(replace=('"0.2 mm"', '"-1 mm"')))


def test_setting_a_kind_drops_what_it_has_no_use_for() -> None:
    model = load(
        DEMO,
        [
            ("body.coupler.model", "rigid"),
            ("joint.B.kind", "ideal"),
            ("joint.C.contact.law", "lankarani-nikravesh"),
            ("joint.D.friction.law", "none"),
        ],
    )
    coupler = model.bodies["coupler"]
    assert isinstance(coupler, bodies.Link)
    assert (coupler.model, coupler.release, coupler.stiffness_factor) == ("rigid", "none", 1.0)
    assert isinstance(model.joints["B"], joints.IdealRevolute)
    assert model.clearances["C"].contact == LankaraniNikravesh(restitution=0.5)
    assert model.clearances["D"].friction == Frictionless()
    # What was set itself is kept, and told.
    assert "no use" in only(FOUR_BAR, [("body.coupler.model", "rigid"), ("body.coupler.elements", 3)])


# ----------------------------------------------------------------------------------------------------- laws and schema


@pytest.fixture
def own_law() -> Iterator[type[ContactLaw]]:
    @dataclass(frozen=True)
    class Spring(ContactLaw):
        """A linear spring."""

        name: ClassVar[str] = "test-spring"
        stiffness: float = quantity("N/m", "stiffness", low=0.0)
        rate: float = quantity("N s/m", "damping", 0.0, low=0.0, high=5.0)
        other: float = quantity("N/m^n", "stiffness of an exponent that is known later", 0.0)
        shape: str = quantity("1", "a word", "round")

        def parameters(self, pair: Any) -> tuple[float, ...]:
            return self.stiffness, self.rate

    yield Spring
    del ContactLaw.registry["test-spring"]


def test_a_new_law_needs_no_change_here(own_law: type[ContactLaw]) -> None:
    law = (
        'law = "pereira"\nrestitution = 0.5',
        'law = "test-spring"\nstiffness = "2 kN/mm"\nrate = 2\nother = 3\nshape = "flat"',
    )
    model = read(with_lines(replace=law))
    assert model.clearances["C"].contact == own_law(stiffness=2e6, rate=2.0, other=3.0, shape="flat")  # type: ignore[call-arg]
    assert read(dump(model)) == model
    told = faults(with_lines(replace=(law[0], 'law = "test-spring"\nrate = "6 N s/m"\nshape = 3')))
    assert [line.partition(" = ")[0].partition(":")[0] for line in told] == [
        "[joint.C.contact] rate",
        "[joint.C.contact] shape",
        "[joint.C.contact] stiffness",
    ]
    assert "at most 5 N s/m" in told[0]


@pytest.mark.parametrize("law", CONTACT_LAWS, ids=lambda law: law.name)
def test_every_contact_law_is_read_and_written(law: type[ContactLaw]) -> None:
    """With numbers and words other than its defaults."""
    chosen = contact_law(law, restitution=0.7, damping="flores", effective_mass=3.0)
    values = {key: value for key, value in vars(chosen).items() if value is not None}
    lines = [f'law = "{law.name}"', *(f"{key} = {json.dumps(value)}" for key, value in values.items())]
    model = read(with_lines(replace=('law = "pereira"\nrestitution = 0.5', "\n".join(lines))))
    assert model.clearances["C"].contact == chosen
    assert read(dump(model)) == model


def test_a_damping_factor_that_is_none() -> None:
    old = 'law = "pereira"\nrestitution = 0.5'
    (told,) = faults(with_lines(replace=(old, 'law = "liu"\ndamping = "flroes"')))
    assert told.startswith('[joint.C.contact] damping = "flroes"') and 'Did you mean "flores"?' in told
    (told,) = faults(with_lines(replace=(old, 'law = "liu"\ndamping = 0.3')))
    assert "a number" in told and '"hunt-crossley"' in told


def test_surfaces_that_a_law_is_not_for_are_told_in_its_words() -> None:
    old = 'law = "pereira"\nrestitution = 0.5'
    text = with_lines(replace=(old, 'law = "pereira"')).replace('clearance = "0.2 mm"', "clearance = 9e-7")
    assert any("no exponent for a clearance of 9e-07 m" in line for line in faults(text))


SECTIONS = [("run", Settings), ("start", StartSettings), ("top", mechanism.Mechanism)]
EVERY = [*((section, table) for section in NAMED for table in tables(section)), *((name, Table(noun)) for name, noun in SECTIONS)]


@pytest.mark.parametrize(("section", "table"), EVERY, ids=lambda one: one if isinstance(one, str) else f"{one.noun.__name__} {one.target}")
def test_every_field_of_a_noun_has_its_key(section: str, table: Table) -> None:
    """A field added to a noun must not get lost between file and mechanism: it says unit, meaning and what it holds."""
    header = {"name"} if section in NAMED else {"source"}  # the name is the table's; the source is not in the file
    target = {"body", "slider", "point", "direction", "against"} if table.target else set()
    for field in dataclasses.fields(table.noun):
        if field.name not in header | target:
            assert field in table.fields.values(), field.name
    for key, field in table.fields.items():
        assert isinstance(table.value(key), Value) and len(meaning_of(field, table.along)) > 2, key
        assert len(table.keys) == len(set(table.keys))


def test_json_schema_can_be_made() -> None:
    schema = model_schema()
    json.dumps(schema)
    clearance = schema["definitions"]["ClearanceRevoluteTable"]
    assert clearance["properties"]["clearance"]["x-unit"] == "m"
    assert clearance["additionalProperties"] is False
    for table in schema["definitions"].values():
        assert all("description" in entry for entry in table.get("properties", {}).values())


def test_a_kind_of_joint_needs_its_own_file_only() -> None:
    """Fields are all that a kind says of its table: reading, writing, limits and did-you-mean follow."""

    @dataclass(frozen=True, kw_only=True)
    class Slot(joints.Joint):
        """A pin in a slot of two ends."""

        kind: ClassVar[str] = "test-slot"
        reach: float = quantity("m", "length of the slot", above=0.0)
        way: tuple[tuple[float, float], ...] = described(Many(PLACE), "points on the way", ())

    lines = '[joint.E]\nkind = "test-slot"\nbearing = "ground.A"\njournal = "coupler.end"\nreach = "20 mm"\nway = [[0, "1 mm"]]'
    try:
        model = read(with_lines(lines))
        assert model.joints["E"] == Slot(name="E", bearing="ground.A", journal="coupler.end", reach=0.02, way=((0.0, 1e-3),))
        assert read(dump(model)) == model
        assert "[joint.E] reach" in only(with_lines(lines.replace("20 mm", "-2 mm")))
        assert 'Did you mean "reach"' in faults(with_lines(lines.replace("reach", "raech")))[0]
        assert 'Did you mean "test-slot"?' in faults(with_lines(lines.replace("test-slot", "test-slott")))[0]
        assert "TestSlot" not in json.dumps(model_schema()) and "test-slot" not in json.dumps(model_schema())
    finally:
        del joints.Joint.registry["test-slot"]
