"""Cost of work before it begins: time from a table of costs or from a timed part, memory, and bytes on the
disk.

The time of a step depends on its loop and on the number of joints and elements. The table alone gives
forecasts within a factor of two to three on common processors. Work longer than :data:`WORTH` is therefore
calibrated: its first part is timed (:func:`timed_step`, :func:`timed`), in processor time, so that other
programs on the machine do not count.
"""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import files
from ..assembly.assembled import Assembly
from ..assembly.stability import element_stiffness
from ..compiler.trace.straight_line import estimated_lines
from ..solvers.record import recorded_rows
from ..solvers.status import Status
from ..solvers.transient import choose_loop, run
from ..store.packing import packed
from .progress import amount_of_bytes, counted, span

# Time (ns) of a step, and what each clearance joint, ideal joint and element adds to it; one lane, common
# cores of 2 to 3 GHz.
NANOSECONDS = {
    "data-driven": {"step": 30.0, "clearance": 75.0, "ideal": 170.0, "element": 27.0},
    "generated": {"step": 55.0, "clearance": 40.0, "ideal": 20.0, "element": 22.0},
}
COMPANIONS = 1.7  # time of a step with companions, over that without
LANES = {1: 1.0, 2: 1.1, 4: 1.0, 8: 1.8}  # time of a step by number of lanes, over that of one
# The same with derivatives by one number; with two lanes, a second thread follows the differences of both.
TANGENTS = {1: 2.2, 2: 2.0, 4: 3.4}
DATA_DRIVEN_COMPILATION = 10.0  # s, once for all models with the same forms of laws; kept on disk
# s, plus s for each line of the step; once for all models of the same topology.
STRAIGHT_LINE_COMPILATION = 0.2, 2.2e-4
# Iterations of an equilibrium: fewest, and by elements times slenderness; 0.4, 1.6 and 5.4 in the examples.
FEWEST_ITERATIONS, ITERATIONS = 1000.0, 1.0
STATIC_LOOKS = 3000.0  # ns that checks add to an iteration
MOST_TRIES = 7.0  # steps of a run whose automatic step is halved twice, over those of its first try
REFINED = 7.0  # steps of a smooth run that is repeated with half and a quarter of its step, over its own
SMOOTH_TRIES = 15.0  # the same as MOST_TRIES of such a run, whose automatic step is halved three times
# Time of a static analysis that is repeated with twice and with half the elements, over its own; 1.7 to 6 in
# the examples. With this and ITERATIONS, forecasts of the examples are 1 to 5 times their time.
MESHED = 3.5
ASSEMBLY = 0.006  # s in which a case is assembled and its results are taken, alone

RECORD_SECONDS = 4e-9  # s to keep a byte of a record and to account for the energy in it
# s to write a byte of a record into a run file and to take its measures, without companions and with them,
# which give ranges: 1e-8 to 9e-8 in examples of 40 to 200 turns.
MEASURING_SECONDS = {False: 2e-8, True: 5e-8}
START = 1.0  # s of processor time in which a command starts, reads a model and prints its answer
# Memory to read a whole record as one dataset, over its bytes, and of the program itself (bytes): 400 turns
# of case c, a record of 267 MB, take 614 MB. Without a file the run itself takes 1.2 times its record, with
# one a fifth, because run files are read piece by piece.
RECORD_COPIES = 1.75
LIBRARIES = 1.6e8
COMPRESSED = 0.5  # bytes of outputs in a run file, over those of the numbers
# The same of a motion that hardly changes its numbers, the least of the examples.
LEAST_COMPRESSED = 0.05
# Outputs and steps of a sample that is compressed, its least outputs, and the least and the largest share
# of a long run over that of its sample: 0.76 to 1.11 in runs of 100 and 1000 turns.
SAMPLE, SAMPLE_STEPS, LEAST_SAMPLE = 2000, 500_000, 100
SAMPLED = 0.7, 1.3
# Largest size of a run file over its forecast, without and with companions: outputs that an automatic step
# wrote again and rows of companions that were replaced stay as free pages. The largest of 14 runs are 1.08
# and 1.89.
LARGEST_FILE = 1.2, 2.0
# Least and largest time of stepping over that of a short part of a run, and over that of the table.
TIMED, TABLED = (0.75, 1.3), (0.4, 3.5)
# s to record a byte, to write it into a run file and to measure it, without and with companions: the least
# and the largest in runs of 100 and 1000 turns of six mechanisms are 0.9e-8 and 1.7e-8, 1.9e-8 and 4.5e-8.
WRITTEN_TRIES = 1.5  # time to write and to measure all three tries, over that of the last
WRITING = {False: (7e-9, 2.5e-8), True: (1.5e-8, 6e-8)}

