"""Elementary functions of one number, as :mod:`math` has them, with the same bits on every machine."""

import math
from functools import lru_cache

from ..kernels import elementary
from .routines.functions import arctangent, exponential, half_turn, length, logarithm, raised

# The reduction of kernels.elementary.sincos is exact up to here; beyond, the angle is reduced in whole
# numbers.
LARGE_ANGLE = 1e6
# pi, to 1,270 bits: a double is at most 2^1024, so that 190 bits remain behind the point.
PI_BITS = 1270


def sincos(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle (rad)."""
    if angle == 0.0:
        return float(angle), 1.0
    if abs(angle) < LARGE_ANGLE:
        return _near(float(angle))
    if not math.isfinite(angle):
        return math.nan, math.nan
    return _far(float(angle))


@lru_cache(maxsize=1024)
def _near(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle that is not large. They are cached, because velocities, accelerations and
    ranks are computed at the angles of the closed position.
    """
    result: tuple[float, float] = elementary.sincos(angle)
    return result


def _far(angle: float) -> tuple[float, float]:
    """Sine and cosine of a large angle, whose quarter turns are taken off in whole numbers."""
    numerator, denominator = angle.as_integer_ratio()
    pi = _pi()
    turns, remainder = divmod(numerator << PI_BITS + 1, pi * denominator)
    if 2 * remainder > pi * denominator:
        turns, remainder = turns + 1, remainder - pi * denominator
    # Python rounds the quotient of two integers of any size to the nearest double.
    s, c = elementary.sincos(remainder / (denominator << PI_BITS + 1))
    return ((s, c), (c, -s), (-s, -c), (-c, s))[turns % 4]


@lru_cache(maxsize=1)
def _pi() -> int:
    """pi 2**PI_BITS, rounded, by Machin's formula in whole numbers."""
    unit = 1 << PI_BITS + 32

    def inverse_arctangent(n: int) -> int:
        total = term = unit // n
        k = 1
        while term:
            term //= -n * n
            k += 2
            total += term // k
        return total

    return (16 * inverse_arctangent(5) - 4 * inverse_arctangent(239)) >> 32


def sin(angle: float) -> float:
    """Sine of an angle (rad)."""
    return sincos(angle)[0]


def cos(angle: float) -> float:
    """Cosine of an angle (rad)."""
    return sincos(angle)[1]


def tan(angle: float) -> float:
    """Tangent of an angle (rad)."""
    s, c = sincos(angle)
    return s / c


def atan(x: float) -> float:
    """Angle (rad) of a tangent, from -pi/2 to pi/2."""
    return float(arctangent(float(x)))


def atan2(y: float, x: float) -> float:
    """Angle (rad) of the direction (x, y), from -pi to pi, as :func:`math.atan2` of finite numbers."""
    y, x = float(y), float(x)
    if math.isnan(x) or math.isnan(y):
        return math.nan
    if y == 0.0:
        return y if math.copysign(1.0, x) > 0.0 else math.copysign(math.pi, y)
    if math.isinf(x) or math.isinf(y):
        x, y = (math.copysign(1.0 if math.isinf(coordinate) else 0.0, coordinate) for coordinate in (x, y))
        return atan2(y, x)
    return math.copysign(float(half_turn(abs(y), x)), y)


def asin(x: float) -> float:
    """Angle (rad) of a sine; ValueError beyond 1."""
    return atan2(x, math.sqrt((1.0 - x) * (1.0 + x)))


def acos(x: float) -> float:
    """Angle (rad) of a cosine; ValueError beyond 1."""
    return atan2(math.sqrt((1.0 - x) * (1.0 + x)), x)


def exp(x: float) -> float:
    """e**x; OverflowError beyond the largest double."""
    if math.isnan(x):
        return math.nan
    result = float(exponential(float(x)))
    if math.isinf(result) and not math.isinf(x):
        raise OverflowError("math range error")
    return result


def expm1(x: float) -> float:
    """e**x - 1, exact for small x too (Kahan)."""
    u = exp(x)
    if u == 1.0:
        return x
    return u - 1.0 if abs(x) > 1.0 else (u - 1.0) * (x / log(u))


def log(x: float) -> float:
    """Natural logarithm; ValueError where there is none."""
    if not x > 0.0:
        if math.isnan(x):
            return math.nan
        raise ValueError("math domain error")
    return math.inf if math.isinf(x) else float(logarithm(float(x)))


def log1p(x: float) -> float:
    """ln(1 + x), exact for small x too (Kahan)."""
    u = 1.0 + x
    return x if u == 1.0 else log(u) * (x / (u - 1.0))


def log10(x: float) -> float:
    """Logarithm to base 10; whole numbers for whole powers of ten up to 1e22."""
    first = log(x)
    result = first * 0.4342944819032518
    integer = round(result)
    return float(integer) if 0 <= integer <= 22 and x == integer_power(10.0, integer) else result


def integer_power(x: float, exponent: int) -> float:
    """x**exponent for a whole exponent, by squaring."""
    result, square, left = 1.0, x, abs(exponent)
    while left:
        if left & 1:
            result = result * square
        left >>= 1
        if left:
            square = square * square
    return 1.0 / result if exponent < 0 else result


def power(x: float, exponent: float) -> float:
    """x**exponent: squarings for small whole exponents, a root for 1/2, else by logarithms; ValueError for a
    root of a negative number.
    """
    x, exponent = float(x), float(exponent)
    if exponent == math.floor(exponent) and abs(exponent) <= 16.0:
        return integer_power(x, int(exponent))
    if math.isnan(x) or math.isnan(exponent):
        return math.nan
    if x > 0.0 and math.isfinite(x) and math.isfinite(exponent):
        result = math.sqrt(x) if exponent == 0.5 else float(raised(x, exponent))
        if math.isinf(result):
            raise OverflowError("math range error")
        return result
    if x == 0.0 or math.isinf(x) or math.isinf(exponent):
        return float(math.pow(x, exponent))  # a limit, exact: zero, one or infinity
    if exponent != math.floor(exponent):
        raise ValueError("math domain error")
    return power(-x, exponent) * (1.0 if math.fmod(exponent, 2.0) == 0.0 else -1.0)


def hypot(*sides: float) -> float:
    """Length of a vector."""
    if len(sides) == 2:
        return float(length(float(sides[0]), float(sides[1])))
    largest = max((abs(float(side)) for side in sides), default=0.0)
    up, down = 1.0, 1.0
    if largest > 1e150 or 0.0 < largest < 1e-145:  # powers of two, so that no square overflows or vanishes
        up, down = (2.0**-512, 2.0**512) if largest > 1.0 else (2.0**512, 2.0**-512)
    total = 0.0
    for side in sides:
        total += (side * up) * (side * up)
    return math.sqrt(total) * down


def distance(first: tuple[float, ...], second: tuple[float, ...]) -> float:
    """Distance between two points of a plane."""
    return hypot(*(a - b for a, b in zip(first, second, strict=True)))
