"""Heat maps of a study: each measure over two parameters, the median over all others."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from .studyaxes import Array, edges, lines, places, said_of, ticked, titled, unit_for
from .style import FAINT, heading, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.studied import Study

LEAST = 3  # values of each of two parameters that make a map
MOST = 6  # panels


def heat_maps(study: Study, measures: list[str]) -> Figure | None:
    """A panel a measure; None where no two parameters have a grid of values. Members that gave nothing are grey."""
    axes = [one for one in lines(study) if len(study.axes[one.name]) >= LEAST][:2]
    if len(axes) < 2:
        return None
    shown = [name for name in measures if np.isfinite(study.laid_out(name)).any()][:MOST]
    if not shown:
        return None
    columns = min(len(shown), 2 if len(shown) < 5 else 3)
    figure, boxes = panels(-(-len(shown) // columns), columns, 4.8, 3.7)
    for ax, name in zip(boxes, shown, strict=False):
        panel(figure, ax, study, name, axes)
    for ax in boxes[len(shown) :]:
        ax.set_visible(False)
    others = [name for name in study.axes if name not in {one.name for one in axes}]
    heading(figure, study.model + (f" (median over {said_of(study, others)})" if others else ""))
    return figure


def panel(figure: Figure, ax: Axes, study: Study, name: str, axes: list[Any]) -> None:
    """One map."""
    across, up = axes
    dims = list(study.axes)
    values = median(study.laid_out(name), [dims.index(up.name), dims.index(across.name)])
    (x, x_unit), (y, y_unit) = (places(study.axes[one.name], one.unit) for one in axes)
    factor, unit = unit_for(values, study.measures[name])
    ax.set_facecolor(FAINT)
    drawn = ax.pcolormesh(edges(x), edges(y), np.ma.masked_invalid(factor * values), cmap="viridis", rasterized=True)
    ticked(ax, across, study.axes[across.name], x, x_unit)
    ticked(ax, up, study.axes[up.name], y, y_unit, "y")
    ax.grid(visible=False)
    ax.set_title(titled(name, unit))
    bar = figure.colorbar(drawn, ax=ax)
    bar.outline.set_visible(False)


def median(values: Array, keep: list[int]) -> Array:
    """The median over all axes but two, which come in this order."""
    rest = tuple(k for k in range(values.ndim) if k not in keep)
    moved = np.moveaxis(values, keep, [0, 1])
    if not rest:
        return moved
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a cell of which nothing is known stays so
        found: Array = np.nanmedian(moved.reshape(*moved.shape[:2], -1), axis=2)
    return found
