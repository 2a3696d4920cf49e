"""A study in the files of other programs: a row a member as CSV or Parquet, the labelled dataset as NetCDF. Each is whole or not there."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import VfifeError
from .netcdf import write_netcdf
from .studied import Study
from .whole import whole

EXTRA = 'Parquet is written by pyarrow, which is not installed here: pip install "vfife[parquet]", or write .csv or .nc'


def write(study: Study, path: Path) -> None:
    """Writes a study in the format that the file's ending names. Raises VfifeError for another, OSError."""
    writer = FORMATS.get(path.suffix.lower())
    if writer is None:
        known = f"{', '.join(list(FORMATS)[:-1])} and {list(FORMATS)[-1]}"
        raise VfifeError(f'{path}: no study is written as "{path.suffix or path.name}"; endings that say a format are {known}')
    if not path.absolute().parent.is_dir():
        raise VfifeError(f"{path}: there is no folder {path.absolute().parent}; make it first")
    writer(study, path)


def units(study: Study) -> dict[str, str]:
    """Units by column, of those that have one."""
    found = {**{one.name: one.unit for one in study.parameters}, **study.measures, "step": "s"}
    return {name: unit for name, unit in found.items() if unit != "1"}


def _csv(study: Study, path: Path) -> None:
    """A line of names with units, then one for each member, numbers to the last bit."""
    rows, known = study.rows(), units(study)
    names = study.columns
    with whole(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        lines = csv.writer(stream)
        lines.writerow(f"{name} [{known[name]}]" if name in known else name for name in names)
        lines.writerows([row[name] for name in names] for row in rows)


def _parquet(study: Study, path: Path) -> None:
    """One column each, with its unit in its metadata."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise VfifeError(f"{path}: {EXTRA}") from None
    rows, known = study.rows(), units(study)
    kinds: dict[str, Any] = {"member": pyarrow.int64(), "status": pyarrow.string(), "reason": pyarrow.string()}
    kinds |= {name: pyarrow.int64() for name in ("turns", "settled")} | {name: pyarrow.float64() for name in (*study.measures, "step")}
    columns = {name: [row[name] for row in rows] for name in study.columns}
    arrays = [pyarrow.array(values, kinds.get(name)) for name, values in columns.items()]
    fields = [pyarrow.field(name, array.type, metadata={"units": known.get(name, "1")}) for name, array in zip(columns, arrays, strict=True)]
    schema = pyarrow.schema(fields, metadata={key: str(value) for key, value in study.attributes.items()})
    with whole(path) as part:
        pyarrow.parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=schema), part)


def _netcdf(study: Study, path: Path) -> None:
    write_netcdf(study.data, path)


FORMATS: dict[str, Callable[[Study, Path], None]] = {".csv": _csv, ".nc": _netcdf, ".parquet": _parquet}
