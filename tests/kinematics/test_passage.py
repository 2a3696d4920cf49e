"""Whether a mechanism gets through what its drivers ask for: against Grashof's condition and closed forms of
dead positions.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from support import often
from vfife import gallery, simulate
from vfife.assembly.possible import outlook
from vfife.errors import AssemblyError
from vfife.kinematics.follower import Follower
from vfife.kinematics.full_turn import full_turns
from vfife.kinematics.initial import ideal_motion
from vfife.kinematics.mobility import classified
from vfife.kinematics.passage import passage
from vfife.model.bodies import Section
from vfife.model.drivers import Harmonic
from vfife.model.mechanism import Mechanism, Settings

SPEED = 10.0  # rad/s
TURN = 2.0 * math.pi / SPEED


def four_bar(ground, crank, coupler, rocker, angle=0.0, hand=1.0, play=0.0):
    """A four-bar that starts closed where it can: angles of coupler and rocker by the law of cosines."""
    bx, by = crank * math.cos(angle), crank * math.sin(angle)
    reach = math.hypot(ground - bx, by)
    cosine = (reach**2 + coupler**2 - rocker**2) / (2.0 * reach * coupler)
    towards = math.atan2(-by, ground - bx) + hand * math.acos(max(-1.0, min(1.0, cosine)))
    cx, cy = bx + coupler * math.cos(towards), by + coupler * math.sin(towards)
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", ground, 0.0)
    m.link("crank", length=crank, mass=1.0, angle=angle)
    m.link("coupler", length=coupler, mass=1.0, angle=towards)
    m.link("rocker", length=rocker, mass=1.0, angle=math.atan2(cy, cx - ground))
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    if play:
        m.clearance_joint("C", "coupler.end", "rocker.end", clearance=play, bearing_radius=0.01)
    else:
        m.revolute("C", "coupler.end", "rocker.end")
    m.revolute("D", "ground.D", "rocker.start")
    m.drive("crank", speed=SPEED)
    return m


def slider_crank(crank, rod, offset, angle=0.3):
    y = crank * math.sin(angle) - offset
    x = crank * math.cos(angle) + math.sqrt(rod**2 - y**2)
    m = Mechanism("slider-crank")
    m.point("O", 0.0, 0.0)
    m.point("guide", 0.0, offset)
    m.link("crank", length=crank, mass=1.0, angle=angle)
    m.link("rod", length=rod, mass=1.0, angle=-math.asin(y / rod))
    m.rigid_body("block", mass=1.0, inertia=1e-4, position=(x, offset))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("big-end", "crank.end", "rod.start")
    m.revolute("small-end", "rod.end", "block.center")
    m.slider("guide", "ground.guide", "block.center")
    m.drive("crank", speed=SPEED)
    return m


sizes = st.floats(0.1, 1.0)


@settings(max_examples=often(24), deadline=None)
@given(
    ground=sizes,
    crank=sizes,
    coupler=sizes,
    rocker=sizes,
    angle=st.floats(0.2, 3.0),
    hand=st.sampled_from([-1.0, 1.0]),
)
def test_a_crank_turns_fully_where_grashof_says_so(ground, crank, coupler, rocker, angle, hand):
    reach = math.sqrt(ground**2 + crank**2 - 2.0 * ground * crank * math.cos(angle))
    assume(abs(coupler - rocker) + 0.02 < reach < coupler + rocker - 0.02)  # it closes at the start
    lengths = sorted((ground, crank, coupler, rocker))
    assume(abs(lengths[0] + lengths[3] - lengths[1] - lengths[2]) > 0.01)  # no change point
    kind = classified(ground, crank, coupler, rocker)
    turns = "drag link" in kind or ("crank-rocker" in kind and crank < rocker)
    jam, passed = passage(four_bar(ground, crank, coupler, rocker, angle, hand), TURN, lengths=False)
    assert (jam is None, passed) == (turns, ())
    if (
        jam is not None
        # coupler and rocker in line, stretched or folded: the next such angle of the crank, by the law of
        # cosines
    ):
        cosines = [
            (ground**2 + crank**2 - (coupler + sign * rocker) ** 2) / (2.0 * ground * crank)
            for sign in (1.0, -1.0)
        ]
        ends = [
            side * math.acos(c) % (2.0 * math.pi) for c in cosines if abs(c) < 1.0 for side in (1.0, -1.0)
        ]
        after = min((end - angle) % (2.0 * math.pi) for end in ends)
        assert jam.aims[0] - angle == pytest.approx(after, abs=1e-4)
        assert jam.time == pytest.approx(after / SPEED, abs=1e-4 / SPEED)


@pytest.mark.system("bisects hundreds of mechanisms")
@pytest.mark.parametrize(("coupler", "rocker"), [(0.13, 0.22), (0.55, 0.22), (0.15, 0.24)])
def test_the_nearest_length_is_grashofs(coupler, rocker):
    """A crank of 0.1 m and pivots 0.3 m apart: |coupler - rocker| <= 0.2 m and coupler +
    rocker >= 0.4 m let it turn.
    """
    jam, _ = passage(four_bar(0.3, 0.1, coupler, rocker, 0.9 if coupler < 0.5 else 2.8), TURN)
    lengths = {name: then for name, _, then in jam.lengths}
    short = coupler + rocker < 0.4
    expected = {
        "coupler": 0.4 - rocker if short else rocker + 0.2,
        "rocker": 0.4 - coupler if short else coupler - 0.2,
    }
    assert {name: lengths[name] for name in expected} == pytest.approx(expected, rel=1e-9)
    assert jam.gap == pytest.approx(abs(coupler - expected["coupler"]), rel=1e-8)
    assert jam.joint == "C" and jam.joints == ("A", "B", "C", "D")
    assert math.cos(jam.widest[0]) == pytest.approx(-1.0 if short else 1.0, abs=1e-6)


@pytest.mark.system("bisects lengths")
@settings(max_examples=often(16), deadline=None)
@given(crank=st.floats(0.03, 0.1), rod=st.floats(0.05, 0.3), offset=st.floats(-0.05, 0.05))
def test_a_slider_crank_turns_where_the_rod_is_longer_than_crank_and_offset(crank, rod, offset):
    assume(abs(crank * math.sin(0.3) - offset) < 0.9 * rod and abs(rod - crank - abs(offset)) > 2e-3)
    jam, passed = passage(slider_crank(crank, rod, offset), TURN, lengths=False)
    assert (jam is None, passed) == (rod > crank + abs(offset), ())


def test_a_slider_crank_that_jams_names_its_small_end_and_the_rod_that_would_do():
    jam, _ = passage(slider_crank(0.05, 0.06, 0.02), TURN)
    assert jam.joint == "small-end" and jam.gap == pytest.approx(0.01, rel=1e-8)
    assert jam.aims[0] == pytest.approx(math.pi + math.asin(0.04 / 0.05), abs=1e-4)
    assert {name: then for name, _, then in jam.lengths} == pytest.approx(
        {"rod": 0.07, "crank": 0.04}, rel=1e-9
    )


@pytest.mark.parametrize(
    "name",
    [
        "jansen_leg",
        "six_bar_press",
        "quick_return",
        "scotch_yoke",
        "scissor_lift",
        "slider_crank_loose_guide",
    ],
)
def test_mechanisms_that_get_through_are_let_through(name):
    mechanism = getattr(gallery, name)()
    assert passage(mechanism, 1.0) == (None, ())
    assert outlook(mechanism).notes == ()


def test_a_leg_with_a_short_rod_is_told_which_one():
    m = gallery.jansen_leg()
    m.bodies["upper-rod"] = type(m.bodies["upper-rod"])(
        name="upper-rod", length=0.38, mass=0.2, angle=math.radians(141.0)
    )
    jam, _ = passage(m, 1.0)
    assert jam.joint == "I" and "upper-rod" in jam.bodies
    _, now, then = next(one for one in jam.lengths if one[0] == "upper-rod")
    assert now == 0.38 and then > now
    m.bodies["upper-rod"] = type(m.bodies["upper-rod"])(
        name="upper-rod", length=then, mass=0.2, angle=math.radians(141.0)
    )
    assert passage(m, 1.0, lengths=False)[0] is None
    m.bodies["upper-rod"] = type(m.bodies["upper-rod"])(
        name="upper-rod", length=now + 0.8 * (then - now), mass=0.2, angle=math.radians(141.0)
    )
    assert passage(m, 1.0, lengths=False)[0] is not None


@pytest.mark.parametrize(
    ("coupler", "rocker", "angles"), [(0.3, 0.1, (180.0, 0.0)), (0.18, 0.22, (180.0,)), (0.42, 0.22, (0.0,))]
)
def test_change_points_are_passed_with_a_caution(coupler, rocker, angles):
    """A parallelogram, and cranks as long as Grashof's limit allows; s + l = p + q."""
    m = four_bar(0.3, 0.1, coupler, rocker, 0.4)
    jam, passed = passage(m, TURN)
    assert jam is None
    assert [math.degrees(one.aims[0]) % 360.0 for one in passed] == pytest.approx(
        [angle % 360.0 or 360.0 for angle in angles], abs=0.02
    )
    (note,) = outlook(m, turns=1.0).notes
    assert "change point" in note and f"crank angle {angles[0]:g}°" in note


