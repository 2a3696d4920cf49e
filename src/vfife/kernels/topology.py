"""The topology of a mechanism: the integers that describe which entities are connected, and their kinds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

# What an ideal joint holds: a place (its rows: 0, 2, 1, 1, 1, 1) and the turn of one body with the other (0,
# 1, 1); then kinds of contacts, springs and arguments of functions. A revolute pins a place, a slider lets it
# go along a line and keeps the turn, a gear couples turns alone, a massless link keeps two pins apart.
UNPLACED, PINNED, ACROSS_LINE, ALONG_LINE, ON_PATH, SPACED = range(6)
FREE, LOCKED, GEARED = range(3)
PLACE_ROWS, TURN_ROWS = (0, 2, 1, 1, 1, 1), (0, 1, 1)
AIMED = (ALONG_LINE, SPACED)  # places whose row keeps a length that is data
BEARING, ROUND, LINE, SLOT = range(4)
LINEAR, TORSIONAL, STOP, BUSHING = range(4)
TIME, TURNED, SPEED, TRAVEL, SLIDING = range(5)
# Length to which the stiffness of an element refers: the present one (the paper's), or that without forces.
CURRENT, REFERENCE = range(2)


@dataclass(frozen=True)
class Topology:
    """Integers that describe the connections of a mechanism. Models with equal topology share one generated
    step.

    Particle 0 is the ground; it carries the gears that no other body carries. Each tuple has one entry per
    entity. ``contact_path`` and ``joint_path`` are indices of paths, -1 for none; ``path_pieces`` is the
    number of pieces of each path; ``contact_knots`` that of the table of each contact law, 0 by default.
    ``guides`` are the first contact and the one after the last of each block in a guide with clearance, whose
    corners are contacts of their own. ``wears`` are the contacts whose wear is recorded, ``profiles`` the
    numbers of harmonics of the worn profiles of bearing and journal in each contact, none by default.
    ``joint_actuator`` are the indices of the actuators whose motion the ideal joints prescribe, -1 for none.
    Files of versions without actuators have none; there the work of these drivers is among that of the loads.
    """

    particles: int
    free: tuple[int, ...] = ()
    trig: tuple[int, ...] = ()
    frame_nodes: tuple[tuple[int, int], ...] = ()
    frame_release: tuple[int, ...] = ()
    frame_strain: tuple[int, ...] = ()
    contact_bearing: tuple[int, ...] = ()
    contact_journal: tuple[int, ...] = ()
    contact_kind: tuple[int, ...] = ()
    contact_path: tuple[int, ...] = ()
    guides: tuple[tuple[int, int], ...] = ()
    wears: tuple[int, ...] = ()
    profiles: tuple[tuple[int, int], ...] = ()
    contact_form: tuple[int, ...] = ()
    friction_form: tuple[int, ...] = ()
    joint_bearing: tuple[int, ...] = ()
    joint_journal: tuple[int, ...] = ()
    joint_place: tuple[int, ...] = ()
    joint_turn: tuple[int, ...] = ()
    joint_path: tuple[int, ...] = ()
    joint_function: tuple[int, ...] = ()
    joint_carrier: tuple[int, ...] = ()
    joint_actuator: tuple[int, ...] = ()
    spring_first: tuple[int, ...] = ()
    spring_second: tuple[int, ...] = ()
    spring_kind: tuple[int, ...] = ()
    driven: tuple[int, ...] = ()
    driven_function: tuple[int, ...] = ()
    load_particle: tuple[int, ...] = ()
    load_function: tuple[int, ...] = ()
    load_follow: tuple[bool, ...] = ()
    path_pieces: tuple[int, ...] = ()
    contact_knots: tuple[int, ...] = ()
    body_nodes: tuple[tuple[int, int], ...] = ()
    function_start: tuple[int, ...] = ()
    function_argument: tuple[tuple[int, int, int], ...] = ()
    path_unit: int = 1
    damped: bool = False
    weightless: bool = False
    redundant: bool = False
    coarse: int = 0
    contact_laws: tuple[type, ...] = ()
    friction_laws: tuple[type, ...] = ()

    @property
    def held(self) -> tuple[tuple[int, int], ...]:
        """Place and turn that each ideal joint holds; those of revolutes by default."""
        count = len(self.joint_bearing)
        return tuple(
            zip(self.joint_place or (PINNED,) * count, self.joint_turn or (FREE,) * count, strict=True)
        )

    @property
    def strains(self) -> tuple[int, ...]:
        """Length to which the stiffness of each element refers; the present one by default."""
        return self.frame_strain or (CURRENT,) * len(self.frame_nodes)

    @property
    def carriers(self) -> tuple[int, ...]:
        """Particle from which each ideal joint measures its turn; the ground by default."""
        return self.joint_carrier or (0,) * len(self.joint_bearing)

    @property
    def constraint_starts(self) -> tuple[int, ...]:
        """First constraint row of each ideal joint, and the number of rows."""
        starts = [0]
        for place, turn in self.held:
            starts.append(starts[-1] + PLACE_ROWS[place] + TURN_ROWS[turn])
        return tuple(starts)

    def pieces(self, paths: tuple[int, ...], count: int) -> list[tuple[int, int]]:
        """Return first piece and number of pieces of the path of each of ``count`` joints or contacts; (0, 0)
        for those without a path.
        """
        return [
            (sum(self.path_pieces[:path]), self.path_pieces[path]) if path >= 0 else (0, 0)
            for path in paths or (-1,) * count
        ]

    @property
    def knots(self) -> list[tuple[int, int]]:
        """First piece and number of pieces of the table of each contact's law; none for laws without one."""
        counts = self.contact_knots or (0,) * len(self.contact_bearing)
        return [(sum(counts[:k]), count) for k, count in enumerate(counts)]

    def corrected(self, coarse: int) -> Topology:
        """Return the topology with ``coarse`` additional corrections of ideal joints; equal topologies are
        one object.
        """
        return self if coarse == self.coarse else _corrected(self, coarse)

    @cached_property
    def bound(self) -> tuple[int, ...]:
        """Particles that joints, springs, loads, drivers or functions touch, or that turn an arm, and the
        ground.
        """
        touched = {
            0,
            *self.trig,
            *self.contact_bearing,
            *self.contact_journal,
            *self.joint_bearing,
            *self.joint_journal,
            *self.joint_carrier,
            *self.driven,
        }
        touched |= {*self.spring_first, *self.spring_second, *self.load_particle}
        touched |= {body for _, first, second in self.function_argument for body in (first, second)}
        free = set(self.free)
        return tuple(sorted(touched | {p for p in range(self.particles) if p not in free}))

    def counts(self) -> dict[str, int]:
        """Count the records of each entity."""
        return {
            "particle": self.particles,
            "frame": len(self.frame_nodes),
            "unit": len(self.frame_nodes) if self.path_unit > 1 else 0,
            "contact": len(self.contact_bearing),
            "guide": len(self.guides),
            "joint": len(self.joint_bearing),
            "constraint": self.constraint_starts[-1],
            "spring": len(self.spring_first),
            "driven": len(self.driven),
            "actuator": sum(k >= 0 for k in self.joint_actuator),
            "load": len(self.load_particle),
            "body": len(self.body_nodes),
            "function": len(self.function_start),
            "piece": sum(self.path_pieces),
            "knot": sum(self.contact_knots),
            "wear": len(self.wears),
            "harmonic": sum(map(sum, self.profiles)),
            "system": 1,
        }


@lru_cache(maxsize=64)
def _corrected(topology: Topology, coarse: int) -> Topology:
    return replace(topology, coarse=coarse)
