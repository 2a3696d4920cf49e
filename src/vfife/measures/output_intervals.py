"""Errors of measures because outputs are some of the steps only: of largest values that are taken at the
outputs, and of sums and means over turns that begin and end between two outputs.

Between two outputs a smooth curve leaves their chord by at most h^2/8 max|f''|, with the interval h of the
outputs. Second differences of the outputs stand for h^2 f''. They do so only where outputs resolve the curve:
then second differences over two intervals are about four times as large. Curves that oscillate within two or
three outputs fail this test, and their largest values are not estimated.

Sums and means are computed again with the other interpolation of :mod:`~vfife.measures.turn_ends` at one end
of the turns, then at the other. The differences are added, because those of both ends may cancel by chance.
"""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import hypot
from ..solvers.record import Record
from .catalogue import OVER_TURN, PEAKS, Groups, over_turn
from .elastic import elastic_links, extremes, has_stresses, largest_deflection
from .forces import ground_joints, ground_load, joint_force, joint_force_max, joint_rows
from .motion import slider_motion, sliders
from .repetition import Turns
from .turn_ends import ends_of_last_turn, other_state_at
from .turns import Window, after_first, each_turn, last_turn, of_window

Array = NDArray[np.float64]
# Factor of safety: second differences are known at the outputs only, and of a sine of twelve outputs a period
# they are 2 % less than h^2 f'', of one of five 12 % less.
SAFETY = 2.0
# Least ratio of second differences over two intervals to those over one: four for a curve that many outputs
# resolve, 2 (1 + cos(2 pi/n)) for a sine of n outputs a period, which is this much for n = 5.
RESOLVED = 2.6
FEWEST = 9  # outputs from which on their second differences are judged
ARM = 1e-12  # m: a moment of the largest force on this arm is rounding
ROUNDING = 1e-9  # of the largest value, below which second differences are rounding


def with_intervals(errors: Mapping[str, float], record: Record, first: int) -> dict[str, float]:
    """Return errors by measure, with what is missed between outputs in addition; measures of which that is
    unknown are left out.
    """
    intervals = interval_errors(record, first)
    sums = {name: error + intervals.get(name, 0.0) for name, error in errors.items()}
    return {name: error for name, error in sums.items() if math.isfinite(error)}


def interval_errors(record: Record, first: int) -> dict[str, float]:
    """Return what largest values at the outputs may miss, by measure in its unit; infinite where outputs do
    not resolve the curve. ``first``: step from which outputs are evaluated.
    """
    rows = np.asarray(record.steps) >= first
    part = dataclasses.replace(record, steps=record.steps[rows], source=record.rows[rows], companions=None)
    errors: dict[str, float] = {}
    for name, curve in sampled_curves(part):
        errors[name] = max(errors.get(name, 0.0), missed(curve))
    return errors | _drives(part)


def sampled_curves(record: Record) -> Iterator[tuple[str, Array]]:
    """Yield the curves at the outputs, shape (outputs,), of which measures are largest values or ends."""
    if record.keeps("particle_u"):
        for name in sliders(record):
            motion = slider_motion(record, name)
            yield f"{name}.position.low", motion.position
            yield f"{name}.position.high", motion.position
            yield f"{name}.velocity.max", motion.velocity
            yield f"{name}.acceleration.max", motion.acceleration
    if record.keeps("particle_x"):
        load = ground_load(record)
        force, moment = hypot(load[:, 0], load[:, 1]), load[:, 2]
        yield "ground.shaking_force.max", force
        # Forces that pass through the origin leave a moment of rounding, which no output resolves.
        yield "ground.shaking_moment.max", moment * (np.abs(moment).max() > ARM * force.max())
    if record.keeps("frame_axial_force") and has_stresses(record):
        for name, body in record.assembly.bodies.items():
            if body.elements:
                for kind, values in zip(("tension", "compression"), extremes(record, name), strict=True):
                    yield f"{name}.{kind}.max", values
    if record.keeps("frame_moment_1") and record.keeps("particle_x"):
        for name in elastic_links(record):
            yield f"{name}.deflection.max", np.abs(largest_deflection(record, name))


def missed_end(curve: Array, part: slice, sign: float) -> float:
    """Return how far the largest value of ``sign`` times a curve in a ``part`` of its outputs may lie beyond
    that output.

    With second differences D of the outputs beside it, a parabola rises by D/8 at most, and a curve whose
    slope jumps between two outputs by D/2. The latter is the bound.
    """
    k = part.start + int(np.argmax(sign * curve[part]))
    bends = np.abs(np.diff(curve[max(k - 2, 0) : k + 3], 2))
    return 0.5 * float(bends.max(initial=0.0))


def missed(curve: Array) -> float:
    """Return how far a curve may leave the chords between its outputs; infinite if they do not resolve it."""
    if not len(curve) or not np.isfinite(curve).all():
        return math.inf
    small = ROUNDING * float(np.abs(curve).max())
    if float(np.ptp(curve)) <= small:
        return 0.0
    if len(curve) < FEWEST:
        return math.inf
    bend, wide = (_second_difference(curve, shift) for shift in (1, 2))
    if bend > small and wide < RESOLVED * bend:
        return math.inf
    return SAFETY * bend / 8.0


