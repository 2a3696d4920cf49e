"""``vfife live``: a page in which a mechanism runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .options import LawsOption, SetOption, overrides, take_laws
from .terminal import amount_of_bytes, fail, sentences, tell, writing

Source = Annotated[Path, typer.Argument(metavar="MODEL|RUN", help="Model file, or the folder of a run, whose step it takes.", show_default=False)]
Out = Annotated[Path | None, typer.Option("-o", "--output", metavar="PAGE.html", help="The page.", show_default="MODEL.html")]
SLIDE = "Make this number a slider, from and to, as in joint.C.clearance=0.01..0.5mm; others than these there are none then."
Slide = Annotated[list[str] | None, typer.Option("--slide", metavar="PATH=LOW..HIGH", help=SLIDE)]
NoSlide = Annotated[bool, typer.Option("--no-sliders", help="Without any slider.")]


def live(
    source: Source, out: Out = None, slide: Slide = None, no_sliders: NoSlide = False, set_: SetOption = None, laws: LawsOption = None
) -> None:
    """Write a page in which the mechanism runs: one file, opened from disk in any browser, without a server or a network.

    It steps with the bits of vfife run --companions 0. Sliders change every clearance, the speed of drivers, friction and restitution,
    unless --slide names others.
    """
    if out is not None and not out.absolute().parent.is_dir():
        fail(f"-o {out}: there is no folder {out.absolute().parent}; make it first")
    with sentences(str(source)):
        from ..live import asked_slides, default_slides, model_of
        from ..live.page import LARGEST, written
        from ..live.patches import patched
        from ..results.folder import written as kept

        take_laws(laws)
        mechanism, step = model_of(source, overrides(set_))
        slides = [] if no_sliders else asked_slides(mechanism, slide) if slide else default_slides(mechanism)
        found = patched(mechanism, slides, step)
        page = written(found).encode("utf-8")
        place = out if out is not None else Path(f"{(source.resolve() if source.is_dir() else source).stem}.html")
        if len(page) > LARGEST:
            sizes = f"{amount_of_bytes(len(page))}, more than the {amount_of_bytes(LARGEST)} that a page may"
            raise ValueError(f"the page takes {sizes}; slide less, or use fewer elements")
    for note in found.notes:
        tell("note", f"{note}.")
    with writing(str(place)):
        kept(place, page.decode("utf-8"))
    typer.echo(f"{place}: {amount_of_bytes(len(page))}, sliders: {', '.join(one.name for one in found.slides) or 'none'}; open it in a browser.")
