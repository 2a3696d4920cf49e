"""Which entity is joined to which: the integers of a mechanism, and the kinds that they name."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

# Kinds of ideal joints (rows 2, 2, 1, 3, 1, 1, 1), of contacts, springs and arguments of functions.
REVOLUTE, SLIDER, SLOT, WELD, GEAR, ANGLE, TRAVEL = range(7)
IDEAL_ROWS = (2, 2, 1, 3, 1, 1, 1)
BEARING, ROUND, LINE = range(3)
LINEAR, TORSIONAL, STOP, BUSHING = range(4)
TIME, TURNED, SPEED = range(3)


@dataclass(frozen=True)
class Topology:
    """Integers that say what is joined to what. Two models with equal topology share one generated step.

    Particle 0 is the ground. Each tuple has one entry per entity.
    """

    particles: int
    free: tuple[int, ...] = ()
    trig: tuple[int, ...] = ()
    frame_nodes: tuple[tuple[int, int], ...] = ()
    frame_release: tuple[int, ...] = ()
    contact_bearing: tuple[int, ...] = ()
    contact_journal: tuple[int, ...] = ()
    contact_kind: tuple[int, ...] = ()
    contact_form: tuple[int, ...] = ()
    friction_form: tuple[int, ...] = ()
    joint_bearing: tuple[int, ...] = ()
    joint_journal: tuple[int, ...] = ()
    joint_kind: tuple[int, ...] = ()
    joint_function: tuple[int, ...] = ()
    spring_first: tuple[int, ...] = ()
    spring_second: tuple[int, ...] = ()
    spring_kind: tuple[int, ...] = ()
    driven: tuple[int, ...] = ()
    driven_function: tuple[int, ...] = ()
    load_particle: tuple[int, ...] = ()
    load_function: tuple[int, ...] = ()
    load_follow: tuple[bool, ...] = ()
    body_nodes: tuple[tuple[int, int], ...] = ()
    function_start: tuple[int, ...] = ()
    function_argument: tuple[tuple[int, int, int], ...] = ()
    path_unit: int = 1
    damped: bool = False
    weightless: bool = False
    contact_laws: tuple[type, ...] = ()
    friction_laws: tuple[type, ...] = ()

    @property
    def kinds(self) -> tuple[int, ...]:
        """Kinds of the ideal joints, revolutes unless said."""
        return self.joint_kind or (REVOLUTE,) * len(self.joint_bearing)

    @property
    def constraint_starts(self) -> tuple[int, ...]:
        """First constraint row of each ideal joint, and the number of rows."""
        starts = [0]
        for kind in self.kinds:
            starts.append(starts[-1] + IDEAL_ROWS[kind])
        return tuple(starts)

    @cached_property
    def bound(self) -> tuple[int, ...]:
        """Particles that a joint, spring, load, driver or function touches, or that turn an arm; the ground."""
        touched = {0, *self.trig, *self.contact_bearing, *self.contact_journal, *self.joint_bearing, *self.joint_journal, *self.driven}
        touched |= {*self.spring_first, *self.spring_second, *self.load_particle}
        touched |= {body for _, first, second in self.function_argument for body in (first, second)}
        free = set(self.free)
        return tuple(sorted(touched | {p for p in range(self.particles) if p not in free}))

    def counts(self) -> dict[str, int]:
        """Number of records per entity."""
        return {
            "particle": self.particles,
            "frame": len(self.frame_nodes),
            "unit": len(self.frame_nodes) if self.path_unit > 1 else 0,
            "contact": len(self.contact_bearing),
            "joint": len(self.joint_bearing),
            "constraint": self.constraint_starts[-1],
            "spring": len(self.spring_first),
            "driven": len(self.driven),
            "load": len(self.load_particle),
            "body": len(self.body_nodes),
            "function": len(self.function_start),
            "system": 1,
        }
