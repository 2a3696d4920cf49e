"""Heat maps of the measures of a study over two parameters, with their numerical errors."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from ..results.parameters import Varied
from ..results.study import Study
from .study_axes import (
    EMPTY,
    axes_of,
    broken_name,
    edges,
    error_line,
    hollow_words,
    label_axis,
    largest_error,
    measure_panels,
    name_with_unit,
    no_impact,
    other_dimensions,
    places_of_cases,
    positions,
    sensitive_words,
    shared_scales,
    turns_of_measure,
    unit_of_axis,
    with_impact,
)
from .style import FAINT, INK, Array, heading

LEAST_VALUES = 3  # values of each of two parameters that make a map


def heat_maps(study: Study, measures: list[str]) -> Figure | None:
    """Return a figure with a map for each measure; None where no two parameters have a grid of values. Failed
    cases are grey.
    """
    parameters = [
        parameter for parameter in axes_of(study) if len(study.axes[parameter.name]) >= LEAST_VALUES
    ]
    if len(parameters) < 2 or (drawn := measure_panels(study, measures, 3.7)) is None:
        return None
    figure, axes = drawn
    across, up = parameters[:2]
    scales = shared_scales(study, list(axes))
    for name, ax in axes.items():
        map_panel(figure, ax, study, name, across, up, scales[name])
    dimensions = other_dimensions(study, parameters[:2])
    medians = f" (median over {dimensions})" if dimensions else ""
    sensitive = f"; {text}" if (text := sensitive_words(study)) else ""
    hatched = f"; {HATCHED}" if any(ax.patches for ax in axes.values()) else ""
    heading(figure, study.model + medians + sensitive + hatched, study.progress)
    return figure


TITLE_WIDTH = 40  # characters of the title of a map, above its panel and its bar of colours
TITLE_SIZE = 9.5
HATCH: dict[str, Any] = {"fill": False, "hatch": "////", "edgecolor": "#9a9a9a", "lw": 0.0}
HATCHED = "hatched: equal to the median of the map within the numerical error"


def within_error(study: Study, name: str, middle: Array, values: Array, errors: Array) -> NDArray[np.bool_]:
    """Return which cells of a map, the medians of ``values``, differ from their median by less than their
    numerical error, or by nothing that can be known.
    """
    if name not in study.errors:
        return np.zeros(middle.shape, dtype=bool)
    cells = np.where(no_impact(name, values).any(axis=2) & np.isnan(middle), 0.0, middle)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an unknown value stays unknown
        away = np.abs(cells - np.nanmedian(middle))
    return np.asarray((away < largest_error(name, values, errors)) & np.isfinite(values).any(axis=2))


def map_panel(
    figure: Figure, ax: Axes, study: Study, name: str, across: Varied, up: Varied, scale: tuple[float, str]
) -> None:
    """Draw a map of a measure over two parameters; cells that equal its median within the numerical error are
    hatched.
    """
    values, errors = places_of_cases(study, name, (up, across))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an unknown value stays unknown
        middle = np.nanmedian(with_impact(name, values), axis=2)
    quiet = no_impact(name, values)
    silent = quiet.any(axis=2) & np.isnan(middle)
    (x, x_unit), (y, y_unit) = (
        positions(study.axes[parameter.name], parameter) for parameter in (across, up)
    )
    factor, unit = scale
    ax.set_facecolor(FAINT)
    colours = np.ma.masked_invalid(factor * np.where(silent, 0.0, middle))
    drawn = ax.pcolormesh(edges(x), edges(y), colours, cmap="viridis", rasterized=True)
    label_axis(ax, across, study.axes[across.name], x, unit_of_axis(study, across, x_unit))
    label_axis(ax, up, study.axes[up.name], y, unit_of_axis(study, up, y_unit), "y")
    ax.grid(visible=False)
    rows, columns = np.nonzero(quiet.any(axis=2))
    ax.plot(x[columns], y[rows], color=INK, **EMPTY)
    right, top = edges(x), edges(y)
    for row, column in np.argwhere(within_error(study, name, middle, values, errors)):
        corner, sides = (right[column], top[row]), (np.diff(right)[column], np.diff(top)[row])
        ax.add_patch(Rectangle(corner, *sides, **HATCH))
    turns = turns_of_measure(study, name) + hollow_words(quiet)
    lines = (
        broken_name(name_with_unit(name, unit), TITLE_WIDTH),
        turns,
        error_line(study, name, factor, unit),
    )
    ax.set_title("\n".join(lines), fontsize=TITLE_SIZE)
    bar = figure.colorbar(drawn, ax=ax)
    bar.outline.set_visible(False)
