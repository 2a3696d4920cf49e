"""The functions of a step, run on numbers that carry their first two derivatives in time."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from ..kernels import constraint, geometry


class Taylor:
    """value + rate t + second t^2/2, of plain numbers or of arrays of them; comparisons are those of the
    values.
    """

    __array_ufunc__ = None  # so that arrays leave what they do with it to it
    __slots__ = ("rate", "second", "value")

    def __init__(self, value: Any, rate: Any = 0.0, second: Any = 0.0) -> None:
        self.value, self.rate, self.second = value, rate, second

    def __add__(self, other: Any) -> Taylor:
        o = other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(self.value + o.value, self.rate + o.rate, self.second + o.second)

    __radd__ = __add__

    def __neg__(self) -> Taylor:
        return Taylor(-self.value, -self.rate, -self.second)

    def __sub__(self, other: Any) -> Taylor:
        o = other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(self.value - o.value, self.rate - o.rate, self.second - o.second)

    def __rsub__(self, other: Any) -> Taylor:
        return taylor(other) + -self

    def __mul__(self, other: Any) -> Taylor:
        a, b = self, other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(
            a.value * b.value,
            a.rate * b.value + a.value * b.rate,
            a.second * b.value + 2.0 * a.rate * b.rate + a.value * b.second,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Taylor:
        b = taylor(other)
        value = self.value / b.value
        rate = (self.rate - value * b.rate) / b.value
        return Taylor(value, rate, (self.second - 2.0 * rate * b.rate - value * b.second) / b.value)

    def __rtruediv__(self, other: Any) -> Taylor:
        return taylor(other) / self

    def __abs__(self) -> Taylor:
        return self if self.value >= 0.0 else -self

    def part(self, index: Any) -> Taylor:
        """Some entries of arrays."""
        return Taylor(self.value[index], self.rate[index], self.second[index])

    def __lt__(self, other: Any) -> Any:
        return self.value < taylor(other).value

    def __le__(self, other: Any) -> Any:
        return self.value <= taylor(other).value

    def __gt__(self, other: Any) -> Any:
        return self.value > taylor(other).value

    def __ge__(self, other: Any) -> Any:
        return self.value >= taylor(other).value


def taylor(number: Any) -> Taylor:
    """A plain number as one that does not change."""
    return number if isinstance(number, Taylor) else Taylor(number)


def sqrt(number: Any) -> Any:
    """Square root of a plain number, of an array of them, or of one with derivatives."""
    if not isinstance(number, Taylor):
        return np.sqrt(number) if hasattr(number, "shape") else math.sqrt(number)
    value = sqrt(number.value)
    half = 0.5 / value
    rate = half * number.rate
    return Taylor(value, rate, half * (number.second - 2.0 * rate * rate))


def lifted(*modules: ModuleType) -> Any:
    """The functions of kernels with a square root that takes derivatives along; they call one another."""
    space: dict[str, Any] = {}
    for module in modules:
        space |= vars(module)
    functions: dict[str, Callable[..., Any]] = {}
    for name, value in list(space.items()):
        if isinstance(value, FunctionType):
            functions[name] = FunctionType(value.__code__, space, name, value.__defaults__)
    space |= {**functions, "math": SimpleNamespace(sqrt=sqrt)}
    return SimpleNamespace(**functions)


KERNEL = lifted(geometry, constraint)  # arm, lever, guide_row and relative_turn, as the step has them
