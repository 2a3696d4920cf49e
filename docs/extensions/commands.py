"""Commands and scripts that are run while pages are built, and shown with what they answered.

``{commands}`` holds a terminal's lines, ``$ vfife ...`` or ``$ cat FILE``; ``{script}`` holds Python, whose
names live on to the end of the page; ``{file} NAME`` is a file that the reader writes, and ``{picture} NAME``
shows what one of them left. Each page works in an empty folder of its own, with the examples beside it as
``examples``. Nothing starts a process: a page of ten commands would wait ten times for Python to wake up.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import shutil
import sys
import textwrap
import traceback
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive, directives
from drawn_figures import new_figures
from matplotlib import rc_context
from notebooks import representation, run_cell

from vfife.plots.style import STYLE

ROOT = Path(__file__).resolve().parents[2]
WIDTH = 106  # signs of a line, as wide as a page shows
PROGRESS = re.compile(r"\s*\d+ %  |run: \d+ of \d+: ")  # what a terminal shows in place, and then wipes away


class Workshop:
    """The folder of a page, and the names of its scripts."""

    def __init__(self, folder: Path) -> None:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        shutil.copytree(ROOT / "examples", folder / "examples", ignore=shutil.ignore_patterns("__pycache__"))
        self.folder, self.names, self.pictures, self.cells = folder, {"__name__": "__main__"}, 0, 0

    @contextlib.contextmanager
    def inside(self) -> Any:
        """Work in the folder; yields what is written to either output."""
        heard = io.StringIO()
        with (
            contextlib.chdir(self.folder),
            contextlib.redirect_stdout(heard),
            contextlib.redirect_stderr(heard),
        ):
            yield heard


def answer(words: list[str]) -> int:
    """Runs a command of a terminal, as a process of its own would; its exit code."""
    if words[0] == "cat":
        print("\n".join(Path(name).read_text(encoding="utf-8").rstrip() for name in words[1:]))
        return 0
    if words[0] != "vfife":
        raise ValueError(f"{words[0]}: pages run vfife and cat")
    from vfife.cli import app as commands
    from vfife.cli import signals, terminal

    commands.Signals = (
        contextlib.nullcontext
    )  # the builder ends its processes by signals, which are not for the command
    signals.JSON.wanted, signals.JSON.printed = "--json" in words, False
    given, sys.argv, terminal.PIPE_WIDTH = sys.argv, words, WIDTH
    try:
        commands.app(words[1:], prog_name="vfife")
    except SystemExit as end:
        return int(end.code or 0)
    finally:
        sys.argv = given
    return 0


def folded(line: str) -> list[str]:
    """A long line as a terminal of this width folds it, but between words."""
    return textwrap.wrap(line, WIDTH, subsequent_indent=" " * (len(line) - len(line.lstrip()) + 3))


def tidy(text: str) -> str:
    """An answer without lines of progress and without blanks at ends of lines."""
    heard = [line.rstrip() for line in text.splitlines() if not PROGRESS.match(line)]
    lines = [part for line in heard for part in (folded(line) if len(line) > WIDTH else [line])]
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip("\n")


CURRENT: dict[str, Workshop] = {}  # of the pages that are being read


class Commands(Directive):
    """Lines of a terminal, run."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "exit": directives.nonnegative_int,
        "lines": directives.unchanged,
        "quiet": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        work, parts = CURRENT[self.state.document.settings.env.docname], []
        for line in self.content:
            words = shlex.split(line.removeprefix("$ "), comments=True)
            with work.inside() as heard:
                code = answer(words)
            if code != self.options.get("exit", 0):
                raise self.error(f"{line} ended with {code}:\n{heard.getvalue()}")
            parts += [line, "" if "quiet" in self.options else self.chosen(tidy(heard.getvalue()))]
        return [literal("\n".join(part for part in parts if part), "console")]

    def chosen(self, text: str) -> str:
        """The lines from one that begins with a text to before one that begins with another:
        ``Largest .. Contact``.
        """
        if "lines" not in self.options:
            return text
        begin, _, end = (part.strip() for part in self.options["lines"].partition(".."))
        lines = text.splitlines()
        first = (
            next((k for k, line in enumerate(lines) if line.lstrip().startswith(begin)), None) if begin else 0
        )
        if first is None:
            raise self.error(f"no line begins with {begin!r} in\n{text}")
        last = (
            next((k for k in range(first + 1, len(lines)) if lines[k].lstrip().startswith(end)), None)
            if end
            else len(lines)
        )
        if last is None:
            raise self.error(f"no line after that begins with {end!r} in\n{text}")
        kept = "\n".join(lines[first:last]).strip("\n")
        return ("[...]\n" if first else "") + kept + ("\n[...]" if last < len(lines) else "")


