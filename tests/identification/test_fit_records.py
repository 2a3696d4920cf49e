"""Fits of several records: a swing integrated by scipy gives its numbers back, each record from its own
start.
"""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vfife
from vfife import Mechanism
from vfife.errors import ModelError
from vfife.identification import Record
from vfife.identification.fit_plan import load_plan
from vfife.identification.fit_task import plan_fit
from vfife.identification.measurements import Curve, Measured
from vfife.identification.parameters import FitParameter
from vfife.identification.starts import starts_of, with_starts
from vfife.identification.step_uncertainty import confidence_of, without_own
from vfife.kinematics.initial import ideal_motion
from vfife.modelfile import dump
from vfife.modelfile.parameter import with_values

MASS, ARM, INERTIA, DAMPING, DRY = 0.15, 0.15, 1e-4, 3e-4, 2e-4
STARTS = ((0.9, 2.0), (2.2, -3.0))
LOOKED = {
    "body.rod.inertia": (5e-5, 2e-4),
    "spring.bearing.damping": (1e-4, 6e-4),
    "driver.rod.torque.0,-driver.rod.torque.1": (0.0, 5e-4),
}
QUICK = {
    "start": "data", "step": "2 ms", "screened": 1, "starts": 1, "restarts": 0, "derivatives": "differences"
}  # fmt: skip


def pendulum() -> Mechanism:
    """A rod with viscous and dry friction; its angle counts from upright."""
    m = Mechanism("pendulum", gravity=(0.0, -9.81))
    m.settings = vfife.Settings(duration=1.0)
    m.point("O", 0.0, 0.0)
    m.rigid_body("rod", mass=MASS, inertia=8e-5, center=(0.0, ARM), pins={"pivot": (0.0, 0.0)}, angle=3.0)
    m.revolute("O", "ground.O", "rod.pivot")
    m.torsional_spring("bearing", "ground", "rod", damping=2e-4)
    m.torque("rod", value=(1e-4, -1e-4), speeds=(-0.05, 0.05), interpolation="linear")
    return m


def swing(angle: float, rate: float, times: np.ndarray) -> np.ndarray:
    """Its equation of motion, integrated by scipy."""
    inertia = INERTIA + MASS * ARM * ARM

    def rates(_, y):
        dry = DRY * np.clip(y[1] / 0.05, -1.0, 1.0)
        return y[1], (MASS * 9.81 * ARM * math.sin(y[0]) - DAMPING * y[1] - dry) / inertia

    return solve_ivp(rates, (0.0, times[-1]), (angle, rate), t_eval=times, rtol=1e-8, max_step=0.02).y[0]


@pytest.fixture(scope="module")
def records(tmp_path_factory) -> list[Path]:
    folder, noise = tmp_path_factory.mktemp("swings"), np.random.default_rng(4)
    files = []
    for k, (angle, rate) in enumerate(STARTS):
        times = np.arange(0.0, 3.0 + 0.2 * k, 0.01)
        values = swing(angle, rate, times) + 1e-3 * noise.standard_normal(len(times))
        rows = "\n".join(f"{a:.5f},{b:.9g}" for a, b in zip(times, values, strict=True))
        files.append(folder / f"{'ab'[k]}.csv")
        files[-1].write_text(f"time (s),rod.angle (rad)\n{rows}\n")
    return files


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fit") / "a.fit"


@pytest.fixture(scope="module")
def fit(records, place):
    return vfife.fit(pendulum(), records, LOOKED, file=place, **QUICK)


@pytest.mark.slow("a fit of two records")
def test_common_numbers_and_own_starts_come_back(fit):
    for path, truth in zip(LOOKED, (INERTIA, DAMPING, DRY), strict=True):
        one = fit[path]
        assert one.low < truth < one.high and abs(one.value - truth) < 0.25 * truth, path
    assert [one.name for one in fit.records] == ["a", "b"]
    for record, start in zip(fit.records, STARTS, strict=True):
        for one, truth in zip(record.values, start, strict=True):
            assert abs(one.value - truth) < 4.0 * one.error < 0.2, one.name
        assert record.residual < 5e-3
    assert dict(fit.set)["driver.rod.torque.0"] == -dict(fit.set)["driver.rod.torque.1"] > 0.0


def test_the_split_of_two_frictions_is_called_poor(fit):
    assert fit.correlation[2, 1] < -0.8 and fit.splits == [], "both are known to a tenth"
    dry = fit.values[2]
    wide = dataclasses.replace(dry, low=0.5 * dry.value, high=1.5 * dry.value)
    (text,) = dataclasses.replace(fit, values=[*fit.values[:2], wide]).splits
    assert text.startswith("the split between spring.bearing.damping and driver.rod.torque.0")


def test_a_fit_of_records_of_other_lengths_is_read_back_and_written(fit, place, tmp_path):
    again = vfife.identification.load_fit(place)
    assert again.json() == fit.json() and again.set == fit.set
    assert [len(one.places) for one in again.curves] == [300, 320]
    again.write_csv(tmp_path / "curves.csv")
    lines = (tmp_path / "curves.csv").read_text().splitlines()
    assert lines[0].startswith("record,time [s],rod.angle measured [rad]") and len(lines) == 621


