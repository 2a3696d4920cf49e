"""Figures of a study by name: heat maps, curves with bands, parallel coordinates, Pareto fronts."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Collection, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from ..errors import VfifeError, shown, suggestion
from .notebook import sharp
from .style import (
    BLUE,
    BODIES,
    CENTRE,
    FAINT,
    GREY,
    INK,
    PICTURES,
    RPM,
    STYLE,
    VERMILION,
    Figures,
    heading,
    one_legend,
    panels,
    readable,
    saved,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.study import Study, Varied

Array = NDArray[np.float64]
MOST_TICKS = 7  # of a logarithmic axis


def broken(name: str, width: int = 15) -> str:
    """Return a long name in lines, broken at its dots and underscores."""
    lines = [""]
    for part in re.split(r"(?<=[._ ])", name):
        if lines[-1] and len(lines[-1]) + len(part) > width:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)


def titled(name: str, unit: str) -> str:
    """Return a name with its unit."""
    return f"{name} ({unit})" if unit else name


def positions(values: Sequence[Any], unit: str) -> tuple[Array, str]:
    """Return the positions of values of a parameter along an axis, and their unit; words one after
    another.
    """
    if any(isinstance(value, str) for value in values):
        return np.arange(len(values), dtype=float), ""
    factor, unit = (RPM, "rpm") if unit == "rad/s" else readable(values, unit)
    return factor * np.asarray(values, dtype=float), unit


def edges(middles: Array) -> Array:
    """Return the edges of cells around their middles; the outer ones as far away as the inner ones."""
    if len(middles) == 1:
        half = 0.5 * (abs(middles[0]) or 1.0)
        return np.array([middles[0] - half, middles[0] + half])
    inner = 0.5 * (middles[1:] + middles[:-1])
    return np.concatenate([[2.0 * middles[0] - inner[0]], inner, [2.0 * middles[-1] - inner[-1]]])


def logarithmic(middles: Array) -> bool:
    """Return whether values lie evenly on a logarithmic scale, and not on a plain one."""
    if len(middles) < 3 or middles.min() <= 0.0:
        return False
    ratios, steps = middles[1:] / middles[:-1], np.diff(middles)
    return bool(np.ptp(ratios) < 1e-3 * ratios.mean() and np.ptp(steps) > 1e-2 * steps.mean())


def label_axis(
    ax: Axes, one: Varied, values: Sequence[Any], middles: Array, unit: str, axis_name: str = "x"
) -> None:
    """Labels an axis of a parameter."""
    axis, label = (ax.xaxis, ax.set_xlabel) if axis_name == "x" else (ax.yaxis, ax.set_ylabel)
    label(titled(one.name, unit))
    if any(isinstance(value, str) for value in values):
        axis.set_ticks(list(middles), [str(value) for value in values])
    elif logarithmic(middles):
        (ax.set_xscale if axis_name == "x" else ax.set_yscale)("log")
        at = [middles[k] for k in evenly(len(middles), MOST_TICKS)]
        axis.set_ticks(at, [f"{value:.3g}" for value in at])
        axis.set_minor_locator(NullLocator())


def axes_of(study: Study) -> list[Varied]:
    """Return the parameters that may be axes, those with most values first, words last."""
    own = [one for one in study.parameters if one.name in study.axes]
    return sorted(
        own,
        key=lambda one: (
            any(isinstance(value, str) for value in study.axes[one.name]),
            -len(study.axes[one.name]),
        ),
    )


def dimension_words(study: Study, dims: list[str]) -> str:
    """Return the dimensions in words."""
    return ", ".join(f"{len(study.axes[name]):,} samples" if name == "sample" else name for name in dims)


def evenly(count: int, most: int) -> list[int]:
    """Return at most ``most`` of ``count`` indices, evenly."""
    return (
        sorted({round(k * (count - 1) / max(most - 1, 1)) for k in range(most)})
        if count > most
        else list(range(count))
    )


MOST_CURVES, MOST_PANELS = 6, 6
BAND = (0.05, 0.95)


def curves(study: Study, measures: list[str]) -> Figure | None:
    """Return a figure with a panel for each measure; None where no parameter has several values."""
    own = [one for one in axes_of(study) if len(study.axes[one.name]) > 1]
    shown = [name for name in measures if np.isfinite(study.laid_out(name)).any()][:MOST_PANELS]
    if not own or not shown:
        return None
    figure, boxes = panels(len(shown), 2 if len(shown) < 5 else 3, 4.8, 3.5)
    for ax, name in zip(boxes, shown, strict=True):
        curve_panel(ax, study, name, own)
    one_legend(figure, boxes)
    others = [name for name in study.axes if name not in {one.name for one in own[:2]}]
    band = (
        f" (medians; bands: {100.0 * BAND[0]:g} to {100.0 * BAND[1]:g} % over"
        f" {dimension_words(study, others)})"
    )
    count = len(study.axes[own[1].name]) if len(own) > 1 else 0
    part = f"; {MOST_CURVES} of {count} values of {own[1].name}" if count > MOST_CURVES else ""
    heading(figure, study.model + part + (band if others else ""))
    return figure


def curve_panel(ax: Axes, study: Study, name: str, own: list[Any]) -> None:
    """Draw the curves of a measure."""
    dims, along = list(study.axes), own[0]
    other = own[1] if len(own) > 1 else None
    keep = [dims.index(along.name)] + ([dims.index(other.name)] if other is not None else [])
    values = np.moveaxis(study.laid_out(name), keep, list(range(len(keep))))
    values = values.reshape(values.shape[0], values.shape[1] if other is not None else 1, -1)
    factor, unit = readable(values, study.measures[name])
    x, x_unit = positions(study.axes[along.name], along.unit)
    labels, label_unit = ([None], "") if other is None else value_labels(study.axes[other.name], other.unit)
    for colour, k in enumerate(evenly(values.shape[1], MOST_CURVES)):
        middle, low, high = (factor * one for one in quantiles(values[:, k, :]))
        label = None if other is None else f"{other.name} {labels[k]} {label_unit}".rstrip()
        look = BODIES[colour % len(BODIES)]
        ax.plot(x, middle, color=look, marker="o", ms=3.0 if len(x) < 30 else 0.0, label=label)
        if values.shape[2] > 1:
            ax.fill_between(x, low, high, color=look, alpha=0.18, lw=0.0)
    label_axis(ax, along, study.axes[along.name], x, x_unit)
    ax.set_title(titled(name, unit))


def value_labels(values: list[Any], unit: str) -> tuple[list[str], str]:
    """Return the values of a parameter for a legend, and their unit."""
    if any(isinstance(value, str) for value in values):
        return [str(value) for value in values], ""
    numbers, unit = positions(values, unit)
    return [f"{value:.4g}" for value in numbers], unit


def quantiles(values: Array) -> Array:
    """Return the median, lower and upper end of the band along the last axis, without unknown values; shape
    (3, places).
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an unknown value stays unknown
        low, middle, high = np.nanquantile(values, (BAND[0], 0.5, BAND[1]), axis=1)
    return np.stack([middle, low, high])


