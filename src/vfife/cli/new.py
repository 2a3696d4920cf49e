"""``vfife new``: commented model files to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..files import GALLERY, write_text
from .terminal import fail, grid, output, row, sentences, writing

ROOM = Path(__file__).resolve().parents[1]
FOLDERS = {"model": ROOM / "modelfile" / "templates", "model of the gallery": GALLERY}
SCHEMA = ROOM / "modelfile" / "model.schema.json"
NameArgument = Annotated[str | None, typer.Argument(metavar="[NAME]", help="Which one; without it all are listed.", show_default=False)]
OutOption = Annotated[Path | None, typer.Option("-o", "--out", metavar="FILE", help="Write it into this file.", show_default=False)]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace a file that is there.")]


def new(name: NameArgument = None, out: OutOption = None, force: ForceOption = False) -> None:
    """A commented model file to start from, on standard output or into a file."""
    if name is None:
        if out is not None:
            fail(f"nothing says what to write into {out}; name one of {', '.join(templates())}")
        show()
        return
    text = started(name)
    if out is None:
        typer.echo(text, nl=False)
        return
    with sentences(str(out)), writing(str(out), "What was there is as it was."):
        if out.exists() and not force:
            raise ValueError("there is such a file already; choose another name, or replace it with --force")
        write_text(out, text)


def templates() -> dict[str, Path]:
    """Model files to start from, by name: those whose lines are explained, then the gallery."""
    return {path.stem: path for folder in FOLDERS.values() for path in sorted(folder.glob("*.toml"))}


def started(name: str) -> str:
    """Text of a template; its first line tells editors where the schema is."""
    known = templates()
    name = name if name in known else next((one for one in known if one.replace("_", "-") == name.replace("_", "-")), name)
    if name not in known:
        from ..errors import suggestion

        fail(f"there is no model {name!r} to start from; {suggestion(name, known, 'name one of those there are')}")
    return f"#:schema {SCHEMA.as_uri()}\n{known[name].read_text(encoding='utf-8')}"


def about(path: Path) -> str:
    """What a template is: its first line."""
    return path.read_text(encoding="utf-8").partition("\n")[0].lstrip("# ")


def show() -> None:
    """All models with a line each, in two tables."""
    for title, folder in FOLDERS.items():
        table = grid(title, "what it is")
        for path in sorted(folder.glob("*.toml")):
            row(table, path.stem, about(path))
        output().print(table)
    typer.echo("Write one with: vfife new NAME -o FILE")
