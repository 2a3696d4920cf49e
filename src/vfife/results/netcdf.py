"""A dataset as NetCDF-4, whole or not at all.

HDF5 falls over where a write fails under it. So a file is made in memory, and written by the system's own calls under another name; one that is too
large for that is begun only where the disk has room for all of it.
"""

from __future__ import annotations

import errno
import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..files import free_bytes, replacement

if TYPE_CHECKING:
    import xarray

IN_MEMORY = 2**30  # bytes of numbers beyond which a file is not made in memory
ROOM = 1.1  # of the bytes of the numbers that a file may take


def write_netcdf(data: xarray.Dataset, path: Path) -> None:
    """Writes a dataset; a file that is there is replaced when the new one is whole. Raises OSError, after which nothing has changed."""
    encoding: dict[str, dict[str, Any]] = {str(name): {"zlib": True, "complevel": 1, "shuffle": True} for name in data.data_vars}
    with replacement(path) as temporary:
        if data.nbytes > IN_MEMORY:
            free = free_bytes(path)
            if free is not None and free < ROOM * data.nbytes:
                raise OSError(errno.ENOSPC, f"{os.strerror(errno.ENOSPC)}: this takes up to {int(ROOM * data.nbytes):,} bytes", str(path))
            data.to_netcdf(temporary, engine="h5netcdf", encoding=encoding)
        else:
            made = _made(data, encoding)
            with temporary.open("wb") as stream:
                stream.write(made)


def _made(data: xarray.Dataset, encoding: dict[str, dict[str, Any]]) -> memoryview:
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    whole = io.BytesIO()
    store: Any = H5NetCDFStore(h5netcdf.File(whole, "w"))
    try:
        data.dump_to_store(store, encoding=encoding)
    finally:
        store.close()
    return whole.getbuffer()
