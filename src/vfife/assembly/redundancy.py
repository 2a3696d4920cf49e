"""Whether ideal joints hold more than there is to hold, by the equations of their reactions at the start; which reactions that leaves open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..codegen.graph import derive, tables
from ..kernels.arrays import CONSTRAINT_INDEX, HEADER, Layout
from ..kernels.constraint import levers
from ..kernels.factors import factor, fill
from ..kernels.topology import FREE, PLACE_ROWS, Topology
from ..numerics import dense
from ..numerics.elementwise import cos, sin
from ..numerics.products import norm, product
from .stability import constraint_rows

Array = NDArray[np.float64]

DEPENDENT = 1e-9  # pivot, of what it was before elimination, of a row that may follow from those before it
VANISHING = 1e-7  # singular value of rows of unit length that is none: a pivot goes as its square, and small ones are not told from it there
FELT = 1e-6  # part of a joint in reactions that move nothing, of all of them


def redundant(layout: Layout, state: Array, topology: Topology) -> bool:
    """Whether a constraint follows from the others, in the state of the start; only those that close loops may."""
    return any(derive(topology).closing) and _small(layout, state, topology) and idle(layout, state, topology)[1].shape[1] > 0


def _small(layout: Layout, state: Array, topology: Topology) -> bool:
    """Whether the pivot of a row that closes a loop is so small that it may be none."""
    integers, _, rows = tables(topology)
    I, S = integers.tolist(), [*state.tolist(), *([0.0] * (rows - layout.rows))]
    turned = [p for p in topology.bound if p > 0]
    for name, values in (("c", cos), ("s", sin)):
        for p in turned:
            S[layout.row(name, p)] = float(values(float(state[layout.row("particle_theta", p)])))
        S[layout.row(name, 0)] = float(values(0.0))
    levers(S, I)
    fill(S, I)
    factor(S, I, 0.0)
    for k in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * k
        own, inverse = S[I[r + CONSTRAINT_INDEX.at] + k], S[I[HEADER.inverse] + k]
        if I[r + CONSTRAINT_INDEX.closing] and own > 0.0 and not 0.0 < DEPENDENT * own * inverse < 1.0:
            return True
    return False


def idle(layout: Layout, state: Array, topology: Topology) -> tuple[Array, Array, list[int]]:
    """G [rows, 3 particles], reactions N [rows, k] that move nothing, orthonormal in energy, and the particles: the joined ones, in order.

    G M^-1 G^T N = 0. Rows of G are divided by the roots of their own diagonals of G M^-1 G^T, so that N does not depend on units: N^T N = 1 are
    squares of reactions times what they would do alone, as the step weighs them.
    """
    joined = sorted({*topology.joint_bearing, *topology.joint_journal, *topology.carriers})
    inverse = np.stack([state[layout[f"particle_inverse_{kind}"]][joined] for kind in ("mass", "mass", "inertia")], axis=1).reshape(-1)
    rows = constraint_rows(layout, state, topology, joined)
    own = np.sqrt((rows * rows * inverse).sum(axis=1))
    rows = rows / np.where(own > 0.0, own, 1.0)[:, None]
    left, size, _ = dense.svd(rows * np.sqrt(inverse))
    return rows, left[:, int((size > VANISHING).sum()) :], joined


def shared(
    layout: Layout, state: Array, topology: Topology, ideals: Sequence[str], pivots: Sequence[str], driven: Sequence[str]
) -> tuple[str, ...]:
    """Reactions that rigid bodies leave open, ``<joint>.force``, ``<joint>.moment`` and ``<driven body>.torque``: those that have a part in some
    distribution that moves nothing. What is told of them is the one of least norm.

    ``ideals``, ``pivots`` and ``driven`` are names in the order of the topology's joints and driven bodies.
    """
    if not topology.redundant:
        return ()
    rows, stress, joined = idle(layout, state, topology)
    parts = norm(stress, axis=1)
    found = []
    for (place, turn), first, end, name in zip(topology.held, topology.constraint_starts, topology.constraint_starts[1:], ideals, strict=False):
        turns = end if turn == FREE else end - 1
        found += [f"{name}.force"] if PLACE_ROWS[place] and parts[first:turns].max() > FELT else []
        found += [f"{name}.moment"] if turn != FREE and parts[turns] > FELT else []
    on_driven = product(rows.T, stress).reshape(len(joined), 3, -1)
    largest = float(np.abs(rows).max(initial=0.0))
    for particle, pivot, body in zip(topology.driven, pivots, driven, strict=True):
        if particle in joined:
            fx, fy, moment = np.abs(on_driven[joined.index(particle)]).max(axis=1)
            found += [f"{pivot}.force"] if max(fx, fy) > FELT * largest else []
            found += [f"{body}.torque"] if moment > FELT * largest else []
    return tuple(found)
