"""Heat maps of the measures of a study over two parameters, with their numerical errors."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from ..numerics.outward import UP, significant
from ..results.case_errors import NOT_ESTIMATED
from ..results.parameters import Varied
from ..results.study import Study
from .study_axes import (
    EMPTY,
    HOLLOW,
    arranged,
    axes_of,
    broken_name,
    edges,
    label_axis,
    measure_panels,
    name_with_unit,
    no_impact,
    other_dimensions,
    positions,
    sensitive_words,
    turns_of_measure,
    unit_of_axis,
)
from .style import FAINT, INK, Array, digits, heading, readable

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
    for name, ax in axes.items():
        map_panel(figure, ax, study, name, across, up)
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


def error_line(study: Study, name: str, factor: float, unit: str) -> str:
    """Return the numerical error of a measure, which is multiplied by a factor to have the unit."""
    if (error := study.errors.get(name)) is None:
        return f"numerical error {NOT_ESTIMATED}"
    size, word = (error.most, "up to") if error.sensitive else (error.typical, "typically")
    if size < error.floor:
        size, word = error.floor, "typically below"
    return f"numerical error {word} {digits(float(significant(factor * size, 3, UP)))} {unit}".rstrip()


def within_error(study: Study, name: str, values: Array, parameters: Sequence[Varied]) -> NDArray[np.bool_]:
    """Return which ``values`` of a map over parameters differ from their median by less than their numerical
    error, or by nothing that can be known.
    """
    if name not in study.errors:
        return np.zeros(values.shape, dtype=bool)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an unknown value stays unknown
        bars = np.nanmax(arranged(study, study.error_bars(name), parameters), axis=2)
        return np.asarray(np.abs(values - np.nanmedian(values)) < bars)


def map_panel(figure: Figure, ax: Axes, study: Study, name: str, across: Varied, up: Varied) -> None:
    """Draw a map of a measure over two parameters; cells that equal its median within the numerical error are
    hatched.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an unknown value stays unknown
        values = np.nanmedian(arranged(study, study.laid_out(name), (up, across)), axis=2)
    (x, x_unit), (y, y_unit) = (
        positions(study.axes[parameter.name], parameter) for parameter in (across, up)
    )
    factor, unit = readable(values, study.measures[name])
    ax.set_facecolor(FAINT)
    drawn = ax.pcolormesh(
        edges(x), edges(y), np.ma.masked_invalid(factor * values), cmap="viridis", rasterized=True
    )
    label_axis(ax, across, study.axes[across.name], x, unit_of_axis(study, across, x_unit))
    label_axis(ax, up, study.axes[up.name], y, unit_of_axis(study, up, y_unit), "y")
    ax.grid(visible=False)
    rows, columns = np.nonzero(no_impact(name, values))
    ax.plot(x[columns], y[rows], color=INK, **EMPTY)
    right, top = edges(x), edges(y)
    for row, column in np.argwhere(within_error(study, name, values, (up, across))):
        corner, sides = (right[column], top[row]), (np.diff(right)[column], np.diff(top)[row])
        ax.add_patch(Rectangle(corner, *sides, **HATCH))
    turns = turns_of_measure(study, name) + HOLLOW * bool(len(rows))
    lines = (
        broken_name(name_with_unit(name, unit), TITLE_WIDTH),
        turns,
        error_line(study, name, factor, unit),
    )
    ax.set_title("\n".join(lines), fontsize=TITLE_SIZE)
    bar = figure.colorbar(drawn, ax=ax)
    bar.outline.set_visible(False)
