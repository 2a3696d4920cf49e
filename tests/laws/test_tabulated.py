"""A law that is a table: what an impact loses is the area between its branches, and nothing of it gives
energy.
"""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

import vfife
from support import go, journal_in_bearing
from vfife.errors import LawError, ModelError
from vfife.laws import Frictionless, KelvinVoigt, Pair, Tabulated
from vfife.laws.contact.tabulated import MOST_PIECES
from vfife.modelfile import dump, load, loads

PAIR = Pair(0.01, 2e-4, 0.02)
STIFFNESS = 1e8  # N/m
EPS = 2.0**-52
LINE = ((0.0, 0.0), (1e-4, 1e4))
LOADING = tuple((d, STIFFNESS * d * (1.0 + 1e4 * d)) for d in np.linspace(0.0, 1e-4, 11).tolist())
UNLOADING = tuple((d, force * (0.5 + 0.5 * (1e4 * d) ** 2)) for d, force in LOADING)


def parted(
    law: vfife.laws.ContactLaw, speed: float = 1.0, step: float = 2e-7, duration: float | None = None
) -> tuple[float, float]:
    """Speed of parting and deepest penetration (m) of a free impact of 1 kg."""
    duration = 2e-4 / speed + 4e-4 if duration is None else duration
    m = journal_in_bearing(speed, clearance=2e-4, contact=law, friction=Frictionless())
    record = go(m, step, duration=duration, outputs=200, loop="generated")
    return -float(record.block("particle_u")[-1, 1]), float(record.block("contact_penetration_max").max())


@pytest.mark.parametrize("loop", ["generated", "interpreted"])
def test_a_straight_line_is_the_linear_law_to_the_bit(loop):
    step, duration = (2e-7, 5e-4) if loop == "generated" else (4e-6, 6e-4)
    rows = []
    for law in (Tabulated(loading=LINE), KelvinVoigt(stiffness=STIFFNESS, damping_coefficient=0.0)):
        m = journal_in_bearing(clearance=2e-4, contact=law, friction=Frictionless())
        rows.append(go(m, step, duration=duration, outputs=100, loop=loop).block("contact_normal_force"))
    assert rows[0].max() > 9e3 and np.array_equal(*rows)


@pytest.mark.parametrize("speed", [0.3, 0.9])
def test_two_lines_give_the_root_of_their_slopes_at_any_speed(speed):
    """Loading k d, unloading r k d: the area below one over that below the other is r, so the restitution is
    its root; closed form.
    """
    law = Tabulated(loading=LINE, unloading=((0.0, 0.0), (1e-4, 0.6e4)), transition=0.01)
    there, deepest = parted(law, speed)
    assert there / speed == pytest.approx(math.sqrt(0.6), rel=1e-4)
    assert deepest == pytest.approx(speed * math.sqrt(1.0 / STIFFNESS), rel=1e-3), (
        "m v^2 = k d^2 on the way in"
    )


@pytest.mark.parametrize("share", [0.4, 0.8])
def test_an_impact_loses_the_area_between_the_branches_wherever_it_turns(share):
    """Areas of the points' own cubics, by scipy; the transition costs some of its square, and the error of a
    step goes with its square.
    """
    up, down = (PchipInterpolator(*np.transpose(points)) for points in (LOADING, UNLOADING))
    deep = share * 1e-4
    speed = math.sqrt(2.0 * up.integrate(0.0, deep))
    left = math.sqrt(2.0 * down.integrate(0.0, deep))
    law = Tabulated(loading=LOADING, unloading=UNLOADING, transition=0.01)
    there, deepest = parted(law, speed, 1e-7)
    assert deepest == pytest.approx(deep, rel=1e-4) and there == pytest.approx(left, rel=3e-4)
    coarse, coarser = (parted(law, speed, step)[0] for step in (4e-7, 8e-7))
    assert abs(coarse - coarser) < 3e-4 * there
    wide = Tabulated(loading=LOADING, unloading=UNLOADING, transition=0.2)
    assert 1e-4 < abs(parted(wide, speed, 1e-7)[0] / left - 1.0) < 0.02, "a wider transition loses less"


def test_a_free_impact_by_itself_says_the_same():
    from vfife.measures.impact import free_impact

    law = Tabulated(loading=LINE, unloading=((0.0, 0.0), (1e-4, 0.25e4)), transition=0.01)
    assert free_impact(law, PAIR, 2.0, 0.5).restitution == pytest.approx(0.5, rel=1e-4)


