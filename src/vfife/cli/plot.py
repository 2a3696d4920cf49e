"""``vfife plot``: the figures of a run."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..results.folder import FIGURES
from .ended import loaded, refuse_taken
from .options import RunArgument
from .signals import NOW
from .terminal import answer, command, fail, sentences, writing

if TYPE_CHECKING:
    from ..result import Result

LIST = "list"
PICTURES = (".png", ".svg", ".pdf")  # as plots has them; a test compares
KEPT = "The run is as it was"


OutOption = Annotated[Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="Where to; of one figure also a file, as forces.svg.",
                                                show_default="RUN/figures")]  # fmt: skip
Named = Annotated[list[str] | None, typer.Option("--figure", metavar="NAME", show_default="the usual ones",
                  help="Figure to draw, once for each; all draws every one that the run has, list says which there are.")]  # fmt: skip
As = Annotated[str, typer.Option("--format", metavar="|".join(one[1:] for one in PICTURES), help="Format of the files.")]
At = Annotated[
    str | None, typer.Option("--at", metavar="ANGLE|TIME", help="Moment at which the mechanism is drawn, as 90deg of the last turn, or 12ms.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace figures that are there.")]


def plot(run: RunArgument, figure: Named = None, out: OutOption = None, kind: As = "png", at: At = None, force: Force = False) -> None:
    """Draw figures of a run: the mechanism, journal paths, forces and accelerations over the ideal ones; more with --figure."""
    if f".{kind}" not in PICTURES:
        fail(f"--format {kind}: no figure is written as this; there are {', '.join(one[1:] for one in PICTURES)}")
    NOW.saved = f"{KEPT}, and no figure was drawn."
    names = [name for one in figure or () for name in one.split(",")]
    result, file = loaded(run)
    if LIST in names:
        listed(result)
        return
    with sentences(str(run)):
        from ..plots import chosen, refuse_beside

        if at is not None:
            refuse_beside(names)
        wanted = chosen(result, names or (["mechanism"] if at is not None else []))
    single = out is not None and out.suffix.lower() in PICTURES
    if single and len(wanted) != 1:
        fail(f"-o {out}: one file holds one figure and this draws {len(wanted)}; name one with --figure, or a folder")
    folder = file.parent / FIGURES if out is None else out
    targets = {wanted[0]: out} if single and out is not None else {name: folder / f"{name}.{kind}" for name in wanted}
    free(targets, force)
    drawn(result, targets, at, str(run))
    if not names and at is None:
        typer.echo(f"More: {command()} plot {shlex.quote(str(run))} --figure {LIST}", err=True)


def free(targets: dict[str, Path], force: bool) -> None:
    """Refuses to draw where figures are already, unless they may be replaced."""
    taken = [path for path in targets.values() if path.exists()]
    if len(targets) == 1:
        (path,) = targets.values()
        with sentences(str(path)):
            if path.exists() or path.parent.is_file():
                refuse_taken(path, force)
    elif taken and not force:
        names = ", ".join(path.name for path in taken)
        fail(f"{taken[0].parent}: there are figures already: {names}; name another folder with -o, or add --force to replace them")


def drawn(result: Result, targets: dict[str, Path], at: str | None, run: str) -> None:
    """Draws one figure after the other, each of them whole or not there."""
    from ..plots import figure
    from ..plots.style import saved

    for done, (name, path) in enumerate(targets.items(), 1):
        with sentences(run), writing(str(path), f"{KEPT}, and so is what was there before."):
            made = figure(result, name, result.reference, at)
            path.parent.mkdir(parents=True, exist_ok=True)
            saved(made, path)
        typer.echo(path)
        NOW.saved = f"{KEPT}; {done} of {len(targets)} figures were drawn, in {path.parent}."


def listed(result: Result) -> None:
    """What figures there are, and which of them the run has nothing for."""
    from ..plots.table import FIGURES
    from ..report.document import Document, Table

    rows = []
    for name, one in FIGURES.items():
        why = one.lacks(result)
        rows.append((name, one.says, f"none: {why}" if why else "usual" if one.usual else ""))
    answer(Document([Table(("figure", "shows", ""), rows)]))
