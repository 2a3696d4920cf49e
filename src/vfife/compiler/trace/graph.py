"""The graph of a mechanism's joints: which joints share a body, the order of their elimination, and the
profile of the constraint equations.

**Order of elimination.** Eliminating a chain from one end to the other, each pivot waits for the one before
it, and so does each row of both substitutions. From both ends to the middle (Babuška 1972), only half as many
wait for each other, with the same number of operations; in a tree all leaves begin at once. The rule that
gives this order is that of minimum degree (Tinney and Walker 1967): eliminate the joint with the fewest
neighbours, and among equals the one that waits least. It also keeps fill-in small.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from ...kernels.topology import BEARING, LINE, ROUND, Topology
from .schedule import depth_first


class Couple(NamedTuple):
    """Two constraint rows (``column`` before ``row``, or the same) that share a free ``body``, and the side
    of the body in each: 0 bearing, 1 journal, 2 carrier.
    """

    row: int
    column: int
    body: int
    side: int
    column_side: int


@dataclass(frozen=True)
class Graph:
    """Lists derived from a topology, in the one order in which every loop sums.

    ``order``: joints in the order of elimination; ``rows``: their constraints in that order; ``closing``:
    whether each constraint closes a loop; ``couples``: pairs of constraint rows that share a body. The lower
    half of the matrix is stored row by row from the first entry that can differ from zero: row r has the
    columns ``first[r]`` to r, and its column c is entry ``start[r]`` + c of ``size`` entries.

    ``jointed``: bodies in contacts, or in ideal joints if a contact's body is. ``pinned``: bodies in ideal
    joints. For each contact, ``shared``: another joint acts on its bodies, too; ``constrained``: one of its
    bodies is in an ideal joint; ``simultaneous``: its force is solved together with others. ``close_again``:
    contacts change the reactions of ideal joints, which are therefore closed a second time in a step.
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


class Sides(NamedTuple):
    """Bodies of a contact or an ideal joint; the carrier of its gears, or the ground."""

    bearing: int
    journal: int
    carrier: int = 0


@lru_cache(maxsize=64)
def derive(topology: Topology) -> Graph:
    """Return the graph of a topology."""
    free = set(topology.free)
    contacts = list(map(Sides, topology.contact_bearing, topology.contact_journal))
    joints = list(map(Sides, topology.joint_bearing, topology.joint_journal, topology.carriers))
    uses = Counter(body for sides in [*contacts, *joints] for body in set(sides) if body in free)
    pinned = {body for sides in joints for body in sides if body in free}
    constrained = tuple(any(body in pinned for body in sides[:2]) for sides in contacts)
    # On an arm, friction turns the body against the normal force: a contact with an arm counts as shared,
    # too.
    arms = set(topology.trig) & free
    shared = tuple(any(uses[body] > 1 or body in arms for body in sides[:2]) for sides in contacts)
    touched = {body for sides in contacts for body in sides if body in free}
    starts = topology.constraint_starts
    order = elimination_order([sorted(set(sides) & free) for sides in joints])
    rows = tuple(row for joint in order for row in range(starts[joint], starts[joint + 1]))
    counts = [starts[joint + 1] - starts[joint] for joint in order]
    couples = _couples(
        [joints[joint] for joint, count in zip(order, counts, strict=True) for _ in range(count)], free
    )
    # Elimination fills in only between the first entry of a row and its diagonal, so the profile of the
    # matrix is that of its factors.
    first = list(range(len(rows)))
    for couple in couples:
        first[couple.row] = min(first[couple.row], couple.column)
    start, size = [], 0
    for row, column in enumerate(first):
        start.append(size - column)
        size += row - column + 1
    return Graph(
        order=order,
        rows=rows,
        jointed=tuple(sorted(touched | (pinned if any(constrained) else set()))),
        pinned=tuple(sorted(pinned)),
        shared=shared,
        constrained=constrained,
        couples=couples,
        first=tuple(first),
        start=tuple(start),
        size=size,
        close_again=any(constrained),
        closing=_closing([joints[joint] for joint in order], counts, free),
        simultaneous=_simultaneous(topology, contacts, constrained),
    )


def _simultaneous(
    topology: Topology, contacts: list[Sides], constrained: tuple[bool, ...]
) -> tuple[bool, ...]:
    """Return for each contact whether it is solved simultaneously with others: rounds and corners that share
    a free body, which may begin in one step. Contacts of bodies in ideal joints are solved in turn.
    """
    kinds = topology.contact_kind or (BEARING,) * len(contacts)
    outside = [kind in (ROUND, LINE) and not hangs for kind, hangs in zip(kinds, constrained, strict=True)]
    free = set(topology.free)
    uses = Counter(
        body for sides, counts in zip(contacts, outside, strict=True) if counts for body in {*sides} & free
    )
    return tuple(
        counts and any(uses[body] > 1 for body in sides)
        for sides, counts in zip(contacts, outside, strict=True)
    )


