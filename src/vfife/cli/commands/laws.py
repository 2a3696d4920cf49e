"""``vfife laws`` and ``vfife materials``: the laws there are, with their sources, units and forms; a free
impact through one of them.
"""

from __future__ import annotations

from typing import Any

from ...errors import suggestion
from ...laws import ContactLaw, FrictionLaw
from ...laws.check import USUAL, comparison, faults, needed
from ...report.laws import described, law_details, law_list
from ...report.laws import materials as material_list
from ..arguments.models import LawsOptions, MaterialsOptions
from ..terminal import answer, fail, sentences
from ..values import take_laws


def laws(options: LawsOptions) -> None:
    """Run ``vfife laws``."""
    with sentences("laws"):
        user_laws = take_laws(options.laws)
        loops = compared_loops(user_laws)
        descriptions = [
            {**law, "compared": loops[law["name"]]} if law["name"] in loops else law
            for law in chosen(options.name)
        ]
        if options.plot:
            if options.name is None:
                raise ValueError("--plot: name the law to draw, as in vfife laws pereira --plot")
            from .law_drawing import draw_law

            descriptions = [{**law, **draw_law(law, options)} for law in descriptions]
    answer(
        (law_list if options.name is None and not options.long else law_details)(descriptions),
        options.as_json,
    )


def compared_loops(names: list[str]) -> dict[str, str]:
    """In which loops laws of the user's own were compared with Python, by name. Raises ValueError where one
    cannot be used.
    """
    if not names:
        return {}
    registered = [
        base.registry[name] for name in names for base in (ContactLaw, FrictionLaw) if name in base.registry
    ]
    if messages := [fault for law in registered for fault in faults(law)]:
        raise ValueError("\n".join(f"--laws {fault}" for fault in messages))
    return comparison([(law(), USUAL) for law in registered if not needed(law)])


def chosen(name: str | None) -> list[dict[str, Any]]:
    """Descriptions of the laws of a name, else of all."""
    all_laws = list(described())
    if name is None:
        return all_laws
    named = [law for law in all_laws if law["name"] == name.lower()]
    if not named:
        fail(
            f"there is no law {name!r}."
            f" {suggestion(name.lower(), [law['name'] for law in all_laws], 'name one of them').capitalize()}"
        )
    return named


def materials(options: MaterialsOptions) -> None:
    """Run ``vfife materials``."""
    answer(material_list(), options.as_json)
