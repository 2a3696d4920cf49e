"""Motions that coexist and motions that only look so: pendulums with a stop against an integration that
locates the stop (DOP853), a slider-crank whose contact law has a memory, and points that a test writes.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vfife
from vfife.dynamics import load_map
from vfife.dynamics.basins import attractors, basins
from vfife.measures.attractors import ALIKE_POINTS, change, same_motion, step_share
from vfife.measures.chaos import exponent, verdict
from vfife.modelfile import load

LENGTH, MASS, GRAVITY, STIFFNESS, DAMPING, AIR = 0.3, 0.5, 9.81, 400.0, 0.5, 0.01
INERTIA = MASS * LENGTH**2 / 3.0


def pendulum(low: float, high: float) -> vfife.Mechanism:
    """A rod on a hinge named pivot, with a stop at both angles (deg)."""
    m = vfife.Mechanism("pendulum with a stop", gravity=(0.0, -GRAVITY))
    m.link("rod", length=LENGTH, mass=MASS, angle="-90 deg")
    m.torsional_spring("air", "ground", "rod", damping=AIR)
    m.stop(
        "wall", "ground", "rod", low=f"{low} deg", high=f"{high} deg", stiffness=STIFFNESS, damping=DAMPING
    )
    return m


def on_moved_base() -> vfife.Mechanism:
    """Its hinge is moved by a Scotch yoke: 0.03 sin(12 t) m."""
    m = pendulum(-170.0, -80.0)
    ground = m.point("O", 0.0, 0.0)
    crank = m.link("crank", length=0.03, mass=0.2, angle="-90 deg")
    car = m.rigid_body("car", mass=1.0, inertia=0.01, position=(0.0, 0.0))
    m.revolute("shaft", ground, crank.start)
    m.slider("slot", car.pin(), crank.end, direction=(0, 1), turning=True)
    m.slider("rail", ground, car.pin())
    m.revolute("hinge", car.pin(), m.bodies["rod"].start)
    m.drive(crank, speed=12.0)
    return m


def forced() -> vfife.Mechanism:
    """Its hinge rests, and a moment of 0.5 cos(6 t) N m acts."""
    m = pendulum(-150.0, -70.0)
    m.revolute("hinge", m.point("P", 0.0, 0.0), m.bodies["rod"].start)
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0.0))
    m.revolute("shaft", m.point("Q", 0.5, 0.0), rotor.pin())
    m.drive(rotor, speed=6.0)
    angles = [0, "360 deg"]
    m.moment("force", "rod.end", moment=0.5, expression="cos(angle)", crank="rotor", angles=angles)
    return m


def last_speed(start, speed, low, high, moment, turns=60):
    """Return the speed (rad/s) of a pendulum after some turns at a ``speed`` of the excitation, from its
    angle and speed; ``moment(t, angle)`` excites it.
    """
    low, high, period = math.radians(low), math.radians(high), 2.0 * math.pi / speed

    def rates(t, y, side):
        total = moment(t, y[0]) - 0.5 * MASS * GRAVITY * LENGTH * math.cos(y[0]) - AIR * y[1]
        if side > 0:
            total += min(0.0, -(STIFFNESS * (y[0] - high) + DAMPING * y[1]))
        if side < 0:
            total += max(0.0, -(STIFFNESS * (y[0] - low) + DAMPING * y[1]))
        return [y[1], total / INERTIA]

    def reaches(limit, direction):
        def event(t, y):
            return y[0] - limit

        event.direction, event.terminal = direction, True
        return event

    t, y, side = 0.0, np.array(start), 0
    while t < turns * period - 1e-12:
        events = (
            [reaches(high, 1), reaches(low, -1)] if side == 0 else [reaches((low, 0, high)[side + 1], -side)]
        )
        part = solve_ivp(
            lambda t, y, side=side: rates(t, y, side), (t, turns * period), y, method="DOP853", rtol=1e-8,
            atol=1e-10, events=events,
        )  # fmt: skip
        t, y = part.t[-1], part.y[:, -1]
        if part.status == 1:
            side = 0 if side else (1 if len(part.t_events[0]) else -1)
    return y[1]


def moved_base(t, angle):
    """Return the moment (N m) of the inertia of a hinge at 0.03 sin(12 t) m."""
    return -0.5 * MASS * LENGTH * math.sin(angle) * 0.03 * 144.0 * math.sin(12.0 * t)


def groups(found, alike, ranges=True):
    """Return the attractors of basins by another share of the range."""
    cases = sorted(found.verdicts)
    of_motions = [found.ranges_of(k) for k in cases] if ranges else None
    return attractors([found.points[k] for k in cases], [found.verdicts[k] for k in cases], alike, of_motions)


@pytest.fixture(scope="module")
def moved(tmp_path_factory):
    """Starts of the pendulum on a moved base, and their file."""
    path = tmp_path_factory.mktemp("moved") / "moved.map"
    axes = ("body.rod.angle", "-150 deg", "-85 deg"), ("body.rod.velocity.2", -5.0, 5.0)
    return basins(on_moved_base(), *axes, count=(6, 5), file=path), path


def test_one_motion_is_not_several(moved):
    """The onset lies elsewhere in its step each time: the range of all points is that scatter, and splits
    the motion, as a much narrower criterion does.
    """
    found, _ = moved
    assert [(motion.kind, len(motion.members)) for motion in found.attractors] == [("period 1", 30)]
    assert found.agreement == "10 of 10 companions alike"
    assert len(groups(found, ALIKE_POINTS, ranges=False)) > 1 and len(groups(found, 1e-6)) > 1
    speeds = [found.points[k][-1, 0] for k in range(30)]
    known = [
        last_speed((found.spec.x[k % 6], found.spec.y[k // 6]), 12.0, -170.0, -80.0, moved_base)
        for k in (0, 14, 29)
    ]
    assert np.ptp(known) < 1e-5
    assert speeds == pytest.approx([known[0]] * 30, abs=1e-3 * found.ranges_of(0)[0])


def test_a_file_has_the_ranges_and_the_companions_points(moved):
    found, path = moved
    again = load_map(path)
    assert all(np.array_equal(again.ranges[k], found.ranges[k]) for k in range(30))
    assert all(
        np.array_equal(one.points, other.points) and len(one.points) == 20
        for one, other in zip(again.companions, found.companions, strict=True)
    )
    assert str(again) == str(found)
    # The range of the speed within a turn is known from a run, too.
    run = vfife.simulate(on_moved_base(), turns=40)
    speeds = run.series["rod.angular_velocity"].values
    speeds = speeds[-(len(speeds) // 40) :]
    assert found.ranges_of(0) == pytest.approx([np.ptp(speeds)], rel=0.1)


def test_files_without_ranges_are_read(moved):
    found, _ = moved
    former = dataclasses.replace(
        found,
        ranges={},
        companions=tuple(dataclasses.replace(one, points=np.zeros((0, 1))) for one in found.companions),
    )
    assert former.share == ALIKE_POINTS and len(former.attractors) == 1
    assert former.agreement == "10 of 10 companions alike"


def test_coexisting_motions_stay_apart():
    """Two motions, each start at the one that an integration reaches; a criterion as wide as their distance
    makes them one.
    """
    axes = ("body.rod.angle", "-100 deg", "-77 deg"), ("body.rod.velocity.2", 2.0, 5.0)
    found = basins(forced(), *axes, count=(4, 3))
    known = np.array(
        [
            last_speed(start, 6.0, -150.0, -70.0, lambda t, angle: 0.5 * math.cos(6.0 * t))
            for start in ((x, y) for y in found.spec.y for x in found.spec.x)
        ]
    )
    first = np.abs(known - known[0]) < 0.1
    assert 0 < first.sum() < 12 and np.ptp(known[first]) < 1e-3 and np.ptp(known[~first]) < 1e-3
    assert len(found.attractors) == 2 and {motion.kind for motion in found.attractors} == {"period 1"}
    labels = found.labels.reshape(-1)
    assert set(labels[first]) != set(labels[~first]) and len(set(labels[first])) == 1
    assert len(groups(found, 1.0)) == 1
    reached = np.array([motion.points[0, 0] for motion in found.attractors])[labels.astype(int)]
    assert reached == pytest.approx(known, abs=0.01)
    # A companion that reaches the other motion does not agree, although both have period 1.
    case = found.companions[0]
    elsewhere = next(k for k in range(12) if labels[k] != labels[case.number])
    swapped = dataclasses.replace(case, points=found.points[elsewhere])
    other = dataclasses.replace(found, companions=(swapped, *found.companions[1:]))
    assert other.agreement == "9 of 10 companions alike" and found.agreement == "10 of 10 companions alike"
    assert "times the step another motion of period 1" in " ".join(str(other).split())


def test_motions_of_a_law_with_a_memory_stay_apart():
    """The journal never leaves its bearing, and each past leads to its own motion: over more than ten times
    the error of the step.
    """
    friction = {"law": "ambrosio", "coefficient": 0.1}
    model = load(
        "examples/slider_crank_loose_pin.toml",
        set=[
            ("joint.pin.contact.restitution", 0.5),
            ("joint.pin.clearance", 3e-4),
            ("joint.pin.friction", friction),
        ],
    )
    axes = ("start.pin.x", -1.35e-4, 1.35e-4), ("start.pin.vy", -0.3, 0.3)
    found = basins(model, *axes, count=(6, 4), turns=150, step=7e-6, companions=3)
    assert len(found.attractors) >= 5 and found.share < 0.5 * ALIKE_POINTS
    assert len(groups(found, 0.03)) == 1


def motions(*points):
    rows = [np.asarray(one, dtype=float)[:, None] for one in points]
    decays = exponent(np.full(30, -0.5))
    return rows, [verdict(one, decays) for one in rows]


def test_motions_that_have_not_settled_belong_to_the_one_they_reach():
    """Of a range of 1: a motion of period 1, one that approaches it, and one that does not come near."""
    steady = np.full(30, 2.0)
    near, far = (2.0 + size * 0.93 ** np.arange(30) * np.cos(2.4 * np.arange(30)) for size in (0.005, 0.05))
    rows, found = motions(steady, steady, near, far)
    assert [one.kind for one in found] == ["period 1", "period 1", "not settled", "not settled"]
    ranges = [np.ones(1)] * 4
    assert [one.members for one in attractors(rows, found, 0.01, ranges)] == [(0, 1, 2), (3,)]
    assert [one.members for one in attractors(rows, found, 0.001, ranges)] == [(0, 1), (2, 3)]
    assert [one.members for one in attractors(rows, found, 0.1, ranges)] == [(0, 1, 2, 3)]
    grown = [dataclasses.replace(one, exponent=exponent(np.full(30, 0.02))) for one in found]
    assert [one.members for one in attractors(rows, grown, 0.01, ranges)] == [(0, 1), (2, 3)]


def test_a_difference_that_rotates_decays_over_all_turns():
    """Points that alternate within the tolerance about those of period 1, from which a difference decays by
    a mean of 0.07, but in half of the turns hardly: both are one motion.
    """
    rows, found = motions(np.full(40, 2.0), np.resize([2.0, 2.004], 40))
    for halves, members in (((-0.1, -0.04), [(0, 1)]), ((-0.04, -0.04), [(0,), (1,)])):
        growth = exponent(np.repeat(halves, 20))
        swinging = [dataclasses.replace(one, exponent=growth) for one in found]
        assert [one.members for one in attractors(rows, swinging, 0.01, [np.ones(1)] * 2)] == members


def test_a_period_of_steps_is_the_motion_itself_and_chaos_never_is():
    rows, found = motions(
        np.full(30, 2.0), np.full(30, 2.0), np.resize([2.0, 2.004], 30), np.resize([2.0, 2.3], 30)
    )
    ranges = [np.ones(1)] * 4
    assert [one.kind for one in found][2:] == ["period 2", "period 2"]
    assert [one.members for one in attractors(rows, found, 0.01, ranges)] == [(0, 1, 2), (3,)]
    chaos = dataclasses.replace(found[2], kind="chaotic", period=None)
    assert len(attractors(rows[:3], [*found[:2], chaos], 0.01, ranges[:3])) == 2


def test_the_share_is_that_of_most_companions():
    assert (
        step_share([]) == ALIKE_POINTS
        and step_share([1e-5] * 3) == 1e-3
        and step_share([1.0]) == ALIKE_POINTS
    )
    assert step_share([1e-3, 1e-3, 0.5]) == pytest.approx(4e-3)
    one, two = (
        ("period 2", np.resize([1.0, 3.0], 9)[:, None]),
        ("not settled", np.resize([3.02, 1.0], 9)[:, None]),
    )
    assert change(one, two, np.array([4.0])) == pytest.approx(0.005) == change(two, one, np.array([4.0]))
    assert change(one, ("chaotic", two[1]), np.ones(1)) is None and change(two, two, np.ones(1)) is None
    assert same_motion(one, two, np.array([0.021])) and same_motion(two, one, np.array([0.021]))
    assert not same_motion(one, two, np.array([0.019])) and same_motion(two, two, np.zeros(1))


def test_a_harmonic_base_is_refused_with_a_recipe_and_the_recipe_is_the_same_motion():
    m = pendulum(-170.0, -80.0)
    car = m.rigid_body("car", mass=1.0, inertia=0.01, position=(0.0, 0.0))
    m.slider("rail", m.point("O", 0.0, 0.0), car.pin())
    m.revolute("hinge", car.pin(), m.bodies["rod"].start)
    m.harmonic(slider="rail", amplitude=0.03, frequency=12.0 / (2.0 * math.pi))
    with pytest.raises(vfife.errors.ModelError, match="drive a crank that moves it as a Scotch yoke"):
        vfife.dynamics.poincare_section(m)
    end = 4.0 * math.pi / 12.0  # two periods
    runs = [vfife.simulate(model, duration=end, step=5e-5) for model in (m, on_moved_base())]
    angles = [run.series["rod.angle"].values[-1] for run in runs]
    assert angles[0] == pytest.approx(angles[1], abs=2e-3)
