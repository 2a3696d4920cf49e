"""Derivatives of measures through a run: against dimensional analysis, closed forms, and differences of whole
runs.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

import mechanisms
import vfife
from differences import compared
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError
from vfife.kernels.polynomial import polynomial
from vfife.measures.catalogue import over_turn
from vfife.measures.turns import last_turn
from vfife.modelfile import dump, loads
from vfife.modelfile.parameter import Parameter, holds, numbers
from vfife.report.sensitivity import sensitivity as sensitivity_document
from vfife.report.terminal import as_text
from vfife.results.derivatives import Derivative, Sensitivity
from vfife.solvers.tangents import changes, displaced, tangents
from vfife.solvers.transient import run
from vfife.studies.methods.derivatives import floors, rounding, sensitivity, silent_moments
from vfife.studies.methods.finite_difference import NEIGHBOUR_SHARE, Variants, with_same_steps

EXAMPLES = "examples"
# What the number at the end of a path is measured in: powers of mass, length and time.
DIMENSIONS = {
    "mass": (1, 0, 0), "length": (0, 1, 0), "clearance": (0, 1, 0), "bearing_radius": (0, 1, 0),
    "axial_length": (0, 1, 0), "0": (0, 1, 0),
    "1": (0, 1, 0), "impact_speed_floor": (0, 1, -1), "v0": (0, 1, -1), "v1": (0, 1, -1), "speed": (0, 0, -1),
    "stiffness": (1, -0.5, -2),
    "restitution": (0, 0, 0), "coefficient": (0, 0, 0), "angle": (0, 0, 0), "area": (0, 2, 0),
    "second_moment": (0, 4, 0), "height": (0, 1, 0),
    "center_at": (0, 0, 0), "youngs_modulus": (1, -1, -2), "inertia": (1, 2, 0), "density": (1, -3, 0),
    "poissons_ratio": (0, 0, 0),
}  # fmt: skip
FORCE, TORQUE, ACCELERATION = (1, 1, -2), (1, 2, -2), (0, 0, -2)


def weighed(found, measure: str) -> tuple[float, float, float]:
    """Sums of elasticities, weighed with the powers of mass, length and time that numbers are measured in."""
    sums = [0.0, 0.0, 0.0]
    for path, elastic in found.elasticities(measure).items():
        powers = (0, 1, -2) if path.startswith("gravity") else DIMENSIONS[path.rpartition(".")[2]]
        sums = [one + power * elastic for one, power in zip(sums, powers, strict=True)]
    return tuple(sums)


@pytest.fixture(scope="module")
def case_b():
    """One loose joint, five impacts a turn; four tenths of a turn."""
    of = ["*.force.max", "*.torque.max", "*acceleration.max"]
    return sensitivity(vfife.load(f"{EXAMPLES}/four_bar_case_b.toml"), of, turns=0.4, step=4e-6, companions=0)


@pytest.mark.system("compiles tangents of scaled models")
def test_derivatives_obey_dimensional_analysis(case_b):
    """Whatever the unit of mass, length or time, physics are the same: through contacts, hysteresis and
    friction (Buckingham's theorem).
    """
    found = case_b
    assert weighed(found, "C.force.max") == pytest.approx(FORCE, abs=2e-5)
    assert weighed(found, "A.force.max") == pytest.approx(FORCE, abs=2e-5)
    assert weighed(found, "crank.torque.max") == pytest.approx(TORQUE, abs=2e-5)
    assert weighed(found, "follower.angular_acceleration.max") == pytest.approx(ACCELERATION, abs=2e-5)
    assert abs(found.elasticity("C.force.max", "joint.C.contact.restitution")) > 0.01


def test_derivatives_are_differences_of_whole_runs(case_b):
    """Central differences of the same steps, so close that no onset falls into another step."""
    mechanism = vfife.load(f"{EXAMPLES}/four_bar_case_b.toml")
    text, base = (
        dump(mechanism),
        vfife.simulate(mechanism, turns=0.4, step=4e-6, reference=False, companions=0).record.assembly,
    )
    for path in (
        "joint.C.clearance",
        "joint.C.contact.stiffness",
        "joint.C.friction.coefficient",
        "body.coupler.mass",
    ):
        value = numbers(mechanism)[path]
        up, down = (
            run(Variants(text, base).with_number(path, value, (1.0 + sign * 1e-5) * value))
            for sign in (1.0, -1.0)
        )
        for measure in ("C.force.max", "follower.angular_acceleration.max"):
            both = [over_turn(record, last_turn(record))[measure] for record in (up, down)]
            difference = (both[0] - both[1]) / 2e-5 / case_b.measures[measure]
            # Rounding grows to 3e-10 of an acceleration by its fifth impact, and the difference is divided by
            # 2e-5: it scatters by 1.5e-5.
            assert case_b.elasticity(measure, path) == pytest.approx(difference, rel=1e-4, abs=3e-5)


@pytest.mark.parametrize(
    "name, to, length",
    [
        ("four_bar_case_c", ("joint.*.clearance", "body.coupler.*"), {"turns": 0.02, "step": 1e-6}),
        ("slider_crank_loose_pin", ("joint.pin.*", "body.rod.*"), {"turns": 0.1}),
        ("four_bar", ("joint.C.*", "body.coupler.*"), {"turns": 0.01}),
    ],
)
def test_where_differences_are_known_derivatives_are_these(name, to, length):
    """Onsets, reversals of friction, hysteresis, elements that bend; all models and numbers are in
    tests/verification.
    """
    found = compared(vfife.load(f"{EXAMPLES}/{name}.toml"), to, **length)
    sure = found.unknown < 1e-4
    assert sure.mean() > 0.5
    assert (found.apart[sure] <= 1e-4 + 2.0 * found.unknown[sure]).all()


@pytest.mark.system("compiles two tangents")
def test_what_play_adds_to_the_ideal_mechanism_takes_the_derivatives_of_both():
    """(max - ideal) / ideal: the ideal force has none by the clearance, and goes with the mass as that of the
    ideal mechanism by itself.
    """
    mechanism, to = vfife.load(f"{EXAMPLES}/four_bar_case_b.toml"), ["joint.C.clearance", "body.coupler.mass"]
    found = sensitivity(mechanism, ["C.force.max", "C.force.lip"], to, turns=0.4, step=4e-6, companions=0)
    alone = sensitivity(mechanism.ideal(), ["C.force.max"], to[1:], turns=1, companions=0)
    ideal = found.measures["C.force.max"] / (1.0 + found.measures["C.force.lip"] / 100.0)
    for path in to:
        own = (
            alone.derivative("C.force.max", path) * (1.0 + found.measures["C.force.lip"] / 100.0)
            if path == to[1]
            else 0.0
        )
        expected = 100.0 * (found.derivative("C.force.max", path) - own) / ideal
        assert found.derivative("C.force.lip", path) == pytest.approx(expected, rel=1e-5)
    assert alone.measures["C.force.max"] == pytest.approx(ideal, rel=1e-9)


def test_a_series_has_its_jacobian():
    """The force over time of a journal that meets its bearing, by two numbers: differences of whole runs."""
    mechanism = vfife.load(f"{EXAMPLES}/journal_in_bearing.toml")
    text, assembly = dump(mechanism), assemble(mechanism, 1e-6, duration=3e-4, force_step=True)
    chosen = {
        path: value
        for path, value in numbers(mechanism).items()
        if path in ("joint.O.contact.restitution", "body.journal.mass")
    }

    def force(record):
        return record.block("contact_normal_force")[:, 0]

    near = [Variants(text, assembly).neighbours(path, value) for path, value in chosen.items()]
    sides = [[force(record) for record in pair] for (pair,) in tangents(assembly, near)]
    assert 0.5 * (sides[0][0] + sides[0][1]) == pytest.approx(force(run(assembly)), rel=1e-9)
    found = np.stack(
        [(up - down) / one.distance for (up, down), one in zip(sides, near, strict=True)], axis=1
    )
    for k, (path, value) in enumerate(chosen.items()):
        up, down = (
            force(run(Variants(text, assembly).with_number(path, value, (1.0 + sign * 1e-5) * value)))
            for sign in (1.0, -1.0)
        )
        assert found[:, k] == pytest.approx(
            (up - down) / (2e-5 * value), rel=1e-5, abs=1e-5 * np.abs(found[:, k]).max()
        )


def test_displaced_runs_stand_at_other_places_of_their_small_steps_too():
    """Runs displaced by whole parts of a step would all have an onset at one place in its part."""
    for count in range(1, 9):
        shares = np.array(displaced(count, 8))
        assert shares[0] == 0.0 and shares.max() < 1.0
        assert len(set(np.round(shares, 9))) == len(set(np.round(8.0 * shares % 1.0, 9))) == count


@pytest.mark.parametrize("name", ["four_bar_case_c", "elastic_pendulum", "slider_crank_loose_guide"])
def test_a_number_replaced_in_the_nouns_is_one_that_was_read(name):
    mechanism = vfife.load(f"{EXAMPLES}/{name}.toml")
    text, seen = dump(mechanism), 0
    for path, value in numbers(mechanism).items():
        if value and holds(mechanism, path, value) and seen < 24:
            seen += 1
            found = Parameter(mechanism, path).set(1.01 * value)
            assert replace(found, source=None) == replace(
                loads(text, set=[(path, 1.01 * value)]), source=None
            )
    assert seen > 4
    assert not holds(mechanism, "gravity.0", 77.0)


def test_an_ideal_slider_crank_scales_as_its_laws_say():
    """Without weight all forces go with the square of the speed, and the pin's with the mass of the block
    alone, which nothing else accelerates.
    """
    found = sensitivity(
        vfife.load(f"{EXAMPLES}/slider_crank.toml"), ["*.force.max", "crank.torque.max"], turns=1
    )
    for measure in found.measures:
        assert found.elasticity(measure, "driver.crank.speed") == pytest.approx(2.0, abs=1e-7)
        assert weighed(found, measure) == pytest.approx(TORQUE if "torque" in measure else FORCE, abs=2e-5)
    assert found.elasticity("pin.force.max", "body.block.mass") == pytest.approx(1.0, abs=2e-5)
    assert not any(one.displaced for one in found.derivatives)


@pytest.mark.system("compiles tangents of scaled models")
def test_elastic_links_obey_dimensional_analysis():
    """A pendulum that bends: its material, section and weight, from a start at which it is straight."""
    mechanism = vfife.load_model(f"{EXAMPLES}/elastic_pendulum.toml", set=[("body.rod.elements", 4)])
    found = sensitivity(mechanism, ["*.force.max"], duration=0.2, companions=0)
    (measure,) = found.measures
    assert weighed(found, measure)[:2] == pytest.approx(
        FORCE[:2], abs=1e-5
    )  # how long it is looked at has a time, too
    assert abs(found.elasticity(measure, "material.rubber.youngs_modulus")) > 1e-4


@pytest.mark.system("compiles a tangent of each kind of driver")
def test_drives_of_every_kind_carry_their_derivatives():
    """Ramps, harmonics, tables over time and angle: central differences of whole runs, in which kinks of
    tables may fall into other steps.
    """
    mechanism = mechanisms.every_drive()
    found = sensitivity(
        mechanism,
        ["*.torque.max", "*.force.max"],
        ["driver.hung.*", "driver.timed.*", "driver.slowed.*", "load.across.*"],
        duration=4e-3,
        step=4e-6,
        companions=0,
    )
    text = dump(mechanism)
    base = vfife.simulate(mechanism, duration=4e-3, step=4e-6, reference=False, companions=0).record.assembly
    seen = 0
    for one in found.derivatives:
        up, down = (
            run(
                Variants(text, base).with_number(
                    one.path, one.value, one.value + sign * 1e-5 * abs(one.value)
                )
            )
            for sign in (1.0, -1.0)
        )
        for measure, size in found.measures.items():
            both = [over_turn(record, last_turn(record)).get(measure, 0.0) for record in (up, down)]
            difference = (both[0] - both[1]) / (2e-5 * abs(one.value))
            seen += abs(one.value * difference) > 1e-3 * size
            assert one.values[measure] == pytest.approx(
                difference, rel=1e-5, abs=3e-4 * size / abs(one.value)
            )
    assert seen > 4


def test_tables_whose_pieces_begin_later_change_as_their_values_do():
    """The derivative of a table at a fixed time, by the time of one of its points: differences of what the
    two tables say there.
    """
    mechanism = mechanisms.every_drive()
    text, assembly = dump(mechanism), assemble(mechanism, 4e-6, duration=4e-3, force_step=True)
    path, value, seen = "driver.timed.times.1", 0.002, 0
    near = Variants(text, assembly).neighbours(path, value)
    changed = changes(assembly, near)
    for start in assembly.topology.function_start:
        for time in (0.0005, 0.0019, 0.0021, 0.0037, 0.0046):
            up, down = (polynomial(one.tables, start, time)[0] for one in (near.up, near.down))
            found = polynomial(changed, start, time)[0]
            assert found == pytest.approx((up - down) / near.distance, rel=1e-6, abs=1e-6)
            seen += abs(found) > 1.0
    assert seen >= 4


@pytest.mark.parametrize("patterns", [{"of": []}, {"to": ()}])
def test_no_patterns_at_all_are_a_fault(patterns):
    with pytest.raises(ModelError, match="it is empty"):
        vfife.sensitivity(vfife.load("examples/slider_crank.toml"), **patterns, turns=1)


def test_patterns_that_fit_nothing_are_told_together():
    mechanism = replace_name(vfife.load(f"{EXAMPLES}/slider_crank.toml"))
    with pytest.raises(ModelError, match=r"'joint\.pinn\.\*'") as caught:
        sensitivity(mechanism, to=["joint.pinn.*", "body.crank.mas"])
    assert "body.crank.mass" in str(caught.value)


def test_a_measure_that_no_run_has_is_told_before_there_is_one(monkeypatch):
    monkeypatch.setattr(
        "vfife.studies.methods.derivatives.run_prepared",
        lambda *given, **more: pytest.fail("a run was begun"),
    )
    for wrong in ("pin.forc.max", "*.forc.max", "pinn.force.maxi"):
        with pytest.raises(ModelError, match=re.escape(wrong)):
            sensitivity(vfife.load(f"{EXAMPLES}/slider_crank.toml"), [wrong])


def test_a_run_with_a_duration_has_no_derivatives_by_what_changes_its_turns():
    """The last turn before a fixed time is another part of the motion at another speed."""
    case_b = vfife.load(f"{EXAMPLES}/four_bar_case_b.toml")
    paths = ["driver.crank.speed", "joint.C.clearance"]
    found = sensitivity(case_b, ["C.force.max"], paths, duration=0.012, companions=0)
    assert "--turns" in found.refused["driver.crank.speed"]
    assert [one.path for one in found.derivatives] == ["joint.C.clearance"]
    case_b.settings = replace(case_b.settings, turns=None, duration=0.012)
    with pytest.raises(ModelError, match="driver.crank.speed.*turns"):
        sensitivity(case_b, ["C.force.max"], ["driver.crank.speed"])
    by_turns = sensitivity(case_b, ["C.force.max"], paths, turns=0.1, companions=0)
    assert not by_turns.refused and {one.path for one in by_turns.derivatives} == set(paths)


def replace_name(mechanism: vfife.Mechanism) -> vfife.Mechanism:
    """A shorter run."""
    mechanism.settings = replace(mechanism.settings, turns=1.0)
    return mechanism


def test_what_rounding_leaves_stands_beside_the_largest_of_its_unit():
    """Moments beside torques, and the influence of an acceleration beside that; what changes by more, or has
    no unit, is none.
    """
    found = {"guide.moment.max": 2.8e-45, "crank.torque.max": 5.0, "a.torque.mean": 1e-12,
        "b.torque.mean": 1e-12, "pin.impacts": 0.0,
             "block.angular_acceleration.max": 2.8e-41, "rod.angular_acceleration.max": 4e3,
             "block.angular_acceleration.lip": 30.0}  # fmt: skip
    nothing = {
        "guide.moment.max",
        "b.torque.mean",
        "block.angular_acceleration.max",
        "block.angular_acceleration.lip",
    }
    assert rounding(found, {"a.torque.mean": 0.1}) == nothing
    assert rounding({"guide.moment.max": 2.8e-45}) == frozenset()
    assert rounding({"guide.1.penetration.max": 1e-5, "guide.2.penetration.max": 0.0}) == {
        "guide.2.penetration.max"
    }


def test_what_rounding_leaves_stands_beside_what_the_largest_force_may_turn():
    """A moment that is alone in its unit, and what turns nowhere: 1e-45 of one machine and the exact 0 of
    another are the same.
    """
    assembly = assemble(vfife.load(f"{EXAMPLES}/slider_crank.toml"), turns=1)
    assert silent_moments(assembly, {}) == {"guide.moment.max": 0.0}
    assert silent_moments(assembly, {"guide.moment.max": 1e-45}) == {}
    scales = floors(assembly, {"pin.force.max": 300.0})
    assert scales["N m"] == pytest.approx(300.0 * 0.12) and scales["rad/s^2"] > 1e4
    for value in (0.0, 1e-45, 1e-9):
        assert rounding({"guide.moment.max": value}, {}, scales) == {"guide.moment.max"}
    assert rounding({"guide.moment.max": 1e-3}, {}, scales) == frozenset()


def test_zeros_and_what_nothing_depends_on_are_left_out(case_b):
    assert case_b.refused["ground.A.0"].startswith("zero")
    assert "joint.C.axial_length" not in [one.path for one in case_b.derivatives]


def test_a_table_has_every_measure_and_number(case_b, tmp_path):
    case_b.write_csv(tmp_path / "all.csv")
    lines = (tmp_path / "all.csv").read_text().splitlines()
    assert len(lines) == 1 + len(case_b.measures) * len(case_b.derivatives)
    rows = [dict(zip(lines[0].split(","), line.split(","), strict=True)) for line in lines[1:]]
    for measure in case_b.measures:
        own = [one for one in rows if one["measure"] == measure]
        assert [one["number"] for one in own] == [path for path, _ in case_b.ranked(measure)]
        first = own[0]
        assert float(first["elasticity"]) == case_b.elasticity(measure, first["number"])


def test_what_is_known_stands_before_what_is_not(case_b):
    """The largest known effect first; unknown ones last, without a number, and marked in tables."""
    unknown = 0
    for measure in case_b.measures:
        effects = {one.path: one for one in case_b.effects(measure)}
        ranked = case_b.ranked(measure)
        known = [value for path, value in ranked if effects[path].kind != "unknown"]
        assert ranked[: len(known)] == [pair for pair in ranked if effects[pair[0]].kind != "unknown"]
        assert known == sorted(known, key=lambda value: -abs(value)) and not np.isnan(known).any()
        assert all(np.isnan(value) for _, value in ranked[len(known) :])
        rows = [one for one in case_b.rows() if one["measure"] == measure]
        assert all(one["meaningless"] for one in rows[len(known) :])
        unknown += len(ranked) - len(known)
    assert unknown > 0, "or this test says nothing"


def test_where_a_search_for_positions_begins_is_no_number_of_the_model():
    """The block of a slider-crank is placed by its joints; that of a point that hangs on a spring is not."""
    found = sensitivity(vfife.load(f"{EXAMPLES}/slider_crank.toml"), ["pin.force.max"], ["body.*"], turns=1)
    assert "starting guess" in found.refused["body.block.position.0"]
    assert "body.block.position.0" not in [one.path for one in found.derivatives]
    m = vfife.Mechanism("hung", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("weight", mass=1.0, inertia=1e-3, position=(0.3, 0.2), pins={"pin": (0.0, 0.0)})
    m.spring("s", "ground.O", "weight.pin", stiffness=100.0, free_length=0.1)
    free = sensitivity(m, ["*"], ["body.*"], duration=0.5)
    assert not any("guess" in why for why in free.refused.values())


@pytest.mark.parametrize("name", ["four_bar_case_c", "scotch_yoke", "slider_crank_loose_guide"])
def test_neighbours_are_what_their_texts_give(name):
    """A number changed in the objects of the mechanism, against the text read with it: start, tables, steps,
    to the bit.
    """
    mechanism = vfife.load_model(f"{EXAMPLES}/{name}.toml")
    text, assembly = dump(mechanism), assemble(mechanism, turns=1)
    known = [
        (path, value)
        for path, value in numbers(mechanism).items()
        if value and not path.startswith("material")
    ]
    for path, value in known[::4]:
        change = path, value * (1.0 + NEIGHBOUR_SHARE)
        one, alone = (
            Variants(text, assembly).with_number(path, value, change[1]),
            with_same_steps(loads(text, set=[change]), assembly),
        )
        assert (
            one.state.tobytes() == alone.state.tobytes() and one.tables.tobytes() == alone.tables.tobytes()
        ), change
        assert (one.topology, one.choice.steps, one.choice.outputs_every) == (
            alone.topology,
            alone.choice.steps,
            alone.choice.outputs_every,
        )
        assert one.choice.step == alone.choice.step


def test_numbers_of_unknown_influence_stand_last_by_the_end_of_their_range() -> None:
    """The value of one whose sign is not known means nothing, however large it is."""
    shares = {
        "alpha": (3.0, 2.0, 4.0),
        "bravo": (90.0, -1.0, 95.0),
        "charlie": (0.1, -200.0, 1.0),
        "delta": (-5.0, -6.0, -4.0),
    }
    derivatives = [
        Derivative(path, 1.0, {"F": value}, {"F": (low, high)}) for path, (value, low, high) in shares.items()
    ]
    result = Sensitivity("machine", {"F": 100.0}, derivatives)
    assert [effect.path for effect in result.effects("F")] == ["delta", "alpha", "charlie", "bravo"]
    text = " ".join(as_text(sensitivity_document(result, top=1)).split())
    assert "delta" in text and "charlie" in text and "alpha" not in text and "bravo" not in text
    assert "These rows stand last" in text
