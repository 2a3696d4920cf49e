"""Sine, cosine, logarithm, exponential and powers against decimal arithmetic with forty digits."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest

from support import EPS
from vfife.kernels import elementary, frame

PI = Decimal(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798"
)


def exact_sincos(angle: float) -> tuple[Decimal, Decimal]:
    """Sine and cosine by Taylor series of an angle reduced by whole turns."""
    with localcontext() as context:
        context.prec = 45
        x = Decimal(angle)
        x -= 2 * PI * (x / (2 * PI)).to_integral_value()
        sine, cosine, term, k = Decimal(0), Decimal(0), Decimal(1), 0
        while abs(term) > Decimal("1e-40"):
            cosine, sine = (cosine + term, sine) if k % 2 == 0 else (cosine, sine + term)
            k += 1
            term *= x / k * (-1 if k % 2 == 0 else 1)
        return sine, cosine


def angles() -> np.ndarray:
    """Angles over the range of a long run and ten times that, and next to multiples of an eighth of a turn,
    where the reduction has to choose.
    """
    rng = np.random.default_rng(7)
    eighths = rng.integers(-120000, 120001, 300) * (math.pi / 4)
    near = np.concatenate(
        [
            eighths,
            np.nextafter(eighths, np.inf),
            np.nextafter(eighths, -np.inf),
            eighths + rng.normal(0, 1e-6, 300),
        ]
    )
    every = np.concatenate(
        [
            rng.uniform(-1e5, 1e5, 600),
            rng.uniform(-1e6, 1e6, 300),
            rng.uniform(-7, 7, 800),
            10.0 ** rng.uniform(-12, 0, 100),
            near,
            [0.0, 1e5, -1e5],
        ]
    )
    return every


def test_sine_and_cosine_are_correct_to_the_last_digit():
    worst = 0.0
    for angle in angles():
        sine, cosine = elementary.sincos(float(angle))
        exact_sine, exact_cosine = exact_sincos(float(angle))
        worst = max(worst, abs(float(Decimal(sine) - exact_sine)), abs(float(Decimal(cosine) - exact_cosine)))
    assert worst < 2.3e-16


def test_sine_is_odd_and_cosine_even_to_the_bit():
    """What makes the motion of a mirrored mechanism the mirrored motion."""
    for angle in angles():
        sine, cosine = elementary.sincos(float(angle))
        assert elementary.sincos(-float(angle)) == (-sine, cosine)


def small_turn(c: float, s: float, angle: float) -> tuple[float, float]:
    """A direction turned by what a body turns in a step, as the closing of joints turns it."""
    sine, versine = elementary.turned(angle)
    return c - (versine * c + sine * s), s + (sine * c - versine * s)


@pytest.mark.parametrize("angle", np.linspace(-0.05, 0.05, 41))
def test_small_turn(angle):
    sine, cosine = exact_sincos(float(angle))
    c, s = small_turn(1.0, 0.0, float(angle))
    assert abs(float(Decimal(s) - sine)) < 2e-17 and abs(float(Decimal(c) - cosine)) < 1.2e-16


@pytest.mark.parametrize(("angle", "most"), [(-0.99, 3e-8), (0.8, 4e-9), (-0.5, 3e-11), (0.1, 1e-15)])
def test_large_turns_of_a_step_lose_some_digits(angle, most):
    """The series ends with the ninth power."""
    sine, versine = elementary.turned(angle)
    assert (sine, versine) == pytest.approx((math.sin(angle), 2.0 * math.sin(0.5 * angle) ** 2), rel=most)


def test_small_turn_adds_to_a_direction():
    c, s = small_turn(math.cos(1.0), math.sin(1.0), 0.04)
    assert (c, s) == pytest.approx((math.cos(1.04), math.sin(1.04)), rel=0, abs=2.5e-16)


def test_turn_of_a_path_unit():
    """Error below 1e-13 up to 0.05 rad; of one step below 1e-15 up to 0.01 rad."""
    ca, sa = math.cos(0.7), math.sin(0.7)
    for angle in np.linspace(-0.05, 0.05, 101):
        c, s = small_turn(ca, sa, float(angle))
        assert abs(frame.turn(c, s, ca, sa) - angle) < 1e-13
        if abs(angle) <= 0.01:
            assert abs(frame.step_turn(c, s, ca, sa) - angle) < 1e-15


def test_power_loses_a_few_bits_at_most():
    rng = np.random.default_rng(3)
    worst = 0.0
    with localcontext() as context:
        context.prec = 40
        for x, n in zip(10.0 ** rng.uniform(-12, -2, 1500), rng.uniform(0, 2, 1500), strict=True):
            exact = Decimal(float(x)) ** Decimal(float(n))
            worst = max(worst, abs(float((Decimal(elementary.power(float(x), float(n))) - exact) / exact)))
    assert worst < 1e-15  # promised: 1e-14


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_power_at_whole_exponents(exponent):
    for x in (1e-12, 3e-9, 7e-6, 0.01, 0.5, 1.0, 2.0, 1000.0):
        assert elementary.power(x, exponent) == pytest.approx(x**exponent, rel=1e-14, abs=0)


def test_power_of_nothing_is_nothing():
    assert elementary.power(0.0, 0.2) == 0.0 and elementary.power(1e-30, 0.2) == 0.0


def test_power_is_continuous_where_its_range_is_reduced():
    """At powers of two and of their root the reduction takes another way; neighbours must stay neighbours."""
    for k in range(-40, 1):
        for edge in (2.0**k, 2.0**k * math.sqrt(0.5)):
            around = [elementary.power(v, 0.2) for v in (np.nextafter(edge, 0), edge, np.nextafter(edge, 2))]
            assert max(around) - min(around) < 8 * EPS * edge**0.2


def test_exp2():
    rng = np.random.default_rng(5)
    with localcontext() as context:
        context.prec = 40
        for whole in range(-127, 128):
            part = float(rng.uniform(-0.51, 0.51))
            exact = Decimal(2) ** (Decimal(whole) + Decimal(part))
            assert abs(float(Decimal(elementary.exp2(float(whole), part)) / exact - 1)) < 4e-16


def test_two_to_is_exact():
    assert [elementary.two_to(float(k)) for k in range(-127, 128)] == [2.0**k for k in range(-127, 128)]


def test_reduction_is_exact_and_its_range_kept():
    for k in range(-95, 32):
        for edge in (2.0**k, 2.0**k * math.sqrt(0.5)):
            for x in (np.nextafter(edge, 0), edge, np.nextafter(edge, np.inf)):
                if x >= 2.0**-95:
                    m, e = elementary.reduced(float(x))
                    assert (
                        m * 2.0**e == x
                        and e == int(e)
                        and math.sqrt(0.5) * (1 - EPS) <= m <= math.sqrt(2.0) * (1 + EPS)
                    )


def test_logarithm_is_right_to_the_last_digit():
    """Over its range, and about 1, where the relative error is the hard one."""
    rng = np.random.default_rng(11)
    numbers = np.concatenate(
        [
            10.0 ** rng.uniform(-28, 9, 1200),
            rng.uniform(0.5, 2.0, 800),
            1.0 + 10.0 ** rng.uniform(-15, -1, 300),
        ]
    )
    worst = 0.0
    with localcontext() as context:
        context.prec = 40
        for x in numbers:
            exact = Decimal(float(x)).ln()
            worst = max(worst, abs(float((Decimal(elementary.log(float(x))) - exact) / exact)))
    assert worst < 2.3e-16
    assert elementary.log(1.0) == 0.0 and elementary.log(0.0) == elementary.log(2.0**-95)


def test_exponential():
    rng = np.random.default_rng(13)
    worst = 0.0
    with localcontext() as context:
        context.prec = 40
        for x in np.concatenate([rng.uniform(-87.9, 87.9, 1500), rng.uniform(-1, 1, 500)]):
            worst = max(worst, abs(float(Decimal(elementary.exp(float(x))) / Decimal(float(x)).exp() - 1)))
    assert worst < 4e-16
    assert elementary.exp(0.0) == 1.0
