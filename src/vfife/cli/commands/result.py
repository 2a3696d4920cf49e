"""What to do with a run that was made: tell, draw, animate, report, export."""

from __future__ import annotations

import shlex
import time
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...files import write_text
from ...job.progress import ProgressLine
from ...solvers.status import Progress, Status
from ...store.folder import FIGURES
from ...store.lock import holder
from ...store.schemas import RUN, STUDY
from ..options import JsonOption, RunArgument
from ..signals import NOW
from ..terminal import amount_of_bytes, answer, command, errors, fail, sentences, span, tell, writing

if TYPE_CHECKING:
    from ...simulation.result import Result

CheckOption = Annotated[
    bool, typer.Option("--check", help="Read every output of a large file as well, and tell what is damaged.")
]


def info(run: RunArgument, check: CheckOption = False, as_json: JsonOption = False) -> None:
    """What a run file holds, also that of a run that was interrupted or killed."""
    with sentences(str(run)):
        found = contents(run, check)
    from ...report import run as documents

    answer(documents.info(found), as_json)


def contents(path: Path, check: bool = True) -> dict[str, Any]:
    """What is known of a run without assembling its model. The outputs of a large file are read where they
    are to be checked.
    """
    from ...store.runfile import RunFile

    with RunFile.open(path) as file:
        alone = None if check else file.steps_alone()
        meta, steps, events, last = (
            file.meta,
            file.steps if alone is None else alone,
            file.events,
            file.last_checkpoint(),
        )
        path, reference, lost = file.path, file.has_reference, file.lost
    choice, model = meta.get("choice", {}), tomllib.loads(meta.get("model", ""))
    status = meta.get("status", "unknown")
    return {
        "file": str(path),
        "bytes": path.stat().st_size,
        "status": Status.UNFINISHED if status == Status.RUNNING else status,
        "model": model.get("name", ""),
        "source": meta.get("source"),
        "created": meta.get("created"),
        "finished": meta.get("finished"),
        "versions": meta.get("versions", {}),
        "loop": meta.get("loop"),
        "step": meta.get("step"),
        "steps": int(steps[-1]) if len(steps) else 0,
        "static": model.get("run", {}).get("analysis") == "static",
        "steps_planned": choice.get("outputs", 0) * choice.get("outputs_every", 0),
        "turn": choice.get("turn"),
        "outputs": len(steps),
        "written_by": holder(path.parent),
        "damage": list(lost),
        "checked": alone is None,
        "channels": sorted({name for name, _ in meta.get("kept", ())}),
        "laws": meta.get("laws", {}),
        "own_laws": [
            {key: law[key] for key in ("name", "kind", "file", "text")} for law in meta.get("own_laws", ())
        ],
        "reference": reference,
        "checkpoint": last[0] if last is not None else None,
        "wall_s": meta.get("wall"),
        "events": [{"step": step, "time": time, "text": text} for step, time, text in events],
        "summary": meta.get("summary"),
    }


KEPT = "The run is as it was"
AS_BEFORE = f"{KEPT}, and so is what was there before."
ENDINGS = (
    ".csv",
    ".nc",
    ".nc4",
    ".h5",
    ".mat",
    ".parquet",
    ".svg",
    ".pdf",
    ".png",
)  # as Result.export has them; a test compares
ForceFile = Annotated[bool, typer.Option("--force", help="Replace the file if there is one.")]


def export(
    run: RunArgument,
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="File to write: .csv, .nc, .mat, .parquet; a figure as .svg, .pdf, .png, by its name.",
            show_default=False,
        ),
    ],
    figure: Annotated[
        str | None,
        typer.Option("--figure", metavar="NAME", help="The figure, if the file is not called by its name."),
    ] = None,
    force: ForceFile = False,
) -> None:
    """Write all channels of a run with their units, or a figure, in the format that the file's ending says."""
    with sentences(str(target)):
        refuse_ending(target, ENDINGS)
        refuse_taken(target, force)
    NOW.saved = f"Nothing was written. {AS_BEFORE}"
    result, _ = loaded(run)
    with sentences(str(run)), writing(str(target), AS_BEFORE):
        result.export(target, figure)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)})")


