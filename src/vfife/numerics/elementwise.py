"""Elementary functions of a number, or of each number of an array, with the same bits whatever stands beside
a number.

Where a function has no value, one number raises the error of :mod:`math`; in an array stands an infinity or
NaN.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import scalar
from .dense import flat
from .routine import call

Array = NDArray[np.float64]
MOST_SINGLE = 8  # numbers, up to which single ones are faster than a call of compiled code


def _parts(values: tuple[Any, ...]) -> tuple[list[Array], tuple[int, ...]]:
    """Return the values as flat arrays of one length, and their common shape."""
    if len(values) == 1 or all(
        isinstance(value, np.ndarray) and value.shape == np.shape(values[0]) for value in values
    ):
        return [flat(value) for value in values], np.shape(values[0])
    arrays = [np.asarray(value, dtype=np.float64) for value in values]
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    return [np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1) for array in arrays], shape


def _plain(values: tuple[Any, ...]) -> bool:
    """Whether all are single numbers."""
    return not any(isinstance(value, np.ndarray | list | tuple) and np.ndim(value) for value in values)


def _each(
    function: Callable[..., float], name: str, values: tuple[Any, ...], easy: Callable[..., NDArray[np.bool_]]
) -> Any:
    """Apply a function to numbers, or to arrays: by the compiled routine ``name`` where ``easy`` is true of
    the arguments, and by ``function``, number by number, elsewhere.

    The routines have no branches for infinities, NaN, and arguments out of range; such entries are rare.
    """
    if _plain(values):
        return function(*(float(value) for value in values))
    parts, shape = _parts(values)
    sound = easy(*parts)
    result = np.empty(parts[0].shape)
    if sound.all():
        call(name, *parts, result)
    else:
        safe = [np.where(sound, part, 1.0) for part in parts]
        call(name, *safe, result)
        for k in np.flatnonzero(~sound).tolist():
            result[k] = _quiet(function, [float(part[k]) for part in parts])
    return result.reshape(shape)


def _quiet(function: Callable[..., float], values: list[float]) -> float:
    """Return a function's value as an entry of an array: infinite or NaN where the function raises."""
    try:
        return function(*values)
    except (OverflowError, ZeroDivisionError):
        return np.inf
    except ValueError:
        return -np.inf if function is scalar.log and values[0] == 0.0 else np.nan


def sincos(angle: Any) -> tuple[Any, Any]:
    """Sine and cosine of angles (rad)."""
    if isinstance(angle, float) or _plain((angle,)):
        return scalar.sincos(float(angle))
    (angles,), shape = _parts((angle,))
    if angles.size <= MOST_SINGLE:
        pairs = [scalar.sincos(number) for number in angles.tolist()]
        sines, cosines = np.array(pairs, dtype=np.float64).reshape(-1, 2).T.copy()
        return sines.reshape(shape), cosines.reshape(shape)
    sine, cosine = np.empty(angles.shape), np.empty(angles.shape)
    sound = np.abs(angles) < scalar.LARGE_ANGLE
    if sound.all():
        call("turn_all", angles, sine, cosine)
    else:
        call("turn_all", np.where(sound, angles, 0.0), sine, cosine)
        for k in np.flatnonzero(~sound).tolist():
            sine[k], cosine[k] = scalar.sincos(float(angles[k]))
    return sine.reshape(shape), cosine.reshape(shape)


def sin(angle: Any) -> Any:
    """Sine of angles (rad)."""
    return sincos(angle)[0]


def cos(angle: Any) -> Any:
    """Cosine of angles (rad)."""
    return sincos(angle)[1]


def tan(angle: Any) -> Any:
    """Tangent of angles (rad)."""
    s, c = sincos(angle)
    return s / c


def exp(x: Any) -> Any:
    """e**x."""
    return _each(scalar.exp, "exponentials", (x,), np.isfinite)