# Time (ns) and bytes to write a number into a file of an ending.
EXPORTED = {
    ".csv": (500.0, 15.0),
    ".xlsx": (1500.0, 6.5),
    ".mat": (250.0, 5.5),
    ".parquet": (250.0, 8.0),
    ".nc": (400.0, 5.0),
}
BRIEF = 2.0  # s of an ideal reference that need not be forecast before it is run
WORTH = 1.5  # s of work from which on a chunk of it is timed
CHUNK_STEPS = 20_000
# Work that takes longer (s), or a larger share of the memory or of the free disk, must be confirmed.
LONG, SHARE = 3600.0, 0.5


@dataclass(frozen=True)
class Forecast:
    """Cost of the remaining work: ``count`` runs (called by the ``noun``) of ``steps`` steps, in addition to
    those ``done``.

    ``seconds`` on this machine without other load, with ``threads`` of ``lanes``; bytes of ``memory`` and
    ``disk``. ``work`` describes the work instead of count and steps; ``remedy`` tells how to reduce it,
    ``note`` what may increase it. ``disk_growth``: the largest size on disk over ``disk``. ``ends``: the time
    (s) in the cheapest and in the dearest case, where they differ.
    """

    noun: str
    count: int = 1
    steps: float = 0.0
    seconds: float = 0.0
    memory: float = LIBRARIES
    disk: float = 0.0
    done: int = 0
    threads: int = 1
    lanes: int = 1
    work: str = ""
    remedy: str = "ask for fewer cases or turns"
    note: str = ""
    remarks: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()
    first_look: float = math.inf  # s that a first look at the same takes
    spread: tuple[float, float] | None = None  # s, from which to which time a run may take
    disk_growth: float = 1.0
    ends: tuple[float, float] | None = None

    def with_ends(self, low: float, high: float) -> Forecast:
        """Return this forecast with the time (s) with an automatic step that is not halved, and with one that
        is halved twice, within one factor of both.
        """
        note = f", {span(low)} to {span(high)} as the automatic step is halved or not"
        return dataclasses.replace(self, seconds=math.sqrt(low * high), note=note, ends=(low, high))

    def longer(self, seconds: float) -> Forecast:
        """Return this forecast with the seconds that a command needs beside its runs."""
        if self.ends is None:
            return dataclasses.replace(self, seconds=self.seconds + seconds)
        return self.with_ends(self.ends[0] + seconds, self.ends[1] + seconds)

    @property
    def longest(self) -> float:
        """Time (s) in the dearest case."""
        return self.seconds if self.ends is None else self.ends[1]

    @property
    def time_words(self) -> str:
        """Time as text, as a range where it is one."""
        return " to ".join(dict.fromkeys(map(span, self.spread or (self.seconds,))))

    @property
    def most_disk(self) -> float:
        """Largest number of bytes on disk."""
        return self.disk_growth * self.disk

    @property
    def disk_words(self) -> str:
        """Size on disk, as a range where it is one."""
        ends = [amount_of_bytes(size) for size in dict.fromkeys((self.disk, self.most_disk))]
        return " to ".join(ends)

    def excess(self, place: Path) -> str:
        """Return a description of excessive cost (hours, half the memory or disk); "" if there is none."""
        free, memory = files.free_bytes(place), physical_memory()
        parts = []
        if self.seconds > LONG:
            parts.append(f"about {span(self.seconds)}")
        if memory is not None and self.memory > SHARE * memory:
            parts.append(
                f"about {amount_of_bytes(self.memory)} of memory on a machine that has"
                f" {amount_of_bytes(memory)}"
            )
        if free is not None and self.most_disk > SHARE * free:
            parts.append(f"about {self.disk_words} on a disk that has {amount_of_bytes(free)} left")
        return " and ".join(parts)

    @property
    def amount(self) -> str:
        """Description of the runs and their steps."""
        plural = " each" if self.count > 1 else ""
        return self.work or f"{counted(self.count, self.noun)} of {self.steps:,.0f} steps{plural}"

    def sentence(self, place: Path | None) -> str:
        """Return the forecast in one line."""
        done = f" beside {self.done:,} that are there" if self.done else ""
        work = self.work or f"{counted(self.count, self.noun)}{done}, about {self.steps:,.0f} steps each"
        lanes = f", {counted(self.lanes, self.noun)} at once in each" if self.lanes > 1 else ""
        disk = f", {self.disk_words} in {place}" if place is not None and self.disk else ""
        threads = f"{counted(self.threads, 'thread')}{lanes}"
        return f"{work}: {self.time_words} on an idle machine with {threads}{disk}{self.note}."


