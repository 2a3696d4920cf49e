"""Ranges of smooth runs against the truth: an independent integration, and runs with a step 32 times
smaller; near bifurcations too.
"""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vfife
from support import with_settings
from vfife.measures.error_ranges import sizes
from vfife.measures.smooth_errors import values_of
from vfife.measures.trust import trust
from vfife.model.mechanism import Mechanism
from vfife.simulation.result import Result

GRAVITY = 9.81
FINER = 32
QUICK, EVERY = range(8), range(60)
OUTSIDE = 0.005  # of a measure's size: no further may the truth lie outside of a range


def hung(
    radius: float, length: float, speed: float, stiffness: float, damping: float, angle: float, turns: float
) -> Mechanism:
    """A rod of 1 kg hung on a crank, ``angle`` (rad) from its rest, with a torsional spring and damper to
    the ground.
    """
    m = Mechanism("rod on a crank", gravity=(0.0, -GRAVITY))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=radius, mass=0.2, angle=0.0)
    m.link("rod", length=length, mass=1.0, angle=-0.5 * math.pi + angle)
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("A", "crank.end", "rod.start")
    m.drive("crank", speed=speed)
    m.torsional_spring("s", "ground", "rod", stiffness=stiffness, damping=damping, free_angle=-0.5 * math.pi)
    return with_settings(m, turns=turns)


def largest_accelerations(
    radius: float, length: float, speed: float, stiffness: float, damping: float, angle: float, turns: float
) -> np.ndarray:
    """Largest angular acceleration (rad/s^2) of the rod in each turn, by an eighth-order method; it begins
    with the least kinetic energy.
    """
    inertia, arm, turn = length**2 / 3.0, 0.5 * length, 2.0 * math.pi / speed

    def rates(time: Any, state: np.ndarray) -> list[Any]:
        theta, omega = state
        ax, ay = -radius * speed**2 * np.cos(speed * time), -radius * speed**2 * np.sin(speed * time)
        moment = (
            arm * (np.sin(theta) * ax - np.cos(theta) * (ay + GRAVITY))
            - stiffness * (theta + 0.5 * math.pi)
            - damping * omega
        )
        return [omega, moment / inertia]

    begin = -0.5 * math.pi + angle
    start = [begin, -arm * radius * speed * math.cos(begin) / inertia]
    found = solve_ivp(
        rates, (0.0, turns * turn), start, method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True
    )
    times = np.linspace(0.0, turn, 4001) + turn * np.arange(round(turns))[:, None]
    states = found.sol(times.ravel()).reshape(2, *times.shape)
    return np.abs(rates(times, states)[1]).max(axis=1)


# radius, length (m), speed (rad/s), stiffness (N m/rad), damping (N m s/rad), angle (rad), turns, steps a
# turn. The last ones lie beside the end of
# a regular motion: within half a percent of the speed it becomes chaotic.
CASES = {
    "calm": (0.05, 0.4, 5.0, 0.2, 0.05, 0.3, 10.0, 120),
    "parametric": (0.03, 0.4, 12.0, 0.1, 0.02, 0.5, 20.0, 240),
    "before the edge": (0.2219, 0.2127, 15.7218, 0.2831, 0.0363, 1.03, 20.0, 240),
    "on the edge": (0.2219, 0.2127, 15.7608, 0.2831, 0.0363, 1.03, 20.0, 240),
    "beyond the edge": (0.2219, 0.2127, 15.8202, 0.2831, 0.0363, 1.03, 20.0, 240),
    "chaotic": (0.1487, 0.5697, 9.5972, 0.4662, 0.0919, 0.922, 20.0, 60),
}
SENSITIVE = {"beyond the edge", "chaotic"}


@pytest.mark.system("compares whole runs with references")
@pytest.mark.parametrize("name", CASES)
def test_an_independent_integration_lies_in_the_range(name: str) -> None:
    *numbers, count = CASES[name]
    result = vfife.simulate(hung(*numbers), step=2.0 * math.pi / numbers[2] / count, outputs=min(count, 240))
    said = trust(result.record, result.measures)
    assert said is not None and said.sensitive == (name in SENSITIVE)
    one, motion = result.measures["rod.angular_acceleration.max"], result.motion
    truth = float(largest_accelerations(*numbers)[motion.first - 1 : motion.last].mean())
    assert one.estimated and abs(one - truth) > 1e-6 * truth
    assert said.sensitive or one.low <= truth <= one.high, (one, truth)


