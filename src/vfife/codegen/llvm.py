"""The straight-line step as text of LLVM's language: every operation of the trace is one instruction on vectors of W doubles, whatever W.

Row r of lane w lies at S[r W + w]. The text asks for no fused product and allows no reordering, so that every machine gives the same bits;
the same text becomes code of other processors, of graphics cards and of the web.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from importlib.resources import files

from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from .schedule import Line, Load, Store, Test, ordered, streamed, woven
from .straight_line import Function, functions, trace
from .trace import STEP_NUMBER, Operand, Operation, Trace, is_row, rows_used

BINARY = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv", "and": "and", "or": "or"}
ORDER = {">": "ogt", "<": "olt", ">=": "oge", "<=": "ole", "==": "oeq", "!=": "une"}
ROUNDING = 6755399441055744.0  # 1.5 2^52, added and taken off again
BLOCK = 400  # lines between two ends of a block
DRIVER = files(__package__).joinpath("driver.ll")


class Writer:
    """Instructions for W simulations side by side."""

    def __init__(self, width: int, truths: Iterable[str] = ()) -> None:
        self.width, self.truths = width, frozenset(truths)
        self.out: list[str] = []
        self.number = "double" if width == 1 else f"<{width} x double>"
        self.truth = "i1" if width == 1 else f"<{width} x i1>"
        self.suffix = "f64" if width == 1 else f"v{width}f64"
        self.constants: dict[str, str] = {}
        self.count = 0

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

    def row(self, row: int) -> str:
        """Address of a row."""
        return self.fresh(f"getelementptr double, ptr %S, i64 {row * self.width}")

    def load(self, row: int) -> None:
        """The row as it was."""
        self.out.append(f"  {self.value(f'v{row}')} = load {self.number}, ptr {self.row(row)}, align {8 * self.width}")

    def store(self, row: int, value: Operand) -> None:
        """A row is given a value."""
        self.out.append(f"  store {self.number} {self.value(value)}, ptr {self.row(row)}, align {8 * self.width}")

    def operation(self, operation: Operation) -> None:
        """One instruction; two for a rounding."""
        name, operator, operands = operation
        values = [self.value(o) for o in operands]
        if operator in BINARY:
            text = f"{BINARY[operator]} {self.kind(name)} {values[0]}, {values[1]}"
        elif operator in ORDER:
            text = f"fcmp {ORDER[operator]} {self.number} {values[0]}, {values[1]}"
        elif operator == "select":
            kind = self.kind(name)
            text = f"select {self.truth} {values[0]}, {kind} {values[1]}, {kind} {values[2]}"
        elif operator == "round":
            text = f"fsub {self.number} {self.fresh(f'fadd {self.number} {values[0]}, {self.value(ROUNDING)}')}, {self.value(ROUNDING)}"
        elif operator == "neg":
            text = f"fneg {self.number} {values[0]}"
        else:
            text = f"call {self.number} @llvm.{ {'sqrt': 'sqrt', 'abs': 'fabs'}[operator] }.{self.suffix}({self.number} {values[0]})"
        self.out.append(f"  {self.value(name)} = {text}")

    def begin(self, searching: bool) -> None:
        """Functions of time at the step, where there are any, and the number of the step in all lanes."""
        if searching:
            self.out.append("  call void @functions(ptr %S, ptr %T, i64 %stride, i64 %step)")
        if self.width == 1:
            self.out.append(f"  %{STEP_NUMBER} = sitofp i64 %step to double")
            return
        first = self.fresh(f"insertelement {self.number} poison, double {self.fresh('sitofp i64 %step to double')}, i64 0")
        self.out.append(f"  %{STEP_NUMBER} = shufflevector {self.number} {first}, {self.number} poison, <{self.width} x i32> zeroinitializer")

    def any(self, condition: Operand) -> str:
        """Whether a condition holds in any lane."""
        if self.width == 1:
            return self.value(condition)
        bits = self.fresh(f"bitcast {self.truth} {self.value(condition)} to i{self.width}")
        return self.fresh(f"icmp ne i{self.width} {bits}, 0")

    def lines(self, lines: Iterable[Line]) -> str:
        """Lines in their order; where the rare condition holds, the way goes to ``rare``. The name of the last block is returned.

        After ``BLOCK`` lines a block ends with a way out that is never taken: the time of compilation grows with the square of a block.
        """
        block, size = "body", 0
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
            elif isinstance(line, Store):
                self.store(line.row, line.value)
            elif isinstance(line, Test):
                block, size = "common", 0
                self.out += [f"  br i1 {self.any(line.condition)}, label %rare, label %common", "common:"]
        return block


class Lane(Writer):
    """Instructions for lane ``w`` of W alone; ``mark`` keeps names of one function apart from another's."""

    def __init__(self, lanes: int) -> None:
        super().__init__(1)
        self.lanes, self.mark = lanes, ""

    def value(self, operand: Operand) -> str:
        """An operand as it is written."""
        own = isinstance(operand, str) and (is_row(operand) or operand[1:].isdigit())
        return f"%{self.mark}{operand}" if own else super().value(operand)

    def row(self, row: int) -> str:
        """Address of a row in the lane."""
        return self.fresh(f"getelementptr double, ptr %S, i64 {self.fresh(f'add i64 %w, {row * self.lanes}')}")

    def polynomial(self, table: str, x: str) -> tuple[str, ...]:
        """Value and two derivatives of a table."""
        result = self.fresh(f"call {{ double, double, double }} @polynomial(ptr %T, i64 {table}, double {x})")
        return tuple(self.fresh(f"extractvalue {{ double, double, double }} {result}, {k}") for k in range(3))


