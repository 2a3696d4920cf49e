"""The suite as documents of ``vfife verify``, and as a page of documentation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from vfife.report.document import Document, Paragraph, Part, Table

from .case import Case, Row, entry

CaseRows = tuple[Case, list[Row]]

FAMILIES = {
    "beams": "Elastic beams in motion", "chaos": "Chaos and its beginnings",
    "drives": "Gears, motors and prescribed motion",
    "equilibria": "Equilibria", "fourbars": "Four-bar",
    "guides": "Sliders and guides", "impacts": "Contacts",
    "oscillators": "Springs, dampers, bushings and stops",
    "pendulums": "Pendulums and closed chains", "squeezer": "Andrews' squeezer",
}  # fmt: skip
VERDICTS = {True: "passed", False: "FAILED"}
MINUS = "−"  # after which no line is broken
HEAD = "| quantity | unit | reference | vfife | error | tolerance |\n|---|---|--:|--:|--:|--:|"


def tables(cases: Iterable[Case]) -> str:
    """All cases by family, each run, as Markdown; RuntimeError where one fails, since a page must not show
    what does not hold.
    """
    parts, family = [], ""
    for one in cases:
        if one.family != family:
            family = one.family
            parts.append(f"## {FAMILIES.get(family, family)}")
        rows = one.check()
        wrong = [row.note or row.quantity for row in rows if not row.passed]
        if wrong:
            raise RuntimeError(f"verification case {one.name!r} fails: {', '.join(wrong)}")
        about = " ".join((one.rows.__doc__ or "").split())
        parts += [
            f"### {one.title}",
            f"`{one.name}`: {about}",
            f"Reference: {one.source}.",
            "\n".join([HEAD, *map(line, rows)]),
        ]
    return "\n\n".join(parts)


def line(row: Row) -> str:
    """Return a row of a table; errors below rounding count as zero."""
    quantity, unit = (text.replace("|", "\\|") for text in (row.quantity, row.unit))
    error = "0" if abs(row.error) < 1e-12 else f"{row.error:+.1e}"
    numbers = (f"{row.reference:.6g}", f"{row.value:.6g}", error, f"{row.tolerance:g}")
    shown = " | ".join(number.replace("-", MINUS) for number in numbers)
    return f"| {quantity} | {unit} | {shown} |"


def listing(cases: Sequence[Case]) -> Document:
    """Return names, titles and sources of cases."""
    rows = [(one.name, one.title, one.source) for one in cases]
    keys = ("family", "title", "source", "quick")
    data = [{"case": one.name} | {key: getattr(one, key) for key in keys} for one in cases]
    return Document([Table(("case", "title", "source"), rows)], data={"cases": data})


def document(one: Case, rows: Sequence[Row]) -> Document:
    """Return the numbers of a case beside their references."""
    cells = [
        (row.note or row.quantity, row.unit, f"{row.reference:.7g}", f"{row.value:.7g}", f"{row.error:+.1e}",
         f"{row.tolerance:.1g}", VERDICTS[row.passed])
        for row in rows
    ]  # fmt: skip
    heads = ("quantity", "unit", "reference", "ours", "error", "tolerance", "")
    passed = all(row.passed for row in rows)
    title = f"{one.name}  {VERDICTS[passed]}"
    parts: list[Part] = [
        Paragraph(f"  {one.title}", lead=title, style="good" if passed else "bad"),
        Paragraph(one.source, style="faint", indent=2),
        Table(heads, cells, numbers=(2, 3, 4, 5), indent=2),
    ]
    return Document(parts)


def failed(done: Sequence[CaseRows]) -> list[str]:
    """Return the names of the cases with a number beyond its tolerance."""
    return [one.name for one, rows in done if not all(row.passed for row in rows)]


def conclusion(done: Sequence[CaseRows], interrupted: bool = False) -> Document:
    """Return how many cases passed; as data all numbers."""
    data: dict[str, Any] = {"cases": [entry(one, row) for one, rows in done for row in rows]}
    wrong, numbers = failed(done), sum(len(rows) for _, rows in done)
    text = f"{len(done) - len(wrong)} of {len(done)} cases passed, {numbers} numbers"
    text += f"; failed: {', '.join(wrong)}" if wrong else ""
    data |= {"interrupted": True} if interrupted else {}
    return Document([Paragraph(text, style="bad" if wrong else "good")], data=data)
