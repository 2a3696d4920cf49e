"""A smooth run again with half its step: the error that is told, against the error there is."""

from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import vfife
from support import with_settings
from vfife import gallery
from vfife.measures.catalogue import PEAKS
from vfife.measures.error_ranges import ranged, sizes
from vfife.measures.smooth_errors import error_of, estimate, values_of
from vfife.measures.trust import Trust, finer, trust
from vfife.measures.values import Measured
from vfife.model.mechanism import Mechanism
from vfife.modelfile.read import load, loads
from vfife.simulation.result import Result
from vfife.solvers.refinement import FINER, PARTS, SAMPLED, Differences, refine
from vfife.solvers.scales import scales

FRAME = Path(vfife.__file__).parent / "modelfile" / "templates" / "frame.toml"


def pendulum() -> Mechanism:
    """A heavy rod, let go 2 rad from its rest."""
    m = Mechanism("rod", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=0.6, mass=1.5, angle=2.0 - 0.5 * math.pi)
    m.revolute("O", "ground.O", "rod.start")
    return with_settings(m, duration=2.0)


@pytest.mark.parametrize("make", [pendulum, gallery.double_pendulum, gallery.jansen_leg])
def test_the_order_is_two(make) -> None:
    estimate = vfife.simulate(with_settings(make(), step=4e-4)).record.estimate
    assert estimate is not None and estimate.order == pytest.approx(2.0, abs=0.05)


def test_the_error_of_a_pendulum() -> None:
    """The largest force at the pin is m g (1 + 3/2 (1 - cos a)) at the lowest point: energy and the
    centripetal acceleration of a rod.
    """
    result = vfife.simulate(pendulum(), step=4e-3)
    one = result.measures["O.force.max"]
    truth = 1.5 * 9.81 * (1.0 + 1.5 * (1.0 - math.cos(2.0)))
    assert abs(one - truth) > 1e-6 * truth
    assert one.low <= truth <= one.high


@pytest.mark.parametrize(
    "make", [gallery.four_bar_ideal, gallery.six_bar_press, gallery.quick_return, gallery.jansen_leg]
)
def test_the_truth_lies_in_the_range(make) -> None:
    result = vfife.simulate(make(), reference=False)
    truth = vfife.simulate(make(), step=result.record.assembly.choice.step / 8.0, companions=0).measures
    turn, driven = result.record.assembly.choice.turn, result.crank
    assert turn is not None
    largest = result.measures["A.force.max" if "A.force.max" in result.measures else "O.force.max"]
    torque = result.measures[
        f"{driven}.torque.max"
    ]  # whose mean over a turn without losses is zero, but for the step
    idle = {".power.mean": 1e-7 * 2.0 * math.pi / turn * torque, ".torque.mean": 1e-7 * torque}
    for name, one in result.measures.items():
        slack = 1e-6 * abs(one) + next(
            (least for ending, least in idle.items() if name.endswith(ending)), 1e-9 * largest
        )
        assert one.low - slack <= truth[name] <= one.high + slack, name


def test_a_body_that_does_not_turn_is_no_doubt() -> None:
    """The yoke's angular acceleration is nothing but rounding."""
    said = trust(vfife.simulate(gallery.scotch_yoke()).record)
    assert said is not None and not said.sensitive and said.companions == 0


def test_a_coarse_step_is_told() -> None:
    result = vfife.simulate(pendulum(), step=0.05, outputs=20)
    assert result.summary["trust"]["sensitive"]
    assert re.match(
        r"The step is coarse: \S+\.max has an error of about [1-9]", result.summary["warnings"][0]
    )


def test_companions_turn_it_off_and_on() -> None:
    assert vfife.simulate(pendulum(), companions=0).record.estimate is None
    long = with_settings(pendulum(), duration=20000.0, step=1e-4, outputs=2)
    assert not _made(long)


def _made(mechanism: Mechanism) -> bool:
    from vfife.simulation.simulate import prepare
    from vfife.solvers.arguments import RunArguments

    return prepare(mechanism, RunArguments()).refined