def _closing(order: list[Sides], counts: list[int], free: set[int]) -> tuple[bool, ...]:
    """Return for each constraint whether it closes a loop: joints before its own connect its two bodies
    already. Bodies with a prescribed motion count as one body.

    Joints are in the ``order`` of elimination, each with its number of rows, ``counts``. ``parent`` leads
    from a body to a representative of all bodies connected with it (union-find, Galler and Fischer 1964); a
    joint whose bodies have the same representative closes a loop. Only the pivots of such rows can vanish;
    those of a tree are at least an inverse mass (:mod:`vfife.kernels.factors`).
    """
    parent: dict[int, int] = {}
    closing: list[bool] = []
    for sides, count in zip(order, counts, strict=True):
        first, second = (body if body in free else 0 for body in sides[:2])
        while first in parent:
            first = parent[first]
        while second in parent:
            second = parent[second]
        if first != second:
            parent[max(first, second)] = min(first, second)
        closing += [first == second] * count
    return tuple(closing)


def _couples(sides: list[Sides], free: set[int]) -> tuple[Couple, ...]:
    """Return the pairs of constraint rows that share a free body, sorted; ``sides`` are the bodies of each
    row.
    """
    uses: dict[int, list[tuple[int, int]]] = {}
    for row, bodies in enumerate(sides):
        for side, body in enumerate(bodies):
            if body in free:
                uses.setdefault(body, []).append((row, side))
    return tuple(
        sorted(
            Couple(row, column, body, side, column_side)
            for body, rows in uses.items()
            for row, side in rows
            for column, column_side in rows
            if column <= row
        )
    )


def elimination_order(joints: Sequence[Sequence[int]]) -> tuple[int, ...]:
    """Return the numbers of joints in the order of their elimination; each joint is given by its free bodies.

    A first pass eliminates joints by minimum degree and builds the elimination tree: which joint waits for
    which. A second pass lists the tree chain by chain in postorder, each joint after all that it waits for.
    The entries of a row begin at the first joint of its subtree, so postorder gives the narrowest profile for
    this tree. For a chain, the halves from both ends come one after the other, and the joint where they meet
    comes last. The end with which the list begins follows from ties of the first pass and differs between
    even and odd numbers of joints. Either end is as good, but another order gives other bits
    (``make golden``).
    """
    joints_of: dict[int, set[int]] = {}
    for joint, bodies in enumerate(joints):
        for body in bodies:
            joints_of.setdefault(body, set()).add(joint)
    neighbours = [
        set().union(*(joints_of[body] for body in bodies)) - {joint} for joint, bodies in enumerate(joints)
    ]
    waits = [0] * len(joints)  # length of the longest chain of joints that must be eliminated before each
    children: list[list[int]] = [[] for _ in joints]  # in the elimination tree
    roots: list[int] = []
    place: dict[int, int] = {}
    ready = [(len(adjacent), 0, joint) for joint, adjacent in enumerate(neighbours)]
    heapq.heapify(ready)
    eliminated: list[int] = []
    # The heap is ordered by degree, then by wait, then by number, so that the order is the same on every
    # machine. Its entries are never removed: one whose degree or wait is no longer the joint's own is stale,
    # and a newer one is behind it.
    while ready:
        degree, waited, joint = heapq.heappop(ready)
        if joint in place or (degree, waited) != (len(neighbours[joint]), waits[joint]):
            continue
        place[joint] = len(eliminated)
        eliminated.append(joint)
        # Eliminating a joint couples all its neighbours with one another (fill-in), and each of them waits
        # for it.
        for neighbour in neighbours[joint]:
            neighbours[neighbour] |= neighbours[joint]
            neighbours[neighbour] -= {joint, neighbour}
            waits[neighbour] = max(waits[neighbour], waits[joint] + 1)
            heapq.heappush(ready, (len(neighbours[neighbour]), waits[neighbour], neighbour))
    # The neighbours left in a joint's set are those eliminated after it. The first of them is its parent in
    # the elimination tree (Liu 1990); only a parent has to come after its children.
    for joint in eliminated:
        later = min(neighbours[joint], key=place.__getitem__, default=None)
        (roots if later is None else children[later]).append(joint)
    return tuple(depth_first(roots, children.__getitem__))
