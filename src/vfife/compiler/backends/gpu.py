"""The straight-line step for graphics cards: one case per thread, with the language and lines of ``llvm.py``.

Cases lie in tiles of 32, the number of threads that execute together: row r of case m is
S[(m // 32 rows + r) 32 + m % 32]. Threads of a group then read neighbouring numbers, and the offset of a row
is a constant of the text. Fast steps keep their rows in registers until an unlikely branch is needed: a
processor's cache holds the state of eight lanes, but that of a card does not hold the states of thousands of
threads.

Apart from the two lines that ask for the number of the thread, the same text runs on a processor, case by
case: so its bits are tested on machines without a card.
"""

from __future__ import annotations

from ...kernels.advance import Memory, Outputs
from ...kernels.arrays import Layout
from ...kernels.topology import Topology
from ..trace.schedule import streamed
from ..trace.straight_line import Function, steps_of
from ..trace.tape import STEP_NUMBER, Operand, Trace, is_row, rows_used
from .llvm import Lane, Writer, full_step, operators, resize, time_functions
from .modules import is_short

LEAST_CAPABILITY = 70  # compute capability (7.0) for which programs are compiled; later cards run them
TILE = 32
# Arguments of a kernel. For addresses, how many numbers a case has: rows, where cases lie side by side, else
# numbers one after the other; SHARED where all cases use the same. An empty text is an integer. N are the
# numbers of a run, as the driver reads them.
SHARED = None
ARGUMENTS: dict[str, str | None] = {
    "S": "ROWS", "Q": "ROWS", "C": "3", "T": "%stride", "N": SHARED, "stride": "", "count": "", "look": "",
    "recorded": SHARED, "keeping": "", "extremes": SHARED, "resetting": "", "sound": SHARED, "finite": "",
    "limited": SHARED, "limiting": "", "limits": "%bounds", "broken": "1",
    "due": "1", "interval": "1", "at": "1", "stop": "1", "room": "", "out": "%handed", "reached": "1",
}  # fmt: skip
# Arguments of ``stream`` in their order: arrays with their length, or 0 if the driver does not read it. Three
# are not used here and get any address: R, because fast steps keep rows in registers; I, the topology of the
# data-driven loop; and ``shares``, because the start is taken on the processor.
LENGTHS = {
    "T": "%stride",
    "recorded": "%keeping",
    "extremes": "%resetting",
    "sound": "%finite",
    "limited": "%limiting",
}
STANDING_IN = {"R": "Q", "I": "N", "shares": "C"}
ARRAYS = [STANDING_IN.get(name, name) for name in (*Memory._fields, *Outputs._fields)]
PASSED = (
    *(
        f"ptr %{name}{'' if ARGUMENTS[name] is SHARED else '.own'}, i64 {LENGTHS.get(name, 0)}"
        for name in ARRAYS
    ),
    *("i64 %room", "i64 %until", "i64 %n", "i64 %count"),
)
SIDE_BY_SIDE = ("S", "Q", "C", "limits")


class Thread(Lane):
    """Write instructions for one case; names of rows are shared by all functions of time."""

    def value(self, operand: Operand) -> str:
        """Return the text of an operand."""
        return f"%{operand}" if is_row(operand) else super().value(operand)

    def row(self, row: int, copy: str = "S") -> str:
        """Write the address of a row."""
        return Writer.row(self, row, copy)

    def function(self, f: Function) -> tuple[str, ...]:
        """Write the evaluation of a function: value, two derivatives, kinks, and value one step later."""
        self.truths = frozenset(Trace(f.operations, {}).truths)
        for operation in f.operations:
            self.operation(operation)
        values = self.polynomial(str(f.table), self.value(f.argument))
        return values + (self.polynomial(str(f.table), "%after")[0] if f.of_time else values[0],)

    def phi(self, name: str, first: str, second: str, blocks: tuple[str, str]) -> None:
        """Write a number that is ``first`` or ``second``, depending on the block from which control comes."""
        self.out.append(f"  {name} = phi double [ {first}, %{blocks[0]} ], [ {second}, %{blocks[1]} ]")


