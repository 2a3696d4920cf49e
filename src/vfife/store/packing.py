"""Arrays as few bytes: neighbouring outputs have the leading bytes of their numbers in common, which halves a
run file. Each block is sealed with a hash of all that stands beside it in its row.
"""

from __future__ import annotations

import hashlib
import math
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST_BYTES = 2**30  # of one block of numbers; more is written in several
SEAL_BYTES = 16


def packed(values: NDArray[np.float64]) -> bytes:
    """Shape and numbers as bytes: columns first, then all first bytes of the numbers, all second ones ...,
    deflated.
    """
    columns = np.ascontiguousarray(np.atleast_1d(values).T, dtype="<f8")
    shape = np.array([values.ndim, *values.shape], dtype="<u4").tobytes()
    return shape + zlib.compress(columns.reshape(-1).view(np.uint8).reshape(-1, 8).T.tobytes(), 1)


def unpacked(data: bytes, most: int = MOST_BYTES) -> NDArray[np.float64]:
    """What :func:`packed` was given. Nothing is inflated beyond the size that the block says, and none of
    more than ``most`` bytes is begun.

    Raises zlib.error for what is not as it should be.
    """
    dimensions = int(np.frombuffer(data[:4], dtype="<u4")[0]) if len(data) >= 4 else 9
    if dimensions > 2 or len(data) < 4 + 4 * dimensions:
        raise zlib.error("a block of numbers has no shape")
    shape = tuple(int(n) for n in np.frombuffer(data[4 : 4 + 4 * dimensions], dtype="<u4"))
    size = 8 * math.prod(shape)
    if size > most:
        raise zlib.error(f"a block of numbers says that it has {size:,} bytes; {most:,} are the most")
    raw = zlib.decompressobj().decompress(data[4 + 4 * dimensions :], size + 1)
    if len(raw) != size:
        raise zlib.error("a block of numbers is not as long as it should be")
    numbers = np.frombuffer(raw, dtype=np.uint8).reshape(8, -1).T.copy().reshape(-1).view("<f8")
    return np.ascontiguousarray(numbers.reshape(shape[::-1]).T, dtype=float)


def seal(table: str, *values: Any) -> bytes:
    """Hash of a row: the table's name and all values beside the seal, each with its kind and length."""
    digest = hashlib.blake2b(table.encode(), digest_size=SEAL_BYTES)
    for value in values:
        part = value if isinstance(value, bytes) else str(value).encode("utf-8", "surrogatepass")
        digest.update(f"|{type(value).__name__[0]}{len(part)}|".encode() + part)
    return digest.digest()
