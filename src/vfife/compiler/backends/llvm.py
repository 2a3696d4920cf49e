"""The straight-line step as text of LLVM's language: every operation of the trace is one instruction on
vectors of W doubles, whatever W.

Row r of lane w lies at S[r W + w]. The text asks for no fused product and allows no reordering, so that every
machine gives the same bits; the same text becomes code of other processors, of graphics cards and of the web.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterable

from ...kernels.arrays import Layout
from ..trace.schedule import (
    Again,
    Line,
    Load,
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
from ..trace.tangent import Tangents, named, of_time
from ..trace.tape import STEP_NUMBER, Operand, Operation, Trace, is_row, rows_used

BINARY = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv", "and": "and", "or": "or"}
ORDER = {">": "ogt", "<": "olt", ">=": "oge", "<=": "ole", "==": "oeq", "!=": "une"}
ROUNDING = 6755399441055744.0  # 1.5 2^52, added and taken off again
ANSWER = "{ double, double, double, double }"  # of a polynomial
FUNCTIONS = "void @functions(ptr %S, ptr %from, ptr %T, i64 %numbers, i64 %step)"
STACK = 16  # bytes of which where a stack begins is a multiple
COPY = 6_000  # bytes of a copy of the state of which there may be two
BLOCK = 400  # lines between two ends of a block


class Writer:
    """Instructions for W simulations side by side; a row begins ``stride`` numbers after the one before,
    which is W unless another is given.
    """

    def __init__(
        self, width: int, truths: Iterable[str] = (), moving: Iterable[int] = (), stride: int = 0
    ) -> None:
        self.width, self.truths, self.moving, self.stride = (
            width,
            frozenset(truths),
            frozenset(moving),
            stride or width,
        )
        self.out: list[str] = []
        self.number = "double" if width == 1 else f"<{width} x double>"
        self.truth = "i1" if width == 1 else f"<{width} x i1>"
        self.suffix = "f64" if width == 1 else f"v{width}f64"
        self.constants: dict[str, str] = {}
        self.count = 0
        self.framed = ' "frame-pointer"="all"'  # what is put aside has addresses that are a byte shorter

    def kind(self, operand: Operand) -> str:
        """Type of an operand."""
        return self.truth if isinstance(operand, bool) or operand in self.truths else self.number

    def value(self, operand: Operand) -> str:
        """An operand as it is written."""
        if isinstance(operand, str):
            return f"%{operand}"
        one = str(operand).lower() if isinstance(operand, bool) else literal(operand)
        if self.width == 1:
            return one
        scalar = "i1" if isinstance(operand, bool) else "double"
        return self.constants.setdefault(one, "<" + ", ".join([f"{scalar} {one}"] * self.width) + ">")

    def fresh(self, text: str) -> str:
        """A name of its own for a text."""
        self.count += 1
        self.out.append(f"  %x{self.count} = {text}")
        return f"%x{self.count}"

    def row(self, row: int, copy: str = "S") -> str:
        """Address of a row in a copy of the state."""
        return self.fresh(f"getelementptr double, ptr %{copy}, i64 {row * self.stride}")

    def load(self, row: int, name: str = "", written: bool = False) -> None:
        """The row as it was, or as it is ``written``."""
        copy = ("to" if written else "from") if row in self.moving else "S"
        self.out.append(
            f"  {self.value(name or f'v{row}')} = load {self.number}, ptr {self.row(row, copy)}, align"
            f" {8 * self.width}"
        )

    def store(self, row: int, value: Operand) -> None:
        """A row is given a value."""
        copy = "to" if row in self.moving else "S"
        self.out.append(
            f"  store {self.number} {self.value(value)}, ptr {self.row(row, copy)}, align {8 * self.width}"
        )

    def operation(self, operation: Operation) -> None:
        """One instruction; two for a rounding, and for a product and a sum."""
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
        """Functions of time at the step, where there are any, and the number of the step in all lanes."""
        if searching:
            self.out.append(
                f"  call void @functions(ptr %S, ptr %{'from' if self.moving else 'S'}, ptr %T, i64 %numbers,"
                " i64 %step)"
            )
        self.out.append(f"  %{STEP_NUMBER} = {self.everywhere(self.fresh('sitofp i64 %step to double'))}")

    def everywhere(self, number: str) -> str:
        """What gives a number in all lanes."""
        if self.width == 1:
            return f"bitcast double {number} to double"
        first = self.fresh(f"insertelement {self.number} poison, double {number}, i64 0")
        return (
            f"shufflevector {self.number} {first}, {self.number} poison, <{self.width} x i32> zeroinitializer"
        )

    def any(self, condition: Operand) -> str:
        """Whether a condition holds in any lane."""
        if self.width == 1:
            return self.value(condition)
        bits = self.fresh(f"bitcast {self.truth} {self.value(condition)} to i{self.width}")
        return self.fresh(f"icmp ne i{self.width} {bits}, 0")

    def lines(self, lines: Iterable[Line | Again], block: str = "body") -> str:
        """Lines in their order; where the rare condition holds, the way goes to ``rare``.

        The name of the last block is returned.

        After ``BLOCK`` lines a block ends with a way out that is never taken: the time of compilation grows
        with the square of a block.
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
            elif isinstance(line, Again):
                self.load(line.row, line.name, line.written)
            elif isinstance(line, Store):
                self.store(line.row, line.value)
            elif isinstance(line, Test):
                block, size = "common", 0
                self.out += [f"  br i1 {self.any(line.condition)}, label %rare, label %common", "common:"]
        return block


