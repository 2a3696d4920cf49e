"""What no sound run shows: numbers that are not finite, journals that have left their bearings, elements stretched out of all shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .assembled import Assembly

STRETCH = 5.0  # of an element's first length, or its inverse


def unsound(assembly: Assembly, kept: NDArray[np.uint32], rows: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of the recorded numbers, shape (outputs, kept), lie beyond all bounds.

    A penetration beyond the bearing's radius and an element beyond a fifth or five times its length are marks of an unstable step, which can
    stay finite for long.
    """
    with np.errstate(invalid="ignore"):
        bad = ~np.isfinite(rows)
        column = {int(row): k for k, row in enumerate(kept)}
        for index, name in enumerate(assembly.contact_joints):
            k = column[assembly.layout.row("contact_penetration", index)]
            bad[:, k] |= rows[:, k] > assembly.mechanism.contacts[name].reach
        if assembly.topology.frame_nodes:
            lengths = assembly.layout["reference_length"]
            columns = [column[int(row)] for row in lengths]
            ratio = rows[:, columns] / assembly.state[lengths]
            bad[:, columns] |= (ratio > STRETCH) | (ratio < 1.0 / STRETCH)
    return bad
