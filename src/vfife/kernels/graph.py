"""What follows from a topology: which joints share a body, which bodies hang together, the profile of the constraints' equations, tiles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import IDEAL_ROWS, JB, JC, JD, JE, JF, JG, JK, JL, JQ, JR, JT, REVOLUTE, H, Layout, Q, Topology

TILE = 1024  # elements whose particles stay in the cache between drift and kick


@dataclass(frozen=True)
class Graph:
    """Derived lists, in the one order that every loop sums in."""

    jointed: tuple[int, ...]
    pinned: tuple[int, ...]
    shared: tuple[bool, ...]
    constrained: tuple[bool, ...]
    couples: tuple[tuple[int, int, int, bool, bool], ...]
    first: tuple[int, ...]
    start: tuple[int, ...]
    size: int
    close_again: bool


@lru_cache(maxsize=64)
def derive(topology: Topology) -> Graph:
    """The graph of a topology. A couple is (row, row before it or the same, body, journal side of the first, journal side of the second)."""
    free = set(topology.free)
    clearances = list(zip(topology.clearance_bearing, topology.clearance_journal, strict=True))
    ideals = list(zip(topology.ideal_bearing, topology.ideal_journal, strict=True))
    uses = Counter(body for pair in [*clearances, *ideals] for body in set(pair) if body in free)
    pinned = tuple(sorted({body for pair in ideals for body in pair if body in free}))
    constrained = tuple(any(body in pinned for body in pair) for pair in clearances)
    armed = set(topology.trig)  # on an arm, friction turns the body against the normal force: it counts as shared too
    shared = tuple(any(uses[body] > 1 or body in armed & free for body in pair) for pair in clearances)
    touched = {body for pair in clearances for body in pair if body in free}
    jointed = tuple(sorted(touched | (set(pinned) if any(constrained) else set())))
    starts = topology.row_starts
    sides = [pair for joint, pair in enumerate(ideals) for _ in range(starts[joint + 1] - starts[joint])]
    couples = _couples(sides, free)
    reach = list(range(len(sides)))
    for row, other, *_ in couples:
        reach[row] = min(reach[row], other)
    start, size = [], 0
    for r, low in enumerate(reach):
        start.append(size - low)
        size += r - low + 1
    again = any(constrained)
    return Graph(jointed, pinned, shared, constrained, couples, tuple(reach), tuple(start), size, again)


def _couples(sides: list[tuple[int, int]], free: set[int]) -> tuple[tuple[int, int, int, bool, bool], ...]:
    """Pairs of constraint rows that share a body, with that body; the pair of sides says where it stands in each."""
    uses: dict[int, list[tuple[int, bool]]] = {}
    for row, pair in enumerate(sides):
        for journal, body in zip((False, True), pair, strict=True):
            if body in free:
                uses.setdefault(body, []).append((row, journal))
    found = [
        (row, other, body, side, other_side) for body, rows in uses.items() for row, side in rows for other, other_side in rows if other <= row
    ]
    return tuple(sorted(found))


def tiles(topology: Topology, layout: Layout) -> list[tuple[int, int, int, int, int, int]]:
    """Ranges of plain particles to drift, elements, and plain particles to kick, so that few lines of the cache are needed at a time."""
    count = len(topology.element_nodes)
    plain = np.full(topology.particles, -1, dtype=np.intp)
    loose = np.flatnonzero(np.isin(np.arange(topology.particles), topology.bound, invert=True))
    plain[loose] = np.arange(len(loose))
    if not count:
        return [(0, len(loose), 0, 0, 0, len(loose))] if len(loose) else []
    nodes = plain[np.asarray(topology.element_nodes, dtype=np.intp)]
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


def tables(topology: Topology) -> tuple[NDArray[np.uint32], Layout, int]:
    """The topology as the integer array of the data-driven loop, the layout of S, and the rows of S with that loop's scratch."""
    graph, t, layout = derive(topology), topology, Layout(topology)
    body = layout.records["particle"]
    low, free = layout.rows, set(t.free)
    rows = t.row_starts[-1]
    inverse, y, gn, gt = (low + graph.size + k * rows for k in range(4))

    def records(entity: str, *columns: Iterable[int]) -> NDArray[np.int64]:
        return np.column_stack([layout.records[entity], *(np.asarray(column, dtype=np.int64) for column in columns)])

    def bodies(indices: Iterable[int]) -> NDArray[np.intp]:
        return body[np.asarray(indices, dtype=np.intp)]

    def function(indices: Iterable[int]) -> list[int]:
        return [0 if k < 0 else layout.record("function", k) for k in indices]

    def row(k: int, lever: int = 0) -> int:
        return layout.record("row", k) + lever

    nodes = np.asarray(t.element_nodes, dtype=np.intp).reshape(-1, 2)
    spans = {(int(i), int(j)): layout.record("element", e) for e, (i, j) in enumerate(t.element_nodes)} if t.path_unit == 1 else {}
    units = layout.records["unit"] if t.path_unit > 1 else np.zeros(len(nodes), dtype=np.intp)
    ends = [pair for k, pair in enumerate(zip(t.ideal_bearing, t.ideal_journal, strict=True)) for _ in range(t.row_starts[k + 1] - t.row_starts[k])]
    pins = [part for kind in t.kinds for part in ((1, 2) if kind == REVOLUTE else (0,) * IDEAL_ROWS[kind])]
    lever = {False: Q.jb, True: Q.jk}
    lists: dict[str, Any] = {
        "bound": [(int(body[p]),) for p in t.bound if p in free],
        "trig": [(int(body[p]),) for p in t.trig],
        "jointed": [(int(body[p]),) for p in graph.jointed],
        "pinned": [(int(body[p]),) for p in graph.pinned],
        "tile": tiles(t, layout),
        "element": records("element", bodies(nodes[:, 0]), bodies(nodes[:, 1]), t.element_release, units),
        "clearance": records(
            "clearance", bodies(t.clearance_bearing), bodies(t.clearance_journal), graph.shared, graph.constrained,
            t.clearance_contact, t.clearance_friction, [int(t.friction_laws[kind].set_valued) for kind in t.clearance_friction],  # type: ignore[attr-defined]
            [int(getattr(t.contact_laws[kind], "film", False)) for kind in t.clearance_contact],
            t.clearance_kind or [0] * len(t.clearance_bearing),
        ),
        "ideal": records(
            "ideal", bodies(t.ideal_bearing), bodies(t.ideal_journal), t.kinds, [row(k) if rows else 0 for k in t.row_starts[:-1]],
            [y + k for k in t.row_starts[:-1]], function(t.ideal_function or [-1] * len(t.ideal_bearing)), np.diff(t.row_starts),
        ),
        "row": [(row(k), *(int(body[p]) for p in ends[k]), graph.first[k], low + graph.start[k]) for k in range(rows)],
        "couple": [
            (row(i), row(k), int(body[shared]), row(i, lever[si]), row(k, lever[sk]), int(si == sk), low + graph.start[i] + k,
             int(pins[i] and pins[k]), low + graph.start[min(i + 1, rows - 1)] + k)
            for i, k, shared, si, sk in graph.couples
            if not (pins[i] and pins[k]) or (pins[i] == 1 and pins[k] == 1)
        ],
        "spring": records("spring", bodies(t.spring_first), bodies(t.spring_second), t.spring_kind),
        "driven": records("driven", bodies(t.driven), function(t.driven_function)),
        "load": records("load", bodies(t.load_particle), function(t.load_function), t.load_follow or [0] * len(t.load_particle)),
        "body": [
            (layout.record("body", k), int(body[i]), int(body[j]), spans.get((i, j), 0)) for k, (i, j) in enumerate(t.body_nodes)
        ],
        "function": [
            (layout.record("function", k), start, *_argument(t, k, body)) for k, start in enumerate(t.function_start)
        ],
    }  # fmt: skip
    sizes = {"tile": JT, "element": JE, "clearance": JC, "ideal": JR, "row": JQ, "couple": JK, "spring": JG, "driven": JD, "load": JL, "body": JB}
    sizes["function"] = JF
    integers = np.zeros(H.SIZE + sum(int(np.size(values)) for values in lists.values()), dtype=np.uint32)
    at = H.SIZE
    for name, values in lists.items():
        flat = np.asarray(values, dtype=np.int64).reshape(-1)
        integers[getattr(H, name)] = at
        integers[getattr(H, f"{name}_count")] = len(flat) // (sizes[name].SIZE if name in sizes else 1)
        integers[at : at + len(flat)] = flat
        at += len(flat)
    integers[[H.profile, H.profile_count, H.inverse, H.y, H.gn, H.gt]] = low, graph.size, inverse, y, gn, gt
    worked = bool(t.load_particle) or any(k >= 0 for k in t.ideal_function)
    integers[[H.plain, H.path_unit, H.damped, H.worked, H.close_again]] = layout.plain, t.path_unit, t.damped, worked, graph.close_again
    return integers, layout, gt + rows


def _argument(topology: Topology, k: int, body: NDArray[np.intp]) -> tuple[int, int, int]:
    """What function ``k`` depends on, and the two particles whose angle or speed it is."""
    if not topology.function_argument:
        return 0, 0, 0
    kind, first, second = topology.function_argument[k]
    return kind, int(body[first]), int(body[second])
