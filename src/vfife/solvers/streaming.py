"""Many simulations in lanes on all cores: a simulation that ends makes room for the next at once, and none
depends on its neighbours.

Each thread has lanes of one topology, which it steps by one compiled loop. Simulations with other steps, and
other numbers of steps a turn, share them: each has its own outputs and its own end. To wait for the longest
of a batch instead would leave most lanes idle, as simulations that settle end after very different times. The
machine code runs without Python's global lock; Python sees a simulation once for so many of its outputs, and
when it ends.
"""

from __future__ import annotations

import os
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol, TypeAlias, TypedDict, TypeVar, Unpack, cast

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, Bounds, bounds, limited_rows
from ..compiler.runtime.cuda import MEMBERS, DeviceStream
from ..compiler.runtime.native import stream_lanes
from ..compiler.runtime.runner import Starter, Stream
from .interrupts import QUICK, ChunkSize
from .record import Record, recorded_rows
from .transient import choose_loop

Array = NDArray[np.float64]

PATIENCE = 0.2  # s between two checks for signals
AHEAD = 64  # lanes that are made before they are needed, if there are several threads


class Simulation(Protocol):
    """A simulation that may have ended, even before it was in a lane."""

    @property
    def finished(self) -> bool:
        """Whether it needs no further step."""


