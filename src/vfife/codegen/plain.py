"""Plain functions as text of LLVM's language: what the kernels and laws are written in, and no more of Python.

That is numbers, integers, truths, tuples of them and arrays that are handed in; + - * / // %, comparisons, ``and``, ``or``, ``not``, conditional
expressions; ``abs``, ``min``, ``max``, ``int``, ``float``, ``len``, ``math.sqrt``, each other; ``if``, ``while``, ``for`` over a range, an array or
a tuple. A function is written once for all kinds of arguments that it is called with, as Python would run it: no operation is reordered or fused.
Indices are places from 0 on; what lies beyond the end of an array is not looked for.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from ..errors import SourceError
from .expressions import Expressions
from .values import TYPES, Array, Kind, Value, answered, members, types_of, wider

APART = ("step", "functions", "resize", "newton", "residual")  # called from several places: written into each, they would be compiled as often
DECLARED = "declare double @llvm.sqrt.f64(double)\ndeclare double @llvm.fabs.f64(double)\ndeclare i64 @llvm.abs.i64(i64, i1)\n"


class Module:
    """The functions of a text, and those that were written so far."""

    def __init__(self, text: str) -> None:
        self.trees: dict[str, ast.FunctionDef] = {}
        self.texts: list[str] = []
        self.known: dict[tuple[str, tuple[Kind, ...]], tuple[str, Kind | None] | None] = {}
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef):
                self.trees[node.name] = node
            elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and isinstance(node.value, ast.Name):
                self.trees[node.targets[0].id] = self.trees[node.value.id]
            else:
                raise SourceError(f"no function: {ast.unparse(node)}")

    def function(self, name: str, kinds: tuple[Kind, ...]) -> tuple[str, Kind | None]:
        """Name in LLVM's text of a function for arguments of these kinds, and the kind of its answer, None where there is none."""
        if (name, kinds) not in self.known:
            self.known[name, kinds] = None
            written = Function(self, name, kinds, f'"{name}.{len(self.known)}"')
            self.texts.append(written.text())
            self.known[name, kinds] = written.symbol, written.answer
        found = self.known[name, kinds]
        if found is None:
            raise SourceError(f"{name} calls itself")
        return found


def library_text(text: str, entries: dict[str, tuple[str, list[Kind]]]) -> str:
    """LLVM's text of several functions that return nothing, and of all that they call; by the names that they are called by from outside."""
    module, calls = Module(text), []
    for entry, (name, kinds) in entries.items():
        symbol, _ = module.function(name, tuple(kinds))
        places = [f"{one} {'noalias ' if one == 'ptr' else ''}%a{k}" for k, one in enumerate(one for kind in kinds for one in types_of(kind))]
        names = ", ".join(place.replace(" noalias", "") for place in places)
        calls.append(f"define void @{entry}({', '.join(places)}) {{\n  call void @{symbol}({names})\n  ret void\n}}\n")
    return "\n".join([DECLARED, *module.texts, *calls])


