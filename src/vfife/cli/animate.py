"""``vfife animate``: a film of a run."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from ..job.progress import ProgressLine
from .ended import ForceFile, loaded, refuse_taken
from .options import RunArgument
from .signals import NOW
from .terminal import amount_of_bytes, sentences, span, writing

AS = "Film to write: .gif, or .mp4 with the extra video."
Out = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILM", help=AS, show_default="RUN.gif")]
Frames = Annotated[int, typer.Option(metavar="N", help="Frames; no more than the part shown has outputs.")]
Rate = Annotated[float, typer.Option("--fps", metavar="N", help="Frames a second.")]
Turns = Annotated[float, typer.Option(metavar="N", help="Last turns of the crank that are shown; without a crank the whole run is.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress line.")]
KEPT = "The run is as it was, and so is what was there before."


def animate(
    run: RunArgument, out: Out = None, frames: Frames = 240, rate: Rate = 25.0, turns: Turns = 1.0, force: ForceFile = False, quiet: Quiet = False
) -> None:
    """Write a film of a run: the mechanism as it moves, its play drawn larger, and beside it the largest joint forces as they come."""
    target = out if out is not None else Path(f"{(run.resolve() if run.is_dir() else run).stem}.gif")
    with sentences(str(target)):
        refuse_taken(target, force)
    begun = time.monotonic()
    result, _ = loaded(run)
    NOW.saved = f"No film was written. {KEPT}"
    with sentences(str(target)), writing(str(target), KEPT):
        from ..plots.filmfiles import animate as written
        from ..solvers.status import Progress

        with ProgressLine(quiet) as line:
            made, lasting = written(
                result, target, frames, rate, turns, lambda k, n: line(Progress(k, n, time.monotonic() - begun, f"{k} of {n} frames drawn"))
            )
    done = f"{amount_of_bytes(target.stat().st_size)}, {made} frames, {lasting:.3g} s long, written in {span(time.monotonic() - begun)}"
    typer.echo(f"{target} ({done})")
