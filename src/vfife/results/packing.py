"""Arrays as few bytes: neighbouring outputs have the leading bytes of their numbers in common, which halves a run
file.
"""

from __future__ import annotations

import zlib

import numpy as np
from numpy.typing import NDArray


def packed(values: NDArray[np.float64]) -> bytes:
    """Shape and numbers as bytes: columns first, then all first bytes of the numbers, all second ones ..., deflated."""
    columns = np.ascontiguousarray(np.atleast_1d(values).T, dtype="<f8")
    shape = np.array([values.ndim, *values.shape], dtype="<u4").tobytes()
    return shape + zlib.compress(columns.reshape(-1).view(np.uint8).reshape(-1, 8).T.tobytes(), 1)


def unpacked(data: bytes) -> NDArray[np.float64]:
    """What :func:`packed` was given."""
    dimensions = int(np.frombuffer(data[:4], dtype="<u4")[0]) if len(data) >= 4 else 9
    shape = tuple(int(n) for n in np.frombuffer(data[4 : 4 + 4 * dimensions], dtype="<u4")) if dimensions < 3 else ()
    raw = zlib.decompress(data[4 + 4 * dimensions :])
    if len(raw) != 8 * int(np.prod(shape)) or len(shape) != dimensions:
        raise zlib.error("a block of numbers is not as long as it should be")
    numbers = np.frombuffer(raw, dtype=np.uint8).reshape(8, -1).T.copy().reshape(-1).view("<f8")
    return np.ascontiguousarray(numbers.reshape(shape[::-1]).T, dtype=float)
