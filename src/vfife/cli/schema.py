"""``vfife schema``: the JSON Schema of model files and study files, for editors and validators."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..files import write_text
from .terminal import writing

OutOption = Annotated[Path | None, typer.Option("-o", "--out", metavar="FILE", help="Write it into this file.", show_default=False)]


StudyOption = Annotated[bool, typer.Option("--study", help="The schema of study files instead.")]


def schema(out: OutOption = None, study: StudyOption = False) -> None:
    """JSON Schema of model files, for completion and checks in an editor: every key with its meaning, unit and limits."""
    if study:
        from ..study.study_file import text
    else:
        from ..modelfile.jsonschema import text

    if out is None:
        typer.echo(text(), nl=False)
        return
    with writing(str(out), "What was there is as it was."):
        write_text(out, text())
