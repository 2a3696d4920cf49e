"""Figures of a study by name: heat maps, curves with bands, parallel coordinates, Pareto fronts."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..errors import VfifeError, shown, suggestion
from ..measures.catalogue import NO_IMPACT
from ..measures.extrapolation import NEVER_NEGATIVE
from ..numerics.pareto import front
from ..results.parameters import Varied
from ..results.study import Study
from .notebook import sharp
from .study_axes import (
    EMPTY,
    axes_of,
    broken_name,
    error_line,
    even_indices,
    hollow_words,
    label_axis,
    largest_error,
    measure_panels,
    name_with_unit,
    no_impact,
    other_dimensions,
    places_of_cases,
    positions,
    readable_parameter,
    ring,
    sensitive_words,
    shared_scales,
    turns_of_measure,
    unit_of_axis,
    with_impact,
)
from .study_maps import heat_maps
from .style import (
    BLUE,
    BODIES,
    CENTRE,
    FAINT,
    GREY,
    INK,
    PICTURES,
    STYLE,
    VERMILION,
    Array,
    Figures,
    heading,
    one_legend,
    panels,
    readable,
    saved,
)

MOST_CURVES = 6
BAND = (0.05, 0.95)


def curves(study: Study, measures: list[str]) -> Figure | None:
    """Return a figure with a panel for each measure; None where no parameter has several values."""
    parameters = [parameter for parameter in axes_of(study) if len(study.axes[parameter.name]) > 1][:2]
    if not parameters or (drawn := measure_panels(study, measures, 3.5)) is None:
        return None
    figure, axes = drawn
    scales = shared_scales(study, list(axes))
    for name, ax in axes.items():
        curve_panel(ax, study, name, parameters, scales[name])
    one_legend(figure, axes.values())
    heading(figure, study.model + curve_words(study, parameters, list(axes)), study.progress)
    return figure


def curve_words(study: Study, parameters: list[Varied], names: list[str]) -> str:
    """Return which values the curves of measures over parameters are of, and what bands and bars show."""
    count = len(study.axes[parameters[1].name]) if len(parameters) > 1 else 0
    text = f"; {MOST_CURVES} of {count} values of {parameters[1].name}" if count > MOST_CURVES else ""
    if dimensions := other_dimensions(study, parameters):
        ends = f"{100.0 * BAND[0]:g} to {100.0 * BAND[1]:g} %"
        text += f" (medians; bands: {ends} over {dimensions}, without numerical errors)"
    return text + (f"; bars: {bar_words(study)}" if any(name in study.errors for name in names) else "")


def bar_words(study: Study) -> str:
    """Return which error the bars show."""
    text = sensitive_words(study)
    return f"largest numerical error; {text}" if text else "typical numerical error"


def curve_panel(
    ax: Axes, study: Study, name: str, parameters: list[Varied], scale: tuple[float, str]
) -> None:
    """Draw the curves of a measure over the first parameter, one for each value of the second."""
    first, *legend_parameters = parameters
    values, errors = places_of_cases(study, name, parameters)
    labels: list[str | None] = [None]
    for second in legend_parameters:
        texts, label_unit = value_labels(study.axes[second.name], second)
        labels = [f"{second.name} {text} {label_unit}".rstrip() for text in texts]
    values = values.reshape(len(values), len(labels), -1)
    errors, (factor, unit) = errors.reshape(values.shape), scale
    x, x_unit = positions(study.axes[first.name], first)
    shown = even_indices(len(labels), MOST_CURVES)
    for colour, k in enumerate(shown):
        look = BODIES[colour % len(BODIES)]
        curve = factor * with_impact(name, values[:, k])
        middle, low, high = quantiles(curve)
        if (quiet := no_impact(name, values[:, k]).any(axis=1)).any():
            ax.plot(x[quiet], np.zeros(quiet.sum()), color=look, **ring(colour))
        ax.plot(x, middle, color=look, marker="o", ms=3.0 if len(x) < 30 else 0.0, label=labels[k])
        if values.shape[2] > 1:
            ax.fill_between(x, low, high, color=look, alpha=0.18, lw=0.0)
        if name in study.errors:
            bars = factor * largest_error(name, values[:, k], errors[:, k])
            ends = error_ends(name, middle, bars)
            ax.errorbar(x, middle, ends, fmt="none", ecolor=look, elinewidth=0.8)
    label_axis(ax, first, study.axes[first.name], x, unit_of_axis(study, first, x_unit))
    label_counts(ax, values)
    turns = turns_of_measure(study, name) + hollow_words(no_impact(name, values[:, shown]))
    lines = [name_with_unit(name, unit), turns]
    if values.shape[2] > 1:
        lines.append(error_line(study, name, factor, unit))
    ax.set_title("\n".join(lines))


def label_counts(ax: Axes, values: Array) -> None:
    """Put no tick between whole numbers where all values are whole, as counts are."""
    finite = values[np.isfinite(values)]
    if len(finite) and (finite == np.rint(finite)).all():
        ax.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10], integer=True))


def error_ends(name: str, values: Array, errors: Array) -> Array:
    """Return the lengths of error bars below and above values, shape (2, values); bars of a measure that
    cannot be negative end at 0.
    """
    lower = np.minimum(errors, np.maximum(values, 0.0)) if name.endswith(NEVER_NEGATIVE) else errors
    return np.stack([lower, errors])


def value_labels(values: list[Any], parameter: Varied) -> tuple[list[str], str]:
    """Return the values of a parameter for a legend, and their unit."""
    if any(isinstance(value, str) for value in values):
        return [str(value) for value in values], ""
    numbers, unit = positions(values, parameter)
    return [f"{value:.4g}" for value in numbers], unit


def quantiles(values: Array) -> Array:
    """Return the median, lower and upper end of the band along the last axis, without unknown values; shape
    (3, places).
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an unknown value stays unknown
        low, middle, high = np.nanquantile(values, (BAND[0], 0.5, BAND[1]), axis=1)
    return np.stack([middle, low, high])


