"""Lines of a processor's cache: copies of a state are taken in whole ones, and vectors that straddle two cost a quarter of the speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LINE = 8  # numbers in a line


def padded(count: int) -> int:
    """So many numbers in whole lines."""
    return -(-count // LINE) * LINE


def aligned(count: int) -> NDArray[np.float64]:
    """Zeros that begin a line, with room to the end of the last one's."""
    space = np.zeros(padded(count) + LINE)
    skip = (-space.ctypes.data // 8) % LINE
    return space[skip : skip + count]
