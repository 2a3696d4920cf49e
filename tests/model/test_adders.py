"""The builders of a mechanism are made of the fields of its kinds; a stub writes them out for editors and
type checkers.
"""

from __future__ import annotations

import inspect

import pytest

import vfife
from model.stubs import STUB, stub
from vfife.errors import ModelError
from vfife.model.builders import builders
from vfife.model.mechanism import Mechanism
from vfife.schema import required

BUILDERS = builders()


def test_the_stub_is_that_of_the_kinds() -> None:
    assert STUB.read_text("utf-8") == stub(), "run python tests/model/stubs.py"
    assert {"link", "clearance", "spring", "frame", "curved_slot", "moment", "drive"} <= set(BUILDERS)


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
    rod = m.add(vfife.Link(name="rod", length=1.0, mass=1.0))
    m.add(vfife.IdealRevolute(name="J", bearing="ground.O", journal="rod.start"))
    m.add(vfife.ConstantSpeed(body="rod", speed=3.0))
    other = Mechanism("m")
    other.point("O", 0, 0)
    other.link("rod", length=1, mass=1)
    other.revolute("J", "ground.O", "rod.start")
    other.drive("rod", speed=3)
    assert m == other and rod is m.bodies["rod"]
    for wrong, words in (
        (vfife.Link(name="rod", length=1.0), "there is a body called"),
        (vfife.Link(name="arm", length=-1.0, mass=1.0), "negative"),
        (vfife.IdealRevolute(name="K", bearing="ground.O", journal="rod.begin"), "rod has no pin"),
    ):
        with pytest.raises(ModelError, match=words):
            m.add(wrong)
    with pytest.raises(TypeError, match="a mechanism has no Material"):
        m.add(vfife.Material("x", youngs_modulus=1.0, poissons_ratio=0.3, density=1.0))
    assert m == other
