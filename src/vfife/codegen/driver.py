"""The loop driver of :mod:`vfife.kernels.advance` beside straight-line code: its text in LLVM's language, in Python and in JavaScript."""

from __future__ import annotations

from ..kernels import advance as kernel
from ..kernels.polynomial import polynomial
from .compile import kind_of, listed
from .llvm import aligned
from .lock import WRITING
from .loops import ENTRIES
from .plain import library_text
from .source import Gathered
from .values import Array, External, Kind

ARRAY, INTEGERS = Array("d", 1), Array("u", 1)
# What straight-line code has in the place of the data-driven loop's functions: of arrays their addresses are passed, and the numbers of all tables.
STEPS = {
    "lean": External((ARRAY, ARRAY, ARRAY, INTEGERS, "i", "i", "b"), (0, 2, 4, 5, 8, 9), "i"),
    "whole": External((ARRAY, ARRAY, INTEGERS, "i"), (0, 2, 3, 6)),
    "functions": External((ARRAY, ARRAY, INTEGERS, "i"), (0, 0, 2, 3, 6)),
    "resize": External((ARRAY, INTEGERS, ARRAY), (0, 4)),
}
# The same of one lane in the languages that have no vectors: ``clean`` takes a step, or tells that the whole one is needed and changes nothing.
ONE_LANE = """
def lean(S, R, T, I, n, count, watching):
    for k in range(count):
        functions(S, T, I, n + k)
        if not clean(S, n + k):
            return k
    return count
"""
WIDEST = 8
# Loops that copy stay loops, where LLVM would call the C library.
OWN = '"no-builtins"'


def gathered(*names: str) -> str:
    """Text of functions of the driver and all that they call, but for the steps."""
    with WRITING:
        texts = Gathered()
        texts.given = dict.fromkeys(STEPS, "")
        for name in names:
            texts.add(getattr(kernel, name))
        texts.add(polynomial)
        return texts.text()


def llvm_text(*names: str) -> str:
    """The driver in LLVM's language: functions of it, and ``polynomial``, which functions of time call."""
    entries: dict[str, tuple[str, list[Kind]]] = {name: (name, [kind_of(one) for one in listed(ENTRIES[name])]) for name in names}
    entries["polynomial"] = "polynomial", [ARRAY, "i", "d"]
    return library_text(gathered(*names), entries, STEPS, OWN)


def text() -> str:
    """The driver for processors; what it calls may put aside the widest vectors, which do not straddle two lines of the cache."""
    return llvm_text(*ENTRIES) + aligned(WIDEST)
