"""``vfife laws``: contact and friction laws with their sources, formulas and parameters, and a law by itself in numbers and a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .options import JsonOption, LawsOption, positive, take_laws
from .terminal import answer, fail, sentences, writing

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
    from ..report.laws import law_details, law_list

    answer((law_list if name is None and not long else law_details)(found), as_json)


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
    from ..report.laws import described

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
