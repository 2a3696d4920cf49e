"""Motions and forces that drivers and loads prescribe, and the largest step that resolves each of them.

The error of a step is, for a motion, its second difference minus the acceleration, and for a force a twelfth
of its second difference. It does not depend monotonically on the step if a function has waves of several
lengths. The largest step is therefore searched from above: halved until the function stays resolved, then
bisected. Bisection alone could stop at a step that is a whole wave long, where the error seems to vanish.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..kinematics.forces import driven_body
from ..model.functions import motion_function, timed
from ..model.geometry.polynomials import Polynomials
from ..model.mechanism import Mechanism

Array = NDArray[np.float64]

# Largest errors, as shares of the largest acceleration or force: of an automatic step, and of a given step
# before a caution.
RESOLVED = 5e-4
MISSED = 1e-2
SAMPLES, MOST_SAMPLES = 8, 50_000  # samples of a piece, and of a function
BETWEEN_KINKS = 100  # steps between two kinks
SHORTEST = 1e-6  # of the time span: smallest step that is searched
HALVINGS = 3  # halvings in a row after which a function counts as resolved
SPLITS = 10  # bisections: to a thousandth of the step
CLOSE = 1e-6  # of a piece: distance from its end at which its value there is taken
PHASES = 16  # places of a corner between two steps
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class InputFunction:
    """A prescribed function: its ``name``, the ``window`` of its argument (s, or rad over an angle) in a run,
    and ``pace``, the rate of its argument (1/s; 1 over time).

    ``motion``: joints are closed by its second difference; otherwise it is a force, of which the second
    integral moves bodies. ``reach`` (m) is the size of the mechanism that a travel moves, 1 for an angle
    (rad), and infinite for a function that turns nothing.
    """

    name: str
    function: Polynomials
    window: tuple[float, float]
    motion: bool
    pace: float = 1.0
    reach: float = math.inf


def input_functions(
    mechanism: Mechanism, length: float, spin: float, size: Callable[[], float]
) -> Iterator[InputFunction]:
    """Yield what drivers and loads prescribe in a run of ``length`` (s), if bodies turn at up to ``spin``
    (rad/s) and links are up to ``size()`` (m) long.
    """
    for name, driver in mechanism.drivers.items():
        body = driven_body(name, driver)
        if driver.moves:
            law = f"the motion law of {f'joint {driver.slider}' if driver.slider else driver.point or body}"
            # A rotation has no reach: turns are divided into steps anyway. At constant speed it has no error.
            reach = math.inf if driver.revolves and body else 1.0 if body else size()
            if reach == math.inf and driver.steady_speed is not None:
                continue
            yield InputFunction(
                law, motion_function(driver, 0.0, mechanism.clock), (0.0, length), True, reach=reach
            )
        elif driver.argument == "time":
            yield InputFunction(
                f"the force on {driver.point or body}",
                timed(driver.effort(), mechanism.clock),
                (0.0, length),
                False,
            )
        elif driver.argument == "angle" and spin > 0.0:
            effort = driver.effort()
            yield InputFunction(
                f"the torque on {body}", effort, (effort.starts[0], effort.starts[-1]), False, spin
            )
    for name, load in mechanism.loads.items():
        function, gap = load.course()
        ends = (function.starts[0], function.starts[-1])
        if load.argument == "time":
            yield InputFunction(f"the load {name}", timed(function, mechanism.clock), (0.0, length), False)
        elif load.argument == "angle" and spin > 0.0:
            yield InputFunction(
                f"the load {name}",
                function,
                ends if function.period is None else (0.0, function.period),
                False,
                spin,
            )
        elif load.argument == "travel" and spin > 0.0 and len(function.starts) > 1:
            # The table of a travel extends as far before its first place, and the travel is assumed to follow
            # half of its stroke times sin(spin t).
            stroke = 0.5 * (ends[1] - ends[0] - gap)
            yield InputFunction(f"the load {name}", function, ends, False, 0.5 * spin * stroke)


def step_limits(result: Iterator[InputFunction], share: float, turn_steps: float) -> list[tuple[str, float]]:
    """Return the largest step (s) for each function, by name, at which its error is at most ``share`` of its
    largest value and a turn has at least ``turn_steps`` steps; inf without a limit.
    """
    limits = []
    for function in result:
        step = _missed_at(function, share) / function.pace
        rate = (
            float(np.abs(_times_of(function)[1][:, 1]).max(initial=0.0))
            if math.isfinite(function.reach)
            else 0.0
        )
        limits.append(
            (
                function.name,
                min(step, 2.0 * math.pi * function.reach / (rate * turn_steps) if rate > 0.0 else math.inf),
            )
        )
    return limits


@lru_cache(maxsize=64)
def _times_of(input_function: InputFunction) -> tuple[Array, Array]:
    """Return the arguments at which a function is sampled, its knots included, and its values and two
    derivatives there.
    """
    first, last = input_function.window
    function = input_function.function
    if function.period is not None:
        last = min(last, first + function.period)
    knots = np.array([first, *(start for start in function.starts if first < start < last), last])
    parts = max(1, min(SAMPLES, MOST_SAMPLES // len(knots)))
    inside = knots[:-1, None] + np.diff(knots)[:, None] * (np.arange(parts) / parts)
    times = np.append(inside.ravel(), last)
    return times, function.sampled(times)


@lru_cache(maxsize=64)
def _missed_at(input_function: InputFunction, share: float) -> float:
    """Return the largest step (in the function's argument) whose error is at most ``share`` of the largest
    value; inf if all steps are.
    """
    times, values = _times_of(input_function)
    kinks = np.array(input_function.function.kinks)
    span = float(times[-1] - times[0])
    spacing = np.diff(kinks[(kinks >= times[0]) & (kinks <= times[-1])])
    longest: float = min(0.25 * span, float(spacing.min()) / BETWEEN_KINKS if len(spacing) else math.inf)
    if not span > 0.0 or not np.abs(values[:, 1:]).max() > 0.0:
        return math.inf
    # A motion without acceleration has no error at any step.
    if input_function.motion and not np.abs(values[:, 2]).max() > 0.0:
        return longest if len(spacing) else math.inf

    def missed(step: float) -> bool:
        return _miss(input_function, times, values, kinks, step) > share

    result, step, resolved = math.inf, longest, 0
    # Several halvings in a row must be resolved: a step of a whole wave alone has no error.
    while step > SHORTEST * span and resolved < HALVINGS:
        result, resolved = (step, 0) if missed(step) else (result, resolved + math.isfinite(result))
        step *= 0.5
    if not math.isfinite(result):
        return longest if len(spacing) else math.inf
    low, high = 0.5 * result, result
    for _ in range(SPLITS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if missed(middle) else (middle, high)
    return low


def _miss(input_function: InputFunction, times: Array, values: Array, kinks: Array, step: float) -> float:
    """Return the error of a step as a share of the largest value, away from kinks: steps with kinks are
    repeated in smaller ones.

    ``bends`` of a force, jumps of its second derivative, count as if the pieces on both sides shared them.
    """
    bends = np.array(input_function.function.bends).reshape(-1, 2)
    breaks = np.sort(np.append(kinks, bends[:, 0]))
    at = (
        np.searchsorted(breaks, times - step * (1.0 + 1e-9)),
        np.searchsorted(breaks, times + step * (1.0 + 1e-9)),
    )
    smooth = at[0] == at[1]
    early, late = (input_function.function.sampled(times[smooth] + side * step)[:, 0] for side in (-1.0, 1.0))
    present = values[smooth, 0]
    second = late - 2.0 * present + early
    noise = 8.0 * EPS * float(np.abs(values[:, 0]).max(initial=0.0))
    if input_function.motion:
        largest = float(np.abs(values[:, 2]).max()) * (step * step)
        error = np.abs(second - values[smooth, 2] * (step * step))
    else:
        largest, error = float(np.abs(values[:, 0]).max()), np.abs(second) / 12.0
    worst = max(
        0.0, float(error.max(initial=0.0)) - noise, float(bends[:, 1].max(initial=0.0)) * (step * step) / 12.0
    )
    return worst / largest if largest > 0.0 else 0.0


def peak_error(input_function: InputFunction, step: float) -> float:
    """Return by how much steps (s) may miss a peak at a corner or a jump of a force, as a share of its
    largest value. Half and quarter steps meet the same times again, so that repetitions with them do not
    show it.
    """
    function, (first, last) = input_function.function, input_function.window
    starts, width = np.array(function.starts), step * input_function.pace
    inside = np.flatnonzero((starts[1:] > first) & (starts[1:] < last))
    largest = float(np.abs(_times_of(input_function)[1][:, 0]).max(initial=0.0))
    if input_function.motion or not len(inside) or not largest > 0.0:
        return 0.0
    places = starts[1:][inside]
    left = places - CLOSE * np.diff(starts)[inside]
    peak = np.maximum(*(np.abs(function.sampled(times)[:, 0]) for times in (left, places)))
    largest_error = 0.0
    for share in (np.arange(PHASES) + 0.5) / PHASES:  # of the last step before the corner
        times = left - share * width, places + (1.0 - share) * width
        met = np.maximum(*(np.abs(function.sampled(time)[:, 0]) for time in times))
        largest_error = max(largest_error, float((peak - met).max()))
    return largest_error / largest
