"""The adders of a mechanism say what they take, for completion; that is what the nouns take."""

from __future__ import annotations

import dataclasses
import inspect
import typing

import pytest

from vfife.model import mechanism
from vfife.model.mechanism import Mechanism

ADDERS = [name for name, one in vars(Mechanism).items() if inspect.isfunction(one) and name[0] != "_" and name not in ("point", "drive", "ideal")]


def test_there_are_adders() -> None:
    assert {"link", "clearance", "spring", "frame"} <= set(ADDERS)


@pytest.mark.parametrize("name", ADDERS)
def test_an_adder_takes_what_its_noun_has(name: str) -> None:
    adder = getattr(Mechanism, name)
    hints = typing.get_type_hints(adder, vars(mechanism))
    noun = hints.pop("return")
    given = [one.name for one in inspect.signature(adder).parameters.values() if one.kind is not one.VAR_KEYWORD and one.name != "self"]
    options = typing.get_args(hints["options"])[0] if "options" in hints else None
    optional = list(typing.get_type_hints(options)) if options is not None else []
    fields = {field.name: field for field in dataclasses.fields(noun)}
    assert {*given, *optional} == set(fields)
    for field in optional:
        assert fields[field].default is not dataclasses.MISSING or fields[field].default_factory is not dataclasses.MISSING, field
    for one in inspect.signature(adder).parameters.values():
        if one.default is not one.empty:
            assert one.default == fields[one.name].default, one.name
    known = typing.get_type_hints(options) if options is not None else {}
    types = typing.get_type_hints(noun)
    for field in {*given, *optional} - {"name"}:
        assert {**hints, **known}[field] == types[field], field
