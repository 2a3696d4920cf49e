"""``vfife resume``: a run that was interrupted or killed goes on, or a complete one further."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..results.folder import find_run
from .carried import carried, concluded
from .options import JsonOption, LawsOption, RunArgument, positive, take_laws
from .terminal import sentences, tell

if TYPE_CHECKING:
    from ..results.runfile import RunFile
    from ..simulation import Prepared
    from ..solvers.record import Checkpoint

GATHER = 0.25  # s: what a kill may cost, beside the steps that are being taken
Until = Annotated[
    str | None, typer.Option("--until", metavar="SECONDS", help='Time at which it ends, such as 0.5 or "500 ms".', show_default="as planned")
]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures as well.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress line and no summary; warnings and errors are told.")]


def resume(
    run: RunArgument,
    until: Until = None,
    laws: LawsOption = None,
    figures: Figures = False,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Go on with a run that was interrupted or killed, as if nothing had happened: the same numbers, to the bit.

    With --until a run ends later than planned, also one that is complete; its step stays what it is. Exit codes are those of vfife run.
    """
    with sentences(str(run)):
        take_laws(laws)
        end = None if until is None else positive("--until", until, "s")
        resumed(find_run(run).parent, end, figures, as_json, quiet)


def resumed(path: Path, until: float | None, figures: bool, as_json: bool, quiet: bool) -> None:
    """Goes on with the run in a folder. Raises HeldError where another process does, ResumeError where there is nothing to go on with."""
    from ..results.place import kept_run
    from ..results.runfile import RunFile
    from ..simulation import taken_up

    place = kept_run(path)

    def opened() -> tuple[RunFile, Prepared, Checkpoint | None]:
        file = RunFile.write(place.run_file, gather=GATHER)
        try:
            prepared, last = taken_up(file, until)
        except BaseException:
            file.close()
            raise
        done = 0 if last is None else last.step
        if not quiet:
            tell("note", f"goes on after step {done:,} of {prepared.assembly.choice.steps:,}.")
        return file, prepared, last

    try:
        result = carried(opened, place, quiet)
        if until is not None:
            from ..files import write_text
            from ..modelfile import dump
            from ..results.folder import MODEL

            write_text(place.path / MODEL, dump(result.record.assembly.mechanism))
        concluded(result, place, figures, as_json, quiet)
    finally:
        place.leave()
