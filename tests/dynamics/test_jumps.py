"""Exponents of motions whose contact force jumps at the onset: against an integration of a pendulum with its
variational equations and the saltation matrix (DOP853, rtol 1e-9, 133 turns), and against two neighbouring
motions, which need no derivative.
"""

import math

import numpy as np
import pytest

import vfife
from vfife.dynamics.sections import poincare_section
from vfife.kernels.jumps import TOUCH
from vfife.laws import ContactLaw, KelvinVoigt
from vfife.measures.chaos import exponent, verdict
from vfife.simulation.turn_steps import with_steps
from vfife.solvers.turn_runner import TurnRunner

ROUND = 0.02  # m, radius of the pendulum's end


def pendulum(start: float = -90.0) -> vfife.Mechanism:
    """A forced pendulum beside a clock: 0.5 m, 1 kg, 0.8 cos(4 t) N m."""
    m = vfife.Mechanism("pendulum", gravity=(0.0, -9.81))
    clock = m.link("clock", length=0.1, mass=0.1)
    m.revolute("clockpin", m.point("Q", 0.0, -1.0), clock.start)
    m.drive(clock, speed=4.0)
    rod = m.link("rod", length=0.5, mass=1.0, angle=f"{start!r} deg")
    m.revolute("hinge", m.point("P", 0.0, 0.0), rod.start)
    m.torsional_spring("damper", "ground", "rod", stiffness=0.0, damping=0.02)
    angles = [0, "360 deg"]
    m.moment("drive", rod.end, moment="1 N m", crank="clock", angles=angles, expression="0.8*cos(angle)")
    return m


def stopped(damping: float, high: str = "-70 deg", start: float = -90.0) -> vfife.Mechanism:
    """The pendulum with a stop."""
    m = pendulum(start)
    m.stop("stop", "ground", "rod", low="-400 deg", high=high, stiffness=2e3, damping=damping)
    return m


def on_plane() -> vfife.Mechanism:
    """The pendulum with a plane of the law of Kelvin and Voigt at the same angle."""
    m, angle = pendulum(), math.radians(-70.0)
    end = 0.5 * np.array([math.cos(angle), math.sin(angle)])
    normal = np.array([math.sin(angle), -math.cos(angle)])
    law = KelvinVoigt(stiffness=2e4, damping_coefficient=40.0)
    m.external_contact(
        "plane", m.point("W", *(end - ROUND * normal).tolist()), m.bodies["rod"].end, journal_radius=ROUND,
        direction=(float(normal[1]), -float(normal[0])), contact=law, friction="none",
    )  # fmt: skip
    return m


@pytest.mark.parametrize(
    ("damping", "known", "tolerance"), [(5.0, -0.740, 0.03), (0.5, -0.317, 0.03), (0.0, -0.195, 0.02)]
)
def test_the_exponent_of_a_damped_stop_contains_the_jump_of_its_moment(damping, known, tolerance):
    """Without the jump it is +1.48, +0.75 and -0.185, and the motion is called chaotic."""
    found = poincare_section(stopped(damping), turns=200, step=2e-4)
    assert found.exponent.value == pytest.approx(known, abs=tolerance)
    assert found.verdict.kind == "period 1"


def test_points_that_scatter_with_the_step_are_periodic():
    found = poincare_section(stopped(5.0), turns=90, step=2e-4)
    assert found.verdict.distance > 0.1 and found.verdict.scatter < 1e-3
    assert "of the motion's range, and scatter with the step" in " ".join(str(found).split())
    assert "no contacts" not in str(found) and "contact at the stop stop" in " ".join(str(found).split())


def test_the_exponent_of_a_contact_contains_the_jump_of_its_force():
    """Kelvin and Voigt: -0.862 per turn; without the jump +2.08."""
    found = poincare_section(on_plane(), turns=120, step=1e-4)
    assert found.exponent.value == pytest.approx(-0.862, abs=0.03)
    assert found.verdict.kind == "period 1"


def test_neighbouring_motions_approach_each_other_as_the_exponent_says():
    """Two motions 5e-3 rad apart, far more than the pendulum turns in a step (2e-4 rad)."""
    steps, turns = 16_000, 4
    runners = [TurnRunner([with_steps(stopped(5.0, start=start), steps)]) for start in (-90.0, -89.7)]
    for runner in runners:
        runner.begin()
        runner.skip(5)
    layout = with_steps(stopped(5.0), steps).layout
    rows = layout["particle_theta"]

    def distance() -> float:
        return float(np.abs(runners[0].states[rows, 0] - runners[1].states[rows, 0]).max())

    first = distance()
    for runner in runners:
        runner.skip(turns)
    assert distance() < 0.3 * first


def test_a_difference_begins_where_its_parameter_has_an_effect():
    """The stop is touched every second turn only: in the first turn a change of its limit changes nothing."""
    found = vfife.bifurcation(
        stopped(5.0), "spring.stop.high", "-52 deg", "-51 deg", count=2, turns=60, step=3e-4, companions=0
    )
    assert np.isfinite(found.exponents).all()
    assert (found.exponents[..., 0] < 0.0).all() and (found.exponents[..., 0] > -2.0).all()
    assert {kind for way in found.kinds for kind in way} == {"period 2"}


def test_a_difference_that_vanished_has_no_number():
    """Files of former versions hold ln 1e-300."""
    found = exponent([-0.5, -690.775528, -0.5, -0.4])
    assert found.value == -math.inf and "-690" not in found.words and "below any number" in found.words
    assert verdict(np.tile([0.1, 0.7], 20), found).kind == "period 2"
    assert "not estimated" in exponent([math.nan, -0.1, -0.2]).words


def test_companions_of_a_speed_begin_at_the_same_angle():
    """With the time of the speed before, the crank would be elsewhere, and all motions diverge."""
    found = vfife.bifurcation(
        vfife.gallery.slider_crank_loose_pin(), "driver.crank.speed", 96.0, 104.0, count=4, turns=12,
        step="2 us", companions=4,
    )  # fmt: skip
    assert len(found.companions) == 16
    assert not [companion for companion in found.companions if companion.kind == "diverged"]


def test_values_come_back_in_the_unit_of_the_range(tmp_path):
    """Angles in degrees, in the text, on the axis and from the file."""
    path = tmp_path / "stop.map"
    found = vfife.bifurcation(
        stopped(5.0), "spring.stop.high", "-90 deg", "-70 deg", count=2, turns=30, step=2e-3, companions=0,
        file=path,
    )  # fmt: skip
    for result in (found, vfife.dynamics.load_map(path)):
        text = " ".join(str(result).split())
        assert "from -90 deg to -70 deg" in text and " rad" not in text
        axis = result.plot().axes[-1]
        assert axis.get_xlabel() == "spring.stop.high (deg)" and axis.get_xlim()[0] < -89.0


def test_a_law_that_jumps_is_found_by_its_value():
    """Every contact law at the least penetration: only springs with dampers beside them push there."""
    jumping = set()
    for name, law in ContactLaw.registry.items():
        slots = tuple(1.0 for _ in law.slots)
        if not getattr(law, "tabled", False):
            elastic, damping = law.force(TOUCH, 1.0, slots)
            assert math.isfinite(elastic) and math.isfinite(damping)
            if max(abs(elastic), abs(damping)) > 1e-100:
                jumping.add(name)
    assert jumping == {"kelvin-voigt", "anagnostopoulos"}
