"""``vfife new`` and ``vfife schema``: model files to begin with, and what may stand in one."""

from __future__ import annotations

from pathlib import Path

import typer

from ...errors import suggestion
from ...files import GALLERY, write_text
from ...report.document import Document, Paragraph, Table
from ..arguments.models import NewOptions, SchemaOptions
from ..terminal import answer, fail, sentences, writing

ROOM = Path(__file__).resolve().parents[2]
FOLDERS = {"model": ROOM / "modelfile" / "templates", "model of the gallery": GALLERY}
SCHEMA = ROOM / "modelfile" / "model.schema.json"


def new(options: NewOptions) -> None:
    """Run ``vfife new``."""
    name, out = options.name, options.out
    if name is None:
        if out is not None:
            fail(f"the model to write into {out} is missing; name one of {', '.join(templates())}")
        answer(listing())
        return
    text = started(name)
    if out is None:
        typer.echo(text, nl=False)
        return
    with sentences(str(out)), writing(str(out), "The existing file is unchanged."):
        if out.exists() and not options.force:
            raise ValueError("this file exists; choose another name, or replace it with --force")
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
        else next(
            (template for template in paths if template.replace("_", "-") == name.replace("_", "-")), name
        )
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
    kinds = ((title, sorted(folder.glob("*.toml"))) for title, folder in FOLDERS.items())
    tables = [
        Table((title, "what it is"), [(path.stem, description(path)) for path in paths])
        for title, paths in kinds
    ]
    return Document([*tables, Paragraph("Write one with: vfife new NAME -o FILE")])


def schema(options: SchemaOptions) -> None:
    """Run ``vfife schema``."""
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
    with writing(str(options.out), "The existing file is unchanged."):
        write_text(options.out, schema_text())