def refuse_ending(target: Path, endings: Sequence[str]) -> None:
    """Raises ValueError where the ending of a file says none of the formats that there are."""
    if target.suffix.lower() not in endings:
        known = f"{', '.join(endings[:-1])} and {endings[-1]}"
        raise ValueError(
            f'nothing is written as "{target.suffix or target.name}"; name a file such as {target.stem}.csv:'
            f" there are {known}"
        )


def refuse_taken(target: Path, force: bool) -> None:
    """Raises ValueError where a file cannot be written, or takes the place of another one that ``force`` does
    not give up.
    """
    if target.is_dir():
        raise ValueError(f"this is a folder; name a file, such as out{target.suffix}")
    if target.exists() and not force:
        raise ValueError(
            "there is a file of this name already; name another one, or add --force to replace it"
        )
    if not target.absolute().parent.is_dir():
        raise ValueError(f"there is no folder {target.absolute().parent}; make it first")


def loaded(run: Path) -> tuple[Result, Path]:
    """The result of a run and its file; says so where the run did not come to its end."""
    with sentences(str(run)):
        from ...simulation.result import Result
        from ...store.connections import located

        file = located(RUN, run)
        result = Result.load(file)
    if result.record.status != Status.COMPLETE:
        errors().print(
            f"note: this run ended as {result.record.status}; what it wrote until then is used", markup=False
        )
    return result, file


Count = Annotated[int, typer.Option("-n", "--count", metavar="N", min=1, help="So many of the hardest.")]


def impacts(run: RunArgument, count: Count = 10, as_json: JsonOption = False) -> None:
    """The impacts of a run: time, crank angle, approach speed, energy lost and depth, the hardest first; with
    --json all of them in their order.

    None is missed. Those that began between the same two outputs are told together, with their number and
    mean speed; more outputs (vfife run --outputs) tell more of them apart.
    """
    with sentences(str(run)):
        from ...simulation.result import Result

        found = Result.load(run).impacts
    from ...report import run as documents

    answer(documents.impacts(found, count), as_json)


LIST = "list"
PICTURES = (".png", ".svg", ".pdf")  # as plots has them; a test compares


OutOption = Annotated[Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="Where to; of one figure also a file, as forces.svg.",
                                                show_default="RUN/figures")]  # fmt: skip
Named = Annotated[list[str] | None, typer.Option("--figure", metavar="NAME", show_default="the usual ones",
                  help="Figure to draw, once for each; all draws every one that the run has, list says which there are.")]  # fmt: skip
