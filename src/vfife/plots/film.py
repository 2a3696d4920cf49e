"""Frames of a film: the moving mechanism with its clearances enlarged, and beside it the growing curves of
joint forces.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..measures.motion import pin_path, within_turn
from ..results.run_data import RunData
from ..solvers.record import Record
from .curves import Quantity, ideal_curve, largest_forces
from .drawing import draw_symbols, extent
from .name_sides import name_sides
from .style import BLUE, INK, ORANGE, STYLE, VERMILION, Array, circle, heading, scale_of
from .symbols import Outline, Sheet, joint_names, outline_of
from .turn import Span, span_of

SIZE = (10.0, 5.625)  # inches
MOST_PANELS = 3
CIRCLE_RADIUS = 0.028  # radius of the largest clearance circle, as a share of the drawing
NAME_OFFSET = 7.0  # points by which names are moved away from enlarged circles
LEAST_ENLARGED = 2.0  # below this factor clearances are drawn as they are
TRAIL = 12  # frames over which a journal's path is shown in its circle
CIRCLE = circle(1.0, 49).T
TEXTUAL = ("weight", "fontsize", "color")  # properties of a text that change its pixels


@dataclass
class DrawCall:
    """A call of a method of axes, with its look and text, and the position of what is drawn, shape (points,
    2).
    """

    method: str
    look: dict[str, Any]
    at: Array
    text: str = ""

    @property
    def rank(self) -> float:
        """Order of drawing: matplotlib's zorder."""
        return float(self.look.get("zorder", 2.0))


def same_artists(first: Sequence[DrawCall], second: Sequence[DrawCall]) -> bool:
    """Return whether two lists of calls draw the same artists, perhaps at other positions."""
    return [(call.method, call.text, call.look) for call in first] == [
        (call.method, call.text, call.look) for call in second
    ]


def points(x: Any, y: Any) -> Array:
    """Return the positions as rows, shape (points, 2)."""
    return np.column_stack([x, y]).astype(float)


@dataclass
class CallRecorder:
    """Axes of a sheet that record calls instead of drawing."""

    calls: list[DrawCall] = field(default_factory=list)

    def plot(self, x: Any, y: Any, **look: Any) -> list[None]:
        """Record a line."""
        if np.size(x):
            self.calls.append(DrawCall("plot", look, points(x, y)))
        return [None]

    def fill(self, x: Any, y: Any, **look: Any) -> list[None]:
        """Record an area."""
        self.calls.append(DrawCall("fill", look, points(x, y)))
        return [None]

    def annotate(self, text: str, xy: Any, *, xytext: Any, **look: Any) -> None:
        """Record a text beside a position, or an arrow to it."""
        self.calls.append(DrawCall("annotate", look, np.array([xy, xytext], dtype=float), text))

    def text(self, x: float, y: float, text: str, **look: Any) -> None:
        """Record a text."""
        self.calls.append(DrawCall("text", look, np.array([[x, y]], dtype=float), text))


def draw_on(ax: Axes, call: DrawCall) -> Artist:
    """Carry out a recorded call and return its artist."""
    if call.method == "plot":
        return ax.plot(*call.at.T, **call.look)[0]
    if call.method == "fill":
        return ax.fill(*call.at.T, **call.look)[0]
    if call.method == "annotate":
        return ax.annotate(call.text, tuple(call.at[0]), xytext=tuple(call.at[1]), **call.look)
    return ax.text(float(call.at[0, 0]), float(call.at[0, 1]), call.text, **call.look)


def move(artist: Any, call: DrawCall) -> None:
    """Move an artist to the position of a call; texts are drawn as sprites, arrows alone are annotations
    here.
    """
    if call.method == "plot":
        artist.set_data(*call.at.T)
    elif call.method == "fill":
        artist.set_xy(call.at)
    else:
        artist.xy = tuple(call.at[0])
        artist.set_position(tuple(call.at[1]))


