"""The straight-line step of one lane as plain Python: slow, with the same bits, for reading, debugging, and
testing a trace without a compiler.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from ...kernels.arrays import Layout
from ...kernels.topology import Topology
from ..trace.schedule import Line, Load, Store, Test, in_place, ordered, streamed
from ..trace.straight_line import Function, steps_of
from ..trace.tape import Operand, rows_used
from .kinds import ENTRIES
from .modules import ONE_LANE, driver_source

PATTERNS = {
    "sqrt": "sqrt({})", "neg": "-{}", "abs": "abs({})", "and": "{} & {}", "or": "{} | {}",
    "select": "{1} if {0} else {2}", "round": "nearest({})",
}  # fmt: skip


def operand(value: Operand) -> str:
    """Return the text of a name, or of a number that reads back to the same bits."""
    if isinstance(value, float) and not math.isfinite(value):
        return "(1e999 - 1e999)" if value != value else "1e999" if value > 0.0 else "-1e999"
    return value if isinstance(value, str) else repr(value)


def line(item: Line) -> str:
    """Return the text of a line."""
    if isinstance(item, Load):
        return f"v{item.row} = S[{item.row}]"
    if isinstance(item, Store):
        return f"S[{item.row}] = {operand(item.value)}"
    if isinstance(item, Test):
        return f"if {operand(item.condition)}: return False"
    pattern = PATTERNS.get(item.operator, f"{{}} {item.operator} {{}}")
    return (
        f"{item.name} ="
        f" {pattern.format(*(f'({o})' if o[0] == '-' else o for o in map(operand, item.operands)))}"
    )


def time_functions(functions: list[Function], layout: Layout) -> Iterable[str]:
    """Yield the lines that evaluate functions at step n, as the data-driven loop does."""
    yield f"dt, shift = S[{layout.row('step')}], S[{layout.row('shift')}]"
    yield "ahead = 0.0 if n == 0 else dt"
    yield "time, after = (n + shift) * dt, (n + 1 + shift) * dt"
    for f in functions:
        yield from (f"{name} = S[{name[1:]}]" for name in rows_used(f.operations))
        yield from map(line, f.operations)
        value, rate, acceleration, kinks, following = (f"S[{row}]" for row in f.rows)
        yield f"{value}, {rate}, {acceleration}, {kinks} = polynomial(T, {f.table}, {operand(f.argument)})"
        yield f"{following} = polynomial(T, {f.table}, after)[0]" if f.of_time else f"{following} = {value}"


def definition(head: str, lines: Iterable[str]) -> str:
    """Return the text of a function."""
    return "\n    ".join([f"def {head}:", *lines]) + "\n"


def module(topology: Topology) -> str:
    """Return a text that defines ``advance`` and ``stream``; its namespace has to provide ``sqrt``."""
    steps = steps_of(topology)
    fast, full = steps.fast, in_place(steps.full, streamed(steps.full))
    change = map(line, in_place(steps.resize, streamed(steps.resize)))
    parts = [
        driver_source(*ENTRIES),
        ONE_LANE,
        definition("functions(S, T, I, n)", time_functions(steps.functions, Layout(topology))),
        definition("resize(S, I, C)", ["size, shift, repeated = C[0], C[1], C[2]", *change]),
        definition("fast_step(S, n)", [*map(line, in_place(fast, ordered(fast))), "return True"]),
        definition("full_step(S, T, I, n)", ["functions(S, T, I, n)", *map(line, full)]),
    ]
    return "\n\n".join(parts)
