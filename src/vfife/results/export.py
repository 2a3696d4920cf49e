"""A result or a study in the files of other programs: CSV, Parquet, MATLAB, NetCDF. Each is whole or not
there.

HDF5 falls over where a write fails under it. So a NetCDF file is made in memory, and written by the system's
own calls under another name; one that is too large for that is begun only where the disk has room for all of
it.
"""

from __future__ import annotations

import csv
import errno
import io
import os
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..errors import VfifeError
from ..files import free_bytes, replacement
from .series import Column, columns

if TYPE_CHECKING:
    import xarray

    from .studied import Study
    from .view import View

What = TypeVar("What")


def write_as(
    what: What, path: Path, formats: Mapping[str, Callable[[What, Path], None]], refused: str
) -> None:
    """Writes in the format that the file's ending names. Raises VfifeError for another, which begins with
    what is ``refused``, and where there is no folder; OSError.
    """
    write = formats.get(path.suffix.lower())
    if write is None:
        *some, last = formats
        raise VfifeError(
            f'{path}: {refused} written as "{path.suffix or path.name}"; endings that say a format are'
            f" {', '.join(some)} and {last}"
        )
    if not path.absolute().parent.is_dir():
        raise VfifeError(f"{path}: there is no folder {path.absolute().parent}; make it first")
    write(what, path)


def arrow(path: Path, others: str) -> Any:
    """pyarrow, which writes Parquet. Raises VfifeError where it is not installed, which names ``others``."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise VfifeError(
            f"{path}: Parquet is written by pyarrow, which is not installed here: pip install"
            f' "vfife[parquet]", or write {others}'
        ) from None
    return pyarrow


def write_parquet(
    path: Path,
    pyarrow: Any,
    columns: Iterable[tuple[str, Any, Mapping[str, str]]],
    attributes: Mapping[str, object],
) -> None:
    """Writes arrays of ``pyarrow`` by their names, each with its metadata, and attributes of them all; whole
    or not there. Raises OSError.
    """
    named = list(columns)
    fields = [pyarrow.field(name, array.type, metadata=told) for name, array, told in named]
    schema = pyarrow.schema(fields, metadata={key: str(value) for key, value in attributes.items()})
    with replacement(path) as part:
        pyarrow.parquet.write_table(
            pyarrow.Table.from_arrays([array for _, array, _ in named], schema=schema), part
        )


IN_MEMORY = 2**30  # bytes of numbers beyond which a file is not made in memory
ROOM = 1.1  # of the bytes of the numbers that a file may take


def write_netcdf(data: xarray.Dataset, path: Path) -> None:
    """Writes a dataset; a file that is there is replaced when the new one is whole. Raises OSError, after
    which nothing has changed.
    """
    encoding: dict[str, dict[str, Any]] = {
        str(name): {"zlib": True, "complevel": 1, "shuffle": True} for name in data.data_vars
    }
    with replacement(path) as temporary:
        if data.nbytes > IN_MEMORY:
            free = free_bytes(path)
            if free is not None and free < ROOM * data.nbytes:
                raise OSError(
                    errno.ENOSPC,
                    f"{os.strerror(errno.ENOSPC)}: this takes up to {int(ROOM * data.nbytes):,} bytes",
                    str(path),
                )
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


# --------------------------------------------------------------------------------------------------------------- results

LONGEST_FIELD = 63  # letters of a name in MATLAB


def export_result(view: View, path: Path) -> None:
    """Writes all channels with their units, in the format that the file's ending names. Raises VfifeError for
    another, OSError.
    """
    write_as(view, path, RESULT_FORMATS, "no data are")


def _write_csv(path: Path, heads: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """A line of names with units, then a line each, numbers to the last bit."""
    with replacement(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        lines = csv.writer(stream)
        lines.writerow(heads)
        lines.writerows(rows)


def _netcdf(one: View | Study, path: Path) -> None:
    write_netcdf(one.data, path)


def _csv(view: View, path: Path) -> None:
    every = columns(view)
    _write_csv(path, (one.titled for one in every), zip(*(one.values.tolist() for one in every), strict=True))


def _parquet(view: View, path: Path) -> None:
    """One column a series, with unit and meaning in its metadata; elements and particles as well."""
    pyarrow = arrow(path, ".csv, .nc or .mat")
    every = ((one, pyarrow.array(np.ascontiguousarray(one.values))) for one in columns(view, fine=True))
    write_parquet(
        path,
        pyarrow,
        ((one.name, array, {"units": one.unit, "long_name": one.meaning}) for one, array in every),
        view.attributes,
    )


def _matlab(view: View, path: Path) -> None:
    """A struct with a field for each joint, body and spring, in it a column for each quantity; ``units`` has
    the same fields, with texts.
    """
    import scipy.io

    found: dict[str, Any] = {}
    units: dict[str, Any] = {}
    names = Names()
    for one in columns(view, fine=True):
        where, said = (
            (found, units)
            if not one.owner
            else (found.setdefault(names[one.owner], {}), units.setdefault(names[one.owner], {}))
        )
        key = names[of_itself(one)]
        where[key], said[key] = np.asarray(one.values, dtype=float), one.unit
    about = {
        names[key]: value if isinstance(value, float) else str(value)
        for key, value in view.attributes.items()
    }
    with replacement(path) as part, part.open("wb") as stream:
        scipy.io.savemat(
            stream,
            {"result": found, "units": units, "about": about},
            long_field_names=True,
            oned_as="column",
            do_compression=True,
        )


def of_itself(one: Column) -> str:
    """What a column is called where its noun is said already."""
    return one.name if not one.owner else one.quantity


class Names(dict[str, str]):
    """Names as MATLAB has them: letters, digits and underscores, the first a letter; no two become one."""

    def __missing__(self, name: str) -> str:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = (plain if re.match(r"[A-Za-z]", plain) else f"x{plain}")[: LONGEST_FIELD - 4]
        taken, found, k = set(self.values()), plain, 2
        while found in taken:
            found, k = f"{plain}_{k}", k + 1
        self[name] = found
        return found


RESULT_FORMATS: dict[str, Callable[[View, Path], None]] = {
    ".csv": _csv, ".mat": _matlab, ".nc": _netcdf, ".nc4": _netcdf, ".h5": _netcdf, ".parquet": _parquet,
}  # fmt: skip


# --------------------------------------------------------------------------------------------------------------- studies


def export_study(study: Study, path: Path) -> None:
    """Writes a study in the format that the file's ending names. Raises VfifeError for another, OSError."""
    write_as(study, path, STUDY_FORMATS, "no study is")


