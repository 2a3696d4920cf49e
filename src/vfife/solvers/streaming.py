"""Many simulations in lanes on all cores: a simulation that ends is replaced by the next at once, and none
depends on its neighbours.

**Lanes.** Each thread has lanes of one topology, stepped by one compiled loop. Simulations with different
steps and different numbers of steps in a turn share a register, because each has its own outputs and its own
end. Batches that wait for their longest client would leave most lanes idle: simulations that run until they
settle end after very different times. A lane is a place in a register; an object of :class:`Lane` is the
simulation in it, so that "lanes that wait" are simulations without a place.

**Threads.** Machine code runs without Python's global lock. Python sees a simulation only when it has a
number of outputs (a turn) or ends. Threads take lanes from one queue (:class:`Waiting`), fill those that are
free between two calls of the loop, and put simulations that have ended into another. The main thread yields
these and receives signals.

**Bits.** A lane's results do not depend on its neighbours, on the thread, or on the step of the stream at
which it began.
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

from ..assembly.assembled import Assembly, Bounds, limited_rows
from ..compiler.runtime.cuda import CARD_CASES, DeviceStream
from ..compiler.runtime.native import stream_lanes
from ..compiler.runtime.runner import Starter, Stream
from .interrupts import QUICK, ChunkSize
from .record import Record, recorded_rows
from .transient import choose_loop

Array = NDArray[np.float64]

PATIENCE = 0.2  # s between two checks for signals
AHEAD = 64  # largest number of simulations that are made before a lane is free, if there are several threads


class Simulation(Protocol):
    """A simulation that may have ended, even before it was in a lane."""

    @property
    def finished(self) -> bool:
        """Whether it needs no further step."""


class Lane:
    """A simulation in a lane of :func:`stepped`, which outputs the rows ``handed`` after every ``every``
    steps.

    It keeps all outputs in ``parts`` until it has ``finished``, unless a subclass overrides :meth:`take`. It
    is ``doubtful`` if numbers left their bounds. ``per`` is the number of outputs in a turn, or in the run if
    there is no turn; ``done`` counts outputs after that of step 0. ``limited`` are the columns with bounds,
    if they are known; ``loop`` is the name of a loop or "auto".
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
        """Bounds of the output rows."""
        return Bounds(self.assembly, self.handed, self.limited)

    @property
    def outputs(self) -> int:
        """Number of outputs up to the next call of :meth:`take`."""
        return self.per

    @property
    def finished(self) -> bool:
        """Whether it needs no further step."""
        return self.doubtful or self.done >= self.assembly.choice.outputs

    def start(self, state: Array) -> None:
        """Receive the state after step 0, shape (rows,), which is the first output."""
        self.parts.append(state[None, self.handed])

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Receive outputs, shape (outputs, handed), and the present state, (rows,). There are fewer outputs
        than :attr:`outputs` if the lane broke, which was found after step ``broken``; -1: it did not.
        """
        self.doubtful = broken >= 0 or bool(self.bounds.unsound(rows).any())
        self.parts.append(rows)
        self.done += len(rows)

    def end(self) -> Lane | None:
        """Return the lane that takes its place, if the simulation has to be repeated; else None."""
        return None

    @property
    def record(self) -> Record:
        """The record of the outputs that the lane has kept."""
        rows = np.concatenate(self.parts)
        return Record(self.assembly, np.arange(len(rows), dtype=np.int64) * self.every, rows, self.handed)


Kind: TypeAlias = tuple[int, str, int, int, int]
Results: TypeAlias = "queue.SimpleQueue[Simulation | BaseException | None]"


class Kinds:
    """Kinds of lanes; lanes of one kind share a compiled loop.

    Comparing topologies takes as long as several steps, and the lanes of a study have the same objects. A
    kind is therefore looked up by the identity of these objects first.
    """

    def __init__(self) -> None:
        self.known: dict[tuple[int, int, str], tuple[Any, Any, int]] = {}
        self.numbers: dict[Any, int] = {}
        self.loops: dict[int, str] = {}

    def of(self, lane: Lane) -> Kind:
        """Return the kind of a lane: number of its topology, rows and loop; loop; length of tables; parts;
        outputs between two calls.
        """
        assembly, handed = lane.assembly, lane.handed
        key = id(assembly.topology), id(handed), lane.loop
        if key not in self.known:
            number = self.numbers.setdefault(
                (assembly.topology, handed.tobytes(), lane.loop), len(self.numbers)
            )
            if number not in self.loops:
                self.loops[number] = choose_loop(assembly, lane.loop)  # type: ignore[arg-type]
            # The objects are kept, so that no other object gets the same identity.
            self.known[key] = assembly.topology, handed, number
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
    """Lanes that wait to be filled in, by kind.

    They are made from ``source`` when they are needed, or up to ``ahead`` of them before, by one thread at a
    time. Making a lane may take as long as running it, so it has a lock of its own: threads that find a
    waiting lane do not wait for one that is being made.
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
        """Return a lane of a kind, or of any kind for None; None if there is none left."""
        if (pair := self._first(kind)) is not None:
            return pair
        with self.making:
            while (pair := self._first(kind)) is None and self._make():
                pass
        return pair

    def prepare(self, count: int) -> None:
        """Make up to ``count`` more lanes before they are needed, but stop when ``ahead`` wait, and make none
        while another thread does.
        """
        if self.ahead and self.making.acquire(blocking=False):
            try:
                while count and sum(map(len, self.queues.values())) < self.ahead and self._make():
                    count -= 1
            finally:
                self.making.release()

    def _first(self, kind: Kind | None) -> tuple[Kind, Lane] | None:
        with self.lock:
            for queued, waiting in self.queues.items():
                if waiting and kind in (None, queued):
                    return queued, waiting.popleft()
        return None

    def _make(self) -> bool:
        """Add one more lane; return False if there is none. Simulations that have finished before they began
        become results at once.
        """
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
    """Options of the hardware that steps lanes.

    ``lanes``: number in one vector register, by default
    :func:`~vfife.compiler.runtime.native.stream_lanes`. ``workers``: number of threads, by default one for
    each core. ``device``: "cuda" for a graphics card, which steps as many lanes as it can.
    """

    lanes: int | None
    workers: int | None
    device: str | None


