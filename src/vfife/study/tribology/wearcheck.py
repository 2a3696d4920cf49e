"""A companion of wear: the block of turns after the last jump again with half the step, whose rates say what the step does to them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...analysis.wear import PLACES
from ...assembly.assemble import assemble
from ...solvers.blocks import Blocks
from ...solvers.halt import Halt
from ...solvers.restepped import restepped
from .worn import Asked, Surface, rates, smooth

Array = NDArray[np.float64]
FINER = 2  # times as many steps in a turn


def beside(asked: Asked, surfaces: Sequence[Surface], blocks: Blocks, rate: Array, halt: Halt) -> tuple[float, float]:
    """How far rates of wear are apart from ``rate`` with half the step: of the volume of all surfaces, and of the deepest place of any, as shares.

    Both begin with the state that ``blocks`` are in; what their turns leave open by themselves is in it.
    """
    model, turn = blocks.assembly.mechanism, blocks.assembly.choice.turn or 0.0
    other = assemble(model, turn / (FINER * asked.steps), turns=1, outputs=PLACES, force_step=True)
    again = Blocks(other, PLACES, halt)
    state = blocks.state
    again.runner.states[:, 0], again.runner.done = restepped(state[:-1], int(state[-1]), other)
    again.shape(*(state[rows] for rows in blocks.harmonics))
    found, _ = rates(again.advance(asked.settle, asked.block), surfaces, asked.block)
    whole, largest = float(rate.sum()), float(np.abs(around(asked, rate)).max())
    apart = abs(float(found.sum()) / whole - 1.0) if whole > 0.0 else 0.0
    return apart, float(np.abs(around(asked, found - rate)).max()) / largest if largest > 0.0 else 0.0


def around(asked: Asked, rate: Array) -> Array:
    """Rates as the geometry follows them."""
    return smooth(rate, max(asked.harmonics, 1))