As = Annotated[
    str, typer.Option("--format", metavar="|".join(one[1:] for one in PICTURES), help="Format of the files.")
]
At = Annotated[
    str | None,
    typer.Option(
        "--at",
        metavar="ANGLE|TIME",
        help="Moment at which the mechanism is drawn, as 90deg of the last turn, or 12ms.",
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace figures that are there.")]


def plot(
    run: RunArgument,
    figure: Named = None,
    out: OutOption = None,
    kind: As = "png",
    at: At = None,
    force: Force = False,
) -> None:
    """Draw figures of a run: the mechanism, journal paths, forces and accelerations over the ideal ones; more
    with --figure.
    """
    if f".{kind}" not in PICTURES:
        fail(
            f"--format {kind}: no figure is written as this; there are"
            f" {', '.join(one[1:] for one in PICTURES)}"
        )
    NOW.saved = f"{KEPT}, and no figure was drawn."
    names = [name for one in figure or () for name in one.split(",")]
    result, file = loaded(run)
    if LIST in names:
        listed(result)
        return
    with sentences(str(run)):
        from ...plots import chosen, only_mechanism

        if at is not None:
            only_mechanism(names)
        wanted = chosen(result, names or (["mechanism"] if at is not None else []))
    single = out is not None and out.suffix.lower() in PICTURES
    if single and len(wanted) != 1:
        fail(
            f"-o {out}: one file holds one figure and this draws {len(wanted)}; name one with --figure, or a"
            " folder"
        )
    folder = file.parent / FIGURES if out is None else out
    targets = (
        {wanted[0]: out}
        if single and out is not None
        else {name: folder / f"{name}.{kind}" for name in wanted}
    )
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
        fail(
            f"{taken[0].parent}: there are figures already: {names}; name another folder with -o, or add"
            " --force to replace them"
        )


def drawn(result: Result, targets: dict[str, Path], at: str | None, run: str) -> None:
    """Draws one figure after the other, each of them whole or not there."""
    from ...plots import figure
    from ...plots.style import saved

    for done, (name, path) in enumerate(targets.items(), 1):
        with sentences(run), writing(str(path), AS_BEFORE):
            made = figure(result, name, result.reference, at)
            path.parent.mkdir(parents=True, exist_ok=True)
            saved(made, path)
        typer.echo(path)
        NOW.saved = f"{KEPT}; {done} of {len(targets)} figures were drawn, in {path.parent}."


def listed(result: Result) -> None:
    """What figures there are, and which of them the run has nothing for."""
    from ...plots.catalogue import FIGURES
    from ...report.document import Document, Table

    rows = []
    for name, one in FIGURES.items():
        why = one.missing(result)
        rows.append((name, one.description, f"none: {why}" if why else "usual" if one.usual else ""))
    answer(Document([Table(("figure", "shows", ""), rows)]))


AS = "Film to write: .gif, or .mp4 with the extra video."
FilmOut = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="FILM", help=AS, show_default="RUN.gif")
]
Frames = Annotated[int, typer.Option(metavar="N", help="Frames; no more than the part shown has outputs.")]
Rate = Annotated[float, typer.Option("--fps", metavar="N", help="Frames a second.")]
Turns = Annotated[
    float,
    typer.Option(
        metavar="N", help="Last turns of the crank that are shown; without a crank the whole run is."
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress line.")]


def animate(
    run: RunArgument,
    out: FilmOut = None,
    frames: Frames = 240,
    rate: Rate = 25.0,
    turns: Turns = 1.0,
    force: ForceFile = False,
    quiet: Quiet = False,
) -> None:
    """Write a film of a run: the mechanism as it moves, its play drawn larger, and beside it the largest
    joint forces as they come.
    """
    target = out if out is not None else Path(f"{(run.resolve() if run.is_dir() else run).stem}.gif")
    with sentences(str(target)):
        refuse_taken(target, force)
    begun = time.monotonic()
    result, _ = loaded(run)
    NOW.saved = f"No film was written. {AS_BEFORE}"
    with sentences(str(target)), writing(str(target), AS_BEFORE):
        from ...plots.filmfiles import animate as written

        with ProgressLine(quiet) as line:
            made, lasting = written(
                result,
                target,
                frames,
                rate,
                turns,
                lambda k, n: line(Progress(k, n, time.monotonic() - begun, f"{k} of {n} frames drawn")),
            )
    done = (
        f"{amount_of_bytes(target.stat().st_size)}, {made} frames, {lasting:.3g} s long, written in"
        f" {span(time.monotonic() - begun)}"
    )
    typer.echo(f"{target} ({done})")


PageOut = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="PAGE.html", help="The page.", show_default="RUN-report.html"),
]
NoLive = Annotated[bool, typer.Option("--no-live", help="Without the page in which the mechanism runs.")]


def report(run: RunArgument, out: PageOut = None, no_live: NoLive = False, force: ForceFile = False) -> None:
    """Write a report of a run: inputs, what was found, cautions, how far it can be trusted, figures, and the
    mechanism running.

    Of a study (FILE.study): what its members came to, figures, and a member of the reader's choice running.

    One file that asks for nothing else, to be read in a browser or printed.
    """

    study = STUDY.owns(run)
    target = out if out is not None else Path(f"{(run.resolve() if run.is_dir() else run).stem}-report.html")
    with sentences(str(target)):
        refuse_taken(target, force)
    kept = "The study is as it was, and so is what was there before." if study else AS_BEFORE
    NOW.saved = f"No report was written. {kept}"
    if study:
        from .study_info import read
    found: Any = read(run) if study else loaded(run)[0]
    with sentences(str(run)):
        from ...live.page.reports import run_report, study_report

        page, notes = (study_report if study else run_report)(found, not no_live)
    for note in notes:
        tell("note", note)
    with writing(str(target), kept):
        write_text(target, page)
    typer.echo(
        f"{target} ({amount_of_bytes(target.stat().st_size)}); open it in a browser, and print it from there."
    )
