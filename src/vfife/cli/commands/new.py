"""``vfife new`` and ``vfife schema``: model files to begin with, and what may stand in one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ...errors import suggestion
from ...files import GALLERY, write_text
from ..options import Options, argument, flag, option
from ..terminal import answer, fail, sentences, writing

if TYPE_CHECKING:
    from ...report.document import Document

ROOM = Path(__file__).resolve().parents[2]
FOLDERS = {"model": ROOM / "modelfile" / "templates", "model of the gallery": GALLERY}
SCHEMA = ROOM / "modelfile" / "model.schema.json"


class NewOptions(Options):
    """Options of ``vfife new``."""

    name: str | None = argument("Which one; without it all are listed.", "[NAME]", None)
    out: Path | None = option(None, "Write it into this file.", "FILE", "-o", "--out")
    force: bool = flag("--force", "Replace a file that is there.")


def new(options: NewOptions) -> None:
    """Write a commented model file to start from, to standard output or into a file."""
    name, out = options.name, options.out
    if name is None:
        if out is not None:
            fail(f"nothing says what to write into {out}; name one of {', '.join(templates())}")
        answer(listing())
        return
    text = started(name)
    if out is None:
        typer.echo(text, nl=False)
        return
    with sentences(str(out)), writing(str(out), "What was there is as it was."):
        if out.exists() and not options.force:
            raise ValueError("there is such a file already; choose another name, or replace it with --force")
        write_text(out, text)


def templates() -> dict[str, Path]:
    """Model files to start from, by name: those whose lines are explained, then the gallery."""
    return {path.stem: path for folder in FOLDERS.values() for path in sorted(folder.glob("*.toml"))}


def started(name: str) -> str:
    """Text of a template; its first line tells editors where the schema is."""
    paths = templates()
    name = (
        name
        if name in paths
        else next((one for one in paths if one.replace("_", "-") == name.replace("_", "-")), name)
    )
    if name not in paths:
        fail(
            f"there is no model {name!r} to start from;"
            f" {suggestion(name, paths, 'name one of those there are')}"
        )
    return f"#:schema {SCHEMA.as_uri()}\n{paths[name].read_text(encoding='utf-8')}"


def description(path: Path) -> str:
    """Return the first line of a template, which describes it."""
    return path.read_text(encoding="utf-8").partition("\n")[0].lstrip("# ")


def listing() -> Document:
    """All models with a line each, in two tables."""
    from ...report.document import Document, Paragraph, Table

    kinds = ((title, sorted(folder.glob("*.toml"))) for title, folder in FOLDERS.items())
    tables = [
        Table((title, "what it is"), [(path.stem, description(path)) for path in paths])
        for title, paths in kinds
    ]
    return Document([*tables, Paragraph("Write one with: vfife new NAME -o FILE")])


class SchemaOptions(Options):
    """Options of ``vfife schema``."""

    out: Path | None = option(None, "Write it into this file.", "FILE", "-o", "--out")
    study: bool = flag("--study", "The schema of study files instead.")
    fit: bool = flag("--fit", "The schema of fit plans instead.")


def schema(options: SchemaOptions) -> None:
    """JSON Schema of model files, study files or fit plans, for completion and checks in an editor: every key
    with its meaning, unit and limits.
    """
    if options.study and options.fit:
        fail("--study and --fit ask for two schemas; name one of them")
    if options.study:
        from ...studies.spec.study_file import schema_text
    elif options.fit:
        from ...identification.fit_plan import schema_text
    else:
        from ...modelfile.jsonschema import text as schema_text
    if options.out is None:
        typer.echo(schema_text(), nl=False)
        return
    with writing(str(options.out), "What was there is as it was."):
        write_text(options.out, schema_text())