LEAST_VALUES = 3  # values of each of two parameters that make a map


def heat_maps(study: Study, measures: list[str]) -> Figure | None:
    """Return a figure with a map for each measure; None where no two parameters have a grid of values. Failed
    cases are grey.
    """
    axes = [one for one in axes_of(study) if len(study.axes[one.name]) >= LEAST_VALUES][:2]
    if len(axes) < 2:
        return None
    shown = [name for name in measures if np.isfinite(study.laid_out(name)).any()][:MOST_PANELS]
    if not shown:
        return None
    figure, boxes = panels(len(shown), 2 if len(shown) < 5 else 3, 4.8, 3.7)
    for ax, name in zip(boxes, shown, strict=True):
        map_panel(figure, ax, study, name, axes)
    others = [name for name in study.axes if name not in {one.name for one in axes}]
    heading(figure, study.model + (f" (median over {dimension_words(study, others)})" if others else ""))
    return figure


def map_panel(figure: Figure, ax: Axes, study: Study, name: str, axes: list[Any]) -> None:
    """Draw a map."""
    across, up = axes
    dims = list(study.axes)
    values = median(study.laid_out(name), [dims.index(up.name), dims.index(across.name)])
    (x, x_unit), (y, y_unit) = (positions(study.axes[one.name], one.unit) for one in axes)
    factor, unit = readable(values, study.measures[name])
    ax.set_facecolor(FAINT)
    drawn = ax.pcolormesh(
        edges(x), edges(y), np.ma.masked_invalid(factor * values), cmap="viridis", rasterized=True
    )
    label_axis(ax, across, study.axes[across.name], x, x_unit)
    label_axis(ax, up, study.axes[up.name], y, y_unit, "y")
    ax.grid(visible=False)
    ax.set_title(titled(name, unit))
    bar = figure.colorbar(drawn, ax=ax)
    bar.outline.set_visible(False)


