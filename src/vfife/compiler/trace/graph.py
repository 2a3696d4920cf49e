"""The graph of a mechanism's joints: which joints share a body, the order of their elimination, the profile
of the constraints' equations.

**Order of elimination.** From the last joint of a chain to the first, a pivot waits for the one before it,
and so does each row of both substitutions. From both ends to the middle (Babuška 1972) half as many wait,
with the same operations; in a tree all leaves begin at once. That is the order of least degree (Tinney and
Walker 1967), of joints alike the one that waits least: no joint then gets more neighbours than it needs.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from ...kernels.topology import BEARING, LINE, ROUND, Topology


class Couple(NamedTuple):
    """A constraint's row, one before it or the same, a free body that both move, and the body's side in each:
    bearing, journal or carrier.
    """

    row: int
    other: int
    body: int
    side: int
    other_side: int


@dataclass(frozen=True)
class Graph:
    """Derived lists, in the one order that every loop sums in.

    ``order`` is that of the joints in the elimination, ``rows`` the numbers of their constraints in it,
    ``closing`` whether each of these closes a loop. The lower half of the equations' matrix is kept row by
    row from the first entry that is not zero: row r has columns ``first[r]`` to r, of which column c is entry
    ``start[r]`` + c of ``size``. ``jointed`` bodies are in contacts, or hang together with one; ``pinned``
    ones are in ideal joints. Of contacts, ``shared`` says that forces of another joint reach its bodies,
    ``constrained`` that they hang in ideal joints, ``simultaneous`` that their forces are solved at once.
    """

    order: tuple[int, ...]
    rows: tuple[int, ...]
    jointed: tuple[int, ...]
    pinned: tuple[int, ...]
    shared: tuple[bool, ...]
    constrained: tuple[bool, ...]
    couples: tuple[Couple, ...]
    first: tuple[int, ...]
    start: tuple[int, ...]
    size: int
    close_again: bool
    closing: tuple[bool, ...]
    simultaneous: tuple[bool, ...]


@lru_cache(maxsize=64)
def derive(topology: Topology) -> Graph:
    """The graph of a topology."""
    free = set(topology.free)
    clearances = list(zip(topology.contact_bearing, topology.contact_journal, strict=True))
    ideals = list(zip(topology.joint_bearing, topology.joint_journal, topology.carriers, strict=True))
    uses = Counter(body for pair in [*clearances, *ideals] for body in set(pair) if body in free)
    pinned = tuple(sorted({body for pair in ideals for body in pair if body in free}))
    constrained = tuple(any(body in pinned for body in pair) for pair in clearances)
    armed = set(
        topology.trig
    )  # on an arm, friction turns the body against the normal force: it counts as shared too
    shared = tuple(any(uses[body] > 1 or body in armed & free for body in pair) for pair in clearances)
    touched = {body for pair in clearances for body in pair if body in free}
    jointed = tuple(sorted(touched | (set(pinned) if any(constrained) else set())))
    starts = topology.constraint_starts
    order = elimination_order([sorted(set(three) & free) for three in ideals])
    rows = tuple(row for joint in order for row in range(starts[joint], starts[joint + 1]))
    sides = [ideals[joint] for joint in order for _ in range(starts[joint + 1] - starts[joint])]
    couples = _couples(sides, free)
    reach = list(range(len(sides)))
    for couple in couples:
        reach[couple.row] = min(reach[couple.row], couple.other)
    # Elimination fills in only between the first entry of a row and its diagonal, so the profile of the
    # matrix is that of its factors.
    start, size = [], 0
    for r, low in enumerate(reach):
        start.append(size - low)
        size += r - low + 1
    again = any(constrained)
    closing = _closing([(starts[joint + 1] - starts[joint], ideals[joint][:2]) for joint in order], free)
    simultaneous = _simultaneous(topology, constrained)
    return Graph(
        order,
        rows,
        jointed,
        pinned,
        shared,
        constrained,
        couples,
        tuple(reach),
        tuple(start),
        size,
        again,
        closing,
        simultaneous,
    )


def _simultaneous(topology: Topology, constrained: tuple[bool, ...]) -> tuple[bool, ...]:
    """Contacts from outside, rounds and corners, that share a free body with another: they may begin in one
    step and are solved together.
    """
    kinds = topology.contact_kind or (BEARING,) * len(topology.contact_bearing)
    pairs = list(zip(topology.contact_bearing, topology.contact_journal, strict=True))
    outside = [kind in (ROUND, LINE) and not hangs for kind, hangs in zip(kinds, constrained, strict=True)]
    free = set(topology.free)
    uses = Counter(
        body for pair, counts in zip(pairs, outside, strict=True) if counts for body in pair if body in free
    )
    return tuple(
        counts and any(uses[body] > 1 for body in pair) for pair, counts in zip(pairs, outside, strict=True)
    )


def _closing(order: list[tuple[int, tuple[int, int]]], free: set[int]) -> tuple[bool, ...]:
    """Whether each constraint joins bodies that joints before its own hold together already; bodies whose
    motion is prescribed are one.

    Joints are given in their order, each with its rows and its two bodies. ``part`` leads from a body to one
    that represents all that it hangs together with (union and find): a joint whose bodies have the same
    representative closes a loop.
    """
    part: dict[int, int] = {}
    closing: list[bool] = []
    for count, pair in order:
        first, second = (body if body in free else 0 for body in pair)
        while first in part:
            first = part[first]
        while second in part:
            second = part[second]
        if first != second:
            part[max(first, second)] = min(first, second)
        closing += [first == second] * count
    return tuple(closing)


def _couples(sides: list[tuple[int, int, int]], free: set[int]) -> tuple[Couple, ...]:
    """Pairs of constraint rows that share a body; ``sides`` are the bearing, journal and carrier of each row."""
    uses: dict[int, list[tuple[int, int]]] = {}
    for row, three in enumerate(sides):
        for side, body in enumerate(three):
            if body in free:
                uses.setdefault(body, []).append((row, side))
    pairs = (
        (body, one, two) for body, rows in uses.items() for one in rows for two in rows if two[0] <= one[0]
    )
    return tuple(
        sorted(Couple(row, other, body, side, other_side) for body, (row, side), (other, other_side) in pairs)
    )


def elimination_order(joints: Sequence[Sequence[int]]) -> tuple[int, ...]:
    """Joints, each given by the free bodies that it joins, in the order of their elimination, those that wait
    for one another side by side.
    """
    at: dict[int, set[int]] = {}
    for joint, bodies in enumerate(joints):
        for body in bodies:
            at.setdefault(body, set()).add(joint)
    neighbours = [
        set().union(*(at[body] for body in bodies)) - {joint} for joint, bodies in enumerate(joints)
    ]
    waits = [0] * len(joints)
    after: list[list[int]] = [[] for _ in joints]  # joints of which this is the next that waits for them
    roots: list[int] = []
    place: dict[int, int] = {}
    ready = [(len(others), 0, joint) for joint, others in enumerate(neighbours)]
    heapq.heapify(ready)
    eliminated: list[int] = []
    # Entries of the heap are never removed: one whose degree or wait is no longer the joint's own is stale,
    # and a newer one is behind it.
    while ready:
        degree, waited, joint = heapq.heappop(ready)
        if joint in place or (degree, waited) != (len(neighbours[joint]), waits[joint]):
            continue
        place[joint] = len(eliminated)
        eliminated.append(joint)
        for other in neighbours[joint]:
            neighbours[other] |= neighbours[joint]
            neighbours[other] -= {joint, other}
            waits[other] = max(waits[other], waits[joint] + 1)
            heapq.heappush(ready, (len(neighbours[other]), waits[other], other))
    for joint in eliminated:
        later = min(neighbours[joint], key=place.__getitem__, default=None)
        (roots if later is None else after[later]).append(joint)
    return _behind(roots, after)


def _behind(roots: list[int], after: list[list[int]]) -> tuple[int, ...]:
    """Every joint behind all that it waits for, and these one chain after the other: a profile is as narrow
    as it can be then.
    """
    order: list[int] = []
    waiting = roots[::-1]
    entered: set[int] = set()
    while waiting:
        joint = waiting[-1]
        if joint in entered:
            order.append(waiting.pop())
        else:
            entered.add(joint)
            waiting += after[joint][::-1]
    return tuple(order)
