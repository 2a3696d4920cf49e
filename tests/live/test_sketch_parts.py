"""Parts added, deleted and changed in a sketch: the text is a valid model after each operation, comments of
all other tables remain, and bodies stay where they are.
"""

import math
import re
import tomllib

import pytest

from vfife import gallery
from vfife.errors import ModelError
from vfife.kinematics.initial import Motion
from vfife.live.server.documents import Document
from vfife.live.sketch.edit import resolution
from vfife.live.sketch.operations import CHOICES, apply
from vfife.live.sketch.pose import Pose
from vfife.live.sketch.removal import SECTIONS
from vfife.live.sketch.sketch import sketch
from vfife.modelfile import loads

TEXTS = {name: gallery.path(name).read_text("utf-8") for name in gallery.__all__}
FOUR_BAR, COMPRESSOR, PRESS = (TEXTS[name] for name in ("four_bar_case_c", "compressor", "six_bar_press"))
QUICK = ("compressor", "gear_train", "lee_frame", "quick_return", "scotch_yoke")
EVERY = [
    name if name in QUICK else pytest.param(name, marks=pytest.mark.system("closes many mechanisms"))
    for name in gallery.__all__
]
# Refusals that are right: what depends on a part is named.
REASONS = re.compile(
    r"load\.\w+ needs (joint|body) |a driven body needs one ideal joint|the model has no body"
)


def comments_beside(text):
    """Comments of tables that no deletion touches: those before the first table, and those of the ground."""
    top = re.findall(r"#.*", text.partition("\n[")[0])
    return top, re.findall(r"#.*", text.partition("\n[ground]\n")[2].partition("\n\n")[0])


def moved(before, after, but=()):
    """Pins that are elsewhere at the start."""
    one, two = Pose.of(loads(before)), Pose.of(loads(after))
    assert isinstance(two.motion, Motion), two.motion
    fine = 5.0 * resolution(one.size)
    sides = [side for side in one.sides if side in two.sides and side[1] != "center" and side[0] not in but]
    return [side for side in sides if math.dist(one.place(side), two.place(side)) > fine]


def undone(text, after):
    """The text after an operation and Undo, and after Redo."""
    document = Document("model", "model", text)
    document.take(after)
    document.undo()
    back = document.text
    document.redo()
    return back, document.text


@pytest.mark.parametrize("name", EVERY)
def test_whatever_is_deleted_leaves_a_model_whose_bodies_stay(name):
    text = TEXTS[name]
    raw = tomllib.loads(text)
    count = 0
    for section in SECTIONS:
        for part in raw.get(section, {}):
            try:
                after = apply(text, "delete", {"section": section, "name": part})
            except ModelError as error:
                assert REASONS.search(str(error)), (section, part, str(error))
                continue
            count += 1
            assert part not in tomllib.loads(after).get(section, {})
            assert moved(text, after) == [], (section, part)
            assert undone(text, after) == (text, after)
            assert comments_beside(after) == comments_beside(text), (section, part)
    assert count or len(raw["body"]) == 1


@pytest.mark.parametrize("name", EVERY)
def test_what_is_added_is_drawn_and_moves_nothing(name):
    text = TEXTS[name]
    pose = Pose.of(loads(text))
    pin = ".".join(next(side for side in pose.sides if side[0] != "ground"))
    x, y = pose.place(pose.sides[-1])
    free = [x + 0.3 * pose.size, y + 0.4 * pose.size]
    for operation, arguments in (
        ("add_point", {"x": free[0], "y": free[1]}),
        ("add_bar", {"start": pin, "end": free}),
        ("add_load", {"point": pin}),
    ):
        after = apply(text, operation, arguments)
        assert moved(text, after) == [], operation
        assert undone(text, after) == (text, after)
        assert re.findall(r"#.*", after) == re.findall(r"#.*", text)
        assert sum(map(len, (sketch(after)[key] for key in ("points", "bodies", "loads")))) == 1 + sum(
            map(len, (sketch(text)[key] for key in ("points", "bodies", "loads")))
        )


def test_a_bar_between_two_points_has_their_distance_and_turns_about_both():
    after = apply(PRESS, "delete", {"section": "body", "name": "coupler"})
    after = apply(after, "add_bar", {"start": "crank.end", "end": "rocker.pin"})
    bar = loads(after).bodies["bar"]
    assert moved(PRESS, after) == []
    assert bar.length == pytest.approx(0.320, abs=1e-5) and bar.mass == pytest.approx(
        15.0 * 0.32
    )  # the median per length
    assert 'length = "320 mm"' in after and "kg" in after.partition("[body.bar]")[2].partition("\n[")[0]
    drawing = sketch(after)
    assert not drawing["fault"] and len(drawing["poses"]) > 30 and drawing["free"] == 0


def test_a_pin_added_to_a_link_is_drawn_where_it_was_set():
    after = apply(FOUR_BAR, "add_pin", {"body": "coupler", "x": 0.5, "y": 0.2})
    assert Pose.of(loads(after)).place(("coupler", "P")) == pytest.approx((0.5, 0.2), abs=1e-4)
    [coupler] = [body for body in sketch(after)["bodies"] if body["name"] == "coupler"]
    assert "P" in coupler["pins"] and len(coupler["outline"]) == 4 and coupler["plate"]
    assert "P-2" in apply(after, "add_pin", {"body": "coupler", "x": 0.5, "y": 0.25})


