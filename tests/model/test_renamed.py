"""Names that nouns had before work for one version more, and say the new one."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

import vfife
from vfife.model.bodies import Frame, Link, PointMass, RigidBody
from vfife.model.drivers import AngleTable, Torque
from vfife.model.mechanism import Start, StartSettings

PIN = {"p": (0.1, 0.0)}
OLD = [
    (Link, {"name": "a", "length": 1.0}, "link_model", "model", "elastic"),
    (Link, {"name": "a", "length": 1.0}, "extra_points", "pins", PIN),
    (RigidBody, {"name": "a", "mass": 1.0, "inertia": 1.0}, "points", "pins", PIN),
    (AngleTable, {"body": "a", "times": (0.0, 1.0)}, "angles", "values", (0.0, 2.0)),
    (Torque, {"body": "a"}, "torque", "value", 3.0),
]


@pytest.mark.parametrize(("noun", "given", "old", "new", "value"), OLD, ids=lambda one: str(getattr(one, "__name__", ""))[:20])
def test_an_old_name_makes_the_same_noun(noun: Any, given: dict[str, Any], old: str, new: str, value: Any) -> None:
    wanted = noun(**given, **{new: value})
    with pytest.warns(DeprecationWarning, match=f"{noun.__name__}.{old} is called {new} now") as told:
        assert noun(**given, **{old: value}) == wanted
    assert told[0].filename == __file__
    with pytest.warns(DeprecationWarning):
        assert dataclasses.replace(wanted, **{old: value}) == wanted
    if old != "points":  # the property of this name is all points now
        with pytest.warns(DeprecationWarning, match=old):
            assert getattr(wanted, old) == value


def test_points_are_all_and_pins_are_those_given() -> None:
    link, plate = Link(name="a", length=2.0, pins=PIN), RigidBody(name="b", mass=1.0, inertia=1.0, pins=PIN, center=(0.5, 0.0))
    assert link.points == {"start": (0.0, 0.0), "end": (2.0, 0.0), **PIN}
    assert plate.points == {"center": (0.5, 0.0), **PIN}
    frame, weight = Frame(name="f", nodes={"A": (0.0, 0.0)}, members=()), PointMass(name="w", mass=1.0)
    for body in (frame, weight):
        with pytest.warns(DeprecationWarning, match="pins is called points now"):
            assert body.pins == body.points  # type: ignore[attr-defined]


def test_the_start_has_its_own_name() -> None:
    assert Start is StartSettings is vfife.StartSettings


@pytest.mark.filterwarnings("error")
def test_new_names_say_nothing() -> None:
    assert Torque(body="a", value=1.0).value == 1.0
    assert dataclasses.replace(Link(name="a", length=1.0), model="elastic").element_count == 4
