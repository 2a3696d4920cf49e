"""Members stepped in lanes on all cores: whoever ends makes room for the next at once, and none knows what
runs beside it.

Each thread has lanes of one topology. Members of other step sizes, and other numbers of steps a turn, share
them: each has its own outputs and its own end. The machine code runs without Python's lock; in Python a
member is looked at once for so many of its outputs, and when it ends.
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
from typing import Any, Protocol, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, Bounds, bounds, limited_rows
from ..compiler.runtime.cuda import MEMBERS, DeviceStream
from ..compiler.runtime.native import stream_lanes
from ..compiler.runtime.runner import Starter, Stream
from .record import Record, recorded_rows
from .transient import choose_loop

Array = NDArray[np.float64]

SECONDS, FIRST, GROWTH = (
    0.25,
    1000,
    4,
)  # of a call between two looks at the clock; steps of the first; from one to the next, at the most
PATIENCE = 0.2  # s between two looks at signals
AHEAD = 64  # members that wait while the next are made, where there are several threads


class Ending(Protocol):
    """What may have ended."""

    @property
    def ended(self) -> bool:
        """Whether it needs no more."""


class Lane:
    """A simulation in a lane, stepped by :func:`stepped`: every ``every`` steps it hands out the rows
    ``handed`` of its state.

    It keeps them all, unless a subclass overrides :meth:`take`, until it has ``ended``. It is ``doubtful``
    where numbers left all bounds. ``per`` is the number of outputs of a turn, or of all where there is no
    turn; ``done`` counts outputs after that of step 0.
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
    def ended(self) -> bool:
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
        """Return what takes its place, where it has to be made again."""
        return None

    @property
    def record(self) -> Record:
        """The record of the outputs that it keeps."""
        rows = np.concatenate(self.parts)
        return Record(self.assembly, np.arange(len(rows), dtype=np.int64) * self.every, rows, self.handed)


Kind: TypeAlias = tuple[int, str, int, int, int]
Found: TypeAlias = "queue.SimpleQueue[Ending | BaseException | None]"


class Kinds:
    """What members have in common that share lanes; long descriptions that were met before are known by the
    objects that they are.
    """

    def __init__(self) -> None:
        self.met: dict[tuple[int, int, str], tuple[Any, Any, int]] = {}
        self.numbers: dict[Any, int] = {}
        self.loops: dict[int, str] = {}

    def of(self, member: Lane) -> Kind:
        """Topology and rows that are handed out by their number, loop, length of tables, parts, outputs."""
        assembly, handed = member.assembly, member.handed
        key = id(assembly.topology), id(handed), member.loop
        if key not in self.met:
            number = self.numbers.setdefault(
                (assembly.topology, handed.tobytes(), member.loop), len(self.numbers)
            )
            if number not in self.loops:
                self.loops[number] = choose_loop(assembly, member.loop)  # type: ignore[arg-type]
            self.met[key] = assembly.topology, handed, number  # kept, so that nothing else comes to lie there
        number = self.met[key][2]
        return (
            number,
            self.loops[number],
            len(assembly.tables),
            assembly.mechanism.settings.parts,
            member.outputs,
        )


@dataclass
class Waiting:
    """Members that wait for a lane, by their kinds; they are made when they are asked for, ``ahead`` of them
    before, by one thread at a time.
    """

    source: Iterator[Lane | Ending]
    found: Found
    share: int  # that one thread takes at first, so that few members are shared fairly
    ahead: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)  # of what waits
    making: threading.Lock = field(
        default_factory=threading.Lock
    )  # of the source: who makes members holds up nobody for whom some wait
    queues: dict[Kind, deque[Lane]] = field(default_factory=dict)
    kinds: Kinds = field(default_factory=Kinds)

    def next(self, wanted: Kind | None) -> tuple[Kind, Lane] | None:
        """A member of a kind, or of any; None where there is none left."""
        if (found := self._first(wanted)) is not None:
            return found
        with self.making:
            while (found := self._first(wanted)) is None and self._make():
                pass
        return found

    def prepare(self, count: int) -> None:
        """Makes so many members before they are asked for, where fewer than ``ahead`` wait and no other
        thread makes some.
        """
        if self.ahead and self.making.acquire(blocking=False):
            try:
                while count and sum(map(len, self.queues.values())) < self.ahead and self._make():
                    count -= 1
            finally:
                self.making.release()

    def _first(self, wanted: Kind | None) -> tuple[Kind, Lane] | None:
        with self.lock:
            for found, waiting in self.queues.items():
                if waiting and wanted in (None, found):
                    return found, waiting.popleft()
        return None

    def _make(self) -> bool:
        """One more that waits; whether there is any."""
        for member in self.source:
            if member.ended:
                self.found.put(member)
                continue
            member = cast(Lane, member)
            found = self.kinds.of(member)
            with self.lock:
                self.queues.setdefault(found, deque()).append(member)
            return True
        return False


