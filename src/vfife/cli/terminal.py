"""What all commands say in the same way: sentences on standard error, one object on standard output, exit codes."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NoReturn

import typer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

BAD_INPUT, DIVERGED, INTERRUPTED = 2, 3, 130
PIPE_WIDTH = 120  # columns of a table that goes into a file or a pipe


def output() -> Console:
    """Standard output as it is now."""
    from rich.console import Console

    return Console(highlight=False, width=None if sys.stdout.isatty() else PIPE_WIDTH)


def errors() -> Console:
    """Standard error as it is now; long sentences are wrapped by the terminal alone, so that they can be searched."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True)


def tell(word: str, sentence: str, style: str = "bold yellow") -> None:
    """A sentence on standard error, after a word in colour; brackets are no markup."""
    from rich.text import Text

    errors().print(Text.assemble((f"{word}: ", style), sentence))


def fail(sentence: str, code: int = BAD_INPUT) -> NoReturn:
    """Ends with a sentence and an exit code."""
    tell("error", sentence, "bold red")
    raise typer.Exit(code)


@contextmanager
def sentences(name: str) -> Iterator[None]:
    """Ends with exit code 2 and a sentence where input cannot be used; ``name`` is the file or folder that it is about."""
    try:
        yield
    except OSError as error:
        file = f" {error.filename}" if error.filename and str(error.filename) != name else ""
        fail(f"{name}:{file} {error.strerror or error}")
    except (ValueError, ArithmeticError) as error:
        message = str(error) or type(error).__name__
        fail(message if message.startswith((name, "-")) else f"{name}: {message}")


def print_json(value: Any) -> None:
    """One object on standard output."""
    typer.echo(json_text(value))


def json_text(value: Any) -> str:
    """JSON by the book: numbers that are not finite become null, numpy's become Python's."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def plain(value: Any) -> Any:
    """The value made of dictionaries, lists, texts and finite numbers only."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def grid(*headings: str, title: str | None = None, right: tuple[int, ...] = ()) -> Table:
    """An empty table with little ink; columns ``right`` hold numbers."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for index, heading in enumerate(headings):
        table.add_column(heading, justify="right" if index in right else "left", overflow="fold")
    return table


def row(table: Table, *cells: Any) -> None:
    """A row of texts, in which brackets are no markup."""
    from rich.text import Text

    table.add_row(*(Text(str(cell)) for cell in cells))


def amount_of_bytes(count: float) -> str:
    """Bytes with a prefix."""
    for unit in ("bytes", "kB", "MB", "GB"):
        if count < 1000.0:
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return f"{count:.3g} TB"


def span(seconds: float) -> str:
    """Seconds as people say them."""
    if not math.isfinite(seconds):
        return "unknown"
    if seconds < 60.0:
        return f"{seconds:.2g} s" if seconds < 9.5 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {rest:02d} s"