END: dict[str, Any] = CENTRE | {
    "fontsize": 8.5,
    "color": INK,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 1.0},
}
WORD: dict[str, Any] = {"ha": "left", "va": "center", "fontsize": 8.5, "color": INK}
MOST_LINES, MOST_AXES = 2000, 12


def parallel(study: Study, measures: list[str]) -> Figure | None:
    """Return a figure of parallel coordinates: a line for each case, coloured by the first measure; None with
    fewer than three cases.
    """
    columns, names = numbers(study, measures)
    complete = np.isfinite(columns).all(axis=1)
    if complete.sum() < 3 or len(names) < 2:
        return None
    columns = columns[complete][even_indices(int(complete.sum()), MOST_LINES)]
    low, high = columns.min(axis=0), columns.max(axis=0)
    scaled = np.where(high > low, (columns - low) / np.where(high > low, high - low, 1.0), 0.5)
    figure, (ax,) = panels(1, 1, max(5.5, 1.45 * len(names)), 4.2)
    key = columns[:, len(study.parameters)] if len(names) > len(study.parameters) else columns[:, 0]
    order = np.argsort(key, kind="stable")  # the largest on top
    lowest, highest = float(key.min()), float(key.max()) if key.max() > key.min() else float(key.min()) + 1.0
    segments = [np.column_stack([np.arange(len(names)), row]) for row in scaled[order]]
    ax.add_collection(
        LineCollection(
            segments,
            array=key[order],
            cmap="viridis",
            norm=Normalize(lowest, highest),
            lw=0.9,
            alpha=min(1.0, max(0.15, 60.0 / len(order))),
        )
    )
    parallel_axes(ax, study, names, low, high)
    colour = names[min(len(study.parameters), len(names) - 1)]
    factor, unit = readable_values(study, colour, key)
    bar = figure.colorbar(
        ScalarMappable(Normalize(factor * lowest, factor * highest), "viridis"), ax=ax, pad=0.02
    )
    bar.outline.set_visible(False)
    bar.set_label(name_with_unit(colour, unit))
    heading(figure, f"{study.model}: {len(order):,} cases", study.progress)
    return figure


def readable_values(study: Study, name: str, values: Any) -> tuple[float, str]:
    """Return factor and unit for values of a parameter or a measure."""
    if name in study.measures:
        return readable(values, study.measures[name])
    return readable_parameter(values, study.parameter(name))


