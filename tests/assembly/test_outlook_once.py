"""The ideal mechanism is followed once, however often and with whatever step a motion is asked for; what is
another motion is followed anew.
"""

import math
from pathlib import Path

import pytest

import vfife
from vfife import gallery
from vfife.assembly import possible
from vfife.assembly.missing_joints import missing_joints
from vfife.errors import AssemblyError
from vfife.kinematics.full_turn import full_turns
from vfife.model.mechanism import Mechanism
from vfife.modelfile import load
from vfife.report.overview import cautions, heading_sentence

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture
def followed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of mechanisms that are followed, from nothing known on, and with doubt left by a look at a whole
    turn.
    """
    found: list[str] = []
    whole = possible.passage

    def watched(mechanism, *given):
        found.append(mechanism.name)
        return whole(mechanism, *given)

    monkeypatch.setattr(possible, "passage", watched)
    monkeypatch.setattr(possible, "full_turns", lambda motions, *_: [None] * len(motions))
    monkeypatch.setattr(possible, "CACHE", type(possible.CACHE)())
    return found


def test_the_same_motion_is_followed_once(followed: list[str]) -> None:
    path = EXAMPLES / "four_bar_case_c.toml"
    first = possible.outlook(load(path), turns=1.0)
    for set_ in ([("run.step", 1e-6)], [("run.outputs", 7), ("run.companions", 0)], [("run.turns", 1.0)]):
        assert possible.outlook(load(path, set=set_), turns=1.0) is first
    assert len(followed) == 1


def test_a_whole_turn_without_doubt_is_not_followed_and_has_the_same_outlook(
    followed: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a mirror image, too, which a look at positions must not miss to tell."""
    path = EXAMPLES / "four_bar_case_c.toml"
    models = [load(path), load(path, set=[("body.coupler.angle", -1.5)])]
    before = [possible.outlook(one, turns=1.0) for one in models]
    monkeypatch.setattr(possible, "full_turns", full_turns)
    after = [possible.outlook(one, turns=1.0) for one in models]
    assert len(followed) == 2
    for one, other in zip(before, after, strict=True):
        assert one.notes == other.notes and one.passes and other.passes
        assert one.motion.position.tobytes() == other.motion.position.tobytes()
    assert not after[0].notes and "mirror image" in after[1].notes[-1]


def test_another_motion_is_followed_anew(followed: list[str]) -> None:
    path, mechanism = EXAMPLES / "four_bar_case_c.toml", load(EXAMPLES / "four_bar_case_c.toml")
    possible.outlook(mechanism, turns=1.0)
    possible.outlook(mechanism, turns=2.0)
    for number in ("body.coupler.length", "driver.crank.speed", "joint.C.clearance", "ground.D.0"):
        possible.outlook(load(path, set=[(number, 1.001 * value_at(mechanism, number))]), turns=1.0)
    assert len(followed) == 6


def value_at(mechanism, path: str) -> float:
    kind, name, field = path.split(".")
    noun = {
        "body": mechanism.bodies,
        "driver": mechanism.drivers,
        "joint": mechanism.joints,
        "ground": mechanism.points,
    }[kind][name]
    return noun[int(field)] if field.isdigit() else getattr(noun, field)


def test_what_jams_is_told_each_time(followed: list[str]) -> None:
    short = load(EXAMPLES / "four_bar_case_c.toml", set=[("body.coupler.length", 0.16)])
    told = set()
    for _ in range(2):
        with pytest.raises(AssemblyError) as caught:
            possible.outlook(short, turns=1.0)
        told.add(str(caught.value))
    assert len(told) == 1 and not possible.CACHE


