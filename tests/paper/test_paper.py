"""What `vfife paper` says about the source paper, against the paper's own numbers (its text) and closed
forms.

Paper: Table 3 (LIP of force and acceleration, per cent, at 0.1, 0.2, 0.5 mm and 50 pi rad/s); statements of
Sect. 4 and 5.
"""

import dataclasses
import json
import math
from importlib import resources

import numpy as np
import pytest

from vfife.laws import LankaraniNikravesh, Pereira
from vfife_validation.paper import curves, search
from vfife_validation.paper.beyond import damped_laws
from vfife_validation.paper.claims import astray, first_turns
from vfife_validation.paper.context import Context
from vfife_validation.paper.impact import delivered, first_impact
from vfife_validation.paper.influence import Case, ideal_maxima, influences
from vfife_validation.paper.items import ITEMS, make
from vfife_validation.paper.mechanisms import (
    COUPLER,
    CRANK,
    FOLLOWER,
    GROUND,
    Parameters,
    directions,
    four_bar,
)
from vfife_validation.paper.search import TABLE_3, Structure, from_numbers, misfit, table_3

PAPER = np.array([6.72, 17.21, 89.95, 13.45, 28.60, 110.32])
GOAL = 3.0  # percentage points


@pytest.fixture(scope="module")
def context():
    return Context()


@pytest.fixture(scope="module")
def fit():
    return json.loads(
        resources.files("vfife_validation.paper").joinpath("fitted.json").read_text(encoding="utf-8")
    )


def verdicts(item):
    return {verdict.statement: verdict.holds for verdict in item.verdicts}


# ------------------------------------------------------------------------------------------------------------
# the set that was inferred


def test_table_3_of_the_search_is_the_paper_s():
    assert np.array(TABLE_3).reshape(-1) == pytest.approx(PAPER)


def test_best_set_gives_all_six_numbers(context):
    """Within three percentage points, with one set of parameters; contact kept and turns repeated in each of
    the three runs.
    """
    item = make("table3", context)
    found = np.array([[row["lip_force"], row["lip_acceleration"]] for row in item.data["table3"]]).T.reshape(
        -1
    )
    assert [row["clearance_mm"] for row in item.data["table3"]] == pytest.approx([0.1, 0.2, 0.5])
    assert np.abs(found - PAPER).max() < GOAL
    assert all(verdicts(item).values())
    assert all(1 < row["settled_at_turn"] <= 12 for row in item.data["table3"])


def test_best_set_gives_them_with_other_steps(context):
    """Half and a quarter of the step: the set is one of the equations, not of the step."""
    for step in (5e-7, 2.5e-7):
        numbers, sound = table_3([context.parameters], step)
        assert sound.all() and np.abs(numbers - PAPER).max() < GOAL


@pytest.mark.system("runs with several steps")
def test_the_slowest_crank_does_not_feel_the_step(context):
    """10 pi, where contact comes about in twenty onsets: a quarter of the step moves neither number by a
    twentieth of a point.
    """
    runs = influences(
        [Case(context.parameters, 2e-4, 10 * math.pi, step) for step in (1e-6, 2.5e-7)], outputs=20
    )
    assert runs[0].lips == pytest.approx(runs[1].lips, abs=0.05)


