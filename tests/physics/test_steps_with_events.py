"""Steps in which something begins, ends or changes its regime are taken again in parts: cases b and c are
smooth in the step, stops are met.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vfife
from support import bits, go, lanes, particle, times, with_settings
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import PARTS, Runner
from vfife.model.mechanism import Mechanism, Settings

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TURN = 0.04
# Largest follower acceleration (rad/s^2) and force of joint 2 (N) in the second turn, by RK4 with located
# onsets at 3.2 million steps
REFERENCE = {"b": (29201.05, 65794.78), "c": (38153.31, 68842.16)}


@lru_cache
def peaks(case: str, per_turn: int, parts: int = 8, share: float = 0.0) -> tuple[float, float]:
    """The same two numbers at so many steps a turn."""
    mechanism = vfife.load_model(EXAMPLES / f"four_bar_case_{case}.toml")
    a = assemble(mechanism, TURN / per_turn, turns=2, outputs=2, force_step=True)
    rows = np.array([*a.layout["body_alpha_max"], *a.layout["contact_force_squared_max"]], dtype=np.uint32)
    runner = Runner(
        a.topology,
        a.state[:, None].copy(),
        a.tables[None],
        "generated",
        rows,
        parts=parts,
        shares=np.array([share]),
    )
    runner.advance(1, 1)
    runner.advance(per_turn, 1)
    last = runner.advance(per_turn, 1)[0, :, 0]
    bodies = len(a.layout["body_alpha_max"])
    return float(last[list(mechanism.bodies).index("follower")]), float(
        np.sqrt(last[bodies + list(mechanism.clearances).index("C")])
    )


def error(case: str, per_turn: int, parts: int = 8) -> float:
    return max(
        abs(found / true - 1.0)
        for found, true in zip(peaks(case, per_turn, parts), REFERENCE[case], strict=True)
    )


@pytest.mark.parametrize("per_turn", [5000, 8000, 10_400, 13_600, 17_600, 20_000, 25_600, 40_000])
def test_case_c_is_right_at_every_step(per_turn):
    assert error("c", per_turn) < (0.01 if per_turn >= 10_000 else 0.03)


@pytest.mark.parametrize("per_turn", [2500, 3100, 4000, 5300, 8000])
def test_case_b_is_right_at_every_step(per_turn):
    assert error("b", per_turn) < 0.005


@pytest.mark.verify
def test_case_c_on_the_fine_grid():
    """116 steps from 5 to 0.4 us and those up to 8 us; the order as the slope of six mean squares from 4 to
    0.5 us.
    """
    counts = [*range(5000, 8000, 200), *range(8000, 100_001, 800)]
    errors = np.array([error("c", n) for n in counts])
    steps = TURN / np.array(counts)
    assert errors[steps <= 4e-6].max() < 0.01
    assert np.median(errors[len(range(5000, 8000, 200)) :]) < 1e-4
    edges = np.geomspace(4.0001e-6, 0.4999e-6, 7)
    groups = [(steps <= high) & (steps > low) for high, low in zip(edges, edges[1:], strict=False)]
    points = np.array(
        [(np.log(steps[one]).mean(), 0.5 * np.log((errors[one] ** 2).mean())) for one in groups]
    )
    assert 1.8 < np.polyfit(*points.T, 1)[0] < 2.2


@pytest.mark.verify
def test_case_b_on_a_fine_grid():
    assert max(error("b", n) for n in range(2500, 40_001, 300)) < 0.005


def test_one_part_is_the_scheme_of_the_paper():
    """As it is, some steps near 3 us take a near-grazing impact to the wrong branch."""
    assert max(error("c", n, 1) for n in range(12_000, 16_001, 800)) > 0.01


def test_a_stop_is_met_within_a_step():
    """Spring and damper beyond a limit against DOP853 from the instant where a wheel of 2 rad/s meets it."""
    limit = 0.1001

    def rate(_t: float, y: np.ndarray) -> list[float]:
        return [y[1], -(300.0 * y[0] + 0.4 * y[1]) / 0.02]

    exact = solve_ivp(
        rate, (limit / 2.0, 0.07), [0.0, 2.0], method="DOP853", rtol=1e-12, atol=1e-14, dense_output=True
    ).sol

    def error(step: float, parts: int) -> float:
        m = Mechanism("wheel")
        m.point("O", 0.0, 0.0)
        m.rigid_body("wheel", mass=1.0, inertia=0.02, velocity=(0.0, 0.0, 2.0))
        m.revolute("O", "ground.O", "wheel.center")
        m.stop("st", "ground", "wheel", low=-9.0, high=limit, stiffness=300.0, damping=0.4)
        record = go(with_settings(m, parts=parts), step, duration=0.06, outputs=50)
        assert record.block("repeated")[-1, 0] == (1.0 if parts > 1 else 0.0)
        return abs(float(particle(record, "wheel")["theta"][-1]) - limit - exact(times(record)[-1])[0])

    worst = {parts: max(error(step, parts) for step in (4e-4, 3e-4, 2e-4, 1e-4)) for parts in (1, 8)}
    assert worst[8] < 0.35 * worst[1] and worst[8] < 2e-5


def turned_into_a_stop(step: float, count: int, parts: int) -> list[float]:
    """Angles (rad) of a wheel of 2 rad/s and 0.02 kg m^2 that meets a spring of 300 N m/rad beyond 0.1 rad:
    velocity Verlet, and the step that leads into the spring in parts.
    """

    def pull(angle: float) -> float:
        return -300.0 * max(angle - 0.1, 0.0) / 0.02

    def taken(angle: float, speed: float, step: float, count: int) -> tuple[float, float]:
        for _ in range(count):
            middle = speed + 0.5 * step * pull(angle)
            angle += step * middle
            speed = middle + 0.5 * step * pull(angle)
        return angle, speed

    found = [(0.05, 2.0)]
    for _ in range(count):
        after = taken(*found[-1], step, 1)
        meets = found[-1][0] <= 0.1 < after[0]
        found.append(taken(*found[-1], step / parts, parts) if meets else after)
    return [angle for angle, _ in found]


@pytest.mark.parametrize("parts", [None, 1, 5])
def test_a_step_with_an_event_is_taken_again_in_eight_parts_or_those_of_the_model(parts: int | None) -> None:
    assert Settings().parts == PARTS
    step, count = 3e-4, 100
    m = Mechanism("wheel")
    m.point("O", 0.0, 0.0)
    m.rigid_body("wheel", mass=1.0, inertia=0.02, angle=0.05, velocity=(0.0, 0.0, 2.0))
    m.revolute("O", "ground.O", "wheel.center")
    m.stop("st", "ground", "wheel", low=-9.0, high=0.1, stiffness=300.0)
    model = with_settings(m, parts=parts) if parts else m
    record = go(model, step, duration=count * step, outputs=count)
    expected = turned_into_a_stop(step, count, parts or 8)
    others = [turned_into_a_stop(step, count, (parts or 8) + more)[-1] for more in (1, 2, 8)]
    assert particle(record, "wheel")["theta"] == pytest.approx(expected, abs=1e-12)
    assert min(abs(other - expected[-1]) for other in others) > 5e-9


def test_lanes_out_of_phase_move_alike():
    """A first step of a share of one, in lanes: lane 0 as without the others, each as alone, in every loop;
    and the same motion.
    """
    a = assemble(vfife.load_model(EXAMPLES / "four_bar_case_c.toml"), 2e-6, duration=4e-3, force_step=True)
    shares = (0.0, 0.25, 0.5, 0.75)
    found = {loop: lanes([a] * 4, loop, shares=shares) for loop in ("generated", "data-driven")}
    rows = {loop: (runner.advance(1, 1), runner.advance(200, 10))[1] for loop, runner in found.items()}
    assert (bits(rows["generated"]) == bits(rows["data-driven"])).all()
    alone = lanes([a], "generated", shares=shares[1:2])
    alone.advance(1, 1)
    assert (bits(alone.advance(200, 10)[:, :, 0]) == bits(rows["generated"][:, :, 1])).all()
    plain = lanes([a], "generated")
    plain.advance(1, 1)
    assert (bits(plain.advance(200, 10)[:, :, 0]) == bits(rows["generated"][:, :, 0])).all()
    follower = list(a.mechanism.bodies).index("follower")
    theta = a.layout["particle_theta"]
    turns = [float(found["generated"].states[theta[-1], k]) for k in range(4)]
    rate = float(found["generated"].states[a.layout["particle_w"][-1], 0])
    assert follower >= 0
    assert np.diff(turns) == pytest.approx(0.25 * 2e-6 * rate, rel=1e-2)