class Lane(Writer):
    """Instructions for lane ``w`` of W alone; ``mark`` keeps names of one function apart from another's."""

    def __init__(self, lanes: int, moving: Iterable[int] = ()) -> None:
        super().__init__(1, moving=moving, stride=lanes)
        self.mark = ""

    def value(self, operand: Operand) -> str:
        """An operand as it is written."""
        own = isinstance(operand, str) and (is_row(operand) or operand[1:].isdigit())
        return f"%{self.mark}{operand}" if own else super().value(operand)

    def row(self, row: int, copy: str = "S") -> str:
        """Address of a row in the lane."""
        return self.fresh(
            f"getelementptr double, ptr %{copy}, i64 {self.fresh(f'add i64 %w, {row * self.stride}')}"
        )

    def polynomial(self, table: str, x: str) -> tuple[str, ...]:
        """Value, two derivatives and kinks of a table."""
        result = self.fresh(f"call {ANSWER} @polynomial(ptr %T, i64 0, i64 {table}, double {x})")
        return tuple(self.fresh(f"extractvalue {ANSWER} {result}, {k}") for k in range(4))

    def along(self, own: str, rate: str, slope: str) -> str:
        """Change of a function whose table changes by ``own`` and whose argument by ``slope``."""
        return self.fresh(f"fadd double {own}, {self.fresh(f'fmul double {rate}, {slope}')}")


def literal(x: float) -> str:
    """A constant by its bits."""
    return "0x%016X" % struct.unpack("<Q", struct.pack("<d", float(x)))[0]  # noqa: UP031


