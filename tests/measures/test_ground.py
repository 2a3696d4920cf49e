"""What a mechanism does to the ground, against the momentum of all its masses; torque, power and efficiency
against work done by hand.
"""

import dataclasses
import math

import numpy as np
import pytest

import mechanisms
from support import CRANK_SPEED, four_bar, go, with_settings
from vfife import Mechanism, simulate
from vfife.gallery import slider_crank
from vfife.kinematics.forces import actions
from vfife.measures import last_turn
from vfife.measures.catalogue import measures
from vfife.measures.forces import ground_load
from vfife.measures.motion import velocities
from vfife.model.drivers import Ramp, Torque
from vfife.report import run
from vfife.report.summary import run_summary


def outside_and_inertia(record):
    """Weight and loads less the rate of change of momentum, and of angular momentum about the origin,
    particle by particle; (outputs, 3).
    """
    assembly, moving = record.assembly, velocities(record)
    x, y, ax, ay, aw = (record.block(f"particle_{name}") for name in ("x", "y", "ax", "ay", "aw"))
    inverse = [record.parameter(f"particle_inverse_{kind}") for kind in ("mass", "inertia")]
    mass, inertia = (np.where(one > 0.0, 1.0 / np.where(one > 0.0, one, 1.0), 0.0) for one in inverse)
    lx, ly, lm = (record.parameter(f"particle_load_{axis}") for axis in "xym")
    free = list(assembly.topology.free)
    fx, fy, m = (lx - mass * ax)[:, free], (ly - mass * ay)[:, free], (lm - inertia * aw)[:, free]
    total = np.column_stack([fx.sum(1), fy.sum(1), (x[:, free] * fy - y[:, free] * fx + m).sum(1)])
    for k, p in enumerate(assembly.topology.driven):
        mx, my, turning = (
            record.parameter(f"driven_{name}")[k] for name in ("moment_x", "moment_y", "inertia")
        )
        c, s = np.cos(record.block("particle_theta")[:, p]), np.sin(record.block("particle_theta")[:, p])
        rx, ry, w, alpha = c * mx - s * my, s * mx + c * my, moving["w"][:, p], aw[:, p]
        px, py = lx[p] + alpha * ry + w * w * rx, ly[p] - alpha * rx + w * w * ry
        gx, gy = assembly.mechanism.gravity
        total += np.column_stack(
            [px, py, x[:, p] * py - y[:, p] * px - turning * alpha + rx * gy - ry * gx + lm[p]]
        )
    return total


def pushed_from_outside(record):
    """Loads and forces of drivers on points: what does not stand on the ground."""
    assembly, t = record.assembly, record.assembly.topology
    own = list(
        range(sum(len(one.ends) for one in actions(dataclasses.replace(assembly.mechanism, drivers={}))))
    )
    total, at = np.zeros((len(record.steps), 3)), len(own)
    for driver in assembly.mechanism.drivers.values():
        if not driver.moves:
            own += [at] if driver.point else []
            at += 1 if driver.point or driver.against == "ground" else 2
    for k in own:
        p, value = t.load_particle[k], record.block("function_value")[:, t.load_function[k]]
        c, s = np.cos(record.block("particle_theta")[:, p]), np.sin(record.block("particle_theta")[:, p])
        x, y, fx, fy, m = (record.parameter(f"load_{name}")[k] for name in ("x", "y", "fx", "fy", "m"))
        px, py = (c * fx - s * fy, s * fx + c * fy) if t.load_follow[k] else (fx + 0.0 * c, fy + 0.0 * c)
        qx, qy = (
            record.block("particle_x")[:, p] + c * x - s * y,
            record.block("particle_y")[:, p] + s * x + c * y,
        )
        total += np.column_stack([value * px, value * py, value * (qx * py - qy * px + m)])
    return total


MADE = {
    "everything": (mechanisms.everything, {"duration": 4e-3, "outputs": 40}),
    "every drive": (mechanisms.every_drive, {"duration": 6e-3, "outputs": 40}),
    "beads": (mechanisms.beads, {"duration": 1e-3, "outputs": 40}),
    "four-bar": (four_bar, {"turns": 0.25}),
    "exchanged": (lambda: four_bar(exchanged=True), {"turns": 0.25}),
    "a gear's carrier on the ground": (lambda: braked_ring(), {"duration": 1e-3}),
    "two motors": (lambda: two_motors(), {"duration": 2e-3, "outputs": 20}),
    "a cylinder": (lambda: cylinder(), {"turns": 0.2}),
}


