"""The gallery of laws: each with formula, source, parameters and a picture of it by itself, as
`vfife laws NAME --plot` draws it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tables import cell, grid

PAGE = "laws-gallery"
PICTURES = "laws"  # in the folder of what is made
GIVEN = {  # what has no default, for the pictures
    "anagnostopoulos": ("stiffness=1e8 N/m", "effective_mass=1 kg"),
    "impact": ("stiffness=6.6e10", "exponent=1.5", "damping_coefficient=1e5", "full_damping_depth=20 um"),
    "kelvin-voigt": ("stiffness=1e8 N/m", "damping_coefficient=2e3"),
    "table": (
        "loading=[[0, 0], [2e-5, 1500], [5e-5, 4500], [1e-4, 10000]]",
        "unloading=[[0, 0], [5e-5, 3000], [1e-4, 10000]]",
    ),
}
WITHOUT = ("none",)
TITLES = {
    "contact": (
        "Contact laws",
        "A journal of 1 kg strikes its bearing at 1 m/s (radius 10 mm, clearance 0.2 mm, 20 mm long, "
        "steel). Left: force over penetration, loading "
        "and unloading. Right: restitution of the free impact over the restitution given as parameter.",
    ),
    "friction": (
        "Friction laws",
        "Friction force of steady sliding over the velocity, under 100 N. For laws with memory, a second "
        "diagram shows small oscillations.",
    ),
}


def told() -> list[dict[str, Any]]:
    """All laws, as the command line has them."""
    from vfife.report.laws import described

    return [law for law in described() if not law["own"]]


def pictures(folder: Path) -> None:
    """A picture of each law."""
    from vfife.cli.commands import law_drawing as lawplot
    from vfife.laws import ContactLaw, FrictionLaw
    from vfife.plots.laws import save_law

    folder.mkdir(parents=True, exist_ok=True)
    lawplot.RESTITUTIONS = tuple(
        round(0.1 * k, 1) for k in range(1, 11)
    )  # half as many impacts as the command computes: the curves are smooth
    pair = lawplot.surfaces("0.2 mm", "10 mm", "20 mm", ("steel", "steel"))
    for law in told():
        if law["name"] not in WITHOUT:
            base: Any = ContactLaw if law["kind"] == "contact" else FrictionLaw
            noun: Any = lawplot.build_law(
                base.registry[law["name"]], law["kind"], GIVEN.get(law["name"]), pair
            )
            _, what = (
                lawplot.contact(noun, pair, 1.0, 1.0)
                if law["kind"] == "contact"
                else lawplot.friction(noun, pair, 100.0)
            )
            save_law(law["kind"], folder / f"{law['kind']}-{law['name']}.png", **what)


def section(law: dict[str, Any]) -> str:
    """A law on its page."""
    from vfife.report.laws import limits

    name, kind = law["name"], law["kind"]
    parts = [f"### {name}", f"```text\n{law['formula']}\n```"]
    if name not in WITHOUT:
        given = f", with {', '.join(one.replace('=', ' = ') for one in GIVEN[name])}" if name in GIVEN else ""
        parts.append(
            f"```{{image}} _made/{PICTURES}/{kind}-{name}.png\n:class: drawn\n"
            f":alt: diagrams of the law {name}{given}\n```"
        )
        parts += [f"Drawn{given.replace(', with', ' with')}."] if given else []
    if law["parameters"]:
        default = [one.get("default", "must be given") for one in law["parameters"]]
        shown = [
            "derived" if one is None else f"{one:g}" if isinstance(one, float) else str(one)
            for one in default
        ]
        told_of = zip(law["parameters"], shown, strict=True)
        rows = [
            (f"`{one['name']}`", cell(one["meaning"]), cell(one["unit"]), limits(one), text)
            for one, text in told_of
        ]
        head = ("parameter", "meaning", "unit", "limits", "default")
        parts.append(f"::::{{container}} keys\n{grid(head, rows)}\n::::")
    return "\n\n".join([*parts, f"*Source*: {cell(law['source'])}"])


def page() -> str:
    """All laws, in Markdown."""
    parts = []
    for kind, (title, text) in TITLES.items():
        parts += [f"## {title}", text, *(section(law) for law in told() if law["kind"] == kind)]
    return "\n\n".join(parts)


def fill(app: Any, docname: str, source: list[str]) -> None:
    """Puts them into their page before that is read."""
    if docname == PAGE:
        app.env.note_dependency(str(Path(app.srcdir) / "_made" / "made-of"))
        app.env.note_dependency(__file__)
        source[0] = source[0].replace("@LAWS@", page())


def setup(app: Any) -> dict[str, bool]:
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
