"""Steps an assembled mechanism from its start to its end, chunk by chunk: progress, Ctrl-C, run file, a stop where numbers blow up."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from ..assembly.assembled import Assembly
from ..assembly.bounds import unsound
from ..codegen.runner import Runner
from ..codegen.straight_line import about
from ..laws.stored import refuse_recorded
from .arguments import Loop
from .companions import Gathering, lanes
from .progress import Progress
from .record import Record, Rows, Writer, lasting_rows, recorded_rows
from .status import Status

CHUNK_BYTES = 2**22  # of rows between two looks, so that memory does not grow with a run that is written to a file
CHUNK_SECONDS = 0.25  # time between two looks at Ctrl-C and the progress line
LONGEST_STRAIGHT_LINE = 25_000  # lines of a step that is still written out: some 380 elements, five seconds of compilation


def choose_loop(assembly: Assembly, loop: Loop) -> str:
    """The loop of a run: straight-line code for all but large frames, path units of several steps and statics."""
    if assembly.mechanism.settings.analysis == "static":
        return "interpreted" if loop == "interpreted" else "data-driven"
    if loop != "auto":
        return loop
    return "generated" if assembly.topology.path_unit == 1 and about(assembly.topology) <= LONGEST_STRAIGHT_LINE else "data-driven"


def run(
    assembly: Assembly,
    *,
    loop: Loop = "auto",
    progress: Callable[[Progress], None] | None = None,
    file: Writer | None = None,
    companions: int = 0,
) -> Record:
    """Steps a mechanism from its start to the end of its choice of steps, with so many companions beside it.

    Ctrl-C ends it after the present chunk with status "interrupted", numbers beyond all bounds with "diverged"; what was computed
    before is kept. Whatever runs beside it, the run has the same bits.
    """
    refuse_recorded([*assembly.topology.contact_laws, *assembly.topology.friction_laws])
    kept, lasting = recorded_rows(assembly), lasting_rows(assembly.layout)
    chosen = choose_loop(assembly, loop)
    choice, smaller = assembly.choice, assembly.mechanism.settings.parts
    first = lanes(companions, chosen)
    states, tables = np.repeat(assembly.state[:, None], len(first), axis=1), np.repeat(assembly.tables[None, :], len(first), axis=0)
    runner = Runner(assembly.topology, states, tables, chosen, kept, parts=smaller, shares=first)
    gathering = Gathering(assembly, kept, first[1 : companions + 1]) if companions else None
    parts: list[Rows] = []

    def keep(done: int, rows: Rows, every: Rows) -> None:
        steps = (done + np.arange(len(rows), dtype=np.int64)) * choice.outputs_every
        beside = gathering.take(steps, every) if gathering is not None and len(rows) else None
        if file is None:
            parts.append(rows)
        else:
            file.append(steps, rows, beside)

    status, done, wall = Status.COMPLETE, 0, 0.0
    most = max(1, CHUNK_BYTES // (8 * len(kept) * len(first)))
    chunk = 1
    every = runner.advance(1, 1)
    keep(0, np.ascontiguousarray(every[:, :, 0]), every)
    try:
        while done < choice.outputs:
            some = min(chunk, choice.outputs - done, most)
            began = time.perf_counter()
            every = runner.advance(choice.outputs_every, some)
            spent = time.perf_counter() - began
            wall += spent
            rows = np.ascontiguousarray(every[:, :, 0])
            broken = unsound(assembly, kept, rows).any(axis=1)
            sound = int(np.argmax(broken)) if broken.any() else len(rows)
            keep(done + 1, rows[:sound], every[:sound])
            if file is not None:
                file.checkpoint(int((done + some) * choice.outputs_every), runner.states[lasting, 0])
            done += sound
            if sound < some:
                status = Status.DIVERGED
                break
            if progress is not None:
                progress(Progress(done * choice.outputs_every, choice.steps, wall))
            chunk = max(1, min(4 * some, int(some * CHUNK_SECONDS / max(spent, 1e-6))))
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    final = runner.states[:, 0].copy() if status == Status.COMPLETE else None
    if file is not None:  # an interrupt may have come after a chunk was written, and before it was counted
        record = Record(assembly, file.steps, file.later(), kept, wall, chosen, status, final)
    else:
        rows = np.concatenate(parts)
        record = Record(assembly, np.arange(len(rows), dtype=np.int64) * choice.outputs_every, rows, kept, wall, chosen, status, final)
    record.companions = gathering.left(int(record.steps[-1])) if gathering is not None else None
    return record
