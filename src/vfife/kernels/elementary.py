"""Sine, cosine, logarithm, exponential and powers from + - * / and comparisons only: the same bits on every
machine, in every lane, compiled or not.

The functions of a C library differ between machines in the last bit, and are calls of one number at a time in
a vector loop. Tables and bit operations of a usual implementation are avoided: lanes would have to load from
different places, and JavaScript has no 64-bit integers. Constants are written with 17 or more digits, so that
every language reads the same number.
"""

import math


def nearest(x):
    """Return the nearest integer, the even one of two, for |x| < 2**51.

    Adding 1.5 * 2**52 leaves no bits for a fraction; subtracting it again leaves the rounded number, without
    a conversion to an integer type.
    """
    return (x + 6755399441055744.0) - 6755399441055744.0


def sincos(angle):
    """Return sine and cosine of an angle (rad), with an error of about 1 ulp for |angle| < 1e6.

    The angle is reduced by quarter turns with a three-part pi/2 (Cody and Waite). The polynomials are those
    of FreeBSD's msun (k_sin.c, k_cos.c), summed in pairs (Estrin 1960), since a step waits for them.
    """
    # 0.6366... is 2/pi. The first two parts of pi/2 have 32 bits at most, so that their products with k are
    # exact for |k| < 2**20.
    k = nearest(angle * 0.6366197723675814)
    r = (
        (angle - k * 1.57079632673412561417) - k * 6.07710050630396597660e-11
    ) - k * 2.02226624879595063154e-21
    z = r * r
    z2 = z * z
    z4 = z2 * z2
    p = -1.66666666666666324348e-01 + z * 8.33333333332248946124e-03
    q = -1.98412698298579493134e-04 + z * 2.75573137070700676789e-06
    s = r + (r * z) * ((p + z2 * q) + z4 * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))
    p = 4.16666666666666019037e-02 + z * -1.38888888888741095749e-03
    q = 2.48015872894767294178e-05 + z * -2.75573143513906633035e-07
    c = (1.0 - 0.5 * z) + z2 * (
        (p + z2 * q) + z4 * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    )
    # Quarter turns modulo 4, from -2 to 2: an odd number exchanges sine and cosine, the sign follows from m.
    m = k - 4.0 * nearest(k * 0.25)
    odd = abs(m) == 1.0
    sign = 1.0 - abs(m)
    sine = m * c if odd else sign * s
    cosine = -(m * s) if odd else sign * c
    return sine, cosine


def turned(angle):
    """Return sine and versine (1 - cosine) of a small angle (rad), with a relative error below 1e-16 for
    |angle| < 0.1 and below 3e-8 for |angle| < 1.

    Joints close by differences of turned arms; 1 - cos from :func:`sincos` would lose half the digits.
    """
    z = angle * angle
    z2 = z * z
    series = (1.0 / 6.0 - z * (1.0 / 120.0)) + z2 * (1.0 / 5040.0 - z * (1.0 / 362880.0))
    versine = z * (
        (0.5 - z * (1.0 / 24.0)) + z2 * ((1.0 / 720.0 - z * (1.0 / 40320.0)) + z2 * (1.0 / 3628800.0))
    )
    return angle - (angle * z) * series, versine


def two_to(integer):
    """Return 2**integer for an integer-valued float with |integer| < 128."""
    # integer + 128 has eight binary digits: the four highest choose among powers of 2**64 and 2**16 below,
    # two digits by three selects each, the others among 2**4 and 2. All products are exact.
    a = integer + 128.0
    r, k = (5.421010862427522e-20, 64.0) if a >= 64.0 else (2.938735877055719e-39, 0.0)
    r, k = (1.0, 128.0) if a >= 128.0 else (r, k)
    r, k = (18446744073709551616.0, 192.0) if a >= 192.0 else (r, k)
    a = a - k
    s, k = (65536.0, 16.0) if a >= 16.0 else (1.0, 0.0)
    s, k = (4294967296.0, 32.0) if a >= 32.0 else (s, k)
    s, k = (281474976710656.0, 48.0) if a >= 48.0 else (s, k)
    a = a - k
    t, k = (16.0, 4.0) if a >= 4.0 else (1.0, 0.0)
    t, k = (256.0, 8.0) if a >= 8.0 else (t, k)
    t, k = (4096.0, 12.0) if a >= 12.0 else (t, k)
    a = a - k
    u = 2.0 if a >= 1.0 else 1.0
    u = 4.0 if a >= 2.0 else u
    u = 8.0 if a >= 3.0 else u
    return r * s * (t * u)


