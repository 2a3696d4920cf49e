"""The topology as the integer array of the data-driven loop: lists of records, whose fields are rows of S and
kinds.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...kernels.arrays import (
    BODY_INDEX,
    CONSTRAINT,
    CONSTRAINT_INDEX,
    CONTACT,
    CONTACT_INDEX,
    COUPLE_INDEX,
    DRIVEN_INDEX,
    FRAME_INDEX,
    FUNCTION_INDEX,
    GUIDE_INDEX,
    HEADER,
    JOINT_INDEX,
    LOAD_INDEX,
    PLAIN,
    SPRING_INDEX,
    TILE_INDEX,
    Fields,
    Layout,
)
from ...kernels.topology import BEARING, CURRENT, FREE, PINNED, STOP, Topology
from .graph import derive

# Fields of the levers on bearing, journal and carrier, by the side of a couple.
LEVERS = (CONSTRAINT.jb, CONSTRAINT.jk, CONSTRAINT.jc)
# The side whose lever has the opposite sign of the two others.
JOURNAL = 1
# The level of coarse steps in which the turned rows are always used (kernels/closing.py).
COARSEST = 3
PLAIN_RANGES = [TILE_INDEX.drift, TILE_INDEX.drift_end, TILE_INDEX.kick, TILE_INDEX.kick_end]
# Elements of a tile, whose particles stay in the cache between drift and kick.
TILE = 1024


def records(fields: Fields, **columns: Any) -> NDArray[np.int64]:
    """Return records of the integer array, shape (count, fields), from one column for each of their fields.

    Raises ValueError for columns in another order than that of the fields.
    """
    names = list(fields.names)
    if names != list(columns):
        raise ValueError(f"fields {names} are given as {list(columns)}")
    return np.column_stack([np.asarray(column, dtype=np.int64).reshape(-1) for column in columns.values()])


def tiles(topology: Topology) -> list[tuple[int, int, int, int, int, int]]:
    """Return the tiles of a topology: ranges of plain particles to drift, of elements, and of plain particles
    to kick, so that a step needs few lines of the cache at a time.

    A tile drifts particles up to the last that its elements need, and kicks those that no later tile needs.
    """
    count = len(topology.frame_nodes)
    plain = np.full(topology.particles, -1, dtype=np.intp)
    loose = np.flatnonzero(np.isin(np.arange(topology.particles), topology.bound, invert=True))
    plain[loose] = np.arange(len(loose))
    if not count:
        return [(0, len(loose), 0, 0, 0, len(loose))] if len(loose) else []
    nodes = plain[np.asarray(topology.frame_nodes, dtype=np.intp)]
    # Drift must have reached ``drifted`` before an element; kick must not pass ``waiting`` while it, or one
    # after it, is still to come.
    drifted = np.maximum.accumulate(nodes.max(axis=1)) + 1
    needed = np.where(nodes >= 0, nodes, len(loose)).min(axis=1)
    waiting = np.minimum.accumulate(needed[::-1])[::-1]
    result, drift, kick = [], 0, 0
    for low in range(0, count, TILE):
        high = min(low + TILE, count)
        last = high == count
        drift_end = len(loose) if last else max(drift, int(drifted[high - 1]))
        kick_end = len(loose) if last else max(kick, int(min(waiting[high], drift_end)))
        result.append((drift, drift_end, low, high, kick, kick_end))
        drift, kick = drift_end, kick_end
    return result


class Lists:
    """The lists of the integer array for one topology.

    Behind the rows of the layout, from ``low`` on, S has the scratch of the data-driven loop: the matrix
    along its profile, the inverse pivots, right-hand sides from ``y`` on, and the responses gn and gt.
    """

    def __init__(self, topology: Topology) -> None:
        self.t, self.graph, self.layout = topology, derive(topology), Layout(topology)
        self.body = self.layout.records["particle"]
        self.low, self.count = self.layout.rows, topology.constraint_starts[-1]
        self.y = self.low + self.graph.size + self.count

    def bodies(self, indices: Iterable[int]) -> NDArray[np.intp]:
        """Return the rows of particles with these indices."""
        return self.body[np.asarray(indices, dtype=np.intp)]

    def function(self, indices: Iterable[int]) -> list[int]:
        """Return the rows of functions with these indices, 0 for none."""
        return [0 if k < 0 else self.layout.record("function", k) for k in indices]

    def row(self, k: int, lever: int = 0) -> int:
        """Return the row of constraint k, or of one of its levers."""
        return self.layout.record("constraint", k) + lever

    def particles(self) -> dict[str, Any]:
        """Return the lists of bound particles by their uses, the tiles of the plain ones, and the
        elements.
        """
        t, free = self.t, set(self.t.free)
        nodes = np.asarray(t.frame_nodes, dtype=np.intp).reshape(-1, 2)
        units = self.layout.records["unit"] if t.path_unit > 1 else np.zeros(len(nodes), dtype=np.intp)
        chosen = {
            "bound": [p for p in t.bound if p in free],
            "trig": t.trig,
            "jointed": self.graph.jointed,
            "pinned": self.graph.pinned,
        }
        result: dict[str, Any] = {name: self.bodies(particles)[:, None] for name, particles in chosen.items()}
        plain = np.asarray(tiles(t), dtype=np.int64).reshape(-1, TILE_INDEX.SIZE)
        plain[:, PLAIN_RANGES] = self.layout.plain + PLAIN * plain[:, PLAIN_RANGES]
        result["tile"] = plain
        result["frame"] = records(
            FRAME_INDEX, row=self.layout.records["frame"], first=self.bodies(nodes[:, 0]),
            second=self.bodies(nodes[:, 1]), release=t.frame_release, unit=units, strain=t.strains,
        )  # fmt: skip
        return result

    def contacts(self) -> NDArray[np.int64]:
        """Return the records of contacts, with the properties of their laws."""
        t = self.t
        implicit = [int(t.friction_laws[kind].set_valued) for kind in t.friction_form]  # type: ignore[attr-defined]
        kinked = [int(getattr(t.friction_laws[kind], "regime", None) is not None) for kind in t.friction_form]
        film = [int(getattr(t.contact_laws[kind], "film", False)) for kind in t.contact_form]
        piece, pieces = self.ranges("piece", t.pieces(t.contact_path, len(t.contact_bearing)))
        knot, knots = self.ranges("knot", t.knots)
        bearing_first, bearing_count, journal_first, journal_count = self.profiles()
        return records(
            CONTACT_INDEX, row=self.layout.records["contact"], bearing=self.bodies(t.contact_bearing),
            journal=self.bodies(t.contact_journal), shared=self.graph.shared,
            constrained=self.graph.constrained, contact=t.contact_form, friction=t.friction_form,
            implicit_half_step=implicit, kinked=kinked, film=film, simultaneous=self.graph.simultaneous,
            kind=t.contact_kind or [BEARING] * len(t.contact_bearing), piece=piece, pieces=pieces, knot=knot,
            knots=knots, wear=self.wears(), bearing_first=bearing_first, bearing_count=bearing_count,
            journal_first=journal_first, journal_count=journal_count,
        )  # fmt: skip

    def ranges(self, entity: str, pieces: Iterable[tuple[int, int]]) -> tuple[list[int], list[int]]:
        """Return first row and number of the records of an entity, for each pair of first index and number;
        0 for none.
        """
        rows, counts = [], []
        for first, count in pieces:
            rows.append(self.layout.record(entity, first) if count else 0)
            counts.append(count)
        return rows, counts

    def wears(self) -> list[int]:
        """Return the row of the wear of each contact, 0 where none is recorded."""
        return [
            self.layout.record("wear", self.t.wears.index(k)) if k in self.t.wears else 0
            for k in range(len(self.t.contact_bearing))
        ]

    def actuators(self) -> list[int]:
        """Return the row of the actuator of each ideal joint, 0 where none moves it."""
        indices = self.t.joint_actuator or (-1,) * len(self.t.joint_bearing)
        return [self.layout.record("actuator", k) if k >= 0 else 0 for k in indices]

    def profiles(self) -> list[list[int]]:
        """Return first row and number of the harmonics of each contact's bearing, and those of its
        journal.
        """
        result: list[list[int]] = [[], [], [], []]
        at = 0
        for counts in self.t.profiles or ((0, 0),) * len(self.t.contact_bearing):
            for side, count in enumerate(counts):
                result[2 * side].append(self.layout.record("harmonic", at) if count else 0)
                result[2 * side + 1].append(count)
                at += count
        return result

    def guides(self) -> list[tuple[int, int, int]]:
        """Return the records of blocks in guides with clearance: their row, and the rows of the first corner
        and behind the last.
        """
        row = self.layout.record
        corners = [
            (row("contact", first), row("contact", first) + CONTACT.SIZE * (end - first))
            for first, end in self.t.guides
        ]
        return [(row("guide", k), *rows) for k, rows in enumerate(corners)]

    def constraints(self) -> dict[str, Any]:
        """Return the records of ideal joints, of their constraints, and of couples: constraints that share a
        body. Two revolutes that share a body have one couple for their four entries.
        """
        t, graph, row = self.t, self.graph, self.row
        starts, body, rows = t.constraint_starts, self.body, graph.rows
        counts = np.diff(starts)
        joints = [k for k in graph.order for _ in range(counts[k])]
        # The rows of a revolute are marked 1 and 2. Of the four couples of two revolutes, only that of their
        # first rows is kept; it stands for four entries of the matrix (kernels/factors.py, ``fill``).
        pins = [
            part
            for k in graph.order
            for part in ((1, 2) if t.held[k] == (PINNED, FREE) else (0,) * int(counts[k]))
        ]
        carriers = np.array([0 if c == 0 else int(body[c]) for c in t.carriers], dtype=np.int64)
        place = {number: k for k, number in enumerate(rows)}
        places, turns = np.array(t.held, dtype=int).reshape(-1, 2).T
        piece, pieces = self.ranges("piece", t.pieces(t.joint_path, len(t.joint_bearing)))
        bearing, journal = self.bodies(t.joint_bearing), self.bodies(t.joint_journal)
        couples = [
            couple
            for couple in graph.couples
            if not (pins[couple.row] and pins[couple.column]) or pins[couple.row] == pins[couple.column] == 1
        ]
        return {
            "joint": records(
                JOINT_INDEX, row=self.layout.records["joint"], bearing=bearing, journal=journal,
                carrier=carriers, place=places, turn=turns,
                first=[row(k) if self.count else 0 for k in starts[:-1]],
                y=[self.y + place.get(k, 0) for k in starts[:-1]],
                function=self.function(t.joint_function or [-1] * len(t.joint_bearing)), rows=counts,
                piece=piece, pieces=pieces, actuator=self.actuators(),
            ),
            "constraint": records(
                CONSTRAINT_INDEX, row=[row(k) for k in rows], bearing=bearing[joints],
                journal=journal[joints], carrier=carriers[joints], start=graph.first,
                at=[self.low + start for start in graph.start], closing=graph.closing,
            ),
            "couple": records(
                COUPLE_INDEX, first=[row(rows[couple.row]) for couple in couples],
                second=[row(rows[couple.column]) for couple in couples],
                body=[int(body[couple.body]) for couple in couples],
                first_lever=[row(rows[couple.row], LEVERS[couple.side]) for couple in couples],
                second_lever=[row(rows[couple.column], LEVERS[couple.column_side]) for couple in couples],
                same=[(couple.side == JOURNAL) == (couple.column_side == JOURNAL) for couple in couples],
                at=[self.low + graph.start[couple.row] + couple.column for couple in couples],
                pins=[pins[couple.row] and pins[couple.column] for couple in couples],
                lower=[
                    self.low + graph.start[min(couple.row + 1, self.count - 1)] + couple.column
                    for couple in couples
                ],
            ),
        }  # fmt: skip

    def mechanism_records(self) -> dict[str, Any]:
        """Return the records of springs, drivers, loads, bodies and functions."""
        t, layout, body = self.t, self.layout, self.body
        ends = {(int(i), int(j)) for i, j in t.body_nodes if i != j} if t.path_unit == 1 else set()
        present = [
            (e, nodes) for e, nodes in enumerate(t.frame_nodes) if t.strains[e] == CURRENT and nodes in ends
        ]
        # Elements whose stored inverse length is that of a body's chord: a division less in each step.
        spans = {nodes: layout.record("frame", e) for e, nodes in present}
        arguments = [_argument(t, k, body) for k in range(len(t.function_start))]
        return {
            "spring": records(
                SPRING_INDEX, row=layout.records["spring"], first=self.bodies(t.spring_first),
                second=self.bodies(t.spring_second), kind=t.spring_kind,
            ),
            "driven": records(
                DRIVEN_INDEX, row=layout.records["driven"], body=self.bodies(t.driven),
                function=self.function(t.driven_function)
            ),
            "load": records(
                LOAD_INDEX, row=layout.records["load"], body=self.bodies(t.load_particle),
                function=self.function(t.load_function), follow=t.load_follow or [0] * len(t.load_particle),
            ),
            "body": records(
                BODY_INDEX, row=layout.records["body"], first=[int(body[i]) for i, _ in t.body_nodes],
                second=[int(body[j]) for _, j in t.body_nodes],
                frame=[spans.get(nodes, 0) for nodes in t.body_nodes],
            ),
            "function": records(
                FUNCTION_INDEX, row=layout.records["function"], table=t.function_start,
                argument=[argument[0] for argument in arguments],
                first=[argument[1] for argument in arguments], second=[argument[2] for argument in arguments],
            ),
        }  # fmt: skip


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
    """Return the integer array of a topology, the layout of S, and the number of rows of S with the scratch
    of the data-driven loop.
    """
    lists_of, t = Lists(topology), topology
    lists = {
        **lists_of.particles(),
        "contact": lists_of.contacts(),
        "guide": lists_of.guides(),
        **lists_of.constraints(),
        **lists_of.mechanism_records(),
    }
    integers = np.zeros(HEADER.SIZE + sum(int(np.size(values)) for values in lists.values()), dtype=np.uint32)
    at = HEADER.SIZE
    for name, values in lists.items():
        flat = np.asarray(values, dtype=np.int64).reshape(-1)
        integers[getattr(HEADER, name)] = at
        integers[getattr(HEADER, f"{name}_count")] = len(flat) // (SIZES[name].SIZE if name in SIZES else 1)
        integers[at : at + len(flat)] = flat
        at += len(flat)
        integers[getattr(HEADER, f"{name}_end")] = at
    inverse, y, gn, gt = (lists_of.low + lists_of.graph.size + k * lists_of.count for k in range(4))
    integers[[HEADER.profile, HEADER.profile_count, HEADER.inverse, HEADER.y, HEADER.gn, HEADER.gt]] = (
        lists_of.low,
        lists_of.graph.size,
        inverse,
        y,
        gn,
        gt,
    )
    worked = bool(t.load_particle) or (not t.joint_actuator and any(k >= 0 for k in t.joint_function))
    watched = bool(t.contact_bearing or t.function_start or t.coarse or STOP in t.spring_kind)
    turned = gt + lists_of.count
    flags = {
        "plain": lists_of.layout.plain,
        "plain_end": lists_of.layout.plain + PLAIN * (t.particles - len(t.bound)), "path_unit": t.path_unit,
        "damped": t.damped, "worked": worked, "close_again": lists_of.graph.close_again, "watched": watched,
        "closing": any(lists_of.graph.closing), "redundant": t.redundant, "coarse": t.coarse > 0,
        "simultaneous": any(lists_of.graph.simultaneous), "turned": turned, "rows": lists_of.layout.rows,
        # Coarse steps correct the reactions more often; the coarsest use Newton's method in every step
        # instead.
        "corrections": 1 + t.coarse if t.coarse < COARSEST else 1, "velocity_corrections": 1 + 2 * t.coarse,
        "newton": t.coarse >= COARSEST,
    }  # fmt: skip
    for name, value in flags.items():
        integers[getattr(HEADER, name)] = value
    return integers, lists_of.layout, turned + 2 * lists_of.graph.size + lists_of.count


def _argument(topology: Topology, k: int, body: NDArray[np.intp]) -> tuple[int, int, int]:
    """Return the kind of argument of function ``k``, and the two particles whose angle or speed it is."""
    if not topology.function_argument:
        return 0, 0, 0
    kind, first, second = topology.function_argument[k]
    return kind, int(body[first]), int(body[second])
