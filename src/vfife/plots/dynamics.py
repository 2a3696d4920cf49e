"""Bifurcation diagrams, basins of attraction and Poincaré sections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from ..measures.chaos import STEP_UNKNOWN, kind_words, signed_range
from ..measures.motion import within_turn
from ..measures.trend import EQUAL
from .style import (
    BLUE,
    BODIES,
    FAINT,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SKY,
    STYLE,
    VERMILION,
    heading,
    legend_entries,
    panels,
    readable,
)
from .turn import CRANK_ANGLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..dynamics.basins import Basins
    from ..dynamics.bifurcation import Bifurcation
    from ..dynamics.sections import PoincareSection

MARKERS = (("o", 1.6), ("x", 2.6), ("^", 2.6), ("s", 1.6), ("+", 4.0), ("v", 2.6))  # with the area of each
NAMES = {"up": "way up", "down": "way down"}
# Least range of an axis, as a share of the largest value on it. Points of a periodic motion are equal within
# a tenth of this, and differ by rounding: without a least range their ticks would have ten digits.
LEAST_RANGE = 10.0 * EQUAL
MOST_TICKS = 6  # of an axis whose labels may have six digits


@rc_context(STYLE)
def diagram(result: Bifurcation) -> Figure:
    """Return a figure of points of each series, each direction or start with its own marker, and below them
    the largest Lyapunov exponent, positive for chaos.

    Rings mark values whose companions with other steps are classified otherwise.
    """
    rows = len(result.points) + 1
    figure, axes = panels(rows, 1, 9.0, 2.7, sharex=True)
    values = np.array(result.spec.values)
    scale, unit_x = result.shown if result.unit else readable(values, result.spec.unit)
    x = scale * values
    units = dict(zip(result.spec.series, result.spec.units, strict=False))
    for ax, (name, points) in zip(axes, result.points.items(), strict=False):
        factor, unit = readable(points, units.get(name, "SI"))
        for k, (way, chain) in enumerate(zip(result.spec.ways, points, strict=True)):
            marker, area = MARKERS[k % len(MARKERS)]
            width, colour = 0.5 if marker in "x+" else 0.0, BODIES[k % len(BODIES)]
            across = np.repeat(x, chain.shape[1])
            look: Any = {"s": area, "c": colour, "marker": marker, "lw": width, "label": NAMES.get(way, way)}
            ax.scatter(across, factor * chain.ravel(), rasterized=True, **look)
        number_axis(ax, "y", factor * points)
        ax.set_ylabel(f"{name}\n({unit}), once a turn")
        ax.margins(x=0.01)
    _exponents(axes[-1], result, x)
    axes[-1].set_xlabel(f"{result.spec.path} ({unit_x})")
    if entries := legend_entries([axes[0], axes[-1]] if len(result.spec.ways) > 1 else axes[-1:]):
        figure.legend([*entries.values()], [*entries], loc="outside lower center", markerscale=2.0, ncols=3)
    turns = result.spec.turns - result.spec.dropped
    title = f"{turns} turns at each value after {result.spec.dropped}"
    heading(figure, _title(result, title, result.agreement), result.progress)
    return figure


def number_axis(ax: Axes, axis: Literal["x", "y"], values: Any) -> None:
    """Label the ``axis`` ("x" or "y") of ``values`` with whole numbers instead of differences from an offset,
    over :data:`LEAST_RANGE` of their size at least.
    """
    values = np.asarray(values)[np.isfinite(values)]
    if len(values):
        low, high = float(values.min()), float(values.max())
        middle, half = 0.5 * (low + high), 0.5 * LEAST_RANGE * max(abs(low), abs(high))
        if high - low < 2.0 * half:
            (ax.set_xlim if axis == "x" else ax.set_ylim)(middle - half, middle + half)
    (ax.xaxis if axis == "x" else ax.yaxis).set_major_locator(MaxNLocator(MOST_TICKS, steps=[1, 2, 5, 10]))
    ax.ticklabel_format(axis=axis, useOffset=False)


def _exponents(last: Axes, result: Bifurcation, x: Any) -> None:
    """Draw the largest exponent of each chain with the means of its halves, and rings where companions are
    classified otherwise.
    """
    # One that is below any number has no place.
    exponents = np.where(np.isfinite(result.exponents), result.exponents, np.nan)
    for k, chain in enumerate(exponents):
        color = BODIES[k % len(BODIES)]
        last.fill_between(x, chain[:, 1], chain[:, 2], color=color, alpha=0.25, lw=0.0)
        last.plot(x, chain[:, 0], color=color, lw=1.0, marker=MARKERS[k % len(MARKERS)][0], ms=2.0)
    rings = [
        (x[companion.number], np.nan_to_num(exponents[companion.way, companion.number, 0]))
        for companion in result.companions
        if result.kind_of(companion) and not result.agrees(companion)
    ]
    if rings:
        look: Any = {"s": 70.0, "facecolors": "none", "edgecolors": VERMILION, "lw": 1.2, "zorder": 4.0}
        last.scatter(*np.array(rings).T, label="another motion with other steps", **look)
    last.axhline(0.0, color=GREY, lw=0.8)
    last.set_ylabel("largest exponent,\nits halves (1/turn)")


PERIODIC = (BLUE, ORANGE, GREEN, SKY, PURPLE, "#F0E442", "#5B4B3A")
KIND_COLOURS = {
    "chaotic": VERMILION,
    "quasi-periodic": "#44AA99",
    "not settled": GREY,
    "not decided": "#DDAA33",
    "diverged": INK,
}


FURTHER_COLOUR = "#DDDDDD"  # of periodic motions beyond the number of colours that can be told apart


def colours(result: Basins) -> list[str]:
    """Return a colour for each attractor: one of its own for each of the most frequent, and
    :data:`FURTHER_COLOUR` for periodic motions after these.
    """
    left = iter(PERIODIC)
    return [KIND_COLOURS.get(attractor.kind) or next(left, FURTHER_COLOUR) for attractor in result.attractors]


def shares(result: Basins, colour: list[str]) -> list[Patch]:
    """Return the entries of the legend: number, kind and share of each attractor with a colour of its own,
    and the share of all others together. Numbers are those of the table.
    """
    total = max(len(result.verdicts), 1)
    groups = [
        (shade, f"{k}. {kind_words(attractor.kind, result.spec.turns)}", len(attractor.members))
        for k, (shade, attractor) in enumerate(zip(colour, result.attractors, strict=True), 1)
        if shade != FURTHER_COLOUR
    ]
    rest = [
        len(attractor.members)
        for shade, attractor in zip(colour, result.attractors, strict=True)
        if shade == FURTHER_COLOUR
    ]
    if rest:
        groups.append((FURTHER_COLOUR, f"{len(rest)} other periodic motions", sum(rest)))
    return [
        Patch(fc=shade, ec=FAINT, label=f"{words}: {100.0 * count / total:.3g} %")
        for shade, words, count in groups
    ]


@rc_context(STYLE)
def basins(result: Basins) -> Figure:
    """Return a figure of the attractor of each start, and shares of all starts; white: impossible starts,
    crosses: companions that are classified otherwise.
    """
    spec = result.spec
    figure, (ax,) = panels(1, 1, 8.0, 7.0)
    (x, unit_x), (y, unit_y) = (_scaled(*pair) for pair in zip((spec.x, spec.y), spec.units, strict=True))
    colour = colours(result)
    if colour:
        mesh = np.ma.masked_invalid(result.labels)
        norm = BoundaryNorm(np.arange(len(colour) + 1) - 0.5, len(colour)) if len(colour) > 1 else None
        ax.pcolormesh(x, y, mesh, cmap=ListedColormap(colour), norm=norm, shading="nearest", rasterized=True)
    crosses = []
    differ = [
        companion.number
        for companion in result.companions
        if companion.number in result.verdicts and not result.agrees(companion)
    ]
    if differ:
        rows, columns = np.divmod(differ, len(x))
        crosses.append(
            ax.scatter(x[columns], y[rows], marker="x", c=INK, s=50.0, label="another with another step")
        )
    ax.set_xlabel(f"{spec.paths[0]} ({unit_x})")
    ax.set_ylabel(f"{spec.paths[1]} ({unit_y})")
    ax.grid(visible=False)
    ax.set_facecolor("white")
    figure.legend(handles=[*shares(result, colour), *crosses], loc="outside lower center", ncols=3)
    starts = f"{len(result.verdicts):,} starts, {spec.turns - spec.dropped} turns after {spec.dropped}"
    heading(figure, _title(result, starts, result.agreement), result.progress)
    return figure


def _scaled(values: Any, unit: str) -> tuple[Any, str]:
    """Return the values in a unit that reads well, angles in degrees, and the unit."""
    numbers, unit = (np.degrees(values), "°") if unit == "rad" else (np.array(values), unit)
    factor, unit = readable(numbers, unit)
    return factor * numbers, unit


def _title(result: Any, turns: str, companions: str) -> str:
    misfit = getattr(result, "misfit", None)
    start = f"; not as given: {misfit.fact}" if misfit else ""
    return f"{result.name}: {turns}, {result.spec.steps:,} steps a turn; {result.laws}; {companions}{start}"


MARK = 9.0  # area of a point
BOX = {"boxstyle": "square,pad=0.2", "fc": "white", "ec": "none"}


@rc_context(STYLE)
def section(result: PoincareSection) -> Figure:
    """Return a figure of points once a turn, the running mean of the exponent, and below them the contacts of
    each joint.
    """
    rows = 1 + len(result.struck)
    figure, axes = panels(2 * rows, 2, 4.7, 3.6)
    points(axes[0], result)
    convergence(axes[1], result)
    for k, name in enumerate(result.struck, 1):
        onsets(axes[2 * k], axes[2 * k + 1], result, name)
    turns = f"{result.verdict.words}; {result.done:,} turns after {result.spec.dropped:,}"
    repeated = result.exponent is not None and result.exponent.estimated
    steps = "range of the exponent with half the step" if repeated else "one step size"
    heading(figure, _title(result, turns, steps), result.progress)
    return figure


def points(ax: Axes, result: PoincareSection) -> None:
    """Draw the section at a phase of the crank: the second series over the first, or a single one over itself
    a turn before.
    """
    units = dict(zip(result.spec.series, result.spec.units, strict=True))
    names = list(result.points)[:2]
    x, y = result.points[names[0]], result.points[names[-1]]
    label = names[-1]
    if len(names) == 1:
        x, y, label = x[:-1], y[1:], f"{label} a turn later"
    (scale_x, unit_x), (scale_y, unit_y) = readable(x, units[names[0]]), readable(y, units[names[-1]])
    ax.scatter(scale_x * x, scale_y * y, s=MARK, c=BLUE, lw=0.0)
    number_axis(ax, "x", scale_x * x)
    number_axis(ax, "y", scale_y * y)
    ax.set_xlabel(f"{names[0]} ({unit_x})")
    ax.set_ylabel(f"{label} ({unit_y})")
    ax.set_title(f"once a turn, {360.0 * result.spec.phase:g}° of the crank after its start")


def convergence(ax: Axes, result: PoincareSection) -> None:
    """Draw the mean growth of a small difference up to each turn, and the range of its limit, or the means of
    both halves where that is not estimated.
    """
    exponent = result.exponent
    ax.axhline(0.0, color=GREY, lw=0.8)
    if exponent is not None:
        turns = result.spec.dropped + 1 + np.arange(len(exponent.running))
        ax.plot(turns, exponent.running, color=BLUE, lw=1.2)
        if exponent.estimated:
            ax.axhspan(exponent.low, exponent.high, color=VERMILION, alpha=0.2, lw=0.0)
            value = "not known" if exponent.unknown else f"{exponent.value:+.3g}"
            text = f"{value}; {signed_range(exponent.low, exponent.high)}"
        else:
            text = f"{exponent.value:+.3g}; halves {signed_range(*exponent.halves)}\n{STEP_UNKNOWN}"
        # The text stands where the curve is not.
        low = exponent.value > float(exponent.running.min()) * 0.5 + float(exponent.running.max()) * 0.5
        look: Any = {"ha": "right", "color": INK, "fontsize": 9.0, "bbox": BOX}
        ax.text(0.98, 0.1 if low else 0.9, text, transform=ax.transAxes, **look)
    ax.set_title("largest exponent, as it converges")
    ax.set_xlabel("turn")
    ax.xaxis.set_major_locator(MaxNLocator(MOST_TICKS, steps=[1, 2, 5, 10], integer=True))
    ax.set_ylabel("mean growth (1/turn)")


def onsets(left: Axes, right: Axes, result: PoincareSection, name: str) -> None:
    """Draw the onsets of contact of a joint over the crank angle: place on the bearing, coloured by speed,
    and the speed.
    """
    contacts = result.struck[name]
    crank = within_turn(np.degrees(contacts["crank"]))
    factor, unit = readable(contacts["speed"], "m/s")
    speed, place = factor * contacts["speed"], np.degrees(contacts["place"])
    round_bearing, label = bool(np.isfinite(place).any()), f"speed of approach ({unit})"
    for ax in (left, right):
        ax.set(xlim=(0.0, 360.0), xticks=np.arange(0.0, 361.0, 90.0), xlabel=CRANK_ANGLE)
        if ax is right or not round_bearing:
            ax.scatter(crank, speed, s=MARK, c=BLUE, lw=0.0)
            ax.set_ylabel(label)
        if not len(crank):
            ax.set_yticks([])
            ax.text(
                0.5, 0.5, "no contact began", transform=ax.transAxes, ha="center", va="center", color=GREY
            )
    left.set_title(f"{name}: {len(crank):,} contact{'' if len(crank) == 1 else 's'} began")
    if round_bearing:
        drawn = left.scatter(crank, place, s=MARK, c=speed, cmap="viridis", lw=0.0)
        left.set(ylim=(0.0, 360.0), yticks=np.arange(0.0, 361.0, 90.0), ylabel="place round the bearing (°)")
        left.figure.colorbar(drawn, ax=left, label=label)
