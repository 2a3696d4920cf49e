"""Expressions of plain functions in LLVM's language: one instruction for each operation, in Python's
order.
"""

from __future__ import annotations

import ast
from typing import NoReturn

from ...errors import SourceError
from .kinds import TYPES, Array, External, Kind, Value, answered, joined, members, named, types_of
from .llvm import BINARY, ORDER, Instructions, literal

INTEGER = {"+": "add nsw", "-": "sub nsw", "*": "mul nsw"}
SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARED = {ast.Gt: ">", ast.Lt: "<", ast.GtE: ">=", ast.LtE: "<=", ast.Eq: "==", ast.NotEq: "!="}
INTEGER_ORDER = {">": "sgt", "<": "slt", ">=": "sge", "<=": "sle", "==": "eq", "!=": "ne"}


TURNED = {">": "<", "<": ">", ">=": "<=", "<=": ">="}  # comparisons with exchanged sides


class Blocks(Instructions):
    """The growing text of a function: allocations in ``first``, everything else in ``out``.

    Allocations are at the entry: in a loop, each round would take more of the stack. ``ended`` says that the
    current block has its last instruction.
    """

    def __init__(self, name: str) -> None:
        super().__init__()
        self.name, self.line = name, 1
        self.first: list[str] = []
        self.ended = False

    def label(self, name: str) -> str:
        """Return a new name for a block."""
        self.count += 1
        return f"{name}{self.count}"

    def begin(self, label: str) -> None:
        """Begin a block."""
        self.out.append(f"{label}:")
        self.ended = False

    def go(self, label: str) -> None:
        """End the block with a jump, unless it has ended."""
        if not self.ended:
            self.out.append(f"  br label %{label}")
        self.ended = True

    def fork(self, truth: str, yes: str, no: str) -> None:
        """End the block with a conditional jump."""
        self.out.append(f"  br i1 {truth}, label %{yes}, label %{no}")
        self.ended = True

    def allocate(self, kind: Kind) -> Value:
        """Return places in memory for a value of this kind; LLVM turns them into registers."""
        names = []
        for part_type in types_of(kind):
            self.count += 1
            self.first.append(f"  %p{self.count} = alloca {part_type}")
            names.append(f"%p{self.count}")
        return Value(kind, tuple(names))

    def store(self, place: Value, value: Value) -> None:
        """Store a value in a place."""
        for part_type, address, part in zip(types_of(place.kind), place.parts, value.parts, strict=True):
            self.out.append(f"  store {part_type} {part}, ptr {address}")

    def load(self, place: Value) -> Value:
        """Load the value in a place."""
        parts = zip(types_of(place.kind), place.parts, strict=True)
        return Value(
            place.kind, tuple(self.fresh(f"load {part_type}, ptr {address}") for part_type, address in parts)
        )

    def common_kind(self, node: ast.AST, first: Kind, second: Kind) -> Kind:
        """Return the kind of two values, which must be the same: 0 is not 0.0, whose negative has a sign."""
        if first != second:
            self.refuse(
                node,
                f"one is {named(first)}, the other {named(second)}; write both as one kind, such as 0.0"
                " for 0",
            )
        return first

    def refuse(self, node: ast.AST, reason: str) -> NoReturn:
        """Raise SourceError with function, line, the text of the line, and the reason why it cannot be
        translated exactly.
        """
        line = getattr(node, "lineno", self.line) - self.line + 1
        raise SourceError(f"{self.name}, line {line}: {ast.unparse(node).splitlines()[0]!r}: {reason}")

    def _unknown(self, node: ast.AST) -> NoReturn:
        self.refuse(node, "this is no part of the language that is compiled")


