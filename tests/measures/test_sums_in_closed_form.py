"""Works, powers, kinetic energies and wear of records that a test writes: each number has a closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from made_records import STEP, made_record
from support import four_bar
from vfife.laws import Coulomb
from vfife.measures import wear
from vfife.measures.catalogue import OVER_TURN, PEAKS, RequestedMeasures
from vfife.measures.contacts import largest_sliding, losses, mean_power, spent_energy
from vfife.measures.energy import driving, ledger, too_open
from vfife.measures.forces import ground_load, largest_shaking
from vfife.measures.turns import last_turn
from vfife.model.bodies import Section
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
    m.clearance_joint("J", "ground.O", "journal.center", clearance=5e-4, bearing_radius=0.01,
        axial_length=0.02,
                friction=Coulomb(coefficient=0.1), wear=Wear(bearing=1e-15, journal=1e-15))  # fmt: skip
    return made_record(m, blocks, STEPS)


@pytest.mark.parametrize(("kind", "block"), [("friction", "contact_friction"), ("impact", "contact_damping")])
def test_a_power_that_grows_evenly_has_lost_half_its_square(kind, block):
    """P = c t loses c t^2/2, exactly by the trapezoidal rule.

    The mean power of an interval, or of a window, is the power at its middle.
    """
    record = rubbing(**{f"{block}_work": summed(40.0), f"{block}_power": 40.0 * TIME})
    assert spent_energy(record, kind)[:, 0] == pytest.approx(20.0 * TIME**2, rel=1e-12, abs=1e-15)
    assert mean_power(record, kind)[1:, 0] == pytest.approx(20.0 * (TIME[1:] + TIME[:-1]), rel=1e-12)
    assert mean_power(record, kind)[0, 0] == 0.0
    window = STEPS > 20
    found = losses(record, window)
    assert found[f"J.{kind}_energy.total"] == pytest.approx(20.0 * (TIME[-1] ** 2 - TIME[4] ** 2), rel=1e-12)
    assert found[f"J.{kind}_power.mean"] == pytest.approx(20.0 * (TIME[-1] + TIME[4]), rel=1e-12)
    term = {"friction": "friction_loss", "impact": "contact_loss"}[kind]
    assert ledger(record).terms[term] == pytest.approx(20.0 * TIME**2, rel=1e-12, abs=1e-15)


RADIUS = 0.01 - 5e-4  # of the journal in ``rubbing``, m


def spinning(speed, acceleration, touches, duration):
    """The journal turns with ``speed`` (at 0) and ``acceleration`` in its bearing."""
    turning = speed + acceleration * (TIME + 0.5 * STEP)
    blocks = {
        "particle_x": np.stack([0.0 * TIME, 0.0 * TIME + 5e-4], axis=1),  # against the bearing
        "particle_w": np.stack([0.0 * TIME, turning], axis=1),
        "particle_aw": np.stack([0.0 * TIME, 0.0 * TIME + acceleration], axis=1),
    }
    depth = np.where(touches, 1e-12, -1e-9)
    return rubbing(**blocks, contact_penetration=depth, contact_duration=duration)


def test_a_journal_that_turns_ever_faster_slides_over_half_the_square_of_the_time():
    """w = a t: the surface slides R a t^2/2, exactly by the trapezoidal rule."""
    record = spinning(0.0, 40.0, np.full(len(TIME), True), TIME)
    way = largest_sliding(record, STEPS > 0)["J.sliding_distance.total"]
    assert way == pytest.approx(RADIUS * 0.5 * 40.0 * TIME[-1] ** 2, rel=1e-6)
    late = largest_sliding(record, STEPS > 20)["J.sliding_distance.total"]
    assert late == pytest.approx(RADIUS * 0.5 * 40.0 * (TIME[-1] ** 2 - TIME[4] ** 2), rel=1e-6)


def test_a_journal_slides_while_it_touches_also_before_it_leaves():
    """w R times the time in contact: an interval with an end apart has the speed of its other end."""
    touches = np.arange(len(TIME)) % 4 != 2
    touching = np.where(touches[1:] & touches[:-1], np.diff(TIME), 0.3 * np.diff(TIME))
    record = spinning(25.0, 0.0, touches, np.concatenate([[0.0], np.cumsum(touching)]))
    way = largest_sliding(record, STEPS > 0)["J.sliding_distance.total"]
    assert way == pytest.approx(RADIUS * 25.0 * touching.sum(), rel=1e-6)


def test_a_driver_whose_power_grows_evenly():
    """Work c t^2/2 over the angle w t: mean power c (t + t')/2, mean torque that over w, ripple the torque's
    range over it.
    """
    speed, c = 300.0, 40.0
    record = made_record(
        four_bar("", speed=speed),
        {
            "driven_work": summed(c),
            "driven_power": c * TIME,
            "driven_torque": 7.0 * TIME,
            "particle_theta": speed * TIME,
        },
        STEPS,
    )
    found = driving(record, STEPS > 20)
    middle = 0.5 * (TIME[-1] + TIME[4])
    assert found["crank.power.mean"] == pytest.approx(c * middle, rel=1e-12)
    assert found["crank.torque.mean"] == pytest.approx(c * middle / speed, rel=1e-9)
    assert found["crank.torque.ripple"] == pytest.approx(
        7.0 * (TIME[-1] - TIME[5]) * speed / (c * middle), rel=1e-9
    )


def test_kinetic_energy_is_that_of_the_speed_it_starts_with_and_then_the_mean_of_both_half_steps():
    """2 kg at v_0 under a constant a: rows hold v_0 + a (t + dt/2), so the mean of squares is v^2 + (a
    dt/2)^2.

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
        "ground.shaking_force.max": pytest.approx(math.hypot(2.0, 3.0)),
        "ground.shaking_moment.max": pytest.approx(1.5),
    }


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
    part = wear.rubbing(record, 0, side)
    own = speed if side == "journal" else 0.0
    assert part.angle == pytest.approx(direction - own * 0.5 * (TIME[1:] + TIME[:-1]), rel=1e-12)
    assert part.work == pytest.approx(5.0 * np.diff(TIME), rel=1e-12) and part.spread == pytest.approx(
        0.0, abs=1e-3
    )


