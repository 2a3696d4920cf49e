"""Files of other programs, of a run or a study: the format that an ending names, and what Parquet needs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from ..errors import VfifeError
from ..files import replacement

What = TypeVar("What")


def write_as(what: What, path: Path, formats: Mapping[str, Callable[[What, Path], None]], refused: str) -> None:
    """Writes in the format that the file's ending names. Raises VfifeError for another, which begins with what is ``refused``, and where there is
    no folder; OSError.
    """
    write = formats.get(path.suffix.lower())
    if write is None:
        *some, last = formats
        raise VfifeError(f'{path}: {refused} written as "{path.suffix or path.name}"; endings that say a format are {", ".join(some)} and {last}')
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
            f'{path}: Parquet is written by pyarrow, which is not installed here: pip install "vfife[parquet]", or write {others}'
        ) from None
    return pyarrow


def write_parquet(path: Path, pyarrow: Any, columns: Iterable[tuple[str, Any, Mapping[str, str]]], attributes: Mapping[str, object]) -> None:
    """Writes arrays of ``pyarrow`` by their names, each with its metadata, and attributes of them all; whole or not there. Raises OSError."""
    named = list(columns)
    fields = [pyarrow.field(name, array.type, metadata=told) for name, array, told in named]
    schema = pyarrow.schema(fields, metadata={key: str(value) for key, value in attributes.items()})
    with replacement(path) as part:
        pyarrow.parquet.write_table(pyarrow.Table.from_arrays([array for _, array, _ in named], schema=schema), part)