Client = TypeVar("Client", bound=Ending)


def stepped(
    members: Iterable[Client], count: int, *, alike: int | None = None, lanes: int | None = None, workers: int | None = None,
    stop: threading.Event | None = None, device: str | None = None, tick: Callable[[], None] | None = None,
) -> Iterator[Client]:  # fmt: skip
    """Step lanes, ``count`` of them or so, and yield each when it has ended, what had ended before as it is;
    with ``stop`` set, no more.

    ``lanes``: side by side in one vector register, :func:`~vfife.compiler.runtime.native.stream_lanes` if not
    given, or as many as there are members that may share one, which are ``alike``, all of them if not given;
    ``workers``: threads, one a core if not given. ``device``: "cuda" has a card step them, by one thread, as
    many side by side as it can. ``tick`` is called now and then while nothing ends.
    """
    if device == "cuda":
        lanes, workers = min(lanes or MEMBERS, count), 1
    found: Found = queue.SimpleQueue()
    ended, stop = threading.Event(), stop or threading.Event()
    workers = max(1, min(workers or os.cpu_count() or 1, count))
    share = max(1, -(-(alike or count) // workers))
    waiting = Waiting(iter(members), found, share, AHEAD if workers > 1 else 0)
    arguments = (
        waiting,
        found,
        lanes,
        lambda: ended.is_set() or stop.is_set(),
        DeviceStream if device == "cuda" else Stream,
    )
    threads = [threading.Thread(target=_work, args=arguments, daemon=True) for _ in range(workers)]
    for thread in threads:
        thread.start()
    try:
        while workers:
            try:
                one = found.get(timeout=PATIENCE)
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
        ended.set()
        for thread in threads:
            thread.join()


def _work(
    waiting: Waiting,
    found: Found,
    lanes: int | None,
    halted: Callable[[], bool],
    streaming: type[Stream | DeviceStream],
) -> None:
    """One thread: lanes of one kind after the other, until no member is left."""
    try:
        while not halted() and (first := waiting.next(None)) is not None:
            Lanes(*first, waiting, found, lanes, streaming).run(halted)
        found.put(None)
    except BaseException as error:
        found.put(error)


class Lanes:
    """The lanes of a thread, and who is in them."""

    def __init__(
        self,
        shared: Kind,
        first: Lane,
        waiting: Waiting,
        found: Found,
        lanes: int | None,
        streaming: type[Stream | DeviceStream],
    ) -> None:
        _, loop, tables, parts, outputs = shared
        topology = first.assembly.topology
        self.kind, self.waiting, self.found = shared, waiting, found
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
        self.room = FIRST

    def _next(self) -> Lane | None:
        found = self.waiting.next(self.kind)
        return None if found is None else found[1]

    def run(self, halted: Callable[[], bool]) -> None:
        """Until all have ended and no other waits."""
        while (self.members or any(self.next.values())) and not halted():
            if self.next and self.stream.beat == 0:
                self._fill()
                self.waiting.prepare(self.lanes)
            self._advance()
            self._look()

    def _fill(self) -> None:
        """Puts those that wait into the lanes that are free; a lane for which there is none repeats another."""
        for lane, member in self.next.items():
            if member is not None:
                assembly = member.assembly
                simulation = self.starter.begun(assembly.state, assembly.tables, np.stack(bounds(assembly)))
                member.start(simulation.state + 0.0)
                self.members[lane], self.begins[lane] = (
                    member,
                    self.stream.put(lane, simulation, member.every, member.outputs),
                )
        self.next.clear()
        for lane in set(range(self.lanes)) - set(self.members):
            self.stream.repeat(lane, next(iter(self.members)))

    def _advance(self) -> None:
        before, began = self.stream.done, time.perf_counter()
        self.stream.advance(min(self.room, self.stream.beat) if self.next else self.room)
        spent, made = time.perf_counter() - began, self.stream.done - before
        if made >= FIRST:
            self.room = max(1, min(GROWTH * max(self.room, made), int(made * SECONDS / max(spent, 1e-6))))

    def _look(self) -> None:
        """Each that has its outputs takes them, and makes room where it has ended."""
        stream = self.stream
        for lane, member in list(self.members.items()):
            broken = int(stream.broken[lane]) - int(self.begins[lane]) if stream.broken[lane] > 0.0 else -1
            if stream.at[lane] < stream.stop[lane] and broken < 0:
                continue
            member.take(stream.rows(lane), broken, stream.state(lane))
            if not member.ended:
                stream.go_on(lane, member.outputs)
                continue
            stream.leave(lane)
            del self.members[lane]
            other = member.end()
            if other is None:
                self.found.put(member)
            self.next[lane] = self._next() if other is None else other
