"""Where laws leave the range of their source, what they say there, surfaces they are not for, and words they
do not know.
"""

import math

import pytest

import vfife
from support import CONTACT_LAWS, contact_law, four_bar, go, journal_in_bearing
from vfife.assembly.assemble import assemble
from vfife.laws import (
    Flores,
    Frictionless,
    Goldsmith,
    Hertz,
    Johnson,
    LankaraniNikravesh,
    LeeWang,
    Liu,
    Material,
    Pair,
    Pereira,
)
from vfife.laws.contact.damping import DAMPING, delivered
from vfife.model.surfaces import cautions, law_facts, remarks, surface_facts
from vfife.report.cautions import rebound_cautions
from vfife.simulation.result import Result

PAIR = Pair(0.01, 5e-4, 0.02, effective_mass=1.0)
OUTSIDE = Pair(0.03, 0.0, 0.02, opposite_radius=0.01, effective_mass=1.0)
PLANE = Pair(math.inf, 0.0, 0.02, opposite_radius=0.01, effective_mass=1.0)


def test_a_pair_inside_outside_and_on_a_plane():
    assert (PAIR.external, OUTSIDE.external) == (False, True)
    assert (PAIR.journal_radius, OUTSIDE.journal_radius) == (pytest.approx(0.0095), 0.01)
    assert PAIR.relative_radius == pytest.approx(0.01 * 0.0095 / 0.0005, rel=1e-12)
    assert OUTSIDE.relative_radius == pytest.approx(0.03 * 0.01 / 0.04, rel=1e-12)
    assert PLANE.relative_radius == 0.01


def test_hertz_outside():
    """K = 4/[3 (s_i + s_j)] sqrt(R_i R_j/(R_i + R_j)); a sphere on a plane: 4/3 E* sqrt(R)."""
    sigma = 2 * (1 - 0.3**2) / 207e9
    assert Hertz().parameters(OUTSIDE)[0] == pytest.approx(
        4 / (3 * sigma) * math.sqrt(0.03 * 0.01 / 0.04), rel=1e-12
    )
    assert Hertz().parameters(PLANE)[0] == pytest.approx(4 / (3 * sigma) * math.sqrt(0.01), rel=1e-12)


def test_pereira_outside():
    """a = 0.39, b = 0.85, n = 1.094, dR = R_i + R_j, in mm, MPa and N; on a plane b/dR vanishes."""
    modulus, depth = 207e3 / (2 * (1 - 0.09)), 0.012
    force = Pereira.force(1e-3 * depth, 0.0, Pereira().parameters(OUTSIDE))[0]
    assert force == pytest.approx((0.39 * 40 + 0.85) * 20 * modulus / 40 * depth**1.094, rel=1e-12)
    flat = Pereira.force(1e-3 * depth, 0.0, Pereira().parameters(PLANE))[0]
    assert flat == pytest.approx(0.39 * 20 * modulus * depth**1.094, rel=1e-12)


@pytest.mark.parametrize("law", CONTACT_LAWS, ids=lambda law: law.name)
def test_outside_every_law_has_a_force_or_says_that_it_has_none(law):
    for pair in (OUTSIDE, PLANE):
        try:
            p = contact_law(law).parameters(pair)
        except ValueError as error:
            assert f'the law "{law.name}"' in str(error)
        else:
            assert all(math.isfinite(value) for value in p) and law.force(1e-5, 0.0, p)[0] > 0.0
    for law_inside in (Liu, Goldsmith):
        with pytest.raises(ValueError, match="inside a bearing"):
            law_inside().parameters(OUTSIDE)


@pytest.mark.parametrize("name", DAMPING)
@pytest.mark.parametrize("law", [Hertz, Liu, Pereira, Johnson], ids=lambda law: law.name)
def test_any_damping_factor_goes_with_any_elastic_force(law, name):
    p = law(restitution=0.6, damping=name).parameters(PAIR)
    elastic, damping = law.force(1e-5, 2.0, p)
    assert damping == pytest.approx(2.0 * DAMPING[name](0.6) * elastic, rel=1e-12)


def test_an_unknown_damping_factor_is_told():
    with pytest.raises(ValueError, match='law "liu": damping = "flroes".*Did you mean "flores"'):
        Liu(damping="flroes")
    with pytest.raises(ValueError, match='allowed: "none" or "hunt-crossley"'):
        Liu(damping="?")


@pytest.mark.parametrize("restitution", [0.05, 0.1, 0.5, 0.9, 0.999, 1.0])
def test_gonthiers_relation_solved_delivers_what_it_is_given(restitution):
    """Here by the closed form; test_contact_laws integrates it for each law."""
    chi = DAMPING["gonthier-exact"](restitution)
    assert chi * (1 + restitution) == pytest.approx(
        math.log((1 + chi) / (1 - chi * restitution)) if chi else 0.0, rel=1e-9
    )
    assert delivered(chi) == pytest.approx(restitution, abs=1e-9)


# --------------------------------------------------------------------------------------------------- cautions


def test_pereira_says_where_its_fit_ends():
    assert Pereira().cautions(PAIR) == () and Pereira().cautions(OUTSIDE) == ()
    (said,) = Pereira().cautions(Pair(0.01, 4e-6, 0.02))
    assert "0.004 mm" in said and "0.005 to 10 mm" in said and "all the same" in said
    with pytest.raises(ValueError, match="no exponent for a clearance of 9e-07 m"):
        Pereira().parameters(Pair(0.01, 9e-7, 0.02))


