"""JSON Schema of a study file, for editors and validators: its keys with meanings, units and limits, from the fields that read them."""

from __future__ import annotations

import json
from typing import Any

from ..modelfile.jsonschema import DIALECT, noun_table
from ..modelfile.tables import Table
from .plan import Amount, Asked, Several, Varied
from .planfile import BESIDE, POINT, VARY

Json = dict[str, Any]
IDENTITY = "urn:vfife:study"
TITLE = "Study file of vfife"


def study_schema() -> Json:
    """The schema, in what drafts 4 and 7 have in common."""
    found = noun_table(Table(Asked), "The file", {})
    varied = noun_table(Table(Varied), "[vary.NAME]", {})
    listed = {**Several(Amount()).json(), "description": "the values of the path that the key is"}
    amounts = {"type": "object", "additionalProperties": Amount().json()}
    found["properties"] |= {
        VARY: {
            "type": "object", "additionalProperties": {"anyOf": [varied, listed]},
            "description": "what is varied, by names of your own, or by path with a list of values",
        },
        POINT: {"type": "array", "items": amounts, "description": "members one by one: a value for each parameter by its name"},
        **{name: {"type": "object", "description": "read by the commands that analyse a study"} for name in BESIDE},
    }  # fmt: skip
    found["required"] = [*found.get("required", ()), VARY]
    return {"$schema": DIALECT, "$id": IDENTITY, "title": TITLE, **found}


def text() -> str:
    """The schema as it is printed."""
    return json.dumps(study_schema(), indent=1, ensure_ascii=False) + "\n"
