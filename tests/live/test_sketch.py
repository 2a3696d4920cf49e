"""Operations on a sketch: each leaves a valid model and the comments, and moves what it says; the ideal
motion that is drawn is that of the mechanism.
"""

import math
import re
import tomllib

import numpy as np
import pytest

from vfife import gallery
from vfife.errors import ModelError
from vfife.kinematics.initial import Motion, ideal_motion
from vfife.live.sketch.edit import resolution
from vfife.live.sketch.operations import apply
from vfife.live.sketch.pose import Pose, frames, pin_side
from vfife.live.sketch.sketch import sketch
from vfife.modelfile import loads
from vfife.modelfile.edits import rewritten

FOUR_BAR = gallery.path("four_bar_case_c").read_text("utf-8")
COMPRESSOR = gallery.path("compressor").read_text("utf-8")
TEXTS = {name: gallery.path(name).read_text("utf-8") for name in gallery.__all__}


def places(text):
    pose = Pose.of(loads(text))
    assert isinstance(pose.motion, Motion), pose.motion
    return {".".join(side): pose.place(side) for side in pose.sides}


def comments(text):
    return re.findall(r"#.*", text)


@pytest.mark.parametrize(
    ("text", "point", "by"),
    [
        (FOUR_BAR, "crank.end", (0.013, 0.021)),
        (FOUR_BAR, "coupler.end", (-0.02, 0.03)),
        (FOUR_BAR, "ground.D", (0.01, -0.015)),
        (COMPRESSOR, "rod.start", (0.002, 0.004)),
        (TEXTS["jansen_leg"], "foot.third", (0.03, 0.02)),
        (TEXTS["jansen_leg"], "upper-rod.end", (0.01, -0.02)),
        (TEXTS["six_bar_press"], "crank.end", (0.004, 0.003)),
    ],
)
def test_a_point_goes_where_it_is_dragged_and_all_others_stay(text, point, by):
    before = places(text)
    x, y = (a + b for a, b in zip(before[point], by, strict=True))
    changed = apply(text, "move_point", {"point": point, "x": x, "y": y})
    after = places(changed)
    moved = {".".join(side) for side in Pose.of(loads(text)).cluster(pin_side(point))}
    fine = 3.0 * resolution(Pose.of(loads(text)).size)
    for pin, place in after.items():
        body = pin.partition(".")[0]
        if pin in moved:
            assert math.dist(place, (x, y)) < fine, pin
        elif pin.endswith(".center") and any(one.startswith(f"{body}.") for one in moved):
            continue  # the centre of mass of a body whose pin was dragged
        else:
            assert math.dist(place, before[pin]) < fine, pin
    assert comments(changed) == comments(text)
    assert set(tomllib.loads(changed)) == set(tomllib.loads(text))


def test_a_pin_in_a_guide_stays_on_it():
    x, y = places(COMPRESSOR)["piston.center"]
    changed = apply(COMPRESSOR, "move_point", {"point": "piston.center", "x": x + 0.01, "y": y + 0.02})
    assert places(changed)["piston.center"] == pytest.approx((x + 0.01, 0.0), abs=1e-5)
    assert 'length = "110 mm"' in changed and 'center_at = "33 mm"' in changed


def test_a_length_is_set_in_the_unit_of_the_file():
    changed = apply(FOUR_BAR, "set_length", {"body": "coupler", "length": 0.2712})
    assert changed == FOUR_BAR.replace('length = "0.260 m"', 'length = "0.2712 m"')
    bare = apply(FOUR_BAR.replace('"0.260 m"', "0.26"), "set_length", {"body": "coupler", "length": 0.2712})
    assert "length = 0.2712\n" in bare


def test_the_direction_of_a_guide_is_set():
    """A drawn guide is horizontal; it can be turned, and the ram goes along it."""
    name = next(joint["name"] for joint in sketch(COMPRESSOR)["joints"] if joint["guide"])
    changed = apply(COMPRESSOR, "set_direction", {"joint": name, "angle": math.radians(10.0)})
    direction = tomllib.loads(changed)["joint"][name]["direction"]
    assert direction == [
        pytest.approx(math.cos(math.radians(10.0)), abs=1e-6),
        round(math.sin(math.radians(10.0)), 6),
    ]
    x, y = places(changed)["piston.center"]
    assert math.atan2(y, x) == pytest.approx(math.radians(10.0), abs=1e-4)
    assert comments(changed) == comments(COMPRESSOR)
    level = apply(changed, "set_direction", {"joint": name, "angle": math.pi / 2.0})
    assert tomllib.loads(level)["joint"][name]["direction"] == [0.0, 1.0]
    with pytest.raises(ModelError, match="has no straight guide"):
        apply(COMPRESSOR, "set_direction", {"joint": "main", "angle": 0.0})


def test_what_does_not_close_says_why_and_is_drawn_with_its_gap():
    changed = apply(FOUR_BAR, "set_length", {"body": "coupler", "length": 0.05})
    drawing = sketch(changed)
    assert drawing["gaps"] and "open" in drawing["fault"]
    assert len(drawing["poses"]) == 1
    closed = sketch(apply(changed, "set_length", {"body": "coupler", "length": 0.26}))
    assert not closed["fault"] and not closed["gaps"] and closed["closed"]


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("move_point", {"point": "crank.middle", "x": 0.0, "y": 0.0}),
        ("move_point", {"point": "crank.end", "x": math.nan, "y": 0.0}),
        ("move_point", {"point": "crank.end", "x": "0", "y": 0.0}),
        ("move_point", {"point": ["crank"], "x": 0.0, "y": 0.0}),
        ("move_point", {"point": "crank.end", "x": 0.0, "y": 0.0}),  # onto its own start
        ("move_point", {"point": "crank.end"}),
        ("set_length", {"body": "joint", "length": 1.0}),
        ("set_length", {"body": "coupler", "length": -1.0}),
        ("erase", {}),
    ],
)
def test_an_operation_that_cannot_be_done_says_why(name, arguments):
    with pytest.raises(ModelError, match=r"\w{3}"):
        apply(FOUR_BAR, name, arguments)


