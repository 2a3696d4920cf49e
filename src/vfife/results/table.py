"""Tables as columns with names and units, and their forms: CSV, Parquet, data frames of pandas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..errors import VfifeError
from ..files import replacement

if TYPE_CHECKING:
    import pandas


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
    path: Path, columns: Iterable[Column], attributes: Mapping[str, object], others: str
) -> None:
    """Write columns with their metadata as Parquet; a file that is there is replaced when the new one is
    whole.

    Raises VfifeError, which names ``others``, without pyarrow; OSError.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise VfifeError(
            f"{path}: Parquet is written by pyarrow, which is not installed here: pip install"
            f' "vfife[parquet]", or write {others}'
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