def test_without_unloading_nothing_is_lost():
    there, _ = parted(Tabulated(loading=LOADING), 1.0)
    assert there == pytest.approx(1.0, rel=1e-7)


@settings(deadline=None, max_examples=25)
@given(st.lists(st.floats(0.0, 1.3), min_size=3, max_size=40), st.integers(0, 1000))
def test_no_table_gives_energy(shares, seed):
    """Whatever is measured, what is used of it has a damping coefficient that is not negative, or is refused.

    A piece between coefficients h and H >= 0 leaves neither in exact numbers. Rounding takes away at most 150
    EPS max(h, H) where both are on it: with D = |H - h|, slopes of Fritsch and Carlson are at most 3 D, so
    the terms of the cubic are at most h, 3 D, 12 D and 8 D; each of the upper two coefficients comes from six
    operations on 8 D to 12 D (36 EPS D + 24 EPS D), and Horner's seven take 3.5 EPS (h + 23 D).
    """
    places = np.cumsum(np.random.default_rng(seed).uniform(1e-7, 1e-5, len(shares)))
    force = 1e8 * places
    try:
        law = Tabulated(
            loading=tuple(zip(places.tolist(), force.tolist(), strict=True)),
            unloading=tuple(zip(places.tolist(), (force * np.minimum(shares, 1.04)).tolist(), strict=True)),
        )
    except LawError as error:
        assert "would give energy" in str(error) or "no force" in str(error)
        return
    p = law.parameters(PAIR)
    assert len(law.knots()) <= MOST_PIECES + 1
    begins, ends = law.pieces, [*(piece[0] for piece in law.pieces[1:]), 1.5 * law.end]
    for piece, end in zip(begins, ends, strict=True):
        coefficients = [
            law.force(d, 1.0, p)[1]
            for d in (*np.linspace(piece[0], end, 16).tolist()[:-1], np.nextafter(end, 0.0))
        ]
        largest = max(coefficients[0], coefficients[-1])
        assert largest >= 0.0 and min(coefficients) >= -150.0 * EPS * largest


def test_a_long_table_is_thinned_and_says_so():
    d = np.linspace(0.0, 1e-4, 1001)
    force = 2e10 * d**1.5
    law = Tabulated(loading=tuple(zip(d.tolist(), force.tolist(), strict=True)))
    p = law.parameters(PAIR)
    off = max(abs(law.force(float(x), 0.0, p)[0] - 2e10 * x**1.5) for x in d)
    assert len(law.knots()) <= MOST_PIECES + 1 and off < 5e-4 * force[-1]
    assert any("of 1001 penetrations are used" in one for one in law.cautions(PAIR))
    noisy = force * (1.0 + 0.02 * np.random.default_rng(1).standard_normal(len(d)))
    noisy[0] = 0.0
    law = Tabulated(loading=tuple(zip(d.tolist(), noisy.tolist(), strict=True)))
    told = " ".join(law.cautions(PAIR))
    assert "loading does not fall" in told
    p, forces = law.parameters(PAIR), []
    forces = [law.force(float(x), 0.0, p)[0] for x in d]
    assert min(np.diff(forces)) >= -1e-9 and np.abs(forces - force).max() < 0.05 * force[-1]


def test_beyond_its_end_it_goes_on_straight_and_a_run_says_so():
    law = Tabulated(loading=LOADING, unloading=UNLOADING)
    p = law.parameters(PAIR)
    end, slope = LOADING[-1][1], PchipInterpolator(*np.transpose(LOADING)).derivative()(1e-4)
    assert law.force(1.5e-4, 0.0, p)[0] == pytest.approx(end + 0.5e-4 * slope, rel=1e-7)
    assert "beyond the table" in " ".join(law.cautions(PAIR, 1.2e-4, 1.0)) and not law.cautions(
        PAIR, 0.9e-4, 1.0
    )
    energy = law.elastic_energy(np.array([0.0, 1e-4, 1.5e-4]), p)
    mean = [0.5 * (law.force(x, 0.0, p)[0] + law.force(x, 0.0, p)[0]) for x in np.linspace(0.0, 1e-4, 20001)]
    assert energy[0] == 0.0 and energy[1] == pytest.approx(np.trapezoid(mean, dx=5e-9), rel=1e-7)
    assert energy[2] - energy[1] == pytest.approx(0.5e-4 * (end + 0.25e-4 * slope), rel=1e-7)


