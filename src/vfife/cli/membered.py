"""What the commands that run members have in common, studies and searches: options, the place of the file, the progress line."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..solvers.status import Status
from .terminal import span

if TYPE_CHECKING:
    from ..study.engine import Outcome

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


def refuse_foreign(target: Path, force: bool) -> None:
    """Raises ValueError where something else has the name of the study file."""
    from ..results.schemas import STUDY

    if target.exists() and not STUDY.owns(target):
        raise ValueError(f"-o {target}: there is something else of this name, which is no study file; name another one")


class MemberLine:
    """The progress line of a study: members, members a second, time left, failures."""

    def __init__(self, line: Any) -> None:
        self.line, self.began, self.failed = line, time.monotonic(), 0
        self.first: int | None = None

    def __call__(self, done: int, of: int, outcome: Outcome) -> None:
        """Shows where the study stands; called after each member."""
        from ..solvers.status import Progress

        self.first = done - 1 if self.first is None else self.first
        self.failed += outcome.status != Status.COMPLETE
        seconds = max(time.monotonic() - self.began, 1e-9)
        rate = (done - self.first) / seconds
        left = f"{span((of - done) / rate)} left" if done < of else f"in {span(seconds)}"
        bad = f"  {self.failed:,} failed" if self.failed else ""
        self.line(Progress(done, of, seconds, f"{done:,} of {of:,} members  {rate:.3g} members/s  {left}{bad}"))