def braked_ring():
    """Gears whose carrier is the ground; the last wheel is held back."""
    m = mechanisms.geared_ring()
    m.drivers["brake"] = Torque(body="c", value=-5.0)
    return m


def cylinder():
    """A piston under pressure, whose head the ground is."""
    m = slider_crank()
    m.guide_force("gas", "guide", force=-2000.0)
    return m


def two_motors():
    """One against the ground, one between the links of a double pendulum."""
    m = mechanisms.Mechanism("motors", gravity=(0.0, -9.81))
    m.point("O", 0.3, 0.4)
    m.link("first", length=0.3, mass=1.0, angle=0.5)
    m.link("second", length=0.2, mass=0.5, angle=-1.0)
    m.revolute("O", "ground.O", "first.start")
    m.revolute("P", "first.end", "second.start")
    m.drivers["second"] = Torque(body="second", value=3.0, against="first")
    m.drivers["first"] = Torque(body="first", value=20.0)
    return m


@pytest.mark.parametrize("name", MADE)
def test_the_ground_carries_weight_loads_and_inertia(name) -> None:
    make, run = MADE[name]
    record = go(make(), 2e-6, **run)
    found, expected = ground_load(record), outside_and_inertia(record) + pushed_from_outside(record)
    size = np.abs(
        np.concatenate(
            [
                record.block("joint_fx"),
                record.block("joint_moment"),
                record.block("contact_normal_force"),
                found,
            ],
            axis=1,
        )
    ).max()
    np.testing.assert_allclose(found[1:], expected[1:], atol=1e-10 * size, rtol=0.0)
    assert size > 0.5


def test_gas_in_a_cylinder_shakes_nothing() -> None:
    """It presses on the head as on the piston: force and moment on the ground are those of the
    masses alone.
    """
    with_gas, without = (ground_load(go(one, 2e-5, turns=0.5)) for one in (cylinder(), slider_crank()))
    np.testing.assert_allclose(with_gas[1:], without[1:], atol=1e-5 * np.abs(without).max())


def test_measures_are_those_of_the_last_turn() -> None:
    record = go(four_bar(), 4e-6, turns=1.25)
    load, found = ground_load(record)[last_turn(record)], measures(record)
    assert found["ground.shaking_force.max"] == np.hypot(load[:, 0], load[:, 1]).max()
    assert found["ground.shaking_moment.max"] == np.abs(load[:, 2]).max()


# ------------------------------------------------------------------------------------------------ torque and
# efficiency


def braked(clear: str = "", torque: float = -600.0):
    """The four-bar, a double crank, whose follower works against a constant torque."""
    m = four_bar(clear, speed=CRANK_SPEED / 5.0)
    m.drivers["brake"] = Torque(body="follower", value=torque)
    return m


def test_a_crank_without_losses_does_the_work_of_the_brake() -> None:
    record = go(braked(), 2e-5, turns=1.5)
    found = measures(record)
    assert found["crank.torque.mean"] == pytest.approx(600.0, rel=1e-4)
    assert found["crank.power.mean"] == pytest.approx(600.0 * CRANK_SPEED / 5.0, rel=1e-4)
    assert found["mechanism.efficiency"] == pytest.approx(1.0, abs=1e-9)
    torque = record.block("driven_torque")[-720:, 0]
    assert found["crank.torque.ripple"] == pytest.approx((torque.max() - torque.min()) / 600.0, rel=1e-4)


def weighted(brake: float) -> Mechanism:
    """A crank alone, 2 kg at 50 mm from its pivot, that works against its weight and a constant torque."""
    m = Mechanism("crank", gravity=(0.0, -9.81))
    m.point("A", 0.0, 0.0)
    m.link("crank", length=0.1, mass=2.0)
    m.revolute("A", "ground.A", "crank.start")
    m.drive("crank", speed=20.0)
    m.drivers["brake"] = Torque(body="crank", value=-brake)
    return m


