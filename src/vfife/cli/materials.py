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

    table = grid("material", "Young's modulus, GPa", "Poisson's ratio", "density, kg/m³", "what it is", "source", right=(1, 2, 3))
    sources = list(dict.fromkeys(one["source"] for one in found))
    for one in found:
        numbers = (f"{1e-9 * one['youngs_modulus']:.4g}", f"{one['poissons_ratio']:.4g}", f"{one['density']:.4g}")
        row(table, one["name"], *numbers, one["meaning"], f"[{1 + sources.index(one['source'])}]")
    console = output()
    console.print(table)
    for number, source in enumerate(sources, 1):
        console.print(Text(f"[{number}] {source}"))
    console.print()
    console.print(Text("A table [material.NAME] in a model file adds a material, or takes the place of one of these."))


def listed() -> list[dict[str, Any]]:
    """Name, Young's modulus (Pa), Poisson's ratio, density (kg/m^3), meaning and source of each."""
    from ..laws.materials import TABLE

    keys = ("youngs_modulus", "poissons_ratio", "density", "meaning", "source")
    return [{"name": name, **dict(zip(keys, entry, strict=True))} for name, entry in TABLE.items()]
