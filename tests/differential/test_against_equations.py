"""Mechanisms that nobody drew against the constrained equations of motion, integrated by another method in a
text that shares nothing.

A step of second order errs by a quarter when it is halved, so a run at half the step is a third of the
difference of the two away from the truth, and what both extrapolate to is much nearer. An error of the
physics stays where it is.
"""

from __future__ import annotations

import math
import os
import random

import numpy as np
import pytest

from differential.compared import Compared, compared
from differential.pencil import FAMILIES
from support import go, largest_force, particle, times, within
from vfife.model.mechanism import Mechanism
from vfife.solvers.record import Record

STEPS = 60
EACH = {**dict.fromkeys(FAMILIES, 19), "linked": 5, "between": 12}  # a hundred and more
MANY = int(os.environ.get("VFIFE_MECHANISMS", "2000"))  # in a long run
FLOOR = {
    "position": 1e-9,
    "velocity": 1e-8,
    "acceleration": 3e-8,
    "force": 3e-8,
    "moment": 3e-8,
}  # of the largest value, and at least of 1
NEAR = 0.3  # of what halving the step changes: how far the extrapolation may be from the truth
# the same where a contact begins or a force or a motion has a kink: where in its step that is differs from
# step to step
AT_EVENTS = 5.0
CHANGE = 0.1  # of the largest value: what halving the step may change


def apart(found: Compared) -> dict[str, tuple[float, float, float]]:
    """Of each quantity: its size, what halving the step changes, and the distance of the extrapolation from
    the truth.
    """
    told = {}
    for name, exact in found.truth.items():
        coarse, fine = found.coarse[name], found.fine[name]
        size = max(1.0, float(np.abs(exact).max()))
        told[name] = (
            size,
            float(np.abs(coarse - fine).max()),
            float(np.abs((4.0 * fine - coarse) / 3.0 - exact).max()),
        )
    return told


def check(found: Compared) -> None:
    for name, (size, change, distance) in apart(found).items():
        what = (
            f"{found.drawn.label}, {name}: size {size:.3g}, half the step changes {change:.2e}, extrapolated"
            f" {distance:.2e} from the equations"
        )
        assert change < CHANGE * size, what
        near = AT_EVENTS if found.drawn.system.touches or found.drawn.system.breaks else NEAR
        assert distance < near * change + FLOOR[name.partition(" ")[0]] * size, what


@pytest.mark.parametrize(
    ("family", "seed"), [(family, seed) for family in FAMILIES for seed in range(EACH[family])]
)
def test_against_the_constrained_equations(family: str, seed: int) -> None:
    check(compared(seed, family, STEPS, "auto" if seed % 10 == 9 else "data-driven"))


@pytest.mark.soak
@pytest.mark.parametrize("family", FAMILIES)
def test_thousands(family: str) -> None:
    """Other seeds each time; those that fail are told together, and ``VFIFE_SEED`` draws them again.

    One in some seven hundred is off because the step is not yet fine or the plain equations have passed over
    a contact: it is tried once more with half the step and equations that look sixteen times as often, and
    has to agree then.
    """
    first = int(os.environ.get("VFIFE_SEED") or random.SystemRandom().randrange(10**9))
    print(f"{family}: seeds from {first} on; VFIFE_SEED={first} VFIFE_MECHANISMS={MANY} draws them again")
    wrong = []
    for seed in range(first, first + MANY // len(FAMILIES)):
        try:
            try:
                check(compared(seed, family, STEPS))
            except AssertionError:
                print(f"{family} {seed}: once more")
                check(compared(seed, family, 2 * STEPS, often=16))
        except Exception as error:  # what a seed leads to is told with all others
            wrong.append(f"seed {seed}: {error}")
    assert not wrong, "\n".join([f"{len(wrong)} of {MANY // len(FAMILIES)}", *wrong])


WEIGHT, LENGTHWISE = 9.81, (1.3, 2.0)  # m/s^2; kg of the crank that is not driven and of the coupler


def parallelogram(seed: int, steps: int, gravity: float = WEIGHT) -> tuple[Record, np.ndarray, float]:
    """Two equal cranks, one driven through a position in which all links lie on a line; the record, the
    crank's angle, and its length.
    """
    rng = np.random.default_rng(seed)
    length, base, speed = (float(rng.uniform(*ends)) for ends in ((0.2, 0.5), (0.3, 0.8), (10.0, 40.0)))
    begin = -float(rng.uniform(0.3, 1.0))
    m = Mechanism("parallelogram", gravity=(0.0, -gravity))
    m.point("A", 0.0, 0.0)
    m.point("B", base, 0.0)
    m.link("crank", length=length, mass=1.0, angle=begin)
    m.link("other", length=length, mass=LENGTHWISE[0], angle=begin)
    m.link("coupler", length=base, mass=LENGTHWISE[1], angle=0.0)
    m.revolute("a", "ground.A", "crank.start")
    m.revolute("b", "ground.B", "other.start")
    m.revolute("c", "crank.end", "coupler.start")
    m.revolute("d", "coupler.end", "other.end")
    m.drive("crank", speed=speed)
    duration = (math.pi + 1.5) / speed
    record = go(m, duration / steps, duration=duration, outputs=400, loop="data-driven")
    return record, begin + speed * times(record), length


@pytest.mark.parametrize("seed", range(6))
def test_a_parallelogram_passes_where_it_could_branch(seed: int) -> None:
    """The coupler does not turn."""
    record, angle, length = parallelogram(seed, 2400)
    assert np.abs(particle(record, "other")["theta"] - angle).max() < 1e-4
    coupler = particle(record, "coupler")
    assert np.abs(coupler["theta"]).max() < 1e-4
    assert np.abs(coupler["y"] - coupler["y"][0] - length * (np.sin(angle) - math.sin(angle[0]))).max() < 1e-4


@pytest.mark.parametrize("seed", range(6))
def test_the_forces_of_a_parallelogram_stay_what_they_are(seed: int) -> None:
    """Without weight the coupler's centrifugal force is shared by the cranks, m r w^2/2 at each and through
    each position.
    """
    record, angle, length = parallelogram(seed, 2400, gravity=0.0)
    speed = (angle[-1] - angle[0]) / times(record)[-1]
    assert largest_force(record, "d", within(record, 0.0, math.inf)) == pytest.approx(
        0.5 * LENGTHWISE[1] * length * speed**2, rel=1e-3
    )


@pytest.mark.parametrize("seed", range(6))
def test_the_weight_of_a_parallelogram_is_borne_along_the_coupler(seed: int) -> None:
    """Moments about the pivot of the crank that is not driven: m_c (g - r w^2 sin a)/2 + m g/2 by the tangent
    of its angle, without bound.
    """
    record, angle, length = parallelogram(seed, 2400)
    speed = (angle[-1] - angle[0]) / times(record)[-1]
    across = 0.5 * LENGTHWISE[1] * (WEIGHT - length * speed**2 * np.sin(angle))
    along = (across + 0.5 * LENGTHWISE[0] * WEIGHT) / np.tan(angle)
    told = record.block("joint_fx")[:, record.assembly.ideals.index("d")]
    apart = np.abs(np.sin(angle)) > 0.1
    assert apart.mean() > 0.8
    assert np.abs(np.abs(told) - np.abs(along))[apart].max() < 2e-3 * np.abs(along[apart]).max()