def test_the_last_driver_leaves_the_run_its_duration():
    after = apply(COMPRESSOR, "delete", {"section": "driver", "name": "crank"})
    assert loads(after).settings.duration == pytest.approx(6 * 60.0 / 1450.0, rel=1e-5)
    again = apply(after, "drive", {"body": "crank"})
    assert again.count("[driver.crank]") == 1 and moved(COMPRESSOR, again) == []


@pytest.mark.parametrize("choice", CHOICES)
@pytest.mark.parametrize("joint", ["B", "C"])
def test_the_kind_of_a_joint_is_changed_and_its_pins_remain(joint, choice):
    after = apply(FOUR_BAR, "set_kind", {"joint": joint, "choice": choice})
    before, now = loads(FOUR_BAR).joints[joint], loads(after).joints[joint]
    assert (now.bearing, now.journal) == (before.bearing, before.journal)
    assert [one["choice"] for one in sketch(after)["joints"] if one["name"] == joint] == [choice]
    if choice in ("ideal", "clearance"):
        assert moved(FOUR_BAR, after) == []
        back = apply(after, "set_kind", {"joint": joint, "choice": "clearance"})
        assert loads(back).joints[joint].clearance == pytest.approx(2e-4, rel=0.5)
    assert undone(FOUR_BAR, after) == (FOUR_BAR, after)


def test_a_slider_and_an_anchor_hold_a_pin_where_it_is():
    loose = apply(FOUR_BAR, "delete", {"section": "body", "name": "follower"})
    for operation in ("add_slider", "anchor"):
        after = apply(loose, operation, {"point": "coupler.end"})
        mechanism = loads(after)
        if operation == "add_slider":
            assert moved(FOUR_BAR, after) == [] and len(sketch(after)["poses"]) > 1
        assert mechanism.points["C"] == pytest.approx(
            Pose.of(loads(loose)).place(("coupler", "end")), abs=1e-4
        )
        assert mechanism.joints["C"].sides == (("ground", "C"), ("coupler", "end"))


def test_a_mechanism_that_cannot_move_is_a_draft_that_says_so():
    after = apply(FOUR_BAR, "add_bar", {"start": "ground.A", "end": "coupler.end"})
    drawing = sketch(after)
    assert "nothing can move" in drawing["fault"] and len(drawing["poses"]) == 1
    assert not sketch(apply(after, "delete", {"section": "body", "name": "bar"}))["fault"]


def test_drivers_are_told_with_the_body_or_the_guide_that_they_drive():
    bodies = {body["name"]: body["driver"] for body in sketch(FOUR_BAR)["bodies"]}
    assert bodies == {
        "crank": {"name": "crank", "speed": pytest.approx(50.0 * math.pi)},
        "coupler": None,
        "follower": None,
    }
    drivers = {joint["name"]: joint["drivers"] for joint in sketch(TEXTS["scissor_lift"])["joints"]}
    assert drivers.pop("roller") == ["actuator"] and not any(drivers.values())


def test_a_value_is_set_as_it_is_written():
    arguments = {"section": "joint", "name": "B", "key": "clearance", "value": "0.3 mm"}
    assert apply(FOUR_BAR, "set_value", arguments) == FOUR_BAR.replace('"0.2 mm"', '"0.3 mm"', 1)


@pytest.mark.parametrize(
    ("text", "name", "arguments", "reason"),
    [
        (COMPRESSOR, "delete", {"section": "joint", "name": "cylinder"}, "load.gas needs joint cylinder"),
        (COMPRESSOR, "delete", {"section": "body", "name": "piston"}, "load.gas needs joint cylinder"),
        (COMPRESSOR, "delete", {"section": "pin", "name": "ground.shaft"}, "joint.main and joint.cylinder"),
        (COMPRESSOR, "delete", {"section": "pin", "name": "rod.start"}, "used by joint.big-end"),
        (COMPRESSOR, "delete", {"section": "run", "name": "turns"}, "cannot be deleted"),
        (COMPRESSOR, "delete", {"section": "body", "name": "rot"}, "no body 'rot'. Did you mean \"rod\""),
        (FOUR_BAR, "add_bar", {"start": "crank.end", "end": "coupler.start"}, "no length"),
        (FOUR_BAR, "add_bar", {"start": "crank.end", "end": [0.4, 0.0]}, "no length"),
        (FOUR_BAR, "add_bar", {"start": "crank.end", "end": ["a", 0.0]}, "finite"),
        (FOUR_BAR, "add_joint", {"first": "ground.D", "second": "crank.end"}, "weld"),
        (FOUR_BAR, "add_joint", {"first": "ground.A", "second": "crank.start"}, "joined already"),
        (FOUR_BAR, "anchor", {"point": "crank.start"}, "on the ground already"),
        (FOUR_BAR, "add_load", {"point": "ground.A"}, None),
        (TEXTS["lee_frame"], "add_pin", {"body": "frame", "x": 0.0, "y": 0.0}, "not rigid"),
        (FOUR_BAR, "set_kind", {"joint": "B", "choice": "distance"}, "choose one of|Choose one of"),
        (FOUR_BAR, "set_kind", {"joint": "A", "choice": "clearance"}, "driven body"),
        (FOUR_BAR, "drive", {"body": "coupler"}, "one ideal joint to the ground"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_says_why(text, name, arguments, reason):
    if reason is None:  # a force at a point of the ground acts on the body that is pinned there
        assert 'at = "crank.start"' in apply(text, name, arguments)
        return
    with pytest.raises(ModelError, match=reason):
        apply(text, name, arguments)
