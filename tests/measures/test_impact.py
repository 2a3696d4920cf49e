"""A law by itself, against closed forms: the free impact through any contact law, and friction in steady and
in small sliding.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from vfife.laws import Ambrosio, ContactLaw, FrictionLaw, LankaraniNikravesh, Pair, Pereira
from vfife.measures.impact import breakaway, free_impact, presliding, steady_sliding, with_restitution

PAIR = Pair(0.01, 2e-4, 0.02)


pytestmark = pytest.mark.usefixtures("only_built_in_laws")


@pytest.mark.parametrize("law", [LankaraniNikravesh(), Pereira()], ids=lambda law: law.name)
@pytest.mark.parametrize("restitution", [0.05, 0.5, 0.9, 1.0])
def test_delivers_what_the_closed_form_says(law, restitution):
    """chi (1 + e) = ln[(1 + chi)/(1 - chi e)], whatever mass, stiffness and exponent."""
    chi = 0.75 * (1.0 - restitution**2)
    e = (
        1.0
        if chi == 0.0
        else brentq(lambda e: chi * (1 + e) - math.log((1 + chi) / (1 - chi * e)), 1e-9, 1.0, xtol=1e-14)
    )
    found = free_impact(with_restitution(law, restitution), PAIR, 0.7, 0.3)
    assert found.restitution == pytest.approx(e, abs=2e-5)
    lost = np.trapezoid(found.force, found.penetration)  # the area of the loop
    assert lost == pytest.approx(0.5 * 0.7 * 0.3**2 * (1.0 - e**2), rel=1e-4, abs=1e-7)


def test_hertz_reaches_the_depth_and_time_of_its_closed_form():
    """delta = (5 m v^2/(4 K))^(2/5) and T = 2.9432 delta/v (Johnson, Contact Mechanics, 1985, Eq. 11.24)."""
    found = free_impact(LankaraniNikravesh(restitution=1.0, stiffness=1e10), PAIR, 2.0, 0.5)
    deepest = (1.25 * 2.0 * 0.5**2 / 1e10) ** 0.4
    assert found.deepest == pytest.approx(deepest, rel=1e-6)
    pause = 2.0 * quad(lambda x: 2.0 * x / math.sqrt(1.0 - (1.0 - x * x) ** 2.5), 0.0, 1.0)[0]  # 2.9432...
    assert found.duration == pytest.approx(pause * deepest / 0.5, rel=1e-5)
    assert found.largest == pytest.approx(1e10 * deepest**1.5, rel=1e-6)


def test_a_law_of_ones_own_that_sticks_delivers_nothing():
    """So much linear damping that the two never part: restitution 0, told within a bounded
    number of steps.
    """

    @dataclass(frozen=True)
    class Mud(ContactLaw):
        name: ClassVar[str] = "mud"

        def parameters(self, pair):
            return ()

        @staticmethod
        def force(penetration, slowness, p):
            return 1e6 * penetration, (1e5 if penetration > 0.0 else 0.0)

    assert free_impact(Mud(), PAIR, 1.0, 1.0).restitution < 1e-3
    with pytest.raises(ValueError, match="no coefficient of restitution"):
        with_restitution(Mud(), 0.5)


def test_steady_sliding_through_a_law_without_memory():
    law, speeds = (
        Ambrosio(coefficient=0.2, v0=1e-3, v1=1e-2),
        np.array([-1.0, -5.5e-3, 0.0, 5e-4, 5.5e-3, 1.0]),
    )
    assert steady_sliding(law, PAIR, 80.0, speeds) == pytest.approx(
        [16.0, 8.0, 0.0, 0.0, -8.0, -16.0], rel=1e-6
    )
    assert not law.memory


def test_small_sliding_through_dahls_law():
    """F = f N (1 - exp(-s x/(f N))) on the first stroke (Dahl 1968); it breaks away at x = f N/s ln 20 by
    this file's meaning of it.
    """

    @dataclass(frozen=True)
    class Dahl(FrictionLaw):
        name: ClassVar[str] = "dahl-of-this-test"
        memory: ClassVar[tuple[str, ...]] = ("deflection (m)",)

        def parameters(self, pair):
            return 0.1, 1e7

        @staticmethod
        def force(normal_force, free_velocity, mobility, memory, dt, p):
            f, s = p
            reach = f * normal_force / s
            sense = 1.0 if free_velocity > 0.0 else -1.0
            z = sense * reach + (memory - sense * reach) * math.exp(-abs(free_velocity) * dt / reach)
            return -s * z, z

    reach = 0.1 * 100.0 / 1e7
    assert Dahl().memory
    assert breakaway(Dahl(), PAIR, 100.0) == pytest.approx(reach * math.log(20.0), rel=0.05)
    place, force = presliding(Dahl(), PAIR, 100.0, 2.0 * reach)
    assert -force[:401] == pytest.approx(10.0 * (1.0 - np.exp(-place[:401] / reach)), abs=1e-6)
    assert place.min() == pytest.approx(-2.0 * reach) and place[-1] == pytest.approx(2.0 * reach)
    assert np.trapezoid(-force[1201:], place[1201:]) > 0.0, "a stroke loses energy"
    assert steady_sliding(Dahl(), PAIR, 100.0, [-1e-2, 1e-2]) == pytest.approx([10.0, -10.0], rel=1e-6)
