"""What to do with a study that was made, or that is still growing: show, draw, export."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..results.lock import holder
from .ended import ForceFile, refuse_ending, refuse_taken
from .membered import FileArgument as FileArgument
from .options import JsonOption
from .terminal import amount_of_bytes, counted, grid, output, print_json, row, sentences, writing

if TYPE_CHECKING:
    from ..results.studied import Study

MOST_SHOWN = 10

Members = Annotated[bool, typer.Option("--members", help="Every member with what it came to.")]


def show(file: FileArgument, members: Members = False, as_json: JsonOption = False) -> None:
    """What a study came to so far: each measure's least, mean and largest value and where, and what failed."""
    found = read(file)
    if as_json:
        print_json(payload(found) | ({"members": found.rows()} if members else {}))
        return
    printed(found, members)


def read(file: Path) -> Study:
    """A study as its file has it now."""
    with sentences(str(file)):
        from ..results.studied import Study

        found = Study.open(file)
    return found


def payload(found: Study) -> dict[str, Any]:
    """What ``--json`` prints."""
    from ..report.study import errors_plainly, extremes

    return {
        "study": found.name,
        "file": None if found.path is None else str(found.path),
        "model": found.model,
        "status": found.status,
        "planned": len(found.members),
        "counts": found.counts,
        "wanted": found.asked["wanted"],
        "parameters": [{"name": one.name, "paths": list(one.paths), "unit": one.unit, "kind": one.kind} for one in found.parameters],
        "measures": extremes(found),
        "errors": errors_plainly(found),
        "failed": [{"member": one.number, "at": dict(one.numbers), "reason": reason} for one, reason in found.failed],
    }


def printed(found: Study, members: bool = False) -> None:
    """The tables for people."""
    from rich.text import Text

    from ..report.study import said_of, where

    console = output()
    counts = ", ".join(f"{count:,} {word}" for word, count in found.counts.items() if count)
    at_work = None if found.path is None else holder(found.path.absolute().parent, f"{found.path.name}.lock")
    said = ", ".join(filter(None, (counted(len(found.members), "member"), counts))) + (f"; {at_work} is at work" if at_work else "")
    console.print(Text.assemble((f"{found.model}: ", "bold"), said))
    wanted = found.asked["wanted"]
    until = "" if wanted["settle"] is None else f" at most, until they repeat within {100.0 * wanted['settle']:g} %"
    over = "the last turn" if wanted["last"] == 1 else f"the last {wanted['last']} turns (means)"
    console.print(f"{counted(wanted['turns'], 'turn')}{until}; measures are of {over}")
    varied = grid("varied", "values", "numbers of the model")
    for k, one in enumerate(found.parameters):
        row(varied, one.name, said_of([found.at(member)[k] for member in found.members], one.unit, one.kind, one.words), ", ".join(one.paths))
    console.print(varied)
    console.print(measured(found))
    console.print(numerical(found))
    if members:
        console.print(every(found))
    for member, reason in found.failed[:MOST_SHOWN]:
        console.print(Text.assemble((f"member {member.number}: ", "bold"), f"{where(found, member)}: {reason}"), soft_wrap=True)
    if len(found.failed) > MOST_SHOWN:
        console.print(f"... and {len(found.failed) - MOST_SHOWN:,} more; --json has all of them")


def quantity(value: Any, unit: str) -> str:
    """A quantity with a prefix; words as they are."""
    from ..report.study import quantity as told

    return told(value, unit)


def measured(found: Study) -> Any:
    """The table of the measures."""
    from ..report.study import extremes, placed

    table = grid("measure", "least", "at", "mean", "largest", "at", right=(1, 3, 4))
    for name, one in extremes(found).items():
        cells = [quantity(one[key], one["unit"]) for key in ("least", "mean", "largest")]
        at = [placed(found, one[key]) for key in ("least_at", "largest_at")]
        row(table, name, cells[0], at[0], cells[1], cells[2], at[1])
    return table


def numerical(found: Study) -> Any:
    """The table of numerical errors, or the words that they are not estimated."""
    from ..report.study import error_words, errors

    if not found.errors:
        return error_words(None, "")
    table = grid("numerical error of a member", "typically", "at most", "estimated from", right=(1, 2))
    for one in errors(found):
        row(table, *one)
    return table


def every(found: Study) -> Any:
    """The table of the members."""
    names, measures = [one.name for one in found.parameters], list(found.measures)
    table = grid("member", *names, *measures, "status", right=tuple(range(len(names) + len(measures) + 1)))
    units = {**{one.name: one.unit for one in found.parameters}, **found.measures}
    for one in found.rows():
        row(table, one["member"], *(quantity(one[name], units[name]) for name in (*names, *measures)), one["status"])
    return table


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
        from ..results.studyexport import write

        write(found, target)
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
