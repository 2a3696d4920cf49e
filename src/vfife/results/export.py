"""Columns with names and units; export of a result or study to CSV, workbooks, Parquet, MATLAB and NetCDF.

HDF5 crashes if a write fails. A NetCDF file is therefore made in memory and written under another name by
system calls; one too large for memory is begun only if the disk has room for all of it.
"""

from __future__ import annotations

import errno
import io
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np

from ..errors import VfifeError, shown
from ..files import DataTable, free_bytes, replacement, write_rows, write_tables
from .selection import Selection

if TYPE_CHECKING:
    import pandas
    import xarray

    from .study import Study


class Column(Protocol):
    """A column of a table: ``values`` by row, in ``unit`` ("1" for texts and numbers without unit)."""

    @property
    def name(self) -> str:
        """Name of the column."""

    @property
    def values(self) -> Any:
        """Values, shape (rows,)."""

    @property
    def unit(self) -> str:
        """Unit of the values."""

    @property
    def metadata(self) -> Mapping[str, str]:
        """Unit, meaning and other attributes for formats that can store them."""


@dataclass(frozen=True)
class TableColumn:
    """A column with its own values; ``kind`` is their type where None stands for missing ones."""

    name: str
    values: Sequence[Any] | np.ndarray
    unit: str = "1"
    attributes: Mapping[str, str] = field(default_factory=dict)
    kind: type | None = None

    @property
    def metadata(self) -> Mapping[str, str]:
        """Unit, and the attributes."""
        return {"units": self.unit, **self.attributes}


def titled(column: Column) -> str:
    """Return the head of a column: name and unit, ``C.force [N]``."""
    return column.name if column.unit == "1" else f"{column.name} [{column.unit}]"


def table_rows(columns: Sequence[Column]) -> Iterator[Sequence[Any]]:
    """Yield the heads of columns, then every row."""
    yield [titled(column) for column in columns]
    values = (
        column.values.tolist() if isinstance(column.values, np.ndarray) else column.values
        for column in columns
    )
    yield from zip(*values, strict=True)


def data_frame(columns: Sequence[Column], index: Column, units: bool = False) -> pandas.DataFrame:
    """Make a data frame of columns and an ``index``; with ``units`` in their names, or without."""
    import pandas

    name = titled if units else (lambda column: column.name)
    data = {name(column): np.asarray(column.values) for column in columns}
    return pandas.DataFrame(data, pandas.Index(index.values, name=name(index)))


def write_parquet(
    path: Path, columns: Iterable[Column], attributes: Mapping[str, object], alternatives: str
) -> None:
    """Write columns with their metadata as Parquet; a file that is there is replaced when the new one is
    whole.

    Raises VfifeError, which names ``alternatives``, without pyarrow; OSError.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise VfifeError(
            f"{path}: Parquet is written by pyarrow, which is not installed here: pip install"
            f' "vfife[parquet]", or write {alternatives}'
        ) from None
    kinds: dict[type | None, Any] = {int: pyarrow.int64(), float: pyarrow.float64(), str: pyarrow.string()}
    arrays, fields = [], []
    for column in columns:
        values = (
            np.ascontiguousarray(column.values) if isinstance(column.values, np.ndarray) else column.values
        )
        arrays.append(pyarrow.array(values, kinds.get(getattr(column, "kind", None))))
        fields.append(pyarrow.field(column.name, arrays[-1].type, metadata=column.metadata))
    schema = pyarrow.schema(fields, metadata={key: str(value) for key, value in attributes.items()})
    with replacement(path) as temporary:
        pyarrow.parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=schema), temporary)


IN_MEMORY = 2**30  # bytes of numbers beyond which a file is not made in memory
ROOM = 1.1  # largest size of a file over that of its numbers
LONGEST_NAME = 63  # letters of a name in MATLAB
Source = TypeVar("Source")


def export(
    source: Source,
    path: Path,
    formats: Mapping[str, Callable[[Source, Path], None]],
    subject: str,
    decimal: str = "point",
) -> None:
    """Write a result or study in the format that the file's ending names; ``decimal`` as in
    :func:`~vfife.files.write_rows`.

    Raises VfifeError for another ending, with the ``subject`` of that sentence, for a decimal comma in
    another format than CSV, and where there is no folder; OSError.
    """
    check_decimal(decimal, path)
    write = formats.get(path.suffix.lower())
    if write is None:
        *first_formats, last = formats
        raise VfifeError(
            f'{path}: {subject} written as "{path.suffix or path.name}"; endings that say a format are'
            f" {', '.join(first_formats)} and {last}"
        )
    if not path.absolute().parent.is_dir():
        raise VfifeError(f"{path}: there is no folder {path.absolute().parent}; make it first")
    if decimal == "comma":
        write_rows(path, _spreadsheet(source), decimal)
    else:
        write(source, path)


def check_decimal(decimal: str, path: Path) -> None:
    """Raise VfifeError for another decimal than "point" and "comma", and for a comma in a format without
    one.
    """
    if decimal not in ("point", "comma"):
        raise VfifeError(f'decimal: {shown(decimal)} is neither "point" nor "comma"')
    if decimal == "comma" and path.suffix.lower() != ".csv":
        raise VfifeError(
            f'{path}: decimal = "comma" is for .csv; all other formats store numbers, which programs show as'
            " their language has it"
        )


def _spreadsheet(source: Any) -> Iterator[Sequence[Any]]:
    """Return the table of a result or study for readers of a spreadsheet."""
    return source.spreadsheet() if isinstance(source, DataTable) else table_rows(source.columns())


def write_netcdf(data: xarray.Dataset, path: Path) -> None:
    """Write a dataset; a file that is there is replaced when the new one is whole. Raises OSError, after
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
            content = _in_memory(data, encoding)
            with temporary.open("wb") as stream:
                stream.write(content)


