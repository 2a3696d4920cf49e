"""Curves of a study: each measure over one parameter, a curve for each value of another, with the band of all that varies beside."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from .studyaxes import Array, lines, places, said_of, shortened, ticked, titled, unit_for
from .style import BODIES, heading, one_legend, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.studied import Study

MOST_CURVES, MOST = 6, 6
BAND = (0.05, 0.95)


def curves(study: Study, measures: list[str]) -> Figure | None:
    """A panel a measure; None where no parameter has values of its own."""
    own = [one for one in lines(study) if len(study.axes[one.name]) > 1]
    shown = [name for name in measures if np.isfinite(study.laid_out(name)).any()][:MOST]
    if not own or not shown:
        return None
    columns = min(len(shown), 2 if len(shown) < 5 else 3)
    figure, boxes = panels(-(-len(shown) // columns), columns, 4.8, 3.5)
    for ax, name in zip(boxes, shown, strict=False):
        panel(ax, study, name, own)
    for ax in boxes[len(shown) :]:
        ax.set_visible(False)
    one_legend(figure, boxes[: len(shown)])
    others = [name for name in study.axes if name not in {one.name for one in own[:2]}]
    band = f" (medians; bands: {100.0 * BAND[0]:g} to {100.0 * BAND[1]:g} % over {said_of(study, others)})"
    heading(figure, study.model + (band if others else ""))
    return figure


def panel(ax: Axes, study: Study, name: str, own: list[Any]) -> None:
    """The curves of a measure."""
    dims, along = list(study.axes), own[0]
    other = own[1] if len(own) > 1 else None
    keep = [dims.index(along.name)] + ([dims.index(other.name)] if other is not None else [])
    values = np.moveaxis(study.laid_out(name), keep, list(range(len(keep))))
    values = values.reshape(values.shape[0], values.shape[1] if other is not None else 1, -1)
    factor, unit = unit_for(values, study.measures[name])
    x, x_unit = places(study.axes[along.name], along.unit)
    labels, label_unit = ([None], "") if other is None else labelled(study.axes[other.name], other.unit)
    for colour, k in enumerate(shortened(values.shape[1], MOST_CURVES)):
        middle, low, high = (factor * one for one in quantiles(values[:, k, :]))
        label = None if other is None else f"{other.name} {labels[k]} {label_unit}".rstrip()
        look = BODIES[colour % len(BODIES)]
        ax.plot(x, middle, color=look, marker="o", ms=3.0 if len(x) < 30 else 0.0, label=label)
        if values.shape[2] > 1:
            ax.fill_between(x, low, high, color=look, alpha=0.18, lw=0.0)
    ticked(ax, along, study.axes[along.name], x, x_unit)
    ax.set_title(titled(name, unit))


def labelled(values: list[Any], unit: str) -> tuple[list[str], str]:
    """Values of a parameter as a legend says them."""
    if any(isinstance(value, str) for value in values):
        return [str(value) for value in values], ""
    numbers, unit = places(values, unit)
    return [f"{value:.4g}" for value in numbers], unit


def quantiles(values: Array) -> tuple[Array, Array, Array]:
    """Median and band along the last axis, of what is known."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a place of which nothing is known stays so
        low, middle, high = np.nanquantile(values, (BAND[0], 0.5, BAND[1]), axis=1)
    return middle, low, high
