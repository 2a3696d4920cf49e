"""``vfife laws``: contact and friction laws with their sources, formulas and parameters, and a law by itself in numbers and a picture."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import JsonOption, LawsOption, positive, take_laws
from .terminal import fail, grid, output, print_json, row, sentences, writing

Size = Annotated[str, typer.Option(metavar="LENGTH", help="Of the pair of surfaces.")]
MaterialOption = Annotated[str, typer.Option("--material", metavar="NAME", help='Of both surfaces, or "bearing,journal"; see `vfife materials`.')]
Parameter = Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter of the law, as in restitution=0.7.")]
Picture = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="Where to draw.", show_default="NAME.png")]


def laws(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="One law only.", show_default=False)] = None,
    long: Annotated[bool, typer.Option("--long", help="All that is known of each law, instead of a line.")] = False,
    plot: Annotated[bool, typer.Option("--plot", help="Draw the law: a free impact, or friction over sliding velocity.")] = False,
    picture: Picture = None,
    clearance: Size = "0.2 mm",
    bearing_radius: Size = "10 mm",
    axial_length: Size = "20 mm",
    material: MaterialOption = "steel",
    mass: Annotated[str, typer.Option(metavar="MASS", help="Of a free impact.")] = "1 kg",
    speed: Annotated[str, typer.Option(metavar="SPEED", help="Of a free impact.")] = "1 m/s",
    normal_force: Annotated[str, typer.Option(metavar="FORCE", help="Under which friction is shown.")] = "100 N",
    set_: Parameter = None,
    laws: LawsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Contact and friction laws, a line each; of one that is named source, formula, parameters with units, defaults and limits.

    With --plot a law by itself: a contact law in free impacts (force over penetration, restitution delivered), a friction law in steady
    sliding, with the loops before it slides where it remembers.
    """
    with sentences("laws"):
        own = take_laws(laws)
        told = tried(own)
        found = [{**law, "compared": told[law["name"]]} if law["name"] in told else law for law in chosen(name, own)]
        if plot:
            if name is None:
                raise ValueError("--plot: name the law to draw, as in vfife laws pereira --plot")
            pair_of = (clearance, bearing_radius, axial_length, material)
            sizes = positive("--mass", mass, "kg"), positive("--speed", speed, "m/s"), positive("--normal-force", normal_force, "N")
            found = [{**law, **by_itself(law, pair_of, sizes, set_, picture)} for law in found]
    if as_json:
        print_json(found)
        return
    if name is None and not long:
        show_list(found)
        return
    for law in found:
        show(law)


def tried(own: list[str]) -> dict[str, str]:
    """In which loops laws of the user's own were compared with Python, by name. Raises ValueError where one cannot be used."""
    if not own:
        return {}
    from ..laws import ContactLaw, FrictionLaw
    from ..laws.check import USUAL, comparison, faults, needed

    known = [base.registry[name] for name in own for base in (ContactLaw, FrictionLaw) if name in base.registry]
    if told := [fault for law in known for fault in faults(law)]:
        raise ValueError("\n".join(f"--laws {fault}" for fault in told))
    return comparison([(law(), USUAL) for law in known if not needed(law)])


def chosen(name: str | None, own: list[str]) -> list[dict[str, Any]]:
    """The laws to tell of: those of a name, else all."""
    found = list(described())
    if name is None:
        return found
    from ..errors import suggestion

    these = [law for law in found if law["name"] == name.lower()]
    if not these:
        fail(f"there is no law {name!r}. {suggestion(name.lower(), [law['name'] for law in found], 'name one of them').capitalize()}")
    return these


