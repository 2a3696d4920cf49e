"""Works, powers, kinetic energies and wear of records that a test writes: each number has a closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from made_records import STEP, made_record
from support import four_bar
from vfife.analysis.energy import ledger
from vfife.analysis.ground import ground_load, largest_shaking
from vfife.analysis.losses import losses, lost, mean_power
from vfife.analysis.machine import driving
from vfife.analysis.wear import rubbed
from vfife.laws import Coulomb
from vfife.model.mechanism import Mechanism
from vfife.model.wear import Wear

STEPS = np.arange(0, 50, 5)
TIME = STEP * STEPS


def summed(rate: float) -> np.ndarray:
    """The row of a work whose power is ``rate`` t: the sum of dt P(t_k) up to the step of the output."""
    return np.array([math.fsum(STEP * rate * STEP * k for k in range(n + 1)) for n in STEPS])


def rubbing(**blocks):
    """A journal in a bearing on the ground, with friction and wear."""
    m = Mechanism("journal in bearing", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.rigid_body("journal", mass=1.0, inertia=1e-4)
    m.clearance("J", "ground.O", "journal.center", clearance=5e-4, bearing_radius=0.01, axial_length=0.02,
                friction=Coulomb(coefficient=0.1), wear=Wear(bearing=1e-15, journal=1e-15))  # fmt: skip
    return made_record(m, blocks, STEPS)


@pytest.mark.parametrize(("kind", "block"), [("friction", "contact_friction"), ("impact", "contact_damping")])
def test_a_power_that_grows_evenly_has_lost_half_its_square(kind, block):
    """P = c t loses c t^2/2, exactly by the trapezoidal rule.

    The mean power of an interval, or of a window, is the power at its middle.
    """
    record = rubbing(**{f"{block}_work": summed(40.0), f"{block}_power": 40.0 * TIME})
    assert lost(record, kind)[:, 0] == pytest.approx(20.0 * TIME**2, rel=1e-12, abs=1e-15)
    assert mean_power(record, kind)[1:, 0] == pytest.approx(20.0 * (TIME[1:] + TIME[:-1]), rel=1e-12)
    assert mean_power(record, kind)[0, 0] == 0.0
    window = STEPS > 20
    found = losses(record, window)
    assert found[f"J.{kind}_energy.total"] == pytest.approx(20.0 * (TIME[-1] ** 2 - TIME[4] ** 2), rel=1e-12)
    assert found[f"J.{kind}_power.mean"] == pytest.approx(20.0 * (TIME[-1] + TIME[4]), rel=1e-12)
    term = {"friction": "friction_loss", "impact": "contact_loss"}[kind]
    assert ledger(record).terms[term] == pytest.approx(20.0 * TIME**2, rel=1e-12, abs=1e-15)


def test_a_driver_whose_power_grows_evenly():
    """Work c t^2/2 over the angle w t: mean power c (t + t')/2, mean torque that over w, ripple the torque's range over it."""
    speed, c = 300.0, 40.0
    record = made_record(
        four_bar("", speed=speed),
        {"driven_work": summed(c), "driven_power": c * TIME, "driven_torque": 7.0 * TIME, "particle_theta": speed * TIME}, STEPS,
    )  # fmt: skip
    found = driving(record, STEPS > 20)
    middle = 0.5 * (TIME[-1] + TIME[4])
    assert found["crank.power.mean"] == pytest.approx(c * middle, rel=1e-12)
    assert found["crank.torque.mean"] == pytest.approx(c * middle / speed, rel=1e-9)
    assert found["crank.torque.ripple"] == pytest.approx(7.0 * (TIME[-1] - TIME[5]) * speed / (c * middle), rel=1e-9)


def test_kinetic_energy_is_that_of_the_speed_it_starts_with_and_then_the_mean_of_both_half_steps():
    """2 kg at v_0 under a constant a: rows hold v_0 + a (t + dt/2), so the mean of squares is v^2 + (a dt/2)^2.

    Output 0 has m v_0^2/2.
    """
    m = Mechanism("mass")
    m.point_mass("b", mass=2.0)
    v0, a = 3.0, 800.0
    after = v0 + a * (TIME + 0.5 * STEP)
    record = made_record(
        m,
        {
            "particle_u": np.stack([0 * TIME, after], axis=1),
            "particle_ax": np.stack([0 * TIME, 0 * TIME + a], axis=1),
        },
        STEPS,
    )
    wanted = 0.5 * 2.0 * ((v0 + a * TIME) ** 2 + (0.5 * a * STEP) ** 2)
    wanted[0] = 0.5 * 2.0 * v0**2
    assert ledger(record).terms["kinetic"] == pytest.approx(wanted, rel=1e-13)


def test_a_load_on_the_ground_has_the_moment_of_its_arm():
    """(2, -3) N at (0.4, 0.5) m with 0.7 N m: 0.4 (-3) - 0.5 (2) + 0.7 = -1.5 N m about the origin."""
    m = Mechanism("ground", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.point("P", 0.4, 0.5)
    m.point_mass("b", mass=1.0)
    m.force("push", "ground.P", force=(2.0, -3.0), moment=0.7)
    record = made_record(m, {"function_value": np.ones(len(STEPS))}, STEPS)
    assert ground_load(record) == pytest.approx(np.tile([2.0, -3.0, -1.5], (len(STEPS), 1)), rel=1e-12)
    assert largest_shaking(record, STEPS > 0) == {
        "ground.shaking_force.max": pytest.approx(math.hypot(2.0, 3.0)), "ground.shaking_moment.max": pytest.approx(1.5),
    }  # fmt: skip


@pytest.mark.parametrize("side", ["bearing", "journal"])
def test_what_turns_evenly_is_rubbed_at_the_angle_of_the_middle_of_each_interval(side):
    """Work summed in a fixed direction at 0.3 rad lies at 0.3 - w (t + t')/2 on a body that turns with w."""
    speed, direction = 20.0, 0.3
    work = 5.0 * TIME
    turned = np.stack([0.0 * TIME, speed * TIME], axis=1)  # of the ground and of the journal
    record = rubbing(
        wear_work=work,
        wear_x=math.cos(direction) * work,
        wear_y=math.sin(direction) * work,
        particle_theta=turned,
    )
    part = rubbed(record, 0, side)
    own = speed if side == "journal" else 0.0
    assert part.angle == pytest.approx(direction - own * 0.5 * (TIME[1:] + TIME[:-1]), rel=1e-12)
    assert part.work == pytest.approx(5.0 * np.diff(TIME), rel=1e-12) and part.spread == pytest.approx(0.0, abs=1e-3)
