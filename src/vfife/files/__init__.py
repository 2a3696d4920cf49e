"""Files on disk: written as a whole under a random name, read only where they are regular and of bounded
size.

A name such as ``model.toml.part`` can be guessed. Whoever may write into the folder could plant a link of
that name, and a write through it would leave the folder. A temporary file is therefore created exclusively
(O_EXCL, O_NOFOLLOW) and has a random name. A device, a pipe or a socket in the place of a file would never
end, or never begin: :func:`read_bytes` refuses both.
"""

from __future__ import annotations

import errno
import math
import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO

from ..errors import Fault, ModelError, kind_of, shown

if TYPE_CHECKING:
    import pandas

# A model file of a thousand bodies has some 300 kB. A file a hundred times larger is no model file.
LARGEST = 32_000_000
# Attempts to find a free random name of 64 bits; a second one is never needed unless the folder is hostile.
ATTEMPTS = 16
# Temporary files that this process has begun and not finished, for signals that leave no time to unwind.
UNFINISHED: set[Path] = set()
# Model files of the gallery: a wheel holds a copy of the folder examples/, which in a checkout lies beside
# src.
_EXAMPLES = Path(__file__).resolve().parent.with_name("examples")
GALLERY = _EXAMPLES if _EXAMPLES.is_dir() else _EXAMPLES.parents[2] / "examples"
KINDS = (
    (stat.S_ISDIR, errno.EISDIR, "it is a folder"),
    (stat.S_ISFIFO, errno.EINVAL, "it is a pipe, not a regular file"),
    (stat.S_ISSOCK, errno.EINVAL, "it is a socket, not a regular file"),
    (stat.S_ISCHR, errno.EINVAL, "it is a device, not a regular file"),
    (stat.S_ISBLK, errno.EINVAL, "it is a device, not a regular file"),
)


def path_of(value: object, function: str) -> Path:
    """Return an argument of a public ``function`` as a path. Raises ModelError if it is none."""
    if not isinstance(value, str | os.PathLike):
        fault = Fault("path", f"this is {kind_of(value)}", shown(value), "the name of a file", "name one")
        raise ModelError([fault], f"{function}()")
    return Path(value)


@contextmanager
def replacement(path: Path) -> Iterator[Path]:
    """Yield an empty temporary file beside ``path``, which takes its place when the block ends without an
    error.

    The file reaches the disk before it is renamed, so that a crash leaves the old file or the new one. Raises
    OSError where the folder cannot be written to; then, and after an error in the block, the old file is
    unchanged.
    """
    temporary = create_temporary(path)
    UNFINISHED.add(temporary)
    try:
        yield temporary
        with temporary.open("rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        UNFINISHED.discard(temporary)


def create_temporary(path: Path) -> Path:
    """Create an empty file with a random name in the folder of ``path``; return its name. Raises OSError."""
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
    for _ in range(ATTEMPTS):
        # The whole name stays within the 255 bytes of a file system, however long that of the file is.
        temporary = path.with_name(f".{path.name[:50]}.{os.urandom(8).hex()}.part")
        try:
            os.close(os.open(temporary, flags, 0o666))
        except FileExistsError:
            continue
        return temporary
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))


def remove_unfinished() -> None:
    """Remove the temporary files of this process."""
    for temporary in list(UNFINISHED):
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


@contextmanager
def text_stream(path: Path, newline: str | None = None) -> Iterator[TextIO]:
    """Yield a stream that writes a text file (UTF-8): afterwards there is the old file or the new one, never
    a part of it.

    A terminal or pipe, as in ``-o /dev/stdout``, is written to directly. Raises OSError.
    """
    if path.exists() and not path.is_file():
        with path.open("w", encoding="utf-8", newline=newline) as stream:
            yield stream
        return
    with replacement(path) as temporary, temporary.open("w", encoding="utf-8", newline=newline) as stream:
        yield stream


def write_text(path: Path, text: str, newline: str | None = None) -> None:
    """Write a text file whole or not at all, as :func:`text_stream` does."""
    with text_stream(path, newline) as stream:
        stream.write(text)


