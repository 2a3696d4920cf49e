"""The texts of a loop with straight-line code: the driver of :mod:`vfife.kernels.advance`, and the two
modules of a step.

The driver is translated to LLVM's language, Python and JavaScript. A step is two modules, which call each
other and are called by the driver: the parts that every step needs, and those that few steps need. If the
latter are long, or no event can occur, they are compiled without optimisation, in a quarter of the time. A
short full step is optimised like the rest: with one loose joint, impacts, of eight steps each, are a sixth of
the run.
"""

from __future__ import annotations

from typing import NamedTuple

from ...kernels import advance as kernel
from ...kernels.arrays import Layout
from ...kernels.polynomial import polynomial
from ...kernels.topology import Topology
from ..trace.source import Gathered
from ..trace.straight_line import Steps, steps_of, trace
from ..trace.tangent import of_size, shared_tangent, tangent, tangent_with_jumps
from ..trace.traceable import WRITING
from .kinds import ENTRIES, Array, External
from .llvm import ANSWER, aligned, fast_steps, full_step, operators, resize, time_functions
from .plain import library_text

ARRAY, INTEGERS = Array("d", 1), Array("u", 1)
# The functions of straight-line code that replace those of the data-driven loop. Of an array, the address is
# passed, and its length for the tables only; the numbers are indices of the parts that are passed.
STEPS = {
    "fast_steps": External((ARRAY, ARRAY, ARRAY, INTEGERS, "i", "i", "b"), (0, 2, 4, 5, 8, 9), "i"),
    "full_step": External((ARRAY, ARRAY, INTEGERS, "i"), (0, 2, 3, 6)),
    "functions": External((ARRAY, ARRAY, INTEGERS, "i"), (0, 0, 2, 3, 6)),
    "resize": External((ARRAY, INTEGERS, ARRAY), (0, 4)),
}
# ``fast_steps`` for one lane, for languages without vectors: ``fast_step`` takes a step, or returns false and
# changes nothing if the full step is needed.
ONE_LANE = """
def fast_steps(S, R, T, I, n, count, watching):
    for k in range(count):
        functions(S, T, I, n + k)
        if not fast_step(S, n + k):
            return k
    return count
"""
WIDEST = 8
# Keeps loops that copy from becoming calls of the C library.
NO_BUILTINS = '"no-builtins"'
SHORT = 4000  # largest number of lines of a full step that is optimised
# Functions of other modules. A step's own ones are called by the driver.
POLYNOMIAL = f"declare {ANSWER} @polynomial(ptr, i64, i64, double)"
FUNCTIONS = "declare void @functions(ptr, ptr, ptr, i64, i64)"


def driver_source(*names: str) -> str:
    """Return the Python text of functions of the driver and of all that they call, except the steps."""
    with WRITING:
        texts = Gathered()
        texts.written = dict.fromkeys(STEPS, "")
        for name in names:
            texts.add(getattr(kernel, name))
        texts.add(polynomial)
        return texts.text()


def driver_text(*names: str) -> str:
    """Return functions of the driver in LLVM's language, and ``polynomial``, which functions of time call."""
    entries = {name: (name, ENTRIES[name].kinds) for name in names}
    entries["polynomial"] = "polynomial", (ARRAY, "i", "d")
    return library_text(driver_source(*names), entries, STEPS, NO_BUILTINS)


def processor_driver() -> str:
    """Return the driver for processors, with a stack aligned so that no spilled vector straddles two lines of
    the cache.
    """
    return driver_text(*ENTRIES) + aligned(WIDEST)


class Pieces(NamedTuple):
    """The two modules of a step: the parts that every step needs, ``frequent``, and those that few need,
    ``rare``; ``hurried``: the latter are compiled without optimisation.
    """

    frequent: str
    rare: str
    hurried: bool


def pieces(topology: Topology, width: int, directions: int = 0, jumps: bool = False) -> Pieces:
    """Return the modules of a step for ``width`` lanes; with ``directions``, for a state followed by its
    derivatives, which contain the ``jumps`` of forces or not.
    """
    steps = derived(topology, directions, jumps)
    frequent, rare = frequent_texts(topology, steps, width, directions), rare_texts(steps, width)
    return Pieces(_module(width, frequent), _module(width, [FUNCTIONS, *rare]), not is_short(steps))


def module(topology: Topology, width: int, directions: int = 0) -> str:
    """Return all of a step as one module, for readers."""
    steps = derived(topology, directions)
    return _module(width, [*frequent_texts(topology, steps, width, directions), *rare_texts(steps, width)])


def frequent_texts(topology: Topology, steps: Steps, width: int, directions: int = 0) -> list[str]:
    """Return the texts that every step needs: functions of time, if there are any, and the fast step."""
    layout = Layout(topology)
    rows = {row + k * layout.rows for f in steps.functions for row in f.rows for k in range(directions + 1)}
    return [
        time_functions(steps.functions, width, layout, steps.fast.stores, directions),
        fast_steps(steps.fast, width, rows, arranged=directions > 0),
    ]


def rare_texts(steps: Steps, width: int) -> list[str]:
    """Return the texts that few steps need: the full step and the change of the step size."""
    return [full_step(steps.full, width, bool(steps.functions), is_short(steps)), resize(steps.resize, width)]


def derived(topology: Topology, directions: int, jumps: bool = False) -> Steps:
    """Return the steps of a topology with their derivatives in ``directions`` directions, which contain the
    ``jumps`` of forces or not.

    Only the fast step is worth the search for shared operations: it is nearly all of the work.
    """
    steps, layout = steps_of(topology), Layout(topology)
    if not directions:
        return steps
    size, fast = of_size(layout.row("step")), steps.fast
    if jumps:
        fast = trace(topology, jumps=True)
        velocities = [row for axis in "uvw" for row in layout.rows_of(f"particle_{axis}")]
        full = tangent_with_jumps(trace(topology, full=True, jumps=True), layout.rows, directions, velocities)
    else:
        full = tangent(steps.full, layout.rows, directions)
    return steps._replace(
        fast=shared_tangent(fast, layout.rows, directions),
        full=full,
        resize=tangent(steps.resize, layout.rows, directions, size),
    )


def is_short(steps: Steps) -> bool:
    """Return whether full steps occur and are short enough to be optimised."""
    return bool(steps.fast.rare) and len(steps.full.operations) < SHORT


def _module(width: int, texts: list[str]) -> str:
    """Return a module of functions, all of which other modules can call."""
    public = (text.replace("define internal ", "define ", 1) for text in texts)
    return "\n".join([operators(width), POLYNOMIAL, *public, aligned(width)])
