"""The loop driver of :mod:`vfife.kernels.advance` beside straight-line code, and the modules of a step.

The driver is written in LLVM's language, in Python and in JavaScript. A step is two modules that call one
another and the driver: what every step needs, and what few do. The last is compiled with the least effort,
which takes a quarter of the time, where it is long or no event is to come. A short full step is made as fast
as the rest: impacts, of eight parts each, are a sixth of a run with one loose joint.
"""

from __future__ import annotations

from typing import NamedTuple

from ...kernels import advance as kernel
from ...kernels.arrays import Layout
from ...kernels.polynomial import polynomial
from ...kernels.topology import Topology
from ..trace.functiontext import WRITING
from ..trace.source import Gathered
from ..trace.straight_line import Steps, steps_of
from ..trace.tangent import of_size, shared_tangent, tangent
from .kinds import ENTRIES, Array, External, Kind, kinds_of
from .llvm import ANSWER, aligned, fast_steps, full_step, operators, resize, time_functions
from .plain import library_text

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
NO_BUILTINS = '"no-builtins"'
SHORT = 4000  # lines of a full step that is worth being made fast
# Functions of other modules. A step's own ones are called by the driver.
POLYNOMIAL = f"declare {ANSWER} @polynomial(ptr, i64, i64, double)"
FUNCTIONS = "declare void @functions(ptr, ptr, ptr, i64, i64)"


def driver_source(*names: str) -> str:
    """Python text of functions of the driver and all that they call, but for the steps."""
    with WRITING:
        texts = Gathered()
        texts.written = dict.fromkeys(STEPS, "")
        for name in names:
            texts.add(getattr(kernel, name))
        texts.add(polynomial)
        return texts.text()


def driver_text(*names: str) -> str:
    """The driver in LLVM's language: functions of it, and ``polynomial``, which functions of time call."""
    entries: dict[str, tuple[str, list[Kind]]] = {name: (name, kinds_of(ENTRIES[name])) for name in names}
    entries["polynomial"] = "polynomial", [ARRAY, "i", "d"]
    return library_text(driver_source(*names), entries, STEPS, NO_BUILTINS)


def processor_driver() -> str:
    """The driver for processors; steps may put aside vectors, which straddle no two lines of the cache."""
    return driver_text(*ENTRIES) + aligned(WIDEST)


class Pieces(NamedTuple):
    """Two modules: what every step needs, and what few do; whether the last is made with the least effort."""

    frequent: str
    rare: str
    hurried: bool


def pieces(topology: Topology, width: int, directions: int = 0) -> Pieces:
    """The modules of a step; with ``directions``, of a state that has its derivatives behind it."""
    steps = derived(topology, directions)
    frequent, rare = frequent_texts(topology, steps, width, directions), rare_texts(steps, width)
    return Pieces(_module(width, frequent), _module(width, [FUNCTIONS, *rare]), not is_short(steps))


def module(topology: Topology, width: int, directions: int = 0) -> str:
    """All of a step as one module, to read it."""
    steps = derived(topology, directions)
    return _module(width, [*frequent_texts(topology, steps, width, directions), *rare_texts(steps, width)])


def frequent_texts(topology: Topology, steps: Steps, width: int, directions: int = 0) -> list[str]:
    """What every step needs: functions of time, where there are any, and the fast step."""
    layout = Layout(topology)
    rows = {row + k * layout.rows for f in steps.functions for row in f.rows for k in range(directions + 1)}
    return [
        time_functions(steps.functions, width, layout, steps.fast.stores, directions),
        fast_steps(steps.fast, width, rows, arranged=directions > 0),
    ]


def rare_texts(steps: Steps, width: int) -> list[str]:
    """What few steps need: the full step, and the change of a step's size."""
    return [full_step(steps.full, width, bool(steps.functions), is_short(steps)), resize(steps.resize, width)]


def derived(topology: Topology, directions: int) -> Steps:
    """The steps of a topology with their derivatives in so many directions."""
    steps, layout = steps_of(topology), Layout(topology)
    if not directions:
        return steps
    size = of_size(layout.row("step"))
    return steps._replace(
        fast=shared_tangent(steps.fast, layout.rows, directions),
        full=tangent(steps.full, layout.rows, directions),
        resize=tangent(steps.resize, layout.rows, directions, size),
    )


def is_short(steps: Steps) -> bool:
    """Whether a full step is taken now and then, and is short enough to be made fast."""
    return bool(steps.fast.rare) and len(steps.full.operations) < SHORT


def _module(width: int, texts: list[str]) -> str:
    """A module of functions, all of which others can call."""
    public = (text.replace("define internal ", "define ", 1) for text in texts)
    return "\n".join([operators(width), POLYNOMIAL, *public, aligned(width)])
