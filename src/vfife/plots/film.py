"""A run as a film: the mechanism as it moves, its clearance drawn larger, and beside it the forces as they
come.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..measures.motion import pin_path
from ..results.view import View
from ..solvers.record import Record
from .curves import Quantity, joint_forces, loaded_joints
from .drawing import extent, signs
from .sheet import Sheet
from .signs import Outline, joint_names, outline
from .stage import Drawn, Notes, Stage
from .style import BLUE, BODIES, INK, ORANGE, STYLE, VERMILION, heading, length_unit, scale_of
from .turn import Span, abscissa, axis_title, one_turn

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
SIZE = (10.0, 5.625)  # inches
MOST_PANELS = 3
PLAY = 0.028  # radius of the largest clearance circle, as a share of the drawing
BESIDE = 7.0  # points by which a name stands farther away where circles are drawn larger
SEEN = 2.0  # times as large: play that would be drawn larger by less is seen as it is
TRAIL = 12  # frames that a journal's way is seen in its circle
CIRCLE = np.stack(
    [np.cos(np.linspace(0.0, 2.0 * np.pi, 49)), np.sin(np.linspace(0.0, 2.0 * np.pi, 49))], axis=1
)


@dataclass
class MovingSheet(Sheet):
    """A sheet on which the same mechanism is drawn again and again: paths are found once."""

    paths: dict[tuple[str, str], Array] = field(default_factory=dict)

    def path(self, body: str, pin: str) -> Array:
        """Path of a pin in the units drawn, shape (moments, 2)."""
        if (body, pin) not in self.paths:
            self.paths[body, pin] = self.factor * pin_path(self.result.record, body, pin)
        return self.paths[body, pin]


@dataclass(frozen=True)
class Running:
    """A curve that runs: its axes, and where its head is at each frame, in the units drawn."""

    ax: Axes
    x: Array
    y: Array


class Film:
    """The frames of a run. ``frames`` are drawn one after another by :meth:`pictures`; ``size`` is that of
    each, in pixels.
    """

    def __init__(self, result: View, reference: View | None, frames: int, turns: float, dpi: float) -> None:
        self.result, self.reference = result, reference
        self.first = first_output(result, turns)
        self.at = places_between(len(result.record.steps), self.first, frames)
        self.view = moments(result, self.at)
        self.frames = len(self.at)
        self.over, _ = one_turn(abscissa(result)[self.first :], result)
        with matplotlib.rc_context(STYLE):
            self.figure = Figure(figsize=SIZE, dpi=dpi)
            self.canvas: Any = FigureCanvasAgg(self.figure)  # whose methods have no types
            self._draw_still()
        self.size = self.canvas.get_width_height()

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """The frames, each as pixels of red, green, blue and opacity, shape (height, width, 4); one is
        overwritten by the next.
        """
        with matplotlib.rc_context(STYLE):
            self.canvas.draw()
            grown = self.canvas.copy_from_bbox(self.figure.bbox)
            lines = [
                curve.ax.plot([], [], color=BLUE, lw=1.3, animated=True, zorder=4)[0] for curve in self.curves
            ]
            heads = [
                curve.ax.plot(
                    [], [], ls="", marker="o", ms=5, color=BLUE, mec="white", animated=True, zorder=5
                )[0]
                for curve in self.curves
            ]
            for k in range(self.frames):
                self.canvas.restore_region(grown)
                for line, curve in zip(lines, self.curves, strict=True):
                    upto = slice(*self._between(k))
                    line.set_data(
                        np.append(curve.x[upto], self._head(curve.x, k)),
                        np.append(curve.y[upto], self._head(curve.y, k)),
                    )
                    curve.ax.draw_artist(line)
                grown = (
                    self.canvas.copy_from_bbox(self.figure.bbox) if lines else grown
                )  # what a curve has drawn stays
                for head, curve in zip(heads, self.curves, strict=True):
                    head.set_data([self._head(curve.x, k)], [self._head(curve.y, k)])
                    curve.ax.draw_artist(head)
                self.stage.draw(k)
                self.clock.set_text(self._moment(k))
                self.figure.draw_artist(self.clock)
                yield np.asarray(self.canvas.buffer_rgba())

    def _between(self, k: int) -> tuple[int, int]:
        """Outputs from before the frame before this one up to this one, from the first of the film."""
        return int(self.at[max(k - 1, 0)]) - self.first, int(self.at[k]) - self.first + 1

    def _head(self, values: Array, k: int) -> float:
        return float(np.interp(self.at[k] - self.first, np.arange(len(values)), values))

    def _moment(self, k: int) -> str:
        now = self._head(self.result.time[self.first :], k)
        if self.result.record.static:
            return f"load factor {now:.4g}"
        angle = "" if self.result.crank is None else f"{self.result.crank} {self._head(self.over, k):.0f}°, "
        return f"{angle}{1e3 * now:.2f} ms"

    # -------------------------------------------------------------------------------------------- what does
    # not move

    def _draw_still(self) -> None:
        names = loaded_joints(self.result, MOST_PANELS)
        left, right = (0.075, 0.56) if names else (0.09, 0.97)
        ax = self.figure.add_axes((left, 0.11, right - left, 0.76))
        mechanism = self.result.record.assembly.mechanism
        outlines = {name: outline(self.view, name) for name in self.view.record.assembly.bodies}
        low, high = extent(self.view, outlines)
        size = float(np.max(high - low)) or 1.0
        factor, unit = length_unit(size)
        colours, striped = (
            {name: BODIES[k % len(BODIES)] for k, name in enumerate(outlines)},
            frozenset(list(outlines)[len(BODIES) :]),
        )
        ax.set_aspect("equal")
        ax.set(
            xlim=factor * np.array([low[0], high[0]]),
            ylim=factor * np.array([low[1], high[1]]),
            xlabel=f"x ({unit})",
            ylabel=f"y ({unit})",
        )
        ax.set_autoscale_on(False)
        largest = max((joint.clearance for joint in mechanism.clearances.values()), default=0.0)
        larger = PLAY * size / largest if largest > 0.0 else 1.0
        self.larger = float(f"{larger:.2g}") if larger > SEEN else 1.0
        sheet = MovingSheet(ax, self.view, factor, factor * size, 0, colours, striped)
        self.stage = Stage(ax, [self._noted(sheet, outlines, k) for k in range(self.frames)])
        self.curves = [self._panel(name, k, len(names)) for k, name in enumerate(names)]
        ax.apply_aspect()
        corner = ax.get_position()
        self.clock = self.figure.text(corner.x0, corner.y1 + 0.015, "", va="bottom", animated=True, color=INK)
        played = f"; play drawn {self.larger:.4g} times as large" if self.larger > 1.0 else ""
        heading(self.figure, f"{mechanism.name}{played}")

    def _noted(self, sheet: MovingSheet, outlines: dict[str, Outline], k: int) -> list[Drawn]:
        """What there is to draw of the mechanism at a frame."""
        notes: Any = Notes()
        sheet.ax, sheet.shown = notes, k
        signs(sheet, outlines)
        every = np.concatenate([one.path.reshape(-1, 2) for one in outlines.values()])
        joint_names(sheet, sheet.factor * np.nanmean(every, axis=0), BESIDE if self.larger > 1.0 else 0.0)
        self._play(sheet, k)
        return list(notes.drawn)

    def _play(self, sheet: MovingSheet, k: int) -> None:
        """Clearance circles drawn larger, in each the journal's centre and where it was just before."""
        for joint in sheet.mechanism.clearances.values() if self.larger > 1.0 else ():
            at = sheet.at(joint.bearing)
            away = sheet.path(*joint.sides[1]) - sheet.path(*joint.sides[0])
            circle = at + self.larger * sheet.factor * joint.clearance * CIRCLE
            sheet.ax.fill(*circle.T, facecolor="white", edgecolor=INK, lw=1.2, zorder=9.1)
            trail = at + self.larger * away[max(k - TRAIL, 0) : k + 1]
            sheet.line(trail, color=ORANGE, lw=1.2, zorder=9.2)
            sheet.ax.plot(*trail[-1], ls="", marker="o", ms=5, color=VERMILION, mec=INK, mew=0.8, zorder=9.3)

    def _panel(self, name: str, k: int, count: int) -> Running:
        """Axes for the force of a joint: the whole curve faint, the ideal one, and room for the one that
        runs.
        """
        height = 0.76 / count
        ax = self.figure.add_axes((0.665, 0.11 + (count - 1 - k) * height + 0.02, 0.315, height - 0.075))
        found = force_from(self.result, self.reference, joint_forces(self.result)[name], self.first)
        most = max(float(found.force.max()), 0.0 if found.ideal is None else float(found.ideal[1].max()))
        factor, unit = scale_of(most, "N")
        ax.plot(found.x, factor * found.force, color=BLUE, lw=0.8, alpha=0.25, zorder=2)
        if found.ideal is not None:
            ax.plot(
                found.ideal[0],
                factor * found.ideal[1],
                color=VERMILION,
                lw=1.2,
                zorder=3,
                label="ideal joints",
            )
            if k == 0:
                ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), borderpad=0.0, fontsize=9)
        ax.set_title(f"joint {name}", fontsize=10)
        ax.set(ylabel=f"force ({unit})", ylim=(0.0, 1.06 * factor * most), xlim=_limits(found.x))
        if k == count - 1:
            ax.set_xlabel(axis_title(self.result))
        else:
            ax.tick_params(labelbottom=False)
        if (
            self.result.crank is not None
            and not self.result.record.static
            and 300.0 < abs(found.x[-1] - found.x[0]) <= 361.0
        ):
            ax.set_xticks(np.arange(60.0 * math.ceil(min(found.x) / 60.0 - 1e-6), max(found.x) + 1e-6, 60.0))
        ax.set_autoscale_on(False)
        return Running(ax, found.x, factor * found.force)


