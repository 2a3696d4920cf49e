"""Pareto fronts of a study: members of which none is better in one measure without being worse in another."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .studyaxes import Array, titled, unit_for
from .style import BLUE, FAINT, GREY, VERMILION, heading, one_legend, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.studied import Study

MOST = 3  # pairs of measures


def fronts(study: Study, measures: list[str], larger: Collection[str] = ()) -> Figure | None:
    """The first measure against each of the next, smaller being better but for those of which ``larger`` is; None with fewer than two."""
    pairs = [(measures[0], other) for other in measures[1 : MOST + 1]]
    known = [pair for pair in pairs if np.isfinite(study.values(pair[0]) + study.values(pair[1])).sum() > 1]
    if not known:
        return None
    figure, axes = panels(1, len(known), 4.8, 4.2)
    for ax, pair in zip(axes, known, strict=True):
        both = np.stack([study.values(name) for name in pair], axis=1)
        both = both[np.isfinite(both).all(axis=1)]
        scales = [unit_for(both[:, k], study.measures[pair[k]]) for k in (0, 1)]
        x, y = (both[:, k] * scales[k][0] for k in (0, 1))
        signs = np.array([-1.0 if name in larger else 1.0 for name in pair])
        best = front(both * signs)
        ax.scatter(x[~best], y[~best], s=14.0, color=BLUE, alpha=0.35, lw=0.0, label="members")
        order = np.flatnonzero(best)[np.argsort(signs[0] * x[best], kind="stable")]
        ax.step(x[order], y[order], where="post", color=GREY, lw=0.9, zorder=1)
        ax.scatter(x[order], y[order], s=22.0, color=VERMILION, edgecolor=FAINT, lw=0.4, zorder=3, label="front: none is better in both")
        names = [titled(name, scale[1]) + (", large" if name in larger else "") for name, scale in zip(pair, scales, strict=True)]
        ax.set(xlabel=names[0], ylabel=names[1])
    one_legend(figure, axes)
    heading(figure, study.model)
    return figure


def front(values: Array) -> NDArray[np.bool_]:
    """Which of some points, shape (points, measures), no other is at most equal to in all measures and less in one."""
    order = np.lexsort(values.T[::-1])
    best = np.zeros(len(values), dtype=bool)
    kept = np.empty((0, values.shape[1]))
    for k in order:
        if not ((kept <= values[k]).all(axis=1) & (kept < values[k]).any(axis=1)).any():
            best[k] = True
            kept = np.vstack([kept, values[k]])
    return best