def fast_steps(step: Trace, width: int, changing: Collection[int], arranged: bool = False) -> str:
    """``fast_steps(S, Q, T, numbers, n0, count)``: steps until one that something rare wants; their number is
    returned.

    Each step reads what changes from one of two copies of the state, S and Q, and writes it to the other, so
    that nothing waits for the test or for an old value to be read; in the end all is in S. Where two copies
    are more than the nearest cache holds, there is one, and what is written waits for the test. What all
    steps share comes before the first, rows that are the same number after each of them behind the last; rows
    that are ``changing`` are made anew before each.
    """
    truths = step.truths
    first, step = steady(step, changing)
    same, step = settled(step, changing)
    twice = 8 * width * len(step.stores) <= COPY
    w = Writer(width, truths, step.stores if twice else ())
    ready = w.lines(first, "entry")
    before, w.out = "\n".join(w.out), []
    w.begin(bool(changing))
    order = list(step.operations) if arranged else ordered(step, not twice)
    last = w.lines(reread(double_buffered(step, order) if twice else in_place(step, order)))
    body, w.out = "\n".join(w.out), []
    for row, value in same.items():
        w.store(row, value)
    home, w.out = "\n".join(w.out), []
    _copied(w, step.stores if twice else ())
    copied = "\n".join(w.out)
    there, here = ("to", "from") if twice else ("S", "S")
    rare = "rare:\n  br label %home\n" if step.rare else ""
    phis = f"[ %{there}, %{last} ]" + (f", [ %{here}, %rare ]" if step.rare else "")
    counts = f"[ %next, %{last} ]" + (", [ %step, %rare ]" if step.rare else "")
    return f"""define internal i64 @fast_steps(ptr %S, ptr %Q, ptr noalias %T, i64 %numbers, \
i64 %n0, i64 %count) noinline{w.framed} {{
entry:
  %end = add i64 %n0, %count
  %going = icmp sgt i64 %count, 0
{before}
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
    """Rows of the copy ``last`` are copied to S."""
    for number, row in enumerate(rows, 1):
        if number % (BLOCK // 4) == 0:
            w.out += [f"  br i1 %going, label %copy{number}, label %never", f"copy{number}:"]
        value = w.fresh(f"load {w.number}, ptr {w.row(row, 'last')}, align {8 * w.width}")
        w.out.append(f"  store {w.number} {value}, ptr {w.row(row)}, align {8 * w.width}")


def full_step(step: Trace, width: int, searching: bool, fast: bool, stride: int = 0) -> str:
    """``full_step(S, T, numbers, n)``: step n, whatever it wants; ``fast`` where that is worth its time."""
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
    """``functions(S, from, T, numbers, n)`` with ``body`` for each lane in turn; %nd and %md are steps n and
    n + 1.
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
    """``functions(S, from, T, numbers, n)``: functions at step n, lane by lane, as the data-driven loop has
    them.

    With ``directions`` the tables of a lane are followed by those of their derivatives, and these by the
    derivatives of its numbers in each.
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
        argument = w.value(named(run.value(f.argument)) if directions else f.argument)
        values = w.polynomial(table, argument)
        later = w.polynomial(table, "%after") if f.of_time else values
        for row, value in zip(f.rows, (*values, later[0]), strict=True):
            w.out.append(f"  store double {value}, ptr {w.row(row)}, align 8")
        third = w.polynomial(w.fresh(f"add i64 {table}, %length"), argument)[2] if directions else ""
        for k in range(directions):
            own = w.fresh(f"add i64 {table}, {w.fresh(f'mul i64 %length, {k + 2}')}")
            slope, after = (w.value(named(one[k])) for one in slopes)
            parts = w.polynomial(own, argument)
            rates = [
                w.along(part, rate, slope)
                for part, rate in zip(parts[:3], (values[1], values[2], third), strict=True)
            ]
            next_slope = w.along(w.polynomial(own, "%after")[0], later[1], after) if f.of_time else rates[0]
            for row, value in zip(f.rows, (*rates, w.value(0.0), next_slope), strict=True):
                w.out.append(f"  store double {value}, ptr {w.row(row + (k + 1) * layout.rows)}, align 8")
    return lane_loop("\n".join(w.out), width)


def resize(change: Trace, width: int, stride: int = 0) -> str:
    """``resize(S, C)``: the state as steps of another size have it; C has three rows: size, phase, and what
    is added to the count of events.
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
    """What a module says of its stack: vectors that are put aside do not straddle two cache lines.

    Who comes from outside has it aligned so.
    """
    if 8 * width <= STACK:
        return ""
    return f"""!llvm.module.flags = !{{!0}}
!0 = !{{i32 1, !"override-stack-alignment", i32 {8 * width}}}
"""


def operators(width: int) -> str:
    """Declarations of the operators that are no instructions."""
    w = Writer(width)
    return "\n".join(f"declare {w.number} @llvm.{name}.{w.suffix}({w.number})" for name in ("sqrt", "fabs"))
