"""Elementary functions from + - * / sqrt alone, over the whole range of a double.

Polynomials are those of FreeBSD's msun, where not said otherwise.

Behind them, the same of arrays, number by number.
"""

import math

from ...kernels.elementary import log_of, nearest, sincos, small_exp, two_to


def exponential(x):
    """Return e**x for every double x that is not NaN: 2**k e**y with y = x - k ln 2, where ln 2 is subtracted
    in two parts.

    Beyond the two limits the result is infinite or zero.
    """
    if x > 709.782712893384:
        return 1e308 * 1e308
    if x < -745.1332191019412:
        return 0.0
    k = nearest(x * 1.4426950408889634)
    high = x - k * 6.93147180369123816490e-01
    low = k * 1.90821492927058770002e-10
    y = high - low
    result = small_exp(y) - y_error(high, y, low)
    # 2**k in steps of 2**120: two_to has no more range, and results below the smallest normal number are
    # rounded only where they get there.
    while k > 120.0:
        result = result * 1.329227995784916e36
        k = k - 120.0
    while k < -120.0:
        result = result * 7.52316384526264e-37
        k = k + 120.0
    return result * two_to(k)


def y_error(high, y, low):
    """Return the rounding error y - (high - low) of an exponent y = high - low; as e**y is near 1, the error
    of e**y is the same.
    """
    return (y - high) + low


def parts(x):
    """Return m in [sqrt(1/2), sqrt(2)) and an integer-valued e with x = m 2**e, for every positive finite x.

    Products with powers of two alone: a kernel has no way to read the bits of a number.
    """
    e = 0.0
    m = x
    while m >= 4294967296.0:
        m = m * 2.3283064365386963e-10
        e = e + 32.0
    while m < 2.3283064365386963e-10:
        m = m * 4294967296.0
        e = e - 32.0
    while m >= 16.0:
        m = m * 0.0625
        e = e + 4.0
    while m < 0.0625:
        m = m * 16.0
        e = e - 4.0
    while m >= 1.4142135623730951:
        m = m * 0.5
        e = e + 1.0
    while m < 0.7071067811865476:
        m = m * 2.0
        e = e - 1.0
    return m, e


def logarithm(x):
    """Return the natural logarithm of a positive finite number."""
    m, e = parts(x)
    return log_of(m, e)


def product_error(a, b, ab):
    """Return a b - ab exactly, where ab is the rounded product, for numbers below 1e290 (Dekker 1971).

    Each factor is split by 2**27 + 1 into two halves whose products are exact. A fused multiplication would
    do the same in one operation, but not every machine that runs the kernels has one.
    """
    c = 134217729.0 * a
    a_high = c - (c - a)
    a_low = a - a_high
    c = 134217729.0 * b
    b_high = c - (c - b)
    b_low = b - b_high
    return ((a_high * b_high - ab) + a_high * b_low + a_low * b_high) + a_low * b_low


def logarithm_in_two(x):
    """ln x as a sum of two numbers, for a positive finite number; relative error about 2**-60.

    2 artanh s with s = (m - 1)/(m + 1) in two parts, and ln 2 in two: the first one, of 32 bits, times the
    exponent is exact.
    """
    m, e = parts(x)
    f = m - 1.0
    g = m + 1.0
    g_rest = (m - g) + 1.0
    s = f / g
    sg = s * g
    s_rest = (((f - sg) - product_error(s, g, sg)) - s * g_rest) / g
    z = s * s
    w = z * z
    low = (0.6666666666666666 + z * 0.4) + w * (0.2857142857142857 + z * 0.2222222222222222)
    high = (0.18181818181818182 + z * 0.15384615384615385) + w * (
        0.13333333333333333 + z * 0.11764705882352941
    )
    last = (0.10526315789473684 + z * 0.09523809523809523) + w * 0.08695652173913043
    third = s * z * (low + w * w * (high + w * w * last))
    top = 2.0 * s
    exact = e * 6.93147180369123816490e-01
    total = exact + top
    back = total - exact
    remainder = (exact - (total - back)) + (top - back)
    remainder = remainder + (third + (2.0 * s_rest + e * 1.90821492927058770002e-10))
    first = total + remainder
    return first, (total - first) + remainder


