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
    """A parameter of a law; a default of null is derived from the surfaces, and there is none where a value has to be given."""
    entry = {"name": field.name, "unit": field.metadata.get("unit", "1"), "meaning": field.metadata.get("meaning", "")}
    return entry if field.default is dataclasses.MISSING else {**entry, "default": field.default}


def show(law: dict[str, Any]) -> None:
    """A law for people."""
    from rich.padding import Padding
    from rich.text import Text

    console = output()
    console.print(Text.assemble((law["name"], "bold"), f"  ({law['kind']} law)"))
    console.print(Padding(Text(law["formula"], style="cyan"), (0, 0, 0, 2)))
    console.print(Padding(Text(law["source"]), (0, 0, 0, 2)))
    if not law["parameters"]:
        console.print()
        return
    table = grid("parameter", "unit", "default", "meaning")
    for one in law["parameters"]:
        default = "derived" if one.get("default", "to be given") is None else one.get("default", "to be given")
        row(table, one["name"], one["unit"], f"{default:g}" if isinstance(default, float) else default, one["meaning"])
    console.print(table)
