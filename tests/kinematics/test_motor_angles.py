"""A body that a torque turns starts at its angle, as a body does whose motion is prescribed."""

import math

import numpy as np
import pytest

from kinematics.test_ideal_motion import slider_crank
from vfife.assembly.assemble import assemble
from vfife.cli.commands.new import templates
from vfife.kinematics.initial import ideal_motion, ideal_motions
from vfife.model.drivers import Torque
from vfife.model.mechanism import Mechanism
from vfife.modelfile.read import load_model
from vfife.report.check import bodies
from vfife.results.continuation import start_from

DEGREE = math.pi / 180.0


def motor_crank(angle=20.0, reach=0.2, hand=1.0, torque=True):
    """A slider-crank of 50 and 150 mm whose block is guessed at ``reach`` (m) on a level guide."""
    m = Mechanism("motor")
    m.point("O", 0.0, 0.0)
    m.point("anchor", -0.1, 0.05)
    m.link("crank", length=0.05, mass=0.5, angle=hand * angle * DEGREE)
    m.link("rod", length=0.15, mass=0.2)
    m.point_mass("block", mass=0.6, position=(reach, 0.0))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("P", "crank.end", "rod.start")
    m.revolute("pin", "rod.end", "block.center")
    m.slider("guide", "ground.O", "block.center", turning=True)
    m.spring("return", "ground.anchor", "block.center", stiffness=200.0)
    if torque:
        m.torque("crank", value=2.0)
    return m


@pytest.mark.parametrize("reach", [0.15, 0.18, 0.2, 0.22])
def test_the_guesses_of_other_bodies_leave_the_crank_of_a_motor_alone(reach):
    motion = ideal_motion(motor_crank(reach=reach))
    s, c = math.sin(20.0 * DEGREE), math.cos(20.0 * DEGREE)
    block = 0.05 * c + math.sqrt(0.15**2 - (0.05 * s) ** 2)
    assert motion.of("crank")[0][2] == pytest.approx(20.0 * DEGREE, abs=1e-13)
    assert motion.of("block")[0][:2] == pytest.approx((block, 0.0), abs=1e-12)
    # The free length of a spring is that of the same start.
    assert motion.datum.spring["return"] == pytest.approx(math.hypot(block + 0.1, 0.05), abs=1e-12)


def test_without_a_torque_every_guess_moves():
    assert abs(ideal_motion(motor_crank(torque=False)).of("crank")[0][2] / DEGREE - 20.0) > 0.5


def test_batches_mirror_images_and_former_motions_start_from_the_same_bits():
    alone = [ideal_motion(motor_crank(angle, reach)) for angle, reach in ((20.0, 0.2), (30.0, 0.18))]
    free = ideal_motion(motor_crank(torque=False))
    group = [motor_crank(20.0, 0.2), motor_crank(30.0, 0.18)]
    for motion, same in zip(alone, ideal_motions(group, former=[free, free]), strict=True):
        assert np.array_equal(motion.position, same.position)
    image = ideal_motion(motor_crank(hand=-1.0)).position
    assert np.array_equal(image * (1.0, -1.0, -1.0), alone[0].position)


def test_a_given_start_is_not_moved():
    free, m = ideal_motion(motor_crank(torque=False)), motor_crank()
    state = {name: centred_on(m, name, free.of(name)[0]) for name in m.bodies}
    start = start_from(state, m)
    assert start.position == pytest.approx(free.position, abs=1e-9)


def centred_on(m, name, place):
    """Place of the frame of a body whose centre of mass is at a place."""
    x = m.bodies[name].length / 2 if hasattr(m.bodies[name], "length") else 0.0
    return place[0] - x * math.cos(place[2]), place[1] - x * math.sin(place[2]), place[2]


def test_the_template_of_gears_starts_upright():
    motion = ideal_motion(load_model(templates()["geared-five-bar"]))
    for body, angle in (("left", 90.0), ("right", 90.0)):
        assert motion.of(body)[0][2] == pytest.approx(angle * DEGREE, abs=1e-12)
    x, y, angle = motion.of("left-rod")[0]
    height = 0.08 + math.sqrt(0.22**2 - 0.125**2)
    assert (x + 0.11 * math.cos(angle), y + 0.11 * math.sin(angle)) == pytest.approx((0.125, height))


def four_bar(crank, rocker):
    m = Mechanism("two motors")
    m.point("A", 0.0, 0.0)
    m.point("D", 0.3, 0.0)
    m.link("crank", length=0.1, mass=0.5, angle=crank * DEGREE)
    m.link("coupler", length=0.25, mass=0.5, angle=0.3)
    m.link("rocker", length=0.2, mass=0.5, angle=rocker * DEGREE)
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    m.revolute("C", "coupler.end", "rocker.end")
    m.revolute("D", "ground.D", "rocker.start")
    return m


def test_motors_that_contradict_each_other_both_give_way_and_are_named():
    free, m = four_bar(60.0, 100.0), four_bar(60.0, 100.0)
    m.torque("crank", value=1.0)
    m.torque("rocker", value=-1.0)
    assert np.array_equal(ideal_motion(m).position, ideal_motion(free).position)
    notes = [note for note in assemble(m, 1e-4, duration=1e-3).notes if "deg, the model says" in note]
    assert [note.split(" starts at ")[0] for note in notes] == ["crank", "rocker"]
    given = [float(note.split("the model says ")[1].split(" deg")[0]) for note in notes]
    starts = [float(note.split("starts at ")[1].split(" deg")[0]) for note in notes]
    assert given == [60.0, 100.0]
    found = [ideal_motion(m).of(body)[0][2] / DEGREE for body in ("crank", "rocker")]
    assert starts == pytest.approx(found, abs=0.01)


def test_an_angle_of_zero_that_does_not_close_is_cautioned_about():
    m = four_bar(0.0, 0.0)
    m.torque("crank", value=1.0)
    m.torque("rocker", value=-1.0)
    notes = [note for note in assemble(m, 1e-4, duration=1e-3).notes if "(0 is the default)" in note]
    assert "rocker" in [note.split(" starts at ")[0] for note in notes]


def test_one_of_two_bodies_with_a_motor_suffices_and_nothing_is_said():
    m = four_bar(60.0, 100.0)
    m.torque("rocker", value=-1.0)
    assert ideal_motion(m).of("rocker")[0][2] == pytest.approx(100.0 * DEGREE, abs=1e-12)
    assert not [note for note in assemble(m, 1e-4, duration=1e-3).notes if "the model says" in note]


def test_a_torque_between_two_bodies_holds_none_and_is_cautioned_about():
    m = four_bar(60.0, 100.0)
    m.torque("crank", value=1.0, against="coupler")
    [note] = [note for note in assemble(m, 1e-4, duration=1e-3).notes if "the model says" in note]
    assert note.startswith("crank starts at ") and "it moved to close the joints" in note


def test_check_lists_what_turns_a_body():
    m = slider_crank(angle=0.3)
    m.drivers["motor"] = Torque(body="crank", value=2.0)
    told = {body["name"]: body["driver"] for body in bodies(assemble(m, 1e-4, duration=1e-3))}
    assert told == {"crank": "motor: torque 2 N m", "rod": None, "slider": None}