def test_a_part_of_a_turn_that_stays_clear_is_let_through():
    m = four_bar(0.3, 0.1, 0.13, 0.22, 0.4)
    end = math.acos((0.09 + 0.01 - 0.35**2) / 0.06)
    assert passage(m, 0.99 * (end - 0.4) / SPEED) == (None, ())
    assert passage(m, 1.01 * (end - 0.4) / SPEED, lengths=False)[0].aims[0] == pytest.approx(end, abs=1e-4)
    swing = Harmonic(
        body="crank", amplitude=-0.5, frequency=2.0
    )  # back first, through the line of the pivots: it closes there
    m.drivers["crank"] = swing
    assert passage(m, 10.0) == (None, ())
    m.drivers["crank"] = Harmonic(body="crank", amplitude=-2.5, frequency=2.0)
    jam = passage(m, 10.0, lengths=False)[0]
    assert jam.aims[0] == pytest.approx(-end, abs=1e-4)
    assert 2.5 * math.sin(2.0 * math.pi * 2.0 * jam.time) == pytest.approx(end + 0.4, abs=2e-2)


@pytest.mark.system("bisects lengths of mechanisms that jam")
def test_the_mirror_image_jams_alike():
    one, two = four_bar(0.3, 0.1, 0.13, 0.22, 0.4, 1.0), four_bar(0.3, 0.1, 0.13, 0.22, -0.4, -1.0)
    two.drivers.clear()
    two.drive("crank", speed=-SPEED)
    one, two = (passage(m, TURN, lengths=False)[0] for m in (one, two))
    assert one.aims[0] == pytest.approx(-two.aims[0], abs=1e-9) and one.time == pytest.approx(
        two.time, abs=1e-9
    )
    assert one.gap == pytest.approx(two.gap, rel=1e-6)


