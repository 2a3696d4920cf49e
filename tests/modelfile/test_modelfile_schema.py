"""The JSON Schema that the package ships: it is that of the code, says what keys are, and fits what loads."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import vfife
from model_texts import FILES, FOUR_BAR, PLAYGROUND, TEMPLATES, played, with_lines
from schemas import complaints
from vfife.modelfile.jsonschema import text
from vfife.modelfile.tables import LAWS

SHIPPED = Path(vfife.__file__).parent / "modelfile" / "model.schema.json"
SCHEMA = json.loads(text())
MODELS = {path.stem: path.read_text(encoding="utf-8") for path in (*FILES, *TEMPLATES)} | {
    "everything": PLAYGROUND,
    "four-bar text": FOUR_BAR,
}


def test_the_shipped_schema_is_that_of_the_code() -> None:
    if SHIPPED.read_text(encoding="utf-8") != text():
        pytest.fail(
            "model.schema.json is not what tables and laws say; run: vfife schema -o"
            " src/vfife/modelfile/model.schema.json",
            pytrace=False,
        )


@pytest.mark.parametrize("name", MODELS)
def test_every_model_that_loads_fits_the_schema(name: str) -> None:
    assert list(complaints(tomllib.loads(MODELS[name]), SCHEMA, SCHEMA)) == []


WRONG = {
    "unknown key": with_lines("[run.x]"),
    "unknown table": FOUR_BAR.replace("[run]", "[ruin]"),
    "text": FOUR_BAR.replace('name = "four-bar"', "name = 3"),
    "missing": FOUR_BAR.replace('bearing_radius = "10 mm"', ""),
    "negative": FOUR_BAR.replace("mass = 2.028", "mass = -1"),
    "law": FOUR_BAR.replace('"pereira"', '"periera"'),
    "key of a law": FOUR_BAR.replace("restitution = 0.5", "restitutoin = 0.5"),
    "limit of a law": FOUR_BAR.replace("restitution = 0.5", "restitution = 1.5"),
    "kind": played(('kind = "weld"', 'kind = "wield"')),
    "key of another kind": played(('kind = "weld"', 'kind = "weld"\ndirection = [1, 0]')),
    "three parts": played(("direction = [0, 1]", "direction = [0, 1, 2]")),
    "one part": played(("direction = [0, 1]", "direction = [0]")),
    "elements": played(("elements = 3", "elements = 1000000")),
    "member": played(('end = "B", elements', 'edn = "B", elements')),
    "switch": played(("follow = true", 'follow = "yes"')),
    "slider of a body": played(('body = "arm"', 'body = "arm"\nslider = "guide"')),
    "bushing": played(('["1 kN/mm", 1e6, "10 N m/rad"]', "3")),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_does_not_fit(case: str) -> None:
    assert list(complaints(tomllib.loads(WRONG[case]), SCHEMA, SCHEMA))


def tables(schema: Any) -> Iterator[tuple[str, Any]]:
    """Every table of the schema that has keys, with its name."""
    yield "top", schema
    for name, one in schema["definitions"].items():
        yield from (
            ((f"{name}/{law['title']}", law) for law in one["oneOf"]) if "oneOf" in one else [(name, one)]
        )


def words(value: Any) -> Iterator[str]:
    """All words of JSON Schema in use, names of keys and tables left out."""
    if isinstance(value, dict):
        for word, inner in value.items():
            yield word
            yield from (
                (w for one in inner.values() for w in words(one))
                if word in ("properties", "definitions")
                else words(inner)
            )
    elif isinstance(value, list):
        for one in value:
            yield from words(one)


def test_every_key_says_what_it_is_with_unit_and_limits() -> None:
    for name, table in tables(SCHEMA):
        assert table["additionalProperties"] is False, name
        assert table["description"], name
        for key, entry in table["properties"].items():
            assert len(entry["description"]) > 3, (name, key)
            if '"x-unit"' in json.dumps(entry) and "allOf" not in entry:
                assert entry["description"].endswith("]"), (name, key)
    link = SCHEMA["definitions"]["LinkTable"]["properties"]
    assert link["length"]["description"] == "distance from start to end [m, above 0 m]"
    assert (
        link["elements"]["description"]
        == "number of frame elements of an elastic link [a whole number from 1 to 100000]"
    )
    assert SCHEMA["definitions"]["BushingTable"]["properties"]["stiffness"]["description"].endswith(
        "[N/m, at least 0 N/m; N m/rad, at least 0 N m/rad]"
    )


@pytest.mark.parametrize("kind", LAWS)
def test_all_laws_are_in_it_with_their_parameters(kind: str) -> None:
    told = {law["title"]: set(law["properties"]) for law in SCHEMA["definitions"][f"{kind}_law"]["oneOf"]}
    from dataclasses import fields

    ours = {name: law for name, law in LAWS[kind].registry.items() if law.__module__.startswith("vfife.")}
    assert told == {name: {"law", *(field.name for field in fields(law))} for name, law in ours.items()}


def test_editors_that_know_draft_4_only_understand_it() -> None:
    assert SCHEMA["$schema"] == "http://json-schema.org/draft-07/schema#"
    assert SCHEMA["$id"] == "urn:vfife:model"
    assert SCHEMA["title"]
    assert not {
        "prefixItems",
        "const",
        "$defs",
        "exclusiveMinimum",
        "exclusiveMaximum",
        "discriminator",
        "if",
    } & set(words(SCHEMA))
    assert '"null"' not in json.dumps(SCHEMA)