def read_bytes(path: str | Path, largest: int = LARGEST) -> bytes:
    """Return the bytes of a regular file of at most ``largest`` bytes.

    The kind is that of the opened file, so a name that is exchanged meanwhile cannot deceive; a pipe is
    opened without waiting for a writer. Raises OSError, whose ``strerror`` says what the file is instead or
    how large it is.
    """
    with open_regular(path) as stream:
        data = stream.read(largest + 1)
    if len(data) > largest:
        raise OSError(errno.EFBIG, f"it has more than {largest / 1e6:g} MB", str(path))
    return data


def open_regular(path: str | Path) -> BinaryIO:
    """Open a regular file for reading. Raises OSError as :func:`read_bytes` does."""
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        require_regular(os.fstat(descriptor), path)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def require_regular(status: os.stat_result, path: str | Path) -> None:
    """Raise OSError with the kind of a file that is not regular; ``status`` is that of ``path``."""
    for is_kind, number, words in KINDS:
        if is_kind(status.st_mode):
            raise OSError(number, words, str(path))


def free_bytes(path: Path) -> int | None:
    """Return the free bytes of the disk of a file that exists or is to be written; None if unknown."""
    for place in (path, *path.absolute().parents):
        with suppress(OSError):
            return shutil.disk_usage(place).free
    return None


def write_rows(path: str | Path, rows: Iterable[Iterable[Any]], decimal: str = "point") -> None:
    """Write rows as CSV, heads first: numbers to the last bit, line ends by RFC 4180 on every machine;
    numbers below :data:`SMALLEST` are zero.

    With a ``decimal`` "comma" semicolons separate the values, a mark of UTF-8 begins the file, as
    spreadsheets of many countries expect, and numbers are rounded for readers as by
    :func:`rounded_rows`. An existing file is replaced when the new one is complete. Raises
    OSError.
    """
    import csv

    with text_stream(Path(path), newline="") as stream:
        if decimal == "comma":
            stream.write("\ufeff")
            csv.writer(stream, delimiter=";").writerows(map(_with_commas, rounded_rows(rows)))
        else:
            csv.writer(stream).writerows(map(_without_remainders, rows))


# Numbers below are remainders of rounding, as of forces that cease; spreadsheets read some of them as text.
# NetCDF, Parquet, MATLAB and JSON have them as they are.
SMALLEST = 1e-300
# Digits of numbers in tables for readers of spreadsheets. CSV with decimal points, NetCDF, Parquet, MATLAB
# and JSON have all digits, because programs read them back.
DIGITS = 7
# Outputs of a long run lie close together on its axis of time.
DIGITS_OF_TIME = 10
TIMES = ("time [s]", "load_factor")
# Decimals of an angle: 3.4e-13 degrees is the 0 of an angle that was reduced to one turn.
DECIMALS_OF_ANGLES = 6
ANGLE = "[deg]"


def rounded_rows(rows: Iterable[Iterable[Any]]) -> Iterator[Iterable[Any]]:
    """Yield the heads of a table, then its rows with numbers of :data:`DIGITS` digits, times of a few more;
    angles in degrees are rounded to millionths, so that multiples are exact. Other cells are unchanged.
    """
    remaining = iter(rows)
    heads = next(remaining, None)
    if heads is None:
        return
    heads = list(heads)
    yield heads
    kinds = [(DIGITS_OF_TIME if head in TIMES else DIGITS, str(head).endswith(ANGLE)) for head in heads]
    for row in remaining:
        # A row may be longer than its heads.
        yield [
            _rounded(value, *kind) if isinstance(value, float) else value
            for value, kind in zip(row, chain(kinds, repeat((DIGITS, False))), strict=False)
        ]


def _rounded(value: float, digits: int, angle: bool) -> float:
    """Return a number with a count of digits; zero without a sign, also for one below :data:`SMALLEST`."""
    if not math.isfinite(value):
        return value
    if abs(value) < SMALLEST:
        return 0.0
    return float(f"{round(value, DECIMALS_OF_ANGLES) if angle else value:.{digits}g}") + 0.0