def test_two_drivers_are_followed_through_time():
    """Two cranks of a five-bar: the pins are apart by more than both rods where the cranks point away from
    each other.
    """

    def five_bar(rod):
        m = Mechanism("five-bar")
        for name, x in (("A", 0.0), ("E", 0.3)):
            m.point(name, x, 0.0)
        for name, angle in (("left", 1.2), ("right", 1.8)):
            m.link(name, length=0.1, mass=1.0, angle=angle)
        m.link("first", length=rod, mass=1.0, angle=0.9)
        m.link("second", length=rod, mass=1.0, angle=2.2)
        for name, one, two in (("A", "ground.A", "left.start"), ("E", "ground.E", "right.start"),
            ("B", "left.end", "first.start"),
                               ("D", "right.end", "second.start"),
                               ("C", "first.end", "second.end")):  # fmt: skip
            m.revolute(name, one, two)
        m.drive("left", speed=SPEED)
        m.drive("right", speed=-SPEED)
        return m

    assert passage(five_bar(0.251), 2.0 * TURN) == (None, ())
    jam, _ = passage(five_bar(0.23), 2.0 * TURN, lengths=False)

    def apart(t):
        left, right = 1.2 + SPEED * t, 1.8 - SPEED * t
        return math.hypot(
            0.3 + 0.1 * (math.cos(right) - math.cos(left)), 0.1 * (math.sin(right) - math.sin(left))
        )

    assert apart(jam.time) == pytest.approx(0.46, rel=1e-4)


@pytest.mark.system("bisects lengths")
def test_play_may_bridge_what_is_open_and_elastic_links_give_way():
    m = four_bar(0.3, 0.1, 0.1799, 0.22, 0.4, play=0.2e-3)
    m.settings = Settings(turns=1.0)
    found = outlook(m)
    assert not found.passes and "clearance of C, 0.2 mm" in found.notes[0]
    assert simulate(m, turns=0.02, companions=0).reference is None
    with pytest.raises(AssemblyError, match="jams at crank angle .* joint C opens.*coupler at least 180 mm"):
        outlook(four_bar(0.3, 0.1, 0.1799, 0.22, 0.4, play=0.05e-3))
    soft = four_bar(0.3, 0.1, 0.13, 0.22, 0.4)
    del soft.bodies["coupler"]
    soft.link("coupler", length=0.13, mass=0.1, model="elastic", section=Section.square(1e-6), angle=1.4)
    assert "elastic, can give way" in outlook(soft, turns=1.0).notes[-1]


def test_what_drivers_do_not_determine_is_left_alone():
    for name in (
        "double_pendulum",
        "squeezer",
        "gear_train",
        "block_on_incline",
        "toggle_press",
        "lee_frame",
    ):
        assert outlook(getattr(gallery, name)()).notes == ()
    m = four_bar(0.3, 0.1, 0.13, 0.22, 0.4)
    m.drivers.clear()
    assert passage(m, TURN) == (None, ())


