"""Elementary functions against decimal arithmetic with forty digits and exact identities, over the whole
range of a double.
"""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest

from vfife.numerics import elementwise, scalar

RNG = np.random.default_rng(25)


def ulps(found: float, exact: Decimal) -> float:
    """Error in units of the last place."""
    with localcontext() as context:
        context.prec = 60
        return abs(float((Decimal(found) - exact) / Decimal(math.ulp(float(exact)))))


def positive(count: int, low: float, high: float) -> list[float]:
    return [
        float(one) * 2.0 ** float(shift)
        for one, shift in zip(RNG.uniform(1.0, 2.0, count), RNG.integers(low, high, count), strict=True)
    ]


def test_exponentials_over_their_whole_range() -> None:
    near = [
        *RNG.uniform(-1.0, 1.0, 300).tolist(),
        *RNG.uniform(-700.0, 700.0, 300).tolist(),
        709.78,
        -708.3,
        1e-300,
        -1e-17,
        0.0,
        0.34657,
    ]
    with localcontext() as context:
        context.prec = 45
        assert max(ulps(scalar.exp(x), Decimal(x).exp()) for x in near) < 0.9
        assert (
            max(ulps(scalar.exp(x), Decimal(x).exp()) for x in (-709.0, -720.3, -744.9)) < 1.0
        )  # below the smallest normal number
    assert (
        scalar.exp(-800.0) == 0.0
        and scalar.exp(-math.inf) == 0.0
        and scalar.exp(math.inf) == math.inf
        and math.isnan(scalar.exp(math.nan))
    )
    with pytest.raises(OverflowError):
        scalar.exp(710.0)


def test_logarithms_over_their_whole_range() -> None:
    values = [
        *positive(400, -1070, 1023),
        *positive(300, -3, 3),
        *(1.0 + RNG.uniform(-1e-3, 1e-3, 200)).tolist(),
        5e-324,
        1.7e308,
    ]
    with localcontext() as context:
        context.prec = 45
        assert max(ulps(scalar.log(x), Decimal(x).ln()) for x in values if x != 1.0) < 0.8
        assert max(ulps(scalar.log10(x), Decimal(x).log10()) for x in positive(300, -300, 300)) < 2.5
    assert scalar.log(1.0) == 0.0 and scalar.log(math.inf) == math.inf
    assert [scalar.log10(10.0**k) for k in range(23)] == list(range(23))
    for x in (0.0, -1.0):
        with pytest.raises(ValueError, match="domain"):
            scalar.log(x)


def test_small_arguments_keep_their_digits() -> None:
    with localcontext() as context:
        context.prec = 60
        for x in [*RNG.uniform(-0.9, 3.0, 200).tolist(), 1e-12, -1e-9, 1e-30, 3e-5]:
            assert ulps(scalar.log1p(x), (1 + Decimal(x)).ln()) < 3.0
            assert ulps(scalar.expm1(x), Decimal(x).exp() - 1) < 3.0


def test_powers() -> None:
    with localcontext() as context:
        context.prec = 60
        for x, y in zip(positive(400, -40, 40), RNG.uniform(-3.0, 3.0, 400).tolist(), strict=True):
            assert ulps(scalar.power(x, y), (Decimal(y) * Decimal(x).ln()).exp()) < 1.5
        for x, y in ((2.0, 1000.5), (1e-300, 0.99), (1.0000001, 5e9), (3.0, -600.25)):
            assert ulps(scalar.power(x, y), (Decimal(y) * Decimal(x).ln()).exp()) < 8.0
        assert ulps(scalar.power(1.5, 7), Decimal("1.5") ** 7) < 4.0
    assert (
        scalar.power(-2.0, 3) == -8.0
        and scalar.power(-2.0, 17.0) == -131072.0
        and scalar.power(0.0, 2.5) == 0.0
        and scalar.power(3.0, 0) == 1.0
    )
    assert (
        scalar.power(0.1, 2) == 0.1 * 0.1
        and scalar.power(0.1, 0.5) == math.sqrt(0.1)
        and scalar.power(4.0, -2) == 1.0 / 16.0
    )
    with pytest.raises(ValueError, match="domain"):
        scalar.power(-1.0, 0.3)
    with pytest.raises(OverflowError):
        scalar.power(10.0, 400.5)


