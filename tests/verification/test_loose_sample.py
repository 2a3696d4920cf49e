"""Ranges of runs with contact are errors that hold: a sample of mechanisms against a step twenty times
smaller, and against plain equations.

The sample has other kinds than the rest of the suite (tests/loose_sample.py). The plain equations share
nothing with the package: constrained motion by Gauss' principle, integrated by DOP853, contacts begun and
ended at located roots (tests/differential/constrained.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vfife
from differential import constrained as plain
from differential.pencil import Drawn
from loose_sample import EACH, FRESH, KINDS, drawn
from vfife.measures.error_ranges import JUDGED, LOADS, own_ranges, sizes
from vfife.measures.trust import trust
from vfife.simulation.result import Result
from vfife.solvers.status import Status

FINER = 20  # times smaller is the step of the truth
INSIDE = 0.99  # of the measures of runs that are not called sensitive
OUTSIDE = 0.005  # of its size: by no more may the truth of a measure lie outside of its range
CALLED = 0.15  # of the runs may be called sensitive
NOISE = 1e-9  # of the largest load: what is less is rounding
# Depth (m) at which the plain equations have a contact begin. One that ended where it is zero to rounding,
# and begins at once again, is seen so.
APART = 1e-10
QUICK = (
    ("hung", 0), ("six-bar", 2), ("offset", 0), ("torque", 0), ("yoke", 0), ("quick-return", 2),
    ("sprung", 3), ("thrown", 1), ("guide", 2),
    ("cam", 0),
)  # fmt: skip
EQUATED = ("hung", "six-bar", "offset", "torque", "yoke", "quick-return", "sprung", "thrown")


@dataclass(frozen=True)
class Found:
    """A run, whether it is called sensitive, and by how much of its size the truth of each measure lies
    outside of its range.
    """

    result: Result
    sensitive: bool
    outside: dict[str, float]


def measure_sizes(result: Result) -> dict[str, float]:
    """Size of each measure: that of largest values as runs are judged by, else its own or a tenth of the
    largest of its kind.
    """
    found, step = result.measures, result.record.assembly.choice.step
    largest = sizes(own_ranges(result.record), step)
    load = max((float(one) for name, one in found.items() if name.endswith(LOADS)), default=0.0)
    kinds: dict[str, float] = {}
    for name, one in found.items():
        kind = ".".join(name.split(".")[-2:])
        kinds[kind] = max(kinds.get(kind, 0.0), abs(one))
    size = {name: max(abs(one), 0.1 * kinds[".".join(name.split(".")[-2:])]) for name, one in found.items()}
    judged = tuple(f".{kind}" for kind in JUDGED)
    return {
        name: largest.get(name, value)
        for name, value in size.items()
        if found[name].estimated
        and (name in largest or not name.endswith(judged))
        and value > NOISE * load * name.endswith((".mean", ".total"))
    }


@cache
def checked(kind: str, seed: int) -> Found | None:
    """The run of a mechanism of the sample against a finer one; None where it comes to no end."""
    mechanism = drawn(kind, seed).m
    result = vfife.simulate(mechanism, reference=False)
    said = trust(result.record, result.measures)
    if result.record.status != Status.COMPLETE or said is None:
        return None
    if said.sensitive:
        return Found(result, True, {})
    step = result.record.assembly.choice.step / FINER
    truth = vfife.simulate(mechanism, reference=False, step=step, companions=0).measures
    outside = {
        name: (
            max(truth[name] - result.measures[name].high, result.measures[name].low - truth[name], 0.0) / size
        )
        for name, size in measure_sizes(result).items()
        if name in truth
    }
    return Found(result, False, outside)


def largest_values(found: Found) -> dict[str, float]:
    """By how much the truth lies outside of the ranges of those values that a run is judged by."""
    return {
        name: one
        for name, one in found.outside.items()
        if name.endswith(tuple(f".{kind}" for kind in JUDGED))
    }


@pytest.mark.system("compares whole runs with references")
@pytest.mark.parametrize(("kind", "seed"), QUICK)
def test_the_truth_lies_in_the_range(kind: str, seed: int) -> None:
    found = checked(kind, seed)
    assert found is not None and not found.sensitive
    assert max(largest_values(found).values()) <= OUTSIDE, found.outside
    assert sum(one == 0.0 for one in found.outside.values()) >= INSIDE * len(found.outside) - 1.0, (
        found.outside
    )


@pytest.mark.verify
def test_the_ranges_of_a_sample_hold_the_truth() -> None:
    """More than 200 runs: 99 % of the measures inside, none outside by more than 0.5 %, few runs called
    sensitive.

    These mechanisms were drawn after the constants of the estimate had been chosen. Among the 234 with
    smaller seeds, by which they were chosen, two runs have more than that outside: in yoke 15 the largest
    value falls into the first output interval of the last turn, whose first instant belongs to the turn
    before (0.9 %); in other laws 11 losses in impacts change with the step where the largest values do not
    (22 % of a fortieth of what friction takes).
    """
    runs = {(kind, seed): checked(kind, seed) for seed in range(FRESH, FRESH + EACH) for kind in KINDS}
    complete = {key: found for key, found in runs.items() if found is not None}
    certain = {key: found for key, found in complete.items() if not found.sensitive}
    assert len(complete) >= 200 and len(certain) >= (1.0 - CALLED) * len(complete)
    every = [(one, *key, name) for key, found in certain.items() for name, one in found.outside.items()]
    largest = [
        (one, *key, name) for key, found in certain.items() for name, one in largest_values(found).items()
    ]
    for some in (every, largest):
        misses = sorted((one for one in some if one[0] > 0.0), reverse=True)
        print(f"{len(some)} measures of {len(certain)} runs, {len(misses)} outside: {misses[:20]}")
        assert len(misses) <= (1.0 - INSIDE) * len(some), misses
        assert max(one[0] for one in some) <= OUTSIDE


def plain_peaks(one: Drawn, begin: float, end: float) -> dict[str, float]:
    """Largest contact forces, penetrations and angular accelerations between two times, by the plain
    equations.
    """
    system, t = one.system, 0.0
    n, root = len(system.mass) - 1, system.root
    y = np.concatenate([np.array(system.q)[1:].ravel(), one.velocity.ravel()])
    found: dict[str, float] = {}

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate(
            [
                y[3 * n :],
                system.moved(t, y[: 3 * n].reshape(-1, 3), y[3 * n :].reshape(-1, 3), root)[0] / root,
            ]
        )

    def crossing(touch: plain.Touch):
        apart = 0.0 if touch.speed > 0.0 else APART

        def depth(t: float, y: np.ndarray) -> float:
            return touch.seen(system._now(y, n))[0] - apart

        depth.terminal, depth.direction = True, -1.0 if touch.speed > 0.0 else 1.0
        return depth

    def look(t: float, y: np.ndarray) -> None:
        now = system._now(y, n)
        values = {f"{touch.name}.force.max": abs(touch.force(now)[0]) for touch in system.touches}
        values |= {f"{touch.name}.penetration.max": touch.seen(now)[0] for touch in system.touches}
        turning = np.abs(rates(t, y)[3 * n :].reshape(-1, 3)[:, 2])
        values |= {
            f"{body}.angular_acceleration.max": float(value)
            for body, value in zip(one.m.bodies, turning, strict=True)
        }
        for name, value in values.items():
            found[name] = max(found.get(name, 0.0), value)

    while t < end:
        events = [crossing(touch) for touch in system.touches]
        done = solve_ivp(
            rates,
            (t, end),
            y,
            method="DOP853",
            rtol=1e-9,
            atol=1e-12,
            events=events,
            max_step=2e-4,
            dense_output=True,
        )
        for first, last in zip(done.t[:-1], done.t[1:], strict=True):
            for at in np.linspace(first, last, 7)[1:]:
                if at > begin:
                    look(at, done.sol(at))
        t, y = float(done.t[-1]), done.y[:, -1]
        for touch, hits in zip(system.touches, done.t_events, strict=True):
            if len(hits):
                touch.speed = 0.0 if touch.speed > 0.0 else max(touch.seen(system._now(y, n))[2], 1e-3)
    return found


@pytest.mark.verify
@pytest.mark.parametrize("kind", EQUATED)
@pytest.mark.parametrize("seed", range(4))
def test_the_plain_equations_lie_in_the_range(kind: str, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plain, "FASTEST", 1e4)
    one = drawn(kind, seed)
    assert one.reactions == ["plain"]
    result = vfife.simulate(one.m, reference=False)
    said, choice = trust(result.record, result.measures), result.record.assembly.choice
    assert said is not None
    if said.sensitive:
        return
    end = float(result.time[-1])
    truth = plain_peaks(one, end - choice.turn if choice.turn else 0.0, end)
    size = sizes(own_ranges(result.record), choice.step)
    for name in truth.keys() & size.keys():
        low, high = result.measures[name].low, result.measures[name].high
        assert low - OUTSIDE * size[name] <= truth[name] <= high + OUTSIDE * size[name], (
            name,
            low,
            truth[name],
            high,
        )