@pytest.mark.parametrize("outputs", [720, 36, 17])
@pytest.mark.parametrize("turns", [1.0, 3.0])
def test_a_torque_with_one_harmonic_has_its_rms_and_the_energy_that_a_flywheel_takes_up(
    outputs: int, turns: float
) -> None:
    """The torque is T0 + T1 cos(angle): rms^2 = T0^2 + T1^2/2, and its integral less the mean has both ends
    T1.
    """
    mean, amplitude = 0.7, 2.0 * 9.81 * 0.05
    result = simulate(weighted(mean), turns=turns, outputs=outputs)
    rms, energy = (result.measures[f"crank.{name}"] for name in ("torque.rms", "energy_fluctuation"))
    exact = math.sqrt(mean**2 + 0.5 * amplitude**2), 2.0 * amplitude
    for value, truth in zip((rms, energy), exact, strict=True):
        assert value.estimated and value.low <= truth <= value.high
        assert value == pytest.approx(truth, rel=1e-5 if outputs == 720 else 0.02)
        assert value.high - value.low < (2e-4 if outputs == 720 else 0.2) * truth
    assert result.measures["crank.torque.rms"].unit == "N m"
    assert result.measures["crank.energy_fluctuation"].unit == "J"
    if outputs == 720:
        page = str(run.document(run_summary(result)))
        assert f"rms torque {float(rms) * 1e3:.1f}" in page or f"rms torque {float(rms):.4g}" in page
        assert "energy fluctuation 1.962 J, which a flywheel would take up" in page


def test_only_a_full_turn_at_constant_speed_has_an_rms_torque_and_a_fluctuation() -> None:
    kinds = {"crank.torque.rms", "crank.energy_fluctuation"}
    assert not kinds & set(measures(go(weighted(0.7), 1e-4, turns=0.6)))
    ramp = weighted(0.7)
    ramp.drivers["crank"] = Ramp(body="crank", speed=20.0, duration=0.4)
    ends = {turns: measures(go(ramp, 1e-4, turns=turns)) for turns in (1.5, 4.0)}
    assert not kinds & set(ends[1.5]) and kinds <= set(ends[4.0])
    assert ends[4.0]["crank.energy_fluctuation"] == pytest.approx(4.0 * 9.81 * 0.05, rel=1e-3)
    # A torque that does not change has nothing to take up.
    level = weighted(0.7)
    level.gravity = (0.0, 0.0)
    found = measures(go(level, 1e-4, turns=1.0))
    assert found["crank.energy_fluctuation"] == 0.0
    assert found["crank.torque.rms"] == pytest.approx(0.7, rel=1e-9)


def test_a_mechanism_with_contact_has_no_estimate_of_either() -> None:
    result = simulate(braked("B"), turns=1.0)
    for name in ("crank.torque.rms", "crank.energy_fluctuation"):
        assert name in result.measures and not result.measures[name].estimated


def test_a_braked_engine_turned_round_gives_what_its_driver_takes() -> None:
    """The follower drives and the crank is held to its speed: the driver takes it."""
    found = measures(go(braked(torque=600.0), 2e-5, turns=1.5))
    assert found["crank.torque.mean"] == pytest.approx(-600.0, rel=1e-4)
    assert found["mechanism.efficiency"] == pytest.approx(1.0, abs=1e-9)


def test_friction_costs_efficiency() -> None:
    record = go(braked("BCD"), 4e-6, turns=2.0)
    found = measures(record)
    lost = sum(
        value
        for name, value in found.items()
        if name.endswith((".friction_energy.total", ".impact_energy.total"))
    )
    out = 600.0 * 2.0 * math.pi
    assert 0.9 < found["mechanism.efficiency"] < 0.995
    assert found["mechanism.efficiency"] == pytest.approx(out / (out + lost), rel=1e-4)
    put_in = found["crank.power.mean"] * 2.0 * math.pi / (CRANK_SPEED / 5.0)
    assert found["mechanism.efficiency"] == pytest.approx(out / put_in, rel=2e-2)


def test_a_machine_that_gives_nothing_off_has_no_efficiency() -> None:
    assert "mechanism.efficiency" not in measures(go(four_bar(), 4e-6, turns=1.0))
    assert "mechanism.efficiency" not in measures(go(braked(), 2e-5, turns=0.5))


def test_damping_slows_what_a_point_does() -> None:
    """A point's acceleration is that of its velocity, with mass-proportional damping too."""
    from vfife.measures.motion import point_motion

    record = go(with_settings(two_motors(), damping=20.0), 2e-6, duration=4e-3, outputs=2000)
    moved = point_motion(record, "second.end")
    rate = (moved.velocity[2:] - moved.velocity[:-2]) / (4e-6)
    np.testing.assert_allclose(moved.acceleration[1:-1], rate, rtol=1e-4, atol=1e-3 * np.abs(rate).max())
