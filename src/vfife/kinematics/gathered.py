"""All rows of a rigid system at once, and positions in which a single joint is open: the text of the step,
run on arrays.

:func:`~vfife.kinematics.system.equations` takes the rows one by one, which suits a start; a motion that is
followed through a turn needs hundreds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.constraint import Guide
from ..kernels.topology import ACROSS, ALONG, APART
from ..model.rows import Across, Along, Apart, OnPath
from ..numerics import dense
from ..numerics.elementwise import sincos
from ..numerics.products import norm, product, times
from .constraints import KERNEL, Constraint
from .system import RigidSystem

Array = NDArray[np.float64]

AXES = ((1.0, 0.0), (0.0, 1.0))
KINDS = {Across: ACROSS, Along: ALONG, Apart: APART}


class Gathered:
    """phi [r] (m) and G [r, 3(n-1)] in (x, y, l theta), as :func:`~vfife.kinematics.system.equations` has
    them, at other aims of the drives.

    Rows are those of the system, in its order.
    """

    def __init__(self, system: RigidSystem) -> None:
        self.system = system
        self.rows, self.columns = system.starts[-1], 3 * len(system.names)
        owners = range(len(system.constraints))
        self.places = [
            (kind, _Group(system, [k for k in owners if _kind(system.constraints[k]) == kind]))
            for kind in (-1, *KINDS.values())
        ]
        self.places = [(kind, group) for kind, group in self.places if len(group.row)]
        self.odd = [k for k in owners if isinstance(system.constraints[k].place, OnPath)]
        turned = [k for k in owners if system.constraints[k].turn is not None]
        self.turns = _Group(system, turned, last=True)
        self.ratio = np.array([system.constraints[k].ratio for k in turned])
        self.length = np.array([system.lengths[k] for k in turned])
        self.carrier = np.array([system.constraints[k].body_c for k in turned], dtype=int)
        self.fixed = np.zeros(self.rows)  # what rows keep: turns (times their length) and travels
        for k, one in enumerate(system.constraints):
            last = system.starts[k + 1] - 1
            if one.turn is not None:
                self.fixed[last] = system.lengths[k] * one.aim
            elif isinstance(one.place, Along):
                self.fixed[last] = one.aim
            elif isinstance(one.place, Apart):
                self.fixed[last] = one.place.length
        self.driven = np.arange(system.held, self.rows)
        self.scale = np.array(
            [
                system.lengths[k] if one.turns else 1.0
                for k, one in enumerate(system.drives, start=len(system.joints))
            ]
        )
        self.pinned, self.levers = self._pins()
        self.reach = np.where(np.arange(self.columns) % 3 == 2, np.repeat(system.reach, 3), 1.0)

    def _pins(self) -> tuple[Array, NDArray[np.intp]]:
        """G of pins without its levers, and where in it those are: of bodies a for both directions, then of
        bodies b.
        """
        G = np.zeros((self.rows, self.columns))
        group = dict(self.places).get(-1)
        if group is None:
            return G, np.zeros(0, dtype=int)
        at = []
        for body, sign in ((group.a, -1.0), (group.b, 1.0)):
            for k in (0, 1):
                G[group.row + k, 3 * body + k] = sign
                at.append((group.row + k) * self.columns + 3 * body + 2)
        return G, np.concatenate(at)

    def aimed(self, aims: Array) -> Array:
        """What the rows keep with the drives at ``aims`` [..., d] (rad, m)."""
        kept = np.broadcast_to(self.fixed, (*aims.shape[:-1], self.rows)).copy()
        kept[..., self.driven] = self.scale * aims
        return kept

    def at(self, position: Array, kept: Array) -> tuple[Array, Array]:
        """phi [..., r] and G [..., r, 3(n-1)] at positions [..., n, 3]."""
        lead = position.shape[:-2]
        phi, G = (
            np.zeros((*lead, self.rows)),
            np.broadcast_to(self.pinned, (*lead, self.rows, self.columns)).copy(),
        )
        x, y, angle = position[..., 0], position[..., 1], position[..., 2]
        s, c = sincos(angle)
        for kind, group in self.places:
            a, b, row = group.a, group.b, group.row
            ax, ay = KERNEL.arm(c[..., a], s[..., a], *group.point_a)
            bx, by = KERNEL.arm(c[..., b], s[..., b], *group.point_b)
            foot_x, foot_y = bx + x[..., b] - x[..., a], by + y[..., b] - y[..., a]
            ex, ey = foot_x - ax, foot_y - ay
            if kind == -1:
                phi[..., row], phi[..., row + 1] = ex, ey
                levers = [
                    sign * KERNEL.lever(*arm, *n)
                    for arm, sign in (((ax, ay), -1.0), ((bx, by), 1.0))
                    for n in AXES
                ]
                G.reshape(*lead, -1)[..., self.levers] = np.concatenate(levers, axis=-1)
            else:
                phi[..., row], nx, ny = KERNEL.guide_row(
                    (), Guide(kind, 0, 0, *group.direction), c[..., a], s[..., a], ex, ey
                )
                _put(G, row, a, -nx, -ny, -KERNEL.lever(foot_x, foot_y, nx, ny))
                _put(G, row, b, nx, ny, KERNEL.lever(bx, by, nx, ny))
        for k in self.odd:
            for at in np.ndindex(lead):
                self._one(k, position[at], phi[at], G[at])
        if len(self.turns.row):
            a, b, row = self.turns.a, self.turns.b, self.turns.row
            phi[..., row] = self.length * KERNEL.relative_turn(
                angle[..., a], angle[..., b], self.ratio, angle[..., self.carrier]
            )
            G[..., row, 3 * a + 2] = -self.length * self.ratio
            G[..., row, 3 * b + 2] = self.length
            G[..., row, 3 * self.carrier + 2] -= self.length * (1.0 - self.ratio)
        return phi - kept, (G / self.reach)[..., 3:]

    def _one(self, k: int, position: Array, phi: Array, G: Array) -> None:
        """The row of a pin in a slot, and no more of its constraint."""
        one, row = self.system.constraints[k], self.system.starts[k]
        found = one.rows(position, None, 1.0)
        phi[row] = found.phi[0]
        for body, block in ((one.body_a, found.a[0]), (one.body_b, found.b[0])):
            G[row, 3 * body : 3 * body + 3] = block


class _Group:
    """Bodies, points, directions and first (or last) rows of constraints of a kind."""

    def __init__(self, system: RigidSystem, owners: list[int], last: bool = False) -> None:
        ones = [system.constraints[k] for k in owners]
        self.a = np.array([one.body_a for one in ones], dtype=int)
        self.b = np.array([one.body_b for one in ones], dtype=int)
        self.row = np.array(
            [system.starts[k + 1] - 1 if last else system.starts[k] for k in owners], dtype=int
        )
        self.point_a = np.array([one.point_a for one in ones], dtype=float).reshape(-1, 2).T
        self.point_b = np.array([one.point_b for one in ones], dtype=float).reshape(-1, 2).T
        units = [
            place.unit() if isinstance(place := one.place, Across | Along) else (1.0, 0.0) for one in ones
        ]
        self.direction = np.array(units, dtype=float).reshape(-1, 2).T


def _kind(one: Constraint) -> int | None:
    """Of the row of a place: -1 of two pins in one place; None where there is none, or it is that of a slot."""
    if one.place is None or isinstance(one.place, OnPath):
        return None
    return KINDS.get(type(one.place), -1)


def _put(G: Array, row: Array, body: Array, x: Array | float, y: Array | float, turn: Array) -> None:
    G[..., row, 3 * body], G[..., row, 3 * body + 1], G[..., row, 3 * body + 2] = x, y, turn


FELT = 1e-3  # part of the largest self-stress from which a row takes part
HELD = 10.0  # weight of the joints that stay closed
LARGEST_TURN = 0.3  # rad in a step
CLOSE = 1e-10  # of the extent
ROUNDS, STEPS = 8, 40
FINEST = 1e-9  # of the extent: a step that is none


def closing_joint(system: RigidSystem, rows: Array | None = None) -> int | None:
    """The joint, by number, that closes the loop of the rows that take part (all, unless a self-stress [rows]
    says so).

    Bodies are hung from the ground on, those nearest to it first; it is the joint left over between the two
    furthest from it.
    """
    part = [
        k for k in range(len(system.joints)) if rows is None or rows[system.rows(k)].max(initial=0.0) > FELT
    ]
    depth, hung, waiting = {0: 0}, set(), [0]
    while waiting:
        body = waiting.pop(0)
        for k in part:
            one = system.joints[k]
            other = one.body_b if one.body_a == body else one.body_a
            if body in (one.body_a, one.body_b) and other not in depth:
                depth[other] = depth[body] + 1
                hung.add(k)
                waiting.append(other)
    left = [
        k
        for k in part
        if k not in hung and system.joints[k].body_a in depth and system.joints[k].body_b in depth
    ]
    return max(
        left, key=lambda k: depth[system.joints[k].body_a] + depth[system.joints[k].body_b], default=None
    )


class Parted(NamedTuple):
    """A position [n, 3] in which everything but a joint is closed and that one is open least, by ``gap`` (m).

    ``pulls`` [rows] (m): d gap = pulls . d phi / gap, at a given position, of what changes the rows.
    """

    position: Array
    gap: float
    pulls: Array


def parted(gathered: Gathered, joint: int, aims: Array, guess: Array) -> Parted:
    """Opens a joint by as little as its loop allows, near a guess [n, 3], by the method of multipliers."""
    kept, here, extent = (
        gathered.aimed(aims),
        gathered.system.rows(joint),
        float(gathered.system.reach[1:].max()),
    )
    weight, shift, position = np.full(gathered.rows, HELD), np.zeros(gathered.rows), guess
    weight[here] = 1.0
    for _ in range(ROUNDS):
        position, phi = _least(gathered, kept, weight, shift, position)
        shift += phi
        shift[here] = 0.0
        if np.abs(np.delete(phi, np.arange(here.start, here.stop))).max(initial=0.0) <= CLOSE * extent:
            break
    pulls = HELD * HELD * shift
    pulls[here] = phi[here]
    return Parted(position, norm(phi[here]), pulls)


def _least(
    gathered: Gathered, kept: Array, weight: Array, shift: Array, position: Array
) -> tuple[Array, Array]:
    """The position with the least |weight (phi + shift)|, by damped Gauss-Newton steps, and phi there."""
    scale, extent = gathered.reach[3:], float(gathered.system.reach[1:].max())
    (phi, jacobian), damping = gathered.at(position, kept), 1e-2
    for _ in range(STEPS):
        error = weight * (phi + shift)
        weighted = weight[:, None] * jacobian
        step = dense.solve(
            product(weighted.T, weighted) + damping * np.eye(len(scale)), -times(weighted.T, error)
        )
        step /= max(1.0, float(np.abs(step / scale)[2::3].max()) / LARGEST_TURN)
        if np.abs(step).max() <= FINEST * extent or damping > 1e9:
            break
        trial = position.copy()
        trial[1:] += (step / scale).reshape(-1, 3)
        tried, turned = gathered.at(trial, kept)
        if norm(weight * (tried + shift)) < norm(error):
            position, phi, jacobian, damping = trial, tried, turned, max(damping / 3.0, 1e-9)
        else:
            damping *= 4.0
    return position, phi
