"""The largest stable step: 2/w of the central difference, with an upper bound w of the highest frequency,
piece by piece.

The mass of a particle is divided among the pieces that hold it (elements, springs, contacts). Each piece with
its share of mass has a frequency, and the highest of these is an upper bound for the whole (Irons and
Treharne 1971). The alternative, the largest eigenvalue of the assembled stiffness, would need a global
matrix, and would not name the piece that sets the step.

Pieces of one sort divide the mass in the ratio of their stiffness: w^2 of a piece is then the sum, over its
motions, of D/m, where D is the stiffness of all pieces of the sort on that motion. Sorts (elements along,
elements across, springs and contacts) divide it as the square roots of their D, so that a soft sort on a
stiff one costs little. Directions change in a run, so a spring or contact counts in any direction, and its
arm as if it were perpendicular.

States are (..., rows), of one mechanism or of a batch with one topology; results have the same leading axes.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..compiler.trace.tables import tables
from ..kernels import frame
from ..kernels.arrays import CONSTRAINT, Layout
from ..kernels.topology import ON_PATH, PINNED, Topology
from ..kinematics.rows import KERNEL
from ..laws.elasticity import elastic_energy, tangents
from ..numerics import dense
from ..numerics.dense import product
from ..numerics.elementwise import hypot, sincos
from .assembled import slots_of

if TYPE_CHECKING:
    from ..laws import ContactLaw
    from .entities import Touch

Array = NDArray[np.float64]
Limits = list[tuple[str, Any]]  # name and step (s) of each piece, NaN in cases without such a limit

# Square root of the growth of a joint's error in a step, up to which Newton's method closes joints; chains of
# one to three bodies hold at 0.9.
CLOSED = 0.8
DEPTHS = tuple(
    accumulate(range(218), lambda depth, _: depth * 1.1, initial=1e-9)
)  # (m), to a metre: in one of them an impact ends
INERTIAS = ("mass", "inertia")
STRAIGHT = 1e-3  # sine of the angle between two elements up to which they count as in line


@dataclass(frozen=True)
class AttachedStiffness:
    """Stiffness of springs and contacts on each particle, shape (..., particles): ``straight`` in any
    direction (N/m), against turning by their arms, and by bushings and torsional springs (N m/rad).
    """

    straight: Array
    levers: Array
    torsional: Array

    @property
    def turning(self) -> Array:
        """Stiffness against turning (N m/rad)."""
        return self.levers + self.torsional


@dataclass(frozen=True)
class ElementStiffness:
    """Stiffness of each element: ``axial`` and ``transverse`` (N/m), the ``moment`` at each node for its own
    turn, and the ``coupling`` for that of the other node (N m/rad).
    """

    nodes: NDArray[np.intp]
    axial: Array
    transverse: Array
    moment: Array
    coupling: Array


def element_stiffness(layout: Layout, state: Array, topology: Topology) -> ElementStiffness:
    """Return the stiffness of all elements, from the step's own element, with its releases; ``moment``
    has the shape (..., elements, 2).
    """
    nodes, release = (
        np.array(topology.frame_nodes, dtype=np.intp).reshape(-1, 2),
        np.array(topology.frame_release, dtype=int),
    )
    counted, present = (
        state[..., layout["reference_inverse_length"]],
        1.0 / state[..., layout["reference_length"]],
    )
    bending = state[..., layout["frame_bending_stiffness"]]
    axial, transverse, moment, coupling = frame.stiffness(
        counted, present, state[..., layout["frame_axial_stiffness"]], bending
    )
    transverse_released, moment_released = frame.stiffness_released(counted, present, bending)
    zero = np.zeros_like(transverse)
    transverse = np.select([release == 0, release == 3], [transverse, zero], transverse_released)
    ends = [np.select([release == 0, release == 3 - end], [moment, moment_released], zero) for end in (1, 2)]
    coupling = np.where(release == 0, coupling, zero)
    return ElementStiffness(nodes, axial, transverse, np.stack(ends, axis=-1), coupling)


def attached_stiffness(
    layout: Layout, state: Array, topology: Topology, contacts: Array | None = None
) -> AttachedStiffness:
    """Return the stiffness of all springs, and of ``contacts`` with these (N/m), (..., contacts)."""
    result = np.zeros((3, topology.particles, *state.shape[:-1]))
    sorts = []
    if topology.spring_first:
        sorts.append(("spring", *spring_stiffness(layout, state)))
    if contacts is not None and topology.contact_bearing:
        sorts.append(("contact", contacts, np.zeros_like(contacts)))
    for kind, straight, torsional in sorts:
        bodies, squares = arms(layout, state, topology, kind)
        shares = straight[..., None], straight[..., None] * squares, torsional[..., None]
        for total, share in zip(result, shares, strict=True):
            columns = np.broadcast_to(share, squares.shape).reshape(*state.shape[:-1], -1)
            np.add.at(total, bodies.ravel(), np.moveaxis(columns, -1, 0))
    return AttachedStiffness(*np.moveaxis(result, 1, -1))


def spring_stiffness(layout: Layout, state: Array) -> tuple[Array, Array]:
    """Return the stiffness of springs along their stiffer axes (N/m) and about the axis of the plane
    (N m/rad), shape (..., springs) each.
    """
    rows = layout.rows_of("spring_stiffness")
    values = state[..., rows].reshape(*state.shape[:-1], -1, 3)
    return values[..., :2].max(axis=-1), values[..., 2]


def arms(layout: Layout, state: Array, topology: Topology, kind: str) -> tuple[NDArray[np.intp], Array]:
    """Return the two bodies of each spring or contact (``kind``) [entities, 2], and the squares of its arms
    on them (m²) (..., entities, 2).
    """
    sides = ("first", "second") if kind == "spring" else ("bearing", "journal")
    bodies = np.array([getattr(topology, f"{kind}_{side}") for side in sides], dtype=np.intp).T
    x, y = (state[..., np.array([layout[f"{kind}_{side}_{axis}"] for side in sides]).T] for axis in "xy")
    return bodies, x * x + y * y


@dataclass(frozen=True)
class Demands:
    """Stiffness of each sort of pieces over its share of mass, on each particle: w^2 times mass (N/m) or
    inertia (N m/rad), shape (..., particles).

    ``axial``, ``transverse`` and ``turns`` belong to elements, ``straight`` and ``turning`` to springs and
    contacts.
    """

    axial: Array
    transverse: Array
    turns: Array
    straight: Array
    turning: Array


def demands(layout: Layout, state: Array, topology: Topology, load: AttachedStiffness) -> Demands:
    """Return the stiffness over the shares of mass.

    Where elements meet at an angle, the motion along one is across the other, so that both sorts share; where
    they meet in line they do not affect each other.
    """
    axial = transverse = moment = np.zeros_like(load.straight)
    bent = np.zeros(load.straight.shape, dtype=bool)
    if topology.frame_nodes:
        k = element_stiffness(layout, state, topology)
        axial, transverse, moment = (
            _at_nodes(k.nodes, values, topology.particles)
            for values in (k.axial[..., None], k.transverse[..., None], k.moment)
        )
        bent = _bent(layout, state, k.nodes, topology.particles)
    a, b, c, d, e = (np.sqrt(values) for values in (axial, transverse, load.straight, moment, load.turning))
    elements = np.where(bent, a + b, np.maximum(a, b))
    alone = np.where(elements > 0.0, 1.0 + c / np.where(elements > 0.0, elements, 1.0), 1.0)
    return Demands(
        np.where(bent, a * (elements + c), axial * alone),
        np.where(bent, b * (elements + c), transverse * alone),
        d * (d + e), c * (c + elements), e * (e + d),
    )  # fmt: skip


def _square(layout: Layout, state: Array, topology: Topology, load: Demands, kind: str) -> Array:
    """Return w^2 (1/s^2) of each spring or contact (``kind``) along a line (..., entities)."""
    bodies, squares = arms(layout, state, topology, kind)
    im, ii = (state[..., layout[f"particle_inverse_{quantity}"]][..., bodies] for quantity in INERTIAS)
    turning = np.where(squares > 0.0, load.turning[..., bodies] * ii, 0.0)
    parts = load.straight[..., bodies] * im + turning
    return np.asarray(parts[..., 0] + parts[..., 1])


def element_limits(layout: Layout, state: Array, topology: Topology, load: Demands) -> tuple[Array, Array]:
    """Return the stable steps (s) of each element, axial and in bending, shape (..., elements) each.

    Axial: w^2 is the sum over both nodes of D/m. Bending has two modes: both ends turn in the same sense,
    with 3 EI/l on the turns and 12 EI/l^3 across, or in opposite senses, with EI/l. The larger root of both
    coupled modes counts; the inertia of each node is shared by 4 EI/l.
    """
    k = element_stiffness(layout, state, topology)
    im, ii = (state[..., layout[f"particle_inverse_{kind}"]] for kind in ("mass", "inertia"))
    stretch = (load.axial * im)[..., k.nodes].sum(axis=-1)
    sway = np.where(k.transverse > 0.0, (load.transverse * im)[..., k.nodes].sum(axis=-1), 0.0)
    turns = np.where(k.moment > 0.0, (load.turns * ii)[..., k.nodes], 0.0)
    first, second = np.moveaxis(turns / np.where(k.moment > 0.0, k.moment, 1.0), -1, 0)
    alike, against = 0.5 * (k.moment[..., 0] + k.coupling), 0.5 * (k.moment[..., 0] - k.coupling)
    a, b, c = (
        alike * (first + second) + sway,
        against * (first + second),
        np.sqrt(np.maximum(alike * against, 0.0)) * (first - second),
    )
    both_modes = 0.5 * (a + b) + np.sqrt(0.25 * ((a - b) * (a - b)) + c * c)
    with np.errstate(divide="ignore"):
        return 2.0 / np.sqrt(stretch), 2.0 / np.sqrt(
            np.where(k.coupling > 0.0, both_modes, turns.sum(axis=-1) + sway)
        )


def _at_nodes(nodes: NDArray[np.intp], values: Array, count: int) -> Array:
    """Return sums over the elements at each particle, of ``values`` (..., elements, 1) for each element or
    (..., elements, 2) for each of its ends.
    """
    total = np.zeros((count, *values.shape[:-2]))
    for column in (0, 1):
        np.add.at(total, nodes[:, column], np.moveaxis(values[..., min(column, values.shape[-1] - 1)], -1, 0))
    return np.moveaxis(total, 0, -1)


def _bent(layout: Layout, state: Array, nodes: NDArray[np.intp], count: int) -> NDArray[np.bool_]:
    """Return whether elements meet at an angle at each particle (..., particles)."""
    x, y = (np.moveaxis(state[..., layout[f"reference_{kind}"]], -1, 0) for kind in ("cosine", "sine"))
    first_x, first_y = np.zeros((2, count, *x.shape[1:]))
    for column in (0, 1):
        first_x[nodes[:, column]], first_y[nodes[:, column]] = x, y
    bent = np.zeros(first_x.shape, dtype=bool)
    for column in (0, 1):
        particles = nodes[:, column]
        across = np.abs(first_x[particles] * y - first_y[particles] * x)
        np.logical_or.at(bent, particles, across > STRAIGHT)
    return np.moveaxis(bent, 0, -1)


def joint_mobility(layout: Layout, state: Array, topology: Topology) -> Array:
    """Return the largest inverse mass (1/kg) of each contact in any direction (..., contacts)."""
    bodies, squares = arms(layout, state, topology, "contact")
    im, ii = (state[..., layout[f"particle_inverse_{quantity}"]][..., bodies] for quantity in INERTIAS)
    parts = im + squares * ii
    return np.asarray(parts[..., 0] + parts[..., 1])


def contact_stiffness(
    touches: Sequence[Sequence[Touch]],
    layout: Layout,
    states: Array,
    topology: Topology,
    expected: Sequence[Mapping[str, float]],
) -> tuple[Array, Array]:
    """Return, for each contact of each case [cases, contacts], the tangent stiffness (N/m) of its law under
    twice its expected force, or the force of an impact, and its inverse mass (1/kg).
    """
    stiffness = np.empty((len(states), len(touches[0])))
    if not touches[0]:
        return stiffness, stiffness
    mobility = joint_mobility(layout, states, topology)
    speeds = hypot(states[:, layout["particle_u"]], states[:, layout["particle_v"]]).max(axis=-1).tolist()
    for index in range(len(touches[0])):
        laws = [contacts[index].joint.contact for contacts in touches]
        name = touches[0][index].joint.name
        slots = [
            slots_of(layout, state, topology, index, len(law.slots))
            for law, state in zip(laws, states, strict=True)
        ]
        masses = mobility[:, index].tolist()
        forces = [
            2.0 * expected[case].get(name, 0.0) or _impact_force(law, slots[case], speeds[case], masses[case])
            for case, law in enumerate(laws)
        ]
        stiffness[:, index] = [value for _, value in tangents(laws, slots, forces)]
    return stiffness, mobility


def at_once(touches: Sequence[Touch]) -> list[int]:
    """Return the number of contacts among which each contact's load is shared: contacts of a joint with the
    same wall, like two corners of a block.
    """
    walls = [(touch.joint.name, touch.touching.normal) for touch in touches]
    sharing = Counter(walls)
    return [sharing[wall] for wall in walls]


def contact_periods(touches: Sequence[Touch], stiffness: Array, mobility: Array) -> Limits:
    """Return half a period (s) of each contact by itself, with its name."""
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.where(mobility > 0.0, 2.0 / np.sqrt(stiffness * mobility), np.inf)
    return [(touch.name, 0.5 * math.pi * root) for touch, root in zip(touches, roots.T, strict=True)]


def contact_limits(
    touches: Sequence[Touch], layout: Layout, state: Array, topology: Topology, load: Demands
) -> Limits:
    """Return the stable step (s) of each contact, with its name."""
    if not touches:
        return []
    square = _square(layout, state, topology, load, "contact")
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = np.where(square > 0.0, 2.0 / np.sqrt(square), np.inf)
    return [(f"contact of joint {touch.name}", steps[..., k]) for k, touch in enumerate(touches)]


def spring_limits(
    layout: Layout, state: Array, topology: Topology, names: Sequence[str], load: Demands
) -> Limits:
    """Return the stable step (s) of each spring, along its axes and about the axis of the plane, with its
    name.
    """
    if not topology.spring_first:
        return []
    straight, torsional = spring_stiffness(layout, state)
    translation = np.where(straight > 0.0, _square(layout, state, topology, load, "spring"), 0.0)
    bodies = np.array([topology.spring_first, topology.spring_second], dtype=np.intp)
    parts = (load.turning * state[..., layout["particle_inverse_inertia"]])[..., bodies]
    rotation = np.where(torsional > 0.0, parts[..., 0, :] + parts[..., 1, :], 0.0)
    square = np.where(rotation > translation, rotation, translation)
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = np.where(square > 0.0, 2.0 / np.sqrt(square), np.nan)
    return [
        (f"spring {names[k] if names else k + 1}", steps[..., k]) for k in range(len(topology.spring_first))
    ]


def arm_limits(
    layout: Layout, states: Array, topology: Topology, names: Sequence[str], turning: Array | None = None
) -> Limits:
    """Return the steps (s) [cases] beyond which ideal joints far outside a light body's radius of gyration k
    may no longer close.

    A correction uses the directions of the present angle, while in a step the body turns by w dt. An error
    across the arm r then leaves one along it, (r/k)^2 w dt times as large, which is across the arm one step
    later, w dt times as large: in total (w dt r/k)^2. In a chain, the error of one joint is passed to the
    next; ``turning`` [cases], the result of :func:`turning_errors` at the start, takes the place of (r/k)^2.
    Both hold for the fastest turning of the start; that of a run is not known here.
    """
    spin = np.abs(states[:, layout["particle_w"]]).max(axis=-1, initial=0.0)
    bodies = np.array([topology.joint_bearing, topology.joint_journal], dtype=np.intp)
    mass, inertia = (
        np.moveaxis(states[:, layout[f"particle_inverse_{kind}"][bodies]], 0, -1)
        for kind in ("mass", "inertia")
    )
    x, y = (
        np.array([states[:, layout[f"joint_{side}_{axis}"]].T for side in ("bearing", "journal")])
        for axis in "xy"
    )
    reach = hypot(x, y) * spin
    counts = (mass > 0.0) & (inertia > 0.0) & (reach > 0.0)
    with np.errstate(all="ignore"):
        steps = np.where(counts, CLOSED * np.sqrt(mass / inertia) / reach, np.nan)
    turning_cases = counts.any(axis=(0, 1))
    result: Limits = [
        (f"small inertia on an arm at joint {name}", steps[side, k])
        for k, name in enumerate(names)
        for side in (0, 1)
        if counts[side, k].any()
    ]
    if turning_cases.any():
        errors = turning_errors(layout, states, topology) if turning is None else turning
        growth = np.where(turning_cases, spin * np.sqrt(errors), 0.0)
        with np.errstate(all="ignore"):
            step = np.where(growth > 0.0, CLOSED / growth, np.nan)
        result.append(("small inertia on arms of several joints", step))
    return result


SMALL_TURN = 1e-6  # rad, between rows whose difference is their change with the angle


def turning_errors(layout: Layout, states: Array, topology: Topology) -> Array:
    """Return, for each of the states [cases, rows], the growth of an error of the reactions in two steps over
    the square of the angle (rad) by which all bodies turn in one step: (r/k)^2 for a single arm.

    It is the spectral radius of (G M^-1 G^T)^-1 dG M^-1 G^T Q, with the constraints G, their change dG with
    the angle, and the quarter turn Q of the forces of joints, which keep their directions in space while the
    bodies turn.
    """
    joined = joined_particles(topology)
    inverse = inverse_masses(layout, states, joined)[:, None]
    present, turned_back, turned_on = np.moveaxis(
        constraint_rows(layout, states, topology, joined, (0.0, -SMALL_TURN, SMALL_TURN)), 1, 0
    )
    transposed = np.swapaxes(present, -1, -2)
    left = product(
        dense.pinv(product(present * inverse, transposed), 1e-10),
        product((turned_on - turned_back) / (2.0 * SMALL_TURN) * inverse, transposed),
    )
    quarter = np.zeros(left.shape[-2:])
    for (place, _), first in zip(topology.held, topology.constraint_starts, strict=False):
        if place == PINNED:
            quarter[first, first + 1], quarter[first + 1, first] = -1.0, 1.0
    return np.asarray(dense.eigenvalue_sizes(product(left, quarter)).max(axis=-1, initial=0.0))


def joined_particles(topology: Topology) -> list[int]:
    """Return the particles that constraints join, in ascending order."""
    return sorted({*topology.joint_bearing, *topology.joint_journal, *topology.carriers})


def inverse_masses(layout: Layout, states: Array, particles: Sequence[int]) -> Array:
    """Return 1/m, 1/m and 1/I of the particles, one after the other [cases, 3 particles]."""
    parts = [
        states[:, layout[f"particle_inverse_{kind}"]][:, particles] for kind in ("mass", "mass", "inertia")
    ]
    return np.stack(parts, axis=-1).reshape(len(states), -1)


class StateRows(dict[int, Any]):
    """Rows of the state, each [cases, 1], as the text of a kernel indexes and replaces them.

    A row of the states is a view made when it is read: a list of all rows would hold one array object for
    each number of the state, many times the numbers themselves where a mechanism has many elements.
    """

    def __init__(self, rows: Array) -> None:
        super().__init__()
        self.rows = rows

    def __missing__(self, row: int) -> Any:
        return self.rows[row] if row < len(self.rows) else 0.0


def constraint_rows(
    layout: Layout, states: Array, topology: Topology, joined: Sequence[int], turns: Sequence[float] = (0.0,)
) -> Array:
    """Return the rows of all constraints on (x, y, theta) of the joined particles [cases, turns, rows, 3
    particles], with all bodies turned by each of the angles ``turns`` (rad).

    The rows are computed by the text of the step, run on arrays of all cases and turns. A pin on a path
    chooses a piece by its place, which text on arrays cannot do: with such a pin, cases and turns are
    computed one by one.
    """
    starts, result = (
        topology.constraint_starts,
        np.zeros((topology.constraint_starts[-1], len(joined), 3, len(states), len(turns))),
    )
    if ON_PATH in topology.joint_place and result.shape[3:] != (1, 1):
        alone = [
            [constraint_rows(layout, state[None], topology, joined, (turn,))[0, 0] for turn in turns]
            for state in states
        ]
        return np.array(alone).reshape(len(states), len(turns), -1, 3 * len(joined))
    integers = tables(topology)[0]
    S = StateRows(np.ascontiguousarray(states.T)[:, :, None])
    angle = states[:, None, layout["particle_theta"]] + np.reshape(turns, (-1, 1))
    angle = np.where(np.arange(topology.particles) > 0, angle, 0.0)[..., list(topology.bound)]
    for name, values in zip(("s", "c"), sincos(angle), strict=True):
        for row, value in zip(layout[name].tolist(), np.moveaxis(values, -1, 0), strict=True):
            S[row] = value
    KERNEL.levers(S, integers.tolist())
    for joint, (bearing, journal, carrier) in enumerate(
        zip(topology.joint_bearing, topology.joint_journal, topology.carriers, strict=True)
    ):
        b, k, c = (joined.index(particle) for particle in (bearing, journal, carrier))
        for q in range(starts[joint], starts[joint + 1]):
            row = layout.record("constraint", q)
            nx, ny, jb, jk, jc = (
                S[row + field]
                for field in (CONSTRAINT.nx, CONSTRAINT.ny, CONSTRAINT.jb, CONSTRAINT.jk, CONSTRAINT.jc)
            )
            for particle, values in ((b, (-nx, -ny, -jb)), (k, (nx, ny, jk)), (c, (0.0, 0.0, -jc))):
                for axis, value in enumerate(values):
                    result[q, particle, axis] += value
    return np.moveaxis(result, (3, 4), (0, 1)).reshape(len(states), len(turns), len(result), -1)


def _impact_force(law: ContactLaw, slots: tuple[float, ...], speed: float, mobility: float) -> float:
    """Return the force (N) of an impact at the largest ``speed`` (m/s) in the mechanism, for a contact
    without an expected force: the elastic energy at its end equals the kinetic energy.
    """
    speed = max(speed, 0.1)
    energy = 0.5 * (speed * speed) / max(mobility, 1e-12)

    def stores(depth: float) -> bool:
        return not float(elastic_energy(law, np.array([depth]), slots)[0]) < energy

    depth = DEPTHS[bisect_left(DEPTHS, True, hi=len(DEPTHS) - 1, key=stores)]
    return float(law.force(depth, 0.0, slots)[0])
