"""The straight-line step as plain Python, one lane: slow, and the same bits; to read, to step through, to try a trace without a compiler."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from ..kernels.arrays import Layout
from ..kernels.elementary import nearest
from ..kernels.polynomial import polynomial
from ..kernels.topology import Topology
from .native import NEVER, Memory, Take
from .schedule import Line, Load, Store, Test, ordered, streamed, woven
from .straight_line import Function, functions, resizing, trace
from .trace import Operand, rows_used

PATTERNS = {
    "sqrt": "sqrt({})", "neg": "-{}", "abs": "abs({})", "and": "{} & {}", "or": "{} | {}", "select": "{1} if {0} else {2}", "round": "nearest({})",
}  # fmt: skip

ADVANCE = """def again(S, before, T, n, parts):
    S[:] = before
    dt, shift = S[STEP], S[SHIFT]
    functions(S, T, n - 1)
    resize(S, dt / parts, shift * parts, 1.0)
    for i in range((n - 1) * parts + 1, n * parts + 1):
        functions(S, T, i)
        whole(S, i)
    resize(S, dt, shift, 0.0)

def displace(S, T, share):
    dt = S[STEP]
    resize(S, share * dt, 0.0, 0.0)
    functions(S, T, 1)
    whole(S, 1)
    resize(S, dt, share, 0.0)

def watch(S, kept, limited, limits, broken, n):
    within = all(isfinite(S[q]) for q in kept)
    within = within and all(low <= S[q] <= high for q, low, high in zip(limited, limits[::2], limits[1::2]))
    if broken[0] == 0.0 and not within:
        broken[0] = n

def advance(memory, n0, steps, out, anew=True, look=NEVER):
    S, before, T, parts, shares, kept, extremes, limited, limits, broken = memory
    before = before[: len(S)]
    for m in range(len(out)):
        if broken[0] > 0.0:
            break
        for q in extremes if anew else ():
            S[q] = 0.0
        for n in range(n0 + m * steps, n0 + (m + 1) * steps):
            functions(S, T, n)
            if n == 0 or not lean(S, n):
                before[:] = S
                whole(S, n)
                if n > 0 and parts > 1 and S[EVENT] > 0.0:
                    again(S, before, T, n, parts)
                if n == 0 and shares[0] > 0.0:
                    displace(S, T, shares[0])
            if (n + 1) % look == 0:
                watch(S, kept, limited, limits, broken, n + 1)
                if broken[0] > 0.0:
                    break
        for q in range(out.shape[1]):
            out[m, q, 0] = S[kept[q]]
"""


def operand(value: Operand) -> str:
    """A name, or a number that reads back to the same bits."""
    if isinstance(value, float) and not math.isfinite(value):
        return "(1e999 - 1e999)" if value != value else "1e999" if value > 0.0 else "-1e999"
    return value if isinstance(value, str) else repr(value)


def line(one: Line) -> str:
    """A line."""
    if isinstance(one, Load):
        return f"v{one.row} = S[{one.row}]"
    if isinstance(one, Store):
        return f"S[{one.row}] = {operand(one.value)}"
    if isinstance(one, Test):
        return f"if {operand(one.condition)}: return False"
    pattern = PATTERNS.get(one.operator, f"{{}} {one.operator} {{}}")
    return f"{one.name} = {pattern.format(*(f'({o})' if o[0] == '-' else o for o in map(operand, one.operands)))}"


def searched(found: list[Function], layout: Layout) -> Iterable[str]:
    """Functions at step n, as the data-driven loop has them."""
    yield f"dt, shift = S[{layout.row('step')}], S[{layout.row('shift')}]"
    yield "ahead = 0.0 if n == 0 else dt"
    yield "time, after = (n + shift) * dt, (n + 1 + shift) * dt"
    for f in found:
        yield from (f"{name} = S[{name[1:]}]" for name in rows_used(f.operations))
        yield from map(line, f.operations)
        value, rate, acceleration, kinks, following = (f"S[{row}]" for row in f.rows)
        yield f"{value}, {rate}, {acceleration}, {kinks} = polynomial(T, {f.table}, {operand(f.argument)})"
        yield f"{following} = polynomial(T, {f.table}, after)[0]" if f.of_time else f"{following} = {value}"


def definition(head: str, lines: Iterable[str]) -> str:
    """A function."""
    return "\n    ".join([f"def {head}:", *lines]) + "\n"


def written(topology: Topology) -> str:
    """Text with ``advance``; it wants ``sqrt``, ``isfinite``, ``nearest``, ``polynomial`` and ``NEVER``."""
    lean, whole, layout, resize = trace(topology), trace(topology, True), Layout(topology), resizing(topology)
    parts = [
        "".join(f"{name.upper()} = {layout.row(name)}\n" for name in ("step", "shift", "event")),
        definition("functions(S, T, n)", searched(functions(topology), layout)),
        definition("resize(S, size, shift, repeated)", map(line, woven(resize, streamed(resize)))),
        definition("lean(S, n)", [*map(line, woven(lean, ordered(lean))), "return True"]),
        definition("whole(S, n)", [*map(line, woven(whole, streamed(whole))), "return True"]),
        ADVANCE,
    ]
    return "\n\n".join(parts)


def straight_line(topology: Topology) -> Callable[[Memory], Take]:
    """``advance`` of a topology as plain Python, called as :class:`~vfife.codegen.runner.Runner` calls its loops."""
    space: dict[str, Any] = {"sqrt": math.sqrt, "isfinite": math.isfinite, "nearest": nearest, "polynomial": polynomial, "NEVER": NEVER}
    exec(compile(written(topology), "<vfife straight line>", "exec"), space)  # the text is our own and the user's laws, never a model file's
    return lambda memory: partial(space["advance"], memory)
