"""What all commands say in the same way: sentences on standard error, one object on standard output, exit
codes.
"""

from __future__ import annotations

import errno
import json
import math
import os
import shlex
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import typer

from ..errors import StorageError
from ..files import free_bytes
from ..job.progress import amount_of_bytes, counted, span
from .signals import ENDING, JSON

if TYPE_CHECKING:
    from rich.console import Console

    from ..errors import Fault
    from ..report.document import Document

BAD_INPUT, DIVERGED, ENERGY, STORAGE = 2, 3, 4, 5
__all__ = ["amount_of_bytes", "counted", "span"]  # for commands, which take all words from here
STATUS = {
    BAD_INPUT: "refused",
    DIVERGED: "diverged",
    ENERGY: "energy",
    STORAGE: "storage",
    129: "interrupted",
    130: "interrupted",
    143: "interrupted",
}
STORAGE_ERRORS = {
    getattr(errno, name)
    for name in ("ENOSPC", "EIO", "EDQUOT", "EROFS", "EFBIG", "EMFILE", "ENFILE")
    if hasattr(errno, name)
}
PIPE_WIDTH = 120  # columns of a table that goes into a file or a pipe


def command() -> str:
    """Return how this program was called, so that suggested commands work as printed."""
    called = sys.argv[0]
    if os.path.basename(called).partition(".")[0] == "vfife":
        program = shutil.which("vfife")
        if program and os.path.exists(called) and os.path.samefile(program, called):
            return "vfife"
        return shlex.quote(short_path(called))
    if os.path.basename(called) == "__main__.py":
        python = shutil.which("python")
        on_path = python and os.path.abspath(python) == os.path.abspath(sys.executable)
        return f"{'python' if on_path else shlex.quote(sys.executable)} -m vfife"
    return "vfife"


def short_path(path: str) -> str:
    """Return the path of a program, relative to the working folder if that is shorter."""
    with suppress(OSError, ValueError):  # no working folder any more, another drive
        relative = os.path.relpath(path)
        if len(relative) < len(path):
            # A name without a separator would be looked for on PATH.
            return relative if os.sep in relative else os.path.join(os.curdir, relative)
    return path


def output() -> Console:
    """Return the console of the present standard output."""
    from rich.console import Console

    return Console(highlight=False, width=None if sys.stdout.isatty() else PIPE_WIDTH)


def errors() -> Console:
    """Return the console of the present standard error; only the terminal wraps long sentences, so that they
    can be searched.
    """
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True)


def tell(word: str, sentence: str, style: str = "bold yellow") -> None:
    """Print a sentence on standard error after a coloured word; brackets are no markup."""
    from rich.text import Text

    errors().print(Text.assemble((f"{word}: ", style), sentence))


def fail(sentence: str, code: int = BAD_INPUT, faults: Sequence[Fault] = (), word: str = "error") -> NoReturn:
    """Exit with a sentence and an exit code; with ``--json`` also with an object that contains the status and
    the faults.
    """
    news = sentence
    for caution in ENDING.cautions:
        news = news.replace(f"{caution} ", "")
    tell(word, news, "bold red" if word == "error" else "bold yellow")
    print_fault(sentence, code, faults)
    raise typer.Exit(code)


def print_fault(sentence: str, code: int, faults: Sequence[Fault] = ()) -> None:
    """Print the object that ``--json`` prints if there is no result."""
    if JSON.wanted and not JSON.printed:
        entries = [
            {name: getattr(fault, name) for name in ("where", "line", "what", "value", "limit", "remedy")}
            for fault in faults
        ]
        print_json({"status": STATUS.get(code, "error"), "faults": entries or [{"what": sentence}]})


def end_interrupted(sentence: str) -> NoReturn:
    """End with the code of the signal, and a sentence that follows the words for the signal."""
    tell("interrupted", f"{ENDING.by}{sentence}")
    raise typer.Exit(ENDING.code)


@contextmanager
def sentences(name: str, *starts: str) -> Iterator[None]:
    """Exit with code 2 and a sentence for unusable input. ``name`` is the file or folder concerned, unless
    the sentence begins with one of the ``starts``.
    """
    try:
        yield
    except OSError as error:
        fail(of_the_system(name, error), STORAGE if error.errno in STORAGE_ERRORS else BAD_INPUT)
    except (ValueError, ArithmeticError) as error:
        message = str(error) or type(error).__name__
        message = message if message.startswith((name, *starts, "-")) else f"{name}: {message}"
        fail(message, STORAGE if isinstance(error, StorageError) else BAD_INPUT, getattr(error, "faults", ()))
    except MemoryError:
        fail(
            f"{name}: there is not enough memory for this; ask for fewer outputs, turns or elements", STORAGE
        )


@contextmanager
def writing(name: str, saved: str = "") -> Iterator[None]:
    """Exit with code 5 where a file cannot be written: the file, the reason, free bytes where these may be
    the reason, and what is ``saved``.

    Exit with code 2 where no file is possible.
    """
    try:
        yield
    except (FileNotFoundError, FileExistsError, IsADirectoryError, NotADirectoryError) as error:
        at = Path(name)
        remedy = (
            f"Make the folder {at.parent} first, or name another place"
            if not at.parent.is_dir()
            else "Name another place"
        )
        fail(f"{name}: {error.strerror or error}. {remedy}. {saved}".rstrip())
    except (OSError, MemoryError) as error:
        free = free_bytes(Path(getattr(error, "filename", None) or name))
        forbidden = isinstance(error, PermissionError) or getattr(error, "errno", None) == errno.EROFS
        room = "" if free is None or forbidden else f"; {free:,} bytes are free there"
        sentence = (
            of_the_system(name, error)
            if isinstance(error, OSError)
            else f"{name}: there is not enough memory"
        )
        fail(f"{sentence}{room}. {saved}".rstrip(), STORAGE)
    except ValueError as error:
        if not isinstance(error, StorageError):
            raise
        fail(f"{error} {saved}".rstrip(), STORAGE)


def of_the_system(name: str, error: OSError) -> str:
    """Return the system's message about a file."""
    file = f" {error.filename}:" if error.filename and str(error.filename) != name else ""
    return f"{name}:{file} {error.strerror or error}"


def print_json(value: Any) -> None:
    """Print one object on standard output."""
    JSON.printed = True
    typer.echo(json_text(value))


def json_text(value: Any) -> str:
    """Return strict JSON: numbers that are not finite become null, numbers of NumPy those of Python; control
    characters are escaped.
    """
    text = json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)
    return (
        "".join(sign if sign.isprintable() or sign == "\n" else json.dumps(sign)[1:-1] for sign in text)
        if not _printable(text)
        else text
    )


def _printable(text: str) -> bool:
    return text.replace("\n", "").isprintable()


def answer(document: Document, as_json: bool = False) -> None:
    """Print an answer on standard output: the value of ``--json``, or words and tables; asides go to standard
    error.
    """
    if as_json:
        print_json(document.data)
        return
    from ..report.terminal import write

    write(document, output(), errors)


def plain(value: Any) -> Any:
    """Return the value with dictionaries, lists, texts and finite numbers only."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def print_line(text: str) -> None:
    """Print a line on standard output, in which brackets are no markup."""
    output().print(text, markup=False, soft_wrap=True)
