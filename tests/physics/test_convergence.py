"""The order of convergence: 2.00 without contact, and what it honestly is with contact."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from support import SQUARE, finer, four_bar, go, observed, order, particle, went, with_settings
from vfife.assembly.assemble import assemble
from vfife.laws import Material
from vfife.model.bodies import Section
from vfife.model.mechanism import Mechanism, StartSettings


def pendulum(angle: float = math.pi) -> Mechanism:
    """A uniform rod whose centre of oscillation is 1 m from the pivot: the rigid pendulum of method.md,
    section 5.
    """
    m = Mechanism("pendulum", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.5, mass=1.0, angle=angle)
    m.revolute("A", "ground.O", "rod.start")
    return m


# Place of the mass (m) at a time (s), from (-1, 0) at rest, and the period (s): method.md, section 5.
PENDULUM = {1: (0.986291751, -0.165010853), 5: (-0.942305435, -0.334754338)}
PERIOD = 2.36784194758


@pytest.mark.parametrize("second", PENDULUM)
def test_rigid_pendulum(second):
    """Where the pendulum is after 1 s and after 5 s, and that each halving of the step quarters the error."""

    def error(step: float) -> float:
        theta = particle(go(pendulum(), step, duration=float(second), outputs=1), "rod")["theta"][-1]
        return math.hypot(math.cos(theta) - PENDULUM[second][0], math.sin(theta) - PENDULUM[second][1])

    errors = observed(error, (4e-3, 2e-3, 1e-3, 5e-4))
    assert order(errors) == pytest.approx([2.0] * 3, abs=0.05)
    assert error(5e-5) < 5e-8


def test_period_of_the_pendulum():
    """Angle at rest again after a period; found from where the angular velocity changes its sign."""
    record = go(pendulum(), 2e-4, duration=2.4, outputs=12000)
    w, step = particle(record, "rod")["w"], 2e-4
    (turning,) = np.flatnonzero((w[100:-1] < 0) & (w[101:] >= 0)) + 100
    at = (turning + 0.5 + w[turning] / (w[turning] - w[turning + 1])) * step
    assert at == pytest.approx(PERIOD, abs=1e-6)


def spring(
    stretch_stiffness: float,
    *,
    path_unit: int = 1,
    gravity: float = 9.81,
    angle: float = 0.3,
    strain: str = "reference",
) -> Mechanism:
    """A bar as a spring, 1 m long, 1 kg at its free end, hung at its other end, unstressed at rest."""
    m = Mechanism("spring", gravity=(0.0, -gravity), start=StartSettings(mode="rough"))
    m.point("O", 0.0, 0.0)
    rubber = Material("rubber", stretch_stiffness / 1e-4, 0.3, 1000.0)
    kind = {"model": "two-particle", "release": "both", "strain": strain}
    m.link("bar", length=1.0, mass=2.0, angle=angle, section=Section.square(1e-4), material=rubber, **kind)
    m.revolute("A", "ground.O", "bar.start")
    return with_settings(m, path_unit=path_unit)


def test_spring_and_mass():
    """A bar that hangs down and is let go: x = (g/w^2)(1 - cos w t), three and a half periods."""
    ea, g = 5e6, 9.81
    w = math.sqrt(ea)
    end = 7 * math.pi / w - 2e-4

    def error(count: int) -> float:
        record = go(spring(ea, angle=-0.5 * math.pi), end / count, duration=end, outputs=1)
        return abs(-particle(record, "bar", 1)["y"][-1] - 1 - g / w**2 * (1 - math.cos(w * end)))

    errors = [error(count) for count in (200, 400, 800)]
    assert errors[-1] < 1e-3 * g / w**2
    assert order(errors) == pytest.approx([2.0] * 2, abs=0.05)


@pytest.mark.parametrize("ea", [500.0, 5000.0])
def test_elastic_pendulum(ea):
    """Swinging, stretched by up to 7 % (EA = 500 N), against SciPy; one path unit for the whole run, N = EA
    (l - l0)/l0.
    """

    def motion(t, y):
        length = math.hypot(y[0], y[1])
        pull = ea * (length - 1) / length
        return [y[2], y[3], -pull * y[0], -pull * y[1] - 9.81]

    solved = solve_ivp(
        motion, (0, 1), [math.cos(0.3), math.sin(0.3), 0, 0], method="DOP853", rtol=1e-12, atol=1e-13
    )

    def error(step: float) -> float:
        end = particle(go(spring(ea, path_unit=10**6), step, duration=1.0, outputs=1), "bar", 1)
        return math.hypot(end["x"][-1] - solved.y[0, -1], end["y"][-1] - solved.y[1, -1])

    assert order(observed(error, (1e-3, 5e-4, 2.5e-4, 1.25e-4))) == pytest.approx([2.0] * 3, abs=0.05)


def test_what_a_path_unit_of_one_step_costs():
    """Honestly: increments EA dl/l_a add EA/2 (dl/l_a)^2 each step to the logarithmic strain, a tension that
    grows as EA dt/2 times the integral of (l'/l)^2. Where a spring stretches by much, the order falls to one.
    """
    step, ea = 1e-3, 500.0
    record = go(spring(ea, strain="current"), step, duration=1.0, outputs=1000)
    x, y = particle(record, "bar", 1)["x"], particle(record, "bar", 1)["y"]
    length = np.hypot(x, y)
    excess = record.block("frame_axial_force")[-1, 0] - ea * math.log(length[-1])
    expected = ea * 0.5 * (np.diff(length) / length[:-1]) @ (np.diff(length) / length[:-1])
    assert excess == pytest.approx(expected, rel=0.05)
    assert 5e-3 < expected < 1e-3 * np.abs(record.block("frame_axial_force")).max()


@pytest.mark.parametrize(
    ("clear", "most"),
    [
        pytest.param("C", 2e-8, id="case b"),
        pytest.param(
            "BCD", 1e-5, id="case c", marks=pytest.mark.system("a turn with 32 times as many steps")
        ),
    ],
)
def test_errors_fall_with_contact(clear, most):
    """Places (m, rad) of cases b and c after one turn, steps from 2 us to 1/16 us, against 1/32 us.

    They fall by two powers of the step in the mean, unevenly, for where in its step an event falls is chance;
    ``test_steps_with_events`` has the slope over many steps.
    """

    def places(step: float) -> np.ndarray:
        record = go(four_bar(clear), step, duration=0.04, outputs=1)
        return np.array(
            [
                particle(record, name)[axis][-1]
                for name in ("coupler", "follower")
                for axis in ("x", "y", "theta")
            ]
        )

    finest = places(2e-6 / 64)
    errors = [np.abs(places(2e-6 / 2**k) - finest).max() for k in (0, 1, 2, 3, 4, 5)]
    assert errors[0] < most
    assert math.log2(errors[0] / errors[-1]) / 5 > 1.1
    assert max(errors[3:]) < max(errors[:3])


def test_elastic_links_converge():
    """Elastic four-bar with ideal joints, stretched and bent from the start: places after a quarter turn."""

    start = assemble(
        four_bar("", "two-particle", section=SQUARE), 2e-6, duration=0.01, outputs=1, force_step=True
    )

    def places(times: int) -> np.ndarray:
        record = went(finer(start, times))
        return np.array(
            [
                particle(record, name, k)[axis][-1]
                for name in ("coupler", "follower")
                for k in (0, 1)
                for axis in ("x", "y")
            ]
        )

    finest = places(32)
    errors = [np.abs(places(times) - finest).max() for times in (1, 2, 4, 8)]
    assert math.log2(errors[0] / errors[-1]) / 3 == pytest.approx(2.0, abs=0.2)