def small_exp(y):
    """Return e**y for |y| <= 0.36: the Taylor series up to y**13, summed in pairs, because Horner's scheme
    would wait for thirteen products, one after the other.
    """
    z = y * y
    q = z * z
    low = (0.5 + y * 1.6666666666666666e-01) + z * (4.1666666666666664e-02 + y * 8.333333333333333e-03)
    middle = (1.3888888888888889e-03 + y * 1.984126984126984e-04) + z * (
        2.48015873015873e-05 + y * 2.7557319223985893e-06
    )
    high = (2.755731922398589e-07 + y * 2.505210838544172e-08) + z * (
        2.08767569878681e-09 + y * 1.6059043836821613e-10
    )
    return 1.0 + (y + z * (low + q * (middle + q * high)))


def exp2(integer, part):
    """Return 2**(integer + part) for an integer-valued |integer| < 128 and |part| <= 0.51."""
    return two_to(integer) * small_exp(part * 0.6931471805599453)


def exp(x):
    """Return e**x for |x| < 88, with a relative error below 1e-15.

    The multiple of ln 2 is subtracted in two parts (msun, e_exp.c), of which the first times an integer is
    exact.
    """
    integer = nearest(x * 1.4426950408889634)
    return two_to(integer) * small_exp(
        (x - integer * 6.93147180369123816490e-01) - integer * 1.90821492927058770002e-10
    )


def reduced(x):
    """Return m in [sqrt(1/2), sqrt(2)) and an integer-valued e with x = m 2**e, for 2**-95 <= x < 2**32;
    smaller x count as 2**-95.

    The result is exact: x is multiplied by powers of two, two binary digits of e at a time.
    """
    # 2.52e-29 is 2**-95. Logarithms use m around 1, where their series converges fastest.
    m = 2.524354896707238e-29 if x < 2.524354896707238e-29 else x
    f, e = (1.0, 0.0) if x < 1.0 else (2.3283064365386963e-10, 32.0)
    f, e = (4294967296.0, -32.0) if x < 2.3283064365386963e-10 else (f, e)
    f, e = (18446744073709551616.0, -64.0) if x < 5.421010862427522e-20 else (f, e)
    m = m * f
    f, k = (256.0, 8.0) if m < 0.00390625 else (1.0, 0.0)
    f, k = (65536.0, 16.0) if m < 1.52587890625e-05 else (f, k)
    f, k = (16777216.0, 24.0) if m < 5.960464477539063e-08 else (f, k)
    m = m * f
    e = e - k
    f, k = (4.0, 2.0) if m < 0.25 else (1.0, 0.0)
    f, k = (16.0, 4.0) if m < 0.0625 else (f, k)
    f, k = (64.0, 6.0) if m < 0.015625 else (f, k)
    m = m * f
    e = e - k
    f, k = (2.0, 1.0) if m < 0.7071067811865476 else (1.0, 0.0)
    f, k = (4.0, 2.0) if m < 0.3535533905932738 else (f, k)
    return m * f, e - k


def log(x):
    """Return the natural logarithm for 2**-95 <= x < 2**32, that of 2**-95 below; error below 1 ulp.

    With x = m 2**e, f = m - 1 and s = f/(m + 1), log m = f - f^2/2 + s (f^2/2 + R(s^2)); R is the polynomial
    of FreeBSD's msun (e_log.c).
    """
    m, e = reduced(x)
    return log_of(m, e)