def test_a_plan_asks_for_the_same_fit(records):
    folder = records[0].parent
    (folder / "pendulum.toml").write_text(dump(pendulum()))
    bounds = "\n".join(f'"{path}" = [{low}, {high}]' for path, (low, high) in LOOKED.items())
    keys = "\n".join(f"{name} = {value!r}" for name, value in QUICK.items())
    tables = "\n".join(f'[[record]]\ndata = "{one.name}"' for one in records)
    plan = folder / "plan.toml"
    plan.write_text(f'model = "pendulum.toml"\n{keys}\n[parameters]\n{bounds}\n{tables}\n')
    assert (
        load_plan(plan).question
        == plan_fit(vfife.load(folder / "pendulum.toml"), records, LOOKED, **QUICK).question
    )
    plan.write_text(plan.read_text().replace("screened = 1", "screend = 1").replace('"a.csv"', "3"))
    with pytest.raises(ModelError) as error:
        load_plan(plan)
    assert 'Did you mean "screened"' in str(error.value) and "record[0].data = 3" in str(error.value)


def test_faults_of_all_records_are_told_at_once(records, tmp_path):
    one = Record(records[0], own={"start.rodd.angle": (0, 1)}, set={"body.rod.mas": 1.0})
    with pytest.raises(ModelError) as error:
        vfife.fit(pendulum(), [one, tmp_path / "none.csv"], {"body.rod.inertia": (2, 1)})
    text = str(error.value)
    for what in ("body.rod.mass", "none.csv", "bounds do not ascend", 'Did you mean "start.rod.angle"'):
        assert what in text, what
    with pytest.raises(ModelError, match="no column is the angle of a body"):
        data = Measured("time", np.arange(40.0), (Curve("rod.x", "x", np.sin(np.arange(40.0))),), "x")
        vfife.fit(pendulum(), data, {"body.rod.inertia": (5e-5, 2e-4)}, start="data")
    with pytest.raises(ModelError, match="is identified by body.rod.inertia already"):
        vfife.fit(pendulum(), records, {"body.rod.inertia": (1, 2)}, own={"body.rod.inertia": (1, 2)})


def test_bounds_of_a_start_hold_it():
    times = np.linspace(0.5, 1.5, 200)
    data = Measured("time", times, (Curve("rod.angle", "angle", np.sin(7.0 * times)),))
    bounds = starts_of(data)
    low, high = bounds["start.rod.angle"]
    assert low < math.sin(3.5) < high and high - low < 0.2
    low, high = bounds["start.rod.angular_velocity"]
    assert low < 7.0 * math.cos(3.5) < high and high - low < 2.0


def test_velocities_of_a_start_follow_from_the_joints():
    """The lower rod of a double pendulum hangs on the moving end of the upper one: v = w x r."""
    m = Mechanism("two rods", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("upper", length=0.5, mass=1.0, angle=0.3)
    m.link("lower", length=0.4, mass=1.0, angle=0.9)
    m.revolute("O", "ground.O", "upper.start")
    m.revolute("E", "upper.end", "lower.start")
    start = {
        "start.upper.angle": 0.4, "start.upper.angular_velocity": 3.0, "start.lower.angular_velocity": -7.0
    }  # fmt: skip
    (one,) = with_starts([m], [start])
    motion = ideal_motion(one)
    place, rate, _ = motion.of("lower")
    x = -0.5 * 3.0 * math.sin(0.4) + 0.2 * 7.0 * math.sin(0.9)
    y = 0.5 * 3.0 * math.cos(0.4) - 0.2 * 7.0 * math.cos(0.9)
    assert rate == pytest.approx([x, y, -7.0], abs=1e-9) and place[2] == pytest.approx(0.9)
    assert motion.of("upper")[1][2] == pytest.approx(3.0)


def test_errors_of_records_that_disagree_are_those_of_their_scatter():
    """A mean of three records whose own means are 0, 1 and 5: its error is the deviation over sqrt(3),
    however many samples each has.
    """
    means, count = np.array([0.0, 1.0, 5.0]), 400
    left = [mean - means.mean() + 1e-3 * np.cos(3.0 * np.arange(count)) for mean in means]
    a = FitParameter("a", ("a",), "kg", 0.0, 1.0)
    ones = -np.ones((3 * count, 1))
    told = confidence_of(left, [a], np.array([0.5]), ones, 1, 0.95, rows=[count] * 3)
    assert told.errors[0] == pytest.approx(means.std(ddof=1) / math.sqrt(3.0), rel=1e-3)
    assert told.limits[0][1] - 0.5 == pytest.approx(4.30265 * told.errors[0], rel=1e-4), "t of 2 degrees"


def test_columns_without_what_own_numbers_can_do_give_the_same_least_squares():
    source = np.random.default_rng(1)
    jacobian, left = source.standard_normal((30, 4)), source.standard_normal(30)
    parameters = [
        FitParameter(name, (name,), "m", 0.0, 1.0, record=own)
        for name, own in zip("abcd", ("", "r", "", "r"), strict=True)
    ]
    every = np.linalg.lstsq(jacobian, left, rcond=None)[0]
    common = np.linalg.lstsq(without_own(jacobian, parameters), left, rcond=None)[0]
    assert common == pytest.approx(every[[0, 2]])


def test_a_number_with_a_minus_has_the_opposite_value():
    assert with_values(pendulum(), {"driver.rod.torque.1": -3.0}).drivers["rod"].value[1] == -3.0