def raised(x, exponent):
    """Return x**exponent for a positive finite x and any finite exponent.

    The logarithm and its product with the exponent are held in two numbers each. The relative error of the
    power is the absolute error of that product, which reaches 700 before the power overflows.
    """
    first, remainder = logarithm_in_two(x)
    if abs(exponent) > 1e200:
        return exponential(exponent * first if exponent * first < 1e4 else 1e4)
    p = exponent * first
    if p > 1e4:
        return 1e308 * 1e308
    if p < -1e4:
        return 0.0
    low = product_error(exponent, first, p) + exponent * remainder
    power = exponential(p)
    return power if power > 1e308 or power == 0.0 else power + power * low


def arctangent(x):
    """Return atan x (rad) by the polynomials of s_atan.c.

    A larger argument is brought below 7/16 by the formula for a difference of angles, with atan(1/2), pi/4,
    atan(3/2) or pi/2 as the other angle; each of these is a sum of two numbers.
    """
    a = abs(x)
    if a < 0.4375:
        high, low, t = 0.0, 0.0, a
    elif a < 0.6875:
        high, low, t = 4.63647609000806093515e-01, 2.26987774529616870924e-17, (2.0 * a - 1.0) / (2.0 + a)
    elif a < 1.1875:
        high, low, t = 7.85398163397448278999e-01, 3.06161699786838301793e-17, (a - 1.0) / (a + 1.0)
    elif a < 2.4375:
        high, low, t = 9.82793723247329054082e-01, 1.39033110312309984516e-17, (a - 1.5) / (1.0 + 1.5 * a)
    else:
        high, low, t = 1.57079632679489655800e00, 6.12323399573676603587e-17, -1.0 / a
    z = t * t
    w = z * z
    odd_terms = 1.42857142725034663711e-01 + w * (
        9.09088713343650656196e-02
        + w * (6.66107313738753120669e-02 + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02))
    )
    odd_terms = z * (3.33333333333329318027e-01 + w * odd_terms)
    even_terms = -7.69187620504482999495e-02 + w * (
        -5.83357013379057348645e-02 + w * -3.65315727442169155270e-02
    )
    even_terms = w * (-1.99999999998764832476e-01 + w * (-1.11111104054623557880e-01 + w * even_terms))
    result = (
        t - t * (odd_terms + even_terms) if a < 0.4375 else high - ((t * (odd_terms + even_terms) - low) - t)
    )
    return -result if x < 0.0 else (x if x == 0.0 else result)


def half_turn(y, x):
    """Return the angle (rad) from 0 to pi of the direction (x, y), for y > 0."""
    b = abs(x)
    if y > 1e17 * b:
        return 1.5707963267948966
    angle = arctangent(y / b)
    return 3.141592653589793 - (angle - 1.2246467991473532e-16) if x < 0.0 else angle


def length(x, y):
    """Return sqrt(x^2 + y^2), scaled by a power of two where a square would overflow or vanish."""
    a = max(abs(x), abs(y))
    if a > 1e150:
        p = x * 7.458340731200207e-155
        q = y * 7.458340731200207e-155
        return math.sqrt(p * p + q * q) * 1.3407807929942597e154
    if a < 1e-145:
        p = x * 1.3407807929942597e154
        q = y * 1.3407807929942597e154
        return math.sqrt(p * p + q * q) * 7.458340731200207e-155
    return math.sqrt(x * x + y * y)


def turn_all(angle, sine, cosine):
    """Write the sines and cosines of angles below 1e6 rad."""
    for k in range(len(angle)):
        sine[k], cosine[k] = sincos(angle[k])


def raise_all(x, exponent, result):
    """Write x[k]**exponent[k] for positive numbers x."""
    for k in range(len(x)):
        result[k] = raised(x[k], exponent[k])


def exponentials(x, result):
    """Write e**x[k]."""
    for k in range(len(x)):
        result[k] = exponential(x[k])


def logarithms(x, result):
    """Write the natural logarithms of positive numbers."""
    for k in range(len(x)):
        result[k] = logarithm(x[k])


def directions_of(y, x, result):
    """Write the angles (rad) of directions (x, y), for y other than zero."""
    for k in range(len(x)):
        angle = half_turn(abs(y[k]), x[k])
        result[k] = -angle if y[k] < 0.0 else angle