def missed_in_mean_square(curve: Array) -> float:
    """Return how far the root mean square of the outputs of a curve may be from that of the curve; infinite
    if they do not resolve it.

    By Minkowski's inequality, the root mean squares of a curve and of its chords differ by no more than that
    of the difference of both, which is known interval by interval from second differences. The mean square of
    the chords is less than that of the outputs by a sixth of that of the rises.
    """
    size = math.sqrt(float((curve * curve).mean()))
    if not size or not (largest := missed(curve)) or not math.isfinite(largest):
        return largest if size else 0.0
    rises, bends = np.diff(curve), np.pad(np.abs(np.diff(curve, 2)), 1, "edge")
    gaps = SAFETY / 8.0 * _larger_end(bends)
    return math.sqrt(float((gaps * gaps).mean())) + float((rises * rises).mean()) / (6.0 * size)


def _second_difference(curve: Array, shift: int) -> float:
    """Return the largest second difference over ``shift`` outputs to both sides."""
    return float(np.abs(curve[2 * shift :] - 2.0 * curve[shift:-shift] + curve[: -2 * shift]).max())


def _drives(record: Record) -> dict[str, float]:
    """Return the errors of ``<driven body>.torque.ripple``, both ends of the torque over its mean size, of
    ``.torque.rms`` and of both ends of ``.energy_fluctuation``.
    """
    if not record.keeps("driven_torque") or len(record.steps) < 2:
        return {}
    errors, half = {}, 0.5 * record.assembly.choice.step
    for name, body in record.assembly.bodies.items():
        if body.driven is None:
            continue
        torque = record.block("driven_torque")[:, body.driven]
        mean, error = abs(float(torque.mean())), missed(torque)
        errors[f"{name}.torque.ripple"] = 2.0 * error / mean if mean > 0.0 else math.inf
        errors[f"{name}.torque.rms"] = missed_in_mean_square(torque)
        if all(record.keeps(f"driven_{block}") for block in ("work", "power")):
            work, power = (record.block(f"driven_{block}")[:, body.driven] for block in ("work", "power"))
            fluctuating = work - half * power
            line = np.linspace(fluctuating[0], fluctuating[-1], len(fluctuating))
            errors[f"{name}.energy_fluctuation"] = 2.0 * missed(fluctuating - line)
    return errors


def shaking_estimate(record: Record, motion: Turns | None) -> float:
    """Return the largest force on the ground (N) with the peaks of joints between outputs; the mean over the
    turns of the measures.

    Between outputs each joint has its largest force without its direction, so that only the sum of all these
    bounds the force on the ground, although most of them cancel: the main bearing of a compressor carries the
    gas that pushes its head away. The estimate adds to the force at the outputs by how much each joint on the
    ground exceeds in the interval what it has at both ends. That is the truth for peaks that do not turn the
    force of a joint round within an interval.
    """
    if motion is None or not motion.has_several:
        return _shaking_peak(of_window(record, last_turn(record)).record)
    # Turn by turn: the forces of all outputs of a long run take as much memory as its rows.
    return float(np.mean([_shaking_peak(turn) for turn in each_turn(record, motion.first, motion.last)]))


def _shaking_peak(record: Record) -> float:
    """Return the estimate (N) for one turn, whose record begins with the output before it."""
    force = hypot(*ground_load(record)[:, :2].T)
    on_ground = set(ground_joints(record))
    places = [k for k, name in enumerate(joint_rows(record)) if name in on_ground]
    at_outputs = joint_force(record)[:, places]
    sizes = hypot(at_outputs[..., 0], at_outputs[..., 1])
    excess = np.maximum(joint_force_max(record)[1:, places] - _larger_end(sizes), 0.0).sum(axis=1)
    return float(np.max(_larger_end(force) + excess, initial=float(force[-1])))


def _larger_end(values: Array) -> Array:
    """Return the larger value at the two ends of each interval between outputs."""
    return np.maximum(values[1:], values[:-1])


def cut_errors(record: Record, motion: Turns | None, groups: Groups | None = None) -> dict[str, float]:
    """Return the errors of the measures of a run, by name in their units; none if its turns are whole numbers
    of outputs. ``motion``: the turns of which measures are taken.
    """
    sums = tuple(group for group in (OVER_TURN if groups is None else groups) if group not in PEAKS)
    if motion is None or not motion.has_several:
        ends = ends_of_last_turn(record)
        part = dataclasses.replace(record, turn_ends=ends)
        return {} if ends is None else _differences(record, part, last_turn(record), 0, sums)
    # Sums of successive turns add up, so that only the first beginning and the last end remain of their ends.
    turns = each_turn(record, motion.first, motion.last)
    first = next(turns)
    if first.turn_ends is None:
        return {}
    last = next(iter(deque(turns, maxlen=1)), first)
    errors: dict[str, float] = {}
    for end, part in enumerate((first, last)):
        for name, error in _differences(record, part, after_first(part), end, sums).items():
            errors[name] = errors.get(name, 0.0) + error / (motion.last - motion.first + 1)
    return errors


def _differences(record: Record, part: Record, window: Window, end: int, groups: Groups) -> dict[str, float]:
    """Return by how much measures of a turn change with the other interpolation at one ``end``, 0 or 1."""
    ends = part.turn_ends
    if ends is None:
        return {}
    rows = np.array(ends.rows)
    rows[end] = other_state_at(record, float(ends.steps[end]))
    changed = dataclasses.replace(part, turn_ends=ends._replace(rows=rows))
    values, changed_values = (over_turn(turn, window, groups) for turn in (part, changed))
    return {name: abs(changed_values.get(name, value) - value) for name, value in values.items()}
