"""Strokes on a sheet: what nouns say of how they are drawn, with matplotlib."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..model.strokes import Block, Curve, Mark, Stroke, Surface
from .sheet import Sheet
from .style import GREY, INK, SIGNS

MARKS: dict[str, dict[str, Any]] = {
    "ring": {"marker": "o", "ms": 8, "mfc": "white", "mew": 1.4, "zorder": 7},
    "dot": {"marker": "o", "ms": 3.5, "zorder": 8},
    "pin": {"marker": "o", "ms": 6.5, "mfc": "white", "mew": 2.0, "zorder": 7},
    "square": {"marker": "s", "ms": 6, "zorder": 7},
    "bearing": {"marker": "o", "ms": 11, "mfc": "white", "mew": 1.8},
}
INNER: dict[str, dict[str, Any]] = {"bearing": {"marker": "o", "ms": 7.5, "mfc": "#cfcfcf", "mew": 0.9}}  # of a sign of two
DASHES: dict[str, Any] = {"-": "-", "-.": "-.", ":": (0, (2, 2))}


def draw(sheet: Sheet, strokes: Iterable[Stroke], bodies: tuple[str, str] = ("ground", "ground")) -> None:
    """Draws the strokes of a noun between two bodies, whose colours they may take; what has a sign goes into the legend."""
    colours = {"ink": INK, "grey": GREY, "spring": SIGNS, "bearing": sheet.colour(bodies[0]), "journal": sheet.colour(bodies[1])}
    signs: dict[str, list[Any]] = {}
    for stroke in strokes:
        if isinstance(stroke, Surface):
            sheet.hatched(stroke.first, stroke.second, stroke.inward, stroke.depth)
            continue
        artist = _one(sheet, stroke, colours[stroke.colour])
        if stroke.sign:
            signs.setdefault(stroke.sign, []).append(artist)
    sheet.signs |= {sign: artists[0] if len(artists) == 1 else tuple(artists) for sign, artists in signs.items()}


def _one(sheet: Sheet, stroke: Curve | Block | Mark, colour: str) -> Any:
    if isinstance(stroke, Curve):
        look = {"lw": stroke.width, "zorder": stroke.rank, "ls": DASHES[stroke.dashes], "alpha": stroke.fade}
        return sheet.line(stroke.points, color=colour, **look)
    if isinstance(stroke, Mark):
        at: Any = ([], []) if stroke.at is None else stroke.at
        looks = [MARKS[stroke.shape], *([INNER[stroke.shape]] if stroke.shape in INNER else [])]
        drawn = tuple(sheet.ax.plot(*at, ls="", **({"mec": colour, "mfc": colour} | look))[0] for look in looks)
        return drawn if len(drawn) > 1 else drawn[0]
    box = stroke.centre, stroke.along, stroke.length, stroke.height
    sheet.box(*box, facecolor="white", edgecolor="none", zorder=3.2)
    sheet.box(*box, facecolor=colour, alpha=0.35, edgecolor="none", zorder=3.3)
    return sheet.box(*box, facecolor="none", edgecolor=colour, lw=1.8, zorder=5)
