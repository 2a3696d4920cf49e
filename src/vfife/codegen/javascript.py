"""The straight-line step as JavaScript: a page that is opened from disk, without a server, runs a mechanism with the same bits.

Its numbers are IEEE 754 doubles, its four operations, ``Math.sqrt`` and comparisons are rounded as everywhere, and a trace uses nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from . import driver
from .schedule import Line, Load, Store, Test, ordered, streamed, woven
from .scripts import script
from .straight_line import Function, functions, resizing, trace
from .trace import Operand, rows_used

PATTERNS = {
    "sqrt": "Math.sqrt({})", "neg": "-({})", "abs": "Math.abs({})", "and": "{} && {}", "or": "{} || {}", "select": "{} ? {} : {}",
    "round": "({} + 6755399441055744) - 6755399441055744", "==": "{} === {}", "!=": "{} !== {}",
}  # fmt: skip


def operand(value: Operand) -> str:
    """A name, or a number that reads back to the same bits."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return "(0 / 0)" if value != value else "(1 / 0)" if value > 0.0 else "(-1 / 0)"
    return value if isinstance(value, str) else f"({value!r})"


def line(one: Line) -> str:
    """A line."""
    if isinstance(one, Load):
        return f"const v{one.row} = S[{one.row}];"
    if isinstance(one, Store):
        return f"S[{one.row}] = {operand(one.value)};"
    if isinstance(one, Test):
        return f"if ({operand(one.condition)}) return false;"
    pattern = PATTERNS.get(one.operator, f"{{}} {one.operator} {{}}")
    return f"const {one.name} = {pattern.format(*map(operand, one.operands))};"


def searched(found: list[Function], layout: Layout) -> Iterable[str]:
    """Functions at step n, as the data-driven loop has them."""
    step, shift = (layout.row(name) for name in ("step", "shift"))
    yield f"const dt = S[{step}], ahead = n === 0 ? 0 : dt, time = (n + S[{shift}]) * dt, after = (n + 1 + S[{shift}]) * dt;"
    for f in found:
        yield "{"
        yield from (f"const {name} = S[{name[1:]}];" for name in rows_used(f.operations))
        yield from map(line, f.operations)
        value, rate, acceleration, kinks, following = (f"S[{row}]" for row in f.rows)
        yield f"[{value}, {rate}, {acceleration}, {kinks}] = polynomial(T, {f.table}, {operand(f.argument)});"
        yield f"{following} = polynomial(T, {f.table}, after)[0];" if f.of_time else f"{following} = {value};"
        yield "}"


def definition(head: str, lines: Iterable[str]) -> str:
    """A function."""
    return "\n  ".join([f"function {head} {{", *lines]) + "\n}\n"


def written(topology: Topology, also: Iterable[int] = ()) -> str:
    """Text with ``advance`` of :mod:`vfife.kernels.advance` for one simulation, whose arrays are typed arrays.

    ``also`` are scratch rows that it leaves.
    """
    also = tuple(also)
    lean, whole, layout, resize = trace(topology, also=also), trace(topology, True, also), Layout(topology), resizing(topology)
    text = driver.gathered("advance") + driver.ONE_LANE
    parts = [
        script(text, (*driver.STEPS, "clean")),
        definition("functions(S, T, I, n)", searched(functions(topology), layout)),
        definition("resize(S, I, C)", ["const [size, shift, repeated] = C;", *map(line, woven(resize, streamed(resize)))]),
        definition("clean(S, n)", [*map(line, woven(lean, ordered(lean))), "return true;"]),
        definition("whole(S, T, I, n)", ["functions(S, T, I, n);", *map(line, woven(whole, streamed(whole)))]),
    ]
    return "\n".join(parts)