def test_factors_stretch_it():
    law = Tabulated(loading=LOADING, unloading=UNLOADING)
    wide = dataclasses.replace(law, force_factor=3.0, penetration_factor=2.0)
    for depth in (1e-6, 4.4e-5, 1e-4, 2e-4):
        one, other = (
            law.force(depth, 2.0, law.parameters(PAIR)),
            wide.force(2.0 * depth, 2.0, wide.parameters(PAIR)),
        )
        assert other == pytest.approx([3.0 * value for value in one], rel=1e-12)


def test_derivatives_are_carried_through_it():
    """F = v sqrt(k m), d = v sqrt(m/k): half a per cent of force a per cent of stiffness, and half of one
    less of penetration.
    """
    m = journal_in_bearing(1.0, clearance=2e-4, contact=Tabulated(loading=LINE), friction=Frictionless())
    found = vfife.sensitivity(
        m,
        ["J.force.max", "J.penetration.max"],
        ["joint.J.contact.*_factor"],
        duration=5e-4,
        step=1e-6,
        companions=0,
    )
    for path, force, depth in (("force", 0.5, -0.5), ("penetration", -0.5, 0.5)):
        where = f"joint.J.contact.{path}_factor"
        assert found.elasticity("J.force.max", where) == pytest.approx(force, abs=2e-3)
        assert found.elasticity("J.penetration.max", where) == pytest.approx(depth, abs=2e-3)


# ------------------------------------------------------------------------------------------------------ files

MODEL = """
[ground]
O = [0, 0]
[body.b]
model = "particle"
mass = 1
velocity = [1, 0, 0]
[joint.J]
kind = "clearance"
bearing = "ground.O"
journal = "b.center"
clearance = "0.2 mm"
bearing_radius = "10 mm"
contact = { law = "table", loading = LOADING, unloading = "back.csv" }
"""
CURVE = "penetration (um), force (kN)\n# press, specimen 3\n0, 0\n50, 4\n100, 10\n"
BACK = "penetration (um), force (kN)\n100, 10\n50, 2\n0, 0\n"


def model(folder: Path, loading: str = '"out.csv"', curve: str = CURVE, back: str = BACK) -> Path:
    """A model file with its curves beside it."""
    (folder / "out.csv").write_text(curve)
    (folder / "back.csv").write_text(back)
    path = folder / "model.toml"
    path.write_text(MODEL.replace("LOADING", loading))
    return path


def test_curves_stand_in_files_or_in_the_model(tmp_path):
    m = load(model(tmp_path))
    law = m.joints["J"].contact
    assert law.loading == ((0.0, 0.0), (5e-5, 4e3), (1e-4, 1e4)) and law.unloading == (
        (0.0, 0.0),
        (5e-5, 2e3),
        (1e-4, 1e4),
    )
    assert load(model(tmp_path, '[["0 um", 0], ["50 um", "4 kN"], ["0.1 mm", 1e4]]')) == m
    (tmp_path / "out.csv").unlink()
    assert loads(dump(m)) == m, "what is written holds the points, and needs no file"


FAULTS = {
    "no file": ({"loading": '"aut.csv"'}, 'Did you mean "out.csv"'),
    "a cell": ({"curve": CURVE.replace("4", "four")}, '"out.csv": line 4, column 2 (force (kN))'),
    "a unit": ({"curve": CURVE.replace("kN", "mm")}, "its unit is that of a length"),
    "a column": ({"curve": CURVE.replace("force", "forze")}, 'Did you mean "force"'),
    "not sorted": ({"curve": CURVE.replace("50", "150")}, "does not come after"),
    "an offset": ({"curve": CURVE.replace("0, 0", "0, 1")}, "it begins with 1000 N at no penetration"),
    "pulls": ({"curve": CURVE.replace("50, 4", "50, -4")}, "a force below 0 N"),
    "falls": ({"curve": CURVE.replace("50, 4", "50, 14")}, "its force falls while the surfaces approach"),
    "exchanged": ({"curve": BACK, "back": CURVE}, "would give energy"),
    "one point": ({"loading": "[[0, 0]]"}, "a table of 1 points"),
    "no pairs": ({"loading": "[0, 1]"}, "a list"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_what_is_wrong_with_a_curve_is_told(tmp_path, name):
    given_, what = FAULTS[name]
    with pytest.raises(ModelError) as told:
        load(model(tmp_path, **given_))
    assert what in str(told.value) and "[joint.J.contact]" in str(told.value), str(told.value)
    if name in ("no file", "a cell", "a unit", "a column"):
        assert len(told.value.faults) == 1, "what cannot be read is not also a table without points"
