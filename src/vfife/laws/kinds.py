"""Kinds of values in the function of a law: what the language of laws (:mod:`~vfife.laws.language`) says of each expression.

Python converts between truth values, whole numbers and numbers wherever it likes; compiled code does not. A value therefore has one kind:

- a *number*, a double;
- a *truth value*, which a comparison gives and a condition takes;
- a *whole number*, whose limits are known when the law is compiled: a literal, a constant of the file, the counter of a loop;
- a tuple of these.
"""

from __future__ import annotations

from typing import NamedTuple

NUMBER = "a number"
TRUTH = "a truth value"
UNKNOWN = "unknown"  # of what has a fault already: nothing more is said of it
LARGEST = 2**53  # up to here every whole number is a double, and comparing, adding and converting commute


class Whole(NamedTuple):
    """A whole number between two others."""

    low: int
    high: int


class Several(NamedTuple):
    """A tuple; ``slots`` marks that of the parameters, whose length the trial with numbers looks at."""

    kinds: tuple[Kind, ...]
    slots: bool = False


Kind = str | Whole | Several


def category(kind: Kind) -> object:
    """What a name may stand for throughout: two kinds of one category differ in the limits of whole numbers alone."""
    if isinstance(kind, Several):
        return tuple(category(one) for one in kind.kinds)
    return "a whole number" if isinstance(kind, Whole) else kind


def size(kind: Kind) -> int:
    """How many numbers it has."""
    return sum(map(size, kind.kinds)) if isinstance(kind, Several) else 1


def known(kind: Kind) -> bool:
    """Whether nothing in a kind is unknown."""
    return all(known(one) for one in kind.kinds) if isinstance(kind, Several) else kind != UNKNOWN


def numeric(kind: Kind) -> bool:
    """Whether arithmetic takes it."""
    return kind in (NUMBER, UNKNOWN) or isinstance(kind, Whole)


def words(kind: Kind) -> str:
    """A kind in words."""
    if isinstance(kind, Several):
        return f"a tuple of {len(kind.kinds)}"
    return "a whole number" if isinstance(kind, Whole) else kind
