"""Restart of a run from its file: the prepared run, its last checkpoint, and :func:`resume`."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..assembly.assembled import Assembly
from ..compiler.runtime.cache import sources as sources_of_the_step
from ..files import path_of
from ..job.job import job_of
from ..modelfile import dump
from ..options import named_interrupt, with_faults
from ..results.continuation import extended, refuse_finished
from ..results.provenance import assembly_meta, ranges_of_tries, refuse_displaced
from ..solvers.arguments import Arguments
from ..solvers.record import Checkpoint, Record
from ..solvers.status import Progress, Status
from ..store.connections import located
from ..store.lock import run_lock
from ..store.runfile import RunFile
from ..store.schemas import RUN
from .result import Result
from .simulate import MEASURING, Prepared, run_prepared, show_phase
from .start import RestoredStart, Span, expected_forces


def reopen_run(file: RunFile, until: float | None = None) -> tuple[Prepared, Checkpoint | None]:
    """Return the run of a file, ready to continue, and its last checkpoint; outputs after it are removed.

    ``until``: another end time (s); the step is not changed any more then. Raises ResumeError for a run that
    is complete or whose outputs are damaged.
    """
    place, meta, former, last = str(file.path), file.meta, Result.of(file), file.latest()
    refuse_finished(former.record, until, place)
    refuse_displaced(meta, place)
    record, arguments = former.record, dict(former.arguments)
    companions = dict(meta.get("companions", {}))
    changed: dict[str, Any] = {"status": Status.RUNNING}
    if until is not None:
        record.assembly = extended(record, until, place)
        arguments |= {"turns": None, "duration": until, "searches": False}
        changed |= {
            "model": dump(record.assembly.mechanism),
            "choice": dataclasses.asdict(record.assembly.choice),
            "asked": arguments,
        }
    if last is None:
        file.begin(meta | changed)
    else:
        if companions and last.values.ndim == 1:
            companions = {}
            record.assembly = alone(record, last.step)
            file.leave_companions()
            changed |= {"notes": list(record.assembly.notes), **assembly_meta(record.assembly)}
        file.rewind(last)
        file.put(changed)
        changes = (
            ""
            if arguments.get("sources") == sources_of_the_step().decode()
            else "; the step before was that of another version"
        )
        file.event(last.step, f"goes on from here{changes}")
    return restore_prepared(former, arguments, companions), last


def alone(record: Record, step: int) -> Assembly:
    """Return the assembly of a run that goes on without its companions after a step, which a note reports:
    version 0.2 saved a complete run without their states.
    """
    time = record.assembly.choice.step * step
    note = (
        f"The run continues from {time:.6g} s without companions, because its file has no state of them: no"
        " numerical error is estimated. Run the model again from its start for one."
    )
    return dataclasses.replace(record.assembly, notes=(*record.assembly.notes, note))


def restore_prepared(former: Result, arguments: dict[str, Any], stored: Mapping[str, Any]) -> Prepared:
    """Return what :func:`prepare` returned for the run of a file. ``arguments`` and ``stored`` are its
    metadata of arguments and companions.
    """
    record, reference = former.record, former.reference
    length = Span(
        turns=arguments.get("turns"),
        duration=arguments.get("duration"),
        outputs=arguments.get("outputs"),
        force_step=bool(arguments.get("force_step")),
    )
    earlier, tries = ranges_of_tries(stored)
    return Prepared(
        record.assembly, reference, record.loop,  # type: ignore[arg-type]
        RestoredStart(record, length, expected_forces(reference), bool(arguments.get("started"))),
        companions=len(stored.get("counts", ())),
        refined=bool(arguments.get("refined")), inputs=arguments,
        earlier=earlier, tries=tries,
        searches=bool(arguments.get("searches", True)),
    )  # fmt: skip


@with_faults()
@named_interrupt("resume")
def resume(
    run: str | Path, *, until: float | str | None = None, progress: Callable[[Progress], None] | None = None
) -> Result:
    """Continue an interrupted or killed run; the result has the bits of an uninterrupted run.

    run: the folder of the run, or its file, which ``vfife.simulate(file=...)``, ``result.save()`` or
    ``vfife run`` made
    until: a later end time (s, or a text with a unit), also for a complete run
    progress: called with a :class:`~vfife.solvers.status.Progress`

    Returns the result of the whole run, which is in the file as well; after Ctrl-C it has the outputs so far,
    its status "interrupted". Companions go on with the run. Raises ResumeError if there is nothing to
    continue, HeldError if another process writes into the file, RunFileError and StorageError if the file
    cannot be read or written.
    """
    arguments = Arguments("resume")
    end = arguments.quantity("until", until, "s")
    arguments.callable("progress", progress)
    arguments.check()
    path = located(RUN, path_of(run, "resume"))
    with job_of("resume", path, True, progress) as job, run_lock(path), RunFile.write(path) as file:
        prepared, last = reopen_run(file, end)
        result = run_prepared(prepared, progress=job, file=file, resume=last)
        show_phase(job, result.record, MEASURING)
        result.finish(file)
        if result.record.status == Status.INTERRUPTED:
            job.interrupted()
    return result
