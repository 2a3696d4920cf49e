"""Laws and keys of model files come from the model classes: a new law or kind needs no change in what reads
them.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from model_texts import faults, only, with_lines
from support import CONTACT_LAWS, contact_law
from vfife.laws import ContactLaw, quantity
from vfife.model import joints, mechanism
from vfife.model.mechanism import Settings, StartSettings
from vfife.modelfile import dump
from vfife.modelfile import loads as read
from vfife.modelfile.jsonschema import model_schema
from vfife.modelfile.tables import NAMED, Table, tables
from vfife.schema import PLACE, FreeList, Value, described, meaning_of


@pytest.fixture
def own_law() -> Iterator[type[ContactLaw]]:
    @dataclass(frozen=True)
    class Spring(ContactLaw):
        """A linear spring."""

        name: ClassVar[str] = "test-spring"
        stiffness: float = quantity("N/m", "stiffness", low=0.0)
        rate: float = quantity("N s/m", "damping", 0.0, low=0.0, high=5.0)
        other: float = quantity("N/m^n", "stiffness of an exponent that is known later", 0.0)
        shape: str = quantity("1", "a word", "round")

        def parameters(self, pair: Any) -> tuple[float, ...]:
            return self.stiffness, self.rate

    yield Spring
    del ContactLaw.registry["test-spring"]


def test_a_new_law_needs_no_change_here(own_law: type[ContactLaw]) -> None:
    law = (
        'law = "pereira"\nrestitution = 0.5',
        'law = "test-spring"\nstiffness = "2 kN/mm"\nrate = 2\nother = 3\nshape = "flat"',
    )
    model = read(with_lines(replace=law))
    assert model.clearances["C"].contact == own_law(stiffness=2e6, rate=2.0, other=3.0, shape="flat")  # type: ignore[call-arg]
    assert read(dump(model)) == model
    told = faults(with_lines(replace=(law[0], 'law = "test-spring"\nrate = "6 N s/m"\nshape = 3')))
    assert [line.partition(" = ")[0].partition(":")[0] for line in told] == [
        "[joint.C.contact] rate",
        "[joint.C.contact] shape",
        "[joint.C.contact] stiffness",
    ]
    assert "at most 5 N s/m" in told[0]


@pytest.mark.parametrize("law", CONTACT_LAWS, ids=lambda law: law.name)
def test_every_contact_law_is_read_and_written(law: type[ContactLaw]) -> None:
    """With numbers and words other than its defaults."""
    chosen = contact_law(law, restitution=0.7, damping="flores", effective_mass=3.0)
    values = {key: value for key, value in vars(chosen).items() if value is not None}
    lines = [f'law = "{law.name}"', *(f"{key} = {json.dumps(value)}" for key, value in values.items())]
    model = read(with_lines(replace=('law = "pereira"\nrestitution = 0.5', "\n".join(lines))))
    assert model.clearances["C"].contact == chosen
    assert read(dump(model)) == model


def test_a_damping_factor_that_is_none() -> None:
    old = 'law = "pereira"\nrestitution = 0.5'
    (told,) = faults(with_lines(replace=(old, 'law = "liu"\ndamping = "flroes"')))
    assert told.startswith('[joint.C.contact] damping = "flroes"') and 'Did you mean "flores"?' in told
    (told,) = faults(with_lines(replace=(old, 'law = "liu"\ndamping = 0.3')))
    assert "a number" in told and '"hunt-crossley"' in told


def test_surfaces_that_a_law_is_not_for_are_told_in_its_words() -> None:
    old = 'law = "pereira"\nrestitution = 0.5'
    text = with_lines(replace=(old, 'law = "pereira"')).replace('clearance = "0.2 mm"', "clearance = 9e-7")
    assert any("no exponent for a clearance of 9e-07 m" in line for line in faults(text))


SECTIONS = [("run", Settings), ("start", StartSettings), ("top", mechanism.Mechanism)]
EVERY = [
    *((section, table) for section in NAMED for table in tables(section)),
    *((name, Table(model_class)) for name, model_class in SECTIONS),
]


@pytest.mark.parametrize(
    ("section", "table"),
    EVERY,
    ids=lambda one: one if isinstance(one, str) else f"{one.model_class.__name__} {one.target}",
)
def test_every_field_of_a_class_has_its_key(section: str, table: Table) -> None:
    """A field added to a class must not get lost between file and mechanism: it says unit, meaning and what
    it holds.
    """
    header = (
        {"name"} if section in NAMED else {"source"}
    )  # the name is the table's; the source is not in the file
    target = {"body", "slider", "point", "direction", "against"} if table.target else set()
    for field in dataclasses.fields(table.model_class):
        if field.name not in header | target:
            assert field in table.fields.values(), field.name
    for key, field in table.fields.items():
        assert isinstance(table.value(key), Value) and len(meaning_of(field, table.is_linear)) > 2, key
        assert len(table.keys) == len(set(table.keys))


def test_json_schema_can_be_made() -> None:
    schema = model_schema()
    json.dumps(schema)
    clearance = schema["definitions"]["ClearanceRevoluteTable"]
    assert clearance["properties"]["clearance"]["x-unit"] == "m"
    assert clearance["additionalProperties"] is False
    for table in schema["definitions"].values():
        assert all("description" in entry for entry in table.get("properties", {}).values())


def test_a_kind_of_joint_needs_its_own_file_only() -> None:
    """Fields are all that a kind says of its table: reading, writing, limits and did-you-mean follow."""

    @dataclass(frozen=True, kw_only=True)
    class Slot(joints.Joint):
        """A pin in a slot of two ends."""

        kind: ClassVar[str] = "test-slot"
        reach: float = quantity("m", "length of the slot", above=0.0)
        way: tuple[tuple[float, float], ...] = described(FreeList(PLACE), "points on the way", ())

    lines = (
        '[joint.E]\nkind = "test-slot"\nbearing = "ground.A"\njournal = "coupler.end"\nreach = "20 mm"\nway ='
        ' [[0, "1 mm"]]'
    )
    try:
        model = read(with_lines(lines))
        assert model.joints["E"] == Slot(
            name="E", bearing="ground.A", journal="coupler.end", reach=0.02, way=((0.0, 1e-3),)
        )
        assert read(dump(model)) == model
        assert "[joint.E] reach" in only(with_lines(lines.replace("20 mm", "-2 mm")))
        assert 'Did you mean "reach"' in faults(with_lines(lines.replace("reach", "raech")))[0]
        assert 'Did you mean "test-slot"?' in faults(with_lines(lines.replace("test-slot", "test-slott")))[0]
        assert "TestSlot" not in json.dumps(model_schema()) and "test-slot" not in json.dumps(model_schema())
    finally:
        del joints.Joint.registry["test-slot"]
