"""What to do with a study that was made, or that is still growing: show, draw, export."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .ended import ForceFile, refuse_ending, refuse_taken
from .membered import FileArgument as FileArgument
from .options import JsonOption
from .terminal import amount_of_bytes, answer, sentences, writing

if TYPE_CHECKING:
    from ..results.studied import Study

Members = Annotated[bool, typer.Option("--members", help="Every member with what it came to.")]


def show(file: FileArgument, members: Members = False, as_json: JsonOption = False) -> None:
    """What a study came to so far: each measure's least, mean and largest value and where, and what failed."""
    found = read(file)
    from ..report.study import document

    answer(document(found, members), as_json)


def read(file: Path) -> Study:
    """A study as its file has it now."""
    with sentences(str(file)):
        from ..results.studied import Study

        found = Study.open(file)
    return found


ENDINGS = (".csv", ".nc", ".parquet")


def export(
    file: FileArgument,
    target: Annotated[Path, typer.Argument(metavar="OUT", help="File to write: .csv, .nc or .parquet.", show_default=False)],
    force: ForceFile = False,
) -> None:
    """Write a study as a table of its members (CSV, Parquet) or a labelled dataset (NetCDF), with units."""
    with sentences(str(target)):
        refuse_ending(target, ENDINGS)
        refuse_taken(target, force)
    found = read(file)
    with sentences(str(file)), writing(str(target), "The study is as it was, and so is what was there before."):
        found.export(target)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)})")


FiguresOption = Annotated[Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="Where to.", show_default="FILE-figures")]
FigureOption = Annotated[list[str] | None, typer.Option("--figure", metavar="NAME", help="maps, curves, parallel or fronts; all unless named.")]
MeasureOption = Annotated[list[str] | None, typer.Option("--measure", metavar="NAME", help="A measure to draw, in this order; all unless named.")]
LargerOption = Annotated[
    list[str] | None, typer.Option("--maximise", metavar="NAME", help="A measure that is better the larger it is; may be repeated.")
]
Kind = Annotated[str, typer.Option("--kind", metavar="KIND", help="png, svg or pdf.")]


def plot(
    file: FileArgument,
    folder: FiguresOption = None,
    figure: FigureOption = None,
    measure: MeasureOption = None,
    maximise: LargerOption = None,
    kind: Kind = "png",
) -> None:
    """Draw a study: heat maps, curves with bands, parallel coordinates, Pareto fronts (the smaller, the better, unless --maximise says not)."""
    found = read(file)
    target = folder if folder is not None else file.with_name(f"{file.stem}-figures")
    with sentences(str(file)), writing(str(target), "The study is as it was."):
        from ..plots.study import drawn

        target.mkdir(parents=True, exist_ok=True)
        paths = drawn(found, target, figure or (), measure or (), f".{kind.lower().removeprefix('.')}", maximise or ())
    for path in paths:
        typer.echo(path)