def cores() -> int:
    """Return the number of processors of this machine."""
    return os.cpu_count() or 1


def physical_memory() -> int | None:
    """Return the bytes of memory of this machine, None if unknown."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return None


# ------------------------------------------------------------------------------------------------------ runs


@dataclass(frozen=True)
class RunCost:
    """Cost of a run: loop, times of a step (ns), of the run and of a first compilation (s), rows of the
    state, bytes of the record, times of the ideal reference and of the run without companions, bytes of
    memory and disk. With an automatic step it is that of the first try. ``measuring`` is the time (s) to
    write the run file and to take all measures, which is not among ``seconds``; ``disk_growth`` as in
    :class:`Forecast`. ``spread``: the least and the largest time (s) with ``measuring``, None for a static
    analysis that is repeated; ``halved``: the largest with an automatic step that is halved as often as
    ``halvings`` says, "twice" or "three times"; 0 where none is.
    """

    loop: str
    ns_per_step: float
    seconds: float
    compile_seconds: float
    rows: int
    bytes: int
    ideal_seconds: float = 0.0
    stepping: float = 0.0
    memory: float = LIBRARIES
    disk: float = 0.0
    measuring: float = 0.0
    disk_growth: float = 1.0
    spread: tuple[float, float] | None = None
    halved: float = 0.0
    halvings: str = ""

    def forecast(self, steps: int, remedy: str = "") -> Forecast:
        """Return the forecast of the run with its measures."""
        seconds = self.seconds + self.measuring
        amounts = seconds, self.memory, self.disk
        note = f"; up to {span(self.halved)} if the step is halved {self.halvings}" if self.halved else ""
        growth, spread = self.disk_growth, self.spread
        return Forecast(
            "run", 1, steps, *amounts, remedy=remedy, note=note, disk_growth=growth, spread=spread
        )


def run_cost(
    assembly: Assembly,
    reference: Assembly | None = None,
    *,
    companions: int = 0,
    refined: bool = False,
    measured: bool = False,
) -> RunCost:
    """Return the cost of a run with its ideal ``reference`` and ``companions`` from the table; ``measured``:
    calibrate long work.

    ``refined``: the run is repeated with smaller steps (a smooth one) or on other meshes (a static one).
    """
    cost = _alone(assembly)
    if companions:
        cost = dataclasses.replace(cost, seconds=COMPANIONS * cost.seconds)
    written = MEASURING_SECONDS[companions > 0] * cost.bytes
    measured = measured and cost.seconds + written > WORTH and cost.loop == "generated"
    if measured:
        cost = dataclasses.replace(cost, seconds=timed_step(assembly, companions) * assembly.choice.steps)
    size, stepping = float(cost.bytes), cost.seconds / (COMPANIONS if companions else 1.0)
    if reference is not None:
        ideal = _alone(reference)
        cost = dataclasses.replace(cost, seconds=cost.seconds + ideal.seconds, ideal_seconds=ideal.seconds)
        size += ideal.bytes
    recording = RECORD_SECONDS * size
    memory, seconds = RECORD_COPIES * size + LIBRARIES, cost.seconds + recording
    if refined and assembly.mechanism.settings.analysis == "static":
        seconds *= MESHED
    elif refined:
        seconds, memory = REFINED * seconds, memory + 2.0 * cost.bytes
    cost = dataclasses.replace(
        cost, seconds=seconds, stepping=stepping, memory=memory, disk=COMPRESSED * size, measuring=written,
        disk_growth=LARGEST_FILE[companions > 0],
    )  # fmt: skip
    if assembly.mechanism.settings.analysis != "static" or not refined:
        halves = (companions > 0 or refined) and assembly.choice.automatic
        step_seconds = seconds - (REFINED if refined else 1.0) * recording
        cost = _with_spread(cost, step_seconds, companions > 0, measured, halves)
    share = sampled_share(assembly) if measured else None
    if share is None:
        return cost
    low, high = SAMPLED
    growth = high / low * cost.disk_growth / LARGEST_FILE[0]
    return dataclasses.replace(cost, disk=low * share * size, disk_growth=growth)


def _with_spread(cost: RunCost, stepping: float, accompanied: bool, timed: bool, halves: bool) -> RunCost:
    """Return the cost of a run with its least and its largest time, and the largest of one that ``halves``
    its step: twice with companions, three times without; ``stepping``: time (s) of its steps and of the
    reference, of a ``timed`` part or of the table.
    """
    low, high = (
        pace * stepping + writing * cost.bytes
        for pace, writing in zip(TIMED if timed else TABLED, WRITING[accompanied], strict=True)
    )
    pace, writing = (TIMED if timed else TABLED)[1], WRITING[accompanied][1]
    tries, halvings = (MOST_TRIES, "twice") if accompanied else (SMOOTH_TRIES, "three times")
    halved = tries * pace * stepping + WRITTEN_TRIES * writing * cost.bytes if halves else 0.0
    return dataclasses.replace(cost, spread=(low, high), halved=halved, halvings=halvings if halves else "")


def _alone(assembly: Assembly) -> RunCost:
    topology, choice = assembly.topology, assembly.choice
    static = assembly.mechanism.settings.analysis == "static"
    loop = "data-driven" if static else choose_loop(assembly, "auto")
    ns = NANOSECONDS[loop]
    entities = (len(topology.contact_bearing), len(topology.joint_bearing), len(topology.frame_nodes))
    step = ns["step"] + sum(
        ns[name] * count for name, count in zip(("clearance", "ideal", "element"), entities, strict=True)
    )
    steps = choice.outputs * expected_iterations(assembly) if static else choice.steps
    step += STATIC_LOOKS * static
    fixed, per_line = STRAIGHT_LINE_COMPILATION
    compilation = (
        fixed + per_line * estimated_lines(topology) if loop == "generated" else DATA_DRIVEN_COMPILATION
    )
    size = 8 * len(recorded_rows(assembly)) * (choice.outputs + 1)
    return RunCost(loop, step, 1e-9 * step * steps, compilation, assembly.layout.rows, size)


def expected_iterations(assembly: Assembly) -> float:
    """Return an estimate of the iterations of an equilibrium: in proportion to the elements of the largest
    body and to its slenderness L sqrt(EA/EI).
    """
    limit = float(assembly.mechanism.settings.iterations)
    bodies = [list(body.elements) for body in assembly.bodies.values() if body.elements]
    if not bodies:
        return min(FEWEST_ITERATIONS, limit)
    stiffness = element_stiffness(assembly.layout, assembly.state, assembly.topology)
    # Of one element, with axial stiffness EA/l and transverse 12 EI/l^3 or less: l sqrt(EA/EI) is the root of
    # twelve times their ratio.
    transverse = np.where(stiffness.transverse > 0.0, stiffness.transverse, np.inf)
    slenderness = np.sqrt(12.0 * stiffness.axial / transverse)
    largest = max(len(elements) * float(slenderness[elements].sum()) for elements in bodies)
    return min(FEWEST_ITERATIONS + ITERATIONS * largest, limit)


def export_forecast(ending: str, rows: int, columns: int) -> Forecast:
    """Return the forecast of a table of results in a file with this ending, from the table."""
    nanoseconds, size = EXPORTED.get(ending, EXPORTED[".nc"])
    numbers = rows * columns
    return Forecast(
        "table",
        seconds=1e-9 * nanoseconds * numbers,
        disk=size * numbers,
        work=f"{counted(rows, 'row')} of {counted(columns, 'column')}",
    )


# -------------------------------------------------------------------------------------------------- measured


def timed(work: Callable[[], Any]) -> float:
    """Return the processor time (s) of a function call, of all its threads."""
    began = time.process_time()
    work()
    return time.process_time() - began


def timed_step(assembly: Assembly, companions: int = 0) -> float:
    """Return the processor time (s) of a step of this assembly on this machine, from two short runs. The step
    that is compiled for it is the one that the run needs. Raises KeyboardInterrupt on Ctrl-C.
    """
    choice = assembly.choice
    interval = min(choice.outputs_every, CHUNK_STEPS // 10)

    def chunk(steps: int) -> Assembly:
        outputs = math.ceil(steps / interval)
        return dataclasses.replace(
            assembly, choice=dataclasses.replace(choice, outputs_every=interval, outputs=outputs)
        )

    def run_chunk(assembly: Assembly) -> None:
        # A run keeps Ctrl-C in its status, which here would be lost.
        if run(assembly, companions=companions).status == Status.INTERRUPTED:
            raise KeyboardInterrupt

    short, long = chunk(1), chunk(CHUNK_STEPS)
    run_chunk(short)  # compiles
    brief = min(timed(lambda: run_chunk(short)) for _ in range(2))
    full = min(timed(lambda: run_chunk(long)) for _ in range(2))
    return max(full - brief, 0.1 * full) / (long.choice.steps - short.choice.steps)


def sampled_share(assembly: Assembly) -> float | None:
    """Return the bytes of the first outputs in a run file over those of their numbers; None for fewer than
    :data:`LEAST_SAMPLE` outputs in :data:`SAMPLE_STEPS` steps. Raises KeyboardInterrupt on Ctrl-C.
    """
    choice = assembly.choice
    outputs = min(SAMPLE, choice.outputs, SAMPLE_STEPS // choice.outputs_every)
    if outputs < LEAST_SAMPLE:
        return None
    record = run(dataclasses.replace(assembly, choice=dataclasses.replace(choice, outputs=outputs)))
    if record.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    rows = record.rows[:]
    return len(packed(rows)) / max(rows.nbytes, 1)


# ----------------------------------------------------------------------------------------------------- lanes


@dataclass(frozen=True)
class Stream:
    """Runs in the lanes of all cores: ``overhead`` (s) of one in Python, one after another; ``steps``:
    processor time (s) of the steps of one; ``width``: how many are requested together.
    """

    overhead: float
    stepping: float
    width: float = math.inf

    def seconds(self, count: float) -> float:
        """Return the time (s) of ``count`` runs: threads step while one of them assembles."""
        threads = min(cores(), self.width)
        return count * max(self.overhead, (self.overhead + self.stepping) / threads)


def stream(assembly: Assembly, width: float, lanes: int) -> Stream:
    """Return the stream of runs like this one, from the table."""
    cost = _alone(assembly)
    return Stream(
        ASSEMBLY,
        cost.seconds * LANES[lanes] / min(lanes, width) if cost.loop == "generated" else cost.seconds,
        width,
    )


def pilot(work: Callable[[int], Any], turns: int, count: int, width: float = math.inf) -> Stream:
    """Return the timed stream of runs of ``turns``: ``work`` makes ``count`` shorter runs.

    The difference between two lengths is the time of stepping, the rest is overhead.
    """
    work(1)  # compiles and imports
    first = timed(lambda: work(1)) / count
    if turns == 1:
        return Stream(0.5 * first, 0.5 * first, width)
    pilot_turns = min(turns, 4)
    turn = max(0.0, (timed(lambda: work(pilot_turns)) / count - first) / (pilot_turns - 1))
    return Stream(max(first - turn, 0.0), turn * turns, width)