def test_it_is_kept(tmp_path) -> None:
    result = vfife.simulate(pendulum())
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path / "run.sqlite")
    assert again.record.estimate == result.record.estimate
    for name, one in result.measures.items():
        assert (again.measures[name].low, again.measures[name].high) == (one.low, one.high)


def test_every_measure_has_an_error() -> None:
    """Means, powers and shaking forces too. The place of the largest stress jumps from node to node, and the
    axial vibration of the elastic pendulum is faster than its outputs: these have none.
    """
    for make in (gallery.four_bar_ideal, gallery.quick_return, gallery.elastic_pendulum):
        measures = vfife.simulate(make(), reference=False).measures
        assert [name for name, one in measures.items() if not one.estimated] == [
            name for name in measures if name.endswith((".place", "tension.max", "compression.max"))
        ]
        assert any(
            name == "ground.shaking_force.max" and one.low < one < one.high for name, one in measures.items()
        )


@pytest.mark.system("runs with a quarter of the step")
def test_means_of_turns_have_the_error_of_the_same_turns() -> None:
    """A follower with a damper to the ground, over four turns: the mean power is told with its error, and the
    truth lies within it.
    """
    mechanism = with_settings(gallery.four_bar_ideal(), turns=4.0)
    mechanism.torsional_spring("damper", "ground", list(mechanism.bodies)[-1], damping=0.05)
    turn = vfife.simulate(mechanism, companions=0).record.assembly.choice.turn
    result = vfife.simulate(mechanism, step=turn / 240.0, outputs=60, reference=False, force_step=True)
    truth = vfife.simulate(mechanism, step=turn / 240.0 / 32.0, outputs=60, reference=False, companions=0)
    assert result.motion is not None and result.motion.first < result.motion.last
    for name, true in values_of(truth.record, result.record).items():
        one = result.measures[name]
        assert one.estimated and one.low - 1e-9 * abs(true) <= true <= one.high + 1e-9 * abs(true), name
        # The load on the ground, the energy and the torque are known at sixty outputs a turn; their ranges
        # hold what lies between them.
        at_outputs = name.startswith("ground.") or name.endswith(".energy_fluctuation")
        limit = 0.11 if name.endswith(".torque.rms") else 0.1 if at_outputs else 0.05
        assert one.width <= limit * abs(one), name
    assert result.measures["crank.power.mean"] > 1.0


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ((1.04, 1.01, 1.0025), 1.25 * 0.04),  # second order: what is left is a third of the last difference
        ((1.04, 1.02, 1.01), 1.25 * 0.04),  # first order
        ((1.0, 1.0, 1.04), 1.25 * (0.04 + 3.0 * 0.04)),  # h and h/2 agree by chance
        ((1.04, 1.0, 1.0), 1.25 * 4.0 / 3.0 * 0.04),  # h/2 and h/4 agree by chance, or are exact
        ((1.0, 1.0, 1.0), 0.0),
    ],
)
def test_an_error_from_three_steps(values: tuple[float, float, float], error: float) -> None:
    assert error_of(*values, 0.25) == pytest.approx(error, rel=1e-12, abs=1e-15)
    assert error_of(*values, None) == pytest.approx(error, rel=1e-12, abs=1e-15)


def test_the_order_counts_between_one_and_two() -> None:
    """Where the motion converges more slowly, more is left out by the finest step too."""
    first, second = (error_of(1.04, 1.01, 1.0025, ratio) for ratio in (0.5, 0.25))
    assert first == pytest.approx(1.25 * 0.06) and second == pytest.approx(1.25 * 0.04)
    assert error_of(1.04, 1.01, 1.0025, 0.9) == first and error_of(1.04, 1.01, 1.0025, 0.1) == second


