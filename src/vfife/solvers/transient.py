"""Step an assembled mechanism from its start or from a checkpoint to its end, with progress, signals, the run
file, and a stop where numbers leave their bounds.

The loop is called for a quarter of a second at most, because signals, progress and checkpoints wait for the
end of a call. Calls are whole intervals between outputs, or pieces of one if intervals are long. A run that
writes a file keeps no rows in memory.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, Bounds
from ..compiler.runtime.runner import Runner
from ..compiler.trace.straight_line import estimated_lines
from ..errors import VfifeError
from ..laws.stored import refuse_recorded
from .arguments import Loop
from .companion_lanes import SeparateLanes, Stepper, SynchronisedLanes, single_runner
from .companions import CompanionRecorder, step_counts
from .interrupts import FIRST, QUICK, ChunkSize, Interrupts
from .record import Burst, Checkpoint, Record, Rows, Writer, lasting_rows, recorded_rows, room_for_rows
from .repeating import Settling
from .status import Progress, Status

# Largest size (bytes) of the rows of one call, so that memory does not grow with a run that writes a file.
CHUNK_BYTES = 2**22
CHECKPOINT_SECONDS = 60.0  # longest time between two checkpoints, however far apart outputs are
CHECKPOINT_SHARE = 20.0  # shortest time between two checkpoints, as a multiple of the time to write one
JUDGE_SECONDS, JUDGED = 5.0, 200  # time between two checks of the energy, and outputs in one
SHORT = 50_000  # numbers in all lanes of a state for which a generated step takes some 50 microseconds
# Lines of the longest step that is compiled as straight-line code: some 380 elements, five seconds.
LONGEST_STRAIGHT_LINE = 25_000


Judge: TypeAlias = Callable[[NDArray[np.int64], Rows], bool]


def choose_loop(assembly: Assembly, loop: Loop) -> str:
    """Return the loop of a run. "auto" is straight-line code, except for large frames, path units of several
    steps, and statics.
    """
    if assembly.mechanism.settings.analysis == "static":
        return "interpreted" if loop == "interpreted" else "data-driven"
    if loop != "auto":
        return loop
    return (
        "generated"
        if assembly.topology.path_unit == 1 and estimated_lines(assembly.topology) <= LONGEST_STRAIGHT_LINE
        else "data-driven"
    )


def run(
    assembly: Assembly,
    *,
    loop: Loop = "auto",
    progress: Callable[[Progress], None] | None = None,
    file: Writer | None = None,
    companions: int = 0,
    resume: Checkpoint | None = None,
    judge: Judge | None = None,
) -> Record:
    """Step a mechanism from its start to the end of its choice of steps, together with ``companions``
    companion runs; return its record.

    ``progress`` is called after each call of the loop. ``file`` receives outputs and checkpoints; ``resume``
    is a checkpoint from which the run continues. ``judge`` gets steps and rows of outputs every few seconds,
    with those of output 0 before them; if it returns True, the run ends with the status "energy".

    Ctrl-C (any signal that raises KeyboardInterrupt) ends the run within a quarter of a second with the
    status "interrupted" and a checkpoint; numbers beyond their bounds end it with "diverged". All that was
    computed before is kept. The run has the same bits with any companions, and with any interruptions.
    """
    refuse_recorded([*assembly.topology.contact_laws, *assembly.topology.friction_laws])
    halt = Interrupts()
    # Not within the context: this compiles, and Ctrl-C has nothing to keep yet.
    stepping = Stepping(assembly, choose_loop(assembly, loop), companions, file, halt, judge)
    with halt:
        try:
            stepping.begin(resume)
            status = stepping.to_the_end(progress)
        except KeyboardInterrupt:
            if not stepping.begun:
                raise
            status = Status.INTERRUPTED
            stepping.leave()
        return stepping.record(status)


class Stepping:
    """A run in progress: its lanes, the rows that are kept, and its progress."""

    def __init__(
        self,
        assembly: Assembly,
        loop: str,
        companions: int,
        file: Writer | None,
        halt: Interrupts,
        judge: Judge | None,
    ) -> None:
        self.assembly, self.loop, self.file, self.halt, self.judge = assembly, loop, file, halt, judge
        self.row_numbers, self.lasting = recorded_rows(assembly), lasting_rows(assembly.layout)
        self.lanes = companions + 1
        self.largest_chunk = max(1, CHUNK_BYTES // (8 * len(self.row_numbers) * self.lanes))
        self.bounds = Bounds(assembly, self.row_numbers)
        counts = step_counts(assembly.choice, companions)
        self.runner = self._stepper(np.array([assembly.choice.outputs_every, *counts]))
        self.chunk_start = self.runner.states[:, 0].copy()
        self.recorder = CompanionRecorder(assembly, self.row_numbers, counts) if companions else None
        states = self.runner.states
        self.pace = ChunkSize(first=QUICK if loop == "generated" and states.size <= SHORT else FIRST)
        self.rows = room_for_rows(assembly.choice.outputs + 1 if file is None else 0, len(self.row_numbers))
        self.outputs = 0  # rows that are filled
        self.done, self.earlier, self.begun, self.call_complete = 0, 0.0, False, True
        self.burst: Burst | None = None
        self.checkpoint_step, self.checkpoint_time, self.checkpoint_seconds = -1, time.monotonic(), 0.0
        self.first: Rows | None = None
        self.judge_time, self.energy_violated = time.monotonic(), False
        settle = assembly.mechanism.settings.settle
        self.settling = None if settle is None else Settling(assembly, self.row_numbers, settle)

    def _stepper(self, counts: NDArray[np.int64]) -> Stepper:
        """Return what steps the run, alone or with companions; ``counts`` are the steps of each lane between
        two outputs.
        """
        if len(counts) == 1:
            return self._alone()
        if self.loop == "generated":
            return SynchronisedLanes(self.assembly, counts, self.row_numbers, self.largest_chunk)
        return SeparateLanes(self.assembly, counts, self.row_numbers, self.loop)

    def _alone(self) -> Runner:
        """Return a runner of the run alone."""
        return single_runner(self.assembly, self.loop, self.row_numbers)

    # -------------------------------------------------------------------------------------------------- begin

    def begin(self, resume: Checkpoint | None) -> None:
        """Take the first output, or continue from a checkpoint."""
        if resume is not None:
            self._restore(resume)
        else:
            lane_rows = self.runner.advance(1, 1)
            self._keep(0, lane_rows)
        self.begun = True

    def _restore(self, resume: Checkpoint) -> None:
        values = resume.values.reshape(len(self.lasting), -1)
        if values.shape[1] != self.lanes:
            raise VfifeError(
                f"the checkpoint was written with {values.shape[1] - 1} companions and the run has"
                f" {self.lanes - 1}; start a new run from its end"
            )
        self.runner.states[self.lasting] = values
        self.runner.done, self.done, self.checkpoint_step = resume.step + 1, resume.step, resume.step
        self.earlier = float(resume.extra.get("wall", 0.0))
        if self.file is not None and self.judge is not None:
            self.first = self.file.later()()[:1]
        if self.recorder is not None and self.file is not None:
            self.recorder.restore(resume.extra["companions"], self.file.companions(), self.file.turns())
        if self.settling is not None and self.file is not None:
            self.settling.restore(self.file.later()())

    # -------------------------------------------------------------------------------------------------- go on

    def to_the_end(self, progress: Callable[[Progress], None] | None) -> Status:
        """Step to the end, call by call; each call is complete before a signal is handled."""
        choice, began = self.assembly.choice, time.monotonic()
        while not self.finished:
            done_before, self.chunk_start[:] = self.runner.done, self.runner.states[:, 0]
            self.call_complete = False
            sound = self._chunk()
            self.call_complete = True
            if not sound:
                self.burst = self._replayed(done_before)
                return Status.DIVERGED
            if self.energy_violated:
                return Status.ENERGY
            if progress is not None:
                # With the time to keep outputs: it decides when the run ends.
                seconds = self.earlier + time.monotonic() - began
                progress(Progress(self.done, choice.steps, seconds))
            self.halt.look()
        return Status.COMPLETE

    @property
    def finished(self) -> bool:
        """Whether all steps are taken, or turns repeat and the settings end a run then."""
        return self.done >= self.assembly.choice.steps or (
            self.settling is not None and self.settling.settled
        )

    @property
    def wall(self) -> float:
        """Seconds of stepping, including those before the checkpoint."""
        return self.earlier + self.pace.seconds

    def _chunk(self) -> bool:
        """Take some outputs, or a piece of the interval to the next one; return False if numbers left their
        bounds.
        """
        choice = self.assembly.choice
        inside = self.done % choice.outputs_every
        count = min(
            self.pace.steps // choice.outputs_every,
            choice.outputs - self.done // choice.outputs_every,
            self.largest_chunk,
        )
        if self.settling is not None and self.settling.remaining:
            count = min(count, self.settling.remaining)  # so that a run ends with the turn that settles it
        if inside == 0 and count > 0:
            return self._keep(
                self.done + choice.outputs_every, self.pace.call(self.runner, choice.outputs_every, count)
            )
        piece = min(max(self.pace.steps, 1), choice.outputs_every - inside)
        ends = inside + piece == choice.outputs_every
        lane_rows = self.pace.call(self.runner, piece, reset=inside == 0, record=ends)
        if ends:
            return self._keep(self.done + piece, lane_rows)
        if self.runner.broken[0] > 0.0:
            return False
        self.done += piece
        if time.monotonic() - self.checkpoint_time > CHECKPOINT_SECONDS:
            self.checkpoint()
        return True

    def _keep(self, first: int, lane_rows: Rows) -> bool:
        """Keep the valid ones of some outputs, beginning with that of step ``first``, with a checkpoint if
        all are valid; return whether they are.
        """
        rows = np.array(
            lane_rows[:, :, 0], order="C"
        )  # a copy, which does not keep the rows of companions alive
        broken = self.bounds.unsound(rows).any(axis=1)
        if self.runner.broken[0] > 0.0:
            broken |= (
                first + np.arange(len(rows)) * self.assembly.choice.outputs_every >= self.runner.broken[0] - 1
            )
        sound = int(np.argmax(broken)) if broken.any() and first > 0 else len(rows)
        steps = first + np.arange(sound, dtype=np.int64) * self.assembly.choice.outputs_every
        companions = (
            self.recorder.take(steps, lane_rows[:sound]) if self.recorder is not None and sound else None
        )
        if sound:
            self.done = int(steps[-1])
        if self.settling is not None and sound == len(rows):
            self.settling.take(rows[1:] if first == 0 else rows)
        self._look(steps, rows[:sound])
        if self.file is None:
            self.rows[self.outputs : self.outputs + sound] = rows[:sound]
            self.outputs += sound
        else:
            due = (
                time.monotonic() - self.checkpoint_time
                >= min(CHECKPOINT_SECONDS, CHECKPOINT_SHARE * self.checkpoint_seconds)
                or self.finished
            )
            began = time.monotonic()
            self.file.append(
                steps, rows[:sound], companions, self._checkpoint() if due and sound == len(rows) else None
            )
            if due and sound == len(rows):
                self._note_checkpoint(began)
        return sound == len(rows)

    def _look(self, steps: NDArray[np.int64], rows: Rows) -> None:
        """Call the judge with outputs, together with output 0, from which energies are counted."""
        if self.first is None and len(steps) and steps[0] == 0:
            self.first = rows[:1]
        if (
            self.judge is None
            or self.first is None
            or len(steps) < 2
            or time.monotonic() - self.judge_time < JUDGE_SECONDS
        ):
            return
        latest = slice(-JUDGED, None)
        self.energy_violated = self.judge(
            np.concatenate([[0], steps[latest]]), np.concatenate([self.first, rows[latest]])
        )
        self.judge_time = time.monotonic()

    # -------------------------------------------------------------------------------------------- checkpoints

    def _checkpoint(self) -> Checkpoint:
        extra = {"wall": self.wall} | (
            {} if self.recorder is None else {"companions": self.recorder.checkpoint}
        )
        return Checkpoint(self.done, self.runner.states[self.lasting], extra)

    def checkpoint(self) -> None:
        """Write a checkpoint of the present state, unless there is one."""
        if self.file is not None and self.done > self.checkpoint_step:
            began = time.monotonic()
            self.file.append(np.zeros(0, dtype=np.int64), np.zeros((0, 0)), None, self._checkpoint())
            self._note_checkpoint(began)

    def _note_checkpoint(self, began: float) -> None:
        self.checkpoint_step, self.checkpoint_time = self.done, time.monotonic()
        self.checkpoint_seconds = self.checkpoint_time - began

    def leave(self) -> None:
        """Write a checkpoint before a run ends early. If a second signal interrupted a call, the last
        checkpoint remains valid.
        """
        if self.call_complete:
            self.checkpoint()

    # ---------------------------------------------------------------------------------------------------- end

    def _replayed(self, done: int) -> Burst | None:
        """Return where the first number left its bounds, by repeating the last call with a check after every
        step; ``done`` is the number of steps before it.
        """
        runner, count = self._alone(), self.runner.done - done
        runner.states[:, 0], runner.done, runner.look = self.chunk_start, done, 1
        runner.advance(count, 1, reset=False, record=False)
        if runner.broken[0] == 0.0:
            return None
        row = runner.states[self.row_numbers, 0]
        return Burst(
            int(runner.broken[0]) - 1,
            self.row_numbers[self.bounds.unsound(row[None, :])[0]],
            bool(np.isfinite(row).all()),
        )

    def record(self, status: Status) -> Record:
        """Return the record of the run."""
        final = self.runner.states[:, 0] + 0.0 if status == Status.COMPLETE else None
        source: Rows | Callable[[], Rows]
        if (
            self.file is not None
        ):  # an interrupt may have come after a chunk was written, and before it was counted
            steps, source = self.file.steps, self.file.later()
        else:
            steps, source = (
                np.arange(self.outputs, dtype=np.int64) * self.assembly.choice.outputs_every,
                self.rows[: self.outputs],
            )
        record = Record(self.assembly, steps, source, self.row_numbers, self.wall, self.loop, status, final)
        record.reached, record.burst = max(self.done, int(record.steps[-1])), self.burst
        if self.file is None and self.call_complete and status in (Status.COMPLETE, Status.INTERRUPTED):
            record.checkpoint = self._checkpoint()
        record.companions = (
            self.recorder.companions(int(record.steps[-1])) if self.recorder is not None else None
        )
        return record