def test_johnson_says_where_its_relation_ends():
    assert Johnson().cautions(PAIR, 2.6e-4, 1.0) == ()
    (said,) = Johnson().cautions(PAIR, 2.8e-4, 1.0)
    assert "280 µm" in said and "0.5413 dR = 270.7 µm" in said and "tangent" in said


def test_hertz_has_a_range_where_a_line_will_do_and_warns_beyond():
    """1e-5 sqrt(E/rho) and 1e-3 sqrt(E/rho), of the slower material: steel 0.0515 and 5.15 m/s."""
    law = LankaraniNikravesh()
    assert law.usual(PAIR) == (pytest.approx(0.05151, rel=1e-3), pytest.approx(5.151, rel=1e-3))
    assert (
        law.cautions(PAIR, 1e-5, 5.1) == ()
        and Flores().usual(PAIR) == law.usual(PAIR)
        and Johnson().usual(PAIR) is None
    )
    (said,) = law.cautions(PAIR, 1e-5, 5.2)
    assert "5.2 m/s" in said and "5.15 m/s" in said
    lead = Material("lead", 16e9, 0.44, 11340.0)
    assert law.usual(Pair(0.01, 5e-4, 0.02, bearing=lead))[0] == pytest.approx(0.01188, rel=1e-3)


def test_joints_that_are_as_fast_as_usual_share_a_line():
    m = four_bar("BCD")
    (line,) = remarks(m, {"B": (0.0, 0.3), "C": (0.0, 0.04), "D": (0.0, 0.5)})
    assert line.startswith("B, C, D: impacts of up to 500 mm/s") and "up to 51.5 mm/s" in line
    assert remarks(m, dict.fromkeys("BCD", (0.0, 0.04))) == () == remarks(m, dict.fromkeys("BCD", (0.0, 6.0)))


def test_a_damping_factor_says_what_it_delivers():
    (said,) = LeeWang(restitution=0.5).facts(PAIR)
    e = delivered(0.375)
    assert 0.375 * (1 + e) == pytest.approx(math.log(1.375 / (1 - 0.375 * e)), rel=1e-12)
    assert f"with restitution 0.5 a free impact rebounds with {e:.4g} of its speed" in said
    assert 'the law "hertz" with damping = "gonthier-exact"' in said
    times = DAMPING["gonthier-exact"](0.5) / 0.375
    assert f"damps {times:.2g} times as strongly, also when a closed contact that began slowly" in said
    assert "hertz" not in Liu(restitution=0.5, damping="lee-wang").facts(PAIR)[0]
    assert DAMPING["gonthier-exact"](1e-3) <= 1000.0 and delivered(1000.0) <= 1e-3
    assert Flores(restitution=0.9).facts(PAIR) == () == Hertz().facts(PAIR)


def test_a_rebound_is_no_caution_but_where_impacts_are_asked_for():
    """The compressor's restitution is that of its law: its answers begin with no caution about it."""
    machine = vfife.gallery.compressor()
    assert cautions(machine) == ()
    (fact,) = law_facts(machine)
    assert fact.startswith("Joints big-end, small-end, cylinder: lankarani-nikravesh, with restitution 0.5")
    assert rebound_cautions(machine, ["main.force.max", "crank.power.mean"]) == ()
    assert rebound_cautions(machine, ["main.force.max", "small-end.approach_speed.max"]) == (fact,)


def test_a_block_touches_with_its_corners_and_their_radius_is_stated():
    """Pressure of a line contact goes with the root of 1/radius, so a reader must know the radius."""
    machine = vfife.gallery.compressor()
    assert surface_facts(machine) == (
        "Joint cylinder: the block touches the walls with its corners, whose radius of 1 mm (corner_radius)"
        " decides its pressures, wear and contact stiffness.",
    )
    assert surface_facts(four_bar("BCD")) == ()


def test_assembly_and_result_say_it_once_for_joints_that_are_alike():
    joints = {"clearance": 4e-6, "contact": Pereira(restitution=0.9)}
    (note,) = assemble(four_bar("BCD", **joints), 1e-7, duration=1e-3, force_step=True).notes
    assert note.startswith("Joints B, C, D: pereira, the clearance of 0.004 mm")
    assert assemble(four_bar("BCD"), 1e-6, duration=1e-3, force_step=True).notes == ()


def test_a_run_tells_its_fastest_impact():
    record = go(
        journal_in_bearing(0.7, friction=Frictionless(), contact=LankaraniNikravesh(restitution=0.8)),
        1e-6,
        duration=4e-3,
        outputs=10,
    )
    assert record.block("contact_fastest")[-1] == pytest.approx(0.7, rel=1e-6)
    assert record.block("contact_onsets")[-1] > 1
    told = Result(record).summary
    assert [one for one in told["remarks"] if one.startswith("J: impacts of up to 700 mm/s")] and not told[
        "warnings"
    ]


def test_a_slow_run_is_silent():
    record = go(
        journal_in_bearing(0.04, friction=Frictionless(), contact=LankaraniNikravesh(restitution=0.8)),
        1e-6,
        duration=3e-2,
        outputs=10,
    )
    assert record.block("contact_onsets")[-1] >= 1
    told = Result(record).summary
    assert not told["remarks"] and not [one for one in told["warnings"] if "lankarani" in one]
