"""Derivatives of measures through a run: against dimensional analysis, closed forms, and differences of whole runs."""

import re
from dataclasses import replace

import pytest

import mechanisms
import vfife
from vfife.analysis.measures import last_turn, over_turn
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError
from vfife.kernels.polynomial import polynomial
from vfife.modelfile import dump
from vfife.modelfile.numbers import numbers
from vfife.solvers.tangents import changes
from vfife.solvers.transient import run
from vfife.study.derivatives import sensitivity
from vfife.study.nearby import beside, placed

EXAMPLES = "examples"
# What the number at the end of a path is measured in: powers of mass, length and time.
DIMENSIONS = {
    "mass": (1, 0, 0), "length": (0, 1, 0), "clearance": (0, 1, 0), "bearing_radius": (0, 1, 0), "axial_length": (0, 1, 0), "0": (0, 1, 0),
    "1": (0, 1, 0), "impact_speed_floor": (0, 1, -1), "v0": (0, 1, -1), "v1": (0, 1, -1), "speed": (0, 0, -1), "stiffness": (1, -0.5, -2),
    "restitution": (0, 0, 0), "coefficient": (0, 0, 0), "angle": (0, 0, 0), "area": (0, 2, 0), "second_moment": (0, 4, 0), "height": (0, 1, 0),
    "center_at": (0, 0, 0), "youngs_modulus": (1, -1, -2), "inertia": (1, 2, 0), "density": (1, -3, 0), "poissons_ratio": (0, 0, 0),
}  # fmt: skip
FORCE, TORQUE, ACCELERATION = (1, 1, -2), (1, 2, -2), (0, 0, -2)


def weighed(found, measure: str) -> tuple[float, float, float]:
    """Sums of elasticities, weighed with the powers of mass, length and time that numbers are measured in."""
    sums = [0.0, 0.0, 0.0]
    for path, elastic in found.ranked(measure):
        powers = (0, 1, -2) if path.startswith("gravity") else DIMENSIONS[path.rpartition(".")[2]]
        sums = [one + power * elastic for one, power in zip(sums, powers, strict=True)]
    return tuple(sums)


@pytest.fixture(scope="module")
def case_b():
    """One loose joint, five impacts a turn; four tenths of a turn."""
    of = ["*.force.max", "*.torque.max", "*acceleration.max"]
    return sensitivity(vfife.load(f"{EXAMPLES}/four_bar_case_b.toml"), of, turns=0.4, step=4e-6, companions=0)


def test_derivatives_obey_dimensional_analysis(case_b):
    """Whatever the unit of mass, length or time, physics are the same: through contacts, hysteresis and friction (Buckingham's theorem)."""
    found = case_b
    assert weighed(found, "C.force.max") == pytest.approx(FORCE, abs=2e-5)
    assert weighed(found, "A.force.max") == pytest.approx(FORCE, abs=2e-5)
    assert weighed(found, "crank.torque.max") == pytest.approx(TORQUE, abs=2e-5)
    assert weighed(found, "follower.angular_acceleration.max") == pytest.approx(ACCELERATION, abs=2e-5)
    assert abs(found.elasticity("C.force.max", "joint.C.contact.restitution")) > 0.01


def test_derivatives_are_differences_of_whole_runs(case_b):
    """Central differences of the same steps, so close that no onset falls into another step."""
    mechanism = vfife.load(f"{EXAMPLES}/four_bar_case_b.toml")
    text, base = dump(mechanism), vfife.simulate(mechanism, turns=0.4, step=4e-6, reference=False, companions=0).record.assembly
    for path in ("joint.C.clearance", "joint.C.contact.stiffness", "joint.C.friction.coefficient", "body.coupler.mass"):
        value = dict(numbers(text))[path]
        up, down = (run(placed(text, path, value, (1.0 + sign * 1e-5) * value, base)) for sign in (1.0, -1.0))
        for measure in ("C.force.max", "follower.angular_acceleration.max"):
            both = [over_turn(record, last_turn(record))[measure] for record in (up, down)]
            difference = (both[0] - both[1]) / 2e-5 / case_b.measures[measure]
            assert case_b.derivative(measure, path) * value / case_b.measures[measure] == pytest.approx(difference, rel=1e-4)