def _without_remainders(row: Iterable[Any]) -> list[Any]:
    return [0.0 if isinstance(value, float) and 0.0 < abs(value) < SMALLEST else value for value in row]


def _with_commas(row: Iterable[Any]) -> list[Any]:
    return [str(float(value)).replace(".", ",") if isinstance(value, float) else value for value in row]


def with_decimal_points(rows: Sequence[list[str]], delimiter: str) -> Sequence[list[str]]:
    """Return the rows of a CSV file with decimal points in place of decimal commas, which may be in columns
    without any point where commas do not separate the columns.
    """
    if delimiter == ",":
        return rows
    points = {k for row in rows for k, cell in enumerate(row) if "." in cell}
    return [[cell if k in points else cell.replace(",", ".") for k, cell in enumerate(row)] for row in rows]


def remedy_of_row(cells: int, columns: int, delimiter: str) -> str:
    """Return the remedy for a row with another number of cells than columns, as 1,5 has where commas separate
    cells.
    """
    if delimiter == "," and cells > columns:
        return "give each column one; for decimal commas, as in 1,5, separate the columns with semicolons"
    return "give each column one"


def write_tables(path: str | Path, tables: Mapping[str, Iterable[Iterable[Any]]]) -> None:
    """Write tables by the titles of their sheets as a workbook (.xlsx), numbers rounded for readers as by
    :func:`rounded_rows`. Raises VfifeError for a table too large for a sheet, OSError.
    """
    from .workbook import write_workbook

    with replacement(Path(path)) as temporary, temporary.open("wb") as stream:
        write_workbook(stream, {title: rounded_rows(rows) for title, rows in tables.items()})


class DataTable:
    """Base of results with a table: :meth:`table` yields its heads, then its rows."""

    @property
    def progress(self) -> str:
        """How much is computed, as in "12 of 100 values"; empty for a complete result."""
        return ""

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield the heads of the columns, then every row."""
        raise NotImplementedError

    def spreadsheet(self) -> Iterator[Sequence[Any]]:
        """Yield the table as readers of spreadsheets want it, by default the same."""
        return self.table()

    def write_csv(self, path: str | Path, decimal: str = "point") -> None:
        """Write the table as CSV.

        path: the file; an existing one is replaced when the new one is complete
        decimal: "comma" for decimal commas, with semicolons between the values

        Raises OSError.
        """
        write_rows(path, self.spreadsheet(), decimal)

    def tables(self) -> dict[str, Iterable[Sequence[Any]]]:
        """Return the tables of a workbook by the titles of their sheets."""
        return {type(self).__name__: self.spreadsheet()}

    def write_table(self, path: str | Path, decimal: str = "point") -> None:
        """Write the table as CSV or as a workbook.

        path: the file; a workbook if its name ends in ``.xlsx``
        decimal: "comma" for decimal commas in CSV

        Raises VfifeError for a table too large for a sheet, OSError.
        """
        if Path(path).suffix.lower() == ".xlsx":
            write_tables(path, self.tables())
        else:
            self.write_csv(path, decimal)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table for pandas, with numbered rows. Its ``attrs`` tell whether the result is
        ``complete``, and how much of another one is ``computed``.
        """
        import pandas

        heads, *rows = self.table()
        return with_completeness(pandas.DataFrame(rows, columns=list(heads)), self.progress)


def share_done(done: float, planned: float, noun: str) -> str:
    """Return how many of the planned things are done as text; empty if all are."""
    return "" if done >= planned else f"{done:,.0f} of {planned:,.0f} {noun}"


def with_completeness(frame: pandas.DataFrame, progress: str) -> pandas.DataFrame:
    """Return a table, whose ``attrs`` tell whether it is ``complete`` or how much is ``computed``."""
    frame.attrs |= {"complete": not progress} | ({"computed": progress} if progress else {})
    return frame


def named_rows(rows: Sequence[dict[str, Any]]) -> Iterator[Sequence[Any]]:
    """Yield the heads and rows of maps by column; what a map lacks is None."""
    heads = list(dict.fromkeys(key for row in rows for key in row))
    yield heads
    for row in rows:
        yield [row.get(head) for head in heads]
