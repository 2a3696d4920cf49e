"""Where a run goes beyond what joints are built for: one warning with numbers; what is usual:
one quiet line.
"""

import pytest

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
    assert line.startswith("J: impacts of up to 0.3 m/s") and line in result.summary["remarks"]


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