def median(values: Array, keep: list[int]) -> Array:
    """Return the median over all axes but two, which are kept in this order."""
    rest = tuple(k for k in range(values.ndim) if k not in keep)
    moved = np.moveaxis(values, keep, [0, 1])
    if not rest:
        return moved
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an unknown value stays unknown
        middle: Array = np.nanmedian(moved.reshape(*moved.shape[:2], -1), axis=2)
    return middle


END: dict[str, Any] = CENTRE | {
    "fontsize": 8.5,
    "color": INK,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 1.0},
}
MOST_LINES, MOST_AXES = 2000, 12


def parallel(study: Study, measures: list[str]) -> Figure | None:
    """Return a figure of parallel coordinates: a line for each case, coloured by the first measure; None with
    fewer than three cases.
    """
    columns, names = numbers(study, measures)
    complete = np.isfinite(columns).all(axis=1)
    if complete.sum() < 3 or len(names) < 2:
        return None
    columns = columns[complete][evenly(int(complete.sum()), MOST_LINES)]
    low, high = columns.min(axis=0), columns.max(axis=0)
    scaled = np.where(high > low, (columns - low) / np.where(high > low, high - low, 1.0), 0.5)
    figure, (ax,) = panels(1, 1, max(5.5, 1.45 * len(names)), 4.2)
    key = columns[:, len(study.parameters)] if len(names) > len(study.parameters) else columns[:, 0]
    order = np.argsort(key, kind="stable")  # the largest on top
    least, most = float(key.min()), float(key.max()) if key.max() > key.min() else float(key.min()) + 1.0
    segments = [np.column_stack([np.arange(len(names)), row]) for row in scaled[order]]
    ax.add_collection(
        LineCollection(
            segments,
            array=key[order],
            cmap="viridis",
            norm=Normalize(least, most),
            lw=0.9,
            alpha=min(1.0, max(0.15, 60.0 / len(order))),
        )
    )
    parallel_axes(ax, study, names, low, high)
    colour = names[min(len(study.parameters), len(names) - 1)]
    factor, unit = readable(key, unit_of(study, colour))
    bar = figure.colorbar(
        ScalarMappable(Normalize(factor * least, factor * most), "viridis"), ax=ax, pad=0.02
    )
    bar.outline.set_visible(False)
    bar.set_label(titled(colour, unit))
    heading(figure, f"{study.model}: {len(order):,} cases")
    return figure


def unit_of(study: Study, name: str) -> str:
    """Return the unit of a parameter or a measure."""
    return study.measures[name] if name in study.measures else study.parameter(name).unit


def numbers(study: Study, measures: list[str]) -> tuple[Array, list[str]]:
    """Return the parameters and measures of the finished cases, shape (cases, axes), and their names."""
    chosen = measures[: max(1, MOST_AXES - len(study.parameters))]
    columns = [study.points(), *(study.values(name)[:, None] for name in chosen)]
    return np.concatenate(columns, axis=1), [*(one.name for one in study.parameters), *chosen]


def parallel_axes(ax: Axes, study: Study, names: list[str], low: Array, high: Array) -> None:
    """Draw the parallel axes with their limits, and words at their positions."""
    ax.set(xlim=(-0.35, len(names) - 0.65), ylim=(-0.09, 1.09))
    ax.set_yticks([])
    ax.grid(visible=False)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)
    heads = []
    for k, name in enumerate(names):
        ax.axvline(k, color=GREY, lw=0.8, zorder=0)
        words = (
            sorted({value for one in study.done if isinstance(value := study.at(one)[k], str)})
            if k < len(study.parameters)
            else []
        )
        factor, unit = readable([low[k], high[k]], unit_of(study, name))
        heads.append(broken(name) + (f"\n({unit})" if unit else ""))
        ends = ("", "") if words else (f"{factor * low[k]:.4g}", f"{factor * high[k]:.4g}")
        ax.text(k, -0.04, ends[0], **END)
        ax.text(k, 1.04, ends[1], **END)
        for n, word in enumerate(dict.fromkeys(study.at(one)[k] for one in study.done) if words else ()):
            ax.text(
                k + 0.04,
                n / max(len(words) - 1, 1),
                str(word),
                ha="left",
                va="center",
                fontsize=8.5,
                color=INK,
            )
    ax.set_xticks(range(len(names)), heads, fontsize=9.0)
    ax.tick_params(axis="x", length=0.0, pad=8.0)


MOST_PAIRS = 3  # pairs of measures