class TextSprite:
    """A text as pixels, rendered once, because text takes longest to draw of all that moves. It covers what
    is under it.
    """

    def __init__(self, ax: Axes, call: DrawCall) -> None:
        self.ax, self.canvas, dpi = ax, ax.figure.canvas, ax.figure.dpi
        look = {name: value for name, value in call.look.items() if name in TEXTUAL}
        figure = Figure(figsize=(0.35 + 0.11 * len(call.text), 0.35), dpi=dpi, facecolor="white")
        canvas: Any = FigureCanvasAgg(figure)  # whose methods have no types
        figure.text(0.5, 0.5, call.text, ha="center", va="center", **look)
        canvas.draw()
        drawn = np.array(canvas.buffer_rgba())
        rows, columns = (np.flatnonzero((drawn[..., :3] < 255).any(axis=(2, axis))) for axis in (1, 0))
        inked = [
            slice(max(int(at[0]) - 2, 0), int(at[-1]) + 3) if len(at) else slice(0, 0)
            for at in (rows, columns)
        ]
        self.pixels = drawn[inked[0], inked[1]]
        self.scale = dpi / 72.0

    def draw(self, call: DrawCall) -> None:
        """Copy the pixels to the position of a call, as far as it is on the canvas."""
        picture = np.asarray(self.canvas.buffer_rgba())  # type: ignore[attr-defined]  # of Agg
        x, y = self.ax.transData.transform(call.at[0]) + (
            self.scale * call.at[1] if len(call.at) > 1 else 0.0
        )
        (height, width), (tall, wide) = picture.shape[:2], self.pixels.shape[:2]
        top, left = round(height - y - 0.5 * tall), round(x - 0.5 * wide)
        rows = slice(max(top, 0), min(top + tall, height))
        columns = slice(max(left, 0), min(left + wide, width))
        if rows.start < rows.stop and columns.start < columns.stop:
            picture[rows, columns] = self.pixels[
                rows.start - top : rows.stop - top, columns.start - left : columns.stop - left
            ]


class Playback:
    """Draws the recorded calls of many frames; artists that stand still below all moving ones are drawn once,
    with the background.

    matplotlib takes some 100 ms to draw a figure and 5 ms to draw the moving artists alone, so a frame
    restores the pixels of the background and draws only these over it.
    """

    def __init__(self, ax: Axes, frames: list[list[DrawCall]]) -> None:
        self.ax, self.frames = ax, frames
        first = frames[0]
        alike = all(same_artists(frame, first) for frame in frames)
        fixed = {
            k
            for k, call in enumerate(first)
            if alike and all(np.array_equal(frame[k].at, call.at, equal_nan=True) for frame in frames)
        }
        lowest = min([call.rank for k, call in enumerate(first) if k not in fixed], default=np.inf)
        # Texts, though not below the moving artists, are slow to draw.
        self.background = {
            k for k in fixed if first[k].rank < lowest or first[k].method in ("text", "annotate")
        }
        for k in sorted(self.background):
            draw_on(ax, first[k])
        self.artists: list[Artist | TextSprite] = []
        self.shown: list[DrawCall] = []
        self.sprites: dict[str, TextSprite] = {}

    def draw(self, frame: int) -> None:
        """Draw the moving artists of a frame over the canvas."""
        calls = sorted(
            (call for k, call in enumerate(self.frames[frame]) if k not in self.background),
            key=lambda call: call.rank,
        )
        if not same_artists(calls, self.shown):
            for artist in self.artists:
                if not isinstance(artist, TextSprite):
                    artist.remove()
            self.artists = [self._sprite(call) if call.text else draw_on(self.ax, call) for call in calls]
        for artist, call in zip(self.artists, calls, strict=True):
            if isinstance(artist, TextSprite):
                artist.draw(call)
            else:
                move(artist, call)
                self.ax.draw_artist(artist)
        self.shown = calls

    def _sprite(self, call: DrawCall) -> TextSprite:
        if call.text not in self.sprites:
            self.sprites[call.text] = TextSprite(self.ax, call)
        return self.sprites[call.text]


@dataclass
class FilmSheet(Sheet):
    """A sheet that is drawn once a frame: paths are computed once."""

    paths: dict[tuple[str, str], Array] = field(default_factory=dict)

    def path(self, body: str, pin: str) -> Array:
        """Return the path of a pin in the units drawn, shape (moments, 2)."""
        if (body, pin) not in self.paths:
            self.paths[body, pin] = self.factor * pin_path(self.result.record, body, pin)
        return self.paths[body, pin]


@dataclass(frozen=True)
class ForcePanel:
    """Axes with a growing curve, and its values in the unit drawn."""

    ax: Axes
    span: Span
    y: Array