def _limits(x: Array) -> tuple[float, float]:
    low, high = float(min(x)), float(max(x))
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def first_output(result: View, turns: float) -> int:
    """The output at which the last ``turns`` turns of the crank begin; 0 without a crank, and where the run
    is shorter.
    """
    record = result.record
    turn, step = record.assembly.choice.turn, record.assembly.choice.step
    if turn is None or record.static:
        return 0
    begin = float(record.steps[-1]) - turns * turn / step
    return int(np.argmax(record.steps > begin - 0.5))


def places_between(outputs: int, first: int, frames: int) -> Array:
    """Where among the outputs each frame is, shape (frames,): output 7 and a quarter is 7.25. Never more
    frames than outputs.
    """
    return np.linspace(first, outputs - 1, min(frames, outputs - first))


def moments(result: View, at: Array) -> View:
    """The run as it is at places between its outputs: positions and angles on a straight line from one to the
    next, shape (places, rows).
    """
    record = result.record
    low = np.minimum(at.astype(int), max(len(record.steps) - 2, 0))
    share = (at - low)[:, None]
    high = np.minimum(low + 1, len(record.steps) - 1)
    rows = (
        record.rows[low] * (1.0 - share) + record.rows[high] * share
        if len(record.steps) > 1
        else record.rows[low]
    )
    steps = record.steps[np.rint(at).astype(int)]
    return View(Record(record.assembly, steps, rows, record.kept, status=record.status))


