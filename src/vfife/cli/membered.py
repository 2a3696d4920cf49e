"""What the commands that run members have in common, studies and searches: options, the place of the file, the progress line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .job import RUNS, CommandJob

StudyArgument = Annotated[Path, typer.Argument(metavar="STUDY.toml", help="Study file in TOML.", show_default=False)]
FileArgument = Annotated[Path, typer.Argument(metavar="FILE.study", help="What a study was kept in.", show_default=False)]
Target = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE.study", help="Where to keep it.", show_default="runs/STUDY.study")]
Force = Annotated[bool, typer.Option("--force", help="Replace the study that is in the file.")]
Yes = Annotated[bool, typer.Option("--yes", help="Run whatever it takes: hours, or half the disk.")]
Workers = Annotated[int | None, typer.Option(metavar="N", min=1, help="Threads, or processes of a local cluster.", show_default="one a core")]
ON_CARD = "Step members on an NVIDIA card (extra gpu); we have not tried it on one."
Device = Annotated[str | None, typer.Option(metavar="cuda", help=ON_CARD, show_default="the processor")]
Retry = Annotated[bool, typer.Option("--retry", help="Try members again that failed before.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress line and no tables; warnings and errors are told.")]


class StudyCommand(CommandJob):
    """The job of a command that computes members. Raises ValueError where something else has the name of the study file."""

    def __init__(self, file: Path, target: Path | None, yes: bool, quiet: bool, what: str = "study") -> None:
        from ..results.schemas import STUDY

        place = target if target is not None else RUNS / f"{file.stem}.study"
        if place.exists() and not STUDY.owns(place):
            raise ValueError(f"-o {place}: there is something else of this name, which is no study file; name another one")
        super().__init__(what, place, yes=yes, quiet=quiet)
        self.saved = f"Members that ended are kept in {place}; the same command goes on after them."
        self.kept = self.saved if place.exists() else ""