def test_angles_of_directions() -> None:
    """tan of the answer, by sine and cosine of forty digits, is the quotient: the error is below 1 ulp."""
    from kernels.test_elementary import exact_sincos

    for x, y in RNG.normal(size=(400, 2)).tolist():
        angle = scalar.atan2(y, x)
        sine, cosine = exact_sincos(angle)
        with localcontext() as context:
            context.prec = 45
            off = (Decimal(y) * cosine - Decimal(x) * sine) / (Decimal(x) ** 2 + Decimal(y) ** 2).sqrt()
        assert abs(float(off)) < 1.5 * math.ulp(angle) and abs(angle - math.atan2(y, x)) <= 2.0 * math.ulp(
            angle
        )
    for y in (0.0, -0.0, 1.0, -2.0, 1e-320, math.inf, -math.inf):
        for x in (0.0, -0.0, 3.0, -1.0, 1e300, -1e-320, math.inf, -math.inf):
            assert np.array(scalar.atan2(y, x)).tobytes() == np.array(math.atan2(y, x)).tobytes(), (y, x)
    for x in RNG.uniform(-1.0, 1.0, 200).tolist():
        assert abs(scalar.asin(x) - math.asin(x)) <= 2.0 * math.ulp(math.asin(x)) and abs(
            scalar.acos(x) - math.acos(x)
        ) <= 2.0 * math.ulp(1.6)
    assert scalar.asin(1.0) == math.pi / 2 and scalar.acos(-1.0) == math.pi and scalar.acos(1.0) == 0.0


def test_large_angles() -> None:
    """sin and cos of the C library are correct to the last digit there, and sin(10^22) is a
    published number.
    """
    for angle in [*RNG.uniform(-1e9, 1e9, 300).tolist(), *positive(200, 20, 1023), 1e22, 2.0**1000]:
        s, c = scalar.sincos(angle)
        assert abs(s - math.sin(angle)) <= 2.0 * math.ulp(s) and abs(c - math.cos(angle)) <= 2.0 * math.ulp(c)
        assert scalar.sincos(-angle) == (-s, c)
    assert scalar.sin(1e22) == -0.8522008497671888
    assert math.isnan(scalar.sin(math.inf))


def test_lengths_of_vectors() -> None:
    for x, y in RNG.normal(size=(300, 2)).tolist():
        assert abs(scalar.hypot(x, y) - math.hypot(x, y)) <= math.ulp(math.hypot(x, y))
    for scale in (2.0**700, 2.0**-700):
        assert (
            scalar.hypot(3.0 * scale, -4.0 * scale) == 5.0 * scale
            and scalar.hypot(2.0 * scale, 3.0 * scale, 6.0 * scale) == 7.0 * scale
        )
    assert scalar.hypot(2.0) == 2.0 and scalar.hypot() == 0.0
    assert (
        scalar.hypot(2.0, 3.0, 6.0) == pytest.approx(7.0, abs=2e-15)
        and scalar.distance((1.0, 2.0), (4.0, 6.0)) == 5.0
    )


@pytest.mark.parametrize("name", ["sin", "cos", "tan", "exp", "log", "log10", "hypot", "atan2", "power"])
def test_arrays_have_the_bits_of_single_numbers(name: str) -> None:
    rng = np.random.default_rng(31)  # of its own: the shared one depends on the tests that ran before
    values = np.concatenate(
        [rng.uniform(0.0, 30.0, 60), [1e-9, 3.0, 2e6, 1e-310, 1e200][: 3 if name == "exp" else 5]]
    )
    values = np.minimum(values, 700.0) if name == "exp" else values
    others = rng.uniform(-2.0, 2.0, len(values))
    others[:3] = 0.5, 2.0, 0.0
    others[-2:] = np.abs(others[-2:])  # of the smallest number, so that no power of it overflows
    arguments = (values, others) if name in ("hypot", "atan2", "power") else (values,)
    if name == "power":
        arguments = values[:-1], others[:-1]
    found = getattr(elementwise, name)(*arguments)
    single = [getattr(scalar, name)(*one) for one in zip(*(one.tolist() for one in arguments), strict=True)]
    if name == "log10":
        assert np.abs(found - single).max() <= 2e-13
    else:
        assert found.tolist() == single
    assert getattr(elementwise, name)(*(one.reshape(-1, 1) for one in arguments)).shape == (
        len(arguments[0]),
        1,
    )


def test_interpolation_is_that_of_numpy() -> None:
    places, values = np.array([0.0, 1.0, 1.5, 4.0]), np.array([2.0, -1.0, -1.0, 7.0])
    x = np.concatenate([RNG.uniform(-1.0, 5.0, 100), places])
    assert np.allclose(
        elementwise.interpolate(x, places, values), np.interp(x, places, values), rtol=0.0, atol=1e-14
    )
    assert elementwise.interpolate(places, places, values).tolist() == values.tolist()
    assert (
        elementwise.interpolate(9.0, places, values) == 7.0
        and elementwise.interpolate(0.3, [2.0], [5.0]) == 5.0
    )
