"""Runs an assembled mechanism chunk by chunk: progress, Ctrl-C, run file, a stop where numbers blow up."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .assemble import assemble
from .assembly import Assembly, Record
from .bounds import unsound
from .drivers import ConstantSpeed, Torque
from .mechanism import Mechanism

if TYPE_CHECKING:
    from .result import Result
    from .runfile import RunFile

Loop = Literal["auto", "data-driven", "generated", "interpreted"]
Start: TypeAlias = "Result | str | Path | Mapping[str, Any] | None"

CHUNK_SECONDS = 0.25  # time between two looks at Ctrl-C and the progress line
SAVED = 30e-9  # seconds that straight-line code saves for each step and element or joint
LARGEST_STRAIGHT_LINE = 50  # elements and joints of a topology that is still written out


@dataclass(frozen=True)
class Progress:
    """Where a run stands."""

    done: int
    steps: int
    seconds: float
    text: str = ""

    @property
    def share(self) -> float:
        """Part that is done, 0 to 1."""
        return self.done / self.steps

    @property
    def speed(self) -> float:
        """Steps a second."""
        return self.done / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def left(self) -> float:
        """Seconds left."""
        return (self.steps - self.done) / self.speed if self.speed else float("nan")


def entities(assembly: Assembly) -> int:
    """Elements and joints: what a step's work grows with."""
    t = assembly.topology
    return len(t.element_nodes) + len(t.clearance_bearing) + len(t.ideal_bearing) + len(t.spring_first)


def compilation(assembly: Assembly) -> float:
    """Seconds (measured on one machine, a guess elsewhere) that straight-line code takes to compile: it grows with the square of its lines."""
    t = assembly.topology
    lines = 60 * len(t.element_nodes) + 190 * len(t.clearance_bearing) + 150 * len(t.ideal_bearing) + 20 * len(t.free)
    return 1.0 + 3.5e-6 * lines**2


def choose_loop(assembly: Assembly, loop: Loop) -> str:
    """The loop of a run: straight-line code where it saves more time than its compilation costs, or is compiled already."""
    if assembly.mechanism.settings.analysis == "static":
        return "interpreted" if loop == "interpreted" else "data-driven"
    if loop != "auto":
        return loop
    if entities(assembly) > LARGEST_STRAIGHT_LINE or assembly.topology.path_unit != 1:
        return "data-driven"
    saved = SAVED * max(entities(assembly), 2) * assembly.choice.steps
    return "generated" if saved > compilation(assembly) or (saved > 0.2 and _compiled(assembly)) else "data-driven"


def _compiled(assembly: Assembly) -> bool:
    from .kernels.compile import is_compiled
    from .kernels.generate import straight_line

    return is_compiled(straight_line(assembly.topology, 1), "advance")


