"""Strokes of sliders over a turn of the crank, and loads over travel that do not fit them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..model.loads import Load
from ..model.mechanism import Mechanism
from ..numerics.elementwise import sincos
from .batch import Batch, Structures
from .drives import guide_of
from .forces import guide_direction
from .full_turn import POSITIONS_PER_TURN, FullTurn, positions_around
from .initial import Motion

Array = NDArray[np.float64]

# Share of the largest value by which the values of the two strokes may differ at the end of the stroke.
JUMP = 0.1
SHIFT = 0.01  # of a stroke, and of the largest pressure, by which a table may miss the dead centre


def strokes(
    batch: Batch, motions: Sequence[Motion], turns: Sequence[FullTurn], slider: str
) -> tuple[list[float], list[float]]:
    """Return the least and greatest travels (m) of a slider along its guide in each case, [cases].

    The extremes lie between the positions of a turn: each is that of a parabola through three positions that
    are a degree apart, around the extreme of a parabola through three positions of the turn.
    """
    values = travels(batch, motions, turns, slider)
    lows, highs = (
        _greatest(batch, motions, turns, slider, sign * values, sign).tolist() for sign in (-1.0, 1.0)
    )
    return [-value for value in lows], highs


def _greatest(
    batch: Batch,
    motions: Sequence[Motion],
    turns: Sequence[FullTurn],
    slider: str,
    values: Array,
    sign: float,
) -> Array:
    """Return the greatest travel (m) along a guide, times ``sign``, of each case with these ``values`` at the
    positions of its turn [cases, positions].
    """
    stride = 2.0 * np.pi / POSITIONS_PER_TURN
    around = positions_around(motions, turns, np.array([stride * vertex(row) for row in values]))
    narrow = [FullTurn(turn.direction, around[:, k]) for k, turn in enumerate(turns)]
    close = sign * travels(batch, motions, narrow, slider)
    left, middle, right = close.T
    curvature = left - 2.0 * middle + right
    bent = curvature < 0.0
    divisor = np.where(bent, curvature, -1.0)
    inside = bent & (np.abs(left - right) <= -2.0 * divisor)  # the vertex lies between the three positions
    peak = np.where(inside, middle - 0.125 * (right - left) * (right - left) / divisor, middle)
    return np.asarray(np.fmax(values.max(axis=-1), peak))


def vertex(values: Array) -> float:
    """Return the place, as a number of positions from the first, of the largest value of a turn whose last
    position repeats the first, by a parabola through three positions.
    """
    values, k = values[:-1], int(np.argmax(values[:-1]))
    left, middle, right = (float(values[(k + i) % len(values)]) for i in (-1, 0, 1))
    curvature = left - 2.0 * middle + right
    return k + (0.5 * (left - right) / curvature if curvature else 0.0)


def travels(batch: Batch, motions: Sequence[Motion], turns: Sequence[FullTurn], slider: str) -> Array:
    """Return the travels (m) of a slider along its guide at the positions of each case's turn, shape (cases,
    positions).
    """
    # A turn is solved for the mirror image where the mechanism has the other hand.
    images = np.array([(1.0, motion.hand, motion.hand) for motion in motions])[:, None, None]
    positions = np.array([turn.positions for turn in turns]) * images
    sides, names = batch.first.joints[slider].sides, motions[0].names
    places = [positions[:, :, names.index(body)] for body, _ in sides]
    bearing, journal = (
        place[..., :2] + rotated(place[..., 2], batch.from_center(side))
        for place, side in zip(places, sides, strict=True)
    )
    axis = rotated(places[0][..., 2], batch.column("joints", slider).numbers(guide_direction))
    return np.asarray(((journal - bearing) * axis).sum(axis=-1))


def rotated(angles: Array, vectors: Array) -> Array:
    """Return a vector of a body's axes in each case [cases, 2] in global axes at each of its angles (rad)
    [cases, angles], (cases, angles, 2).
    """
    s, c = sincos(angles)
    x, y = vectors.T[:, :, None]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def stroke_cautions(
    cases: Mapping[int, tuple[Mechanism, Motion, FullTurn]], structures: Structures
) -> dict[int, tuple[str, ...]]:
    """Return, for each case, a sentence on each load whose two strokes have different values where the slider
    reverses, whose table the slider does not reach, or whose pressure grows with the volume.
    """
    numbers = list(cases)
    result: dict[int, tuple[str, ...]] = dict.fromkeys(cases, ())
    for indices in structures.groups([mechanism for mechanism, _, _ in cases.values()]):
        members = [numbers[i] for i in indices]
        mechanisms, motions, turns = zip(*(cases[k] for k in members), strict=True)
        batch = structures.batch(mechanisms)
        for name, load in batch.first.loads.items():
            if load.axis == "travels" and guide_of(batch.first, load.slider) is not None:
                ends = strokes(batch, motions, turns, load.slider)
                for k, low, high in zip(members, *ends, strict=True):
                    load = cases[k][0].loads[name]
                    low, high = low - load.zero_travel, high - load.zero_travel
                    result[k] += (*_jumps(name, load, low, high), *_misplaced(name, load, low, high))
                    result[k] += tuple(_shifted(name, load, low, high))
    return result


def _jumps(name: str, load: Load, low: float, high: float) -> Iterator[str]:
    """Yield a sentence on a load with different values of its two strokes at the ends of a slider's travel
    (m).
    """
    jumps = [
        f"at {1e3 * place:.4g} mm from {out:.4g} to {back:.4g}"
        for place in (low, high)
        for out, back in [load.strokes_at(place)]
        if abs(out - back) > JUMP * load.largest
    ]
    if jumps:
        yield (
            f"The load {name} jumps where {load.slider} reverses: {' and '.join(jumps)}. The slider moves"
            f" from {1e3 * low:.4g} to {1e3 * high:.4g} mm of the table. At these two places both strokes"
            " should have the same load: adapt travels and zero_travel to the stroke."
        )


def _misplaced(name: str, load: Load, low: float, high: float) -> Iterator[str]:
    """Yield a sentence on a load whose table covers no part of a slider's travel (m), or on a pressure that
    is larger at the end to which it pushes, where its cylinder is largest.
    """
    first, last = load.places[0], load.places[-1]
    if low >= last or high <= first:
        start, end = (f"{round(1e3 * place, 6):.4g}" for place in (low, high))
        yield (
            f"The slider of load {name} moves from {start} to {end} mm of the table, which covers"
            f" {1e3 * first:.4g} to {1e3 * last:.4g} mm: the load keeps one value. Check zero_travel, the"
            " units of travels and the start position."
        )
    elif load.measured[0] == "Pa":
        at_low, at_high = (sum(load.strokes_at(place)) / 2.0 for place in (low, high))
        if math.copysign(1.0, load.unit) * (at_high - at_low) > JUMP * load.largest:
            end = f"{round(1e3 * (high if load.unit > 0.0 else low), 6):.4g}"
            yield (
                f"The pressure of load {name} is larger at {end} mm of the table, to which it pushes"
                f" {load.slider}, than at the other end: a gas has its largest pressure where its volume is"
                " least. Is reverse wrong, or the table turned?"
            )


def _shifted(name: str, load: Load, low: float, high: float) -> Iterator[str]:
    """Yield a sentence on a pressure whose larger end in the table is not where the slider's travel (m) ends:
    a table for another stroke, or for another length of a link.
    """
    first, last = load.places[0], load.places[-1]
    if load.measured[0] != "Pa" or low >= last or high <= first:
        return
    at_first, at_last = (sum(load.strokes_at(place)) for place in (first, last))
    end, place = (first, low) if at_first > at_last else (last, high)
    differs = abs(sum(load.strokes_at(place)) - max(at_first, at_last)) > 2.0 * SHIFT * load.largest
    is_beyond = place < first or place > last
    if abs(place - end) > SHIFT * (high - low) and (differs or is_beyond):
        yield (
            f"The slider of load {name} reverses at {round(1e3 * place, 6):.4g} mm of the table, whose"
            f" largest end pressure is at {1e3 * end:.4g} mm: is it for another stroke or link? For the same"
            f" gas at this dead centre, zero_travel = '{1e3 * (load.zero_travel + place - end):.6g} mm'."
        )