def sprung(seed: int) -> Mechanism:
    """A mass between two springs that buckle or not, pulled by a third one from a crank; or a rod on a
    crank; or two rods falling freely.
    """
    draw = random.Random(seed)
    kind, turns = draw.randrange(3), float(draw.choice([10, 20, 40, 60]))
    if kind == 0:
        length, damping = draw.uniform(0.2, 0.6), 10.0 ** draw.uniform(-3.5, -1.5)
        speed = math.sqrt(1.5 * GRAVITY / length) * draw.choice(
            [draw.uniform(0.5, 1.2), draw.uniform(1.7, 2.3), draw.uniform(2.3, 5.0)]
        )
        return hung(
            draw.uniform(0.02, 0.2),
            length,
            speed,
            draw.uniform(0.001, 2.0),
            damping,
            draw.uniform(0.05, 1.5),
            turns,
        )
    if kind == 1:
        m = Mechanism("double pendulum", gravity=(0.0, -GRAVITY))
        m.point("O", 0.0, 0.0)
        swing = draw.choice([draw.uniform(0.1, 0.8), draw.uniform(0.8, 2.0)])
        m.link("a", length=0.3, mass=1.0, angle=-0.5 * math.pi + swing)
        m.link(
            "b",
            length=draw.uniform(0.2, 0.5),
            mass=draw.uniform(0.3, 2.0),
            angle=-0.5 * math.pi + draw.uniform(-swing, swing),
        )
        m.revolute("O", "ground.O", "a.start")
        m.revolute("A", "a.end", "b.start")
        return with_settings(m, duration=draw.choice([1.0, 3.0, 6.0]))
    m, stiffness = Mechanism("mass between springs"), draw.uniform(100.0, 500.0)
    for name, place in {"O": (0.0, -0.6), "P": (-0.2, 0.0), "Q": (0.2, 0.0)}.items():
        m.point(name, *place)
    m.link("crank", length=draw.uniform(0.01, 0.08), mass=0.1, angle=0.0)
    m.revolute("O", "ground.O", "crank.start")
    m.point_mass("mass", mass=1.0, position=(0.0, draw.uniform(-0.1, 0.1)))
    free, damping = (
        0.2 * draw.choice([draw.uniform(0.7, 1.0), draw.uniform(1.02, 1.3)]),
        10.0 ** draw.uniform(-1.2, 0.3),
    )
    for name in "PQ":
        m.spring(
            name, f"ground.{name}", "mass.center", stiffness=stiffness, damping=damping, free_length=free
        )
    m.spring(
        "pull",
        "crank.end",
        "mass.center",
        stiffness=draw.uniform(10.0, 100.0),
        damping=damping,
        free_length=0.6,
    )
    m.drive("crank", speed=math.sqrt(stiffness) * draw.uniform(0.3, 1.6))
    return with_settings(m, turns=turns)


def compared(seed: int) -> tuple[Result, dict[str, float]]:
    """A run with a coarse step, and by how much of its size each measure's range misses the truth, which
    is known to a third of what it changes by from a step twice as large; measures whose truth is known to
    no more than OUTSIDE are left out.
    """
    mechanism = sprung(seed)
    count, turn = (
        random.Random(seed + 1000).choice([120, 240, 480]),
        vfife.simulate(mechanism, companions=0).record.assembly.choice.turn,
    )
    length = (
        {"step": turn / count, "outputs": 120}
        if turn
        else {"step": mechanism.settings.duration / (10 * count), "outputs": 10 * count}
    )
    result = vfife.simulate(mechanism, reference=False, **length, force_step=True)
    fine, finer = (
        values_of(
            vfife.simulate(
                mechanism, reference=False, companions=0, **length | {"step": length["step"] / part}
            ).record,
            result.record,
        )
        for part in (FINER // 2, FINER)
    )  # of the same turns, whatever the finer runs would take
    size, missed = sizes(result.measures, length["step"]), {}
    for name in result.measures.keys() & fine.keys() & finer.keys():
        one = result.measures[name]
        scale = size.get(name, max(abs(one), 1e-6 * max(map(abs, result.measures.values()))))
        if (doubt := abs(finer[name] - fine[name])) < OUTSIDE * scale and one.estimated:
            missed[name] = (
                max(finer[name] - one.high, one.low - finer[name], doubt / 3.0) / scale - doubt / 3.0 / scale
            )
    return result, missed


def judged(seeds: range) -> tuple[int, int, float, int]:
    """Measures of runs that are not called sensitive, those whose truth lies in the range, the worst that
    does not, and those runs.
    """
    every, inside, worst, runs = 0, 0, 0.0, 0
    for seed in seeds:
        result, missed = compared(seed)
        said = trust(result.record, result.measures)
        if said is not None and not said.sensitive:
            every, inside, runs = (
                every + len(missed),
                inside + sum(one <= 0.0 for one in missed.values()),
                runs + 1,
            )
            worst = max([worst, *missed.values()])
    return every, inside, worst, runs


@pytest.mark.system("integrates random mechanisms a second time")
def test_the_truth_lies_in_the_ranges_of_random_smooth_mechanisms() -> None:
    every, inside, worst, runs = judged(QUICK)
    assert runs >= len(QUICK) // 2 and every > 5 * runs
    assert inside >= 0.98 * every and worst <= OUTSIDE


@pytest.mark.verify
def test_the_truth_lies_in_the_ranges_of_many_random_smooth_mechanisms() -> None:
    every, inside, worst, runs = judged(EVERY)
    assert runs >= len(EVERY) // 2
    assert inside >= 0.99 * every and worst <= OUTSIDE