class Film:
    """The frames of a run. ``frames`` are drawn one after another by :meth:`pictures`; ``size`` is that of
    each, in pixels.
    """

    def __init__(
        self, result: RunData, reference: RunData | None, frames: int, turns: float, dpi: float
    ) -> None:
        self.result, self.reference = result, reference
        self.first = first_output(result, turns)
        self.at = frame_positions(len(result.record.steps), self.first, frames)
        self.view = interpolate(result, self.at)
        self.frames = len(self.at)
        with matplotlib.rc_context(STYLE):
            self.figure = Figure(figsize=SIZE, dpi=dpi)
            self.canvas: Any = FigureCanvasAgg(self.figure)  # whose methods have no types
            self._draw_background()
        self.size = self.canvas.get_width_height()

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """Yield the frames, each as pixels of red, green, blue and opacity, shape (height, width, 4); one is
        overwritten by the next.
        """
        with matplotlib.rc_context(STYLE):
            self.canvas.draw()
            grown = self.canvas.copy_from_bbox(self.figure.bbox)
            line: dict[str, Any] = {"lw": 1.3, "zorder": 4}
            head: dict[str, Any] = {"ls": "", "marker": "o", "ms": 5, "mec": "white", "zorder": 5}
            lines, heads = (
                [curve.ax.plot([], [], color=BLUE, animated=True, **look)[0] for curve in self.curves]
                for look in (line, head)
            )
            for k in range(self.frames):
                self.canvas.restore_region(grown)
                # A line draws only what it has grown by since the last frame, because its pixels stay.
                self._draw_curves(lines, k, slice(*self._frame_outputs(k)))
                grown = self.canvas.copy_from_bbox(self.figure.bbox) if lines else grown
                self._draw_curves(heads, k, slice(0))
                self.playback.draw(k)
                self.clock.set_text(self._clock_text(k))
                self.figure.draw_artist(self.clock)
                yield np.asarray(self.canvas.buffer_rgba())

    def _draw_curves(self, lines: Sequence[Any], k: int, outputs: slice) -> None:
        """Draw the line of each panel through some outputs of its curve and the position of a frame."""
        for line, curve in zip(lines, self.curves, strict=True):
            x, y = (np.append(values[outputs], self._head(values, k)) for values in (curve.span.x, curve.y))
            line.set_data(*replace(curve.span, x=x).placed(y))
            curve.ax.draw_artist(line)

    def _frame_outputs(self, k: int) -> tuple[int, int]:
        """Return the outputs from the one before the last frame up to this frame, counted from the first of
        the film.
        """
        return int(self.at[max(k - 1, 0)]) - self.first, int(self.at[k]) - self.first + 1

    def _head(self, values: Array, k: int) -> float:
        return float(np.interp(self.at[k] - self.first, np.arange(len(values)), values))

    def _clock_text(self, k: int) -> str:
        time = self._head(self.result.time[self.first :], k)
        if self.result.record.static:
            return f"load factor {time:.4g}"
        rotation = self.result.crank_rotation
        if rotation is None:
            return f"{1e3 * time:.2f} ms"
        degrees = round(float(within_turn(self._head(rotation[self.first :], k)))) % 360
        return f"{self.result.crank} {degrees}°, {1e3 * time:.2f} ms"

    # ------------------------------------------------------------------------------------- what does not move

    def _draw_background(self) -> None:
        forces = largest_forces(self.result, MOST_PANELS)
        left, right = (0.075, 0.56) if forces else (0.09, 0.97)
        ax = self.figure.add_axes((left, 0.11, right - left, 0.76))
        mechanism = self.result.record.assembly.mechanism
        outlines = {name: outline_of(self.view, name) for name in self.view.record.assembly.bodies}
        low, high = extent(self.view, outlines)
        ax.set_aspect("equal")
        sheet = FilmSheet.for_area(ax, self.view, 0, low, high)
        largest = max((joint.clearance for joint in mechanism.clearances.values()), default=0.0)
        factor = CIRCLE_RADIUS * sheet.size / sheet.factor / largest if largest > 0.0 else 1.0
        self.enlarged = float(f"{factor:.2g}") if factor > LEAST_ENLARGED else 1.0
        self.farther = NAME_OFFSET if self.enlarged > 1.0 else 0.0
        ax.apply_aspect()
        scale = 72.0 * SIZE[0] * ax.get_position().width / np.ptp(ax.get_xlim())
        self.sides = name_sides(sheet, list(outlines.values()), self.frames, float(scale), self.farther)
        self.playback = Playback(ax, [self._recorded(sheet, outlines, k) for k in range(self.frames)])
        self.curves = [
            self._panel(name, quantity, k, len(forces)) for k, (name, quantity) in enumerate(forces.items())
        ]
        ax.apply_aspect()
        corner = ax.get_position()
        self.clock = self.figure.text(corner.x0, corner.y1 + 0.015, "", va="bottom", animated=True, color=INK)
        scale = f"; clearance drawn {self.enlarged:.4g} times as large" if self.enlarged > 1.0 else ""
        heading(self.figure, f"{mechanism.name}{scale}")

    def _recorded(self, sheet: Sheet, outlines: dict[str, Outline], k: int) -> list[DrawCall]:
        """Return the calls that draw the mechanism of a frame."""
        recorder: Any = CallRecorder()
        sheet.ax, sheet.shown = recorder, k
        draw_symbols(sheet, outlines)
        joint_names(sheet, self.sides, self.farther)
        self._clearance_circles(sheet, k)
        return list(recorder.calls)

    def _clearance_circles(self, sheet: Sheet, k: int) -> None:
        """Enlarged clearance circles, in each the journal's centre and its path of the last frames."""
        for joint in sheet.mechanism.clearances.values() if self.enlarged > 1.0 else ():
            at = sheet.at(joint.bearing)
            away = sheet.path(*joint.sides[1]) - sheet.path(*joint.sides[0])
            circle = at + self.enlarged * sheet.factor * joint.clearance * CIRCLE
            sheet.ax.fill(*circle.T, facecolor="white", edgecolor=INK, lw=1.2, zorder=9.1)
            trail = at + self.enlarged * away[max(k - TRAIL, 0) : k + 1]
            sheet.line(trail, color=ORANGE, lw=1.2, zorder=9.2)
            sheet.ax.plot(*trail[-1], ls="", marker="o", ms=5, color=VERMILION, mec=INK, mew=0.8, zorder=9.3)

    def _panel(self, name: str, quantity: Quantity, k: int, count: int) -> ForcePanel:
        """Return the axes for the force of a joint: the whole curve faint, the ideal one, and room for the
        one that runs.
        """
        height = 0.76 / count
        ax = self.figure.add_axes((0.665, 0.11 + (count - 1 - k) * height + 0.02, 0.315, height - 0.075))
        span = span_of(self.result, self.first, len(self.result.record.steps) - 1)
        force = quantity.recorded(self.result.record)[self.first :]
        ideal = ideal_curve(self.reference, quantity.recorded, span)
        largest_force = max(float(force.max()), 0.0 if ideal is None else np.nanmax(ideal[1]))
        factor, unit = scale_of(largest_force, "N")
        ax.plot(*span.placed(factor * force), color=BLUE, lw=0.8, alpha=0.25, zorder=2)
        if ideal is not None:
            ax.plot(ideal[0], factor * ideal[1], color=VERMILION, lw=1.2, zorder=3, label="ideal joints")
            if k == 0:
                ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), borderpad=0.0, fontsize=9)
        ax.set_title(f"joint {name}", fontsize=10)
        ax.set(ylabel=f"force ({unit})", ylim=(0.0, 1.06 * factor * largest_force or 1.0))
        span.set_limits(ax)
        if k == count - 1:
            ax.set_xlabel(span.title)
        else:
            ax.tick_params(labelbottom=False)
        ax.set_autoscale_on(False)
        return ForcePanel(ax, span, factor * force)


def first_output(result: RunData, turns: float) -> int:
    """Return the output at which the last ``turns`` turns of the crank begin; 0 without a crank, and where
    the run is shorter.
    """
    record = result.record
    turn, step = record.assembly.choice.turn, record.assembly.choice.step
    if turn is None or record.static:
        return 0
    begin = float(record.steps[-1]) - turns * turn / step
    return int(np.argmax(record.steps > begin - 0.5))


def frame_positions(outputs: int, first: int, frames: int) -> Array:
    """Return the position of each frame among the outputs, shape (frames,), such as 7.25; never more frames
    than outputs.
    """
    return np.linspace(first, outputs - 1, min(frames, outputs - first))


def interpolate(result: RunData, at: Array) -> RunData:
    """Return the run interpolated linearly at positions among its outputs, shape (frames, rows)."""
    record = result.record
    low = np.minimum(at.astype(int), max(len(record.steps) - 2, 0))
    share = (at - low)[:, None]
    high = np.minimum(low + 1, len(record.steps) - 1)
    rows = record.rows[low] * (1.0 - share) + record.rows[high] * share
    steps = record.steps[np.rint(at).astype(int)]
    return RunData(Record(record.assembly, steps, rows, record.row_numbers, status=record.status))
