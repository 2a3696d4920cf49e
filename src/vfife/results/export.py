"""A result in the files of other programs: CSV, Parquet, MATLAB, NetCDF. Each is whole or not there."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..files import replacement
from .formats import arrow, write_as, write_parquet
from .netcdf import write_netcdf
from .series import Column, columns

if TYPE_CHECKING:
    from .view import View

LONGEST_FIELD = 63  # letters of a name in MATLAB


def export(view: View, path: Path) -> None:
    """Writes all channels with their units, in the format that the file's ending names. Raises VfifeError for another, OSError."""
    write_as(view, path, FORMATS, "no data are")


def _netcdf(view: View, path: Path) -> None:
    write_netcdf(view.data, path)


def _csv(view: View, path: Path) -> None:
    """A line of names with units, then one for each output, numbers to the last bit."""
    every = list(columns(view))
    values = [one.values.tolist() for one in every]
    with replacement(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        lines = csv.writer(stream)
        lines.writerow(one.titled for one in every)
        lines.writerows(zip(*values, strict=True))


def _parquet(view: View, path: Path) -> None:
    """One column a series, with unit and meaning in its metadata; elements and particles as well."""
    pyarrow = arrow(path, ".csv, .nc or .mat")
    every = ((one, pyarrow.array(np.ascontiguousarray(one.values))) for one in columns(view, fine=True))
    write_parquet(path, pyarrow, ((one.name, array, {"units": one.unit, "long_name": one.meaning}) for one, array in every), view.attributes)


def _matlab(view: View, path: Path) -> None:
    """A struct with a field for each joint, body and spring, in it a column for each quantity; ``units`` has the same fields, with texts."""
    import scipy.io

    found: dict[str, Any] = {}
    units: dict[str, Any] = {}
    names = Names()
    for one in columns(view, fine=True):
        where, said = (found, units) if not one.owner else (found.setdefault(names[one.owner], {}), units.setdefault(names[one.owner], {}))
        key = names[of_itself(one)]
        where[key], said[key] = np.asarray(one.values, dtype=float), one.unit
    about = {names[key]: value if isinstance(value, float) else str(value) for key, value in view.attributes.items()}
    with replacement(path) as part, part.open("wb") as stream:
        scipy.io.savemat(stream, {"result": found, "units": units, "about": about}, long_field_names=True, oned_as="column", do_compression=True)


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


FORMATS: dict[str, Callable[[View, Path], None]] = {
    ".csv": _csv, ".mat": _matlab, ".nc": _netcdf, ".nc4": _netcdf, ".h5": _netcdf, ".parquet": _parquet,
}  # fmt: skip