class Function(Expressions):
    """One function for one list of kinds. It is written again where a name turns out to hold a wider kind than its first value has."""

    def __init__(self, module: Module, name: str, kinds: tuple[Kind, ...], symbol: str) -> None:
        super().__init__(name)
        self.module, self.tree, self.kinds, self.symbol = module, module.trees[name], kinds, symbol
        self.held: dict[str, Kind] = {}
        self.answer: Kind | None = None
        while True:
            before = dict(self.held), self.answer
            self._write()
            if (self.held, self.answer) == before:
                return

    def text(self) -> str:
        """Its definition."""
        inlined = "noinline" if self.name in APART else "alwaysinline"
        answer = "void" if self.answer is None else answered(self.answer)
        return f"define internal {answer} @{self.symbol}({self.arguments}) {inlined} {{\nentry:\n" + "\n".join([*self.first, *self.out]) + "\n}\n"

    def _write(self) -> None:
        self.begin_anew()
        self.places: dict[str, Value] = {}
        self.bound: dict[str, Value] = {}  # arrays, which are never assigned again
        self.loops: list[tuple[str, str]] = []
        given = self.tree.args.args
        if len(given) != len(self.kinds):
            raise SourceError(f"{self.name} takes {len(given)} arguments and was given {len(self.kinds)}")
        apart, texts = self.name in APART, []
        for argument, kind in zip(given, self.kinds, strict=True):
            parts = []
            for one in types_of(kind):
                self.count += 1
                parts.append(f"%a{self.count}")
                texts.append(f"{one} {'noalias ' if one == 'ptr' and apart else ''}%a{self.count}")
            self.assign(argument.arg, Value(kind, tuple(parts)))
        self.arguments = ", ".join(texts)
        self.block(self.tree.body)
        if not self.ended:
            self.out.append("  ret void" if self.answer is None else "  unreachable")
        self.first.append(f"  br label %{self.label('start')}")
        self.out.insert(0, f"{self.first[-1].rpartition('%')[2]}:")

    def known(self, name: str, kinds: tuple[Kind, ...]) -> tuple[str, Kind | None] | None:
        """A function of the same text."""
        return self.module.function(name, kinds) if name in self.module.trees else None

    def block(self, statements: list[ast.stmt]) -> None:
        """Statements, up to one that leaves."""
        for statement in statements:
            if self.ended:
                return
            getattr(self, f"_{type(statement).__name__.lower()}", self._refused)(statement)

    def _pass(self, statement: ast.Pass) -> None:
        pass

    def _expr(self, statement: ast.Expr) -> None:
        if isinstance(statement.value, ast.Call):
            self.call(statement.value)

    def _assign(self, statement: ast.Assign) -> None:
        value = self.value(statement.value)
        for target in statement.targets:
            self.give(target, value)

    def _augassign(self, statement: ast.AugAssign) -> None:
        if isinstance(statement.target, ast.Subscript):
            item, place = self.place(statement.target)
            now = self.item(item, place)
            new = self.binary(statement, type(statement.op), now, self.value(statement.value))
            self.out.append(f"  store double {self.convert(new, 'd').parts[0]}, ptr {place}")
        else:
            read = ast.parse(ast.unparse(statement.target), mode="eval").body
            self.give(statement.target, self.binary(statement, type(statement.op), self.value(read), self.value(statement.value)))

    def give(self, target: ast.expr, value: Value) -> None:
        """Assigns to a name, an item of an array or several of these."""
        if isinstance(target, ast.Tuple):
            for one, part in zip(target.elts, members(value), strict=True):
                self.give(one, part)
        elif isinstance(target, ast.Subscript):
            item, place = self.place(target)
            if item != "d":
                self._refused(target)
            self.out.append(f"  store double {self.convert(value, 'd').parts[0]}, ptr {place}")
        elif isinstance(target, ast.Name):
            self.assign(target.id, value)
        else:
            self._refused(target)

    def assign(self, name: str, value: Value) -> None:
        """Gives a name a value."""
        if isinstance(value.kind, Array):
            if self.bound.setdefault(name, value) != value:
                raise SourceError(f"{self.name}: {name} stands for two arrays")
            return
        kind = self.held[name] = wider(self.held.get(name, value.kind), value.kind)
        if name not in self.places or self.places[name].kind != kind:
            self.places[name] = self.room(kind)
        self.store(self.places[name], value)

    def _if(self, statement: ast.If) -> None:
        yes, no, after = (self.label(name) for name in ("then", "else", "after"))
        self.fork(self.truth(statement.test), yes, no)
        left = []
        for label, statements in ((yes, statement.body), (no, statement.orelse)):
            self.begin(label)
            self.block(statements)
            left.append(self.ended)
            self.go(after)
        if all(left):
            return
        self.begin(after)

    def _while(self, statement: ast.While) -> None:
        again, body, after = (self.label(name) for name in ("while", "body", "done"))
        self.go(again)
        self.begin(again)
        self.fork(self.truth(statement.test), body, after)
        self.begin(body)
        self._body(statement, again, after)
        self.begin(after)

    def _body(self, statement: ast.While | ast.For, again: str, after: str) -> None:
        """The body of a loop; ``break`` goes to ``after``, ``continue`` and its end go ``again``."""
        if statement.orelse:
            self._refused(statement)
        self.loops.append((again, after))
        self.block(statement.body)
        self.loops.pop()
        self.go(again)

    def _break(self, statement: ast.Break) -> None:
        self.go(self.loops[-1][1])

    def _continue(self, statement: ast.Continue) -> None:
        self.go(self.loops[-1][0])

    def _for(self, statement: ast.For) -> None:
        """Counts in a place of its own: what the body does to the name changes nothing."""
        start, end, step, item = self._counted(statement)
        place = self.room("i")
        test, body, again, after = (self.label(name) for name in ("for", "body", "next", "done"))
        self.store(place, Value("i", (start,)))
        self.go(test)
        self.begin(test)
        now = self.load(place).parts[0]
        self.fork(self.fresh(f"icmp {'slt' if step > 0 else 'sgt'} i64 {now}, {end}"), body, after)
        self.begin(body)
        self.give(statement.target, item(now))
        self._body(statement, again, after)
        self.begin(again)
        self.store(place, Value("i", (self.fresh(f"add nsw i64 {now}, {step}"),)))
        self.go(test)
        self.begin(after)

    def _counted(self, statement: ast.For) -> tuple[str, str, int, Callable[[str], Value]]:
        """First number, end, step, and what the name of a loop is given at a number."""
        over = statement.iter
        if isinstance(over, ast.Call) and isinstance(over.func, ast.Name) and over.func.id == "range":
            first, *more = [self.integer(one) for one in over.args[:2]]
            step = int(ast.literal_eval(over.args[2])) if len(over.args) == 3 else 1
            return first if more else "0", more[0] if more else first, step, lambda now: Value("i", (now,))
        value = self.value(over)
        if isinstance(value.kind, Array) and value.kind.dimensions == 1:
            return "0", value.parts[1], 1, self._items(value.kind.item, value.parts[0])
        if not isinstance(value.kind, tuple) or value.kind not in (("i",) * len(value.kind), ("d",) * len(value.kind)):
            return self._refused(statement)  # type: ignore[no-any-return]
        kind, size = str(value.kind[0]), len(value.parts)
        self.count += 1
        space = f"%p{self.count}"
        self.first.append(f"  {space} = alloca [{size} x {TYPES[kind]}]")
        for k, part in enumerate(value.parts):
            self.out.append(f"  store {TYPES[kind]} {part}, ptr {self.fresh(f'getelementptr {TYPES[kind]}, ptr {space}, i64 {k}')}")
        return "0", str(size), 1, self._items(kind, space)

    def _items(self, kind: str, space: str) -> Callable[[str], Value]:
        """What gives the item at a number."""
        return lambda now: self.item(kind, self.fresh(f"getelementptr inbounds {TYPES[kind]}, ptr {space}, i64 {now}"))

    def _return(self, statement: ast.Return) -> None:
        self.ended = True
        if statement.value is None:
            self.out.append("  ret void")
            return
        value = self.value(statement.value)
        self.answer = value.kind if self.answer is None else wider(self.answer, value.kind)
        value = self.convert(value, self.answer)
        types = types_of(self.answer)
        whole = value.parts[0]
        if len(types) > 1:
            whole = "poison"
            for k, (one, part) in enumerate(zip(types, value.parts, strict=True)):
                whole = self.fresh(f"insertvalue {answered(self.answer)} {whole}, {one} {part}, {k}")
        self.out.append(f"  ret {answered(self.answer)} {whole}")
