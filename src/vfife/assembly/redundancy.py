"""Whether ideal joints hold more than there is to hold, as the equations of their reactions have it at the start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..codegen.graph import derive, tables
from ..kernels.arrays import CONSTRAINT_INDEX, HEADER, Layout
from ..kernels.constraint import levers
from ..kernels.factors import factor, fill
from ..kernels.topology import Topology

DEPENDENT = 1e-9  # pivot, of what it was before elimination, of a row that follows from those before it


def redundant(layout: Layout, state: NDArray[np.float64], topology: Topology) -> bool:
    """Whether a constraint follows from those before it, in the state of the start; only those that close loops may."""
    if not any(derive(topology).closing):
        return False
    integers, _, rows = tables(topology)
    I, S = integers.tolist(), [0.0] * rows
    S[: layout.rows] = state.tolist()
    turned = [p for p in topology.bound if p > 0]
    for name, values in (("c", np.cos), ("s", np.sin)):
        for p in turned:
            S[layout.row(name, p)] = float(values(state[layout.row("particle_theta", p)]))
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
