"""The reference of model files, made from the JSON Schema that the package ships: every key with its meaning,
unit, limits and default. ``make texts`` writes it into the page.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from tables import cell, framed, grid

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = ROOT / "src" / "vfife" / "modelfile" / "model.schema.json"
PAGE = "model-reference"
TITLES = {
    "run": "How long, how fine", "start": "How it starts", "material": "Materials", "ground": "Ground",
    "body": "Bodies", "joint": "Joints", "spring": "Springs, dampers, stops", "driver": "Drivers",
    "load": "Loads", "gear": "Gears and belts",
}  # fmt: skip
HEAD = ("key", "meaning", "unit, limits", "default")
BRACKET = re.compile(r" \[([^\]]+)\]$")
LAWS = {
    "contact_law": "[contact law](laws-gallery.md#contact-laws)",
    "friction_law": "[friction law](laws-gallery.md#friction-laws)",
}


def rows(table: dict[str, Any]) -> list[tuple[str, ...]]:
    """The keys of a table, those that must be given first."""
    must = table.get("required", [])
    found = []
    for key, value in sorted(table["properties"].items(), key=lambda one: one[0] not in must):
        text = value.get("description", "")
        limits = BRACKET.search(text)
        default = (
            json.dumps(value["default"], ensure_ascii=False)
            if "default" in value
            else "must be given"
            if key in must
            else ""
        )
        told = [f"`{default}`" if "default" in value else default]
        found.append(
            (f"`{key}`", meaning(value, BRACKET.sub("", text)), cell(limits[1]) if limits else "", *told)
        )
    return found


def meaning(value: dict[str, Any], text: str) -> str:
    """What a key is; the words that it may be, and where the tables of laws are told."""
    words = value.get("enum", ())
    law = next((LAWS[name] for name in LAWS if name in json.dumps(value)), "")
    if law:
        return f"{cell(text)}: a {law}"
    return (
        cell(text)
        if len(words) < 2
        else f"{cell(text)}: {', '.join(f'`{json.dumps(word)}`' for word in words)}"
    )


def section(head: str, table: dict[str, Any]) -> str:
    """A table of the file: its heading unless it is the only one, how it is begun, its keys."""
    where, _, text = table["description"].partition(": ")
    title = f"### {head}\n\n" if head else ""
    return f"{title}`{where}`\n: {cell(text)}\n\n{keys(table)}"


def keys(table: dict[str, Any]) -> str:
    """The keys of a table."""
    return grid(HEAD, rows(table))


def spoken(name: str, where: str) -> str:
    """The heading of a table: the word by which a file chooses it, or what it is called."""
    word = re.search(r' = "([^"]+)"', where)
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name.removesuffix("Table")).lower()
    return word[1] if word else plain


def page() -> str:
    """The reference, in Markdown."""
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    definitions, parts, told = schema["definitions"], [], set()
    top = {"properties": {key: value for key, value in schema["properties"].items() if key not in TITLES}}
    parts.append(f"## At the top\n\n{keys(top)}")
    for key, title in TITLES.items():
        value = schema["properties"][key]
        names = [
            one for one in re.findall(r'"#/definitions/(\w+)"', json.dumps(value)) if one.endswith("Table")
        ]
        parts.append(f"## {title}")
        if not names:
            parts.append(f'`[{key}]`\n: {cell(value["description"])}, as in `NAME = ["100 mm", 0]`')
        for name in names:
            described = definitions[name]["description"]
            parts.append(
                section(
                    spoken(name, described.partition(": ")[0]) if len(names) > 1 else "", definitions[name]
                )
            )
        told.update(names)
    inner = [name for name in definitions if name.endswith("Table") and name not in told]
    parts.append("## Tables within tables")
    parts += [section(spoken(name, ""), definitions[name]) for name in inner]
    return "\n\n".join(parts)


def fill(app: Any, docname: str, source: list[str]) -> None:
    """Put the tables of the page into frames before it is read."""
    if docname == PAGE:
        source[0] = framed(source[0])


def setup(app: Any) -> dict[str, bool]:
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
