"""Model files: what they mean, those of the examples too."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

from model_texts import DEMO, EXAMPLES, FILES, FOUR_BAR, with_lines
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh, Material, Pereira
from vfife.model import bodies, drivers, joints, loads
from vfife.model.mechanism import Settings, StartSettings
from vfife.modelfile import dump, load
from vfife.modelfile import loads as read

# ---------------------------------------------------------------------------------------------------- meaning


def test_a_file_means_what_it_says() -> None:
    model = read(FOUR_BAR)
    assert model.name == "four-bar"
    assert model.points == {"A": (0.0, 0.0), "D": (0.15, 0.0)}
    assert model.bodies["coupler"] == bodies.Link(
        name="coupler", length=0.26, mass=2.028, angle=51 / 180 * math.pi
    )
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
            'times = [0, "10 ms", "0.03 s"]\nangles = [0, "90 deg", "2 rad"]',
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
        name="plate",
        mass=2.0,
        inertia=0.01,
        center=(1e-3, 0.0),
        velocity=(1.0, 0.0, 2.0),
        pins={"P": (0.1, 0.02)},
    )
    assert model.bodies["weight"] == bodies.PointMass(
        name="weight", mass=1.0, position=(0.0, 1.0), material=bronze
    )
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


# ------------------------------------------------------------------------------------------------------------
# examples


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_examples_load_and_come_back(path: Path) -> None:
    model = load(path)
    assert read(dump(model)) == model
    assert model.source == str(path)


def test_all_examples_are_there() -> None:
    names = {"four_bar", "four_bar_ideal", "four_bar_case_b", "four_bar_case_c", "journal_in_bearing"}
    assert names <= {path.stem for path in FILES}


@pytest.mark.parametrize(
    "path",
    [path for path in FILES if path.stem.startswith("four_bar") and path.stem != "four_bar_loose"],
    ids=lambda path: path.stem,
)
def test_four_bars_are_that_of_table_1(path: Path) -> None:
    model = load(path)
    assert model.points == {"A": (0.0, 0.0), "D": (0.15, 0.0)}
    lengths = {
        name: (body.length, body.mass) for name, body in model.bodies.items() if isinstance(body, bodies.Link)
    }
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
        assert (joint.contact, joint.friction) == (
            Pereira(restitution=0.5),
            Ambrosio(coefficient=0.1, v0=0.01, v1=0.1),
        )
        assert (joint.axial_length, joint.friction_moment) == (0.005, "off")
    for name in ("coupler", "follower"):
        link = model.bodies[name]
        assert isinstance(link, bodies.Link)
        assert (link.model, link.release) == ("two-particle", "both")
        assert link.section is not None
        assert link.material.youngs_modulus * link.stiffness_factor * link.section.area == pytest.approx(
            2.07e11, rel=1e-14
        )


def test_reference_cases_have_their_laws() -> None:
    for case in "bc":
        for joint in load(EXAMPLES / f"four_bar_case_{case}.toml").clearances.values():
            assert joint.contact == LankaraniNikravesh(restitution=0.9, stiffness=6.6e10)
            assert joint.friction == Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2)
            assert (joint.friction_moment, joint.impact_speed_floor) == ("mid-overlap", 1e-3)


@pytest.mark.system("starts a process")
def test_examples_need_neither_pint_nor_numba() -> None:
    code = (
        "import sys\nfrom vfife.modelfile import load\n"
        f"for path in {[str(path) for path in FILES]!r}: load(path)\n"
        "heavy = {'pint', 'numba', 'scipy', 'xarray', 'matplotlib'} & set(sys.modules)\n"
        "sys.exit(' '.join(heavy) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
