"""The file that is written in a hurry is the one that h5netcdf writes, name by name."""

import io
from typing import Any

import h5py
import numpy as np
import pytest
import xarray

import vfife
from mechanisms import everything
from vfife.results.netcdf import generally, quickly, write_netcdf


def value(one: Any) -> Any:
    return one if isinstance(one, str | bytes) else (np.asarray(one).dtype.str, np.asarray(one).shape, repr(np.asarray(one).tolist()))


def dumped(whole: io.BytesIO) -> dict[str, Any]:
    """All that lies in a file but who wrote it: attributes, types, shapes, filters, dimensions by name, bits of numbers."""
    with h5py.File(whole) as file:
        found: dict[str, Any] = {"": {name: value(one) for name, one in file.attrs.items() if name != "_NCProperties"}, "order": list(file)}
        for name, one in file.items():
            found[name] = {
                "shape": one.shape, "type": one.dtype.str, "text": h5py.check_string_dtype(one.dtype), "chunks": one.chunks,
                "filters": (one.compression, one.compression_opts, one.shuffle, one.fletcher32), "fill": value(one.fillvalue),
                "scale": one.is_scale, "along": [[scale.name for scale in axis.values()] for axis in one.dims] if not one.is_scale else [],
                "attributes": {key: value(it) for key, it in one.attrs.items() if key not in ("DIMENSION_LIST", "REFERENCE_LIST")},
                "tracked": one.id.get_create_plist().get_attr_creation_order(), "values": one[()].tobytes() if one.dtype.kind != "O" else list(one[()]),
            }  # fmt: skip
        return found


def encoding(data: xarray.Dataset) -> dict[str, dict[str, Any]]:
    return {str(name): {"zlib": True, "complevel": 1, "shuffle": True} for name in data.data_vars}


def table() -> xarray.Dataset:
    """Texts, truths, whole numbers and numbers that are missing, of which some chunks are many."""
    values = np.arange(120_000.0).reshape(4000, 30)
    values[3, 4] = np.nan
    return xarray.Dataset(
        {
            "name": ("member", ["a", "längst", ""]), "count": ("member", [1, 2, 3], {"units": "1"}), "true": ("member", [True, False, True]),
            "large": (("row", "column"), values, {"long_name": "größte", "limits": [1.0, 2.0], "number": 3}),
        },
        {"member": [0, 1, 2], "row": np.arange(4000), "column": [f"c{k}" for k in range(30)], "where": ("member", [0.5, 1.5, np.nan])},
        {"model": "m", "step": 1e-6, "many": [1, 2], "note": ""},
    )  # fmt: skip


def of_a_run() -> xarray.Dataset:
    return vfife.simulate(everything(), duration=0.002, step=2e-6, outputs=5, reference=False).data


@pytest.mark.parametrize("made", [of_a_run, table])
def test_what_is_written_quickly_is_what_is_written_generally(made: Any) -> None:
    data, quick, general = made(), io.BytesIO(), io.BytesIO()
    generally(data, general, encoding(data))
    assert quickly(data, quick)
    assert dumped(quick) == dumped(general)
    with xarray.open_dataset(quick, engine="h5netcdf") as read:
        xarray.testing.assert_identical(read.load(), data)


@pytest.mark.parametrize(
    "data",
    [
        xarray.Dataset({"x": ("along", [1.0, 2.0])}),  # a dimension without a coordinate
        xarray.Dataset({"x": ((), 1.0)}),
        xarray.Dataset({"t": ("t", np.array(["2024-01-01"], dtype="M8[ns]"))}).set_coords("t").assign(z=("t", [1.0 + 2.0j])),
    ],
    ids=["no coordinate", "a number by itself", "complex"],
)
def test_anything_else_goes_the_general_way(data: xarray.Dataset, tmp_path) -> None:
    whole = io.BytesIO()
    assert not quickly(data, whole) and not whole.getbuffer()
    if "z" in data:
        return
    write_netcdf(data, tmp_path / "out.nc")
    with xarray.open_dataset(tmp_path / "out.nc", engine="h5netcdf") as read:
        xarray.testing.assert_identical(read.load(), data)
