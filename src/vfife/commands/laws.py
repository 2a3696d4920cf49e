"""``vfife laws``: contact and friction laws with their sources, formulas and parameters."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from .options import JsonOption
from .terminal import fail, grid, output, print_json, row


def laws(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="One law only.", show_default=False)] = None,
    as_json: JsonOption = False,
) -> None:
    """Contact and friction laws: source, formula, parameters with units and defaults."""
    found = list(described())
    if name is not None:
        known = [law["name"] for law in found]
        found = [law for law in found if law["name"] == name.lower()]
        if not found:
            near = difflib.get_close_matches(name.lower(), known, 1)
            fail(f"there is no law {name!r}; " + (f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}"))
    if as_json:
        print_json(found)
        return
    for law in found:
        show(law)


def described() -> Iterator[dict[str, Any]]:
    """Every law, contact laws first, in the order of their names."""
    from ..laws import ContactLaw, FrictionLaw

    for kind, base in (("contact", ContactLaw), ("friction", FrictionLaw)):
        for name, law in sorted(base.registry.items()):
            yield {
                "name": name,
                "kind": kind,
                "source": law.source,
                "formula": law.formula,
                "parameters": [parameter(field) for field in dataclasses.fields(law)],
            }


def parameter(field: dataclasses.Field[Any]) -> dict[str, Any]:
    """A parameter of a law: null as default means that it is derived, and that there is none if it is ``required``."""
    required = field.default is dataclasses.MISSING
    entry = {"name": field.name, "unit": field.metadata.get("unit", "1"), "meaning": field.metadata.get("meaning", "")}
    return {**entry, "default": None if required else field.default, "required": required}


def show(law: dict[str, Any]) -> None:
    """A law for people."""
    from rich.text import Text

    console = output()
    console.print(Text.assemble((law["name"], "bold"), f"  ({law['kind']} law)"))
    console.print(Text(f"  {law['formula']}", style="cyan"))
    console.print(Text(f"  {law['source']}"))
    if law["parameters"]:
        table = grid("parameter", "unit", "default", "meaning")
        for one in law["parameters"]:
            default = "required" if one["required"] else "derived" if one["default"] is None else f"{one['default']:g}"
            row(table, one["name"], one["unit"], default, one["meaning"])
        console.print(table)
    else:
        console.print()