@dataclass(frozen=True)
class ForceCurve:
    """Largest force of a joint in each interval (N) over crank angle (degrees), time (ms) or load factor, and
    the ideal one's.
    """

    x: Array
    force: Array
    ideal: tuple[Array, Array] | None


def force_from(result: View, reference: View | None, one: Quantity, first: int) -> ForceCurve:
    """The force of a joint from an output on; the ideal one's last turn again for each turn of it."""
    x, origin = one_turn(abscissa(result)[first:], result)
    force = largest(result, one)[first:]
    if reference is None:
        return ForceCurve(x, force, None)
    at, values = Span(first, first + len(x) - 1, x, None, axis_title(result), origin).beside(
        reference, largest(reference, one)
    )
    if result.crank is not None and not result.record.static:
        turns = range(1 + int(abs(x[-1] - x[0]) / 360.0))
        at, values = np.concatenate([at + 360.0 * k for k in turns]), np.tile(values, len(turns))
    seen = (at >= min(x) - 1e-6) & (at <= max(x) + 1e-6)
    return ForceCurve(x, force, (at[seen], values[seen]) if seen.sum() > 1 else None)


def largest(result: View, one: Quantity) -> Array:
    """The largest force since the output before, or that of an equilibrium."""
    return (
        one.samples(result.record)
        if one.extremes is None or result.record.static
        else one.extremes(result.record)
    )
