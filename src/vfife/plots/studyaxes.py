"""Axes of a study's figures: quantities in units that read well, values of parameters in their places, words in their order."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from .style import readable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..results.studied import Study, Varied

Array = NDArray[np.float64]
MOST_TICKS = 7  # of a logarithmic axis


def broken(name: str, width: int = 15) -> str:
    """A long name in lines, broken at its dots and underscores."""
    lines = [""]
    for part in re.split(r"(?<=[._ ])", name):
        if lines[-1] and len(lines[-1]) + len(part) > width:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)


def titled(name: str, unit: str) -> str:
    """A name with its unit."""
    return f"{name} ({unit})" if unit else name


def places(values: Sequence[Any], unit: str) -> tuple[Array, str]:
    """Where values of a parameter lie along an axis, and their unit; words one after another."""
    if any(isinstance(value, str) for value in values):
        return np.arange(len(values), dtype=float), ""
    factor, unit = readable(values, unit)
    return factor * np.asarray(values, dtype=float), unit


def edges(middles: Array) -> Array:
    """Borders of cells around their middles; the outer ones as far away as the inner ones."""
    if len(middles) == 1:
        half = 0.5 * (abs(middles[0]) or 1.0)
        return np.array([middles[0] - half, middles[0] + half])
    inner = 0.5 * (middles[1:] + middles[:-1])
    return np.concatenate([[2.0 * middles[0] - inner[0]], inner, [2.0 * middles[-1] - inner[-1]]])


def logarithmic(middles: Array) -> bool:
    """Whether values lie evenly on a logarithmic scale, and not on a plain one."""
    if len(middles) < 3 or middles.min() <= 0.0:
        return False
    ratios, steps = middles[1:] / middles[:-1], np.diff(middles)
    return bool(np.ptp(ratios) < 1e-3 * ratios.mean() and np.ptp(steps) > 1e-2 * steps.mean())


def ticked(ax: Axes, one: Varied, values: Sequence[Any], middles: Array, unit: str, along: str = "x") -> None:
    """Labels an axis of a parameter."""
    axis, label = (ax.xaxis, ax.set_xlabel) if along == "x" else (ax.yaxis, ax.set_ylabel)
    label(titled(one.name, unit))
    if any(isinstance(value, str) for value in values):
        axis.set_ticks(list(middles), [str(value) for value in values])
    elif logarithmic(middles):
        (ax.set_xscale if along == "x" else ax.set_yscale)("log")
        at = [middles[k] for k in shortened(len(middles), MOST_TICKS)]
        axis.set_ticks(at, [f"{value:.3g}" for value in at])
        axis.set_minor_locator(NullLocator())


def lines(study: Study) -> list[Varied]:
    """Parameters along the axes, those of most values first, words last."""
    own = [one for one in study.parameters if one.name in study.axes]
    return sorted(own, key=lambda one: (any(isinstance(value, str) for value in study.axes[one.name]), -len(study.axes[one.name])))


def said_of(study: Study, dims: list[str]) -> str:
    """Dimensions in words."""
    return ", ".join(f"{len(study.axes[name]):,} samples" if name == "sample" else name for name in dims)


def shortened(count: int, most: int) -> list[int]:
    """So many of a number of things, evenly."""
    return sorted({round(k * (count - 1) / max(most - 1, 1)) for k in range(most)}) if count > most else list(range(count))
