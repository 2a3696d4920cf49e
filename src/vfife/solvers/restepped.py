"""A motion under way, gone on with at another step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..codegen.graph import tables
from ..kernels.advance import resize

Array = NDArray[np.float64]


def restepped(state: Array, done: int, assembly: Assembly) -> tuple[Array, int]:
    """A state after so many steps, shape (rows,), as ``assembly`` has it, which differs in its step and in other numbers: state and steps done.

    Positions, velocities, forces and what contacts remember stay; half-step velocities become those of the new step, by the text of the step.
    The clock stays where it is.
    """
    integers, layout, room = tables(assembly.topology)
    found = np.zeros(room)
    found[: layout.rows] = state
    shift, own = layout.row("shift"), layout.row("step")
    time, size = (done - 1 + float(found[shift])) * float(found[own]), assembly.choice.step
    number = round(time / size)
    kernel: Any = resize
    kernel(found, integers.tolist(), size, time / size - number, 0.0)
    given = layout.of("parameter")
    ahead = found[shift]
    found[given] = assembly.state[given]
    found[shift] = ahead
    return found[: layout.rows], number + 1
