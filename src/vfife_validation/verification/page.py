"""The suite as a page of documentation."""

from __future__ import annotations

from collections.abc import Iterable

from .case import Case, Row

FAMILIES = {
    "beams": "Elastic beams in motion", "chaos": "Chaos and its beginnings",
    "drives": "Gears, motors and prescribed motion",
    "equilibria": "Equilibria", "fourbars": "Four-bar",
    "guides": "Sliders and guides", "impacts": "Contacts",
    "oscillators": "Springs, dampers, bushings and stops",
    "pendulums": "Pendulums and closed chains", "squeezer": "Andrews' squeezer",
}  # fmt: skip
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