def by_itself(law: dict[str, Any], pair_of: tuple[str, ...], sizes: tuple[float, ...], texts: Any, picture: Path | None) -> dict[str, Any]:
    """Numbers of a law by itself, and the file with its picture."""
    from ..laws import ContactLaw, FrictionLaw
    from . import lawplot

    clearance, radius, length, material = pair_of
    bearing, _, journal = material.partition(",")
    pair = lawplot.surfaces(clearance, radius, length, (bearing.strip(), journal.strip() or bearing.strip()))
    base: Any = ContactLaw if law["kind"] == "contact" else FrictionLaw
    noun: Any = lawplot.made(base.registry[law["name"]], law["kind"], texts, pair)
    target = lawplot.target_of(picture, law["name"])
    mass, speed, normal = sizes
    numbers, what = lawplot.contact(noun, pair, mass, speed) if law["kind"] == "contact" else lawplot.friction(noun, pair, normal)
    from ..plots.laws import drawn

    with writing(str(target), "What was there is as it was."):
        drawn(law["kind"], target, **what)
    return {"derived": noun.derived(pair), "units": noun.units(pair), "numbers": numbers, "picture": str(target)}


def described() -> Iterator[dict[str, Any]]:
    """Every law, contact laws first, in the order of their names."""
    from ..laws import ContactLaw, FrictionLaw
    from ..laws.law import built_in

    for kind, base in (("contact", ContactLaw), ("friction", FrictionLaw)):
        for name, law in sorted(base.registry.items()):
            yield {
                "name": name,
                "kind": kind,
                "own": not built_in(law),
                "source": law.source,
                "formula": law.formula,
                "parameters": [parameter(field) for field in dataclasses.fields(law)],
                "slots": list(law.slots),
            }


def parameter(field: dataclasses.Field[Any]) -> dict[str, Any]:
    """A parameter of a law; a default of null is derived from the surfaces, and there is none where a value has to be given."""
    entry = {"name": field.name, "unit": field.metadata.get("unit", "1"), "meaning": field.metadata.get("meaning", "")}
    entry |= {limit: field.metadata[limit] for limit in ("above", "low", "high") if field.metadata.get(limit) is not None}
    return entry if field.default is dataclasses.MISSING else {**entry, "default": field.default}


def limits(one: dict[str, Any]) -> str:
    """Limits of a parameter in words."""
    words = {"above": "above", "low": "at least", "high": "at most"}
    return ", ".join(f"{words[limit]} {one[limit]:g}" for limit in words if limit in one)


def show_list(found: list[dict[str, Any]]) -> None:
    """A line for each law, and how to see more of it."""
    from rich.text import Text

    console, widest = output(), max(len(law["name"]) for law in found) + 2
    for kind in ("contact", "friction"):
        console.print(Text(f"{kind.capitalize()} laws", style="bold"))
        for law in found:
            if law["kind"] == kind:
                line = Text.assemble((law["name"].ljust(widest), "cyan"), "(your own) " * law["own"], " ".join(law["source"].split()))
                console.print(line, no_wrap=True, overflow="ellipsis")
    console.print(Text("Formula, parameters and limits of one: vfife laws NAME; by itself in numbers and a picture: vfife laws NAME --plot."))


def show(law: dict[str, Any]) -> None:
    """A law for people."""
    from rich.padding import Padding
    from rich.text import Text

    console = output()
    console.print(Text.assemble((law["name"], "bold"), f"  ({law['kind']} law{', your own' if law['own'] else ''})"))
    console.print(Padding(Text(law["formula"], style="cyan"), (0, 0, 0, 2)))
    console.print(Padding(Text(law["source"]), (0, 0, 0, 2)))
    if "compared" in law:
        console.print(Padding(Text(f"Compared: {law['compared']}."), (0, 0, 0, 2)))
    if law["parameters"]:
        table = grid("parameter", "unit", "default", "limits", "meaning")
        for one in law["parameters"]:
            default = "derived" if one.get("default", "to be given") is None else one.get("default", "to be given")
            row(table, one["name"], one["unit"], f"{default:g}" if isinstance(default, float) else default, limits(one), one["meaning"])
        console.print(table)
    else:
        console.print()
    if "picture" in law:
        from .check import with_unit
        from .lawplot import show as show_numbers

        derived = ", ".join(f"{name} {with_unit(value, law['units'][name])}" for name, value in law["derived"].items())
        console.print(Text(f"For these surfaces: {derived}" if derived else ""))
        show_numbers(law["numbers"])
        console.print(Text.assemble(("Picture: ", "bold"), law["picture"]))