class Script(Directive):
    """Python, run; the figures that it leaves in its names are shown below what it printed."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {"alt": directives.unchanged}

    def run(self) -> list[nodes.Node]:
        work, code = CURRENT[self.state.document.settings.env.docname], "\n".join(self.content)
        with rc_context(STYLE), work.inside() as heard:
            try:
                exec(compile(code, "<script>", "exec"), work.names)
            except Exception as error:
                raise self.error("".join(traceback.format_exception(error))) from error
        shown: list[nodes.Node] = [literal(code, "python")]
        if said := tidy(heard.getvalue()):
            shown.append(literal(said, "text", "answer"))
        for figure in new_figures(work.names):
            work.pictures += 1
            path = work.folder / f"figure-{work.pictures}.png"
            with rc_context(STYLE):
                figure.savefig(path, dpi=110)
            shown.append(drawn(path, self.options.get("alt", "")))
        return shown


class NotebookCell(Directive):
    """A cell of a notebook, run; what it prints and displays is shown below it."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        work, code = CURRENT[self.state.document.settings.env.docname], "\n".join(self.content)
        work.cells += 1
        with rc_context(STYLE), work.inside() as heard:
            try:
                value = run_cell(code, work.names, f"<cell {work.cells} of {work.folder.name}>")
                shown = "" if value is None else representation(value)
            except Exception as error:
                raise self.error("".join(traceback.format_exception(error))) from error
        parts: list[nodes.Node] = [literal(code, "python")]
        text = tidy(heard.getvalue())
        if isinstance(shown, bytes):
            path = work.folder / f"cell-{work.cells}.png"
            path.write_bytes(shown)
            picture = [drawn(path, f"figure of cell {work.cells}")]
        elif shown.lstrip().startswith("<") and not shown.startswith("<vfife"):
            picture = [nodes.raw("", f'<div class="displayed">{shown}</div>', format="html")]
        else:
            text, picture = tidy(f"{text}\n{shown}"), []
        return [*parts, *([literal(text, "text", "answer")] if text.strip() else []), *picture]


class File(Directive):
    """A file that the reader writes, for commands that follow."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        code, name = "\n".join(self.content), self.arguments[0]
        (CURRENT[self.state.document.settings.env.docname].folder / name).write_text(
            code + "\n", encoding="utf-8"
        )
        shown = nodes.container("", classes=["literal-block-wrapper"], literal_block=True)
        shown += nodes.caption(name, name)
        shown += literal(code, {"py": "python"}.get(name.rpartition(".")[2], name.rpartition(".")[2]))
        return [shown]


class Picture(Directive):
    """A picture that a command left in the folder of the page."""

    required_arguments = 1
    option_spec: ClassVar[dict[str, Any]] = {"alt": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        path = CURRENT[self.state.document.settings.env.docname].folder / self.arguments[0]
        if not path.is_file():
            raise self.error(f"{self.arguments[0]}: nothing on this page has left it")
        return [drawn(path, self.options.get("alt", ""))]


def literal(text: str, language: str, *classes: str) -> nodes.Node:
    """A block as it is typed or printed."""
    return nodes.literal_block(text, text, language=language, classes=["ran", *classes])


def drawn(path: Path, alt: str) -> nodes.Node:
    """A picture, in a path from the root of the pages."""
    docs = ROOT / "docs"
    return nodes.image(uri=f"/{path.relative_to(docs).as_posix()}", alt=alt, classes=["drawn"])


def begin_page(app: Any, docname: str, source: list[str]) -> None:
    """An empty folder for a page that runs something."""
    if re.search(r"^\s*[`:]{3,}\{(commands|script|file|notebook-cell)\}", source[0], re.M):
        app.env.note_dependency(
            str(Path(app.srcdir) / "_made" / "made-of")
        )  # which is new where the package has changed
        CURRENT[docname] = Workshop(Path(app.srcdir) / "_made" / "work" / docname.replace("/", "-"))


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("commands", Commands)
    app.add_directive("script", Script)
    app.add_directive("file", File)
    app.add_directive("notebook-cell", NotebookCell)
    app.add_directive("picture", Picture)
    app.connect("source-read", begin_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