def test_the_oldest_is_forgotten(followed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(possible, "CACHE_SIZE", 2)
    mechanism = load(EXAMPLES / "slider_crank.toml")
    for turns in (1.0, 2.0, 3.0, 3.0, 1.0):
        possible.outlook(mechanism, turns=turns)
    assert len(possible.CACHE) == 2 and len(followed) == 4


JOINTS = {
    "slider_crank": {
        "pin": "rod.end is joined to nothing and lies 0 mm from block.center",
        "guide": "no load, spring or weight acts on block there",
    },
    "six_bar_press": {
        "C": "coupler.end is joined to nothing",
        "F": "rod.end is joined to nothing",
        "guide": "no load, spring or weight acts on ram there",
    },
    "quick_return": dict.fromkeys(["P", "R", "slot", "guide"], "no load, spring or weight acts on"),
    "compressor": {"small-end": "rod.end is joined to nothing and lies 0 mm from piston.center"},
    "jansen_leg": dict.fromkeys("JKBDCFGHI", "is joined to nothing and lies"),
    "squeezer": dict.fromkeys(["O", "P", "B", "A5", "A7", "H", "G", "E2", "E4", "E6"], "forgotten?"),
    "gear_train": dict.fromkeys(["motor", "middle", "flywheel"], "no load, spring or weight acts on"),
    "lee_frame": {
        "foot": "ground.foot and frame.foot lie in one place",
        "head": "ground.head and frame.head",
    },
    "williams_toggle": {"left": "ground.left and toggle.left lie in one place"},
    "toggle_press": {
        "knee": "lower.start is joined to nothing and lies 0 mm from upper.end",
        "wrist": "lower.end is joined to nothing and lies 0 mm from ram.center",
        "guide": "ground.guide is joined to nothing",
    },
    "journal_in_bearing": {"O": "journal.center is joined to nothing and lies 0 mm from ground.O"},
    "slider_crank_free": {"pin": "The mechanism has 3 degrees of freedom", "crankpin": "lies 0 mm from"},
}


@pytest.mark.parametrize("name", JOINTS)
def test_a_joint_that_is_forgotten_is_told(name: str) -> None:
    for joint, words in JOINTS[name].items():
        m = getattr(gallery, name)()
        del m.joints[joint]
        (told,) = missing_joints(m)
        assert words in told and told.endswith("forgotten?"), (joint, told)
        assert told in m.check().notes, joint


@pytest.mark.parametrize("name", gallery.__all__)
def test_no_joint_is_missed_where_none_is_missing(name: str) -> None:
    assert missing_joints(getattr(gallery, name)()) == ()


def crank_with_rod(gravity: float, angle: float = -0.5 * math.pi) -> Mechanism:
    m = Mechanism("a pendulum on a crank", gravity=(0.0, gravity))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=0.1, mass=1.0)
    m.link("rod", length=0.3, mass=1.0, angle=angle)
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("P", "crank.end", "rod.start")
    m.drive("crank", speed=5.0)
    return m


@pytest.mark.parametrize("gravity", [0.0, -9.81])
def test_pendulums_on_a_crank_are_meant(gravity: float) -> None:
    m = crank_with_rod(gravity)
    assert missing_joints(m) == ()
    m.link("second", length=0.2, mass=1.0, angle=0.3)
    m.revolute("Q", "rod.end", "second.start")
    assert missing_joints(m) == ()
    m.rigid_body("disc", mass=1.0, inertia=0.01)
    m.revolute("S", "second.end", "disc.center")
    (told,) = missing_joints(m)
    assert "acts on disc there" in told


def test_a_crank_that_is_the_clock_of_a_pendulum_is_meant() -> None:
    m = crank_with_rod(-9.81)
    m.point("Q", 1.0, 0.0)
    del m.joints["P"]
    m.revolute("P", "ground.Q", "rod.start")
    assert missing_joints(m) == ()


def test_a_five_bar_that_a_spring_holds_is_meant() -> None:
    m = crank_with_rod(0.0, angle=1.2)
    m.point("E", 0.4, 0.0)
    m.link("right", length=0.3, mass=1.0, angle=2.0)
    m.link("left", length=0.1, mass=1.0, angle=0.2)
    m.revolute("E", "ground.E", "right.start")
    m.revolute("D", "right.end", "left.end")
    m.revolute("C", "left.start", "rod.end")
    (told,) = missing_joints(m)
    assert "acts on rod, right and left there" in told
    m.torsional_spring("return", "ground", "right", stiffness=10.0)
    assert m.check().after_drives > 0 and all("forgotten" not in note for note in m.check().notes)


def test_a_run_begins_with_the_joint_that_is_missing_and_the_freedom_left() -> None:
    m = gallery.slider_crank_loose_guide(turns=0.1)
    del m.joints["pin"]
    summary = vfife.simulate(m, companions=1).summary
    assert "is a joint" in summary["warnings"][0].lower() and summary["warnings"][0].endswith("forgotten?")
    assert next(iter(cautions(summary))) == summary["warnings"][0]
    assert not any(note.endswith("forgotten?") for note in summary["run"]["notes"])
    assert summary["run"]["free_when_driven"] == 2
    assert heading_sentence(summary).endswith(" · 2 degrees of freedom left when driven")
    whole = vfife.simulate(gallery.slider_crank(turns=0.1)).summary
    assert "free_when_driven" not in whole["run"] and "freedom" not in heading_sentence(whole)


def test_elastic_bodies_determine_the_reactions_of_redundant_joints() -> None:
    lee = gallery.lee_frame()
    words = "the elastic bodies determine how these joints share their load"
    assert lee.check().redundant and words in str(lee.check())
    m = Mechanism("three parallel rockers")
    m.rigid_body(
        "beam", mass=1.0, inertia=0.1, position=(0.0, 0.1), pins={f"p{k}": (0.2 * k, 0.0) for k in range(3)}
    )
    for k in range(3):
        m.point(f"g{k}", 0.2 * k, 0.0)
        m.link(f"rocker{k}", length=0.1, mass=1.0, angle=0.5 * math.pi)
        m.revolute(f"A{k}", f"ground.g{k}", f"rocker{k}.start")
        m.revolute(f"B{k}", f"rocker{k}.end", f"beam.p{k}")
    assert "rigid links do not determine" in str(m.check())
