"""Where every number of a step lies, and the records that its loops walk through;
:mod:`~vfife.kernels.blocks` describes the numbers.

All numbers lie in one array ``S`` of shape ``(rows, lanes)``, entity by entity. In one array the compiler
sees that two rows never overlap, so that several simulations share a vector register. A record keeps the
numbers of an entity in one cache line. A particle that no joint, load or driver touches is *plain* and has a
shorter record. A checkpoint consists of this array and the step number, a run's record of its state and
extremes at each output step.

The topology reaches the data-driven loop as one array ``I`` of unsigned integers: a header, then lists of
records.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .blocks import BLOCKS, BY_NAME, Role
from .topology import Topology

# Arrays that kernels are called with: rows of a state, records and rows, numbers of steps.
Numbers = NDArray[np.float64]
Integers = NDArray[np.uint32]
Counts = NDArray[np.int64]


class Fields:
    """Row of each field within a record; a field of several rows is named by its first."""

    def __init__(self, widths: Iterable[tuple[str, int]]) -> None:
        self.SIZE = 0
        self.names: list[str] = []
        for name, width in widths:
            setattr(self, name, self.SIZE)
            self.names.append(name)
            self.SIZE += width

    def __getattr__(self, name: str) -> int:
        raise AttributeError(name)


ENTITIES = (
    *("system", "particle", "frame", "unit", "contact", "guide", "joint", "constraint"),
    *("spring", "driven", "load", "body", "function", "piece", "knot", "wear", "harmonic"),
    "actuator",
)


def _fields(*entities: str) -> Fields:
    return Fields(
        (block.field, block.width) for entity in entities for block in BLOCKS if block.entity == entity
    )


# Rows of each entity's record; PARTICLE is that of a bound particle, whose first PLAIN rows are those of a
# plain one.
RECORDS = {
    entity: _fields("particle", "bound") if entity == "particle" else _fields(entity) for entity in ENTITIES
}
SYSTEM, PARTICLE, FRAME, UNIT, CONTACT, GUIDE, JOINT, CONSTRAINT = list(RECORDS.values())[:8]
SPRING, DRIVEN, LOAD, BODY, FUNCTION, PIECE, KNOT, WEAR, HARMONIC, ACTUATOR = list(RECORDS.values())[8:]
PLAIN = _fields("particle").SIZE


def fields(*names: str) -> Fields:
    """Return fields of one row each."""
    return Fields((name, 1) for name in names)


# Records of the integer array: rows of S and kinds.
FRAME_INDEX = fields("row", "first", "second", "release", "unit", "strain")
CONTACT_INDEX = fields(
    *("row", "bearing", "journal", "shared", "constrained", "contact", "friction", "implicit_half_step"),
    *("kinked", "film", "simultaneous", "kind", "piece", "pieces", "knot", "knots", "wear"),
    *("bearing_first", "bearing_count", "journal_first", "journal_count"),
)
GUIDE_INDEX = fields("row", "corners", "corners_end")
JOINT_INDEX = fields(
    *("row", "bearing", "journal", "carrier", "place", "turn", "first", "y", "function", "rows"),
    *("piece", "pieces", "actuator"),
)
CONSTRAINT_INDEX = fields("row", "bearing", "journal", "carrier", "start", "at", "closing")
SPRING_INDEX = fields("row", "first", "second", "kind")
DRIVEN_INDEX = fields("row", "body", "function")
LOAD_INDEX = fields("row", "body", "function", "follow")
BODY_INDEX = fields("row", "first", "second", "frame")
FUNCTION_INDEX = fields("row", "table", "argument", "first", "second")
COUPLE_INDEX = fields("first", "second", "body", "first_lever", "second_lever", "same", "at", "pins", "lower")
TILE_INDEX = fields("drift", "drift_end", "frame", "frame_end", "kick", "kick_end")

LISTS = (
    *("bound", "trig", "jointed", "pinned", "tile", "frame", "contact", "guide", "joint", "constraint"),
    *("couple", "spring", "driven", "load", "body", "function"),
)
HEADER = fields(
    *LISTS,
    *(f"{name}_end" for name in LISTS),
    *(f"{name}_count" for name in LISTS),
    *("plain", "plain_end", "profile", "profile_count", "inverse", "y", "gn", "gt", "path_unit", "damped"),
    *("worked", "close_again", "watched", "closing", "redundant", "coarse", "turned", "simultaneous", "rows"),
    *("corrections", "velocity_corrections", "newton"),
)


NO_ROWS = np.zeros(0, dtype=np.intp)


class Layout:
    """The rows of each block: all of ``layout["particle_x"]``, in order, or one of them,
    ``layout.row("particle_x", 3)``.
    """

    def __init__(self, topology: Topology) -> None:
        counts = topology.counts()
        self.records: dict[str, NDArray[np.intp]] = {}
        self.rows = 0
        for entity in ENTITIES:
            count, size = counts[entity], RECORDS[entity].SIZE
            if entity == "particle":
                sizes = np.full(count, PLAIN, dtype=np.intp)
                sizes[list(topology.bound)] = PARTICLE.SIZE
                order = np.argsort(
                    sizes == PLAIN, kind="stable"
                )  # bound ones first, so that plain ones follow each other
                starts = np.empty_like(sizes)
                starts[order] = self.rows + np.cumsum(sizes[order]) - sizes[order]
                self.plain = self.rows + len(topology.bound) * PARTICLE.SIZE
                self.records["bound"] = starts[list(topology.bound)]
                self.rows += int(sizes.sum())
            else:
                starts = (
                    np.arange(self.rows, self.rows + count * size, size, dtype=np.intp) if count else NO_ROWS
                )
                self.rows += count * size
            self.records[entity] = starts
        self.known: dict[str, NDArray[np.intp]] = {}
        self.whole: dict[str, NDArray[np.intp]] = {}
        self.roles: dict[tuple[Role, ...], tuple[int, ...]] = {}

    def __getitem__(self, name: str) -> NDArray[np.intp]:
        if name not in self.known:
            block = BY_NAME[name]
            fields: Any = PARTICLE if block.entity == "bound" else RECORDS[block.entity]
            self.known[name] = self.records[block.entity] + getattr(fields, block.field)
        return self.known[name]

    def rows_of(self, name: str) -> NDArray[np.intp]:
        """Return all rows of a block, entity by entity, also where it is wider than one row."""
        width = BY_NAME[name].width
        if width == 1:
            return self[name]
        if name not in self.whole:
            self.whole[name] = np.asarray((self[name][:, None] + np.arange(width)).reshape(-1), dtype=np.intp)
        return self.whole[name]

    def row(self, name: str, index: int = 0) -> int:
        """Return the row of entity ``index`` in block ``name``; the first one if the block is wider.

        For bound blocks the index is the particle's.
        """
        block = BY_NAME[name]
        if block.entity == "bound":
            return int(self.records["particle"][index]) + int(getattr(PARTICLE, block.field))
        return int(self[name][index])

    def record(self, entity: str, index: int) -> int:
        """Return the first row of the record of an entity."""
        return int(self.records[entity][index])

    def of(self, *roles: Role) -> list[int]:
        """Return all rows of the given roles, block by block."""
        if roles not in self.roles:
            chosen = [block for block in BLOCKS if block.role in roles and len(self.records[block.entity])]
            self.roles[roles] = tuple(row for block in chosen for row in self.rows_of(block.name).tolist())
        return list(self.roles[roles])


@lru_cache(maxsize=64)
def layout_of(topology: Topology) -> Layout:
    """Return the layout of a topology, one object for all mechanisms of this topology."""
    return Layout(topology)