class Expressions(Blocks):
    """Write expressions. ``places`` are the places in memory of names, ``bound`` the arrays by name."""

    places: dict[str, Value]
    bound: dict[str, Value]
    assigned: set[str]  # names that have a value on every way to here

    def resolve(
        self, node: ast.AST, name: str, kinds: tuple[Kind, ...]
    ) -> tuple[str, Kind | None] | External | None:
        """Return the name in LLVM's text of another function and the kind of its answer, or None if there is
        no such function.
        """
        raise NotImplementedError

    def truth(self, node: ast.expr) -> str:
        """Write an expression as a truth value; an integer is true if it is not zero."""
        value = self.value(node)
        if value.kind == "b":
            return value.parts[0]
        if value.kind == "i":
            return self.fresh(f"icmp ne i64 {value.parts[0]}, 0")
        return self.refuse(node, f"{named(value.kind)} is no condition; write a comparison")

    def integer(self, node: ast.expr) -> str:
        """Write an expression that must be an integer."""
        value = self.value(node)
        return (
            value.parts[0]
            if value.kind == "i"
            else self.refuse(node, f"this is {named(value.kind)}, and an integer is needed")
        )

    def number(self, node: ast.AST, value: Value) -> str:
        """Return a value as a double; an integer is converted as in Python, rounded beyond 2^53."""
        part, *_ = value.parts
        if value.kind == "i":
            return (
                literal(float(part))
                if part.lstrip("-").isdigit()
                else self.fresh(f"sitofp i64 {part} to double")
            )
        return (
            part
            if value.kind == "d"
            else self.refuse(node, f"this is {named(value.kind)}, and a number is needed")
        )

    def value(self, node: ast.expr) -> Value:
        """Write an expression; return its value."""
        return getattr(self, f"_{type(node).__name__.lower()}", self._unknown)(node)  # type: ignore[no-any-return]

    def _constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, bool):
            return Value("b", ("true" if node.value else "false",))
        if isinstance(node.value, int):
            if abs(node.value) >= 1 << 63:
                self.refuse(node, "an integer has 64 bits")
            return Value("i", (str(node.value),))
        return Value("d", (literal(node.value),)) if isinstance(node.value, float) else self._unknown(node)

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.bound:
            return self.bound[node.id]
        if node.id not in self.assigned:
            self.refuse(node, f"{node.id} may be used before it has a value")
        return self.load(self.places[node.id])

    def _tuple(self, node: ast.Tuple) -> Value:
        return joined([self.value(element) for element in node.elts])

    def _attribute(self, node: ast.Attribute) -> Value:
        value = self.value(node.value)
        if node.attr != "shape" or not isinstance(value.kind, Array):
            self._unknown(node)
        return Value(("i",) * value.kind.dimensions, value.parts[1:])

    def _subscript(self, node: ast.Subscript) -> Value:
        value = self.value(node.value)
        if isinstance(value.kind, Array):
            return self.item(*self.place(node, value))
        parts, at = members(value), node.slice
        index = written(at)
        if not parts or index is None or not -len(parts) <= index < len(parts):
            self.refuse(node, "of a tuple one item is taken, by a number that is written there")
        return parts[index]

    def place(self, node: ast.Subscript, array: Value) -> tuple[str, str]:
        """Return kind and address of an item of an array, whose items lie row by row."""
        if not isinstance(array.kind, Array):
            self.refuse(node, "this is no array")
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(indices) != array.kind.dimensions:
            self.refuse(node, f"this array has {array.kind.dimensions} dimensions")
        if any(isinstance(index, ast.UnaryOp) for index in indices):
            self.refuse(node, "an index counts from 0 on; -1 is not the last item")
        offset = self.integer(indices[0])
        for size, index in zip(array.parts[2:], indices[1:], strict=True):
            offset = self.fresh(
                f"add nsw i64 {self.fresh(f'mul nsw i64 {offset}, {size}')}, {self.integer(index)}"
            )
        return array.kind.item, self.fresh(
            f"getelementptr inbounds {TYPES[array.kind.item]}, ptr {array.parts[0]}, i64 {offset}"
        )

    def item(self, kind: str, place: str) -> Value:
        """Load the item at an address."""
        result = self.fresh(f"load {TYPES[kind]}, ptr {place}")
        if kind == "u":
            return Value("i", (self.fresh(f"zext i32 {result} to i64"),))
        return Value("i" if kind == "l" else kind, (result,))

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value("b", (self.fresh(f"xor i1 {self.truth(node.operand)}, true"),))
        if (
            isinstance(node.op, ast.USub)
            and isinstance(node.operand, ast.Constant)
            and type(node.operand.value) in (int, float)
        ):
            return self._constant(ast.copy_location(ast.Constant(-node.operand.value), node))  # type: ignore[operator]
        value = self.value(node.operand)
        if value.kind not in ("i", "d") or not isinstance(node.op, ast.USub | ast.UAdd):
            self.refuse(node, f"this is no sign of {named(value.kind)}")
        if isinstance(node.op, ast.UAdd):
            return value
        return Value(
            value.kind,
            (
                self.fresh(
                    f"sub nsw i64 0, {value.parts[0]}"
                    if value.kind == "i"
                    else f"fneg double {value.parts[0]}"
                ),
            ),
        )

    def _binop(self, node: ast.BinOp) -> Value:
        return self.binary(node, node.op, self.value(node.left), self.value(node.right), node.right)

    def binary(
        self, node: ast.AST, operator: ast.operator, left: Value, right: Value, divisor: ast.expr
    ) -> Value:
        """Write one operation on two numbers; an integer is converted if the other is a double, as in Python.

        ``divisor`` is the right operand as it is written, by which // and % are accepted.
        """
        sign = SIGNS.get(type(operator))
        integers = left.kind == right.kind == "i"
        if sign is not None and integers and sign != "/":
            return Value("i", (self.fresh(f"{INTEGER[sign]} i64 {left.parts[0]}, {right.parts[0]}"),))
        if sign is not None:
            return Value(
                "d",
                (self.fresh(f"{BINARY[sign]} double {self.number(node, left)}, {self.number(node, right)}"),),
            )
        if not isinstance(operator, ast.FloorDiv | ast.Mod):
            self._unknown(node)
        if not integers or not positive(divisor):
            self.refuse(
                node,
                "// and % are of integers, by one that is written there or by max(..., 1), so that it is"
                " above zero",
            )
        # Rounded down, as Python does, where LLVM rounds towards zero.
        a, b = left.parts[0], right.parts[0]
        quotient, remainder = self.fresh(f"sdiv i64 {a}, {b}"), self.fresh(f"srem i64 {a}, {b}")
        negative = self.fresh(f"icmp slt i64 {remainder}, 0")
        result, alternative = (
            (quotient, f"add i64 {quotient}, -1")
            if isinstance(operator, ast.FloorDiv)
            else (remainder, f"add i64 {remainder}, {b}")
        )
        return Value("i", (self.fresh(f"select i1 {negative}, i64 {self.fresh(alternative)}, i64 {result}"),))

    def _compare(self, node: ast.Compare) -> Value:
        """Write a comparison or a chain of them. Python skips the rest of a chain after one that fails; here
        all are computed, so the rest must be names, numbers or lengths.
        """
        left, result = self.value(node.left), ""
        for k, (operator, operand) in enumerate(zip(node.ops, node.comparators, strict=True)):
            if k and not isinstance(operand, ast.Name | ast.Constant) and not _length(operand):
                self.refuse(node, "the last part of a chain is a name or a number; write `a < b and b < c`")
            right = self.value(operand)
            comparison = self.compared(
                node,
                COMPARED[type(operator)] if type(operator) in COMPARED else self._unknown(node),
                left,
                right,
            )
            result = self.fresh(f"and i1 {result}, {comparison}") if result else comparison
            left = right
        return Value("b", (result,))

    def compared(self, node: ast.AST, sign: str, left: Value, right: Value) -> str:
        """Write one comparison of two numbers or truth values."""
        if left.kind == right.kind and left.kind in ("b", "i"):
            if left.kind == "b" and sign not in ("==", "!="):
                self.refuse(node, "truths are equal or not, and neither is the larger")
            return self.fresh(
                f"icmp {INTEGER_ORDER[sign]} {TYPES[str(left.kind)]} {left.parts[0]}, {right.parts[0]}"
            )
        if left.kind == "d" and right.kind == "i":
            return self.compared(node, TURNED.get(sign, sign), right, left)
        if left.kind == "i" and right.kind == "d" and not small(left):
            return self._exactly(sign, left.parts[0], right.parts[0])
        return self.fresh(f"fcmp {ORDER[sign]} double {self.number(node, left)}, {self.number(node, right)}")

    def _exactly(self, sign: str, integers: str, number: str) -> str:
        """Write the comparison of an integer and a double, exact beyond 2^53 as in Python: if the integer
        rounds to the double, the integer value of that double decides.
        """
        rounded = self.fresh(f"sitofp i64 {integers} to double")
        back = self.fresh(f"call i64 @llvm.fptosi.sat.i64.f64(double {rounded})")
        equal = self.fresh(f"fcmp oeq double {rounded}, {number}")
        tie = self.fresh(f"icmp {INTEGER_ORDER[sign]} i64 {integers}, {back}")
        if sign == "!=":
            return self.fresh(f"or i1 {self.fresh(f'xor i1 {equal}, true')}, {tie}")
        exact = self.fresh(f"and i1 {equal}, {tie}")
        return (
            exact
            if sign == "=="
            else self.fresh(
                f"or i1 {exact}, {self.fresh(f'fcmp {ORDER[sign[0]]} double {rounded}, {number}')}"
            )
        )

    def _boolop(self, node: ast.BoolOp) -> Value:
        """Write ``and`` or ``or`` with jumps: the second operand must not be computed if the first decides,
        because it may read beyond the end of an array.
        """
        place, end = self.allocate("b"), self.label("known")
        for k, operand in enumerate(node.values):
            value = self.value(operand)
            if value.kind != "b":
                self.refuse(
                    node, f"`and` and `or` take truths, and {ast.unparse(operand)} is {named(value.kind)}"
                )
            (truth,) = value.parts
            self.store(place, value)
            if k < len(node.values) - 1:
                following = self.label("more")
                self.fork(truth, *((following, end) if isinstance(node.op, ast.And) else (end, following)))
                self.begin(following)
        self.go(end)
        self.begin(end)
        return self.load(place)

    def _ifexp(self, node: ast.IfExp) -> Value:
        yes, no, end = (self.label(name) for name in ("yes", "no", "chosen"))
        self.fork(self.truth(node.test), yes, no)
        # Both arms are written before their common place is made, because its kind is known only then. The
        # second arm is cut off, the end of the first is completed, and the second is added again.
        ends, values = [], []
        for label, arm in ((yes, node.body), (no, node.orelse)):
            self.begin(label)
            values.append(self.value(arm))
            ends.append(len(self.out))
            self.ended = False
        place = self.allocate(self.common_kind(node, values[0].kind, values[1].kind))
        tail = self.out[ends[0] :]
        del self.out[ends[0] :]
        self.store(place, values[0])
        self.go(end)
        self.out += tail
        self.ended = False
        self.store(place, values[1])
        self.go(end)
        self.begin(end)
        return self.load(place)

    def _call(self, node: ast.Call) -> Value:
        result = self.call(node)
        return result if result is not None else self.refuse(node, "this function returns nothing")

    def call(self, node: ast.Call) -> Value | None:
        """Write the call of a function; return its answer, None without one."""
        name = ast.unparse(node.func)
        if node.keywords:
            self.refuse(node, "arguments are given by their place, not by name")
        values = [self.value(argument) for argument in node.args]
        arguments = [
            f"{part_type} {part}"
            for value in values
            for part_type, part in zip(types_of(value.kind), value.parts, strict=True)
        ]
        result = self.resolve(node, name, tuple(value.kind for value in values))
        if isinstance(result, External):
            return self._called(name, result.answer, [arguments[k] for k in result.passed])
        if result is not None:
            return self._called(*result, arguments)
        if name in ("min", "max") and len(values) > 1:
            return self._best(node, ">" if name == "max" else "<", values)
        if name not in ("len", "float", "int", "abs", "math.sqrt") or len(values) != 1:
            self.refuse(node, "no such function, or not with so many arguments")
        return self._builtin(node, name, values[0])

    def _builtin(self, node: ast.Call, name: str, value: Value) -> Value:
        """Write the call of one of Python's functions of one argument."""
        kind, part = value.kind, value.parts[0] if value.parts else ""
        if name == "len":
            if isinstance(kind, str):
                self.refuse(node, f"{named(kind)} has no length")
            return Value("i", (value.parts[1] if isinstance(kind, Array) else str(len(kind)),))
        if name in ("float", "int") and kind == "b":
            return (
                Value("d", (self.fresh(f"uitofp i1 {part} to double"),))
                if name == "float"
                else Value("i", (self.fresh(f"zext i1 {part} to i64"),))
            )
        if name == "int" and kind == "d":
            return Value("i", (self.fresh(f"call i64 @llvm.fptosi.sat.i64.f64(double {part})"),))
        if name == "abs" and kind == "i":
            return Value("i", (self.fresh(f"call i64 @llvm.abs.i64(i64 {part}, i1 false)"),))
        if name == "int" and kind == "i":
            return value
        number = self.number(node, value)
        if name == "float":
            return Value("d", (number,))
        return Value(
            "d",
            (
                self.fresh(
                    f"call double @llvm.{'sqrt' if name == 'math.sqrt' else 'fabs'}.f64(double {number})"
                ),
            ),
        )

    def _best(self, node: ast.AST, sign: str, values: list[Value]) -> Value:
        """Write ``min`` or ``max``: the first of equal values, and never NaN after a number, as in Python."""
        best = values[0]
        for candidate in values[1:]:
            kind = self.common_kind(node, best.kind, candidate.kind)
            better, (part_type,) = self.compared(node, sign, candidate, best), types_of(kind)
            best = Value(
                kind,
                (
                    self.fresh(
                        f"select i1 {better}, {part_type} {candidate.parts[0]}, {part_type} {best.parts[0]}"
                    ),
                ),
            )
        return best

    def _called(self, symbol: str, answer: Kind | None, arguments: list[str]) -> Value | None:
        call = f"@{symbol}({', '.join(arguments)})"
        if answer is None:
            self.out.append(f"  call void {call}")
            return None
        kind, size = answered(answer), len(types_of(answer))
        result = self.fresh(f"call {kind} {call}")
        if size == 1:
            return Value(answer, (result,))
        return Value(answer, tuple(self.fresh(f"extractvalue {kind} {result}, {k}") for k in range(size)))


def positive(node: ast.expr) -> bool:
    """Return whether an expression is visibly a positive integer: a number, or max(..., 1)."""
    if isinstance(node, ast.Call) and ast.unparse(node.func) == "max":
        return any(isinstance(argument, ast.Constant) and positive(argument) for argument in node.args)
    return isinstance(node, ast.Constant) and type(node.value) is int and node.value > 0


def written(node: ast.expr) -> int | None:
    """Return the value of an integer literal with its sign; None for any other expression."""
    sign = -1 if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) else 1
    constant = node.operand if isinstance(node, ast.UnaryOp) else node
    return (
        sign * constant.value if isinstance(constant, ast.Constant) and type(constant.value) is int else None
    )


def small(value: Value) -> bool:
    """Return whether a value is an integer literal that a double represents exactly."""
    return value.parts[0].lstrip("-").isdigit() and abs(int(value.parts[0])) <= 1 << 53


def _length(node: ast.expr) -> bool:
    return isinstance(node, ast.Call) and ast.unparse(node.func) == "len"