def log_of(m, e):
    """Return the natural logarithm of m 2**e for m in [sqrt(1/2), sqrt(2)) and integer-valued e."""
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    odd_terms = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01))
    even_terms = z * (
        6.666666666666735130e-01
        + w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01))
    )
    half = 0.5 * f * f
    return e * 6.93147180369123816490e-01 - (
        (half - (s * (half + (odd_terms + even_terms)) + e * 1.90821492927058770002e-10)) - f
    )


def logarithmic(level):
    """w >= 1 of w - ln w = level, which is -W(-exp(-level)) on the lower branch of Lambert's function, as
    numerator and denominator.

    A law that divides by w divides once. For 1.003 < level < 60; relative error below 1e-13. ln w is a
    quotient of two polynomials of the root t of 2 (level - 1), about which w = 1 + t + t^2/3 + ...: fitted to
    the exact function in the largest relative error, and summed in pairs, which waits less.
    """
    y = 2.0 * (level - 1.0)
    t = math.sqrt(y)
    q = y * y
    numerator = t * (
        (0.9999999999933714 + 0.7527993300181866 * t)
        + y * (0.2471674906572691 + 0.041001996094361455 * t)
        + q * ((0.0032967857332578242 + 0.00010057199699388455 * t) + y * 6.738543262373831e-07)
    )
    denominator = (
        (1.0 + 0.9194659965492309 * t)
        + y * (0.37263404665249034 + 0.08127064821988474 * t)
        + q
        * (
            (0.009664905143209593 + 0.0005623556008692475 * t)
            + y * (1.217158267344985e-05 + 5.296604246656522e-08 * t)
        )
    )
    return level * denominator + numerator, denominator


def power(x, exponent):
    """Return x**exponent for 0 <= x < 2**32 and |exponent log2 x| < 120, with a relative error below 1e-14;
    0 for x below 2**-95.

    x is reduced to m in [sqrt(1/2), sqrt(2)) by exact powers of two; log m = 2 artanh((m - 1)/(m + 1)). The
    exponent is split so that its product with the integer part of the logarithm is exact.
    """
    tiny = x < 2.524354896707238e-29
    m, e = reduced(x)
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    y = z * z
    q = y * y
    series = (1.0 / 3.0 + z * 0.2) + y * (1.0 / 7.0 + z * (1.0 / 9.0))
    tail = (
        (1.0 / 11.0 + z * (1.0 / 13.0))
        + y * (1.0 / 15.0 + z * (1.0 / 17.0))
        + q * (1.0 / 19.0 + z * (1.0 / 21.0))
    )
    log2m = 2.8853900817779268 * (s + s * z * (series + q * tail))
    # Adding and subtracting 1.5 * 2**32 rounds the exponent to a multiple of 2**-20; the rest is small.
    coarse = (exponent + 6442450944.0) - 6442450944.0
    remainder = (exponent - coarse) * e + exponent * log2m
    integer = nearest(coarse * e + remainder)
    r = exp2(integer, (coarse * e - integer) + remainder)
    return 0.0 if tiny else r


def approach(x):
    """Return 1 - exp(-x) for x >= 0, with a relative error below 1e-14; 1 beyond 40.

    The Taylor polynomial is evaluated at x up to 0.6. Above, it is evaluated at x/64, and exp(-x/64) is
    squared six times. Sums are formed in pairs, because products that wait for each other take the time.
    """
    small = x < 0.6
    t = x if small else 0.015625 * (x if x < 40.0 else 40.0)
    z = t * t
    y = z * z
    low = (1.0 - 0.5 * t) + z * (0.16666666666666666 - 0.041666666666666664 * t)
    middle = (0.008333333333333333 - 0.001388888888888889 * t) + z * (
        0.0001984126984126984 - 2.48015873015873e-05 * t
    )
    high = (2.7557319223985893e-06 - 2.755731922398589e-07 * t) + z * (
        2.505210838544172e-08 - 2.08767569878681e-09 * t
    )
    last = 1.6059043836821613e-10 - 1.1470745597729725e-11 * t
    q = t * ((low + y * middle) + (y * y) * (high + y * last))
    e = 1.0 - q
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    far = 1.0 - e * e
    far = far if x < 40.0 else 1.0
    return q if small else far
