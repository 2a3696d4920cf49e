"""A dataset as NetCDF-4, whole or not at all.

HDF5 falls over where a write fails under it. So a file is made in memory, and written by the system's own calls under another name; one that is too
large for that is begun only where the disk has room for all of it.
"""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .tables import free_bytes

if TYPE_CHECKING:
    import xarray

IN_MEMORY = 2**30  # bytes of numbers beyond which a file is not made in memory
ROOM = 1.1  # of the bytes of the numbers that a file may take


def write_netcdf(data: xarray.Dataset, path: Path) -> None:
    """Writes a dataset; a file that is there is replaced when the new one is whole. Raises OSError, after which nothing has changed."""
    encoding: dict[str, dict[str, Any]] = {str(name): {"zlib": True, "complevel": 1, "shuffle": True} for name in data.data_vars}
    part = path.with_name(f"{path.name}.part")
    try:
        if data.nbytes > IN_MEMORY:
            free = free_bytes(path)
            if free is not None and free < ROOM * data.nbytes:
                raise OSError(errno.ENOSPC, f"{os.strerror(errno.ENOSPC)}: this takes up to {int(ROOM * data.nbytes):,} bytes", str(path))
            data.to_netcdf(part, engine="h5netcdf", encoding=encoding)
        else:
            made = _made(data, encoding)
            with part.open("wb") as stream:
                stream.write(made)
                stream.flush()
                os.fsync(stream.fileno())
        os.replace(part, path)
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def _made(data: xarray.Dataset, encoding: dict[str, dict[str, Any]]) -> memoryview:
    whole = io.BytesIO()
    if not quickly(data, whole):
        generally(data, whole, encoding)
    return whole.getbuffer()


def generally(data: xarray.Dataset, whole: io.BytesIO, encoding: dict[str, dict[str, Any]]) -> None:
    """Any dataset, as xarray and h5netcdf write it."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    store: Any = H5NetCDFStore(h5netcdf.File(whole, "w"))
    try:
        data.dump_to_store(store, encoding=encoding)
    finally:
        store.close()


def quickly(data: xarray.Dataset, whole: io.BytesIO) -> bool:
    """The same file in a fifth of the time, which h5netcdf spends on looking up what it has just made; False, and nothing written, where the
    dataset has more than numbers and texts along dimensions that have coordinates."""
    import h5py
    from xarray.conventions import cf_encoder, encode_dataset_coordinates

    variables, attributes = cf_encoder(*encode_dataset_coordinates(data))
    plain = all(one.dtype.kind in "fiuU" and one.ndim for one in variables.values())
    if not plain or any(name not in variables or variables[name].dims != (name,) for name in data.sizes):
        return False
    numbers = {name: k for k, name in enumerate(dict.fromkeys(name for one in variables.values() for name in one.dims))}
    with h5py.File(whole, "w", track_order=True) as file:
        file.attrs["_NCProperties"] = np.bytes_(f"version=2,h5py={h5py.version.version},hdf5={h5py.version.hdf5_version}")
        _describe(file, attributes)
        made = {name: _variable(file, str(name), one, name in data.data_vars) for name, one in variables.items()}
        for name, number in numbers.items():
            made[name].make_scale(str(name))
            made[name].attrs["_Netcdf4Dimid"] = np.int32(number)
        for name, one in variables.items():
            if name not in numbers:
                made[name].attrs["_Netcdf4Dimid"] = np.int32(numbers[one.dims[0]])
                for axis, along in enumerate(one.dims):
                    made[name].dims[axis].attach_scale(made[along])
            made[name].attrs["_Netcdf4Coordinates"] = np.array([numbers[along] for along in one.dims], dtype=np.int32)
    return True


def _variable(file: Any, name: str, one: xarray.Variable, packed: bool) -> Any:
    """A variable with its attributes."""
    import h5py

    text, attributes = one.dtype.kind == "U", dict(one.attrs)
    values = one.values.astype(object) if text else one.values
    kind: Any = h5py.string_dtype() if text else values.dtype
    packing = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if packed else {}
    made = file.create_dataset(
        name, data=values, shape=values.shape, dtype=kind, fillvalue=attributes.get("_FillValue"), track_order=True, **packing
    )
    _describe(made, attributes)
    return made


def _describe(owner: Any, attributes: Mapping[Any, Any]) -> None:
    for name, value in attributes.items():
        owner.attrs[name] = value if isinstance(value, str) else np.atleast_1d(value)