def test_stored_sets_are_what_they_are_said_to_be(fit):
    """A spread of the stored sets that fit, run again: the stored numbers, all within the goal."""
    entries = fit["fits"][:: max(1, len(fit["fits"]) // 8)]
    assert len(fit["fits"]) >= 20
    numbers, sound = table_3([from_numbers(entry["parameters"]) for entry in entries])
    assert sound.all()
    assert numbers == pytest.approx(np.array([entry["table_3"] for entry in entries]), abs=0.01)
    assert np.abs(numbers - PAPER).max() <= GOAL


@pytest.mark.system("runs the mechanisms of the paper")
def test_best_of_every_structure_is_what_it_is_said_to_be(fit):
    """Those that cannot give Table 3 as well: uniform rods and the upper branch stay far off."""
    numbers, sound = table_3([from_numbers(entry["parameters"]) for entry in fit["structures"]])
    for entry, found in zip(fit["structures"], misfit(numbers, sound), strict=True):
        assert found == pytest.approx(entry["misfit"], abs=0.02)
        if "uniform rods" in entry["structure"] or "above" in entry["structure"]:
            assert entry["misfit"] > 3 * GOAL


def test_numbers_of_sets_go_there_and_back(context):
    p = dataclasses.replace(context.parameters, crank_angle=0.5, friction_moment="surface", below=False)
    assert from_numbers(json.loads(json.dumps(search.as_numbers(p)))) == p


# ------------------------------------------------------------------------------------------------- the search


def plane(points, step=0.0, workers=None):
    """In place of Table 3: the optimum is known, and no simulation is run."""
    length = np.array([math.log10(p.axial_length) for p in points])
    return PAPER + np.outer(length + 2.0, np.ones(6)), np.ones(len(points), dtype=bool)


def test_search_is_repeatable_and_improves(monkeypatch):
    """The same seed gives the same points, another one others."""
    monkeypatch.setattr(search, "table_3", plane)

    def best(seed):
        one = search.Search(Structure("stiff bars"), np.random.default_rng(seed), size=12)
        one.begin()
        first = one.best
        for _ in range(15):
            one.generation()
        points, _, found = one.all_points()
        assert (
            found[0] == one.best < 0.1 * first
            and (np.diff(found) >= 0).all()
            and len(points) == one.count == 12 * 18
        )
        return points[0]

    assert best(1) == best(1) != best(2)
    assert best(1).axial_length == pytest.approx(0.01, rel=0.02)


def test_points_of_the_cube_are_within_the_limits():
    for structure in search.STRUCTURES:
        d = len(structure.unknowns)
        low, high = (
            search.parameters(structure, np.zeros(d)),
            search.parameters(structure, np.ones(d) * (1 - 1e-12)),
        )
        assert (low.axial_length, high.axial_length) == pytest.approx((1e-3, 5e-2))
        assert low.v0 == pytest.approx(1e-4) and high.v1 == pytest.approx(300.0)
        assert (low.friction_moment != "off") == structure.moment and low.below == structure.below
        assert 0.0 <= high.crank_angle < 2 * math.pi and (high.crank_angle > 0.0) == structure.any_start


def test_what_loses_contact_is_no_fit():
    assert misfit(PAPER[None, :], np.array([False]))[0] >= search.FAILED
    assert misfit(PAPER[None, :] * np.nan, np.array([True]))[0] >= search.FAILED
    assert misfit(PAPER[None, :] + [[0, -2, 0, 1, 0, 0]], np.array([True]))[0] == pytest.approx(2.0)


@pytest.mark.verify
def test_a_search_from_another_seed_comes_near():
    """From nothing but the limits of the unknowns: within the goal after at most 80 generations."""
    one = search.Search(Structure("bars", any_start=True), np.random.default_rng(7))
    one.begin()
    while one.best > GOAL and one.generations < 80:
        one.generation()
    assert one.best <= GOAL


def test_a_search_ends_with_its_budget_and_by_ctrl_c(monkeypatch):
    """A budget that is spent leaves out the structures that have not begun; Ctrl-C keeps what there is."""
    monkeypatch.setattr(search, "table_3", plane)
    spent = search.run(0.0, 1, lambda text: None, [Structure("stiff bars"), Structure("bars")])
    assert len(spent) == 1 and spent[0].count == 96

    def interrupted(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(search.Search, "generation", interrupted)
    told = []
    kept = search.run(60.0, 1, told.append, [Structure("stiff bars")])
    assert [one.count for one in kept] == [96] and "stopped by Ctrl-C" in told[-1]


# ---------------------------------------------------------------------------------------------- the mechanism


@pytest.mark.parametrize("below", [True, False])
@pytest.mark.parametrize("angle", np.linspace(0.0, 6.0, 7))
def test_linkage_closes_at_every_crank_angle(angle, below):
    """Coupler's end = follower's end, on the side of line B-D that was asked for."""
    coupler, follower = directions(angle, below)
    b = CRANK * np.array([math.cos(angle), math.sin(angle)])
    c = b + COUPLER * np.array([math.cos(coupler), math.sin(coupler)])
    assert c == pytest.approx(
        np.array([GROUND, 0.0]) + FOLLOWER * np.array([math.cos(follower), math.sin(follower)]), abs=1e-12
    )
    d, e = np.array([GROUND, 0.0]) - b, c - b
    assert (d[0] * e[1] - d[1] * e[0] > 0.0) == below


def test_ideal_maxima_are_those_of_method():
    """Independent kinematics and dynamics (method.md, section 2): two-particle links and uniform rods at 50
    pi, and 10 pi a 25th of it.
    """
    assert ideal_maxima("stiff bars", True, 50 * math.pi) == pytest.approx((89430.6, 22816.05), rel=1e-5)
    assert ideal_maxima("uniform rods", True, 50 * math.pi) == pytest.approx((65338.1, 22816.05), rel=1e-5)
    assert ideal_maxima("bars", False, 10 * math.pi) == pytest.approx((3577.2, 912.642), rel=2e-5)


def test_start_angle_moves_along_the_same_ideal_motion():
    """A mechanism started elsewhere on the branch turns through the same ideal motion."""
    p = Parameters(crank_angle=2.0)
    runs = [four_bar(q, 2e-4).ideal() for q in (p, dataclasses.replace(p, crank_angle=0.0))]
    from vfife.solvers.ensemble import ensemble

    one, other = ensemble(runs, step=1e-5, turns=1, outputs=400)
    assert one.turns.block("body_alpha_max")[-1] == pytest.approx(
        other.turns.block("body_alpha_max")[-1], rel=1e-5
    )


# ------------------------------------------------------------------------------------------------- Figs. 8-10


@pytest.mark.parametrize("restitution", [0.9, 0.5])
def test_one_impact_is_the_closed_form(context, restitution):
    """Rebound by the law's own relation, energy inside the loop = kinetic energy lost; 0.913177 and 0.72524
    are published values.
    """
    entry = next(e for e in make("fig8", context).data["impacts"] if e["restitution"] == restitution)
    assert entry["rebound"] == pytest.approx({0.9: 0.913177, 0.5: 0.72524}[restitution], abs=2e-5)
    assert entry["loss"] == pytest.approx(0.5 * (1.0 - entry["rebound"] ** 2), rel=1e-4)


def test_impact_of_the_text(context):
    """1 kg at 1 m/s, K = 6.6e10, 0.9: 0.15277 ms, 49.585 um, 23.221 kN."""
    entry = next(e for e in make("fig8", context).data["impacts"] if e["restitution"] == 0.9)
    assert entry["depth"] == pytest.approx(4.9585e-5, rel=1e-4)
    assert entry["peak_force"] == pytest.approx(2.3221e4, rel=1e-4)
    assert entry["contact_time"] == pytest.approx(1.5277e-4, rel=1e-4)
    assert all(verdicts(make("fig8", context)).values())


def test_elastic_impact_gives_everything_back():
    """Hertz: depth (5 m v^2/4 K)^(2/5), whole kinetic energy back."""
    hit = first_impact(LankaraniNikravesh(restitution=1.0, stiffness=6.6e10), 0.02)
    assert hit["depth"].max() == pytest.approx((1.25 / 6.6e10) ** 0.4, rel=1e-5)
    assert delivered(0.0) == 1.0


def test_enhanced_law_penetrates_less_where_the_bearing_is_long_enough(context):
    """Fig. 9; at the length where both are equally deep they are, on either side of it they are not."""
    data = make("fig9", context).data
    sphere = data["depths"]["lankarani-nikravesh"]
    assert data["depths"]["enhanced, 20 mm"] < 0.6 * sphere
    for factor, sign in ((0.9, 1.0), (1.0, 0.0), (1.1, -1.0)):
        depth = first_impact(Pereira(restitution=0.9), factor * data["equal_length"])["depth"].max()
        assert (depth - sphere) / sphere == pytest.approx(sign * 0.05, abs=0.03 if sign else 5e-3)


def test_second_peak_is_lower(context):
    """Fig. 10: the journal crosses with what it kept, 0.913177 m/s, so the second contact begins (2 c/v')
    after the first ended.
    """
    data = make("fig10", context).data
    assert data["peaks"][1] < 0.95 * data["peaks"][0]
    assert data["begins"] == pytest.approx([5e-4, 5e-4 + 1.5277e-4 + 1e-3 / 0.913177], abs=1e-6)


# ---------------------------------------------------------------------------------------------------- Sect. 5


HOLDS = [
    "All three joints stay in contact throughout the settled turn",
    "LIP(F) falls as the crank turns faster",
    "LIP(a) falls as the crank turns faster",
    "Forces and accelerations themselves grow with crank speed",
    "Strong vibration after the start declines",
    "The motion becomes periodic",
    "Contact is lost while the motion settles only",
    "Penetration grows with crank speed",
    "The curve fluctuates although contact is kept",
]


@pytest.mark.system("runs the mechanisms of the paper")
def test_claims_of_the_text(context):
    """Each conclusion of Sect. 5 holds for the set that fits Table 3, wherever it is judged."""
    found = {}
    for entry in make("claims", context).data["claims"]:
        found.setdefault(entry["claim"], []).append(entry["holds"])
    assert all(all(found[claim]) for claim in HOLDS), {claim: found[claim] for claim in HOLDS}
    assert found["The enhanced law penetrates less"] == [True]
    assert found["The vibration at the start grows with the clearance"] == [
        False
    ]  # it starts where the forces are small
    assert len(found["The curve fluctuates although contact is kept"]) == 4


def test_a_verdict_can_be_false(context):
    """Uniform rods: other numbers than Table 3, and the verdict about the goal says so."""
    rods = Context(
        fit={
            **context.fit,
            "best": {**context.fit["best"], "parameters": search.as_numbers(Parameters(link="uniform rods"))},
        }
    )
    item = make("table3", rods)
    assert (
        next(holds for statement, holds in verdicts(item).items() if statement.startswith("All six")) is False
    )


def test_turning_points_of_a_curve():
    """A sine over one turn turns twice; a ripple below the floor does not count, one above it does."""
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    assert curves.ripples(np.sin(angle)) == 2
    assert curves.ripples(np.sin(angle) + 0.002 * np.sin(40 * angle)) == 2
    assert curves.ripples(np.sin(angle) + 0.2 * np.sin(10 * angle)) > 10


def test_every_damped_law_is_taken(context):
    """Beyond: each registered contact law of the package with a restitution, at the
    restitution of the set.
    """
    laws = damped_laws(context.parameters)
    assert {"lankarani-nikravesh", "pereira"} <= {name.partition(",")[0] for name in laws}
    assert {law.restitution for law in laws.values()} == {context.parameters.contact.restitution}


def test_vibration_at_the_start_grows_with_clearance_where_the_forces_are_large(context):
    """Started at crank angle 0, near the peak, the paper's claim holds for the very set for which it does not
    from 115 degrees.
    """
    p = dataclasses.replace(context.parameters, crank_angle=0.0)
    runs = influences([Case(p, c) for c in (1e-4, 2e-4, 5e-4)])
    first = [astray(one, first_turns(context, one))[0] for one in runs]
    assert first == sorted(first) and first[2] > 1.2 * first[0] > 2.0


@pytest.mark.verify
def test_lost_table_4_over_all_fits(context):
    """Every stored set: LIPs at 10 pi above those at 50 pi; the ranges that method.md saw with two sets lie
    in reach.
    """
    low, high = np.array(make("table4", context).data["spread"]).transpose(2, 0, 1)
    assert (low[0] > 30.0).all() and (high[0] < 400.0).all()
    assert (low[2] >= PAPER[[1, 4]] - GOAL).all() and (high[2] <= PAPER[[1, 4]] + GOAL).all()


@pytest.mark.verify
def test_beyond_the_paper(context):
    """Rise with clearance and of the absolute maxima survive all; the step does not matter; the start angle
    does.
    """
    item = make("beyond", context)
    found = verdicts(item)
    assert found["Survives every change: maxima rise with speed"]
    assert found["From 1 µs on the step moves no number by more than 1.5 points"]
    assert not found["The settled turn does not depend on the start angle (within a point)"]


def test_without_friction_the_motion_does_not_settle(context):
    """Friction is what ends the vibration of the start: the same set without it has not repeated a turn after
    eight.
    """
    p = dataclasses.replace(context.parameters, friction=0.0)
    one = influences([Case(p, 2e-4)], outputs=20, turns=8)[0]
    assert one.run.settled is None and one.run.distances[-1] > 1e-2


def test_every_item_has_a_maker():
    from vfife.cli.commands.verify import PAPER_ITEMS

    assert tuple(ITEMS) == PAPER_ITEMS
