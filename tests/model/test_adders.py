"""The builders of a mechanism are made of the fields of its kinds; a stub writes them out for editors and
type checkers.
"""

from __future__ import annotations

import inspect

import pytest

import vfife
from model.stubs import STUB, stub
from vfife.errors import ModelError
from vfife.model.bodies import Link
from vfife.model.builders import builders
from vfife.model.mechanism import Mechanism
from vfife.schema import required

BUILDERS = builders()


def test_the_stub_is_that_of_the_kinds() -> None:
    assert STUB.read_text("utf-8") == stub(), "run python tests/model/stubs.py"
    assert {"link", "clearance_joint", "spring", "frame", "curved_slot", "moment", "drive"} <= set(BUILDERS)


@pytest.mark.parametrize("name", BUILDERS)
def test_a_builder_takes_what_its_kind_has(name: str) -> None:
    builder = getattr(Mechanism, name)
    given = {one.name: one for one in inspect.signature(builder).parameters.values() if one.name != "self"}
    assert all(one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY) for one in given.values()), (
        "a misspelt keyword is an error"
    )
    for key, field in BUILDERS[name].fields.items():
        assert required(field) <= (given[key].default is inspect.Parameter.empty), key
        if given[key].kind is inspect.Parameter.KEYWORD_ONLY:
            assert f"\n{key}: " in (inspect.getdoc(builder) or ""), key


def test_what_is_made_is_added_with_the_checks_of_its_builder() -> None:
    m = Mechanism("m")
    m.point("O", 0, 0)
    rod = m.add(vfife.bodies.Link(name="rod", length=1.0, mass=1.0))
    m.add(vfife.joints.IdealRevolute(name="J", bearing="ground.O", journal="rod.start"))
    m.add(vfife.drivers.ConstantSpeed(body="rod", speed=3.0))
    other = Mechanism("m")
    other.point("O", 0, 0)
    other.link("rod", length=1, mass=1)
    other.revolute("J", "ground.O", "rod.start")
    other.drive("rod", speed=3)
    assert m == other and rod is m.bodies["rod"]
    for wrong, words in (
        (vfife.bodies.Link(name="rod", length=1.0), "there is a body called"),
        (vfife.bodies.Link(name="arm", length=-1.0, mass=1.0), "negative"),
        (vfife.joints.IdealRevolute(name="K", bearing="ground.O", journal="rod.begin"), "rod has no pin"),
    ):
        with pytest.raises(ModelError, match=words):
            m.add(wrong)
    with pytest.raises(TypeError, match="a mechanism has no Material"):
        m.add(vfife.Material("x", youngs_modulus=1.0, poissons_ratio=0.3, density=1.0))
    assert m == other


def test_pins_and_objects_stand_for_their_names() -> None:
    m, named = Mechanism("m"), Mechanism("m")
    pivot = m.point("O", 0, 0)
    crank = m.link("crank", length="100 mm", mass=1)
    plate = m.rigid_body("plate", mass=1, inertia=1, pins={"eye": (0.1, 0)})
    m.revolute("A", pivot, crank.start)
    guide = m.slider("G", pivot, plate.pin("eye"))
    m.clearance_joint("C", crank.end, plate.pin(), clearance="0.1 mm", bearing_radius="10 mm")
    m.torsional_spring("T", "ground", crank, stiffness=3)
    m.drive(crank, speed="10 rpm")
    m.ramp(slider=guide, speed=1, duration=2)
    named.point("O", 0, 0)
    named.link("crank", length="100 mm", mass=1)
    named.rigid_body("plate", mass=1, inertia=1, pins={"eye": (0.1, 0)})
    named.revolute("A", "ground.O", "crank.start")
    named.slider("G", "ground.O", "plate.eye")
    named.clearance_joint("C", "crank.end", "plate.center", clearance="0.1 mm", bearing_radius="10 mm")
    named.torsional_spring("T", "ground", "crank", stiffness=3)
    named.drive("crank", speed="10 rpm")
    named.ramp(slider="G", speed=1, duration=2)
    assert m == named and m.to_toml() == named.to_toml()
    assert (crank.end, crank.end.body, crank.end.name) == ("crank.end", "crank", "end")
    with pytest.raises(ModelError, match='Did you mean "eye"'):
        plate.pin("eyes")


def test_an_item_takes_texts_with_units_as_its_builder_does() -> None:
    m = Mechanism("m")
    rod = m.add(Link(name="rod", length="200 mm", mass="3 g"))  # type: ignore[arg-type]
    assert (rod.length, m.bodies["rod"].mass) == (0.2, 0.003)


def test_the_old_name_of_the_joint_with_clearance_works() -> None:
    m = Mechanism("m")
    m.point("O", 0, 0)
    m.link("rod", length=1, mass=1)
    with pytest.warns(DeprecationWarning, match="clearance_joint"):
        m.clearance("C", "ground.O", "rod.start", clearance="0.1 mm", bearing_radius="10 mm")
    assert m.clearances["C"].clearance == 1e-4