def test_a_closed_position_is_closed_to_round_off():
    motion = ideal_motion(gallery.jansen_leg())
    follower = Follower.of(motion.system, motion.position * (1.0, motion.hand, motion.hand))
    position, _ = follower.closed(motion.position + 1e-3, np.array([motion.system.drives[0].aim]))
    assert np.abs(motion.system.dense_rows(position, motion.system.aims)[0]).max() < 1e-9


def test_a_massless_link_has_a_nearest_length_too():
    m = four_bar(0.3, 0.1, 0.13, 0.22, 0.4)
    del m.bodies["coupler"], m.joints["B"], m.joints["C"]
    m.distance("bar", "crank.end", "rocker.end", length=0.13)
    jam, _ = passage(m, TURN)
    assert {name: then for name, _, then in jam.lengths}["bar"] == pytest.approx(0.18, rel=1e-9)


@pytest.mark.parametrize("excess", [3e-8, 1e-10, 1e-12, -1e-8, -1e-10])
def test_a_hair_beside_a_change_point_is_no_jam(excess):
    """Less than a micron in a metre is no length of a workshop's, and round-off decides which side it lies
    on.
    """
    for m in (four_bar(0.3, 0.1, 0.18 + excess, 0.22, 0.4), slider_crank(0.05, 0.07 + excess, 0.02)):
        assert passage(m, TURN)[0] is None


@pytest.mark.system("follows a thousand mechanisms round")
def test_what_surely_makes_a_turn_is_of_grashof_s_crank_rockers():
    """Seen as a whole, walked or from that of a neighbour: only what Grashof's condition lets through, and
    all that is far from its limit.
    """
    rng = np.random.default_rng(5)
    sides = np.array([0.15, 0.4, 0.26, 0.46]) * (1.0 + 0.14 * rng.uniform(-1.0, 1.0, (60, 4)))
    spare = sides.sum(axis=1) - 2.0 * (sides.max(axis=1) + sides.min(axis=1))
    turns = (spare > 0.0) & (sides[:, 0] == sides.min(axis=1))
    assert (~turns).sum() > 5 and (turns & (spare > 0.04)).sum() > 5
    for speed in (SPEED, -SPEED):
        neighbour, sure = None, []
        for one in sides:
            motion = ideal_motion(four_bar(*one, angle=1.5))
            [walked], [known] = full_turns([motion], [speed]), full_turns([motion], [speed], neighbour)
            if walked is not None and known is not None:
                assert np.abs(walked.positions - known.positions).max() < 1e-8
            sure.append((walked is not None, known is not None))
            neighbour = known or neighbour
        for found in np.array(sure).T:
            assert not found[~turns].any() and found[turns & (spare > 0.04)].all()


def cranks(*pins: tuple[float, float]) -> Mechanism:
    """Parallel cranks of 0.1 m at 0.4 rad that carry a beam at its ``pins`` (m); the first is driven."""
    m = Mechanism("parallel cranks")
    at = (0.1 * math.cos(0.4), 0.1 * math.sin(0.4))
    named = {f"p{k}": pin for k, pin in enumerate(pins)}
    m.rigid_body("beam", mass=3.0, inertia=0.1, pins=named, center=(0.1, 0.02), position=at)
    for k, (x, y) in enumerate(pins):
        m.point(f"O{k}", x, y)
        m.link(f"crank{k}", length=0.1, mass=1.0, angle=0.4)
        m.revolute(f"A{k}", f"ground.O{k}", f"crank{k}.start")
        m.revolute(f"B{k}", f"crank{k}.end", f"beam.p{k}")
    m.drive("crank0", speed=SPEED)
    return m


def test_change_points_of_redundant_cranks_are_found():
    """Two loops split at once, so that the determinant keeps its sign; with a third pin beside the line of
    the others, one loop leads the other through, and nothing splits.
    """
    jam, passed = passage(cranks((0.0, 0.0), (0.1, 0.0), (0.25, 0.0)), TURN)
    assert jam is None
    assert [math.degrees(one.aims[0]) for one in passed] == pytest.approx([180.0, 360.0], abs=0.02)
    assert set(passed[0].joints) == {"A0", "A1", "A2", "B0", "B1", "B2"}
    assert passed[0].time == pytest.approx((math.pi - 0.4) / SPEED, rel=2e-3)
    assert passage(cranks((0.0, 0.0), (0.1, 0.0), (0.15, 0.1)), TURN) == (None, ())