def recorded_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Rows of S that a run keeps: all state and all extremes."""
    return np.array(assembly.layout.of("state", "extreme"), dtype=np.uint32)


def run(assembly: Assembly, *, loop: Loop = "auto", progress: Callable[[Progress], None] | None = None, file: RunFile | None = None) -> Record:
    """Steps a mechanism from its start to the end of its choice of steps.

    Ctrl-C ends it after the present chunk with status "interrupted", numbers beyond all bounds with "diverged"; what was computed
    before is kept.
    """
    from .kernels.runner import Runner
    from .laws.recorded import refuse_recorded

    refuse_recorded([*assembly.topology.contact_laws, *assembly.topology.friction_laws])
    kept = recorded_rows(assembly)
    chosen = choose_loop(assembly, loop)
    runner = Runner(assembly.topology, assembly.state[:, None].copy(), assembly.tables[None, :], chosen, kept)
    choice = assembly.choice
    parts = [runner.advance(1, 1)[:, :, 0]]
    record = Record(assembly, np.zeros(1, dtype=np.int64), parts[0], kept, loop=chosen)
    status, done, wall, chunk = "complete", 0, 0.0, 1
    if file is not None:
        file.append(np.zeros(1, dtype=np.int64), parts[0])
    try:
        while done < choice.outputs:
            some = min(chunk, choice.outputs - done)
            began = time.perf_counter()
            rows = runner.advance(choice.outputs_every, some)[:, :, 0]
            spent = time.perf_counter() - began
            wall += spent
            broken = unsound(assembly, kept, rows).any(axis=1)
            sound = int(np.argmax(broken)) if broken.any() else len(rows)
            parts.append(rows[:sound])
            steps = (done + 1 + np.arange(sound)) * choice.outputs_every
            if file is not None:
                file.append(steps, rows[:sound])
                file.checkpoint(int((done + some) * choice.outputs_every), runner.states[:, 0])
            done += sound
            if sound < some:
                status = "diverged"
                break
            if progress is not None:
                progress(Progress(done * choice.outputs_every, choice.steps, wall))
            chunk = max(1, min(4 * some, int(some * CHUNK_SECONDS / max(spent, 1e-6))))
    except KeyboardInterrupt:
        status = "interrupted"
    record.steps = np.arange(done + 1, dtype=np.int64) * choice.outputs_every
    record.rows = np.concatenate(parts)[: done + 1]
    record.wall, record.status = wall, status
    record.final = runner.states[:, 0].copy() if status == "complete" else None
    return record


def expected_forces(reference: Result | None) -> Mapping[str, float]:
    """Largest forces of the ideal mechanism, by joint."""
    if reference is None:
        return {}
    return {name.removesuffix(".force.max"): value for name, value in reference.measures.items() if name.endswith(".force.max")}


def reference_of(mechanism: Mechanism, turns: float | None = None, duration: float | None = None) -> Result | None:
    """The ideal mechanism, where a driver makes it comparable turn by turn: one turn at constant speed, else as long as the run."""
    if mechanism.settings.analysis == "static":
        return None
    moving = [driver for driver in mechanism.drivers.values() if not isinstance(driver, Torque)]
    if not mechanism.contacts or not moving or len(mechanism.ideal().joints) < len(mechanism.joints):
        return None
    if all(isinstance(driver, ConstantSpeed) for driver in moving):
        turns, duration = 1.0, None
    from .result import Result

    return Result(run(assemble(mechanism.ideal(), beside=mechanism, turns=turns, duration=duration)))


def simulate(
    mechanism: Mechanism,
    *,
    turns: float | None = None,
    duration: float | None = None,
    step: float | str | None = None,
    outputs: int | None = None,
    loop: Loop = "auto",
    reference: bool | Result = True,
    force_step: bool = False,
    progress: Callable[[Progress], None] | None = None,
    file: RunFile | None = None,
    start: Start = None,
) -> Result:
    """Simulates a mechanism.

    ``turns`` of the crank or ``duration`` (s); ``step`` (s) or "auto"; ``outputs`` per turn (per run without a crank); ``loop`` "auto",
    "data-driven", "generated" or "interpreted", which give the same bits; ``reference``: also run the ideal mechanism to compare with.
    An automatic step is halved, three times at the most, while first contacts land deeper than a joint allows. A mechanism whose settings ask for
    a static analysis is brought to equilibrium instead (:func:`~vfife.statics.equilibrium`), which takes neither ``turns``, ``duration`` nor
    ``step``. ``start``: a former run (or its folder) to go on from, or states of bodies by name (:func:`~vfife.given.start_from`). Raises
    ValueError, all faults at once, for a mechanism that cannot be assembled and StepError for too large a step.
    """
    from .modelfile import examined
    from .provenance import provenance
    from .result import Result

    examined(mechanism)
    if mechanism.settings.analysis == "static":
        from .statics import equilibrium

        given = {"turns": turns, "duration": duration, "step": step}
        asked: Any = {name: value for name, value in given.items() if value is not None}
        still = dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **asked))
        return Result(equilibrium(assemble(still), loop=loop, progress=progress, file=file))
    ideal = reference if not isinstance(reference, bool) else reference_of(mechanism, turns, duration) if reference else None
    expected = expected_forces(ideal)
    options: dict[str, Any] = {"turns": turns, "duration": duration, "outputs": outputs, "force_step": force_step}
    assembly = begun(mechanism, step, start, expected=expected, **options)
    record = run(assembly, loop=loop, progress=progress, file=file)
    tries = 3 if assembly.choice.automatic else 0
    while tries and record.status == "complete" and _too_deep(record):
        tries -= 1
        assembly = begun(mechanism, 0.5 * assembly.choice.step, start, expected=expected, **options)
        if file is not None:
            file.begin(provenance(assembly, recorded_rows(assembly), choose_loop(assembly, loop)))
        record = run(assembly, loop=loop, progress=progress, file=file)
    return Result(record, ideal)


def begun(mechanism: Mechanism, step: float | str | None = None, start: Start = None, time: float | None = None, **options: Any) -> Assembly:
    """The assembled mechanism at its own start, or where a former run was at ``time`` (s; its end unless given), or at states given by name.

    A run that ended and is cut alike goes on with its whole state, element and contact forces with it.
    """
    if start is None:
        return assemble(mechanism, step, **options)
    from .continued import alike, continued, former
    from .given import given

    assembly = assemble(mechanism, step, given=given(start, mechanism, time), **options)
    record = former(start, time)
    return continued(assembly, record) if record is not None and alike(assembly, record) else assembly


def _too_deep(record: Record) -> bool:
    """Whether a first contact landed deeper than its joint allows."""
    return bool(record.assembly.clearances) and bool(record.block("clearance_deep")[-1].any())
