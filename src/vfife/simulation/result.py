"""The result of a run: its numbers, summary, pictures and files."""

from __future__ import annotations

import dataclasses
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import RunFileError, StorageError, VfifeError
from ..files import path_of, replacement
from ..options import with_faults
from ..results.export import RESULT_FORMATS, check_decimal, export, write_netcdf
from ..results.provenance import (
    companion_rows_of,
    companions_meta,
    final_state,
    keep_reference,
    last_state,
    provenance,
    restored,
    restored_companions,
    versions,
)
from ..results.run_data import RunData
from ..results.selection import selection
from ..solvers.record import Estimate, Record, Rows, lasting_rows
from ..solvers.status import Status
from ..store.connections import unwritten, warn_of_damage
from ..store.runfile import RunFile
from ..store.schemas import is_run_file

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.figure import Figure

    from ..live.page.page import Live


class Result(RunData):
    """Result of a run: numbers as in :class:`~vfife.results.run_data.RunData`, and summary, pictures and
    files.

    ``record`` has the recorded rows; ``reference`` is the result of the ideal mechanism or None.
    ``arguments`` of the run, for JSON, from which :func:`~vfife.resume` goes on.
    """

    reference: Result | None

    def __init__(
        self, record: Record, reference: Result | None = None, arguments: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(record, reference)
        self.arguments = {} if arguments is None else dict(arguments)

    @property
    def status(self) -> Status:
        """How the run ended, as a text: "complete", "interrupted", "diverged", ..."""
        return self.record.status

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Content of the printed summary as dictionaries, lists, texts and numbers."""
        from ..report.summary import run_summary

        return run_summary(self)

    def __str__(self) -> str:
        from ..report.summary import summary_text

        return summary_text(self)

    # -------------------------------------------------------------------------------------------------- files

    def to_netcdf(self, path: str | Path) -> None:
        """Write the dataset as NetCDF-4.

        path: the file; an existing one is replaced when the new one is complete

        Raises OSError.
        """
        write_netcdf(self.data, path_of(path, "to_netcdf"))

    def export(
        self, path: str | Path, figure: str | None = None, decimal: str = "point", *,
        channels: str | Iterable[str] | None = None, turns: str | int | Sequence[int] | None = None,
        by_angle: bool = False,
    ) -> None:  # fmt: skip
        """Write channels with their units, or a figure, in the format of the file's extension.

        path: ``.csv``, ``.xlsx``, ``.nc`` (NetCDF), ``.mat`` (MATLAB) or ``.parquet`` (needs pyarrow) for
        channels, ``.svg``, ``.pdf`` or ``.png`` for a figure; an existing file is replaced when the new one
        is complete
        figure: name of the figure as in :meth:`plot`, by default the name of the file
        decimal: "comma" for a CSV file with decimal commas, separated by semicolons
        channels: names ("C.force") or patterns ("*.force") of series, or names of joints, bodies and springs;
        by default all. In NetCDF a channel has all its joints or bodies
        turns: turns of the crank, as 60, (59, 60), "59..60" or "last"; by default all outputs
        by_angle: True for one turn (the last, unless ``turns`` names one) in the order of the crank's angle

        Raises VfifeError for an unknown extension, figure, channel or turn, and for a decimal comma in
        another format than CSV; OSError.
        """
        path = path_of(path, "export")
        if path.suffix.lower() in RESULT_FORMATS and figure is None:
            export(selection(self, channels, turns, by_angle), path, RESULT_FORMATS, "no data are", decimal)
            return
        if channels is not None or turns is not None or by_angle:
            raise VfifeError(
                f"{path}: channels and turns are chosen for data, not for a figure; leave them out"
            )
        check_decimal(decimal, path)
        from ..plots import save_one

        save_one(self, figure, path, RESULT_FORMATS)

    def save(self, path: str | Path) -> None:
        """Write a run file for :meth:`load`.

        path: the file; an existing run file is replaced when the new one is complete

        Raises RunFileError for an ending of another format such as .csv, and if another kind of file has this
        name, StorageError if the file cannot be written.
        """
        path = path_of(path, "save")
        if path.suffix.lower() in RESULT_FORMATS:
            raise RunFileError(
                f"{path}: save() writes a run file, which no other program reads; for {path.suffix} use"
                " export(), or give the run file another ending"
            )
        meta = self._meta()
        if path.exists() and not is_run_file(path):
            raise RunFileError(
                f"{path}: a file of this name exists that is not a run file of vfife; choose another name"
            )
        try:
            with replacement(path) as temporary, RunFile.create(temporary, meta, replace=True) as file:
                self.finish(file)
        except OSError as error:
            raise StorageError(unwritten(path, f"no run file can be made here ({error.strerror})")) from error

    def finish(self, file: RunFile) -> None:
        """Complete a run file with whatever it lacks: model, outputs, last state, reference, status and
        summary.
        """
        record = self.record
        missing = slice(file.outputs_so_far, None)
        if missing.start < len(record.steps):
            file.append(
                record.steps[missing],
                record.rows[missing],
                companion_rows_of(record) if missing.start == 0 else None,
            )
        last = (file.last_checkpoint() or (None,))[0]
        if record.checkpoint is not None and last != record.checkpoint.step:
            # That of all lanes: the companions go on as well when the run is resumed.
            file.checkpoint(record.checkpoint.step, record.checkpoint.values, record.checkpoint.extra)
        elif record.checkpoint is None and record.final is not None and last != record.steps[-1]:
            file.checkpoint(int(record.steps[-1]), record.final[lasting_rows(record.assembly.layout)])
        if self.reference is not None and not file.has_reference:
            keep_reference(file, self.reference.record)
        meta = {} if file.knows("meta", "kept") else self._meta()
        if record.estimate is not None:
            meta["estimate"] = dataclasses.asdict(record.estimate)
        if record.snaps:
            meta["snaps"] = record.snaps
        if record.unstable:
            meta["unstable"] = record.unstable
        file.finish(
            record.status, self.summary, **meta, wall=record.wall, loop=record.loop, message=record.message
        )

    def _meta(self) -> dict[str, Any]:
        """Return the metadata of a run file."""
        record, left = self.record, self.record.companions
        meta = provenance(record.assembly, record.row_numbers, record.loop) | (
            {"asked": self.arguments} if self.arguments else {}
        )
        return (
            meta
            if left is None
            else meta
            | companions_meta(record.assembly, left.counts, left.earlier, left.tries, left.row_numbers)
        )

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Return the result of a run file; a killed run has the outputs written.

        path: the run file, or its folder

        Raises RunFileError if there is no such file, or if it is damaged or of another kind.
        """
        with RunFile.open(path) as file:
            result = cls.of(file)
        warn_of_damage(
            file.path, "run", result.record.damaged_parts, "Run the model again, or use a backup of the file."
        )
        return result

    @classmethod
    def of(cls, file: RunFile) -> Result:
        """Return the result of an open run file."""
        place, meta, last = str(file.path), file.meta, file.last_checkpoint()
        alone = file.finished_steps()
        result = cls(
            restored(meta, *file.outputs(), place)
            if alone is None
            else restored(meta, alone, file.later(), place)
        )
        record = result.record
        result.arguments = dict(meta.get("asked", {}))
        if alone is not None:
            record.source = partial(_read, record, file.path.absolute())
            if meta.get("summary") and meta["versions"] == versions(record.loop):
                # The stored summary: computing it again would read every output of a large file.
                result.__dict__["summary"] = meta["summary"]
        record.estimate = Estimate(**meta["estimate"]) if "estimate" in meta else None
        record.companions = restored_companions(file, record)
        record.reached = int(record.steps[-1]) if last is None else max(last[0], int(record.steps[-1]))
        if last is not None and last[0] == record.steps[-1]:
            record.final = final_state(meta, record.assembly, last[1], place)
        record.checkpoint = last_state(file, record)
        reference = file.reference()
        if reference is not None:
            result.reference = cls(restored(*reference, place=place))
        record.damaged_parts = file.damaged_parts
        return result

    # ----------------------------------------------------------------------------------------------- pictures

    def _repr_html_(self) -> str:
        """Return summary and figures for a notebook."""
        from ..plots.notebook import result_html

        return result_html(self)

    def plot(
        self,
        *names: str,
        at: str | None = None,
        other: Result | Sequence[Result] = (),
        labels: Sequence[str] = (),
    ) -> dict[str, Figure]:
        """Return figures by name; without ``names`` the usual ones: mechanism, journal paths, forces and
        accelerations over the ideal ones.

        ``names``: some of "mechanism", "orbits", "guides", "forces", "moments", "accelerations", "strip",
        "traces", "polar", "phase", "spectrum", "waterfall", "spectrogram", "envelope", "energy", "stress",
        "deflection", or "all" for those that the result has data for. ``at``: the mechanism alone at a
        moment, as "90deg" of the last turn, or "12 ms". ``other``: one or several results that are drawn into
        the same panels, over the crank angle where there is a crank; ``labels`` name the runs in the legend,
        by default by the parameters in which their models differ. Raises VfifeError for an unknown name, a
        figure without data, one that cannot be overlaid, and a moment outside the run.
        """
        from ..plots import figure, figures, only_mechanism, overlays

        if results := [other] if isinstance(other, Result) else [*other]:
            if at is not None:
                raise VfifeError("at: the mechanism is drawn at a moment of one run; leave out the others")
            return overlays([self, *results], names, labels)
        if at is not None:
            only_mechanism(names)
            return {"mechanism": figure(self, "mechanism", at=at)}
        return figures(self, self.reference, names)

    def animate(self, path: str | Path, frames: int = 240, rate: float = 25.0, turns: float = 1.0) -> None:
        """Write a film of the mechanism, with enlarged clearances and the largest joint forces.

        path: the file, ``.gif`` or ``.mp4`` (needs the extra ``video``); an existing file is replaced when
        the film is complete
        frames: largest number of pictures
        rate: pictures per second
        turns: number of last turns of the crank that are shown; without a crank the whole run is

        Raises VfifeError for another extension and numbers out of range, StorageError and OSError if the file
        cannot be written.
        """
        from ..plots.filmfiles import animate

        animate(self, path_of(path, "animate"), frames, rate, turns)

    if TYPE_CHECKING:  # attached by vfife.methods

        def live(self, slide: Iterable[str] | None = ()) -> Live:
            """See :func:`vfife.methods.live_result`."""

        def report(
            self, path: str | Path, running: bool = True, author: str = "", logo: str | Path | None = None
        ) -> tuple[str, ...]:
            """See :func:`vfife.methods.report`."""


def _read(record: Record, path: Path) -> Rows:
    """Read the outputs of a large file when they are first needed, without damaged ones, which are
    reported.
    """
    with RunFile.open(path) as file:
        record.steps, rows = file.outputs()
        record.damaged_parts = file.damaged_parts
    warn_of_damage(path, "run", record.damaged_parts, "Run the model again, or use a backup of the file.")
    if rows.shape[1] != len(record.row_numbers):
        raise RunFileError(
            f"{path}: {rows.shape[1]} rows were recorded and {len(record.row_numbers)} are named; run the"
            " model again"
        )
    return rows


@with_faults()
def load_result(path: str | Path) -> Result:
    """Return the result of a run file; a killed run has the outputs written.

    path: the run file, or its folder

    Nothing is assembled, and no text of a law is executed. Raises RunFileError if there is no such file, or
    if it is damaged or of another kind.
    """
    return Result.load(path)


__all__ = ["Result", "RunFileError", "load_result"]