def fast_steps(step: Trace, functions: list[Function], layout: Layout) -> str:
    """Return ``fast_steps(S, Q, T, numbers, n0, count)`` as in ``llvm.py``, with rows in registers: read
    before the first step, written after the last.
    """
    w = Thread(TILE)
    # Rows of functions are computed before a step, not by it: %p is their value in the last step, %v the new
    # one. All other rows that change are phis of %e (before the first step) and the result of the last step.
    # If a step is rejected, control leaves with the values from before it (%h).
    function_rows = {row for f in functions for row in f.rows}
    new_values = {row: f"%v{row}" for row in function_rows} | {
        row: w.value(value) for row, value in step.stores.items()
    }
    old_values = {row: f"%{'p' if row in function_rows else 'v'}{row}" for row in new_values}
    names = {
        *rows_used([*step.operations, *(o for f in functions for o in f.operations)]),
        *filter(is_row, step.stores.values()),
    }
    unchanged = {int(str(name)[1:]) for name in names} - new_values.keys() | {
        layout.row("step"),
        layout.row("shift"),
    }
    for row, name in [
        *((row, f"%e{row}") for row in new_values),
        *((row, f"%v{row}") for row in sorted(unchanged)),
    ]:
        w.out.append(f"  {name} = load double, ptr {w.row(row)}, align 8")
    w.out += ["  br label %body", "body:", "  %step = phi i64 [ %n0, %entry ], [ %next, %common ]"]
    for row in new_values:
        w.phi(old_values[row], f"%e{row}", new_values[row], ("entry", "common"))
    _search(w, functions, layout)
    w.truths = frozenset(step.truths)
    for operation in streamed(step, False):
        w.operation(operation)
    w.out += [f"  br i1 {w.value(step.rare)}, label %home, label %common"]
    w.out += [
        "common:",
        "  %next = add i64 %step, 1",
        "  %more = icmp slt i64 %next, %end",
        "  br i1 %more, label %body, label %home",
        "home:",
    ]
    w.out.append("  %reached = phi i64 [ %step, %body ], [ %next, %common ]")
    for row in new_values:
        w.phi(f"%h{row}", old_values[row], new_values[row], ("body", "common"))
    for row in new_values:
        w.out.append(f"  store double %h{row}, ptr {w.row(row)}, align 8")
    body = "\n".join(w.out)
    return f"""define internal i64 @fast_steps(ptr %S, ptr %Q, ptr noalias %T, i64 %numbers, \
i64 %n0, i64 %count) noinline {{
entry:
  %end = add i64 %n0, %count
{body}
  %clean = sub i64 %reached, %n0
  ret i64 %clean
}}
"""


def _search(w: Thread, functions: list[Function], layout: Layout) -> None:
    """Write the number of the step and the functions at it."""
    w.out += [f"  %{STEP_NUMBER} = sitofp i64 %step to double"]
    if not functions:
        return
    dt, shift = (f"%v{layout.row(name)}" for name in ("step", "shift"))
    ahead = w.fresh(f"sitofp i64 {w.fresh('add i64 %step, 1')} to double")
    for name, n in (("time", f"%{STEP_NUMBER}"), ("after", ahead)):
        w.out.append(f"  %{name} = fmul double {w.fresh(f'fadd double {n}, {shift}')}, {dt}")
    w.out += [f"  %ahead = select i1 true, double {dt}, double 0.0"]
    for number, f in enumerate(functions):
        w.mark = f"f{number}"
        for row, value in zip(f.rows, w.function(f), strict=True):
            w.out.append(f"  %v{row} = select i1 true, double {value}, double 0.0")
    w.mark = ""


def member(layout: Layout) -> str:
    """Return ``member(..., m)``: ``stream`` for case m, given the addresses of all cases, from the step that
    it has ``reached``; a case that has all its outputs does nothing.
    """
    lines = [f"  %tile = lshr i64 %m, {TILE.bit_length() - 1}", f"  %lane = and i64 %m, {TILE - 1}"]
    lines += ["  %handed = mul i64 %room, %keeping", "  %bounds = mul i64 %limiting, 2"]
    for name, size in ARGUMENTS.items():
        if not size:
            continue
        rows = size.replace("ROWS", str(layout.rows))
        if name in SIDE_BY_SIDE:
            lines += [
                f"  %{name}.rows = mul i64 %tile, {rows}",
                f"  %{name}.tile = mul i64 %{name}.rows, {TILE}",
            ]
            lines.append(f"  %{name}.first = add i64 %{name}.tile, %lane")
        else:
            lines.append(f"  %{name}.first = mul i64 %m, {rows}")
        lines.append(f"  %{name}.own = getelementptr double, ptr %{name}, i64 %{name}.first")
    arguments = ", ".join(f"{kind(size)} %{name}" for name, size in ARGUMENTS.items())
    body = "\n".join(lines)
    return f"""define void @member({arguments}, i64 %m) {{
entry:
{body}
  %has = load i64, ptr %at.own, align 8
  %wants = load i64, ptr %stop.own, align 8
  %n = load i64, ptr %reached.own, align 8
  %past = urem i64 %n, %look
  %until = sub i64 %look, %past
  %more = icmp slt i64 %has, %wants
  br i1 %more, label %steps, label %done
steps:
  %made = call i64 @stream({", ".join(PASSED)})
  store i64 %made, ptr %reached.own, align 8
  br label %done
done:
  ret void
}}
"""


def kind(size: str | None) -> str:
    """Return the type of an argument."""
    return "i64" if size == "" else "ptr"


def module(topology: Topology, driver: str) -> str:
    """Return the text of a module with ``member``; ``driver`` is the text of its ``stream``."""
    steps, layout = steps_of(topology), Layout(topology)
    return "\n".join(
        [
            time_functions(steps.functions, 1, layout, (), stride=TILE),
            fast_steps(steps.fast, steps.functions, layout),
            full_step(steps.full, 1, bool(steps.functions), is_short(steps), TILE),
            resize(steps.resize, 1, TILE),
            operators(1),
            driver,
            member(layout),
        ]
    )


def kernel() -> str:
    """Return the kernel ``simulate(...)``, which calls ``member`` in each thread."""
    arguments = ", ".join(f"{kind(size)} %{name}" for name, size in ARGUMENTS.items())
    return f"""declare i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.tid.x()
define ptx_kernel void @simulate({arguments}) {{
  %block = call i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
  %thread = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()
  %block.long = zext i32 %block to i64
  %thread.long = zext i32 %thread to i64
  %before = mul i64 %block.long, {TILE}
  %m = add i64 %before, %thread.long
  call void @member({arguments}, i64 %m)
  ret void
}}
"""
