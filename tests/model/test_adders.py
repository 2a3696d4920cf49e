"""The builders of a mechanism write out what they take, for editors and type checkers; that is what the nouns take."""

from __future__ import annotations

import dataclasses
import inspect
import sys
import typing

import pytest

from vfife.fields import described_fields, required
from vfife.laws import Law, Material
from vfife.model.builders import Builders
from vfife.model.mechanism import Mechanism

BUILDERS = [name for name, one in inspect.getmembers(Builders, inspect.isfunction) if name[0] != "_" and name != "point"]
# Fields that a builder leaves to others, and what it cannot do without though its noun can.
NAMED_BY = {"drive": {"direction", "slider", "point", "against"}, "torque": {"direction", "slider", "point"}, "moment": {"force", "follow"}}
NEEDED = {"drive": {"body"}, "torque": {"body"}, "moment": {"moment"}}


def test_there_are_builders() -> None:
    assert {"link", "clearance", "spring", "frame", "curved_slot"} <= set(BUILDERS)


@pytest.mark.parametrize("name", BUILDERS)
def test_a_builder_takes_what_its_noun_has(name: str) -> None:
    builder = getattr(Mechanism, name)
    hints = typing.get_type_hints(builder, vars(sys.modules[builder.__module__]))
    noun = hints["return"]
    given = {one.name: one for one in inspect.signature(builder).parameters.values() if one.name != "self"}
    assert all(one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY) for one in given.values()), "a misspelt keyword is an error"
    fields = {field.name: field for field in dataclasses.fields(noun)}
    assert set(given) == set(fields) - NAMED_BY.get(name, set())
    for field in described_fields(noun):
        if field.name not in given or field.name in NEEDED.get(name, set()):  # a table has a name, which may be the body's
            continue
        shown = given[field.name].default
        assert (shown is inspect.Parameter.empty) == required(field), field.name
        if required(field):
            continue
        default = field.default if field.default_factory is dataclasses.MISSING else field.default_factory()
        assert shown == (default.name if isinstance(default, Law | Material) else default), field.name


@pytest.mark.parametrize("name", BUILDERS)
def test_its_help_lists_its_keywords(name: str) -> None:
    builder = getattr(Mechanism, name)
    for one in inspect.signature(builder).parameters.values():
        if one.kind is one.KEYWORD_ONLY:
            assert f"\n{one.name}: " in (inspect.getdoc(builder) or ""), one.name
