"""Exponents and derivatives of motions whose contact force jumps at the onset: against an integration of a
pendulum with its variational equations and the saltation matrix (DOP853, rtol 1e-9), against two neighbouring
motions, which need no derivative, and against finite changes.
"""

import math

import numpy as np
import pytest

import vfife
from vfife.assembly.assemble import assemble
from vfife.dynamics.sections import poincare_section
from vfife.kernels.jumps import TOUCH
from vfife.laws import ContactLaw, KelvinVoigt
from vfife.measures.chaos import exponent, verdict
from vfife.modelfile import dump
from vfife.modelfile.parameter import numbers
from vfife.simulation.turn_steps import with_steps
from vfife.solvers.tangents import force_jumps, tangents
from vfife.solvers.transient import run
from vfife.solvers.turn_runner import TurnRunner
from vfife.studies.methods.finite_difference import Variants

ROUND = 0.02  # m, radius of the pendulum's end
# Exponents of the integration: the logarithm of the multipliers of the periodic motion, which are complex in
# all four; of the plane also the mean of the logarithms of a difference over 133 turns, which its rotation
# shifts.
STOPS = {5.0: -0.7306, 0.5: -0.3076, 0.0: -0.1885}
PLANE = (-0.8563, -0.862)


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


@pytest.mark.parametrize("damping", STOPS)
def test_the_exponent_of_a_damped_stop_contains_the_jump_of_its_moment(damping):
    """Without the jump it is +1.48, +0.75 and -0.185, and the motion is called chaotic."""
    found = poincare_section(stopped(damping), turns=200, step=2e-4)
    assert found.exponent.value == pytest.approx(STOPS[damping], abs=0.006)
    assert found.exponent.low < STOPS[damping] < found.exponent.high
    assert found.verdict.kind == "period 1"
    title = " ".join(found.plot()._suptitle.get_text().split())
    assert "range of the exponent with half the step" in title and "companions" not in title


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


def test_the_range_of_an_exponent_holds_the_rotation_of_the_difference():
    """Both step sizes agree by chance here, to within the swing of the difference about the exponential."""
    found = poincare_section(on_plane(), turns=120, step=1.25e-4).exponent
    assert all(found.low < known < found.high for known in PLANE)
    found = poincare_section(stopped(5.0), turns=200, step=4e-4).exponent
    assert found.low < STOPS[5.0] < found.high


def between_stops(moment: float, speed: float, limits: tuple[float, float], dampers: tuple[float, float]):
    """A pendulum of 0.3 m and 0.5 kg between two stops of 1500 N m/rad at angles ``limits`` (rad);
    ``dampers`` (N m s/rad) of the air and of the stops.
    """
    m = vfife.Mechanism("between stops", gravity=(0, -9.81))
    rod = m.link("rod", length=0.3, mass=0.5, angle="-90 deg")
    m.revolute("hinge", m.point("P", 0, 0), rod.start)
    m.torsional_spring("air", "ground", "rod", damping=dampers[0])
    low, high = limits
    m.stop("wall", "ground", "rod", low=low, high=high, stiffness=1500.0, damping=dampers[1])
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0))
    m.revolute("shaft", m.point("Q", 0.5, 0), rotor.pin())
    m.drive(rotor, speed=speed)
    angles = [0, "360 deg"]
    m.moment("force", "rod.end", moment=moment, expression="cos(angle)", crank="rotor", angles=angles)
    return m


@pytest.mark.parametrize(
    ("moment", "speed", "limits", "dampers", "known"),
    [
        (0.589, 6.1, (-2.86, -0.986), (0.005, 0.5), -0.6486),
        (0.604, 4.67, (-2.92, -1.346), (0.02, 0.2), -0.1872),
    ],
)
def test_the_exponent_contains_the_time_at_which_blows_begin_and_end(moment, speed, limits, dampers, known):
    """Inside a step the stiffness of a stop acts for a part of it. With whole steps the exponents of these
    two and three blows a turn are -0.23 and -1.02, and their ranges leave out those of the multipliers. The
    mirror image has the same exponent.
    """
    low, high = limits
    mirrored = between_stops(-moment, speed, (-math.pi - high, -math.pi - low), dampers)
    for mechanism in (between_stops(moment, speed, limits, dampers), mirrored):
        found = poincare_section(mechanism, turns=120)
        assert found.verdict.kind == "period 1"
        assert found.exponent.value == pytest.approx(known, abs=0.03)
        assert found.exponent.low < known < found.exponent.high


@pytest.mark.parametrize(
    ("model", "path"),
    [("stop", "load.drive.moment"), ("stop", "spring.stop.high"), ("plane", "load.drive.moment")],
)
def test_derivatives_of_curves_contain_the_jump(model, path):
    """Angles over four turns, beside changes of 0.3 %."""
    mechanism = stopped(5.0) if model == "stop" else on_plane()
    assembly = assemble(mechanism, 1e-4, turns=4, force_step=True)
    variants, value = Variants(dump(mechanism), assembly), numbers(mechanism)[path]
    (direction,) = variants.directions({path: value})[0]
    [pairs] = tangents(assembly, [direction.neighbours])
    size = 3e-3 * abs(value)
    sides = [run(variants.with_number(path, value, value + sign * size)) for sign in (1.0, -1.0)]
    up, down = (
        record.rows[:, np.isin(record.row_numbers, assembly.layout.rows_of("particle_theta"))]
        for record in pairs[0]
    )
    more, less = (
        record.rows[:, np.isin(record.row_numbers, assembly.layout.rows_of("particle_theta"))]
        for record in sides
    )
    slopes, quotients = (up - down) / direction.neighbours.distance, (more - less) / (2.0 * size)
    assert np.abs(slopes - quotients).max() < 0.1 * np.abs(quotients).max()