def beam(strain: str = "reference") -> Mechanism:
    """An elastic link of two elements on a pin."""
    m = Mechanism("beam", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.link(
        "l",
        length=0.6,
        mass=1.2,
        angle=0.0,
        model="elastic",
        elements=2,
        section=Section.square(4e-4),
        strain=strain,
    )
    m.revolute("A", "ground.O", "l.start")
    return m


def test_strain_energy_is_that_of_pull_and_end_moments() -> None:
    """N^2 l/(2 E A) + l/(6 E I) (m_1^2 - m_1 m_2 + m_2^2) of each element; side 20 mm, so I = a^4/12."""
    pull, first, second = np.array([300.0, -200.0]), np.array([5.0, 1.0]), np.array([-2.0, 4.0])
    shares = TIME[:, None] / TIME[-1]
    blocks = {
        "frame_axial_force": shares * pull,
        "frame_moment_1": shares * first,
        "frame_moment_2": shares * second,
    }
    young, area, length = 207e9, 4e-4, 0.3
    energy = pull**2 * length / (2.0 * young * area)
    energy += length / (6.0 * young * area**2 / 12.0) * (first**2 - first * second + second**2)
    record = made_record(beam(), blocks, STEPS, step=1e-6)
    assert ledger(record).terms["strain"] == pytest.approx(energy.sum() * shares[:, 0] ** 2, rel=1e-9)


def test_strain_energy_on_the_present_length_is_the_integral_of_the_force() -> None:
    """N = E A ln(l/l_0) over l from l_0: E A (l ln(l/l_0) - l + l_0), for small strains and
    for large ones.
    """
    young, area, length = 207e9, 4e-4, 0.3
    for strain in (1e-5, 0.3, 0.8, -0.7):
        pull = young * area * strain
        present = length * math.exp(strain)
        blocks = {"frame_axial_force": np.full(2, pull), "reference_length": np.full(2, present)}
        record = made_record(beam("current"), blocks, STEPS[:2], step=1e-6)
        series = strain**2 / 2.0 - strain**3 / 6.0 + strain**4 / 24.0  # of e - 1 + exp(-e)
        wanted = present * (series if abs(strain) < 1e-3 else strain - 1.0 + math.exp(-strain))
        assert ledger(record).terms["strain"] == pytest.approx(2.0 * young * area * wanted, rel=1e-9)


def test_weight_works_over_the_height_of_every_mass() -> None:
    """A driven body falls with its centre: m g (h_0 - h), h that of the centre at its angle; a free one by
    its particle.
    """
    m = Mechanism("falling", gravity=(2.0, -10.0))
    m.point("O", 0.0, 0.0)
    m.rigid_body("crank", mass=3.0, inertia=0.1, center=(0.1, 0.2), pins={"axis": (0.0, 0.0)})
    m.point_mass("b", mass=0.5)
    m.revolute("A", "ground.O", "crank.axis")
    m.drive("crank", speed=40.0)
    angle, x, y = 40.0 * TIME, 3.0 * TIME, -7.0 * TIME
    nothing = 0.0 * TIME
    blocks = {
        "particle_theta": np.stack([nothing, angle, nothing], axis=1),
        "particle_x": np.stack([nothing, nothing, x], axis=1),
        "particle_y": np.stack([nothing, nothing, y], axis=1),
    }
    record = made_record(m, blocks, STEPS)
    across, height = 0.1 * np.cos(angle) - 0.2 * np.sin(angle), 0.1 * np.sin(angle) + 0.2 * np.cos(angle)
    wanted = 3.0 * (2.0 * (across - 0.1) - 10.0 * (height - 0.2)) + 0.5 * (2.0 * x - 10.0 * y)
    assert ledger(record).terms["external"] == pytest.approx(wanted, rel=1e-12)


def test_a_ledger_is_open_by_what_is_left_over() -> None:
    """Kinetic energy of 9 J appears from nothing: the residual is that at the end, the error its share of the
    largest energy.
    """
    m = Mechanism("mass", gravity=(0.0, 0.0))
    m.point_mass("b", mass=2.0, velocity=(1.0, 0.0, 0.0))
    after = np.linspace(1.0, math.sqrt(10.0), len(STEPS))
    record = made_record(m, {"particle_u": np.stack([0.0 * after, after], axis=1)}, STEPS)
    found = ledger(record)
    assert (
        found.residual[0] == 0.0
        and found.residual[-1] == pytest.approx(9.0)
        and found.error == pytest.approx(0.9)
    )
    assert found.largest == pytest.approx(10.0) and too_open(record)
    still = made_record(m, {"particle_u": np.stack([0.0 * after, 1.0 + 0.0 * after], axis=1)}, STEPS)
    assert ledger(still).error == 0.0 and not too_open(still)
    assert not too_open(made_record(m, {}, [0])) and too_open(
        made_record(m, {"particle_u": np.array([[0.0, 1.0], [0.0, 3.0]])}, [0, 5])
    )


def test_the_last_turn_is_that_which_ends_with_the_run() -> None:
    """Steps of a hundredth of a turn, an output each ten: the last ten intervals, also where the run began
    within a turn; else all of it.
    """
    m = four_bar("", speed=math.tau / 0.1)
    record = made_record(m, {}, np.arange(0, 260, 10), turns=3, step=1e-3)
    assert np.flatnonzero(last_turn(record)).tolist() == list(range(16, 26))
    exact = made_record(m, {}, np.arange(0, 101, 10), turns=1, step=1e-3)
    assert np.flatnonzero(last_turn(exact)).tolist() == list(range(1, 11))
    assert last_turn(made_record(m, {}, np.arange(0, 91, 10), turns=1, step=1e-3)).all()
    assert last_turn(made_record(m, {}, [0], turns=1, step=1e-3)).tolist() == [True]


def test_only_measures_that_are_named_are_taken() -> None:
    """All without names; influence parameters take the extremes with them, and counts are of
    the whole run.
    """
    every, few, lip, counts = (
        RequestedMeasures(names) for names in ((), ["C.sliding_velocity.max"], ["C.force.lip"], ["C.impacts"])
    )
    assert (every.groups, every.peaks, every.counts) == (OVER_TURN, True, True)
    assert ([group.compute.__name__ for group in few.groups], few.peaks, few.counts) == (
        ["largest_sliding"],
        False,
        False,
    )
    assert (lip.groups, lip.peaks, lip.counts, lip.by_turn) == (PEAKS, True, False, True)
    assert (counts.groups, counts.peaks, counts.counts) == ((), False, True) and not few.by_turn
