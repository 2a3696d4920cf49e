"""A value of a model by its path: read, changed, described."""

from __future__ import annotations

import dataclasses
import tomllib
from pathlib import Path

import pytest

from model_texts import FOUR_BAR
from vfife.errors import Fault, ModelError
from vfife.modelfile import dump, load, loads
from vfife.modelfile.parameter import Parameter, holds, numbers, with_values
from vfife.modelfile.write import tables_of

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_numbers_are_those_of_the_text(path: Path) -> None:
    mechanism = load(path)
    assert tables_of(mechanism) == tomllib.loads(dump(mechanism))
    for name, value in numbers(mechanism).items():
        one = Parameter(mechanism, name)
        assert (one.path, one.get()) == (name, value)


def test_a_number_set_in_an_object_is_one_that_was_read() -> None:
    mechanism = loads(FOUR_BAR)
    for name, value in numbers(mechanism).items():
        if value:
            changed = Parameter(mechanism, name).set(0.99 * value)
            assert changed == loads(dump(mechanism), [(name, 0.99 * value)]), name


def test_a_parameter_describes_itself() -> None:
    gap = Parameter(loads(FOUR_BAR), "joint.coupler-follower.clearance")
    assert (gap.path, gap.unit, gap.limits, gap.get()) == ("joint.C.clearance", "m", "above 0 m", 2e-4)
    assert gap.set("0.5 mm").clearances["C"].clearance == 5e-4
    turns = Parameter(tomllib.loads(FOUR_BAR), "run.turns")
    assert turns.set(3).settings.turns == 3.0
    assert Parameter(loads(FOUR_BAR), "run.outputs").limits == "a whole number from 1 to 100000000"


def test_several_values_are_set_together() -> None:
    mechanism = loads(FOUR_BAR)
    found = with_values(
        mechanism, {"joint.C.clearance": "0.5 mm", "material.steel.density": 7000, "body.crank.mass": 2.0}
    )
    assert found.clearances["C"].clearance == 5e-4
    assert found == loads(
        FOUR_BAR, [("joint.C.clearance", 5e-4), ("material.steel.density", 7000), ("body.crank.mass", 2.0)]
    )
    assert found != mechanism


def test_a_value_that_cannot_be_is_refused() -> None:
    mechanism = loads(FOUR_BAR)
    with pytest.raises(ValueError, match="negative"):
        Parameter(mechanism, "joint.C.clearance").set("-1 mm")
    with pytest.raises(ModelError, match="negative"):
        Parameter(mechanism, "material.steel.density").set(-1.0)
    with pytest.raises(Fault, match="clearance"):
        Parameter(mechanism, "joint.C.clearence")
    with pytest.raises(Fault, match="no number"):
        Parameter(mechanism, "joint.C.contact").read(1.0)


def test_numbers_of_shared_materials_and_other_values_are_held_by_no_object() -> None:
    mechanism = loads(FOUR_BAR)
    assert holds(mechanism, "joint.C.clearance", 2e-4)
    assert not holds(mechanism, "joint.C.clearance", 3e-4)
    assert not holds(mechanism, "material.steel.density", 7800.0)
    assert not holds(dataclasses.replace(mechanism, joints={}), "joint.C.clearance", 2e-4)
