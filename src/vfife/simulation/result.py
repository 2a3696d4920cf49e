"""The result of a run: its view, what a summary and pictures make of it, and files that keep it."""

from __future__ import annotations

import dataclasses
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import RunFileError, StorageError
from ..files import replacement
from ..results.provenance import (
    companion_rows_of,
    companions_meta,
    final_state,
    keep_reference,
    provenance,
    restored,
    restored_companions,
    versions,
)
from ..results.view import View
from ..solvers.record import Estimate, Record, Rows, lasting_rows
from ..store.connections import unwritten
from ..store.runfile import RunFile
from ..store.schemas import is_run_file
from ..store.store import warn_of_damage

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.figure import Figure

    from ..live.page.page import Live


class Result(View):
    """What a run gives: see :class:`~vfife.results.view.View` for its numbers; pictures, summary and files
    are here.

    ``record`` holds the rows, ``reference`` is the result of the ideal mechanism or None.
    """

    reference: Result | None

    def __init__(self, record: Record, reference: Result | None = None) -> None:
        super().__init__(record, reference)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """All that a summary says, as dictionaries, lists, texts and numbers."""
        from ..report.summary import run_summary

        return run_summary(self)

    def __str__(self) -> str:
        from ..report.summary import summary_text

        return summary_text(self)

    # -------------------------------------------------------------------------------------------------- files

    def to_netcdf(self, path: str | Path) -> None:
        """Writes the dataset as NetCDF-4; a file that is there gives way when the new one is whole. Raises
        OSError where it cannot be written.
        """
        from ..results.export import write_netcdf

        write_netcdf(self.data, Path(path))

    def export(self, path: str | Path, figure: str | None = None) -> None:
        """Writes all channels with their units, or a figure, in the format that the file's ending says; what
        is there gives way when it is whole.

        Data: ``.csv``, ``.nc`` (NetCDF), ``.mat`` (MATLAB), ``.parquet`` (with pyarrow). Figures: ``.svg``,
        ``.pdf``, ``.png``; ``figure`` names one, as :meth:`plot` does, where the file is not called by its
        name. Raises VfifeError for another ending or figure, OSError.
        """
        from ..results.export import RESULT_FORMATS, export

        path = Path(path)
        if path.suffix.lower() in RESULT_FORMATS and figure is None:
            export(self, path, RESULT_FORMATS, "no data are")
            return
        from ..plots import save_one

        save_one(self, figure, path, RESULT_FORMATS)

    def save(self, path: str | Path) -> None:
        """Writes a run file that :meth:`load` reads; one that is there already gives way when the new one is
        whole.
        """
        path = Path(path)
        meta = self._meta()
        if path.exists() and not is_run_file(path):
            raise RunFileError(
                f"{path}: there is another file of this name, which is no run file of vfife; name another one"
            )
        try:
            with replacement(path) as temporary, RunFile.create(temporary, meta, replace=True) as file:
                self.finish(file)
        except OSError as error:
            raise StorageError(unwritten(path, f"no run file can be made here ({error.strerror})")) from error

    def finish(self, file: RunFile) -> None:
        """Ends a run file: what it does not have yet of the model, outputs, last state and reference, how the
        run ended, and its summary.
        """
        record = self.record
        missing = slice(file.outputs_so_far, None)
        if missing.start < len(record.steps):
            file.append(
                record.steps[missing],
                record.rows[missing],
                companion_rows_of(record) if missing.start == 0 else None,
            )
        if record.final is not None and (file.last_checkpoint() or (None,))[0] != record.steps[-1]:
            file.checkpoint(int(record.steps[-1]), record.final[lasting_rows(record.assembly.layout)])
        if self.reference is not None and not file.has_reference:
            keep_reference(file, self.reference.record)
        meta = {} if file.knows("meta", "kept") else self._meta()
        if record.estimate is not None:
            meta["estimate"] = dataclasses.asdict(record.estimate)
        file.finish(
            record.status, self.summary, **meta, wall=record.wall, loop=record.loop, message=record.message
        )

    def _meta(self) -> dict[str, Any]:
        record, left = self.record, self.record.companions
        meta = provenance(record.assembly, record.kept, record.loop)
        return (
            meta
            if left is None
            else meta | companions_meta(record.assembly, left.counts, left.earlier, left.kept)
        )

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """The result that a run file, or the run file in a folder, holds; also that of a run that was killed.

        Raises RunFileError where there is no such file, or it is damaged or of another kind.
        """
        with RunFile.open(path) as file:
            result = cls.of(file)
        warn_of_damage(
            file.path, "run", result.record.lost, "Run the model again, or take a copy of the file."
        )
        return result

    @classmethod
    def of(cls, file: RunFile) -> Result:
        """The result that an open run file holds."""
        where, meta, last = str(file.path), file.meta, file.last_checkpoint()
        alone = file.finished_steps()
        result = cls(
            restored(meta, *file.outputs(), where)
            if alone is None
            else restored(meta, alone, file.later(), where)
        )
        record = result.record
        if alone is not None:
            record.source = partial(_read, record, file.path.absolute())
            if meta.get("summary") and meta["versions"] == versions(record.loop):
                result.__dict__["summary"] = meta[
                    "summary"
                ]  # what it was told at its end; to tell it again, every output would be read
        record.estimate = Estimate(**meta["estimate"]) if "estimate" in meta else None
        record.companions = restored_companions(file, record)
        record.reached = int(record.steps[-1]) if last is None else max(last[0], int(record.steps[-1]))
        if last is not None and last[0] == record.steps[-1]:
            record.final = final_state(meta, record.assembly, last[1], where)
        reference = file.reference()
        if reference is not None:
            result.reference = cls(restored(*reference, where=where))
        record.lost = file.lost
        return result

    # -------------------------------------------------------------------------------------------------------
    # pictures

    def _repr_html_(self) -> str:
        """What a notebook shows: the summary and figures."""
        from ..plots.notebook import result_html

        return result_html(self)

    def plot(self, *names: str, at: str | None = None) -> dict[str, Figure]:
        """Figures by name: without ``names`` the usual ones, as the mechanism, journal paths, forces and
        accelerations over the ideal ones.

        ``names``: of "mechanism", "orbits", "guides", "forces", "moments", "accelerations", "strip",
        "traces", "polar", "phase", "spectrum", "waterfall", "spectrogram", "envelope", "energy", "stress",
        "deflection"; "all" that the result has something for. ``at``: the mechanism alone, at a moment as
        "90deg" of the last turn, or "12 ms". Raises VfifeError for another name, a figure that there is
        nothing for, and what is no moment of the run.
        """
        from ..plots import figure, figures, only_mechanism

        if at is not None:
            only_mechanism(names)
            return {"mechanism": figure(self, "mechanism", at=at)}
        return figures(self, self.reference, names)

    def animate(self, path: str | Path, frames: int = 240, rate: float = 25.0, turns: float = 1.0) -> None:
        """Writes a film of the mechanism as it moves, its play drawn larger, with the largest joint forces
        beside it, as ``.gif`` or ``.mp4``.

        Shows the last ``turns`` turns of the crank, without one the whole run, in as many ``frames`` or as
        there are outputs, ``rate`` of them a second; what is there gives way when the film is whole. MP4
        takes the extra ``video``. Raises VfifeError for another ending and numbers out of range, StorageError
        and OSError where it cannot be written.
        """
        from ..plots.filmfiles import animate

        animate(self, Path(path), frames, rate, turns)

    if TYPE_CHECKING:  # attached by vfife.methods

        def live(self, slide: Iterable[str] | None = ()) -> Live: ...
        def report(self, path: str | Path, running: bool = True) -> None: ...


def _read(record: Record, path: Path) -> Rows:
    """The outputs of a large file, where they are asked for; those that are damaged are left out, and told
    from then on.
    """
    with RunFile.open(path) as file:
        record.steps, rows = file.outputs()
        record.lost = file.lost
    warn_of_damage(path, "run", record.lost, "Run the model again, or take a copy of the file.")
    if rows.shape[1] != len(record.kept):
        raise RunFileError(
            f"{path}: {rows.shape[1]} rows were recorded and {len(record.kept)} are named; run the model"
            " again"
        )
    return rows


def load_result(path: str | Path) -> Result:
    """The result that a run file, or the run file in a folder, holds; also that of a run that was killed.

    Nothing is assembled and no law's text is run. Raises RunFileError where there is no such file, or it is
    damaged or of another kind.
    """
    return Result.load(path)


__all__ = ["Result", "RunFileError", "load_result"]
