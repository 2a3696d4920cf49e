"""What follows from a topology: which joints share a body, which bodies hang together, the profile of the ideal joints' equations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .arrays import JB, JC, JD, JE, JF, JK, JL, JR, B, C, D, E, F, Fields, H, L, Layout, R, Topology

SIDES = (-1, 1)  # bearing, journal


@dataclass(frozen=True)
class Graph:
    """Derived lists, in the one order that every loop sums in."""

    jointed: tuple[int, ...]
    pinned: tuple[int, ...]
    shared: tuple[bool, ...]
    constrained: tuple[bool, ...]
    couples: tuple[tuple[int, int, int, int, int], ...]
    first: tuple[int, ...]
    start: tuple[int, ...]
    size: int
    close_again: bool


@lru_cache(maxsize=64)
def derive(topology: Topology) -> Graph:
    """The graph of a topology."""
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
    couples = []
    for i, row in enumerate(ideals):
        for k in range(i + 1):
            for side_i, body in zip(SIDES, row, strict=True):
                for side_k, other in zip(SIDES, ideals[k], strict=True):
                    if body == other and body in free:
                        couples.append((i, k, body, side_i, side_k))
    reach = [min([k for i, k, *_ in couples if i == joint], default=joint) for joint in range(len(ideals))]
    first = tuple(2 * reach[r // 2] for r in range(2 * len(ideals)))
    start, size = [], 0
    for r, low in enumerate(first):
        start.append(size - low)
        size += r - low + 1
    again = any(constrained) or any(body in armed for pair in ideals for body in pair)
    return Graph(jointed, pinned, shared, constrained, tuple(couples), first, tuple(start), size, again)


def tables(topology: Topology) -> tuple[np.ndarray, Layout, int]:
    """The topology as the integer array of the data-driven loop, the layout of S, and the rows of S with that loop's scratch."""
    graph, t, layout = derive(topology), topology, Layout(topology)
    body = [layout.row("particle_x", k) for k in range(t.particles)]
    low = layout.rows
    inverse, y, gn, gt = (low + graph.size + k * 2 * len(t.ideal_bearing) for k in range(4))

    def rows(entity: str, fields: Fields, *columns: Iterable[int]) -> list[int]:
        base = range(layout.base[entity], layout.rows + 1, fields.SIZE)
        return [value for record in zip(base, *columns, strict=False) for value in record]

    def bodies(indices: Iterable[int]) -> list[int]:
        return [body[k] for k in indices]

    def function(indices: Iterable[int]) -> list[int]:
        return [0 if k < 0 else layout.row("function_value", k) for k in indices]

    def couple(i: int, k: int, shared: int, side_i: int, side_k: int) -> tuple[int, ...]:
        arms = [layout.row("bx" if side < 0 else "kx", joint) for joint, side in ((i, side_i), (k, side_k))]
        upper, lower = (low + graph.start[2 * i + r] + 2 * k for r in (0, 1))
        return i, k, body[shared], *arms, int(side_i == side_k), upper, lower

    spans = {nodes: layout.row("element_axial_force", e) - E.axial_force for e, nodes in enumerate(t.element_nodes)}
    chords = [spans.get(nodes, 0) if t.path_unit == 1 else 0 for nodes in t.body_nodes]
    lists: dict[str, list[int]] = {
        "free": bodies(t.free),
        "trig": bodies(t.trig),
        "jointed": bodies(graph.jointed),
        "pinned": bodies(graph.pinned),
        "particle": body,
        "element": rows("element", E, bodies(i for i, _ in t.element_nodes), bodies(j for _, j in t.element_nodes), t.element_release),
        "clearance": rows(
            "clearance", C, bodies(t.clearance_bearing), bodies(t.clearance_journal), graph.shared, graph.constrained,
            t.clearance_contact, t.clearance_friction, (int(getattr(t.contact_laws[k], "film", False)) for k in t.clearance_contact),
        ),
        "ideal": rows("ideal", R, bodies(t.ideal_bearing), bodies(t.ideal_journal)),
        "couple": [value for entry in graph.couples for value in couple(*entry)],
        "row": [value for r, first in enumerate(graph.first) for value in (first, low + graph.start[r])],
        "driven": rows("driven", D, bodies(t.driven), function(t.driven_function)),
        "load": rows("load", L, bodies(t.load_particle), function(t.load_function)),
        "body": rows("body", B, bodies(i for i, _ in t.body_nodes), bodies(j for _, j in t.body_nodes), chords),
        "function": rows("function", F, t.function_start),
    }  # fmt: skip
    sizes = {"element": JE, "clearance": JC, "ideal": JR, "couple": JK, "driven": JD, "load": JL, "body": JB, "function": JF}
    integers = np.zeros(H.SIZE + sum(map(len, lists.values())), dtype=np.uint32)
    at = H.SIZE
    for name, values in lists.items():
        width = 2 if name == "row" else sizes[name].SIZE if name in sizes else 1
        integers[getattr(H, name)] = at
        integers[getattr(H, f"{name}_count")] = len(values) // width
        integers[at : at + len(values)] = values
        at += len(values)
    integers[[H.profile, H.profile_count, H.inverse, H.y, H.gn, H.gt]] = low, graph.size, inverse, y, gn, gt
    integers[[H.path_unit, H.damped, H.close_again]] = t.path_unit, t.damped, graph.close_again
    return integers, layout, gt + 2 * len(t.ideal_bearing)