def test_runs_that_agree_by_chance_leave_a_floor() -> None:
    """No measure counts as better known than a tenth of the one that is known worst, relative
    to their sizes.
    """
    record = vfife.simulate(pendulum(), step=0.02, outputs=100, force_step=True, companions=0).record
    refined = refine(record)
    for part in (refined.half, refined.quarter):  # as if all three had met the same largest force
        part.rows[:, part._columns.of("joint_force_squared_max")] = record.block("joint_force_squared_max")
    errors = estimate(record, refined).errors
    size = sizes({name: Measured(value) for name, value in values_of(record, record).items()}, 0.02)
    assert errors["O.force.max"] == pytest.approx(
        0.1
        * size["O.force.max"]
        * errors["rod.angular_acceleration.max"]
        / size["rod.angular_acceleration.max"]
    )
    assert errors["O.force.max"] > 0.0


def test_a_run_whose_steps_do_not_come_together_is_sensitive() -> None:
    """However well a measure agrees; an automatic step is halved then."""
    said = Trust(0, "O.force.max", 1e-6, 1.0, 1.0, None, 0, 0.1, converges=False)
    assert said.sensitive and not dataclasses.replace(said, converges=True).sensitive
    record = vfife.simulate(pendulum()).record
    assert record.estimate is not None and finer(record) is None
    record.estimate.converges = False
    assert finer(record) == ((record.assembly.choice.step, 1.0),)


def compared(own: list[float], half: list[float], quarter: list[float]) -> Differences:
    """Differences of a body that moves along x; 80 outputs."""
    record = vfife.simulate(
        with_settings(pendulum(), duration=0.8), step=0.01, outputs=80, companions=0, force_step=True
    ).record
    differences = Differences(record, record.row_numbers)
    rows = np.zeros((3, 81, len(record.row_numbers)))
    rows[:, :, differences.columns[1]] = own, half, quarter
    differences.own = rows[0][:, differences.columns]
    for begin in range(0, 80, 8):
        differences.take(begin, rows[1, begin + 1 : begin + 9], rows[2, begin + 1 : begin + 9])
    return differences


def test_differences_that_stop_falling_before_the_end_are_seen() -> None:
    """Second order in the first three quarters, none in the last: there the motion is decided
    by the steps.
    """
    time = np.arange(81) / 80.0
    good = compared(np.sin(9.0 * time) + 0.016, np.sin(9.0 * time) + 0.004, np.sin(9.0 * time) + 0.001)
    assert good.ratio() == pytest.approx(0.25, abs=1e-3) and all(
        good.converges(part) for part in range(PARTS)
    )
    late = np.where(time > 0.8, 0.03, 0.0)
    bad = compared(np.sin(9.0 * time) + 0.016, np.sin(9.0 * time) + 0.004 + late, np.sin(9.0 * time) + 0.001)
    assert not bad.converges(0) and not bad.converges(6)
    early = compared(
        np.sin(9.0 * time) + 0.016,
        np.sin(9.0 * time) + 0.004 + 0.03 * (time < 0.2),
        np.sin(9.0 * time) + 0.001,
    )
    assert not early.converges(0) and early.converges(
        4
    )  # measures of the last turn do not need the first one
    small = compared(np.sin(9.0 * time) + 5e-4, np.sin(9.0 * time), np.sin(9.0 * time) + 5e-4)
    assert small.converges(0)  # differences that decide nothing


def test_a_motion_that_the_steps_decide_is_sensitive() -> None:
    """Two rods let go above the horizontal: after some seconds every step gives another motion."""
    m = gallery.double_pendulum()
    result = vfife.simulate(with_settings(m, duration=60.0), step=1e-3, outputs=600, force_step=True)
    said = trust(result.record, result.measures)
    assert said is not None and not said.converges and said.sensitive
    assert "does not converge" in result.summary["warnings"][0] and not result.summary["trust"]["converges"]


