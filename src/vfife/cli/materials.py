"""``vfife materials``: the materials that a model may name."""

from __future__ import annotations

from typing import Any

from .options import JsonOption
from .terminal import grid, output, print_json, row


def materials(as_json: JsonOption = False) -> None:
    """Materials that a model may name, with their numbers and where these are from."""
    found = listed()
    if as_json:
        print_json(found)
        return
    from rich.text import Text

    heads = ("material", "Young's modulus, GPa", "Poisson's ratio", "density, kg/m³", "hardness, GPa", "what it is", "source")
    table = grid(*heads, right=(1, 2, 3, 4))
    sources = list(dict.fromkeys(source for one in found for source in (one["source"], one["hardness_source"]) if source))
    for one in found:
        numbers = (f"{1e-9 * one['youngs_modulus']:.4g}", f"{one['poissons_ratio']:.4g}", f"{one['density']:.4g}")
        hard = "" if one["hardness"] is None else f"{1e-9 * one['hardness']:.3g}"
        from_where = ", ".join(f"[{1 + sources.index(source)}]" for source in (one["source"], one["hardness_source"]) if source)
        row(table, one["name"], *numbers, hard, one["meaning"], from_where)
    console = output()
    console.print(table)
    for number, source in enumerate(sources, 1):
        console.print(Text(f"[{number}] {source}"))
    console.print()
    console.print(Text("A table [material.NAME] in a model file adds a material, or takes the place of one of these."))


def listed() -> list[dict[str, Any]]:
    """Name, Young's modulus (Pa), Poisson's ratio, density (kg/m^3), meaning, source, and hardness (Pa) with its source, of each."""
    from ..laws.materials import HARDNESS, TABLE

    keys, none = ("youngs_modulus", "poissons_ratio", "density", "meaning", "source"), (None, None)
    return [
        {"name": name, **dict(zip(keys, entry, strict=True)), **dict(zip(("hardness", "hardness_source"), HARDNESS.get(name, none), strict=True))}
        for name, entry in TABLE.items()
    ]
