"""Laws whose damping is not the elastic force times a number: Kelvin and Voigt, Anagnostopoulos, IMPACT. They
never pull.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from support import go, journal_in_bearing, particle
from vfife.laws import Anagnostopoulos, Frictionless, Impact, KelvinVoigt, Pair

PAIR = Pair(0.01, 2e-4, 0.02, effective_mass=2.0)
MASS, SPEED = 2.0, 0.7


def rebound(force, mass: float, speed: float, pulls: bool = False) -> float:
    """Share of the speed that is given back: m d'' = -F(d, d') until F comes down to zero, or where it may
    pull until d does.
    """

    def ended(t, y):
        return y[0] if pulls else force(max(y[0], 1e-300), y[1])

    ended.terminal, ended.direction = True, -1.0
    run = solve_ivp(
        lambda t, y: [y[1], -force(max(y[0], 1e-300), y[1]) / mass], (0, 1), [1e-14, speed],
        method="DOP853", rtol=1e-11, atol=[1e-18, 1e-14], events=ended, max_step=1e-6,
    )  # fmt: skip
    assert run.status == 1
    return -float(run.y[1, -1]) / speed


def rebound_in_a_run(law) -> float:
    """The same in the step: a journal of 2 kg thrown against its bearing. The jump of the force at onset
    makes this first order in the step.
    """
    m = journal_in_bearing(SPEED, mass=MASS, contact=law, friction=Frictionless(), clearance=2e-4)
    record = go(m, 2e-8, duration=2e-3, outputs=100)
    onsets, depth = record.block("contact_onsets")[:, 0], record.block("contact_penetration")[:, 0]
    parted = np.flatnonzero((onsets == 1) & (depth < 0))
    parted = parted[parted > np.argmax(onsets == 1)]
    return float(-particle(record, "journal")["u"][parted[0]] / SPEED)


def closed_form(ratio: float) -> float:
    """Restitution of a linear spring and damper that do not pull, by the ratio of critical damping."""
    root = math.sqrt(1 - ratio**2)
    return math.exp(-ratio / root * (math.pi - math.atan2(2 * ratio * root, 1 - 2 * ratio**2)))


@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.5, 0.7, 0.9, 0.999])
def test_anagnostopoulos_delivers_its_restitution_where_it_may_pull(restitution):
    """As the source has it; cut at zero it gives back what the closed form says."""
    stiffness, damping = Anagnostopoulos(stiffness=2e9, restitution=restitution).parameters(PAIR)
    ratio = damping / (2 * math.sqrt(stiffness * MASS))
    assert ratio == pytest.approx(
        -math.log(restitution) / math.hypot(math.pi, math.log(restitution)), rel=1e-14
    )

    def force(depth, rate):
        return stiffness * depth + damping * rate

    assert rebound(force, MASS, SPEED, pulls=True) == pytest.approx(restitution, abs=1e-7)
    assert rebound(force, MASS, SPEED) == pytest.approx(closed_form(ratio), abs=1e-6)


@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_anagnostopoulos_in_a_run(restitution):
    law = Anagnostopoulos(stiffness=2e9, restitution=restitution)
    stiffness, damping = law.parameters(PAIR)
    assert rebound_in_a_run(law) == pytest.approx(
        closed_form(damping / (2 * math.sqrt(stiffness * MASS))), abs=2e-4
    )


def test_anagnostopoulos_takes_the_mass_of_the_bodies_or_its_own():
    own = Anagnostopoulos(stiffness=2e9, restitution=0.5, effective_mass=8.0).parameters(PAIR)[1]
    assert own == pytest.approx(
        2 * Anagnostopoulos(stiffness=2e9, restitution=0.5).parameters(PAIR)[1], rel=1e-14
    )
    with pytest.raises(ValueError, match="effective mass"):
        Anagnostopoulos(stiffness=2e9).parameters(Pair(0.01, 2e-4, 0.02))


def test_kelvin_voigt_in_a_run():
    law = KelvinVoigt(stiffness=2e9, damping_coefficient=4e4)
    assert law.force(1e-5, 3.0, law.parameters(PAIR)) == (2e4, 4e4)
    assert rebound_in_a_run(law) == pytest.approx(closed_form(4e4 / (2 * math.sqrt(2e9 * MASS))), abs=2e-4)


def adams(depth: float, rate: float, k: float, e: float, c: float, d: float) -> float:
    """max(0, k (x1 - x)^e - STEP(x, x1 - d, c, x1, 0) x') with x1 - x = depth and x' = -rate; STEP as the
    Adams help prints it.
    """
    x, x0, x1 = -depth, -d, 0.0
    share = (x - x0) / (x1 - x0)
    step = c if x <= x0 else 0.0 if x >= x1 else c + (0.0 - c) * share**2 * (3 - 2 * share)
    return max(0.0, k * depth**e - step * -rate)


IMPACTS = [
    Impact(stiffness=2e9, exponent=1.4, damping_coefficient=2e4, full_damping_depth=3e-5),
    Impact(stiffness=1e13, exponent=2.2, damping_coefficient=1e4, full_damping_depth=1e-4),
    Impact(stiffness=5e8, exponent=1.0, damping_coefficient=3e4, full_damping_depth=1e-6),
]


@pytest.mark.parametrize("law", IMPACTS, ids=lambda law: f"{law.exponent:g}")
def test_impact_is_the_function_of_adams(law):
    k, e, c, d = law.stiffness, law.exponent, law.damping_coefficient, law.full_damping_depth
    p = law.parameters(PAIR)
    for depth in np.geomspace(1e-9, 1e-3, 60):
        elastic, damping = law.force(float(depth), 0.0, p)
        for rate in (-0.01, 0.0, 2.0):
            assert max(elastic + damping * rate, 0.0) == pytest.approx(
                adams(depth, rate, k, e, c, d), rel=1e-12, abs=4e-15 * c * abs(rate)
            )


@pytest.mark.parametrize("law", IMPACTS, ids=lambda law: f"{law.exponent:g}")
def test_impact_in_a_run(law):
    given = (law.stiffness, law.exponent, law.damping_coefficient, law.full_damping_depth)
    expected = rebound(lambda depth, rate: adams(depth, rate, *given), MASS, SPEED)
    assert 0.05 < expected < 0.95
    assert rebound_in_a_run(law) == pytest.approx(expected, abs=2e-4)