def test_an_ideal_slider_crank_scales_as_its_laws_say():
    """Without weight all forces go with the square of the speed, and the pin's with the mass of the block alone, which nothing else accelerates."""
    found = sensitivity(vfife.load(f"{EXAMPLES}/slider_crank.toml"), ["*.force.max", "crank.torque.max"], turns=1)
    for measure in found.measures:
        assert found.elasticity(measure, "driver.crank.speed") == pytest.approx(2.0, abs=1e-7)
        assert weighed(found, measure) == pytest.approx(TORQUE if "torque" in measure else FORCE, abs=2e-5)
    assert found.elasticity("pin.force.max", "body.block.mass") == pytest.approx(1.0, abs=2e-5)
    assert not any(one.displaced for one in found.derivatives)


def test_elastic_links_obey_dimensional_analysis():
    """A pendulum that bends: its material, section and weight, from a start at which it is straight."""
    found = sensitivity(vfife.load(f"{EXAMPLES}/elastic_pendulum.toml"), ["*.force.max"], duration=0.2, companions=0)
    (measure,) = found.measures
    assert weighed(found, measure)[:2] == pytest.approx(FORCE[:2], abs=1e-5)  # how long it is looked at has a time, too
    assert abs(found.elasticity(measure, "material.rubber.youngs_modulus")) > 1e-4


def test_drives_of_every_kind_carry_their_derivatives():
    """Ramps, harmonics, tables over time and angle: central differences of whole runs, in which kinks of tables may fall into other steps."""
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
        up, down = (run(placed(text, one.path, one.value, one.value + sign * 1e-5 * abs(one.value), base)) for sign in (1.0, -1.0))
        for measure, size in found.measures.items():
            both = [over_turn(record, last_turn(record)).get(measure, 0.0) for record in (up, down)]
            difference = (both[0] - both[1]) / (2e-5 * abs(one.value))
            seen += abs(one.value * difference) > 1e-3 * size
            assert one.values[measure] == pytest.approx(difference, rel=1e-5, abs=3e-4 * size / abs(one.value))
    assert seen > 5


def test_tables_whose_pieces_begin_later_change_as_their_values_do():
    """The derivative of a table at a fixed time, by the time of one of its points: differences of what the two tables say there."""
    mechanism = mechanisms.every_drive()
    text, assembly = dump(mechanism), assemble(mechanism, 4e-6, duration=4e-3, force_step=True)
    path, value, seen = "driver.timed.times.1", 0.002, 0
    near = beside(text, path, value, assembly)
    changed = changes(assembly, near)
    for start in assembly.topology.function_start:
        for time in (0.0005, 0.0019, 0.0021, 0.0037, 0.0046):
            up, down = (polynomial(one.tables, start, time)[0] for one in (near.up, near.down))
            found = polynomial(changed, start, time)[0]
            assert found == pytest.approx((up - down) / near.apart, rel=1e-6, abs=1e-6)
            seen += abs(found) > 1.0
    assert seen >= 4


def test_patterns_that_fit_nothing_are_told_together():
    mechanism = replace_name(vfife.load(f"{EXAMPLES}/slider_crank.toml"))
    with pytest.raises(ModelError, match=r"'joint\.pinn\.\*'") as caught:
        sensitivity(mechanism, to=["joint.pinn.*", "body.crank.mas"])
    assert "body.crank.mass" in str(caught.value)


def test_a_measure_that_no_run_has_is_told_before_there_is_one(monkeypatch):
    monkeypatch.setattr("vfife.study.derivatives.simulate", lambda *given, **more: pytest.fail("a run was begun"))
    for wrong in ("pin.forc.max", "*.forc.max", "pinn.force.maxi"):
        with pytest.raises(ModelError, match=re.escape(wrong)):
            sensitivity(vfife.load(f"{EXAMPLES}/slider_crank.toml"), [wrong])


def replace_name(mechanism: vfife.Mechanism) -> vfife.Mechanism:
    """A shorter run."""
    mechanism.settings = replace(mechanism.settings, turns=1.0)
    return mechanism


def test_zeros_and_what_nothing_depends_on_are_left_out(case_b):
    assert case_b.refused["ground.A.0"].startswith("zero")
    assert "joint.C.axial_length" not in [one.path for one in case_b.derivatives]


def test_a_table_has_every_measure_and_number(case_b, tmp_path):
    case_b.write_csv(tmp_path / "all.csv")
    lines = (tmp_path / "all.csv").read_text().splitlines()
    assert len(lines) == 1 + len(case_b.measures) * len(case_b.derivatives)
    first = dict(zip(lines[0].split(","), lines[1].split(","), strict=True))
    assert float(first["elasticity"]) == case_b.ranked(first["measure"])[0][1]