def log(x: Any) -> Any:
    """Natural logarithm."""
    return _each(scalar.log, "logarithms", (x,), lambda x: (x > 0.0) & (x < np.inf))


def log10(x: Any) -> Any:
    """Logarithm to base 10."""
    return scalar.log10(float(x)) if _plain((x,)) else log(x) * 0.4342944819032518


def power(x: Any, exponent: Any) -> Any:
    """Return x**exponent as :func:`~vfife.numerics.scalar.power` does, for numbers and arrays."""

    def easy(x: Array, exponent: Array) -> NDArray[np.bool_]:
        return np.asarray(
            (x > 0.0)
            & (x < np.inf)
            & ~((exponent == np.floor(exponent)) & (np.abs(exponent) <= 16.0))
            & (exponent != 0.5)
        )

    if not _plain((x,)) and _plain((exponent,)):
        integer = float(exponent)
        if integer == int(integer) and abs(integer) <= 16.0:
            return integer_power(np.asanyarray(x, dtype=np.float64), int(integer))
        if integer == 0.5:
            return np.sqrt(x)
    return _each(scalar.power, "raise_all", (x, exponent), easy)


def integer_power(x: Any, exponent: int) -> Any:
    """x**exponent for a small whole exponent, by squaring."""
    return scalar.integer_power(x, exponent)


def atan2(y: Any, x: Any) -> Any:
    """Angles (rad) of directions (x, y), from -pi to pi."""
    return _each(
        scalar.atan2, "directions_of", (y, x), lambda y, x: np.isfinite(y) & np.isfinite(x) & (y != 0.0)
    )


def hypot(*sides: Any) -> Any:
    """Return the length of vectors, each coordinate an argument of its own.

    Squares are summed plainly; only where they overflow or vanish the scaled form takes over.
    """
    if all(isinstance(side, float) for side in sides) or _plain(sides):
        return scalar.hypot(*sides)
    parts, shape = _parts(sides)
    if parts[0].size <= MOST_SINGLE:
        vectors = zip(*(part.tolist() for part in parts), strict=True)
        return np.array([scalar.hypot(*vector) for vector in vectors], dtype=np.float64).reshape(shape)
    with np.errstate(over="ignore", under="ignore"):
        squares = parts[0] * parts[0]
        for side in parts[1:]:
            squares = squares + side * side
    result = np.sqrt(squares)
    unusual = ~((squares > 1e-290) & (squares < 1e300))
    if unusual.any():
        # A vector of zeros needs no scaling, and joints without contact have many of them.
        unusual &= sum(np.abs(side) for side in parts) != 0.0
    for k in np.flatnonzero(unusual).tolist() if unusual.any() else ():
        result[k] = scalar.hypot(*(float(side[k]) for side in parts))
    return result.reshape(shape)


def interpolate(x: Any, places: Any, values: Any) -> Any:
    """Return values at ``x`` between those given at rising ``places``, along straight lines; beyond the ends
    the values of the ends, as np.interp does.
    """
    at, xs, ys = (
        np.asarray(x, dtype=np.float64),
        np.asarray(places, dtype=np.float64),
        np.asarray(values, dtype=np.float64),
    )
    if len(xs) == 1:
        return np.full(at.shape, ys[0]) if at.ndim else float(ys[0])
    left = np.clip(np.searchsorted(xs, at, side="right") - 1, 0, len(xs) - 2)
    run = np.clip(at, xs[0], xs[-1]) - xs[left]
    with np.errstate(all="ignore"):
        result = (ys[left + 1] - ys[left]) / (xs[left + 1] - xs[left]) * run + ys[left]
    result = np.where(
        at >= xs[-1], ys[-1], np.where(at <= xs[0], ys[0], np.where(run == 0.0, ys[left], result))
    )
    return result if at.ndim else float(result)


def sqrt(x: Any) -> Any:
    """Square root of a number, or of each of an array."""
    return np.sqrt(x) if isinstance(x, np.ndarray) else math.sqrt(x)
