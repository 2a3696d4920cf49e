"""The loop driver of :mod:`vfife.kernels.advance` beside straight-line code, and the modules of a step.

The driver is written in LLVM's language, in Python and in JavaScript. A step is two modules that call one
another and the driver: what every step needs, and what few do. The last is compiled with the least effort,
which takes a quarter of the time, where it is long or no event is to come. A short whole step is made as fast
as the rest: impacts, of eight parts each, are a sixth of a run with one loose joint.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from ...kernels import advance as kernel
from ...kernels.arrays import Layout
from ...kernels.polynomial import polynomial
from ...kernels.topology import Topology
from ..backends.blocks import Array, External, Kind
from ..backends.llvm import ANSWER, aligned, lean, operators, resize, searched, whole
from ..backends.plain import library_text
from ..trace.functiontext import WRITING
from ..trace.source import Gathered
from ..trace.straight_line import Function, functions, resizing, trace
from ..trace.tangent import of_size, shared_tangent, tangent
from ..trace.tape import Trace
from .loops import ENTRIES
from .native import kinds_of

ARRAY, INTEGERS = Array("d", 1), Array("u", 1)
# What straight-line code has in the place of the data-driven loop's functions: of arrays their addresses are
# passed, and the numbers of all tables.
STEPS = {
    "fast_steps": External((ARRAY, ARRAY, ARRAY, INTEGERS, "i", "i", "b"), (0, 2, 4, 5, 8, 9), "i"),
    "full_step": External((ARRAY, ARRAY, INTEGERS, "i"), (0, 2, 3, 6)),
    "functions": External((ARRAY, ARRAY, INTEGERS, "i"), (0, 0, 2, 3, 6)),
    "resize": External((ARRAY, INTEGERS, ARRAY), (0, 4)),
}
# The same of one lane in the languages that have no vectors: ``fast_step`` takes a step, or returns that the
# full one is needed and changes nothing.
ONE_LANE = """
def fast_steps(S, R, T, I, n, count, watching):
    for k in range(count):
        functions(S, T, I, n + k)
        if not fast_step(S, n + k):
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
    entries: dict[str, tuple[str, list[Kind]]] = {name: (name, kinds_of(ENTRIES[name])) for name in names}
    entries["polynomial"] = "polynomial", [ARRAY, "i", "d"]
    return library_text(gathered(*names), entries, STEPS, OWN)


def text() -> str:
    """The driver for processors; what it calls may put aside the widest vectors, which do not straddle two
    lines of the cache.
    """
    return llvm_text(*ENTRIES) + aligned(WIDEST)


SHORT = 4000  # lines of a whole step that is worth being made fast
# Functions of other modules. A step's own ones are called by the driver.
POLYNOMIAL = f"declare {ANSWER} @polynomial(ptr, i64, i64, double)"
FUNCTIONS = "declare void @functions(ptr, ptr, ptr, i64, i64)"


class Pieces(NamedTuple):
    """Two modules; whether the last is ``hurried``, made with the least effort."""

    often: str
    seldom: str
    hurried: bool


def pieces(topology: Topology, width: int, directions: int = 0) -> Pieces:
    """The modules of :func:`written`."""
    found, step, long, change = parts(topology, directions)
    fast = brief(step, long)
    rare = [FUNCTIONS, whole(long, width, bool(found), fast), resize(change, width)]
    return Pieces(
        _module(width, often(topology, width, directions, found, step)), _module(width, rare), not fast
    )


def _module(width: int, texts: list[str]) -> str:
    """A module of functions, all of which others can call."""
    public = (text.replace("define internal ", "define ", 1) for text in texts)
    return "\n".join([operators(width), POLYNOMIAL, *public, aligned(width)])


@lru_cache(maxsize=2)  # a mechanism and its ideal one, each in several widths or with derivatives beside it
def _traced(topology: Topology) -> tuple[list[Function], Trace, Trace, Trace]:
    """Functions, lean step, whole step, and the change of a step's size."""
    return functions(topology), trace(topology), trace(topology, True), resizing(topology)


def written(topology: Topology, width: int, directions: int = 0) -> str:
    """Text of a step in one module; with ``directions``, of a state that has its derivatives behind it."""
    found, step, long, change = parts(topology, directions)
    rare = [whole(long, width, bool(found), brief(step, long)), resize(change, width)]
    return _module(width, [*often(topology, width, directions, found, step), *rare])


def parts(topology: Topology, directions: int) -> tuple[list[Function], Trace, Trace, Trace]:
    """Functions, lean step, whole step and the change of a step's size, with derivatives in so many
    directions.
    """
    layout, (found, step, long, change) = Layout(topology), _traced(topology)
    if not directions:
        return found, step, long, change
    steps = shared_tangent(step, layout.rows, directions), tangent(long, layout.rows, directions)
    return found, *steps, tangent(change, layout.rows, directions, of_size(layout.row("step")))


def brief(step: Trace, long: Trace) -> bool:
    """Whether a whole step is taken now and then, and is short enough to be made fast."""
    return bool(step.rare) and len(long.operations) < SHORT


def often(topology: Topology, width: int, directions: int, found: list[Function], step: Trace) -> list[str]:
    """What every step needs: functions, where there are any, and the lean step."""
    layout = Layout(topology)
    changing = {row + k * layout.rows for f in found for row in f.rows for k in range(directions + 1)}
    return [
        searched(found, width, layout, step.stores, directions),
        lean(step, width, changing, arranged=directions > 0),
    ]
