"""``vfife verify``: the verification suite, case by case."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ...report.document import Document, Paragraph, Table
from ..options import JsonOptions, argument, flag, option
from ..signals import NOW
from ..terminal import answer, errors, fail, tell
from .verify_page import PAGES, verify_page

if TYPE_CHECKING:
    from vfife_validation.verification import Case, Row

CaseRows = tuple["Case", "list[Row]"]


class VerifyOptions(JsonOptions):
    """Options of ``vfife verify``."""

    names: list[str] | None = argument(
        "These cases only; measured: compare with measurements, or with those named after it.",
        "[CASE]...",
        None,
    )
    folder: Path | None = option(
        None, "Folder of the page that `measured` writes, by default of its name.", "FOLDER", "-o", "--output"
    )
    listed: bool = flag("--list", "List the cases and run none.")


def verify(options: VerifyOptions) -> None:
    """Run the verification suite: our numbers beside published ones, closed forms and independent
    integrations. Exit code 1 if any fails.

    `vfife verify measured` compares with measured pendulums and a hysteresis loop instead, and writes a page.
    """
    group, *items = options.names or [""]
    if group.lower() in PAGES:
        verify_page(group.lower(), items, options.folder, options.listed, options.as_json)
        return
    from vfife_validation.verification import CASES

    cases = chosen(CASES, options.names or [])
    if options.listed:
        show_list(cases, options.as_json)
        return
    done: list[CaseRows] = []
    interrupted = False
    try:
        for case in checked(cases, quiet=options.as_json):
            done.append(case)
    except KeyboardInterrupt:
        interrupted = True
    conclude(done, len(cases), interrupted, options.as_json)


def chosen(cases: Mapping[str, Case], names: Sequence[str]) -> list[Case]:
    """The cases named, all of them where none is; ends with suggestions for those that there are not."""
    wrong = [name for name in names if name.lower() not in cases]
    if wrong:
        sentences = []
        for name in wrong:
            near = difflib.get_close_matches(name.lower(), cases, 3, 0.4)
            sentence = (
                f"did you mean {' or '.join(repr(one) for one in near)}?"
                if near
                else "vfife verify --list names all there are"
            )
            sentences.append(f"there is no case {name!r}; {sentence}")
        fail("; ".join(sentences))
    return [cases[name] for name in dict.fromkeys(name.lower() for name in names)] or list(cases.values())


def show_list(cases: Sequence[Case], as_json: bool) -> None:
    """Names, titles and sources."""
    rows = [(one.name, one.title, one.source) for one in cases]
    data = {
        "cases": [
            {
                "case": one.name,
                "family": one.family,
                "title": one.title,
                "source": one.source,
                "quick": one.quick,
            }
            for one in cases
        ]
    }
    answer(Document([Table(("case", "title", "source"), rows)], data=data), as_json)


def checked(cases: Sequence[Case], quiet: bool) -> Iterator[CaseRows]:
    """Runs the cases; on a terminal a line says which one is under way, and each one is shown when it is
    done.
    """
    from rich.status import Status

    console = errors()
    with Status("", console=console) as status:
        if not console.is_terminal:
            status.stop()
        for number, one in enumerate(cases, start=1):
            status.update(f"{number} of {len(cases)}  {one.title}")
            rows = one.check()
            if not quiet:
                answer(document(one, rows))
            yield one, rows


def document(one: Case, rows: Sequence[Row]) -> Document:
    """The numbers of a case beside their references."""
    passed = all(entry.passed for entry in rows)
    cells = [
        (entry.note or entry.quantity, entry.unit, f"{entry.reference:.7g}", f"{entry.value:.7g}",
         f"{entry.error:+.1e}", f"{entry.tolerance:.1g}",
         verdict(entry.passed))
        for entry in rows
    ]  # fmt: skip
    heads = ("quantity", "unit", "reference", "ours", "error", "tolerance", "")
    title = Paragraph(
        f"  {one.title}", lead=f"{one.name}  {verdict(passed)}", style="good" if passed else "bad"
    )
    return Document(
        [
            title,
            Paragraph(one.source, style="faint", indent=2),
            Table(heads, cells, numbers=(2, 3, 4, 5), indent=2),
        ]
    )


def verdict(passed: bool) -> str:
    """In a word."""
    return "passed" if passed else "FAILED"


def conclude(done: Sequence[CaseRows], total: int, interrupted: bool, as_json: bool) -> None:
    """The last line, or the one object; then the exit code."""
    from vfife_validation.verification import entry

    failed = [one.name for one, rows in done if not all(each.passed for each in rows)]
    data: dict[str, Any] = {"cases": [entry(one, each) for one, rows in done for each in rows]}
    numbers = sum(len(rows) for _, rows in done)
    sentence = f"{len(done) - len(failed)} of {len(done)} cases passed, {numbers} numbers" + (
        f"; failed: {', '.join(failed)}" if failed else ""
    )
    words = Paragraph(sentence, style="bad" if failed else "good")
    answer(Document([words], data={**data, "interrupted": True} if interrupted else data), as_json)
    if interrupted:
        tell("interrupted", f"Stopped by Ctrl-C after {len(done)} of {total} cases.")
        raise typer.Exit(NOW.code)
    if failed:
        raise typer.Exit(1)