STRIP = """
[run]
duration = "0.3 s"
[ground]
wall = [0, 0]
[body.strip]
length = "1 m"
model = "elastic"
elements = 8
section = { rectangle = ["20 mm", "20 mm"] }
[joint.clamp]
kind = "weld"
bearing = "ground.wall"
journal = "strip.start"
[load.tip]  # grows for 50 ms and then stays
at = "strip.end"
force = [0, "-100 N"]
times = [0, "0.05 s", "0.3 s"]
factors = [0, 1, 1]
"""


@pytest.mark.parametrize("make", [lambda: loads(STRIP), lambda: load(FRAME)])
def test_waves_in_the_shortest_elements_make_no_structure_sensitive(make) -> None:
    """The accelerations that they give to nodes differ with every step, and carry hardly any force: the
    forces and the motion converge, and the first step is fine enough.
    """
    result = vfife.simulate(make())
    record, measures = result.record, result.measures
    said, choice = trust(record), record.assembly.choice
    assert said is not None and said.converges and not said.sensitive and not choice.tried
    assert said.order == pytest.approx(2.0, abs=0.2)
    fine = vfife.simulate(make(), step=choice.step / 8.0, companions=0).measures
    for name, size in sizes(ranged(record, groups=PEAKS), choice.step, scales(record.assembly)).items():
        low, high = measures[name].low, measures[name].high
        assert low <= fine[name] <= high and high - low < 5e-3 * size, name


def test_an_elastic_motion_that_the_steps_decide_is_sensitive() -> None:
    """The rubber rod swings, bends and stretches for 20 s: no two steps give the same motion."""
    m = with_settings(gallery.elastic_pendulum(), duration=20.0)
    said = trust(vfife.simulate(m, step="auto", companions=1).record)
    assert said is not None and not said.converges and said.sensitive


def test_repetitions_are_as_long_as_the_run() -> None:
    record = vfife.simulate(pendulum(), companions=0).record
    refined = refine(record)
    for part, one in zip((2, 4), (refined.half, refined.quarter), strict=True):
        assert (
            one.assembly.choice.step == record.assembly.choice.step / part
            and one.steps[-1] == part * record.steps[-1]
        )
        assert one.rows.shape == record.rows.shape
        again = vfife.simulate(
            pendulum(), step=record.assembly.choice.step / part, outputs=len(record.steps) - 1, companions=0
        ).record
        np.testing.assert_array_equal(one.rows, again.rows)


def test_noise_of_second_differences_goes_with_size_over_acceleration():
    """Rounding of places of the size L over a squared step is EPS L / dt**2: the share of the accelerations P
    that it is, is that over P.
    """
    size, push, step = 3.0, 40.0, 1e-3
    rows = np.zeros((5, 6))
    rows[:, 0], rows[:, 3] = size, push  # x and ax; nothing turns
    layout = SimpleNamespace(rows_of=lambda name: np.array([SAMPLED.index(name)]))
    choice = SimpleNamespace(step=step)
    record = SimpleNamespace(
        assembly=SimpleNamespace(layout=layout, choice=choice, bodies={}),
        rows=rows,
        row_numbers=np.arange(6, dtype=np.uint32),
    )
    _, _, noise = Differences(record, np.arange(6, dtype=np.uint32)).scaled()
    rounding = np.finfo(float).eps * (FINER[-1] / step) ** 2
    assert noise[3:5] == pytest.approx(rounding * size / push, rel=1e-12)
    assert noise[5] == pytest.approx(rounding / (push / size), rel=1e-12), (
        "nothing turns faster than what would push it so"
    )


def test_a_smooth_run_is_known_as_far_as_its_worst_error():
    """The share of the size by which the worst measure may be wrong to each side, not the
    width of its range.
    """
    record = vfife.simulate(
        vfife.gallery.four_bar_case_b().ideal(), turns=0.3, step="0.2 ms", force_step=True, reference=False
    ).record
    said = trust(record)
    found = sizes(ranged(record, groups=PEAKS), record.assembly.choice.step)
    worst = max(record.estimate.errors[name] / size for name, size in found.items())
    assert said.apart == pytest.approx(worst, rel=1e-3) and worst > 1e-6
