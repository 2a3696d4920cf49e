"""What follows from a topology: which joints share a body, which bodies hang together, the profile of the constraints' equations, tiles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.arrays import (
    BODY_INDEX,
    CONSTRAINT,
    CONSTRAINT_INDEX,
    CONTACT_INDEX,
    COUPLE_INDEX,
    DRIVEN_INDEX,
    FRAME_INDEX,
    FUNCTION_INDEX,
    GUIDE_INDEX,
    HEADER,
    JOINT_INDEX,
    LOAD_INDEX,
    SPRING_INDEX,
    TILE_INDEX,
    Layout,
)
from ..kernels.topology import BEARING, CURRENT, FREE, LINE, PINNED, ROUND, STOP, Topology
from .dissection import elimination_order

LEVERS = (CONSTRAINT.jb, CONSTRAINT.jk, CONSTRAINT.jc)  # of bearing, journal and carrier in a row of constraints
JOURNAL = 1  # the side whose lever counts the other way than that of the two others
TILE = 1024  # elements whose particles stay in the cache between drift and kick


@dataclass(frozen=True)
class Graph:
    """Derived lists, in the one order that every loop sums in. Rows of constraints are those of the joints in the ``order`` of elimination."""

    order: tuple[int, ...]
    rows: tuple[int, ...]
    jointed: tuple[int, ...]
    pinned: tuple[int, ...]
    shared: tuple[bool, ...]
    constrained: tuple[bool, ...]
    couples: tuple[tuple[int, int, int, int, int], ...]
    first: tuple[int, ...]
    start: tuple[int, ...]
    size: int
    close_again: bool
    closing: tuple[bool, ...]
    together: tuple[bool, ...]


@lru_cache(maxsize=64)
def derive(topology: Topology) -> Graph:
    """The graph of a topology. A couple is (row, row before it or the same, body, its side in the first, its side in the second).

    ``rows`` are the numbers of the constraints in their order.
    """
    free = set(topology.free)
    clearances = list(zip(topology.contact_bearing, topology.contact_journal, strict=True))
    ideals = list(zip(topology.joint_bearing, topology.joint_journal, topology.carriers, strict=True))
    uses = Counter(body for pair in [*clearances, *ideals] for body in set(pair) if body in free)
    pinned = tuple(sorted({body for pair in ideals for body in pair if body in free}))
    constrained = tuple(any(body in pinned for body in pair) for pair in clearances)
    armed = set(topology.trig)  # on an arm, friction turns the body against the normal force: it counts as shared too
    shared = tuple(any(uses[body] > 1 or body in armed & free for body in pair) for pair in clearances)
    touched = {body for pair in clearances for body in pair if body in free}
    jointed = tuple(sorted(touched | (set(pinned) if any(constrained) else set())))
    starts = topology.constraint_starts
    order = elimination_order([sorted(set(three) & free) for three in ideals])
    rows = tuple(row for joint in order for row in range(starts[joint], starts[joint + 1]))
    sides = [ideals[joint] for joint in order for _ in range(starts[joint + 1] - starts[joint])]
    couples = _couples(sides, free)
    reach = list(range(len(sides)))
    for row, other, *_ in couples:
        reach[row] = min(reach[row], other)
    start, size = [], 0
    for r, low in enumerate(reach):
        start.append(size - low)
        size += r - low + 1
    again = any(constrained)
    closing = _closing([(starts[joint + 1] - starts[joint], ideals[joint][:2]) for joint in order], free)
    together = _together(topology, constrained)
    return Graph(order, rows, jointed, pinned, shared, constrained, couples, tuple(reach), tuple(start), size, again, closing, together)


def _together(topology: Topology, constrained: tuple[bool, ...]) -> tuple[bool, ...]:
    """Contacts from outside, rounds and corners, that share a free body with another: they may begin in one step and are solved together."""
    kinds = topology.contact_kind or (BEARING,) * len(topology.contact_bearing)
    pairs = list(zip(topology.contact_bearing, topology.contact_journal, strict=True))
    outside = [kind in (ROUND, LINE) and not hangs for kind, hangs in zip(kinds, constrained, strict=True)]
    free = set(topology.free)
    uses = Counter(body for pair, counts in zip(pairs, outside, strict=True) if counts for body in pair if body in free)
    return tuple(counts and any(uses[body] > 1 for body in pair) for pair, counts in zip(pairs, outside, strict=True))


def _closing(order: list[tuple[int, tuple[int, int]]], free: set[int]) -> tuple[bool, ...]:
    """Whether each constraint joins bodies that joints before its own hold together already; bodies whose motion is prescribed are one.

    Joints are given in their order, each with its rows and its two bodies.
    """
    part: dict[int, int] = {}
    found: list[bool] = []
    for count, pair in order:
        first, second = (body if body in free else 0 for body in pair)
        while first in part:
            first = part[first]
        while second in part:
            second = part[second]
        if first != second:
            part[max(first, second)] = min(first, second)
        found += [first == second] * count
    return tuple(found)


def _couples(sides: list[tuple[int, int, int]], free: set[int]) -> tuple[tuple[int, int, int, int, int], ...]:
    """Pairs of constraint rows that share a body, with that body; the pair of sides says where it stands in each."""
    uses: dict[int, list[tuple[int, int]]] = {}
    for row, three in enumerate(sides):
        for side, body in enumerate(three):
            if body in free:
                uses.setdefault(body, []).append((row, side))
    found = [
        (row, other, body, side, other_side) for body, rows in uses.items() for row, side in rows for other, other_side in rows if other <= row
    ]
    return tuple(sorted(found))


def tiles(topology: Topology, layout: Layout) -> list[tuple[int, int, int, int, int, int]]:
    """Ranges of plain particles to drift, elements, and plain particles to kick, so that few lines of the cache are needed at a time."""
    count = len(topology.frame_nodes)
    plain = np.full(topology.particles, -1, dtype=np.intp)
    loose = np.flatnonzero(np.isin(np.arange(topology.particles), topology.bound, invert=True))
    plain[loose] = np.arange(len(loose))
    if not count:
        return [(0, len(loose), 0, 0, 0, len(loose))] if len(loose) else []
    nodes = plain[np.asarray(topology.frame_nodes, dtype=np.intp)]
    drifted = np.maximum.accumulate(nodes.max(axis=1)) + 1
    needed = np.where(nodes >= 0, nodes, len(loose)).min(axis=1)
    waiting = np.minimum.accumulate(needed[::-1])[::-1]
    found, drift, kick = [], 0, 0
    for low in range(0, count, TILE):
        high = min(low + TILE, count)
        last = high == count
        drift_end = len(loose) if last else max(drift, int(drifted[high - 1]))
        kick_end = len(loose) if last else max(kick, int(min(waiting[high], drift_end)))
        found.append((drift, drift_end, low, high, kick, kick_end))
        drift, kick = drift_end, kick_end
    return found


class Lists:
    """The lists of the integer array for one topology: records of rows of S and kinds."""

    def __init__(self, topology: Topology) -> None:
        self.t, self.graph, self.layout = topology, derive(topology), Layout(topology)
        self.body = self.layout.records["particle"]
        self.low, self.count = self.layout.rows, topology.constraint_starts[-1]
        self.y = self.low + self.graph.size + self.count

    def records(self, entity: str, *columns: Iterable[int]) -> NDArray[np.int64]:
        """Rows of an entity with further columns."""
        return np.column_stack([self.layout.records[entity], *(np.asarray(column, dtype=np.int64) for column in columns)])

    def bodies(self, indices: Iterable[int]) -> NDArray[np.intp]:
        """Rows of particles."""
        return self.body[np.asarray(indices, dtype=np.intp)]

    def function(self, indices: Iterable[int]) -> list[int]:
        """Rows of functions, 0 for none."""
        return [0 if k < 0 else self.layout.record("function", k) for k in indices]

    def row(self, k: int, lever: int = 0) -> int:
        """Row of a constraint, or of one of its levers."""
        return self.layout.record("constraint", k) + lever

    def particles(self) -> dict[str, Any]:
        """Particles that are treated one by one, tiles of the others, elements."""
        t, free = self.t, set(self.t.free)
        nodes = np.asarray(t.frame_nodes, dtype=np.intp).reshape(-1, 2)
        units = self.layout.records["unit"] if t.path_unit > 1 else np.zeros(len(nodes), dtype=np.intp)
        chosen = {"bound": [p for p in t.bound if p in free], "trig": t.trig, "jointed": self.graph.jointed, "pinned": self.graph.pinned}
        found: dict[str, Any] = {name: self.bodies(particles)[:, None] for name, particles in chosen.items()}
        found["tile"] = tiles(t, self.layout)
        found["frame"] = self.records("frame", self.bodies(nodes[:, 0]), self.bodies(nodes[:, 1]), t.frame_release, units, t.strains)
        return found

    def contacts(self) -> NDArray[np.int64]:
        """Contacts with what their laws ask for."""
        t = self.t
        ahead = [int(t.friction_laws[kind].set_valued) for kind in t.friction_form]  # type: ignore[attr-defined]
        kinked = [int(getattr(t.friction_laws[kind], "regime", None) is not None) for kind in t.friction_form]
        film = [int(getattr(t.contact_laws[kind], "film", False)) for kind in t.contact_form]
        return self.records(
            "contact", self.bodies(t.contact_bearing), self.bodies(t.contact_journal), self.graph.shared, self.graph.constrained,
            t.contact_form, t.friction_form, ahead, kinked, film, self.graph.together, t.contact_kind or [0] * len(t.contact_bearing),
            *self.paths(t.contact_path, len(t.contact_bearing)), *self.knots(), self.wears(), *self.profiles(),
        )  # fmt: skip

    def knots(self) -> tuple[list[int], list[int]]:
        """First row and number of the pieces of the table of each contact's law, 0 for none."""
        return [self.layout.record("knot", first) if many else 0 for first, many in self.t.knots], [many for _, many in self.t.knots]

    def wears(self) -> list[int]:
        """Row of the wear of each contact, 0 where none is kept."""
        return [self.layout.record("wear", self.t.wears.index(k)) if k in self.t.wears else 0 for k in range(len(self.t.contact_bearing))]

    def profiles(self) -> list[list[int]]:
        """First row and number of the harmonics of each contact's bearing, and of its journal."""
        found: list[list[int]] = [[], [], [], []]
        at = 0
        for counts in self.t.profiles or ((0, 0),) * len(self.t.contact_bearing):
            for side, count in enumerate(counts):
                found[2 * side].append(self.layout.record("harmonic", at) if count else 0)
                found[2 * side + 1].append(count)
                at += count
        return found

    def guides(self) -> list[tuple[int, int, int]]:
        """Blocks in guides with play, with the contacts that are their corners."""
        return [(self.layout.record("guide", k), first, end) for k, (first, end) in enumerate(self.t.guides)]

    def paths(self, paths: tuple[int, ...], count: int) -> tuple[list[int], list[int]]:
        """First row and number of the pieces of the path of each joint or contact, 0 for none."""
        found = self.t.pieces(paths, count)
        return [self.layout.record("piece", first) if many else 0 for first, many in found], [many for _, many in found]

    def constraints(self) -> dict[str, Any]:
        """Ideal joints, their rows, and which rows meet at a body; two revolutes meet in one entry."""
        t, graph, low, row = self.t, self.graph, self.low, self.row
        starts, body, rows = t.constraint_starts, self.body, graph.rows
        counts = np.diff(starts)
        joints = [k for k in graph.order for _ in range(counts[k])]
        pins = [part for k in graph.order for part in ((1, 2) if t.held[k] == (PINNED, FREE) else (0,) * int(counts[k]))]
        carriers = [0 if c == 0 else int(body[c]) for c in t.carriers]
        place = {number: k for k, number in enumerate(rows)}
        return {
            "joint": self.records(
                "joint", self.bodies(t.joint_bearing), self.bodies(t.joint_journal), *(np.array(t.held, dtype=int).reshape(-1, 2).T),
                [row(k) if self.count else 0 for k in starts[:-1]], [self.y + place.get(k, 0) for k in starts[:-1]],
                self.function(t.joint_function or [-1] * len(t.joint_bearing)), counts, *self.paths(t.joint_path, len(t.joint_bearing)), carriers,
            ),
            "constraint": [
                (row(rows[k]), int(body[t.joint_bearing[j]]), int(body[t.joint_journal[j]]), graph.first[k], low + graph.start[k],
                 int(graph.closing[k]), carriers[j])
                for k, j in enumerate(joints)
            ],
            "couple": [
                (row(rows[i]), row(rows[k]), int(body[shared]), row(rows[i], LEVERS[si]), row(rows[k], LEVERS[sk]),
                 int((si == JOURNAL) == (sk == JOURNAL)), low + graph.start[i] + k, int(pins[i] and pins[k]),
                 low + graph.start[min(i + 1, self.count - 1)] + k)
                for i, k, shared, si, sk in graph.couples
                if not (pins[i] and pins[k]) or (pins[i] == 1 and pins[k] == 1)
            ],
        }  # fmt: skip

    def others(self) -> dict[str, Any]:
        """Springs, drivers, loads, bodies and functions."""
        t, layout, body = self.t, self.layout, self.body
        ends = {(int(i), int(j)) for i, j in t.body_nodes if i != j} if t.path_unit == 1 else set()
        present = [(e, nodes) for e, nodes in enumerate(t.frame_nodes) if t.strains[e] == CURRENT and nodes in ends]
        spans = {nodes: layout.record("frame", e) for e, nodes in present}  # whose inverse length is that of a body's chord
        return {
            "spring": self.records("spring", self.bodies(t.spring_first), self.bodies(t.spring_second), t.spring_kind),
            "driven": self.records("driven", self.bodies(t.driven), self.function(t.driven_function)),
            "load": self.records("load", self.bodies(t.load_particle), self.function(t.load_function), t.load_follow or [0] * len(t.load_particle)),
            "body": [(layout.record("body", k), int(body[i]), int(body[j]), spans.get((i, j), 0)) for k, (i, j) in enumerate(t.body_nodes)],
            "function": [(layout.record("function", k), start, *_argument(t, k, body)) for k, start in enumerate(t.function_start)],
        }


