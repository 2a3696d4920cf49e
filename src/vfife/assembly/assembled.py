"""What assemble hands on: arrays for the kernels, which row belongs to which named thing, and bounds that
sound numbers keep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compiler.runtime.runner import Watched
from ..kernels.arrays import KNOT, Layout
from ..kernels.topology import Topology
from ..model.geometry.path import Path
from ..model.mechanism import Mechanism

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BodyMap:
    """Where a body is found: its particles (indices), elements (indices), its entry among ``body_*`` blocks
    and, if driven, ``driven_*``.

    ``reference`` is the point of the body's frame (m) at which its one particle sits if it is rigid: the
    centre of mass, or the pivot if it is driven. ``nodes`` are the particles that carry its pins. ``mass``
    (kg), ``inertia`` about the centre of mass (kg m^2) and ``center`` (m) are those of the whole body as it
    is calculated.
    """

    name: str
    model: str
    particles: tuple[int, ...]
    elements: tuple[int, ...] = ()
    row: int = 0
    driven: int | None = None
    reference: tuple[float, float] = (0.0, 0.0)
    mass: float = 0.0
    inertia: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)
    pins: dict[str, tuple[float, float]] = field(default_factory=dict)
    nodes: dict[str, int] = field(default_factory=dict)


CONTINUED = "the run that it continues"  # decides the step of a run that goes on from a former one


@dataclass(frozen=True)
class StepChoice:
    """The step (s), what allowed it, and how long a run with it is.

    ``tried``: larger steps (s) that were given up, with the share by which their companions lay apart, or
    None where first contacts were too deep or energy was not accounted for. ``requested_outputs``: outputs in
    a turn that were asked for together with a step; None for the usual number.
    """

    step: float
    stable: float
    culprit: str
    automatic: bool
    limits: tuple[tuple[str, float], ...]
    turn: float | None
    outputs_every: int
    outputs: int
    tried: tuple[tuple[float, float | None], ...] = ()
    requested_outputs: int | None = None

    @property
    def steps(self) -> int:
        """Steps after the first."""
        return self.outputs_every * self.outputs


@dataclass(frozen=True, repr=False)
class Assembly:
    """Model and state of one mechanism.

    ``state`` is S at the start, shape (rows,); ``tables`` the functions of time. ``contacts``, ``ideals``,
    ``springs`` and ``pivots`` are names in the order of the rows of ``contact_*``, ``joint_*``, ``spring_*``
    and ``driven_*``. A pivot is the ideal joint to the ground of a driven body; gears and drivers without a
    pivot are among the ideals; a block in a guide has four contacts, ``joint.1`` to ``joint.4``, and
    ``contact_joints`` names the joint of each contact. ``shared`` are the reactions that redundant joints
    leave open, ``<joint>.force``, ``<joint>.moment`` and ``<driven body>.torque``: the result has those of
    least norm. ``companion_states``, shape (rows, companions), are the starts of the companions of a run that
    goes on from a former one; None for companions that start as the run does. ``missing_joints`` are cautions
    about joints that the model seems to lack, ``notes`` all others.
    """

    mechanism: Mechanism
    topology: Topology
    layout: Layout
    state: NDArray[np.float64]
    tables: NDArray[np.float64]
    bodies: dict[str, BodyMap]
    contacts: tuple[str, ...]
    ideals: tuple[str, ...]
    pivots: tuple[str, ...]
    choice: StepChoice
    springs: tuple[str, ...] = ()
    contact_joints: tuple[str, ...] = ()
    mobility: Any = None
    notes: tuple[str, ...] = ()
    shared: tuple[str, ...] = ()
    companion_states: NDArray[np.float64] | None = None
    missing_joints: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"<Assembly of {self.mechanism.name!r}: {len(self.state)} numbers, {self.choice.steps:,} steps>"
        )

    @cached_property
    def contact_paths(self) -> tuple[Path | None, ...]:
        """The path of the slot of each contact; None for a contact that is in none."""
        return tuple(
            touching.path
            for name in dict.fromkeys(self.contact_joints)
            for touching in self.mechanism.contacts[name].touchings(0.0)
        )

    def contact_slots(self, index: int) -> tuple[float, ...]:
        """Parameters of the law of a contact, as its ``force`` takes them."""
        law = self.mechanism.contacts[self.contact_joints[index]].contact
        return slots_of(self.layout, self.state, self.topology, index, len(law.slots))


def slots_of(
    layout: Layout, state: NDArray[np.float64], topology: Topology, index: int, count: int
) -> tuple[Any, ...]:
    """So many parameters of the law of a contact, from its record; after them the pieces of one that is a
    table.
    """
    row, (first, pieces) = layout.row("contact_slots", index), topology.knots[index]
    ranges = [(row, count), *((layout.record("knot", first + k), KNOT.SIZE) for k in range(pieces))]
    return tuple(value for start, size in ranges for value in state[start : start + size].tolist())


LIMITED = ("contact_penetration", "contact_penetration_max", "reference_length")
STRETCH = 5.0  # of an element's first length, or its inverse


def limited_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Rows of S with numbers that have bounds: penetrations, the largest since the last output, and lengths
    of elements.
    """
    return np.concatenate([assembly.layout[name] for name in LIMITED]).astype(np.uint32)


def bounds(assembly: Assembly) -> tuple[Array, Array]:
    """Return the lowest and highest values that :func:`limited_rows` have in a stable run, two arrays
    (rows,).

    A penetration beyond the bearing's radius and an element beyond a fifth or five times its length are marks
    of an unstable step, which can stay finite for long; a journal may be back in its bearing when somebody
    looks.
    """
    reach = np.array(
        [assembly.mechanism.contacts[name].reach for name in assembly.contact_joints], dtype=float
    )
    length = assembly.state[assembly.layout["reference_length"]]
    return np.concatenate([np.full(2 * len(reach), -np.inf), length / STRETCH]), np.concatenate(
        [reach, reach, length * STRETCH]
    )


def watched(assemblies: Sequence[Assembly], lanes: NDArray[np.bool_]) -> Watched:
    """Return the rows and limits whose violation stops a lane; ``lanes`` (lanes,) is True for those
    monitored.
    """
    low, high = zip(*(bounds(assembly) for assembly in assemblies), strict=True)
    return Watched(limited_rows(assemblies[0]), np.stack(low, axis=1), np.stack(high, axis=1), lanes)


class Bounds:
    """Finds what lies beyond all bounds among recorded numbers, those of the rows ``row_numbers``;
    ``columns`` are those that have bounds, if known.
    """

    def __init__(
        self, assembly: Assembly, recorded: NDArray[np.uint32], columns: NDArray[np.intp] | None = None
    ) -> None:
        if columns is None:
            order = np.argsort(recorded, kind="stable")
            columns = order[np.searchsorted(recorded, limited_rows(assembly), sorter=order)]
        self.columns = columns
        self.low, self.high = bounds(assembly)

    def unsound(self, rows: Array) -> NDArray[np.bool_]:
        """Which numbers, shape (outputs, rows)."""
        bad: NDArray[np.bool_] = ~np.isfinite(rows)
        limited = rows[:, self.columns]
        with np.errstate(invalid="ignore"):
            bad[:, self.columns] |= (limited < self.low) | (limited > self.high)
        return bad