def numbers(study: Study, measures: list[str]) -> tuple[Array, list[str]]:
    """Return the parameters and measures of the finished cases, shape (cases, axes), and their names."""
    chosen = measures[: max(1, MOST_AXES - len(study.parameters))]
    columns = [study.points(), *(study.values(name)[:, None] for name in chosen)]
    return np.concatenate(columns, axis=1), [*(parameter.name for parameter in study.parameters), *chosen]


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
        values = [study.at(case)[k] for case in study.done] if k < len(study.parameters) else []
        words = list(dict.fromkeys(values)) if any(isinstance(value, str) for value in values) else []
        factor, unit = readable_values(study, name, [low[k], high[k]])
        heads.append(broken_name(name) + (f"\n({unit})" if unit else ""))
        ends = ("", "") if words else (f"{factor * low[k]:.4g}", f"{factor * high[k]:.4g}")
        ends = (NO_IMPACT, ends[1]) if no_impact(name, low[k : k + 1]).any() else ends
        ax.text(k, -0.04, ends[0], **END)
        ax.text(k, 1.04, ends[1], **END)
        for n, word in enumerate(words):
            ax.text(k + 0.04, n / max(len(words) - 1, 1), str(word), **WORD)
    ax.set_xticks(range(len(names)), heads, fontsize=9.0)
    ax.tick_params(axis="x", length=0.0, pad=8.0)


MOST_PAIRS = 3  # pairs of measures


def fronts(study: Study, measures: list[str], larger: Collection[str] = ()) -> Figure | None:
    """Return a figure of the first measure over each of the next; all are minimised, except those in
    ``larger``. None with fewer than two.
    """
    pairs = [(measures[0], name) for name in measures[1 : MOST_PAIRS + 1]]
    shown = [pair for pair in pairs if np.isfinite(study.values(pair[0]) + study.values(pair[1])).sum() > 1]
    if not shown:
        return None
    figure, axes = panels(len(shown), len(shown), 4.8, 4.2)
    for ax, pair in zip(axes, shown, strict=True):
        front_panel(ax, study, pair, larger)
    one_legend(figure, axes)
    heading(figure, study.model, study.progress)
    return figure


def front_panel(ax: Axes, study: Study, pair: tuple[str, str], larger: Collection[str]) -> None:
    """Draw the front of two measures. A case without impacts is none of it: its impact speed of 0 is that of
    no event, and neighbouring cases may knock.
    """
    points = np.stack([study.values(name) for name in pair], axis=1)
    points = points[np.isfinite(points).all(axis=1)]
    scales = [readable(points[:, k], study.measures[name]) for k, name in enumerate(pair)]
    signs = np.array([-1.0 if name in larger else 1.0 for name in pair])
    quiet = np.any([no_impact(name, points[:, k]) for k, name in enumerate(pair)], axis=0)
    best = np.zeros(len(points), dtype=bool)
    best[~quiet] = front(points[~quiet] * signs)
    x, y = (points[:, k] * scales[k][0] for k in (0, 1))
    beaten = ~best & ~quiet
    ax.scatter(x[beaten], y[beaten], s=14.0, color=BLUE, alpha=0.35, lw=0.0, label="cases")
    order = np.flatnonzero(best)[np.argsort(signs[0] * x[best], kind="stable")]
    ax.step(x[order], y[order], where="post", color=GREY, lw=0.9, zorder=1)
    look: dict[str, Any] = {"s": 22.0, "color": VERMILION, "edgecolor": FAINT, "lw": 0.4, "zorder": 3}
    ax.scatter(x[order], y[order], **look, label="front: none is better in both")
    if quiet.any():
        ax.plot(x[quiet], y[quiet], color=BLUE, **EMPTY, label=f"{NO_IMPACT}, not compared")
    names = [
        name_with_unit(name, scale[1]) + (", large" if name in larger else "")
        for name, scale in zip(pair, scales, strict=True)
    ]
    ax.set(xlabel=names[0], ylabel=names[1])


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
                f"there is no figure {shown(name)}: {suggestion(name, FIGURES, 'name one of the figures')}"
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
    return {title: sharp(figure, title) for title, figure in reported(study).items()}


def reported(study: Study) -> dict[str, Figure]:
    """Return all figures of a study by title."""
    return {TITLES[name]: figure for name, figure in figures(study).items()}


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
        raise VfifeError(f"{shown(ending)} is not a format of figures; allowed: {', '.join(PICTURES)}")
    drawn = figures(study, names, measures, larger)
    if not drawn:
        raise VfifeError(
            f"{study.path or 'this study'}: there is nothing to draw: {len(study.done):,} of"
            f" {len(study.cases):,} cases have ended"
        )
    return [saved(figure, folder / f"{name}{ending}") for name, figure in drawn.items()]
