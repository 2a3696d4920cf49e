"""A study in the files of other programs: a row a member as CSV or Parquet, the labelled dataset as NetCDF. Each is whole or not there."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..files import replacement
from .formats import arrow, write_as, write_parquet
from .netcdf import write_netcdf
from .studied import Study


def write(study: Study, path: Path) -> None:
    """Writes a study in the format that the file's ending names. Raises VfifeError for another, OSError."""
    write_as(study, path, FORMATS, "no study is")


def units(study: Study) -> dict[str, str]:
    """Units by column, of those that have one."""
    found = {**{one.name: one.unit for one in study.parameters}, **study.measures, "step": "s"}
    return {name: unit for name, unit in found.items() if unit != "1"}


def _csv(study: Study, path: Path) -> None:
    """A line of names with units, then one for each member, numbers to the last bit."""
    rows, known = study.rows(), units(study)
    names = study.columns
    with replacement(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        lines = csv.writer(stream)
        lines.writerow(f"{name} [{known[name]}]" if name in known else name for name in names)
        lines.writerows([row[name] for name in names] for row in rows)


def _parquet(study: Study, path: Path) -> None:
    """One column each, with its unit in its metadata."""
    pyarrow = arrow(path, ".csv or .nc")
    rows, known = study.rows(), units(study)
    kinds: dict[str, Any] = {"member": pyarrow.int64(), "status": pyarrow.string(), "reason": pyarrow.string()}
    kinds |= {name: pyarrow.int64() for name in ("turns", "settled")} | {name: pyarrow.float64() for name in (*study.measures, "step")}
    arrays = ((name, pyarrow.array([row[name] for row in rows], kinds.get(name))) for name in study.columns)
    write_parquet(path, pyarrow, ((name, array, about(study, name, known)) for name, array in arrays), study.attributes)


def about(study: Study, name: str, known: dict[str, str]) -> dict[str, str]:
    """What the metadata of a column say: its unit, and of a measure the numerical error of a member."""
    return {"units": known.get(name, "1"), **{key: str(value) for key, value in study.said_error(name).items()}}


def _netcdf(study: Study, path: Path) -> None:
    write_netcdf(study.data, path)


FORMATS: dict[str, Callable[[Study, Path], None]] = {".csv": _csv, ".nc": _netcdf, ".parquet": _parquet}
