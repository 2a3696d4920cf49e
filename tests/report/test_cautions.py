"""Where a run goes beyond what joints are built for: one warning with numbers; what is usual:
one quiet line.
"""

import pytest

import vfife
from support import go, journal_in_bearing
from vfife.laws import MATERIALS, Frictionless, LankaraniNikravesh, Material
from vfife.laws.materials import HARDNESS, hardness_of
from vfife.report.cautions import out_of_range, usual_remarks
from vfife.simulation.result import Result


def struck(speed: float, **joint) -> Result:
    law = joint.pop("contact", LankaraniNikravesh(restitution=0.9))
    return Result(
        go(
            journal_in_bearing(speed, friction=Frictionless(), contact=law, **joint),
            1e-6,
            duration=6e-3 / speed**0.5,
            outputs=50,
        )
    )


def test_an_impact_that_machines_have_every_day_warns_of_nothing() -> None:
    result = struck(0.3)
    assert list(out_of_range(result)) == [] and result.summary["warnings"] == []
    (line,) = usual_remarks(result)
    assert line.startswith("J: impacts of up to 300 mm/s") and line in result.summary["remarks"]


def test_a_penetration_beyond_the_clearance_is_told_with_numbers() -> None:
    """On a soft law, K = 1e7 N/m^1.5: 2/5 K d^2.5 = m v^2/2, so d = (5 m v^2/(4 K))^(2/5) = 0.66 mm at 0.3
    m/s, play 0.5 mm.
    """
    soft = struck(0.3, contact=LankaraniNikravesh(restitution=1.0, stiffness=1e7))
    (said,) = out_of_range(soft)
    depth = 1e6 * (5.0 * 0.3**2 / 4e7) ** 0.4
    assert depth == pytest.approx(659.0, rel=0.01)
    told = float(said.partition("penetrations of about ")[2].partition(" µm")[0])
    assert told == pytest.approx(depth, rel=0.01) and "in J are more than a clearance of 500 µm" in said


def test_a_tenth_of_the_pin_counts_where_play_is_more() -> None:
    (said,) = out_of_range(
        struck(0.5, clearance=2e-3, contact=LankaraniNikravesh(restitution=1.0, stiffness=1e7))
    )
    assert "more than a tenth of the journal's radius, 800 µm" in said


def test_a_pressure_beyond_hardness_is_told_with_numbers() -> None:
    """On 0.2 mm of steel an impact at 1 m/s: Hertz' p_0 = sqrt(F E*/(pi L R)) of the largest force."""
    result = struck(1.0, axial_length=2e-4)
    (said,) = out_of_range(result)
    force = result.measures["J.force.max"]
    radius, modulus = 0.01 * 0.0095 / 5e-4, 207e9 / 2 / 0.91
    pressure = (force * modulus / (3.141592653589793 * 2e-4 * radius)) ** 0.5
    width = 2 * force / (3.141592653589793 * 2e-4 * pressure)
    snug = pressure if width < 0.0095 else 2 * force / (3.141592653589793 * 2e-4 * 0.0095)
    assert (
        f"line pressures of about {1e-9 * snug:.3g} GPa in J on its 0.2 mm are more than the hardness of"
        " steel, 1.6 GPa" in said
    )
    assert result.summary["conformal"] == ["J"]


def test_a_pressure_on_the_default_length_names_it_and_the_part_of_the_tables() -> None:
    """20 mm are used where a joint gives no length; tables of a run without turns are of the whole run."""
    said = list(out_of_range(struck(60.0)))[-1]
    assert "in J on its 20 mm (that of joints without axial_length) are more than" in said
    assert "joints are built for, in the whole run: " in said
    given = list(out_of_range(struck(60.0, axial_length=0.019)))[-1]
    assert "in J on its 19 mm are more than" in given


def test_a_soft_bearing_decides_and_an_unknown_hardness_says_nothing() -> None:
    known = Material("whitemetal", 50e9, 0.35, 7400.0, hardness=2e8)
    (said,) = out_of_range(struck(0.5, bearing_material=known, axial_length=2e-3))
    assert "the hardness of whitemetal, 0.2 GPa" in said
    assert "hardness" not in "".join(
        out_of_range(
            struck(
                0.5,
                bearing_material=Material("own", 50e9, 0.35, 7400.0),
                axial_length=2e-3,
                journal_material=MATERIALS["brass"],
            )
        )
    )


def test_hardness_is_a_materials_own_or_that_of_the_built_in_one() -> None:
    assert hardness_of(Material()) == HARDNESS["steel"][0] == pytest.approx(1.6e9, rel=1e-3)
    assert hardness_of(Material(hardness=3e9)) == 3e9 and hardness_of(Material("steel", 190e9)) is None
    assert hardness_of(MATERIALS["brass"]) is None


def pendulums(gravity: float, angle: float, loose: bool) -> vfife.Mechanism:
    m = vfife.Mechanism("double pendulum", gravity=(0, gravity))
    m.point("O", 0, 0)
    m.link("rod", length=0.3, mass=1, angle=f"{angle} deg")
    m.link("bob", length=0.2, mass=0.5, angle=f"{min(angle + 30, 0) if loose else angle} deg")
    if loose:
        m.clearance_joint("O", "ground.O", "rod.start", clearance="0.15 mm", bearing_radius="10 mm")
    else:
        m.revolute("O", "ground.O", "rod.start")
    m.revolute("E", "rod.end", "bob.start")
    return m


@pytest.mark.parametrize(
    ("model", "cause"),
    [
        (pendulums(0.0, -84.5, True), "no gravity and no load"),
        (pendulums(0.0, -30.0, False), "no gravity and no load"),
        (
            pendulums(-9.81, -90.0, False),
            "in equilibrium, and stays there; whether it is stable is not examined",
        ),
    ],
    ids=["loose", "ideal", "hanging"],
)
def test_a_model_at_rest_says_that_nothing_moves(model: vfife.Mechanism, cause: str) -> None:
    """Energies, accelerations and forces without loads are rounding there: no other caution."""
    result = vfife.simulate(model, duration=0.1)
    assert result.status == "complete"
    (only,) = result.summary["warnings"]
    assert only.startswith("Nothing moves in this run") and cause in only
    assert "Reliable" in str(result) and "Sensitive" not in str(result)
    moving = vfife.simulate(pendulums(-9.81, -89.999, False), duration=0.1)
    assert not any("Nothing moves" in text for text in moving.summary["warnings"])


def test_a_driver_that_waits_is_named_where_nothing_moves() -> None:
    m = vfife.Mechanism("late")
    m.point("O", 0, 0)
    m.rigid_body("block", mass=1, inertia=1e-3, position=(0.1, 0))
    m.slider("rail", "ground.O", "block.center")
    m.step_to(slider="rail", travel=0.01, duration=1, begin=5)
    (only,) = vfife.simulate(m, duration=0.5).summary["warnings"]
    assert "no driver moves anything" in only
