"""The classical line contacts, implicit in the force: against their printed relations, solved by SciPy."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from support import CONTACT_LAWS
from vfife.kernels.elementary import log, logarithmic
from vfife.laws import Johnson, Material, Pair
from vfife.laws.contact.forms import LineContact

BRONZE = Material("bronze", 110e9, 0.34, 8800.0)
PAIRS = [
    Pair(0.01, 5e-4, 0.02),
    Pair(0.01, 5e-5, 0.02),
    Pair(0.025, 2e-4, 0.005, bearing=BRONZE),
    Pair(0.002, 1e-3, 0.05, journal=BRONZE),
]
LINES = [law for law in CONTACT_LAWS if issubclass(law, LineContact)]
each_line = pytest.mark.parametrize("law", LINES, ids=lambda law: law.name)
each_pair = pytest.mark.parametrize("pair", PAIRS, ids=lambda pair: f"{pair.clearance:g}")


def printed(name: str, force: float, pair: Pair) -> float:
    """Penetration (m) under a force (N), each relation as method sheets print it."""
    sigma = [(1 - m.poissons_ratio**2) / m.youngs_modulus for m in (pair.bearing, pair.journal)]
    s, modulus = sum(sigma) / math.pi, 1 / sum(sigma)
    ri, rj, length = pair.bearing_radius, pair.bearing_radius - pair.clearance, pair.axial_length
    f, gap = force / length, pair.clearance
    r = ri * rj / (ri - rj)
    if name == "johnson":
        return f / (math.pi * modulus) * (math.log(4 * math.pi * modulus * gap / f) - 1)
    if name == "radzimovsky":
        b = 1.60 * math.sqrt(f * r / modulus)
        return f / (math.pi * modulus) * (2 / 3 + math.log(4 * ri / b) + math.log(4 * rj / b))
    if name == "goldsmith":
        return f * s * (math.log(length / (force * r * s)) + 1)
    if name == "dubowsky-freudenstein":
        return f * s * (math.log(length**3 * gap / (force * ri * rj * s)) + 1)
    if name == "esdu-78035":
        return f * s * (math.log(4 * length * gap / (force * s)) + 1)
    raise KeyError(name)


def test_they_are_found():
    assert {"johnson", "radzimovsky", "goldsmith", "dubowsky-freudenstein", "esdu-78035"} <= {
        law.name for law in LINES
    }


@each_line
@each_pair
def test_force_is_the_root_of_the_printed_relation(law, pair):
    """To 1e-10 from a nanometre to where the tangent takes over, at 0.9953 of the largest penetration."""
    p = law().parameters(pair)
    fold = p[2] / (1.1 * math.exp(-0.1))
    worst = 0.0
    for depth in np.geomspace(1e-9, 0.995 * fold, 200):
        force = law.force(float(depth), 0.0, p)[0]
        top = 0.9999 * fold / p[0]  # more than any force before the fold
        root = brentq(
            lambda f, d=depth: printed(law.name, f, pair) - d,
            1e-6 * force,
            min(top, 1.5 * force),
            xtol=1e-300,
            rtol=1e-13,
        )
        worst = max(worst, abs(force / root - 1))
    assert worst < 1e-10


@each_line
@each_pair
def test_goes_on_smoothly_beyond_its_largest_penetration(law, pair):
    """Continuous with its slope, along a straight line, finite and rising at a hundred times that depth."""
    p = law().parameters(pair)
    last = p[2]

    def force(depth: float) -> float:
        return law.force(depth, 0.0, p)[0]

    h = 1e-6 * last
    before, after = (force(last) - force(last - h)) / h, (force(last + h) - force(last)) / h
    assert after == pytest.approx(before, rel=1e-4)
    assert force(last * (1 + 1e-12)) == pytest.approx(force(last), rel=1e-10)
    assert (force(3 * last) - force(2 * last)) / last == pytest.approx(after, rel=1e-6)
    assert math.isfinite(force(100 * last)) and force(100 * last) > force(10 * last)


def test_johnson_has_no_force_beyond_0_5413_clearances():
    pair = PAIRS[0]
    p = Johnson().parameters(pair)
    assert p[2] / (1.1 * math.exp(-0.1)) == pytest.approx(0.5413 * pair.clearance, rel=1e-4)


def test_two_cylinders_side_by_side():
    """Johnson's relation with the sum of the radii: f/(pi E*) [ln(4 R_1/a) + ln(4 R_2/a) - 1] x 1 with a^2 =
    4 f R/(pi E*), his Eq. 5.57.
    """
    pair = Pair(0.03, 0.0, 0.02, opposite_radius=0.01)
    modulus, r = pair.composite_modulus, 0.03 * 0.01 / 0.04
    for depth in (1e-6, 1e-5):
        f = Johnson.force(depth, 0.0, Johnson().parameters(pair))[0] / 0.02
        a = math.sqrt(4 * f * r / (math.pi * modulus))
        assert f / (math.pi * modulus) * (
            math.log(4 * 0.03 / a) + math.log(4 * 0.01 / a) - 1
        ) == pytest.approx(depth, rel=1e-10)


def test_lower_branch_of_lamberts_function():
    """w - ln w = level, put back: from near the fold to penetrations of 1e-26 of it."""
    for beyond in np.geomspace(0.09, 62, 2000):
        level = 1.0 + (beyond - math.log1p(beyond))
        above, below = logarithmic(level)
        assert above / below == pytest.approx(1.0 + beyond, rel=1e-13)


def test_force_at_nothing_is_nothing_and_log_is_finite_there():
    assert math.isfinite(log(0.0))
    for law in LINES:
        assert law.force(0.0, 1.0, law().parameters(PAIRS[0])) == (0.0, 0.0)
        assert 0.0 < law.force(1e-30, 1.0, law().parameters(PAIRS[0]))[0] < 1e-12
