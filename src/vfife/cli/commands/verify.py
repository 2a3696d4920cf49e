"""``vfife verify``: the verification suite, case by case."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...report.document import Document, Paragraph, Table
from ..options import JsonOption
from ..signals import NOW
from ..terminal import answer, errors, fail, tell

if TYPE_CHECKING:
    from vfife_validation.verification import Case, Row

Told = tuple["Case", "list[Row]"]


def verify(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[CASE]...", help="These cases only.", show_default=False)
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the cases and run none.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Run the verification suite: our numbers beside published ones, closed forms and independent
    integrations. Exit code 1 if any fails.
    """
    from vfife_validation.verification import CASES

    cases = chosen(CASES, names or [])
    if listed:
        show_list(cases, as_json)
        return
    done: list[Told] = []
    interrupted = False
    try:
        for told in checked(cases, quiet=as_json):
            done.append(told)
    except KeyboardInterrupt:
        interrupted = True
    conclude(done, len(cases), interrupted, as_json)


def chosen(known: Mapping[str, Case], names: Sequence[str]) -> list[Case]:
    """The cases named, all of them where none is; ends with suggestions for those that there are not."""
    wrong = [name for name in names if name.lower() not in known]
    if wrong:
        sentences = []
        for name in wrong:
            near = difflib.get_close_matches(name.lower(), known, 3, 0.4)
            said = (
                f"did you mean {' or '.join(repr(one) for one in near)}?"
                if near
                else "vfife verify --list names all there are"
            )
            sentences.append(f"there is no case {name!r}; {said}")
        fail("; ".join(sentences))
    return [known[name] for name in dict.fromkeys(name.lower() for name in names)] or list(known.values())


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


def checked(cases: Sequence[Case], quiet: bool) -> Iterator[Told]:
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
        (entry.note or entry.quantity, entry.unit, f"{entry.reference:.7g}", f"{entry.value:.7g}", f"{entry.error:+.1e}", f"{entry.tolerance:.1g}",
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


def conclude(done: Sequence[Told], wanted: int, interrupted: bool, as_json: bool) -> None:
    """The last line, or the one object; then the exit code."""
    from vfife_validation.verification import entry

    failed = [one.name for one, rows in done if not all(each.passed for each in rows)]
    whole: dict[str, Any] = {"cases": [entry(one, each) for one, rows in done for each in rows]}
    numbers = sum(len(rows) for _, rows in done)
    said = f"{len(done) - len(failed)} of {len(done)} cases passed, {numbers} numbers" + (
        f"; failed: {', '.join(failed)}" if failed else ""
    )
    words = Paragraph(said, style="bad" if failed else "good")
    answer(Document([words], data={**whole, "interrupted": True} if interrupted else whole), as_json)
    if interrupted:
        tell("interrupted", f"Stopped by Ctrl-C after {len(done)} of {wanted} cases.")
        raise typer.Exit(NOW.code)
    if failed:
        raise typer.Exit(1)