SIZES = {
    "tile": TILE_INDEX,
    "frame": FRAME_INDEX,
    "contact": CONTACT_INDEX,
    "guide": GUIDE_INDEX,
    "joint": JOINT_INDEX,
    "constraint": CONSTRAINT_INDEX,
    "couple": COUPLE_INDEX,
    "spring": SPRING_INDEX,
    "driven": DRIVEN_INDEX,
    "load": LOAD_INDEX,
    "body": BODY_INDEX,
    "function": FUNCTION_INDEX,
}


@lru_cache(maxsize=16)
def tables(topology: Topology) -> tuple[NDArray[np.uint32], Layout, int]:
    """The topology as the integer array of the data-driven loop, the layout of S, and the rows of S with that loop's scratch."""
    made, t = Lists(topology), topology
    lists = {**made.particles(), "contact": made.contacts(), "guide": made.guides(), **made.constraints(), **made.others()}
    integers = np.zeros(HEADER.SIZE + sum(int(np.size(values)) for values in lists.values()), dtype=np.uint32)
    at = HEADER.SIZE
    for name, values in lists.items():
        flat = np.asarray(values, dtype=np.int64).reshape(-1)
        integers[getattr(HEADER, name)] = at
        integers[getattr(HEADER, f"{name}_count")] = len(flat) // (SIZES[name].SIZE if name in SIZES else 1)
        integers[at : at + len(flat)] = flat
        at += len(flat)
    inverse, y, gn, gt = (made.low + made.graph.size + k * made.count for k in range(4))
    integers[[HEADER.profile, HEADER.profile_count, HEADER.inverse, HEADER.y, HEADER.gn, HEADER.gt]] = made.low, made.graph.size, inverse, y, gn, gt
    worked = bool(t.load_particle) or any(k >= 0 for k in t.joint_function)
    watched = bool(t.contact_bearing or t.function_start or t.coarse or STOP in t.spring_kind)
    turned = gt + made.count
    flags = {
        "plain": made.layout.plain, "plain_count": t.particles - len(t.bound), "path_unit": t.path_unit, "damped": t.damped, "worked": worked,
        "close_again": made.graph.close_again, "watched": watched, "closing": any(made.graph.closing), "redundant": t.redundant,
        "coarse": t.coarse, "together": any(made.graph.together), "turned": turned, "rows": made.layout.rows,
    }  # fmt: skip
    for name, value in flags.items():
        integers[getattr(HEADER, name)] = value
    return integers, made.layout, turned + 2 * made.graph.size + made.count


def _argument(topology: Topology, k: int, body: NDArray[np.intp]) -> tuple[int, int, int]:
    """What function ``k`` depends on, and the two particles whose angle or speed it is."""
    if not topology.function_argument:
        return 0, 0, 0
    kind, first, second = topology.function_argument[k]
    return kind, int(body[first]), int(body[second])