def stepped(
    clients: Iterable[Client], count: int, *, alike: int | None = None, stop: threading.Event | None = None,
    tick: Callable[[], None] | None = None, **processor: Unpack[Processor],
) -> Iterator[Client]:  # fmt: skip
    """Step the lanes ``clients``, about ``count`` of them, and yield each when it has ended; simulations that
    have finished before they began are yielded as they are.

    ``alike``: number of lanes that may share a register, all by default: no thread has more lanes than it
    gets simulations. With 0 ``workers`` this thread steps all of them before the first is yielded, which
    suits short simulations. Setting ``stop`` ends the iteration. ``tick`` is called now and then while
    nothing ends.
    """
    lanes, workers, device = processor.get("lanes"), processor.get("workers"), processor.get("device")
    if device == "cuda":
        # A card steps all its lanes in one call, so a second thread would only wait for it.
        lanes, workers = min(lanes or CARD_CASES, count), 1
    results: Results = queue.SimpleQueue()
    finished, stop = threading.Event(), stop or threading.Event()
    workers = min(os.cpu_count() or 1 if workers is None else workers, max(1, count))
    # Few simulations are divided evenly: a thread that filled a whole register would leave other cores idle.
    share = max(1, -(-(alike or count) // max(1, workers)))
    waiting = Waiting(iter(clients), results, share, AHEAD if workers > 1 else 0)
    arguments = (
        waiting,
        results,
        lanes,
        lambda: finished.is_set() or stop.is_set(),
        DeviceStream if device == "cuda" else Stream,
    )
    threads = [threading.Thread(target=_work, args=arguments, daemon=True) for _ in range(workers)]
    if not workers:
        _work(*arguments)
        workers = 1
    for thread in threads:
        thread.start()
    try:
        while workers:
            try:
                # Waiting without a limit would never call ``tick``, and would keep signals from the main
                # thread on some systems.
                result = results.get(timeout=PATIENCE)
            except queue.Empty:
                if tick is not None:
                    tick()
                continue
            if isinstance(result, BaseException):
                raise result
            if result is None:
                workers -= 1
            else:
                yield cast(Client, result)
    finally:
        # This runs also if the caller abandons the iteration or an exception ends it: threads stop after the
        # present call of their loop, a quarter of a second at most, and none outlives the iteration.
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
    """Run one thread: step lanes of one kind after the other, until none is left."""
    try:
        while not halted() and (first := waiting.next(None)) is not None:
            # A loop serves one kind, so a thread turns to another kind only when none of its own is left.
            Lanes(*first, waiting, results, lanes, streaming).run(halted)
        results.put(None)
    except BaseException as error:
        results.put(error)


class Lanes:
    """The lanes of a thread, and the simulations in them (``clients``, by lane).

    ``next`` are the lanes that became free since the last :meth:`_fill`, each with the simulation that will
    fill it, or None. A lane is filled only when the stream's ``beat`` is zero: simulations are then checked
    at the same steps of their own as in any other stream, and have the same bits.
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
        # The data-driven loop has one lane. Other loops have as many as a register holds, but no more than
        # the power of two that contains the share of this thread, because unused lanes cost as much as used
        # ones.
        lanes = 1 if loop != "generated" else lanes or min(usual, 1 << (waiting.share - 1).bit_length())
        sound, limited = recorded_rows(first.assembly), limited_rows(first.assembly)
        self.stream = streaming(topology, lanes, loop, first.handed, outputs, sound, limited, tables, parts)
        self.lanes = self.stream.lanes
        self.starter = Starter(topology, lanes if streaming is Stream else usual, loop, tables, parts)
        self.clients: dict[int, Lane] = {}
        self.next: dict[int, Lane | None] = {lane: first if lane == 0 else None for lane in range(self.lanes)}
        # Lanes beyond the share are never filled and repeat another one (:meth:`_fill`): more simulations
        # here would be fewer for other threads.
        for lane in range(1, min(self.lanes, waiting.share)):
            self.next[lane] = self._next()
        self.begins = np.zeros(self.lanes, dtype=np.int64)
        self.pace = ChunkSize(first=QUICK)

    def _next(self) -> Lane | None:
        pair = self.waiting.next(self.kind)
        return None if pair is None else pair[1]

    def run(self, halted: Callable[[], bool]) -> None:
        """Step until all simulations have ended and no other waits."""
        while (self.clients or any(self.next.values())) and not halted():
            if self.next and self.stream.beat == 0:
                self._fill()
                # ``next`` is empty now; in time all lanes become free, and each needs a simulation.
                self.waiting.prepare(self.lanes)
            self._advance()
            self._look()

    def _fill(self) -> None:
        """Fill free lanes. A lane for which no simulation waits repeats another one, because all lanes of a
        register are stepped anyway, and its own events would cost time.
        """
        for lane, client in self.next.items():
            if client is not None:
                assembly = client.assembly
                limits = np.stack([client.bounds.low, client.bounds.high])
                simulation = self.starter.started(assembly.state, assembly.tables, limits)
                client.start(simulation.state + 0.0)
                self.clients[lane] = client
                self.begins[lane] = self.stream.put(lane, simulation, client.every, client.outputs)
        self.next.clear()
        for lane in set(range(self.lanes)) - set(self.clients):
            self.stream.repeat(lane, next(iter(self.clients)))

    def _advance(self) -> None:
        """Call the loop once. If lanes are free, the call ends at the next beat, because lanes are filled
        only then; otherwise it lasts a quarter of a second at most, because signals wait for it.
        """
        steps_before, began = self.stream.done, time.perf_counter()
        self.stream.advance(min(self.pace.steps, self.stream.beat) if self.next else self.pace.steps)
        spent, steps = time.perf_counter() - began, self.stream.done - steps_before
        # Short calls consist mostly of overhead, and would make the next ones shorter still.
        if steps >= QUICK:
            self.pace.learn(steps, spent)

    def _look(self) -> None:
        """Hand outputs to each simulation that has all for which it waits, or that broke; free its lane if it
        has ended.
        """
        stream = self.stream
        for lane, client in list(self.clients.items()):
            broken = int(stream.broken[lane]) - int(self.begins[lane]) if stream.broken[lane] > 0.0 else -1
            # Most calls end because one lane is ready. The others stay in the stream without a copy of their
            # outputs.
            if stream.at[lane] < stream.stop[lane] and broken < 0:
                continue
            client.take(stream.rows(lane), broken, stream.state(lane))
            if not client.finished:
                stream.go_on(lane, client.outputs)
                continue
            stream.leave(lane)
            del self.clients[lane]
            # A simulation that has to be repeated keeps its lane instead of joining the queue: its kind has a
            # compiled loop here.
            successor = client.end()
            if successor is None:
                self.results.put(client)
            self.next[lane] = self._next() if successor is None else successor
