"""Strokes of sliders over a turn of the crank, and loads over travel that do not fit them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..model.mechanism import Mechanism
from ..numerics.elementwise import sincos
from .drives import guide_of
from .full_turn import FullTurn
from .initial import Motion
from .pins import from_center

Array = NDArray[np.float64]
Point = tuple[float, float]

# Share of the largest value by which the values of the two strokes may differ at the end of the stroke. Ends
# are known from 37 positions of a turn, at worst 0.4 % of the crank's radius inside, where a steep table
# differs a little already.
JUMP = 0.1


def stroke(mechanism: Mechanism, motion: Motion, turn: FullTurn, slider: str) -> tuple[float, float]:
    """Return the least and greatest travel (m) of a slider along its guide, at the positions of a turn."""
    guided = guide_of(mechanism, slider)
    if guided is None:
        return 0.0, 0.0
    joint, guide = guided
    # A turn is solved for the mirror image where the mechanism has the other hand.
    positions = turn.positions * np.array([1.0, motion.hand, motion.hand])
    places = [positions[:, motion.system.names.index(body)] for body, _ in joint.sides]
    bearing, journal = (
        place[:, :2] + rotated(place[:, 2], from_center(mechanism, side))
        for place, side in zip(places, joint.sides, strict=True)
    )
    axis = rotated(places[0][:, 2], guide.unit())
    travel = ((journal - bearing) * axis).sum(axis=-1)
    return float(travel.min()), float(travel.max())


def rotated(angles: Array, vector: Point) -> Array:
    """Return a vector of a body's axes in global axes at each of its angles (rad), (angles, 2)."""
    s, c = sincos(angles)
    x, y = vector
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def stroke_cautions(mechanism: Mechanism, motion: Motion, turn: FullTurn | None) -> Iterator[str]:
    """Yield a sentence on each load whose two strokes have different values where the slider reverses;
    nothing where the turn is not known.
    """
    if turn is None:
        return
    for name, load in mechanism.loads.items():
        if load.axis != "travels" or guide_of(mechanism, load.slider) is None:
            continue
        low, high = (end - load.zero_travel for end in stroke(mechanism, motion, turn, load.slider))
        jumps = [
            f"at {1e3 * place:.4g} mm from {out:.4g} to {back:.4g}"
            for place, (out, back) in ((place, load.strokes_at(place)) for place in (low, high))
            if abs(out - back) > JUMP * load.largest
        ]
        if jumps:
            yield (
                f"The load {name} jumps where {load.slider} reverses: {' and '.join(jumps)}. The slider moves"
                f" from {1e3 * low:.4g} to {1e3 * high:.4g} mm of the table, where both strokes"
                " have the same load: adapt travels and zero_travel to the stroke."
            )