def fronts(study: Study, measures: list[str], larger: Collection[str] = ()) -> Figure | None:
    """Return a figure of the first measure over each of the next; all are minimised, except those in
    ``larger``. None with fewer than two.
    """
    pairs = [(measures[0], other) for other in measures[1 : MOST_PAIRS + 1]]
    shown = [pair for pair in pairs if np.isfinite(study.values(pair[0]) + study.values(pair[1])).sum() > 1]
    if not shown:
        return None
    figure, axes = panels(len(shown), len(shown), 4.8, 4.2)
    for ax, pair in zip(axes, shown, strict=True):
        both = np.stack([study.values(name) for name in pair], axis=1)
        both = both[np.isfinite(both).all(axis=1)]
        scales = [readable(both[:, k], study.measures[pair[k]]) for k in (0, 1)]
        x, y = (both[:, k] * scales[k][0] for k in (0, 1))
        signs = np.array([-1.0 if name in larger else 1.0 for name in pair])
        best = front(both * signs)
        ax.scatter(x[~best], y[~best], s=14.0, color=BLUE, alpha=0.35, lw=0.0, label="cases")
        order = np.flatnonzero(best)[np.argsort(signs[0] * x[best], kind="stable")]
        ax.step(x[order], y[order], where="post", color=GREY, lw=0.9, zorder=1)
        ax.scatter(
            x[order],
            y[order],
            s=22.0,
            color=VERMILION,
            edgecolor=FAINT,
            lw=0.4,
            zorder=3,
            label="front: none is better in both",
        )
        names = [
            titled(name, scale[1]) + (", large" if name in larger else "")
            for name, scale in zip(pair, scales, strict=True)
        ]
        ax.set(xlabel=names[0], ylabel=names[1])
    one_legend(figure, axes)
    heading(figure, study.model)
    return figure


def front(values: Array) -> NDArray[np.bool_]:
    """Return the Pareto front of points, shape (points, measures): those that no other point equals or beats
    in all measures and beats in one.
    """
    # In lexicographic order a point can only be dominated by an earlier one, so each is compared with the
    # front found so far.
    order = np.lexsort(values.T[::-1])
    best = np.zeros(len(values), dtype=bool)
    beaten_by = np.empty((0, values.shape[1]))
    for k in order:
        if not ((beaten_by <= values[k]).all(axis=1) & (beaten_by < values[k]).any(axis=1)).any():
            best[k] = True
            beaten_by = np.vstack([beaten_by, values[k]])
    return best


FIGURES: dict[str, Callable[[Study, list[str]], Figure | None]] = {
    "maps": heat_maps,
    "curves": curves,
    "parallel": parallel,
    "fronts": fronts,
}
TITLES = {
    "maps": "Measures over two parameters", "curves": "Measures over a parameter",
    "parallel": "Cases, a line each",
    "fronts": "Measures against each other",
}  # fmt: skip


@rc_context(STYLE)
def figures(
    study: Study, names: Collection[str] = (), measures: Collection[str] = (), larger: Collection[str] = ()
) -> dict[str, Figure]:
    """Return figures by name: ``maps``, ``curves``, ``parallel``, ``fronts``; all that have data, or those of
    ``names``.

    ``measures``: those drawn, in this order, by default all; ``larger``: measures that are better when
    larger, for Pareto fronts. Raises VfifeError for an unknown name.
    """
    for name in names:
        if name not in FIGURES:
            raise VfifeError(
                f"there is no figure {shown(name)}: {suggestion(name, FIGURES, 'name one that there is')}"
            )
    for name in (*measures, *larger):
        study.values(name)
    draws: dict[str, Callable[[Study, list[str]], Figure | None]] = {
        **FIGURES,
        "fronts": partial(fronts, larger=larger),
    }
    chosen = list(measures) or list(study.measures)
    drawn = {name: draw(study, chosen) for name, draw in draws.items() if not names or name in names}
    return Figures({name: figure for name, figure in drawn.items() if figure is not None})


def pictures(study: Study) -> dict[str, str]:
    """Return all figures of a study as HTML elements by title."""
    return {TITLES[name]: sharp(figure, TITLES[name]) for name, figure in figures(study).items()}


def save_figures(
    study: Study,
    folder: Path,
    names: Collection[str] = (),
    measures: Collection[str] = (),
    ending: str = ".png",
    larger: Collection[str] = (),
) -> list[Path]:
    """Write figures into a folder and return the files. Raises VfifeError if there is nothing to draw yet."""
    if ending not in PICTURES:
        raise VfifeError(f"no figure is written as {shown(ending)}; there are {', '.join(PICTURES)}")
    drawn = figures(study, names, measures, larger)
    if not drawn:
        raise VfifeError(
            f"{study.path or 'this study'}: there is nothing to draw: {len(study.done):,} of"
            f" {len(study.cases):,} cases have ended"
        )
    return [saved(figure, folder / f"{name}{ending}") for name, figure in drawn.items()]