class Lane:
    """A simulation in a lane of :func:`stepped`: after ``every`` steps it hands out the rows ``handed`` of
    its state.

    It keeps them all, unless a subclass overrides :meth:`take`, until it has ``finished``. It is
    ``doubtful`` if
    numbers left all bounds. ``per`` is the number of outputs of a turn, or of all where there is no turn;
    ``done`` counts outputs after that of step 0.
    """

    def __init__(
        self,
        number: int,
        assembly: Assembly,
        handed: NDArray[np.uint32] | None = None,
        *,
        limited: NDArray[np.intp] | None = None,
        loop: str = "auto",
    ) -> None:
        choice = assembly.choice
        self.number, self.assembly, self.loop, self.limited = number, assembly, loop, limited
        self.handed = recorded_rows(assembly) if handed is None else handed
        self.every, self.per = choice.outputs_every, choice.outputs
        if choice.turn is not None:
            self.per = round(choice.turn / (choice.step * choice.outputs_every))
        self.parts: list[Array] = []
        self.done, self.doubtful = 0, False

    @cached_property
    def bounds(self) -> Bounds:
        """Bounds of the rows handed out; ``limited`` are the columns that have some, where they are known."""
        return Bounds(self.assembly, self.handed, self.limited)

    @property
    def outputs(self) -> int:
        """Outputs up to the next call of :meth:`take`."""
        return self.per

    @property
    def finished(self) -> bool:
        """Whether it needs no further step."""
        return self.doubtful or self.done >= self.assembly.choice.outputs

    def start(self, state: Array) -> None:
        """Take the output of step 0 from the state after its first step, shape (rows,)."""
        self.parts.append(state[None, self.handed])

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Take outputs, shape (outputs, handed), fewer where it broke after step ``broken`` (-1: it did not),
        and its present state, (rows,).
        """
        self.doubtful = broken >= 0 or bool(self.bounds.unsound(rows).any())
        self.parts.append(rows)
        self.done += len(rows)

    def end(self) -> Lane | None:
        """Return the lane that takes its place, if it has to be repeated."""
        return None

    @property
    def record(self) -> Record:
        """The record of the outputs that it keeps."""
        rows = np.concatenate(self.parts)
        return Record(self.assembly, np.arange(len(rows), dtype=np.int64) * self.every, rows, self.handed)


Kind: TypeAlias = tuple[int, str, int, int, int]
Results: TypeAlias = "queue.SimpleQueue[Simulation | BaseException | None]"


class Kinds:
    """Kinds of lanes: those of one kind share a compiled loop.

    To compare topologies takes as long as some steps, and lanes of a study have the same objects. So a kind
    is looked up by the identity of these objects first.
    """

    def __init__(self) -> None:
        self.known: dict[tuple[int, int, str], tuple[Any, Any, int]] = {}
        self.numbers: dict[Any, int] = {}
        self.loops: dict[int, str] = {}

    def of(self, lane: Lane) -> Kind:
        """Number of its topology, rows and loop; loop, length of tables, parts and outputs."""
        assembly, handed = lane.assembly, lane.handed
        key = id(assembly.topology), id(handed), lane.loop
        if key not in self.known:
            number = self.numbers.setdefault(
                (assembly.topology, handed.tobytes(), lane.loop), len(self.numbers)
            )
            if number not in self.loops:
                self.loops[number] = choose_loop(assembly, lane.loop)  # type: ignore[arg-type]
            self.known[key] = (
                assembly.topology,
                handed,
                number,
            )  # the objects are kept, so that no other ones get their identity
        number = self.known[key][2]
        return (
            number,
            self.loops[number],
            len(assembly.tables),
            assembly.mechanism.settings.parts,
            lane.outputs,
        )


@dataclass
class Waiting:
    """Lanes that wait for room, by their kinds.

    They are made when they are needed, or ``ahead`` of them before, by one thread at a time. A lock of its
    own guards the making, so that it holds up only threads for which none waits.
    """

    source: Iterator[Lane | Simulation]
    results: Results
    share: int  # of all, that one thread takes at first, so that few lanes are shared fairly
    ahead: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)  # guards the queues
    making: threading.Lock = field(default_factory=threading.Lock)  # guards the source
    queues: dict[Kind, deque[Lane]] = field(default_factory=dict)
    kinds: Kinds = field(default_factory=Kinds)

    def next(self, kind: Kind | None) -> tuple[Kind, Lane] | None:
        """A lane of a kind, or of any; None if there is none left."""
        if (pair := self._first(kind)) is not None:
            return pair
        with self.making:
            while (pair := self._first(kind)) is None and self._make():
                pass
        return pair

    def prepare(self, count: int) -> None:
        """Make lanes before they are needed, if fewer than ``ahead`` wait and no other thread makes some."""
        if self.ahead and self.making.acquire(blocking=False):
            try:
                while count and sum(map(len, self.queues.values())) < self.ahead and self._make():
                    count -= 1
            finally:
                self.making.release()

    def _first(self, kind: Kind | None) -> tuple[Kind, Lane] | None:
        with self.lock:
            for own, waiting in self.queues.items():
                if waiting and kind in (None, own):
                    return own, waiting.popleft()
        return None

    def _make(self) -> bool:
        """Let one more wait; False if there is none. What has finished already is a result at once."""
        for lane in self.source:
            if lane.finished:
                self.results.put(lane)
                continue
            lane = cast(Lane, lane)
            kind = self.kinds.of(lane)
            with self.lock:
                self.queues.setdefault(kind, deque()).append(lane)
            return True
        return False


Client = TypeVar("Client", bound=Simulation)


class Processor(TypedDict, total=False):
    """What steps lanes.

    ``lanes``: side by side in one vector register, :func:`~vfife.compiler.runtime.native.stream_lanes` if not
    given. ``workers``: threads, one a core if not given. ``device``: "cuda" has a card step them, by one
    thread, as many side by side as it can.
    """

    lanes: int | None
    workers: int | None
    device: str | None


def stepped(
    members: Iterable[Client], count: int, *, alike: int | None = None, stop: threading.Event | None = None,
    tick: Callable[[], None] | None = None, **processor: Unpack[Processor],
) -> Iterator[Client]:  # fmt: skip
    """Step lanes, ``count`` of them or so, and yield each when it has ended, what had ended before as it is;
    with ``stop`` set, no more.

    ``alike``: lanes that may share a register, all if not given; no more are side by side. ``tick`` is called
    now and then while nothing ends.
    """
    lanes, workers, device = processor.get("lanes"), processor.get("workers"), processor.get("device")
    if device == "cuda":
        lanes, workers = min(lanes or MEMBERS, count), 1
    results: Results = queue.SimpleQueue()
    finished, stop = threading.Event(), stop or threading.Event()
    workers = max(1, min(workers or os.cpu_count() or 1, count))
    share = max(1, -(-(alike or count) // workers))
    waiting = Waiting(iter(members), results, share, AHEAD if workers > 1 else 0)
    arguments = (
        waiting,
        results,
        lanes,
        lambda: finished.is_set() or stop.is_set(),
        DeviceStream if device == "cuda" else Stream,
    )
    threads = [threading.Thread(target=_work, args=arguments, daemon=True) for _ in range(workers)]
    for thread in threads:
        thread.start()
    try:
        while workers:
            try:
                one = results.get(timeout=PATIENCE)
            except queue.Empty:
                if tick is not None:
                    tick()
                continue
            if isinstance(one, BaseException):
                raise one
            if one is None:
                workers -= 1
            else:
                yield cast(Client, one)
    finally:
        finished.set()
        for thread in threads:
            thread.join()


def _work(
    waiting: Waiting,
    results: Results,
    lanes: int | None,
    halted: Callable[[], bool],
    streaming: type[Stream | DeviceStream],
) -> None:
    """One thread: lanes of one kind after the other, until none is left."""
    try:
        while not halted() and (first := waiting.next(None)) is not None:
            Lanes(*first, waiting, results, lanes, streaming).run(halted)
        results.put(None)
    except BaseException as error:
        results.put(error)


class Lanes:
    """The lanes of a thread, and the simulations in them.

    ``beat``: the stream can take a simulation in only between two of its own checks of outputs, when it is
    zero.
    """

    def __init__(
        self,
        shared: Kind,
        first: Lane,
        waiting: Waiting,
        results: Results,
        lanes: int | None,
        streaming: type[Stream | DeviceStream],
    ) -> None:
        _, loop, tables, parts, outputs = shared
        topology = first.assembly.topology
        self.kind, self.waiting, self.results = shared, waiting, results
        usual = stream_lanes(len(topology.contact_bearing))
        lanes = 1 if loop != "generated" else lanes or min(usual, 1 << (waiting.share - 1).bit_length())
        sound, limited = recorded_rows(first.assembly), limited_rows(first.assembly)
        self.stream = streaming(topology, lanes, loop, first.handed, outputs, sound, limited, tables, parts)
        self.lanes = self.stream.lanes
        self.starter = Starter(topology, lanes if streaming is Stream else usual, loop, tables, parts)
        self.members: dict[int, Lane] = {}
        self.next: dict[int, Lane | None] = {lane: first if lane == 0 else None for lane in range(self.lanes)}
        for lane in range(1, min(self.lanes, waiting.share)):
            self.next[lane] = self._next()
        self.begins = np.zeros(self.lanes, dtype=np.int64)
        self.pace = ChunkSize(first=QUICK)

    def _next(self) -> Lane | None:
        pair = self.waiting.next(self.kind)
        return None if pair is None else pair[1]

    def run(self, halted: Callable[[], bool]) -> None:
        """Step until all have ended and no other waits."""
        while (self.members or any(self.next.values())) and not halted():
            if self.next and self.stream.beat == 0:
                self._fill()
                self.waiting.prepare(self.lanes)
            self._advance()
            self._look()

    def _fill(self) -> None:
        """Fill free lanes; a lane for which no simulation waits repeats another, because all lanes of a
        register step anyway.
        """
        for lane, member in self.next.items():
            if member is not None:
                assembly = member.assembly
                simulation = self.starter.started(assembly.state, assembly.tables, np.stack(bounds(assembly)))
                member.start(simulation.state + 0.0)
                self.members[lane], self.begins[lane] = (
                    member,
                    self.stream.put(lane, simulation, member.every, member.outputs),
                )
        self.next.clear()
        for lane in set(range(self.lanes)) - set(self.members):
            self.stream.repeat(lane, next(iter(self.members)))

    def _advance(self) -> None:
        """One call of the loop. It ends with the next beat if lanes are free, because they are filled at
        beats alone.
        """
        before, began = self.stream.done, time.perf_counter()
        self.stream.advance(min(self.pace.room, self.stream.beat) if self.next else self.pace.room)
        spent, steps = time.perf_counter() - began, self.stream.done - before
        if steps >= QUICK:
            self.pace.learn(steps, spent)

    def _look(self) -> None:
        """Hand outputs to each simulation that has all it waits for, or that broke; make room if it has
        ended.
        """
        stream = self.stream
        for lane, member in list(self.members.items()):
            broken = int(stream.broken[lane]) - int(self.begins[lane]) if stream.broken[lane] > 0.0 else -1
            if stream.at[lane] < stream.stop[lane] and broken < 0:
                continue
            member.take(stream.rows(lane), broken, stream.state(lane))
            if not member.finished:
                stream.go_on(lane, member.outputs)
                continue
            stream.leave(lane)
            del self.members[lane]
            other = member.end()
            if other is None:
                self.results.put(member)
            self.next[lane] = self._next() if other is None else other
