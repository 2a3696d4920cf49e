"""The straight-line step as text of LLVM's language: every operation of the trace is one instruction on
vectors of W doubles.

Row r of lane w is S[r W + w]. The text contains no fused products and permits no reordering, so that every
machine computes the same bits, on processors of any kind and on graphics cards.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterable

from ...kernels.arrays import Layout
from ..trace.schedule import (
    Line,
    Load,
    Reload,
    Store,
    Test,
    double_buffered,
    in_place,
    ordered,
    reread,
    settled,
    steady,
    streamed,
)
from ..trace.straight_line import Function
from ..trace.tangent import Tangents, of_time
from ..trace.tape import STEP_NUMBER, Operand, Operation, Trace, is_row, operand_of, rows_used

BINARY = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv", "and": "and", "or": "or"}
ORDER = {">": "ogt", "<": "olt", ">=": "oge", "<=": "ole", "==": "oeq", "!=": "une"}
ROUNDING = 6755399441055744.0  # 1.5 2^52: adding and subtracting it rounds to an integer
ANSWER = "{ double, double, double, double }"  # of a polynomial
FUNCTIONS = "void @functions(ptr %S, ptr %from, ptr %T, i64 %numbers, i64 %step)"
STACK = 16  # bytes: alignment of a stack that every caller guarantees
COPY = 6_000  # largest size (bytes) of the written rows of which two copies are kept in the nearest cache
BLOCK = 400  # lines of a block


class Instructions:
    """The growing text of a function, ``out``, in which each result has a name of its own."""

    def __init__(self) -> None:
        self.out: list[str] = []
        self.count = 0

    def fresh(self, text: str) -> str:
        """Write an instruction; return a new name for its result."""
        self.count += 1
        self.out.append(f"  %x{self.count} = {text}")
        return f"%x{self.count}"


class Writer(Instructions):
    """Write instructions for W = ``width`` lanes side by side.

    ``truths`` are names of truth values; ``moving`` rows have two copies, ``from`` and ``to``; a row begins
    ``stride`` numbers after the one before, W unless given.
    """

    def __init__(
        self, width: int, truths: Iterable[str] = (), moving: Iterable[int] = (), stride: int = 0
    ) -> None:
        super().__init__()
        self.width, self.stride = width, stride or width
        self.truths, self.moving = frozenset(truths), frozenset(moving)
        self.number = "double" if width == 1 else f"<{width} x double>"
        self.truth = "i1" if width == 1 else f"<{width} x i1>"
        self.suffix = "f64" if width == 1 else f"v{width}f64"
        self.constants: dict[str, str] = {}
        # Relative to a frame pointer, addresses of spilled numbers are a byte shorter.
        self.framed = ' "frame-pointer"="all"'

    def kind(self, operand: Operand) -> str:
        """Return the type of an operand."""
        return self.truth if isinstance(operand, bool) or operand in self.truths else self.number

    def value(self, operand: Operand) -> str:
        """Return the text of an operand; constants are vectors of equal numbers."""
        if isinstance(operand, str):
            return f"%{operand}"
        text = str(operand).lower() if isinstance(operand, bool) else literal(operand)
        if self.width == 1:
            return text
        scalar = "i1" if isinstance(operand, bool) else "double"
        return self.constants.setdefault(text, "<" + ", ".join([f"{scalar} {text}"] * self.width) + ">")

    def row(self, row: int, copy: str = "S") -> str:
        """Write the address of a row in a copy of the state."""
        return self.fresh(f"getelementptr double, ptr %{copy}, i64 {row * self.stride}")

    def load(self, row: int, name: str = "", written: bool = False) -> None:
        """Load a row as it was before the step, or as it is ``written`` in this step."""
        copy = ("to" if written else "from") if row in self.moving else "S"
        self.out.append(
            f"  {self.value(name or f'v{row}')} = load {self.number}, ptr {self.row(row, copy)}, align"
            f" {8 * self.width}"
        )

    def store(self, row: int, value: Operand) -> None:
        """Store a value in a row."""
        copy = "to" if row in self.moving else "S"
        self.out.append(
            f"  store {self.number} {self.value(value)}, ptr {self.row(row, copy)}, align {8 * self.width}"
        )

    def operation(self, operation: Operation) -> None:
        """Write an operation: one instruction, two for a rounding and for a product with a sum."""
        name, operator, operands = operation
        values = [self.value(o) for o in operands]
        if operator in BINARY:
            text = f"{BINARY[operator]} {self.kind(name)} {values[0]}, {values[1]}"
        elif operator in ORDER:
            text = f"fcmp {ORDER[operator]} {self.number} {values[0]}, {values[1]}"
        elif operator == "select":
            kind, condition = self.kind(name), values[0]
            if any(type(o) is float and o == 0.0 for o in operands[1:]):
                # LLVM makes `x if x < 0.0 else 0.0` a minimum, which ARM and NVIDIA take of -0.0 and 0.0 as
                # -0.0; it does not see through `freeze`, which does nothing.
                condition = self.fresh(f"freeze {self.truth} {condition}")
            text = f"select {self.truth} {condition}, {kind} {values[1]}, {kind} {values[2]}"
        elif operator == "round":
            text = (
                f"fsub {self.number} {self.fresh(f'fadd {self.number} {values[0]}, {self.value(ROUNDING)}')},"
                f" {self.value(ROUNDING)}"
            )
        elif operator == "fused":
            product = self.fresh(f"fmul {self.number} {values[0]}, {values[1]}")
            text = f"fadd {self.number} {product}, {values[2]}"
        elif operator == "neg":
            text = f"fneg {self.number} {values[0]}"
        else:
            text = (
                f"call {self.number}"
                f" @llvm.{ {'sqrt': 'sqrt', 'abs': 'fabs'}[operator] }.{self.suffix}({self.number}"
                f" {values[0]})"
            )
        self.out.append(f"  {self.value(name)} = {text}")

    def begin(self, searching: bool) -> None:
        """Write the call of functions of time, if there are any (``searching``), and the number of the step
        in all lanes.
        """
        if searching:
            self.out.append(
                f"  call void @functions(ptr %S, ptr %{'from' if self.moving else 'S'}, ptr %T, i64 %numbers,"
                " i64 %step)"
            )
        self.out.append(f"  %{STEP_NUMBER} = {self.everywhere(self.fresh('sitofp i64 %step to double'))}")

    def everywhere(self, number: str) -> str:
        """Return the instruction that copies a number to all lanes."""
        if self.width == 1:
            return f"bitcast double {number} to double"
        first = self.fresh(f"insertelement {self.number} poison, double {number}, i64 0")
        return (
            f"shufflevector {self.number} {first}, {self.number} poison, <{self.width} x i32> zeroinitializer"
        )

    def any_lane(self, condition: Operand) -> str:
        """Write whether a condition holds in any lane."""
        if self.width == 1:
            return self.value(condition)
        bits = self.fresh(f"bitcast {self.truth} {self.value(condition)} to i{self.width}")
        return self.fresh(f"icmp ne i{self.width} {bits}, 0")

    def lines(self, lines: Iterable[Line | Reload], block: str = "body") -> str:
        """Write lines in their order, with a jump to ``rare`` if the rare condition holds; return the name of
        the last block.

        After ``BLOCK`` lines a block ends with a conditional jump that is never taken, because the time of
        compilation grows with the square of a block's length.
        """
        size = 0
        for line in lines:
            size += 1
            if size == BLOCK:
                self.count, size = self.count + 1, 0
                block = f"b{self.count}"
                self.out += [f"  br i1 %going, label %{block}, label %never", f"{block}:"]
            if isinstance(line, Operation):
                self.operation(line)
            elif isinstance(line, Load):
                self.load(line.row)
            elif isinstance(line, Reload):
                self.load(line.row, line.name, line.written)
            elif isinstance(line, Store):
                self.store(line.row, line.value)
            elif isinstance(line, Test):
                block, size = "common", 0
                self.out += [
                    f"  br i1 {self.any_lane(line.condition)}, label %rare, label %common",
                    "common:",
                ]
        return block


class Lane(Writer):
    """Write instructions for the single lane ``w`` of W; ``mark`` distinguishes names of different
    functions of time.
    """

    def __init__(self, lanes: int, moving: Iterable[int] = ()) -> None:
        super().__init__(1, moving=moving, stride=lanes)
        self.mark = ""

    def value(self, operand: Operand) -> str:
        """Return the text of an operand."""
        local = isinstance(operand, str) and (is_row(operand) or operand[1:].isdigit())
        return f"%{self.mark}{operand}" if local else super().value(operand)

    def row(self, row: int, copy: str = "S") -> str:
        """Write the address of a row in the lane."""
        return self.fresh(
            f"getelementptr double, ptr %{copy}, i64 {self.fresh(f'add i64 %w, {row * self.stride}')}"
        )

    def polynomial(self, table: str, x: str) -> tuple[str, ...]:
        """Write the evaluation of a table at ``x``: value, two derivatives, and kinks passed."""
        result = self.fresh(f"call {ANSWER} @polynomial(ptr %T, i64 0, i64 {table}, double {x})")
        return tuple(self.fresh(f"extractvalue {ANSWER} {result}, {k}") for k in range(4))

    def derivative(self, change: str, rate: str, slope: str) -> str:
        """Write the derivative of a function whose table changes by ``change`` and whose argument by
        ``slope``.
        """
        return self.fresh(f"fadd double {change}, {self.fresh(f'fmul double {rate}, {slope}')}")


def literal(x: float) -> str:
    """Return the text of a constant by its bits, which no decimal rounding can change."""
    return "0x%016X" % struct.unpack("<Q", struct.pack("<d", float(x)))[0]  # noqa: UP031


def fast_steps(step: Trace, width: int, changing: Collection[int], arranged: bool = False) -> str:
    """Return ``fast_steps(S, Q, T, numbers, n0, count)``: take steps until one that needs the full step;
    return their number.

    Each step reads the rows that change from one of two copies, S and Q, and writes them to the other.
    Nothing then waits for the test, or for an old value to be read, and a rejected step has changed nothing.
    At the end everything is in S. If two copies exceed the nearest cache, there is one, and writes wait for
    the test. Operations that are the same in every step are executed before the first; rows that get the same
    constant in every step are written after the last. Rows ``changing`` are written before each step by
    functions of time. ``arranged``: the operations are in a good order already.
    """
    truths = step.truths
    first, step = steady(step, changing)
    constants, step = settled(step, changing)
    double = 8 * width * len(step.stores) <= COPY
    w = Writer(width, truths, step.stores if double else ())
    ready = w.lines(first, "entry")
    entry, w.out = "\n".join(w.out), []
    w.begin(bool(changing))
    order = list(step.operations) if arranged else ordered(step, not double)
    last = w.lines(reread(double_buffered(step, order) if double else in_place(step, order)))
    body, w.out = "\n".join(w.out), []
    for row, value in constants.items():
        w.store(row, value)
    home, w.out = "\n".join(w.out), []
    _copied(w, step.stores if double else ())
    copied = "\n".join(w.out)
    target, source = ("to", "from") if double else ("S", "S")
    rare = "rare:\n  br label %home\n" if step.rare else ""
    phis = f"[ %{target}, %{last} ]" + (f", [ %{source}, %rare ]" if step.rare else "")
    counts = f"[ %next, %{last} ]" + (", [ %step, %rare ]" if step.rare else "")
    return f"""define internal i64 @fast_steps(ptr %S, ptr %Q, ptr noalias %T, i64 %numbers, \
i64 %n0, i64 %count) noinline{w.framed} {{
entry:
  %end = add i64 %n0, %count
  %going = icmp sgt i64 %count, 0
{entry}
  br label %body
body:
  %step = phi i64 [ %n0, %{ready} ], [ %next, %{last} ]
  %from = phi ptr [ %S, %{ready} ], [ %to, %{last} ]
  %to = phi ptr [ %Q, %{ready} ], [ %from, %{last} ]
{body}
  %next = add i64 %step, 1
  %more = icmp slt i64 %next, %end
  br i1 %more, label %body, label %home
{rare}home:
  %last = phi ptr {phis}
  %reached = phi i64 {counts}
  %clean = sub i64 %reached, %n0
{home}
  %there = icmp eq ptr %last, %S
  br i1 %there, label %done, label %copy
copy:
{copied}
  br label %done
done:
  ret i64 %clean
never:
  ret i64 0
}}
"""


def _copied(w: Writer, rows: Iterable[int]) -> None:
    """Write the copy of rows from the copy ``last`` to S."""
    for number, row in enumerate(rows, 1):
        if number % (BLOCK // 4) == 0:
            w.out += [f"  br i1 %going, label %copy{number}, label %never", f"copy{number}:"]
        value = w.fresh(f"load {w.number}, ptr {w.row(row, 'last')}, align {8 * w.width}")
        w.out.append(f"  store {w.number} {value}, ptr {w.row(row)}, align {8 * w.width}")


def full_step(step: Trace, width: int, searching: bool, fast: bool, stride: int = 0) -> str:
    """Return ``full_step(S, T, numbers, n)``: step n with all branches; ``fast``: ordered and optimised."""
    w = Writer(width, step.truths, stride=stride)
    care = f"noinline{w.framed}" if fast else "noinline optnone"
    w.begin(searching)
    w.lines(reread(in_place(step, ordered(step))) if fast else in_place(step, streamed(step)))
    body = "\n".join(w.out)
    return f"""define internal void @full_step(ptr noalias %S, ptr noalias %T, i64 %numbers, \
i64 %step) {care} {{
  %going = icmp sge i64 %step, 0
{body}
  ret void
never:
  ret void
}}
"""


def lane_loop(body: str, width: int) -> str:
    """Return ``functions(S, from, T, numbers, n)`` that executes ``body`` for each lane in turn; %nd and %md
    are the steps n and n + 1 as doubles.
    """
    return f"""define internal {FUNCTIONS} noinline {{
entry:
  %stride = udiv i64 %numbers, {width}
  %following = add i64 %step, 1
  %nd = sitofp i64 %step to double
  %md = sitofp i64 %following to double
  %start = icmp eq i64 %step, 0
  br label %lane
lane:
  %w = phi i64 [ 0, %entry ], [ %v, %lane ]
  %shift = mul i64 %w, %stride
{body}
  %v = add i64 %w, 1
  %more = icmp slt i64 %v, {width}
  br i1 %more, label %lane, label %done
done:
  ret void
}}
"""


def time_functions(
    functions: list[Function],
    width: int,
    layout: Layout,
    moving: Iterable[int],
    directions: int = 0,
    stride: int = 0,
) -> str:
    """Return ``functions(S, from, T, numbers, n)``: functions at step n, lane by lane, because each searches
    its table by itself.

    With ``directions``, the tables of a lane are followed by tables of their derivatives by the argument, and
    these by the derivatives of their numbers in each direction.
    """
    if not functions:
        return f"define internal {FUNCTIONS} alwaysinline {{\n  ret void\n}}\n"
    w = Lane(stride or width, moving)
    if directions:
        w.out.append(f"  %length = udiv i64 %stride, {directions + 2}")
    dt, shift = (
        w.fresh(f"load double, ptr {w.row(layout.row(name))}, align 8") for name in ("step", "shift")
    )
    for name, n in (("time", "nd"), ("after", "md")):
        w.out.append(f"  %{name} = fmul double {w.fresh(f'fadd double %{n}, {shift}')}, {dt}")
    w.out.append(f"  %ahead = select i1 %start, double 0.0, double {dt}")
    for number, f in enumerate(functions):
        run = Tangents(layout.rows, directions)
        run.slopes |= of_time(layout.row("step"))(run) if directions else {}
        run.run(f.operations)
        slopes = run.slope(f.argument), run.slope("after")
        operations = (
            run.tape.needed([run.value(f.argument), *slopes[0], *slopes[1]]) if directions else f.operations
        )
        w.mark, w.truths = f"f{number}", frozenset(Trace(operations, {}).truths)
        for name in rows_used(operations):
            w.load(int(name[1:]))
        for operation in operations:
            w.operation(operation)
        table = w.fresh(f"add i64 %shift, {f.table}")
        argument = w.value(operand_of(run.value(f.argument)) if directions else f.argument)
        values = w.polynomial(table, argument)
        later = w.polynomial(table, "%after") if f.of_time else values
        for row, value in zip(f.rows, (*values, later[0]), strict=True):
            w.out.append(f"  store double {value}, ptr {w.row(row)}, align 8")
        third = w.polynomial(w.fresh(f"add i64 {table}, %length"), argument)[2] if directions else ""
        for k in range(directions):
            slope_table = w.fresh(f"add i64 {table}, {w.fresh(f'mul i64 %length, {k + 2}')}")
            argument_slope, later_slope = (w.value(operand_of(slope[k])) for slope in slopes)
            parts = w.polynomial(slope_table, argument)
            rates = [
                w.derivative(part, rate, argument_slope)
                for part, rate in zip(parts[:3], (values[1], values[2], third), strict=True)
            ]
            next_slope = (
                w.derivative(w.polynomial(slope_table, "%after")[0], later[1], later_slope)
                if f.of_time
                else rates[0]
            )
            for row, value in zip(f.rows, (*rates, w.value(0.0), next_slope), strict=True):
                w.out.append(f"  store double {value}, ptr {w.row(row + (k + 1) * layout.rows)}, align 8")
    return lane_loop("\n".join(w.out), width)


def resize(change: Trace, width: int, stride: int = 0) -> str:
    """Return ``resize(S, C)``: change the state to another step size; C has three rows: size, phase, and the
    number to add to the count of events.
    """
    w = Writer(width, change.truths, stride=stride)
    for row, name in enumerate(("size", "shift", "repeated")):
        w.out.append(f"  %{name} = load {w.number}, ptr {w.row(row, 'C')}, align {8 * width}")
    w.lines(in_place(change, streamed(change)))
    body = "\n".join(w.out)
    return f"""define internal void @resize(ptr noalias %S, ptr noalias %C) noinline optnone {{
  %going = icmp ne ptr %S, null
{body}
  ret void
never:
  ret void
}}
"""


def aligned(width: int) -> str:
    """Return the alignment of a module's stack, so that no spilled vector straddles two lines of the cache.

    Functions that are called from outside align the stack themselves.
    """
    if 8 * width <= STACK:
        return ""
    return f"""!llvm.module.flags = !{{!0}}
!0 = !{{i32 1, !"override-stack-alignment", i32 {8 * width}}}
"""


def operators(width: int) -> str:
    """Return the declarations of the operators that are no instructions."""
    w = Writer(width)
    return "\n".join(f"declare {w.number} @llvm.{name}.{w.suffix}({w.number})" for name in ("sqrt", "fabs"))
