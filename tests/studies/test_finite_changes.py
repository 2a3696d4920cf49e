"""Derivatives beside finite changes of a number: what is a derivative, what is a change for 1 %, what is
unknown; and the runs that it is judged by.
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from typing import Any

import numpy as np
import pytest

import vfife
from choice import default_cases
from sensitivities import outside
from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.measures.catalogue import PEAKS, over_turn
from vfife.measures.turns import last_turn
from vfife.results.derivatives import Derivative, Sensitivity
from vfife.solvers.ensemble import measures_of, step_sizes
from vfife.solvers.record import recorded_rows
from vfife.solvers.transient import run
from vfife.studies.methods.finite_difference import (
    LEAST_AGREEMENT,
    WIDTHS,
    FiniteChanges,
    agreement,
    compared_with_changes,
    with_same_steps,
)
from vfife.studies.methods.local_search import pattern_search

# Every model of the gallery with contact; the block in a guide with clearance, whose contacts have names of
# their own, ended in a KeyError.
WITH_CONTACT = {
    "block_on_incline": {"duration": 0.01}, "compressor": {"turns": 0.01}, "four_bar": {"turns": 0.01},
    "four_bar_case_b": {"turns": 0.02},
    "four_bar_case_c": {"turns": 0.02}, "four_bar_loose": {"duration": 0.05},
    "jansen_leg_loose": {"turns": 0.02}, "journal_in_bearing": {"duration": 1e-3},
    "piston_slap": {"turns": 0.1},
    "slider_crank_free": {"duration": 0.004}, "slider_crank_loose_guide": {"turns": 0.1},
    "slider_crank_loose_pin": {"turns": 0.02},
}  # fmt: skip


def test_the_list_has_every_model_with_contact():
    assert {name for name in gallery.__all__ if getattr(gallery, name)().contacts} == WITH_CONTACT.keys()


@pytest.mark.parametrize(
    "name",
    default_cases(
        WITH_CONTACT, lambda name: name == "slider_crank_loose_guide", "displaced runs of every model"
    ),
)
def test_every_model_with_contact_has_derivatives_by_the_numbers_of_its_joints(name):
    found = vfife.sensitivity(getattr(gallery, name)(), None, ["joint.*"], companions=0, **WITH_CONTACT[name])
    assert found.derivatives and found.measures
    assert not any("cylinder.1" in why for why in found.refused.values())


def changed(
    own: list[float], up: list[float], down: list[float], close: float | None = None
) -> FiniteChanges:
    """Changes of a measure "f" at some step sizes by a number "p" that is 1; those of 0.1 % a tenth, or
    ``close`` of the number.
    """
    values: dict[tuple[str, float], list[dict[str, float] | None]] = {}
    for share, ends in ((0.01, up), (-0.01, down)):
        values["p", share] = [{"f": one} for one in ends]
        near = [
            one + (0.1 * (end - one) if close is None else 0.1 * share * close)
            for one, end in zip(own, ends, strict=True)
        ]
        values["p", 0.1 * share] = [{"f": one} for one in near]
    return FiniteChanges([{"f": one} for one in own], values)


def judged(slopes: list[float], changes: FiniteChanges) -> Derivative:
    """What is known of the measure "f"."""
    return compared_with_changes(
        Derivative("p", 1.0, {"f": slopes[0]}, {"f": (min(slopes), max(slopes))}),
        {"f": slopes},
        changes,
        {"f": 1.0},
    )


def test_a_derivative_that_changes_agree_with_holds_and_its_range_covers_both():
    found = judged([2.0, 2.02, 2.01], changed([1.0] * 3, [1.0205] * 3, [0.9795] * 3, close=2.0))
    assert found.kinds["f"] == "derivative"
    low, high = found.ranges["f"]
    reach = LEAST_AGREEMENT * 1.0  # of the largest effect
    assert low == pytest.approx(1.98 - reach, rel=1e-9) and high == pytest.approx(
        2.05 + reach, rel=1e-9
    )  # three times the spread; the change is 2.05


def test_a_range_far_below_the_largest_effect_reaches_a_few_of_its_widths_further():
    slopes = [2e-5, 2.02e-5, 2.01e-5]
    found = judged(slopes, changed([1.0] * 3, [1.0 + 2.01e-7] * 3, [1.0 - 2.01e-7] * 3, close=2.01e-5))
    low, high = found.ranges["f"]
    width = 3.0 * 2e-7  # three times the spread
    assert low == pytest.approx(1.98e-5 - WIDTHS * width, rel=1e-6) and high == pytest.approx(
        2.04e-5 + WIDTHS * width, rel=1e-6
    )


def test_a_measure_that_scatters_over_the_steps_has_a_wider_range():
    """A peak between two steps follows a number as a saw does, and jumps
    as high as it scatters over the steps, which 1 % to both sides divide by 0.02. On a line there are none.
    """
    smooth, rough = [1.0, 1.1, 1.2], [1.0, 1.1 + 0.01, 1.2]
    ranges = []
    for own in (smooth, rough):
        ends = ([one + sign * change for one, change in zip(own, (0.02, 0.022, 0.021), strict=True)]
                for sign in (1.0, -1.0))  # fmt: skip
        changes = dataclasses.replace(changed(own, *ends, close=2.1), steps=(1.0, 2.0, 3.0))
        found = judged([2.0, 2.2, 2.1], changes)
        assert found.kinds["f"] == "derivative"
        ranges.append(found.ranges["f"])
    left = 0.01 * math.sqrt(3.0)  # 2/3 and 1/3 of the kink to both sides of the line, one degree of freedom
    assert np.subtract(ranges[0], ranges[1]) == pytest.approx([left / 0.02, -left / 0.02], rel=1e-9)


def test_a_derivative_that_changes_contradict_gives_way_to_them():
    """A tangent that grew without end; a kink, of which each side is known."""
    found = judged(
        [-7.65e8, -7.6e8, -8e8], changed([1.0] * 3, [0.9987, 0.99871, 0.9986], [1.0013, 1.00132, 1.0013])
    )
    assert found.kinds["f"] == "change"
    assert (
        found.changes["f"] == pytest.approx(-0.13)
        and found.change_ranges["f"][0] < -0.132 < -0.128 < found.change_ranges["f"][1]
    )
    found = judged([1.25, 1.25, 1.25], changed([1.0] * 3, [1.0125] * 3, [0.994] * 3))
    assert found.kinds["f"] == "change" and found.change_ranges["f"] == pytest.approx((0.6, 1.25))


def test_where_changes_of_a_tenth_of_a_per_cent_contradict_a_derivative_it_does_not_hold():
    """A step of the measure beside the model: 1 % hides it, a tenth shows it."""
    assert judged([2.0] * 3, changed([1.0] * 3, [1.02] * 3, [0.98] * 3)).kinds["f"] == "derivative"
    assert judged([2.0] * 3, changed([1.0] * 3, [1.02] * 3, [0.98] * 3, close=5.0)).kinds["f"] == "change"


# The largest torque (N m) of a crank-rocker with two loose pins by the length (m) of its crank, at four step
# sizes: changes of the measure over those of the number, to both sides.
JUMP = {
    0.01: [-318.0, -312.0, -308.0, -301.0], -0.01: [941.0, 946.0, 952.0, 948.0],
    0.001: [1018.0, 1029.0, 983.0, 974.0], -0.001: [4325.0, 4121.0, 38990.0, 38937.0],
}  # fmt: skip


def of_quotients(quotients: dict[float, list[float]]) -> FiniteChanges:
    """Changes of a measure "f", 0 at "p" of 1, with these ``quotients`` by the share of the change."""
    changed = {("p", share): [{"f": share * one} for one in some] for share, some in quotients.items()}
    return FiniteChanges([{"f": 0.0}] * 4, changed)


def test_a_derivative_does_not_hold_where_the_mean_of_both_directions_hides_a_jump():
    """The mean of +1 % and -1 % is 317 N m/m, inside the range of the derivatives. The torque falls with +1 %
    and with -1 %, and jumps within -0.1 %.
    """
    slopes = [813.0, 1053.0, 983.0, 872.0, 707.0]
    assert judged(slopes, of_quotients(JUMP)).kinds["f"] == "unknown"
    smooth = {0.01: JUMP[0.01], -0.01: JUMP[-0.01], 0.001: [254.0] * 4, -0.001: [380.0] * 4}
    assert judged([317.0, 318.0, 316.0], of_quotients(smooth)).kinds["f"] == "derivative"
    kink = smooth | {0.001: JUMP[0.01], -0.001: JUMP[-0.01]}
    assert judged([317.0, 318.0, 316.0], of_quotients(kink)).kinds["f"] == "unknown"


# Of the largest force (1122 N) in a slider-crank by the mass of its block: changes over those of the number.
# The model lies where a landing just happens: 994 N with 0.1 % more or less, 1203 N with 1 % more.
RESONANCE = {
    0.01: [8137.0, 8536.0, 8907.0, 9494.0], -0.01: [12928.0, 12647.0, 12373.0, 11946.0],
    0.001: [-126078.0, -123373.0, -120682.0, -116495.0], -0.001: [127938.0, 125109.0, 122320.0, 118057.0],
}  # fmt: skip


def test_a_change_of_a_tenth_of_a_per_cent_against_that_of_1_per_cent_leaves_nothing_known():
    """Against it, as in the resonance, or further than it; not if it is only another part of the change."""
    slopes = [-131000.0, -130800.0, -135000.0]
    assert judged(slopes, of_quotients(RESONANCE)).kinds["f"] == "unknown"
    kinds = {9000.0: "change", 50000.0: "change", 300000.0: "unknown", -30000.0: "unknown"}
    for close, kind in kinds.items():
        sides = {0.01: RESONANCE[0.01], -0.01: RESONANCE[-0.01], 0.001: [close] * 4, -0.001: [12000.0] * 4}
        assert judged(slopes, of_quotients(sides)).kinds["f"] == kind


@pytest.mark.parametrize(
    ("slopes", "up", "down"),
    [
        ([3.0, 3.0, 3.0], [1.01] * 3, [1.01] * 3),  # the least of a measure: it grows both ways
        ([3.0, 3.0, 3.0], [1.01, 1.02, 0.99], [0.99] * 3),  # step sizes do not agree on the sign
        ([30.0, 30.0, 30.0], [1.01, 1.018, 1.015], [0.99] * 3),  # nor on the order of magnitude
        ([1.0, -1.0, 2.0], [1.01, 1.02, 0.99], [0.99] * 3),  # nor do derivatives
    ],
)
def test_where_neither_is_known_it_is_unknown(slopes, up, down):
    assert judged(slopes, changed([1.0] * 3, up, down)).kinds["f"] == "unknown"


def test_without_finite_changes_nothing_is_known():
    none = FiniteChanges([{"f": 1.0}], {})
    found = judged([2.0], none)
    assert found.kinds["f"] == "unknown" and "f" not in found.changes
    assert not agreement([2.0], [], [], 0.0)[1]


def test_one_side_is_enough_where_the_number_may_go_no_other_way():
    changes = changed([1.0] * 3, [1.02] * 3, [0.98] * 3)
    one = FiniteChanges(
        changes.unchanged, {key: value for key, value in changes.changed.items() if key[1] > 0.0}
    )
    assert judged([2.0] * 3, one).kinds["f"] == "derivative"


def test_two_step_sizes_give_no_range():
    """Of a run with few steps, or one whose coarser steps diverge."""
    assert judged([2.0] * 2, changed([1.0] * 2, [1.02] * 2, [0.98] * 2)).kinds["f"] == "unknown"
    assert judged([2.0] * 3, changed([1.0] * 2, [1.02] * 2, [0.98] * 2)).kinds["f"] == "unknown"


@pytest.mark.parametrize(
    "name", ["four_bar_case_c", "slider_crank", "slider_crank_loose_guide", "double_pendulum"]
)
def test_another_step_size_is_that_of_a_mechanism_assembled_with_it(name):
    """To the bit: state, tables, topology. Also of a neighbour."""
    length = {"duration": 0.3} if name == "double_pendulum" else {"turns": 1.0}
    mechanism = vfife.load(f"examples/{name}.toml")
    base = assemble(mechanism, **length)
    sizes = step_sizes(base)
    assert len(sizes) == 4 and sizes[0].steps == base.choice.steps
    ratios = sorted(max(one.steps for one in sizes) / one.steps for one in sizes)
    assert ratios == pytest.approx([1.0, 1.4, 1.7, 2.0], rel=0.04)
    for size in sizes:
        found = size.of(base)
        again = with_same_steps(mechanism, found)
        assert found.state.tobytes() == again.state.tobytes() and found.topology == again.topology
        assert (found.choice.steps, found.choice.step) == (
            again.choice.steps,
            pytest.approx(again.choice.step, rel=1e-12),
        )
        assert found.choice.step * found.choice.steps == pytest.approx(
            base.choice.step * base.choice.steps, rel=1e-12
        )


def test_a_step_near_its_limit_is_compared_with_finer_ones():
    """Twice the step would not be stable: half of it is the finest then."""
    base = assemble(vfife.load("examples/four_bar_case_c.toml"), turns=0.1)
    near = assemble(vfife.load("examples/four_bar_case_c.toml"), 0.85 * base.choice.stable, turns=0.1)
    steps = [one.of(near).choice.step for one in step_sizes(near)]
    assert steps[0] == near.choice.step == max(steps)
    assert min(steps) == pytest.approx(0.5 * steps[0], rel=0.05)


@pytest.mark.system("runs variants alone and in lanes")
@pytest.mark.parametrize(
    "turns", default_cases([2.5, 3.0], lambda turns: turns == 2.5, "the same with whole turns")
)
def test_variants_in_lanes_have_the_measures_of_runs_alone(turns):
    """The last turn begins within a part that a lane hands over, or with one, and has as many outputs."""
    base = assemble(vfife.load("examples/slider_crank_loose_pin.toml"), turns=turns)
    variants = [size.of(base) for size in step_sizes(base)]

    def look(record):
        window = last_turn(record)
        return over_turn(record, window, PEAKS) | {"outputs": float(window.sum())}

    alone = [look(run(one)) for one in variants]
    assert measures_of([(one, recorded_rows(base), look) for one in variants]) == alone
    merged = measures_of([(one, recorded_rows(base), look) for one in variants], merged=True)
    assert [dict(one, outputs=0.0) for one in merged] == [dict(one, outputs=0.0) for one in alone]
    assert all(one["outputs"] < alone[0]["outputs"] for one in merged)


@pytest.mark.parametrize("times", [12.0, 40.0])
def test_a_variant_that_diverges_has_no_measures(times):
    """Numbers that leave their bounds and stay finite, and such that do not."""
    base = assemble(vfife.load("examples/slider_crank_loose_pin.toml"), turns=2.5)
    step = times * base.choice.stable
    broken = assemble(vfife.load("examples/slider_crank_loose_pin.toml"), step, turns=2.5, force_step=True)
    sound = step_sizes(base)[-1].of(base)
    found = measures_of(
        [
            (one, recorded_rows(base), lambda record: {"steps": float(len(record.steps))})
            for one in (sound, broken)
        ]
    )
    assert found[0] is not None and found[1] is None


@pytest.mark.system("runs with a tenth of the step")
def test_ranges_hold_the_truth_of_a_step_ten_times_smaller():
    """A small part of what tests/verification counts: no derivative and no change that is shown without a
    question mark is outside.
    """
    count, wrong = 0, []
    for name, length in (
        ("four_bar_case_b", {"turns": 0.4}),
        ("slider_crank_loose_guide", {"turns": 0.5}),
        ("slider_crank", {"turns": 1.0}),
    ):
        more = outside(vfife.load(f"examples/{name}.toml"), 3, seed=3, **length)
        count, wrong = count + more.shown, [*wrong, *more.wrong]
    assert count >= 20
    assert wrong == []


def test_changes_of_what_play_adds_take_those_of_the_ideal_mechanism():
    """Whole runs with the mass of the coupler 1 % up and down, each with its own reference."""
    mechanism, length = (
        vfife.load("examples/four_bar_case_b.toml"),
        {"turns": 0.4, "step": 4e-6, "companions": 0},
    )
    found = vfife.sensitivity(mechanism, ["C.force.lip"], ["body.coupler.mass"], **length)
    mass, name = mechanism.bodies["coupler"].mass, "C.force.lip"
    up, down = (
        vfife.simulate(
            vfife.load_model(
                "examples/four_bar_case_b.toml", set=[("body.coupler.mass", (1.0 + sign * 0.01) * mass)]
            ),
            **length,
        )
        for sign in (1.0, -1.0)
    )
    change = 0.5 * (up.measures[name] - down.measures[name]) / found.measures[name] * 100.0
    assert found.change(name, "body.coupler.mass") == pytest.approx(change, rel=1e-6)


def test_a_derivative_that_does_not_hold_warns() -> None:
    kinds: list[Any] = ["derivative", "change", "unknown"]
    numbers = [Derivative(kind, 1.0, {"f": 2.0}, {"f": (1.0, 3.0)}, kinds={"f": kind}) for kind in kinds]
    found = Sensitivity("m", {"f": 4.0}, numbers)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert found.derivative("f", "derivative") == 2.0 and found.elasticity("f", "unknown") == 0.5
    with pytest.warns(UserWarning, match="nothing is known"):
        assert found.derivative("f", "unknown") == 2.0
    with pytest.warns(UserWarning, match="only the change for one per cent is known"):
        found.derivative("f", "change")


@pytest.mark.system("displaced runs of a chaotic motion")
def test_a_chaotic_motion_shows_no_derivative_that_its_changes_contradict():
    """Tangents of this run come to -443 % by 1 % of the restitution, of one sign in both displaced runs,
    and were shown as they were.
    """
    found = vfife.sensitivity(
        vfife.load("examples/slider_crank_loose_guide.toml"),
        ["O.force.max"],
        ["joint.guide.contact.restitution"],
        turns=1,
    )
    assert abs(found.elasticity("O.force.max", "joint.guide.contact.restitution")) > 100.0
    assert not found.known("O.force.max", "joint.guide.contact.restitution")
    (row,) = found.rows()
    assert row["meaningless"] and row["kind"] in ("change", "unknown") and abs(row["change"]) < 50.0


def test_a_pattern_search_finds_the_least_within_limits():
    """A kinked valley whose least lies outside of the limit: on its edge."""

    def rank(points):
        return [(max(0.0, x + y - 1.0), abs(x - 0.9) + 2.0 * abs(y - 0.5)) for x, y in points]

    found = pattern_search(np.array([0.2, 0.1]), rank)
    assert found == pytest.approx([0.5, 0.5], abs=3e-3)
