"""Members wait for lanes: they are made when they are asked for, once each, and who makes some holds up
nobody for whom others wait.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from support import four_bar
from vfife.compiler.runtime import native
from vfife.compiler.runtime.runner import Stream
from vfife.solvers import streaming
from vfife.solvers.ensemble import advance, placed
from vfife.solvers.streaming import Waiting

LONG = 30.0  # s, after which a test has failed


@dataclass
class Plain:
    """A member of a kind, which nobody steps."""

    number: int
    kind: str = "one"
    finished: bool = False


def waiting(source: Iterator[Any], ahead: int = 8) -> Waiting:
    return Waiting(
        source, queue.SimpleQueue(), 4, ahead, kinds=SimpleNamespace(of=lambda member: member.kind)
    )  # type: ignore[arg-type]


def number(found: Any) -> int:
    return int(found[1].number)


def test_a_batch_that_is_made_holds_up_nobody_for_whom_members_wait() -> None:
    begun, go_on = threading.Event(), threading.Event()

    def source() -> Iterator[Plain]:
        yield from map(Plain, range(3))
        begun.set()
        assert go_on.wait(LONG)
        yield Plain(3)

    members = waiting(source())
    assert number(members.next(None)) == 0
    maker = threading.Thread(target=members.prepare, args=(8,), daemon=True)
    maker.start()
    assert begun.wait(LONG), "what is wanted next is made before it is asked for"
    assert [number(members.next(None)) for _ in range(2)] == [1, 2], "these wait, so they are had at once"
    members.prepare(8)  # another one makes some
    go_on.set()
    assert number(members.next(None)) == 3
    maker.join(LONG)
    assert members.next(None) is None and not maker.is_alive()


def test_no_more_are_made_than_are_to_wait_and_none_for_one_thread() -> None:
    made: list[int] = []

    def source() -> Iterator[Plain]:
        for k in range(100):
            made.append(k)
            yield Plain(k)

    members = waiting(source(), ahead=5)
    for _ in range(4):
        members.prepare(2)
    assert made == list(range(5))
    members.ahead = 0
    members.next(None)
    members.prepare(4)
    assert made == list(range(5))


def test_members_of_another_kind_wait_and_those_that_have_ended_are_told() -> None:
    members = waiting(iter([Plain(0, "other"), Plain(1, finished=True), Plain(2), Plain(3, "other")]))
    assert number(members.next("one")) == 2  # type: ignore[arg-type]
    assert members.results.get_nowait().number == 1  # type: ignore[union-attr]
    assert members.next("one") is None  # type: ignore[arg-type]
    assert [number(members.next(None)) for _ in range(2)] == [0, 3] and members.next(None) is None


def test_many_threads_take_each_member_once() -> None:
    members, taken = waiting(map(Plain, range(400))), queue.SimpleQueue[int]()

    def take() -> None:
        while (found := members.next(None)) is not None:
            taken.put(number(found))
            members.prepare(3)

    threads = [threading.Thread(target=take, daemon=True) for _ in range(6)]
    for one in threads:
        one.start()
    for one in threads:
        one.join(LONG)
    assert sorted(taken.get_nowait() for _ in range(400)) == list(range(400)) and taken.empty()


@pytest.mark.parametrize(
    "features, contact, without", [("+sse2", 2, 2), ("+sse2,+avx", 4, 4), ("+sse2,+avx,+avx512f", 4, 8)]
)
def test_lanes_of_a_stream_follow_from_processor_and_contacts(
    features, contact, without, monkeypatch
) -> None:
    monkeypatch.setattr(native, "processor", lambda: ("some", features))
    assert [native.stream_lanes(count) for count in (0, 1, 6)] == [without, contact, contact]


@pytest.mark.parametrize("joints, wanted, found", [("C", None, 4), ("", None, 8), ("C", 8, 8), ("", 2, 2)])
def test_members_with_contact_have_four_lanes_where_there_are_eight(
    joints, wanted, found, monkeypatch
) -> None:
    """Also those without contact where so many share one thread; what is asked for is done. Bits are the same
    in all.
    """
    monkeypatch.setattr(native, "widest", lambda: 8)
    seen: list[int] = []

    class Seen(Stream):
        def __init__(self, topology: Any, lanes: int, *more: Any) -> None:
            seen.append(lanes)
            super().__init__(topology, lanes, *more)

    monkeypatch.setattr(streaming, "Stream", Seen)
    members = [placed(four_bar(joints, clearance=2e-4 * (1 + 0.05 * k)), 1e-5, 1, 20) for k in range(8)]
    rows = [one.last.rows.tobytes() for one in advance(members, lanes=wanted, workers=1)]
    assert seen == [found]
    assert rows == [one.last.rows.tobytes() for one in advance(members, lanes=1, workers=1)]
    seen.clear()
    advance(members[:2], workers=1)
    assert seen == [2], "no more than there are members"


@pytest.mark.parametrize(("workers", "ahead"), [(1, 0), (2, 3)])
def test_a_thread_prepares_as_many_simulations_as_it_has_lanes(workers, ahead, monkeypatch) -> None:
    """All threads together have no more than the limit waiting; a single thread prepares none."""
    seen: list[tuple[int, int]] = []

    class Seen(Waiting):
        def prepare(self, count: int) -> None:
            seen.append((count, self.ahead))
            super().prepare(count)
            assert sum(map(len, self.queues.values())) <= self.ahead

    monkeypatch.setattr(streaming, "Waiting", Seen)
    monkeypatch.setattr(streaming, "AHEAD", 3)
    members = [placed(four_bar("C"), 1e-5, 1, 20) for _ in range(9)]
    assert len(advance(members, lanes=2, workers=workers)) == 9
    assert set(seen) == {(2, ahead)}


def test_a_lane_keeps_its_outputs_and_ends_where_numbers_leave_all_bounds() -> None:
    """Sound outputs are kept to the last; a number beyond its bounds, one that is none, or a step that the
    loop found broken ends it at once.
    """
    assembly = placed(four_bar("C"), 1e-5, 1, 4)
    sound = np.tile(assembly.state[streaming.recorded_rows(assembly)], (2, 1))

    def lane() -> streaming.Lane:
        found = streaming.Lane(0, assembly)
        found.start(assembly.state)
        return found

    whole = lane()
    for _ in range(2):
        assert not whole.finished and whole.outputs == 4
        whole.take(sound, -1, assembly.state)
    assert whole.finished and not whole.doubtful and whole.done == 4
    assert whole.record.rows.shape == (5, len(whole.handed)) and whole.record.steps.tolist() == [
        k * whole.every for k in range(5)
    ]
    column = int(whole.bounds.columns[0])
    for value, broken in ((float("nan"), -1), (1e9, -1), (None, 7)):
        rows, other = sound.copy(), lane()
        if value is not None:
            rows[1, column] = value
        other.take(rows, broken, assembly.state)
        assert other.doubtful and other.finished