def units(study: Study) -> dict[str, str]:
    """Units by column, of those that have one."""
    found = {**{one.name: one.unit for one in study.parameters}, **study.measures, "step": "s"}
    return {name: unit for name, unit in found.items() if unit != "1"}


def _study_csv(study: Study, path: Path) -> None:
    known, names = units(study), study.columns
    heads = (f"{name} [{known[name]}]" if name in known else name for name in names)
    _write_csv(path, heads, ([row[name] for name in names] for row in study.rows()))


def _study_parquet(study: Study, path: Path) -> None:
    """One column each, with its unit in its metadata."""
    pyarrow = arrow(path, ".csv or .nc")
    rows, known = study.rows(), units(study)
    kinds: dict[str, Any] = {
        "member": pyarrow.int64(),
        "status": pyarrow.string(),
        "reason": pyarrow.string(),
    }
    kinds |= {name: pyarrow.int64() for name in ("turns", "settled")} | {
        name: pyarrow.float64() for name in (*study.measures, "step")
    }
    arrays = ((name, pyarrow.array([row[name] for row in rows], kinds.get(name))) for name in study.columns)
    write_parquet(
        path, pyarrow, ((name, array, about(study, name, known)) for name, array in arrays), study.attributes
    )


def about(study: Study, name: str, known: dict[str, str]) -> dict[str, str]:
    """What the metadata of a column say: its unit, and of a measure the numerical error of a member."""
    return {
        "units": known.get(name, "1"),
        **{key: str(value) for key, value in study.said_error(name).items()},
    }


STUDY_FORMATS: dict[str, Callable[[Study, Path], None]] = {
    ".csv": _study_csv,
    ".nc": _netcdf,
    ".parquet": _study_parquet,
}
