"""Values of a model file set by their paths."""

from __future__ import annotations

import pytest

from model_texts import DEMO, FOUR_BAR, only, with_lines
from vfife.laws import Frictionless, LankaraniNikravesh, Pereira
from vfife.model import bodies, joints
from vfife.modelfile import load
from vfife.modelfile import loads as read


def test_numbers_and_texts_are_set_by_path() -> None:
    model = read(
        FOUR_BAR,
        [
            ("joint.C.clearance", "0.5 mm"),
            ("joint.C.contact.restitution", 0.8),
            ("joint.C.axial_length", '"6 mm"'),
            ("body.crank.mass", "2"),
            ("ground.D.0", "16 cm"),
            ("gravity", "[0, -9.81]"),
            ("run.step", "1e-6"),
            ("start.journals", "seated"),
            ("name", "another"),
        ],
    )
    joint = model.clearances["C"]
    assert (joint.clearance, joint.contact, joint.axial_length) == (5e-4, Pereira(restitution=0.8), 6e-3)
    assert model.bodies["crank"].mass == 2.0  # type: ignore[attr-defined]
    assert model.points["D"] == (0.16, 0.0)
    assert model.gravity == (0.0, -9.81)
    assert (model.settings.step, model.start.journals, model.name) == (1e-6, "seated", "another")


@pytest.mark.parametrize("alias", ["coupler-follower", "follower-coupler"])
def test_a_joint_is_named_by_its_two_bodies(alias: str) -> None:
    assert read(FOUR_BAR, [(f"joint.{alias}.clearance", "0.5 mm")]).clearances["C"].clearance == 5e-4


def test_the_ground_is_a_body_in_such_a_name() -> None:
    sets = [
        ("joint.ground-follower.kind", "clearance"),
        ("joint.follower-ground.clearance", "1 mm"),
        ("joint.D.bearing_radius", 0.01),
    ]
    assert read(FOUR_BAR, sets).clearances["D"].clearance == 1e-3


def test_what_is_set_stays_as_it_was() -> None:
    contact = {"law": "pereira"}
    model = read(FOUR_BAR, [("joint.C.contact", contact), ("joint.C.contact.restitution", 0.7)])
    assert model.clearances["C"].contact == Pereira(restitution=0.7)
    assert contact == {"law": "pereira"}


def test_two_joints_between_two_bodies_must_be_told_apart() -> None:
    text = with_lines('[joint.E]\nbearing = "coupler.start"\njournal = "follower.end"')
    assert "C or E" in only(text, [("joint.coupler-follower.clearance", "0.5 mm")])


@pytest.mark.parametrize(
    ("path", "meant"),
    [
        ("joint.C.clearence", "joint.C.clearance"),
        ("joint.coupler-folower.clearance", "joint.coupler-follower.clearance"),
        ("run.trns", "run.turns"),
        ("jiont.C.clearance", "joint.C.clearance"),
        ("body.cranc.mass", "body.crank.mass"),
        ("body.crank.mas", "body.crank.mass"),
        ("driver.crank.sped", "driver.crank.speed"),
        ("ground.D.2", "a number from 0 to 1"),
        ("name.x", "is a value, not a table"),
        ("joint", "a table, not a number"),
        ("joint..clearance", "names joined by dots"),
        ("joint.*.clearance", 'path = ["joint.C.clearance"]'),
        ("joint.*.clearence", "joint.C.clearance"),
    ],
)
def test_a_path_that_leads_nowhere_is_told(path: str, meant: str) -> None:
    told = only(FOUR_BAR, [(path, "1 mm")])
    assert meant in told
    assert path in told


def test_a_value_that_was_set_is_not_looked_for_in_the_file() -> None:
    assert "given by set" in only(FOUR_BAR, [("joint.C.clearance", "-1 mm")])
    assert "given by set" not in only(with_lines(replace=('"0.2 mm"', '"-1 mm"')))


def test_setting_a_kind_drops_what_it_has_no_use_for() -> None:
    model = load(
        DEMO,
        set=[
            ("body.coupler.model", "rigid"),
            ("joint.B.kind", "ideal"),
            ("joint.C.contact.law", "lankarani-nikravesh"),
            ("joint.D.friction.law", "none"),
        ],
    )
    coupler = model.bodies["coupler"]
    assert isinstance(coupler, bodies.Link)
    assert (coupler.model, coupler.release, coupler.stiffness_factor) == ("rigid", "none", 1.0)
    assert isinstance(model.joints["B"], joints.IdealRevolute)
    assert model.clearances["C"].contact == LankaraniNikravesh(restitution=0.5)
    assert model.clearances["D"].friction == Frictionless()
    # What was set itself is kept, and told.
    assert "does not use this" in only(
        FOUR_BAR, [("body.coupler.model", "rigid"), ("body.coupler.elements", 3)]
    )
