"""Numbers of many members side by side: one text of an assembly makes one mechanism, or all that differ from it in numbers.

A number of a noun may be :class:`Members`, an array with a value for each. What is made of it has the members first: a point of all is (members,),
the positions of n bodies (members, n, 3). Operations are those of single numbers, to the bit, whatever stands beside them. A condition has to be
true of all members or of none; where they differ :class:`Differing` tells which is which, and who asked takes them apart. What takes one plain
number, such as a function of :mod:`math`, raises :class:`Alone`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Differing(Exception):
    """A condition that is true of some members only, ``where``."""

    def __init__(self, where: NDArray[np.bool_]) -> None:
        super().__init__("members differ in what is done with them")
        self.where = where


class Alone(Exception):
    """What is made of each member by itself, and why."""


class Members(np.ndarray[Any, Any]):
    """Values of all members, members first."""

    def __bool__(self) -> bool:
        values = np.asarray(self)
        if values.all():
            return True
        if values.any():
            raise Differing(values)
        return False

    def __pow__(self, exponent: Any, modulo: None = None) -> Any:
        """Products for small whole exponents; others raise Alone: what raises a plain number is not the same on every machine."""
        if exponent not in (2, 3, 4):
            raise Alone("a power is taken of each member by itself")
        square = self * self
        return square if exponent == 2 else square * self if exponent == 3 else square * square

    def __float__(self) -> float:
        """Raises Alone: where one plain number is needed, each member is taken by itself."""
        if self.ndim:
            raise Alone("a plain number is needed")
        return float(super().__float__())

    def __int__(self) -> int:
        """As :meth:`__float__`."""
        return int(float(self))

    def __index__(self) -> int:
        """As :meth:`__float__`."""
        if self.ndim:
            raise Alone("a plain number is needed")
        return int(super().__index__())

    def __format__(self, how: str) -> str:
        return "several values"

    def __hash__(self) -> int:  # type: ignore[override]
        return id(self)


def members(values: Any) -> Members:
    """Values as numbers of members."""
    return np.ascontiguousarray(values, dtype=float).view(Members)


def several(*values: Any) -> tuple[int, ...]:
    """The shape in front of what is made of such numbers: (members,) where one of them is of members, else ()."""
    for value in values:
        if isinstance(value, Members):
            return (len(value),)
    return ()


def each(function: Callable[..., float], *values: Any) -> Any:
    """A function of plain numbers, or of each member's."""
    count = several(*values)
    if not count:
        return function(*values)
    return members(each_of(function, *values))


def each_of(function: Callable[..., Any], *values: Any) -> list[Any]:
    """What a function of plain numbers makes of each member's, in a list."""
    count = several(*values)[0]
    lists = [value.tolist() if isinstance(value, Members) else [float(value)] * count for value in values]
    return [function(*one) for one in zip(*lists, strict=True)]


def number(value: Any) -> Any:
    """A plain number as one of Python's; those of members as they are."""
    return value.view(Members) if isinstance(value, np.ndarray) and value.ndim else float(value)


def point(*values: Any) -> Any:
    """Coordinates side by side, the last axis: an array (coordinates,), or (members, coordinates)."""
    count = several(*values)
    if not count:
        return np.array(values, dtype=float)
    return np.stack([np.broadcast_to(value, count) for value in values], axis=-1).view(Members)


def table(rows: Sequence[Sequence[Any]]) -> Any:
    """Rows of numbers: an array (rows, columns), or (members, rows, columns)."""
    if not several(*(value for row in rows for value in row)):
        return np.array(rows, dtype=float)
    columns = [point(*row) for row in rows]
    count = several(*columns)
    return np.stack([np.broadcast_to(one, (*count, len(rows[0]))) for one in columns], axis=-2).view(Members)


def largest(*values: Any) -> Any:
    """The largest of some numbers, member by member."""
    if not several(*values):
        return max(values)
    found = values[0]
    for value in values[1:]:
        found = np.maximum(found, value)
    return found


def alike(values: Any) -> Any:
    """What all members have in common; Differing where they do not."""
    own = np.asarray(values)
    if not own.ndim:
        return values
    if not (own == own[0]).all():
        raise Differing(own == own[0])
    return own[0].item()


def spread(values: Any, count: tuple[int, ...]) -> Any:
    """A copy of numbers as an array of its own; where there are members, one for each."""
    if not count:
        return np.array(values, dtype=float)
    own = np.asarray(values, dtype=float)
    wide = own if isinstance(values, Members) else np.broadcast_to(own, (*count, *own.shape))
    return np.array(wide).view(Members)


def sqrt(value: Any) -> Any:
    """Square root."""
    return np.sqrt(value) if isinstance(value, Members) else math.sqrt(value)


def columns(values: Any) -> list[Any]:
    """The entries of the last axis one by one."""
    return [values[..., k] for k in range(values.shape[-1])] if isinstance(values, Members) else values.tolist()


def select(condition: Any, first: Any, second: Any) -> Any:
    """``first if condition else second``."""
    if isinstance(condition, Members):
        return np.where(np.asarray(condition), first, second).view(Members)
    return first if condition else second


def both(first: Any, second: Any) -> Any:
    """``first and second``."""
    return np.logical_and(first, second) if isinstance(first, Members) or isinstance(second, Members) else first and second


def anyone(condition: Any) -> bool:
    """Whether it is true of any member."""
    return bool(np.asarray(condition).any())


def of_members(function: Any) -> Any:
    """A function of the kernels or laws whose square roots are also those of members."""
    return FunctionType(function.__code__, {**function.__globals__, "math": SimpleNamespace(sqrt=sqrt)}, function.__name__, function.__defaults__)


def plain(value: Any, member: int) -> Any:
    """The number of a member."""
    return value[member].item() if isinstance(value, Members) else value


def chosen(value: Any, which: Any) -> Any:
    """Nouns, tuples or dictionaries with the numbers of a member, or of some: what has none of members is left as it is."""
    if isinstance(value, Members):
        some = value[which]
        return some.item() if np.ndim(some) == 0 else some
    if isinstance(value, tuple | list):
        parts = [chosen(one, which) for one in value]
        return value if all(a is b for a, b in zip(parts, value, strict=True)) else type(value)(parts)
    if isinstance(value, dict):
        found = {name: chosen(one, which) for name, one in value.items()}
        return value if all(found[name] is one for name, one in value.items()) else found
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        own = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.init}
        new = {name: chosen(one, which) for name, one in own.items()}
        return value if all(new[name] is one for name, one in own.items()) else dataclasses.replace(value, **new)
    return value
