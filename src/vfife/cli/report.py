"""``vfife report``: a run on one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .ended import ForceFile, loaded, refuse_taken
from .options import RunArgument
from .signals import NOW
from .terminal import amount_of_bytes, sentences, tell, writing

Out = Annotated[Path | None, typer.Option("-o", "--output", metavar="PAGE.html", help="The page.", show_default="RUN-report.html")]
NoLive = Annotated[bool, typer.Option("--no-live", help="Without the page in which the mechanism runs.")]
KEPT = "The run is as it was, and so is what was there before."


def report(run: RunArgument, out: Out = None, no_live: NoLive = False, force: ForceFile = False) -> None:
    """Write a report of a run: inputs, what was found, cautions, how far it can be trusted, figures, and the mechanism running.

    Of a study (FILE.study): what its members came to, figures, and a member of the reader's choice running.

    One file that asks for nothing else, to be read in a browser or printed.
    """
    from ..results.schemas import STUDY

    if STUDY.owns(run):
        of_study(run, out, no_live, force)
        return
    target = out if out is not None else Path(f"{(run.resolve() if run.is_dir() else run).stem}-report.html")
    with sentences(str(target)):
        refuse_taken(target, force)
    NOW.saved = f"No report was written. {KEPT}"
    result, _ = loaded(run)
    with sentences(str(run)):
        from ..files import write_text
        from ..live.reports import run_report

        page, notes = run_report(result, not no_live)
    for note in notes:
        tell("note", note)
    with writing(str(target), KEPT):
        write_text(target, page)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)}); open it in a browser, and print it from there.")


def of_study(file: Path, out: Path | None, no_live: bool, force: bool) -> None:
    """The report of a study."""
    from .studied import read

    target = out if out is not None else Path(f"{file.stem}-report.html")
    with sentences(str(target)):
        refuse_taken(target, force)
    found = read(file)
    with sentences(str(file)):
        from ..files import write_text
        from ..live.reports import study_report

        page, notes = study_report(found, not no_live)
    for note in notes:
        tell("note", note)
    with writing(str(target), "The study is as it was, and so is what was there before."):
        write_text(target, page)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)}); open it in a browser, and print it from there.")
