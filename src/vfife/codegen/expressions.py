"""Expressions of plain functions, one instruction an operation, in Python's order."""

from __future__ import annotations

import ast

from ..errors import SourceError
from .blocks import Blocks
from .llvm import BINARY, ORDER, literal
from .values import TYPES, Array, Kind, Value, answered, joined, members, types_of, wider

INTEGER = {"+": "add nsw", "-": "sub nsw", "*": "mul nsw"}
SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARED = {ast.Gt: ">", ast.Lt: "<", ast.GtE: ">=", ast.LtE: "<=", ast.Eq: "==", ast.NotEq: "!="}
WHOLE = {">": "sgt", "<": "slt", ">=": "sge", "<=": "sle", "==": "eq", "!=": "ne"}


class Expressions(Blocks):
    """Writes expressions. Names have places in memory, arrays are what they were handed in as."""

    places: dict[str, Value]
    bound: dict[str, Value]

    def known(self, name: str, kinds: tuple[Kind, ...]) -> tuple[str, Kind | None] | None:
        """Name in LLVM's text of another function, and the kind of its answer; None where there is no such function."""
        raise NotImplementedError

    def truth(self, node: ast.expr) -> str:
        """Whether an expression holds."""
        value = self.value(node)
        if value.kind == "b":
            return value.parts[0]
        if value.kind == "i":
            return self.fresh(f"icmp ne i64 {value.parts[0]}, 0")
        return self.fresh(f"fcmp une double {self.convert(value, 'd').parts[0]}, {literal(0.0)}")

    def integer(self, node: ast.expr) -> str:
        """An expression that is an integer."""
        return self.convert(self.value(node), "i").parts[0]

    def value(self, node: ast.expr) -> Value:
        """What an expression gives."""
        return getattr(self, f"_{type(node).__name__.lower()}", self._refused)(node)  # type: ignore[no-any-return]

    def _constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, bool):
            return Value("b", ("true" if node.value else "false",))
        if isinstance(node.value, int):
            return Value("i", (str(node.value),))
        return Value("d", (literal(node.value),)) if isinstance(node.value, float) else self._refused(node)

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.bound:
            return self.bound[node.id]
        if node.id not in self.places:
            raise SourceError(f"{self.name}: {node.id} is used before it has a value")
        return self.load(self.places[node.id])

    def _tuple(self, node: ast.Tuple) -> Value:
        return joined([self.value(one) for one in node.elts])

    def _attribute(self, node: ast.Attribute) -> Value:
        value = self.value(node.value)
        if node.attr != "shape" or not isinstance(value.kind, Array):
            return self._refused(node)  # type: ignore[no-any-return]
        return Value(("i",) * value.kind.dimensions, value.parts[1:])

    def _subscript(self, node: ast.Subscript) -> Value:
        value = self.value(node.value) if not isinstance(node.value, ast.Name) or node.value.id not in self.bound else None
        if value is None or isinstance(value.kind, Array):
            return self.item(*self.place(node))
        return members(value)[int(ast.literal_eval(node.slice))]

    def place(self, node: ast.Subscript) -> tuple[str, str]:
        """Kind and address of an item of an array."""
        array = self.value(node.value)
        if not isinstance(array.kind, Array):
            return self._refused(node)  # type: ignore[no-any-return]
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(indices) != array.kind.dimensions or any(isinstance(one, ast.UnaryOp) for one in indices):  # -1 is no place here
            self._refused(node)
        where = self.integer(indices[0])
        for size, one in zip(array.parts[2:], indices[1:], strict=True):
            where = self.fresh(f"add nsw i64 {self.fresh(f'mul nsw i64 {where}, {size}')}, {self.integer(one)}")
        return array.kind.item, self.fresh(f"getelementptr inbounds {TYPES[array.kind.item]}, ptr {array.parts[0]}, i64 {where}")

    def item(self, kind: str, place: str) -> Value:
        """What lies at an address."""
        found = self.fresh(f"load {TYPES[kind]}, ptr {place}")
        return Value("i", (self.fresh(f"zext i32 {found} to i64"),)) if kind == "u" else Value(kind, (found,))

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value("b", (self.fresh(f"xor i1 {self.truth(node.operand)}, true"),))
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
            return self._constant(ast.Constant(-node.operand.value))  # type: ignore[operator]
        value = self.value(node.operand)
        if isinstance(node.op, ast.USub) and value.kind in ("i", "d"):
            return Value(value.kind, (self.fresh(f"sub nsw i64 0, {value.parts[0]}" if value.kind == "i" else f"fneg double {value.parts[0]}"),))
        return value if isinstance(node.op, ast.UAdd) else self._refused(node)

    def _binop(self, node: ast.BinOp) -> Value:
        return self.binary(node, type(node.op), self.value(node.left), self.value(node.right))

    def binary(self, node: ast.AST, operator: type[ast.operator], left: Value, right: Value) -> Value:
        """One operation on two numbers."""
        sign = SIGNS.get(operator)
        whole = left.kind != "d" and right.kind != "d" and sign != "/"
        a, b = (self.convert(one, "i" if whole else "d").parts[0] for one in (left, right))
        if sign is not None:
            return (
                Value("i", (self.fresh(f"{INTEGER[sign]} i64 {a}, {b}"),))
                if whole
                else Value("d", (self.fresh(f"{BINARY[sign]} double {a}, {b}"),))
            )
        if operator not in (ast.FloorDiv, ast.Mod) or not whole:
            self._refused(node)
        # Rounded down, as Python does; by zero it gives zero, for a processor would end the process.
        nothing = self.fresh(f"icmp eq i64 {b}, 0")
        by = self.fresh(f"select i1 {nothing}, i64 1, i64 {b}")
        quotient, rest = self.fresh(f"sdiv i64 {a}, {by}"), self.fresh(f"srem i64 {a}, {by}")
        left_over = self.fresh(f"icmp ne i64 {rest}, 0")
        opposite = self.fresh(f"icmp slt i64 {self.fresh(f'xor i64 {rest}, {by}')}, 0")
        off = self.fresh(f"and i1 {left_over}, {opposite}")
        less = self.fresh(f"add i64 {quotient}, -1") if operator is ast.FloorDiv else self.fresh(f"add i64 {rest}, {by}")
        found = self.fresh(f"select i1 {off}, i64 {less}, i64 {quotient if operator is ast.FloorDiv else rest}")
        return Value("i", (self.fresh(f"select i1 {nothing}, i64 0, i64 {found}"),))

    def _compare(self, node: ast.Compare) -> Value:
        left, found = self.value(node.left), ""
        for operator, other in zip(node.ops, node.comparators, strict=True):
            right = self.value(other)
            one = self.compared(COMPARED[type(operator)] if type(operator) in COMPARED else self._refused(node), left, right)
            found = self.fresh(f"and i1 {found}, {one}") if found else one
            left = right
        return Value("b", (found,))

    def compared(self, sign: str, left: Value, right: Value) -> str:
        """Whether two numbers compare so."""
        whole = left.kind != "d" and right.kind != "d"
        a, b = (self.convert(one, "i" if whole else "d").parts[0] for one in (left, right))
        return self.fresh(f"icmp {WHOLE[sign]} i64 {a}, {b}" if whole else f"fcmp {ORDER[sign]} double {a}, {b}")

    def _boolop(self, node: ast.BoolOp) -> Value:
        """The second is not looked at where the first decides: it may be beyond the end of an array."""
        place, after = self.room("b"), self.label("known")
        for k, one in enumerate(node.values):
            value = self.value(one)
            if value.kind != "b":
                self._refused(node)
            (truth,) = value.parts
            self.store(place, value)
            if k < len(node.values) - 1:
                more = self.label("more")
                self.fork(truth, *((more, after) if isinstance(node.op, ast.And) else (after, more)))
                self.begin(more)
        self.go(after)
        self.begin(after)
        return self.load(place)

    def _ifexp(self, node: ast.IfExp) -> Value:
        yes, no, after = (self.label(name) for name in ("yes", "no", "chosen"))
        self.fork(self.truth(node.test), yes, no)
        ends, values = [], []
        for label, arm in ((yes, node.body), (no, node.orelse)):
            self.begin(label)
            values.append(self.value(arm))
            ends.append(len(self.out))
            self.ended = False
        kind = wider(values[0].kind, values[1].kind)
        place = self.room(kind)
        tail = self.out[ends[0] :]
        del self.out[ends[0] :]
        self.store(place, values[0])
        self.go(after)
        self.out += tail
        self.ended = False
        self.store(place, values[1])
        self.go(after)
        self.begin(after)
        return self.load(place)

    def _call(self, node: ast.Call) -> Value:
        found = self.call(node)
        if found is None:
            raise SourceError(f"{self.name}: {ast.unparse(node.func)} returns nothing")
        return found

    def call(self, node: ast.Call) -> Value | None:
        """Calls a function; None where it returns nothing."""
        name, values = ast.unparse(node.func), [self.value(one) for one in node.args]
        if node.keywords:
            self._refused(node)
        found = self.known(name, tuple(value.kind for value in values))
        if found is not None:
            return self._called(*found, values)
        (kind, (one, *_)), *_ = values or [Value("b", ("",))]
        if name in ("min", "max"):
            return self._best(">" if name == "max" else "<", values)
        if name == "len" and not isinstance(kind, str):
            return Value("i", (values[0].parts[1] if isinstance(kind, Array) else str(len(kind)),))
        if name == "float":
            return self.convert(values[0], "d")
        if name == "int":
            return Value("i", (self.fresh(f"fptosi double {one} to i64"),)) if kind == "d" else self.convert(values[0], "i")
        if name == "abs" and kind == "i":
            return Value("i", (self.fresh(f"call i64 @llvm.abs.i64(i64 {one}, i1 false)"),))
        if name in ("abs", "math.sqrt"):
            number = self.convert(values[0], "d").parts[0]
            return Value("d", (self.fresh(f"call double @llvm.{'sqrt' if name == 'math.sqrt' else 'fabs'}.f64(double {number})"),))
        return self._refused(node)  # type: ignore[no-any-return]

    def _best(self, sign: str, values: list[Value]) -> Value:
        """The first of those that no other exceeds, as Python has it."""
        best = values[0]
        for value in values[1:]:
            kind = wider(best.kind, value.kind)
            best, other = self.convert(best, kind), self.convert(value, kind)
            better, (one,) = self.compared(sign, other, best), types_of(kind)
            best = Value(kind, (self.fresh(f"select i1 {better}, {one} {other.parts[0]}, {one} {best.parts[0]}"),))
        return best

    def _called(self, symbol: str, answer: Kind | None, values: list[Value]) -> Value | None:
        given = ", ".join(f"{one} {part}" for value in values for one, part in zip(types_of(value.kind), value.parts, strict=True))
        if answer is None:
            self.out.append(f"  call void @{symbol}({given})")
            return None
        whole, size = self.fresh(f"call {answered(answer)} @{symbol}({given})"), len(types_of(answer))
        if size == 1:
            return Value(answer, (whole,))
        return Value(answer, tuple(self.fresh(f"extractvalue {answered(answer)} {whole}, {k}") for k in range(size)))
