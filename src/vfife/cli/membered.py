"""Options of the commands that run members: studies, and searches that ask for members as they need them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
