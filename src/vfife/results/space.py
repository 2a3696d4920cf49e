"""Room for the rows of a run that is read."""

from __future__ import annotations

import shutil
import tempfile

import numpy as np
from numpy.typing import NDArray

from ..errors import StorageError

IN_MEMORY = 2**28  # bytes of rows that are read into memory; more are mapped


def space(outputs: int, width: int) -> NDArray[np.float64]:
    """Room for rows: memory, or where they are many a file of no name, of which the system keeps in memory what is looked at.

    Raises StorageError where there is no room for it.
    """
    size = 8 * outputs * width
    if size <= IN_MEMORY:
        return np.empty((outputs, width))
    folder = tempfile.gettempdir()
    free = shutil.disk_usage(folder).free
    if size > free:
        raise StorageError(f"{folder}: the outputs of this run take {size:,} bytes when they are read, and {free:,} are free there")
    with tempfile.TemporaryFile() as file:
        return np.memmap(file, dtype=float, mode="w+", shape=(outputs, width)).view(np.ndarray)
