"""The sheet a mechanism is drawn on: axes, scale, where things are at the output that is drawn, and strokes
of nouns with matplotlib.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..measures.motion import pin_path
from ..model.drawing.strokes import Block, Curve, Mark, Stroke, Surface
from .style import GREY, INK, SIGNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..model.mechanism import Mechanism
    from ..results.view import View

Array = NDArray[np.float64]


@dataclass
class Sheet:
    """``factor`` turns metres into the units drawn, ``size`` is that of the drawing in those, ``shown`` the
    output that is drawn.

    Bodies that share a ``colours`` entry with an earlier one are ``striped``.
    """

    ax: Axes
    result: View
    factor: float
    size: float
    shown: int
    colours: dict[str, str]
    striped: frozenset[str] = frozenset()
    signs: dict[str, Any] = field(default_factory=dict)

    @property
    def mechanism(self) -> Mechanism:
        """What is drawn."""
        return self.result.record.assembly.mechanism

    def path(self, body: str, pin: str) -> Array:
        """Path of a pin in the units drawn, shape (outputs, 2)."""
        return self.factor * pin_path(self.result.record, body, pin)

    def at(self, end: str) -> Array:
        """Place of ``body.pin`` as it is drawn, shape (2,)."""
        body, _, pin = end.partition(".")
        return np.asarray(self.path(body, pin)[self.shown], dtype=float)

    def angles(self, body: str) -> Array:
        """Angle of a body (rad), 0 of the ground, shape (outputs,)."""
        if body == "ground":
            return np.zeros(len(self.result.record.steps))
        column = list(self.result.record.assembly.bodies).index(body)
        return np.asarray(self.result.channels["body_angle"].values[:, column], dtype=float)

    def colour(self, body: str) -> str:
        """Colour of a body; that of ink for the ground."""
        return self.colours.get(body, INK)

    def line(self, points: Any, **look: Any) -> Any:
        """A line through points (n, 2)."""
        style: dict[str, Any] = {"color": INK, "lw": 1.2, "zorder": 5} | look
        return self.ax.plot(*np.asarray(points, dtype=float).T, **style)[0]

    def circle(self, centre: Array, radius: float, **look: Any) -> Any:
        """A circle."""
        turn = np.linspace(0.0, 2.0 * np.pi, 121)
        return self.line(centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1), **look)

    def hatched(self, first: Array, second: Array, inward: Array, depth: float) -> None:
        """A surface from one point to another, its material hatched on the side that ``inward`` points to."""
        self.line([first, second], lw=1.4, zorder=2)
        corners = np.array([first, second, second + depth * inward, first + depth * inward])
        look: dict[str, Any] = {
            "facecolor": "none",
            "edgecolor": GREY,
            "hatch": "//////",
            "lw": 0.0,
            "zorder": 1.5,
        }
        self.ax.fill(*corners.T, **look)

    def box(self, centre: Array, along: Array, length: float, height: float, **look: Any) -> Any:
        """A rectangle with its length along a unit vector."""
        across = np.array([-along[1], along[0]])
        corners = [
            centre + 0.5 * (i * length * along + j * height * across)
            for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        return self.ax.fill(*np.array(corners).T, **look)[0]


MARKS: dict[str, dict[str, Any]] = {
    "ring": {"marker": "o", "ms": 8, "mfc": "white", "mew": 1.4, "zorder": 7},
    "dot": {"marker": "o", "ms": 3.5, "zorder": 8},
    "pin": {"marker": "o", "ms": 6.5, "mfc": "white", "mew": 2.0, "zorder": 7},
    "square": {"marker": "s", "ms": 6, "zorder": 7},
    "bearing": {"marker": "o", "ms": 11, "mfc": "white", "mew": 1.8},
}
INNER: dict[str, dict[str, Any]] = {
    "bearing": {"marker": "o", "ms": 7.5, "mfc": "#cfcfcf", "mew": 0.9}
}  # of a sign of two
DASHES: dict[str, Any] = {"-": "-", "-.": "-.", ":": (0, (2, 2))}


def draw(sheet: Sheet, strokes: Iterable[Stroke], bodies: tuple[str, str] = ("ground", "ground")) -> None:
    """Draws the strokes of a noun between two bodies, whose colours they may take; what has a sign goes into
    the legend.
    """
    colours = {
        "ink": INK,
        "grey": GREY,
        "spring": SIGNS,
        "bearing": sheet.colour(bodies[0]),
        "journal": sheet.colour(bodies[1]),
    }
    signs: dict[str, list[Any]] = {}
    for stroke in strokes:
        if isinstance(stroke, Surface):
            sheet.hatched(stroke.first, stroke.second, stroke.inward, stroke.depth)
            continue
        artist = _one(sheet, stroke, colours[stroke.colour])
        if stroke.sign:
            signs.setdefault(stroke.sign, []).append(artist)
    sheet.signs |= {
        sign: artists[0] if len(artists) == 1 else tuple(artists) for sign, artists in signs.items()
    }


def _one(sheet: Sheet, stroke: Curve | Block | Mark, colour: str) -> Any:
    if isinstance(stroke, Curve):
        look = {"lw": stroke.width, "zorder": stroke.rank, "ls": DASHES[stroke.dashes], "alpha": stroke.fade}
        return sheet.line(stroke.points, color=colour, **look)
    if isinstance(stroke, Mark):
        at: Any = ([], []) if stroke.at is None else stroke.at
        looks = [MARKS[stroke.shape], *([INNER[stroke.shape]] if stroke.shape in INNER else [])]
        drawn = tuple(
            sheet.ax.plot(*at, ls="", **({"mec": colour, "mfc": colour} | look))[0] for look in looks
        )
        return drawn if len(drawn) > 1 else drawn[0]
    box = stroke.centre, stroke.along, stroke.length, stroke.height
    sheet.box(*box, facecolor="white", edgecolor="none", zorder=3.2)
    sheet.box(*box, facecolor=colour, alpha=0.35, edgecolor="none", zorder=3.3)
    return sheet.box(*box, facecolor="none", edgecolor=colour, lw=1.8, zorder=5)
