"""``vfife report``: a run on one page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .ended import ForceFile, loaded, refuse_taken
from .options import RunArgument
from .signals import NOW
from .terminal import amount_of_bytes, sentences, tell, writing

if TYPE_CHECKING:
    from ..result import Result

Out = Annotated[Path | None, typer.Option("-o", "--output", metavar="PAGE.html", help="The page.", show_default="RUN-report.html")]
NoLive = Annotated[bool, typer.Option("--no-live", help="Without the page in which the mechanism runs.")]
LARGEST = 4_000_000  # bytes
KEPT = "The run is as it was, and so is what was there before."


def report(run: RunArgument, out: Out = None, no_live: NoLive = False, force: ForceFile = False) -> None:
    """Write a report of a run: inputs, what was found, cautions, how far it can be trusted, figures, and the mechanism running.

    One file that asks for nothing else, to be read in a browser or printed.
    """
    target = out if out is not None else Path(f"{(run.resolve() if run.is_dir() else run).stem}-report.html")
    with sentences(str(target)):
        refuse_taken(target, force)
    NOW.saved = f"No report was written. {KEPT}"
    result, _ = loaded(run)
    with sentences(str(run)):
        from ..plots.notebook import pictures
        from ..report.document import document
        from ..results.folder import written

        source = result.record.assembly.mechanism.source
        drawn, live = pictures(result), None if no_live else running(result)
        page = document(result, drawn, live, source)
        if len(page.encode("utf-8")) > LARGEST and live is not None:
            tell("note", "the page in which the mechanism runs is left out: with it the report would be too large.")
            page = document(result, drawn, None, source)
    with writing(str(target), KEPT):
        written(target, page)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)}); open it in a browser, and print it from there.")


def running(result: Result) -> str | None:
    """The page in which the mechanism runs; None, and a note, where it cannot."""
    from ..errors import VfifeError
    from ..live import live_page

    mechanism = result.record.assembly.mechanism
    try:
        return live_page(mechanism, step=result.record.assembly.choice.step)  # sliders take long to find: vfife live has them
    except VfifeError as error:
        tell("note", f"the mechanism does not run in the report: {error}.")
        return None
