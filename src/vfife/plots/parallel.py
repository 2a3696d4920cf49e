"""Parallel coordinates of a study: an axis for each parameter and measure, a line for each member."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize

from .studyaxes import Array, broken, shortened, titled, unit_for
from .style import GREY, INK, heading, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.studied import Study

END: dict[str, Any] = {"fontsize": 8.5, "color": INK, "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 1.0}}
MOST_LINES, MOST_AXES = 2000, 12


def parallel(study: Study, measures: list[str]) -> Figure | None:
    """Members with all their measures, coloured by the first of them; None where there are fewer than three."""
    columns, names = numbers(study, measures)
    whole = np.isfinite(columns).all(axis=1)
    if whole.sum() < 3 or len(names) < 2:
        return None
    columns = columns[whole][shortened(int(whole.sum()), MOST_LINES)]
    low, high = columns.min(axis=0), columns.max(axis=0)
    scaled = np.where(high > low, (columns - low) / np.where(high > low, high - low, 1.0), 0.5)
    figure, (ax,) = panels(1, 1, max(5.5, 1.45 * len(names)), 4.2)
    key = columns[:, len(study.parameters)] if len(names) > len(study.parameters) else columns[:, 0]
    order = np.argsort(key, kind="stable")  # the largest on top
    least, most = float(key.min()), float(key.max()) if key.max() > key.min() else float(key.min()) + 1.0
    segments = [np.column_stack([np.arange(len(names)), row]) for row in scaled[order]]
    ax.add_collection(
        LineCollection(
            segments, array=key[order], cmap="viridis", norm=Normalize(least, most), lw=0.9, alpha=min(1.0, max(0.15, 60.0 / len(order)))
        )
    )
    furnish(ax, study, names, low, high)
    colour = names[min(len(study.parameters), len(names) - 1)]
    factor, unit = unit_for(key, unit_of(study, colour))
    bar = figure.colorbar(ScalarMappable(Normalize(factor * least, factor * most), "viridis"), ax=ax, pad=0.02)
    bar.outline.set_visible(False)
    bar.set_label(titled(colour, unit))
    heading(figure, f"{study.model}: {len(order):,} members")
    return figure


def unit_of(study: Study, name: str) -> str:
    """Unit of a parameter or a measure."""
    return study.measures[name] if name in study.measures else study.parameter(name).unit


def numbers(study: Study, measures: list[str]) -> tuple[Array, list[str]]:
    """Parameters and measures of the members that ended, shape (members, axes), and their names."""
    chosen = measures[: max(1, MOST_AXES - len(study.parameters))]
    columns = [study.points(), *(study.values(name)[:, None] for name in chosen)]
    return np.concatenate(columns, axis=1), [*(one.name for one in study.parameters), *chosen]


def furnish(ax: Axes, study: Study, names: list[str], low: Array, high: Array) -> None:
    """Axes with their limits, and words in their places."""
    ax.set(xlim=(-0.35, len(names) - 0.65), ylim=(-0.09, 1.09))
    ax.set_yticks([])
    ax.grid(visible=False)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)
    heads = []
    for k, name in enumerate(names):
        ax.axvline(k, color=GREY, lw=0.8, zorder=0)
        words = sorted({value for one in study.done if isinstance(value := study.at(one)[k], str)}) if k < len(study.parameters) else []
        factor, unit = unit_for([low[k], high[k]], unit_of(study, name))
        heads.append(broken(name) + (f"\n({unit})" if unit else ""))
        ends = ("", "") if words else (f"{factor * low[k]:.4g}", f"{factor * high[k]:.4g}")
        ax.text(k, -0.04, ends[0], ha="center", va="center", **END)
        ax.text(k, 1.04, ends[1], ha="center", va="center", **END)
        for n, word in enumerate(dict.fromkeys(study.at(one)[k] for one in study.done) if words else ()):
            ax.text(k + 0.04, n / max(len(words) - 1, 1), str(word), ha="left", va="center", fontsize=8.5, color=INK)
    ax.set_xticks(range(len(names)), heads, fontsize=9.0)
    ax.tick_params(axis="x", length=0.0, pad=8.0)