def _in_memory(data: xarray.Dataset, encoding: dict[str, dict[str, Any]]) -> memoryview:
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    content = io.BytesIO()
    store: Any = H5NetCDFStore(h5netcdf.File(content, "w"))
    try:
        data.dump_to_store(store, encoding=encoding)
    finally:
        store.close()
    return content.getbuffer()


def _netcdf(source: Selection | Study, path: Path) -> None:
    write_netcdf(source.data, path)


def _csv(source: Selection | Study, path: Path) -> None:
    write_rows(path, _spreadsheet(source))


def _workbook(source: Selection | Study, path: Path) -> None:
    """Write a sheet with the table, and one with what the numbers come from."""
    explanation = [("", ""), *source.attributes.items()]
    write_tables(path, {source.name or "table": _spreadsheet(source), "about": explanation})


def _parquet(selection: Selection, path: Path) -> None:
    """Write one column per series, including elements and particles."""
    write_parquet(path, selection.columns(fine=True), selection.attributes, ".csv, .nc or .mat")


def _matlab(selection: Selection, path: Path) -> None:
    """Write a struct with a field for each joint, body and spring, and in it a column for each quantity;
    ``units`` has the same fields.
    """
    import scipy.io

    data: dict[str, Any] = {}
    units: dict[str, Any] = {}
    names = Names()
    for column in selection.columns(fine=True):
        owner, key = (
            column.owner and names[column.owner],
            names[column.quantity if column.owner else column.name],
        )
        (data.setdefault(owner, {}) if owner else data)[key] = np.asarray(column.values, dtype=float)
        (units.setdefault(owner, {}) if owner else units)[key] = column.unit
    description = {
        names[key]: value if isinstance(value, float) else str(value)
        for key, value in selection.attributes.items()
    }
    with replacement(path) as temporary, temporary.open("wb") as stream:
        content = {"result": data, "units": units, "about": description}
        scipy.io.savemat(stream, content, long_field_names=True, oned_as="column", do_compression=True)


class Names(dict[str, str]):
    """Valid and unique names for MATLAB: letters, digits and underscores, beginning with a letter."""

    def __missing__(self, name: str) -> str:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = (plain if re.match(r"[A-Za-z]", plain) else f"x{plain}")[: LONGEST_NAME - 4]
        used_names, unique, k = set(self.values()), plain, 2
        while unique in used_names:
            unique, k = f"{plain}_{k}", k + 1
        self[name] = unique
        return unique


def _study_parquet(study: Study, path: Path) -> None:
    write_parquet(path, study.table_columns(), study.attributes, ".csv or .nc")


RESULT_FORMATS: dict[str, Callable[[Selection, Path], None]] = {
    ".csv": _csv, ".xlsx": _workbook, ".mat": _matlab, ".nc": _netcdf, ".nc4": _netcdf, ".h5": _netcdf,
    ".parquet": _parquet,
}  # fmt: skip
STUDY_FORMATS: dict[str, Callable[[Study, Path], None]] = {
    ".csv": _csv,
    ".xlsx": _workbook,
    ".nc": _netcdf,
    ".parquet": _study_parquet,
}
