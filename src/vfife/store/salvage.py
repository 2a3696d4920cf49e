"""Salvage of a file whose pages do not fit together: its readable rows go into a new file of its name."""

from __future__ import annotations

import itertools
import os
import shutil
from pathlib import Path

from ..errors import StorageError
from .connections import unwritten, warn_at_caller
from .store import TALLY, Store, Values


def salvage(kind: type[Store], path: Path) -> Path | None:
    """Replace a file whose pages do not fit together by one with its intact rows; return the name under which
    the damaged file stays, None where the pages fit together and nothing is changed.

    The caller holds the lock of the file. Raises RunFileError where nothing can be read, StorageError.
    """
    with kind.open(path) as file:
        if file.is_structured:
            return None
        rows, damage = intact_rows(file), "; ".join(file.damage)
    old_file = next(name for name in free_names(path) if not name.exists())
    try:
        try:
            os.link(path, old_file)
        except OSError:  # a file system without links
            shutil.copy2(path, old_file)
    except OSError as error:
        raise StorageError(unwritten(old_file, str(error))) from error

    def fill(file: Store) -> None:
        for table, stored in rows.items():
            for values in stored:
                file.insert_stored(table, values)

    kind.create(path, fill=fill).close()
    warn_at_caller(
        f"{path}: this {kind.schema.kind} file is damaged: {damage}. Its intact rows were copied into a new"
        f" file of this name; the damaged file stays as {old_file}. What is missing is computed again now."
    )
    return old_file


def intact_rows(file: Store) -> dict[str, list[Values]]:
    """Return the values of the intact rows of each table, without the tally, which is counted anew."""
    tables = [table for table in file.schema.tables if file.has(table)]
    return {
        table: [
            row.values
            for key, row in file.read(table)
            if row is not None and not (table == "meta" and key == TALLY)
        ]
        for table in tables
    }


def free_names(path: Path) -> itertools.chain[Path]:
    """Return the names that a damaged file may take beside the new one, without end."""
    first = path.with_name(f"{path.name}.damaged")
    return itertools.chain([first], (first.with_name(f"{first.name}-{k}") for k in itertools.count(2)))
