"""The ideal mechanism is followed once, however often and with whatever step a motion is asked for; what is
another motion is followed anew.
"""

from pathlib import Path

import pytest

from vfife.assembly import possible
from vfife.errors import AssemblyError
from vfife.kinematics.full_turn import full_turns
from vfife.modelfile import load

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
