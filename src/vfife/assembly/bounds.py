"""What no sound run shows: numbers that are not finite, journals that have left their bearings, elements stretched out of all shape."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..codegen.runner import Watched
from .assembled import Assembly

Array = NDArray[np.float64]

LIMITED = ("contact_penetration", "contact_penetration_max", "reference_length")
STRETCH = 5.0  # of an element's first length, or its inverse


def limited_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Rows of S with numbers that have bounds: penetrations, the largest since the last output, and lengths of elements."""
    return np.concatenate([assembly.layout[name] for name in LIMITED]).astype(np.uint32)


def bounds(assembly: Assembly) -> tuple[Array, Array]:
    """The lowest and highest number that :func:`limited_rows` have in a sound run.

    A penetration beyond the bearing's radius and an element beyond a fifth or five times its length are marks of an unstable step, which can
    stay finite for long; a journal may be back in its bearing when somebody looks.
    """
    reach = np.array([assembly.mechanism.contacts[name].reach for name in assembly.contact_joints], dtype=float)
    length = assembly.state[assembly.layout["reference_length"]]
    return np.concatenate([np.full(2 * len(reach), -np.inf), length / STRETCH]), np.concatenate([reach, reach, length * STRETCH])


def watched(assemblies: Sequence[Assembly], lanes: NDArray[np.bool_]) -> Watched:
    """What breaks simulations of one topology side by side, of which some are looked at."""
    low, high = zip(*(bounds(assembly) for assembly in assemblies), strict=True)
    return Watched(limited_rows(assemblies[0]), np.stack(low, axis=1), np.stack(high, axis=1), lanes)


class Bounds:
    """Finds what lies beyond all bounds among recorded numbers, those of the rows ``kept``; ``columns`` are those that have bounds, if known."""

    def __init__(self, assembly: Assembly, kept: NDArray[np.uint32], columns: NDArray[np.intp] | None = None) -> None:
        if columns is None:
            order = np.argsort(kept, kind="stable")
            columns = order[np.searchsorted(kept, limited_rows(assembly), sorter=order)]
        self.columns = columns
        self.low, self.high = bounds(assembly)

    def unsound(self, rows: Array) -> NDArray[np.bool_]:
        """Which numbers, shape (outputs, kept)."""
        bad: NDArray[np.bool_] = ~np.isfinite(rows)
        limited = rows[:, self.columns]
        with np.errstate(invalid="ignore"):
            bad[:, self.columns] |= (limited < self.low) | (limited > self.high)
        return bad
