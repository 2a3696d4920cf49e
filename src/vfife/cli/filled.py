"""Defaults of a model file that were filled in, found by comparing the file with its schema."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic import BaseModel

Filled = dict[str, Any]

NOUNS = ("material", "body", "joint", "gear", "spring", "driver", "load")


def filled_in(path: Path, items: Iterable[tuple[str, Any]]) -> list[Filled]:
    """Keys that neither a model file without faults nor ``--set`` gives, with the value that is taken instead."""
    from ..modelfile.override import override
    from ..modelfile.schema import STATIC_ONLY, LinkTable, ModelFile
    from ..modelfile.tables import IDLE_KEYS

    raw = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    override(raw, items)
    model = ModelFile.model_validate(raw)
    found = [*table("", model), *table("run", model.run), *table("start", model.start)]
    if model.run.analysis != "static":
        found = [one for one in found if one["path"] not in {f"run.{key}" for key in STATIC_ONLY}]
    for section in NOUNS:
        for name, entry in getattr(model, section).items():
            unused = IDLE_KEYS.get(entry.model, ()) if isinstance(entry, LinkTable) else ()
            found += [one for one in table(f"{section}.{name}", entry) if one["path"].rpartition(".")[2] not in unused]
            if section == "joint" and hasattr(entry, "contact"):
                found += [*law(f"joint.{name}", "contact", entry.contact), *law(f"joint.{name}", "friction", entry.friction)]
    return found


def table(path: str, model: BaseModel) -> Iterator[Filled]:
    """Keys with a default value that a table leaves out; empty tables and values that are derived are none."""
    for key, field in type(model).model_fields.items():
        told = key in model.model_fields_set or field.is_required() or field.default is None
        if not told and not hasattr(field.default, "model_fields_set") and field.default not in ({}, "", ()):
            meaning = field.description or ""
            yield {"path": f"{path}.{key}".lstrip("."), "value": field.default, "unit": unit(field), "meaning": meaning}


def unit(field: Any) -> str:
    """SI unit of a key, "1" where it has none."""
    return next((entry.unit for entry in field.metadata if hasattr(entry, "unit")), "1")


def law(path: str, kind: str, given: dict[str, Any]) -> Iterator[Filled]:
    """The law and its parameters that a joint leaves out."""
    from ..modelfile.lawtables import DEFAULTS
    from ..modelfile.tables import LAWS

    name = given.get("law", DEFAULTS[kind].name)
    if "law" not in given:
        yield {"path": f"{path}.{kind}.law", "value": name, "unit": "1", "meaning": f"{kind} law"}
    for field in dataclasses.fields(LAWS[kind].registry[name]):
        if field.name not in given and field.default not in (None, dataclasses.MISSING):
            told = {key: field.metadata[key] for key in ("unit", "meaning")}
            yield {"path": f"{path}.{kind}.{field.name}", "value": field.default, **told}