def test_the_sensitivity_of_a_damped_stop_is_that_of_finite_changes():
    """Without the jump derivatives are 240 times as large, and finite changes take their place."""
    found = vfife.sensitivity(
        stopped(5.0), of="hinge.force.max", to=("body.rod.length", "load.drive.moment"), turns=3, step=5e-5
    )
    for derivative in found.derivatives:
        assert derivative.kinds["hinge.force.max"] == "derivative"
        change = derivative.changes["hinge.force.max"]
        assert derivative.values["hinge.force.max"] == pytest.approx(change, rel=0.05)


def test_a_force_that_jumps_is_found_in_the_model():
    assert force_jumps(with_steps(stopped(5.0), 1000)) and force_jumps(with_steps(on_plane(), 1000))
    assert not force_jumps(with_steps(stopped(0.0), 1000))
    assert not force_jumps(with_steps(vfife.gallery.slider_crank_loose_pin(), 1000))


def test_a_cloud_that_scatters_with_the_step_is_not_called_chaotic():
    """All motions have period 1; the 0-1 test, without an exponent, called 64 of 64 such starts chaotic."""
    axes = ("body.rod.angle", "-150 deg", "-75 deg"), ("load.drive.moment", 0.7, 1.2)
    found = vfife.dynamics.basins(
        stopped(5.0), *axes, count=(2, 2), step=4e-4, exponents=False, turns=300, companions=0
    )
    assert {motion.kind for motion in found.verdicts.values()} == {"not decided"}
    assert "as those of a periodic motion do that scatter with the step" in found.verdicts[0].evidence
    decided = vfife.dynamics.basins(stopped(5.0), *axes, count=(2, 2), step=4e-4, companions=0)
    assert {motion.kind for motion in decided.verdicts.values()} == {"period 1"}


def test_few_turns_of_a_basin_do_not_show_chaos_where_another_start_is_regular():
    """Of the same pendulum, weakly driven: one start comes to rest, others stay chaotic for 400 turns."""
    axes = ("body.rod.angle", "-150 deg", "-75 deg"), ("load.drive.moment", 16 / 35, 0.46)
    kinds = []
    for turns in (60, 300):
        found = vfife.dynamics.basins(stopped(5.0), *axes, count=(8, 1), step=4e-4, turns=turns, companions=0)
        kinds.append({motion.kind for motion in found.verdicts.values()})
        if turns == 60:
            words = [motion.evidence for motion in found.verdicts.values() if motion.kind == "not decided"]
            assert (
                "3 of 8 starts are not decided, because only 20 turns of each are recorded: record 100"
                " or more (turns = 300" in " ".join(str(found).split())
            )
    assert kinds == [{"not decided", "not settled"}, {"chaotic", "period 1"}]
    assert "over 20 turns" in words[0] and "decays from another start" in words[0]


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
    text = " ".join(str(found).split())
    assert "Errors of points and of values at which the motion changes (values are 1 deg apart)" in text
    assert "with the errors collected so far; companions repeat a value from that state" in text


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
        stopped(5.0), "spring.stop.high", "-80 deg", "-70 deg", count=2, turns=30, step=1e-3, companions=0,
        file=path,
    )  # fmt: skip
    for result in (found, vfife.dynamics.load_map(path)):
        text = " ".join(str(result).split())
        assert "from -80 deg to -70 deg" in text and " rad" not in text
        axis = result.plot().axes[-1]
        assert axis.get_xlabel() == "spring.stop.high (deg)" and axis.get_xlim()[0] < -79.0


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


@pytest.mark.parametrize(
    ("amplitude", "turns", "kind"),
    [
        (1.4, 150, "not decided"),
        (1.4, 300, "not decided"),
        (1.07, 300, "not decided"),
        (0.93, 300, "chaotic"),
        (1.345, 300, "chaotic"),
    ],
)
def test_long_periods_at_the_end_of_a_cascade_are_not_called_chaotic(amplitude, turns, kind):
    """An integration that locates the stop finds period 32 at 1.4 N m and period 48 at 1.07 N m (exponents
    -0.005 and -0.038), and chaos at the others (docs: Periodic or chaotic).
    """
    m = vfife.Mechanism("forced pendulum", gravity=(0, -9.81))
    rod = m.link("rod", length=0.3, mass=0.5, angle="-90 deg")
    m.revolute("hinge", m.point("P", 0, 0), rod.start)
    m.torsional_spring("air", "ground", "rod", damping="0.01 N m s/rad")
    m.stop(
        "wall", "ground", "rod",
        low="-150 deg", high="-70 deg", stiffness="400 N m/rad", damping="0.5 N m s/rad",
    )  # fmt: skip
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0))
    m.revolute("shaft", m.point("Q", 0.5, 0), rotor.pin())
    m.drive(rotor, speed=6.0)
    m.moment(
        "force", "rod.end",
        moment=amplitude, expression="cos(angle)", crank="rotor", angles=[0, "360 deg"],
    )  # fmt: skip
    found = poincare_section(m, turns=turns)
    assert found.verdict.kind == kind, str(found.verdict)
    assert f"forced pendulum: {kind}" in " ".join(str(found).split())
