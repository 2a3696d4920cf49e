"""The suite as documents of ``vfife verify``, and as a page of documentation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from vfife.report.document import Document, Paragraph, Part, Table

from .case import Case, Row, entry

CaseRows = tuple[Case, list[Row]]

FAMILIES = {
    "beams": "Elastic beams", "bearings": "Bearings", "chaos": "Chaos and its beginnings",
    "drives": "Gears, motors and prescribed motion",
    "equilibria": "Equilibria", "fourbars": "Four-bar",
    "guides": "Sliders and guides", "impacts": "Contacts",
    "oscillators": "Springs, dampers, bushings and stops",
    "pendulums": "Pendulums and closed chains", "ranges": "Ranges of numbers",
    "squeezer": "Andrews' squeezer",
}  # fmt: skip
VERDICTS = {True: "passed", False: "FAILED"}
MINUS = "−"  # after which no line is broken
HEAD = "| quantity | unit | reference | vfife | error | tolerance |\n|---|---|--:|--:|--:|--:|"


def tables(cases: Iterable[Case]) -> str:
    """All cases by family, each run, as Markdown; RuntimeError where one fails, since a page must not show
    what does not hold.
    """
    parts, family = [], ""
    for case in cases:
        if case.family != family:
            family = case.family
            parts.append(f"## {FAMILIES.get(family, family)}")
        rows = case.check()
        wrong = [row.note or row.quantity for row in rows if not row.passed]
        if wrong:
            raise RuntimeError(f"verification case {case.name!r} fails: {', '.join(wrong)}")
        description = " ".join((case.rows.__doc__ or "").split())
        parts += [
            f"### {case.title}",
            f"`{case.name}`: {description}",
            f"Reference: {case.source}.",
            "\n".join([HEAD, *map(line, rows)]),
            *(f"{counts}." for counts in counted(rows)),
        ]
    return "\n\n".join(parts)


def counted(rows: Iterable[Row]) -> list[str]:
    """Return the counts behind the shares of a case, in words."""
    return [f"{row.quantity}: {row.counted}" for row in rows if row.counts]


def line(row: Row) -> str:
    """Return a row of a table; errors below rounding count as zero."""
    quantity, unit = (text.replace("|", "\\|") for text in (row.quantity, row.unit))
    error = "0" if abs(row.error) < 1e-12 else f"{row.error:+.1e}"
    numbers = (f"{row.reference:.6g}", f"{row.value:.6g}", error, f"{row.tolerance:g}")
    shown = " | ".join(number.replace("-", MINUS) for number in numbers)
    return f"| {quantity} | {unit} | {shown} |"


def listing(cases: Sequence[Case]) -> Document:
    """Return names, titles and sources of cases."""
    rows = [(case.name, case.title, case.source) for case in cases]
    keys = ("family", "title", "source", "quick")
    data = [{"case": case.name} | {key: getattr(case, key) for key in keys} for case in cases]
    return Document([Table(("case", "title", "source"), rows)], data={"cases": data})


def document(case: Case, rows: Sequence[Row]) -> Document:
    """Return the numbers of a case beside their references."""
    cells = [
        (row.note or row.quantity, row.unit, f"{row.reference:.7g}", f"{row.value:.7g}", f"{row.error:+.1e}",
         f"{row.tolerance:.1g}", VERDICTS[row.passed])
        for row in rows
    ]  # fmt: skip
    heads = ("quantity", "unit", "reference", "ours", "error", "tolerance", "")
    passed = all(row.passed for row in rows)
    title = f"{case.name}  {VERDICTS[passed]}"
    parts: list[Part] = [
        Paragraph(f"  {case.title}", lead=title, style="good" if passed else "bad"),
        Paragraph(case.source, style="faint", indent=2),
        Table(heads, cells, numbers=(2, 3, 4, 5), indent=2),
        *(Paragraph(text, indent=2) for text in counted(rows)),
    ]
    return Document(parts)


def failed(done: Sequence[CaseRows]) -> list[str]:
    """Return the names of the cases with a number beyond its tolerance."""
    return [case.name for case, rows in done if not all(row.passed for row in rows)]


def conclusion(done: Sequence[CaseRows], interrupted: bool = False) -> Document:
    """Return how many cases passed; as data all numbers."""
    data: dict[str, Any] = {"cases": [entry(case, row) for case, rows in done for row in rows]}
    wrong, numbers = failed(done), sum(len(rows) for _, rows in done)
    text = f"{len(done) - len(wrong)} of {len(done)} cases passed, {numbers} numbers"
    text += f"; failed: {', '.join(wrong)}" if wrong else ""
    data |= {"interrupted": True} if interrupted else {}
    return Document([Paragraph(text, style="bad" if wrong else "good")], data=data)