def literal(x: float) -> str:
    """A constant by its bits."""
    return "0x%016X" % struct.unpack("<Q", struct.pack("<d", float(x)))[0]  # noqa: UP031


def lean(step: Trace, width: int, searching: bool) -> str:
    """``lean(S, T, stride, n0, count)``: steps until one that something rare wants; their number is returned."""
    w = Writer(width, step.truths)
    w.begin(searching)
    last = w.lines(woven(step, ordered(step)))
    rare = "rare:\n  %clean = sub i64 %step, %n0\n  ret i64 %clean\n" if step.rare else ""
    body = "\n".join(w.out)
    return f"""define internal i64 @lean(ptr noalias %S, ptr noalias %T, i64 %stride, i64 %n0, i64 %count) noinline {{
entry:
  %end = add i64 %n0, %count
  %going = icmp sgt i64 %count, 0
  br label %body
body:
  %step = phi i64 [ %n0, %entry ], [ %next, %{last} ]
{body}
  %next = add i64 %step, 1
  %more = icmp slt i64 %next, %end
  br i1 %more, label %body, label %done
done:
  ret i64 %count
never:
  ret i64 0
{rare}}}
"""


def whole(step: Trace, width: int, searching: bool) -> str:
    """``whole(S, T, stride, n)``: step n, whatever it wants. It is taken seldom, so no time is spent on making it fast."""
    w = Writer(width, step.truths)
    w.begin(searching)
    w.lines(woven(step, streamed(step)))
    body = "\n".join(w.out)
    return f"""define internal void @whole(ptr noalias %S, ptr noalias %T, i64 %stride, i64 %step) noinline optnone {{
  %going = icmp sge i64 %step, 0
{body}
  ret void
never:
  ret void
}}
"""


def searched(found: list[Function], width: int, step_row: int) -> str:
    """``functions(S, T, stride, n)``: functions at step n, lane by lane, as the data-driven loop has them."""
    w = Lane(width)
    dt = w.fresh(f"load double, ptr {w.row(step_row)}, align 8")
    w.out += [f"  %time = fmul double %nd, {dt}", f"  %after = fmul double %md, {dt}", f"  %ahead = select i1 %start, double 0.0, double {dt}"]
    for number, f in enumerate(found):
        w.mark = f"f{number}"
        for name in rows_used(f.operations):
            w.load(int(name[1:]))
        for operation in f.operations:
            w.operation(operation)
        table = w.fresh(f"add i64 %shift, {f.table}")
        values = w.polynomial(table, w.value(f.argument))
        values += (w.polynomial(table, "%after")[0] if f.of_time else values[0],)
        for row, value in zip(f.rows, values, strict=True):
            w.out.append(f"  store double {value}, ptr {w.row(row)}, align 8")
    body = "\n".join(w.out)
    return f"""define internal void @functions(ptr %S, ptr %T, i64 %stride, i64 %step) noinline {{
entry:
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


def written(topology: Topology, width: int) -> str:
    """Text of a module with ``advance``, which ``driver.ll`` describes."""
    w, found = Writer(width), functions(topology)
    return "\n".join(
        [
            *(f"declare {w.number} @llvm.{name}.{w.suffix}({w.number})" for name in ("sqrt", "fabs")),
            searched(found, width, Layout(topology).row("step")) if found else "",
            lean(trace(topology), width, bool(found)),
            whole(trace(topology, True), width, bool(found)),
            DRIVER.read_text().replace("WIDTH", str(width)).replace("NUMBER", w.number),
        ]
    )