@pytest.mark.parametrize("name", ["four_bar", "compressor", "quick_return", "scissor_lift", "jansen_leg"])
def test_the_motion_drawn_is_the_ideal_motion(name):
    """At each pose every pinned joint is closed, and at some the ideal motion was solved by itself."""
    mechanism, drawing = loads(TEXTS[name]), sketch(TEXTS[name])
    bodies = {body["name"]: k for k, body in enumerate(drawing["bodies"])}
    assert len(drawing["poses"]) > 30

    def place(pin, pose):
        body, _, which = pin.partition(".")
        if body == "ground":
            return np.array(drawing["points"][which])
        x, y, angle = pose[bodies[body]]
        px, py = mechanism.bodies[body].points[which]
        c, s = math.cos(angle), math.sin(angle)
        return np.array([x + c * px - s * py, y + s * px + c * py])

    for pose in drawing["poses"]:
        for joint in drawing["joints"]:
            if joint["pinned"]:
                gap = place(joint["bearing"], pose) - place(joint["journal"], pose)
                assert np.abs(gap).max() < 1e-6 * drawing["size"], joint["name"]
    if drawing["closed"]:
        [driver] = mechanism.drivers.values()
        time = 2.0 * math.pi / abs(driver.steady_speed) * 9 / 36
        solved = ideal_motion(mechanism, time, np.array(_centers(mechanism, drawing["poses"][9])))
        names = tuple(mechanism.bodies)
        there = frames(mechanism, solved.position[1:], names)[:, :2]
        assert there == pytest.approx(np.array(drawing["poses"][9])[:, :2], abs=1e-6)


def _centers(mechanism, pose):
    """Centres of mass from the frames of bodies."""
    zero = np.zeros((len(pose), 3))
    zero[:, 2] = np.array(pose)[:, 2]
    offset = frames(mechanism, zero, tuple(mechanism.bodies)) * (-1.0, -1.0, 0.0)
    return [[0.0, 0.0, 0.0], *(np.array(pose) + offset).tolist()]


def test_a_jam_is_named_with_its_place():
    """Without a full turn (Grashof), the crank is drawn until coupler and follower are in line."""
    short = apply(FOUR_BAR, "set_length", {"body": "follower", "length": 0.3})
    drawing = sketch(apply(short, "set_length", {"body": "coupler", "length": 0.24}))
    angles = [pose[0][2] for pose in drawing["poses"]]
    crank, ground, reach = 0.4, 0.15, 0.3 + 0.24
    limit = math.acos((crank**2 + ground**2 - reach**2) / (2.0 * crank * ground))
    assert "jams" in drawing["note"] and not drawing["closed"]
    assert limit - math.radians(10.0) < max(angles) < limit


@pytest.mark.parametrize("name", gallery.__all__)
def test_every_model_of_the_gallery_is_drawn(name):
    drawing = sketch(TEXTS[name])
    assert not drawing["fault"] and not drawing["gaps"] and np.isfinite(np.array(drawing["poses"])).all()


def test_a_model_with_a_table_beside_it_is_drawn_and_edited(tmp_path):
    text = FOUR_BAR[: FOUR_BAR.index("[driver.crank]")] + '[driver.crank]\ntable = "way.csv"\n'
    file = tmp_path / "model.toml"
    (tmp_path / "way.csv").write_text("time (s), angle (deg)\n0, 0\n1, 90\n2, 360\n", "utf-8")
    assert sketch(text, str(file))["bodies"]
    moved = apply(text, "set_length", {"body": "coupler", "length": 0.27}, str(file))
    assert loads(moved, file=str(file)).bodies["coupler"].length == 0.27
    with pytest.raises(ModelError, match="way.csv"):
        sketch(text, str(tmp_path / "elsewhere" / "model.toml"))


def test_a_table_is_removed_with_its_comment_and_added_behind_its_section():
    raw = tomllib.loads(COMPRESSOR)
    del raw["joint"]["cylinder"], raw["load"], raw["body"]["rod"]
    raw["body"]["lever"] = {"length": "10 mm", "mass": 1.0}
    text = rewritten(COMPRESSOR, raw)
    assert tomllib.loads(text) == raw
    assert "slaps from wall" not in text and "Of steel" not in text and "The gas pushes" not in text
    assert "# Of aluminium" in text and "# A joint with clearance" in text
    assert text.index("[body.piston]") < text.index("[body.lever]") < text.index("[joint.main]")
    assert "\n\n\n" not in text and text.endswith("\n") and not text.endswith("\n\n")
    windows = rewritten(COMPRESSOR.replace("\n", "\r\n"), raw)
    assert windows == text.replace("\n", "\r\n")


def test_a_block_has_its_size_in_the_drawing():
    joints = {joint["name"]: joint for joint in sketch(COMPRESSOR)["joints"]}
    assert joints["cylinder"]["block"] == [0.05, 0.065] and joints["main"]["block"] == [0.0, 0.0]
