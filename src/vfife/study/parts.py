"""Runs of a comparison that are complete, kept in its folder until all are: one that was broken off goes on after them."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path

from ..errors import RunFileError
from ..result import Result
from ..results.header import is_run_file
from ..simulation import Prepared
from ..solvers.status import Status

NAME = "part-{}.sqlite"


class Parts:
    """The complete runs in a folder, each under a name that is made of its model, of what was asked, and of the text of the step."""

    def __init__(self, folder: str | Path | None) -> None:
        self.folder = None if folder is None else Path(folder)

    def path(self, folder: Path, one: Prepared) -> Path:
        """Where a run is kept."""
        meta = one.kept
        told = [meta["model"], sorted(meta["asked"].items()), meta["versions"], one.companions]
        return folder / NAME.format(hashlib.blake2b(repr(told).encode(), digest_size=10).hexdigest())

    def found(self, one: Prepared) -> Result | None:
        """A run that was made before; None where there is none, or it is damaged."""
        if self.folder is None or not (path := self.path(self.folder, one)).is_file():
            return None
        with suppress(RunFileError):
            result = Result.load(path)
            if not result.record.lost and result.record.status == Status.COMPLETE:
                result.reference = one.reference
                return result
        return None

    def keep(self, one: Prepared, result: Result) -> None:
        """Keeps a run. Raises StorageError where it cannot be written."""
        if self.folder is not None:
            Result(result.record).save(self.path(self.folder, one))

    def remove(self) -> None:
        """Takes away what was kept, for all of it is told."""
        if self.folder is not None:
            for path in self.folder.glob(NAME.format("*")):
                if is_run_file(path):
                    path.unlink()
