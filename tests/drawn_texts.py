"""Where the texts of a figure are, as a renderer measures them."""

from itertools import combinations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

NEAR = (
    1.0  # pixels by which boxes of texts may run into each other: they are a little higher than their letters
)


def texts(figure: Figure) -> list[tuple[str, NDArray[np.float64]]]:
    """Every text that is seen, with the lower left and the upper right corner of its box (pixels)."""
    renderer = figure.canvas.get_renderer()
    found: list[Text] = list(figure.texts)  # the title among them
    for legend in figure.legends:
        legend.draw(renderer)  # which lays it out
        found += legend.get_texts()
    for ax in figure.axes:
        ax.get_tightbbox(renderer)
        found += [ax.title, ax._left_title, ax._right_title, ax.xaxis.label, ax.yaxis.label, *ax.texts]
        for axis, (low, high) in ((ax.xaxis, sorted(ax.get_xlim())), (ax.yaxis, sorted(ax.get_ylim()))):
            room = 1e-9 * (high - low)
            for tick in axis.get_major_ticks():
                if low - room <= tick.get_loc() <= high + room:
                    found += [one for one in (tick.label1, tick.label2) if one.get_visible()]
    seen = [one for one in found if one.get_visible() and one.get_text().strip()]
    return [(one.get_text(), np.array(one.get_window_extent(renderer).get_points())) for one in seen]


def faults(figure: Figure) -> list[str]:
    """Texts that leave the canvas, and pairs that overlap."""
    every, size = texts(figure), np.array(figure.canvas.get_width_height(), dtype=float)
    found = [
        f"{text!r} leaves the canvas"
        for text, box in every
        if (box[0] < -NEAR).any() or (box[1] > size + NEAR).any()
    ]
    for (one, a), (other, b) in combinations(every, 2):
        if (np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]) > NEAR).all():
            found.append(f"{one!r} overlaps {other!r}")
    return found
