"""Axes and legends of maps: labels that stay apart, colours that can be told apart."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from vfife.dynamics.basins import Attractor
from vfife.plots.dynamics import FURTHER_COLOUR, KIND_COLOURS, PERIODIC, colours, number_axis, shares
from vfife.plots.study import label_counts


def labels_of(ax, axis: str) -> list:
    """Return the visible labels of an axis, drawn."""
    ax.figure.canvas.draw()
    low, high = sorted(getattr(ax, f"get_{axis}lim")())
    ticks = getattr(ax, f"{axis}axis").get_major_ticks()
    return [tick.label1 for tick in ticks if low <= tick.get_loc() <= high]


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("width", [0.0, 1e-9, 1e-3, 1.0])
def test_ticks_of_points_that_differ_by_rounding_have_few_digits(axis: str, width: float) -> None:
    """Points of a periodic motion differ in the tenth digit: their labels ran together."""
    figure = Figure((4.7, 3.6))
    ax = FigureCanvasAgg(figure).figure.add_subplot()
    values = 95.970966715 + width * np.linspace(-0.5, 0.5, 9)
    ax.scatter(*(values, np.ones(9)) if axis == "x" else (np.ones(9), values))
    number_axis(ax, axis, values)
    labels = labels_of(ax, axis)
    assert 2 <= len(labels) <= 8 and max(len(label.get_text()) for label in labels) <= 8
    boxes = [label.get_window_extent() for label in labels]
    assert not any(one.overlaps(other) for k, one in enumerate(boxes) for other in boxes[:k])
    offset = getattr(ax, f"{axis}axis").get_offset_text().get_text()
    low, high = getattr(ax, f"get_{axis}lim")()
    assert not offset and low <= values.min() <= values.max() <= high


def test_attractors_have_colours_of_their_own_and_numbers() -> None:
    """More attractors than colours: the most frequent are named, the others are one entry."""
    kinds = ["period 1"] * 9 + ["chaotic", "not settled", "period 2"]
    groups = [Attractor(kind, np.zeros((0, 1)), (2 * k, 2 * k + 1)) for k, kind in enumerate(kinds)]
    result = SimpleNamespace(
        attractors=groups, verdicts=dict.fromkeys(range(24)), spec=SimpleNamespace(turns=60)
    )
    colour = colours(result)
    own = [shade for shade in colour if shade != FURTHER_COLOUR]
    assert len(set(own)) == len(own) == len(PERIODIC) + 2 and colour.count(FURTHER_COLOUR) == 3
    entries = shares(result, colour)
    texts = [entry.get_label() for entry in entries]
    assert texts[0] == "1. period 1: 8.33 %" and texts[-1] == "3 other periodic motions: 25 %"
    assert "10. chaotic within 60 turns: 8.33 %" in texts and len(set(texts)) == len(texts) == 10
    assert [to_hex(entry.get_facecolor()).upper() for entry in entries[:7]] == [
        to_hex(c).upper() for c in PERIODIC
    ]


def test_colours_of_attractors_differ() -> None:
    """By a tenth of the range of a colour at least, from each other and from that of the rest."""
    shades = np.array([to_rgb(shade) for shade in (*PERIODIC, *KIND_COLOURS.values(), FURTHER_COLOUR)])
    distances = np.abs(shades[:, None] - shades[None]).max(axis=2) + np.eye(len(shades))
    assert distances.min() > 0.1


def test_counts_have_ticks_at_whole_numbers() -> None:
    for values, whole in ((np.array([1.0, 2.0, np.nan, 16.0]), True), (np.array([1.0, 2.5, 16.0]), False)):
        ax = FigureCanvasAgg(Figure((4.8, 3.5))).figure.add_subplot()
        ax.plot(values)
        ax.set_ylim(0.3, 3.1)
        label_counts(ax, values)
        at = [float(label.get_text()) for label in labels_of(ax, "y")]
        assert all(place == round(place) for place in at) is whole
