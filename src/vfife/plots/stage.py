"""Axes on which the same things are drawn at each moment of a film: first they are noted, then those that
moved are moved and drawn.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
TEXTUAL = ("weight", "fontsize", "color")  # of the look of a name, what its pixels show


@dataclass
class Drawn:
    """Something drawn: by which method of the axes, with which look and text, and where, shape (points, 2)."""

    by: str
    look: dict[str, Any]
    at: Array
    text: str = ""

    def like(self, other: Drawn) -> bool:
        """Whether the other one is the same thing in another place."""
        return (self.by, self.text, self.look) == (other.by, other.text, other.look)

    @property
    def rank(self) -> float:
        """What lies above what: as matplotlib's zorder."""
        return float(self.look.get("zorder", 2.0))


def points(x: Any, y: Any) -> Array:
    """Places as rows, shape (points, 2)."""
    return np.stack([np.atleast_1d(x), np.atleast_1d(y)], axis=1).astype(float)


@dataclass
class Notes:
    """Takes the place of axes in a sheet, and notes what is drawn."""

    drawn: list[Drawn] = field(default_factory=list)

    def plot(self, x: Any, y: Any, **look: Any) -> list[None]:
        """A line."""
        if np.size(x):
            self.drawn.append(Drawn("plot", look, points(x, y)))
        return [None]

    def fill(self, x: Any, y: Any, **look: Any) -> list[None]:
        """An area."""
        self.drawn.append(Drawn("fill", look, points(x, y)))
        return [None]

    def annotate(self, text: str, xy: Any, *, xytext: Any, **look: Any) -> None:
        """A text beside a place, or an arrow to it."""
        self.drawn.append(Drawn("annotate", look, np.array([xy, xytext], dtype=float), text))

    def text(self, x: float, y: float, text: str, **look: Any) -> None:
        """A text."""
        self.drawn.append(Drawn("text", look, np.array([[x, y]], dtype=float), text))


def placed(ax: Axes, one: Drawn) -> Artist:
    """What was noted, on axes."""
    if one.by == "plot":
        return ax.plot(*one.at.T, **one.look)[0]
    if one.by == "fill":
        return ax.fill(*one.at.T, **one.look)[0]
    if one.by == "annotate":
        return ax.annotate(one.text, tuple(one.at[0]), xytext=tuple(one.at[1]), **one.look)
    return ax.text(float(one.at[0, 0]), float(one.at[0, 1]), one.text, **one.look)


def move(artist: Any, one: Drawn) -> None:
    """Moves what is on axes to where it was noted."""
    if one.by == "plot":
        artist.set_data(*one.at.T)
    elif one.by == "fill":
        artist.set_xy(one.at)
    elif one.by == "annotate":
        artist.xy = tuple(one.at[0])
        artist.set_position(tuple(one.at[1]))
    else:
        artist.set_position(tuple(one.at[0]))


class Stamp:
    """A name as pixels, which is drawn once: of all that moves, text takes longest to draw. It covers what is
    under it.
    """

    def __init__(self, ax: Axes, one: Drawn) -> None:
        self.ax, (canvas, dpi) = ax, (ax.figure.canvas, ax.figure.dpi)
        look = {name: value for name, value in one.look.items() if name in TEXTUAL}
        figure = Figure(figsize=(0.35 + 0.11 * len(one.text), 0.35), dpi=dpi, facecolor="white")
        own: Any = FigureCanvasAgg(figure)  # whose methods have no types
        figure.text(0.5, 0.5, one.text, ha="center", va="center", **look)
        own.draw()
        drawn = np.array(own.buffer_rgba())
        rows, columns = (np.flatnonzero((drawn[..., :3] < 255).any(axis=(2, axis))) for axis in (1, 0))
        spaces = [
            slice(max(int(at[0]) - 2, 0), int(at[-1]) + 3) if len(at) else slice(0, 0)
            for at in (rows, columns)
        ]
        self.pixels = drawn[spaces[0], spaces[1]]
        self.canvas, self.scale = canvas, dpi / 72.0

    def draw(self, one: Drawn) -> None:
        """Puts the name where it was noted, as far as that is on the canvas."""
        picture = np.asarray(self.canvas.buffer_rgba())  # type: ignore[attr-defined]  # of Agg
        x, y = self.ax.transData.transform(one.at[0]) + (self.scale * one.at[1] if len(one.at) > 1 else 0.0)
        (height, width), (tall, wide) = picture.shape[:2], self.pixels.shape[:2]
        top, left = round(height - y - 0.5 * tall), round(x - 0.5 * wide)
        rows, columns = (
            slice(max(top, 0), min(top + tall, height)),
            slice(max(left, 0), min(left + wide, width)),
        )
        if rows.start < rows.stop and columns.start < columns.stop:
            picture[rows, columns] = self.pixels[
                rows.start - top : rows.stop - top, columns.start - left : columns.stop - left
            ]


class Stage:
    """Plays notes of many moments on axes: what stands still below all that moves is drawn once, with the
    background.
    """

    def __init__(self, ax: Axes, moments: list[list[Drawn]]) -> None:
        self.ax, self.moments = ax, moments
        first = moments[0]
        same = all(
            len(one) == len(first) and all(a.like(b) for a, b in zip(one, first, strict=True))
            for one in moments
        )
        still = [
            same and all(np.array_equal(one[k].at, first[k].at, equal_nan=True) for one in moments)
            for k in range(len(first))
        ]
        lowest = min(
            [one.rank for one, stands in zip(first, still, strict=True) if not stands], default=np.inf
        )
        under = [
            one.rank < lowest or one.by in ("text", "annotate") for one in first
        ]  # names are slow to draw
        self.below = {k for k in range(len(first)) if still[k] and under[k]} if same else set()
        for k in sorted(self.below):
            placed(ax, first[k])
        self.artists: list[Artist | Stamp] = []
        self.shown: list[Drawn] = []
        self.stamps: dict[str, Stamp] = {}

    def draw(self, moment: int) -> None:
        """Draws what moves as it is at a moment, over what is on the canvas."""
        found = sorted(
            (one for k, one in enumerate(self.moments[moment]) if k not in self.below),
            key=lambda one: one.rank,
        )
        if len(found) != len(self.shown) or not all(
            a.like(b) for a, b in zip(found, self.shown, strict=True)
        ):
            for artist in self.artists:
                if not isinstance(artist, Stamp):
                    artist.remove()
            self.artists = [self._stamp(one) if one.text else placed(self.ax, one) for one in found]
        for artist, one in zip(self.artists, found, strict=True):
            if isinstance(artist, Stamp):
                artist.draw(one)
            else:
                move(artist, one)
                self.ax.draw_artist(artist)
        self.shown = found

    def _stamp(self, one: Drawn) -> Stamp:
        if one.text not in self.stamps:
            self.stamps[one.text] = Stamp(self.ax, one)
        return self.stamps[one.text]
