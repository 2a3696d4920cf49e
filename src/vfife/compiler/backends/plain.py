"""Translate plain functions to LLVM's language: the small part of Python in which kernels and laws are
written.

**The language.** Doubles, integers, truth values, tuples of these, and arrays that are arguments; + - * / //
%, comparisons, ``and``, ``or``, ``not``, conditional expressions; ``abs``, ``min``, ``max``, ``int``,
``float``, ``len``, ``math.sqrt``, and calls of each other; ``if``, ``while``, ``for`` over a range, an array
or a tuple. A function is written once for each list of kinds of arguments with which it is called. It
computes what Python computes: no operation is reordered or fused.

**What is refused**, with the line and the reason, because it would not be translated exactly: a name, the
arms of a condition or the returns of a function with several kinds; a name that may have no value; // and %
by a number that may be zero; the same array as two arguments; recursion.

**What is not checked**, because it depends on data: an index is not compared with the size of its array,
integers have 64 bits, and a division by zero or the root of a negative number gives infinity or NaN where
Python raises.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from ...errors import SourceError
from .expressions import Expressions, written
from .kinds import TYPES, Array, External, Kind, Value, answered, members, named, types_of

# Functions that are called from several places and are long: inlined, they would be compiled as often.
NOINLINE = (
    "step",
    "functions",
    "resize",
    "newton",
    "residual",
    "fast_steps",
    "full_step",
    "event",
    "displace",
    "sound_lanes",
    "polynomial",
)
DECLARED = (
    "declare double @llvm.sqrt.f64(double)\ndeclare double @llvm.fabs.f64(double)\ndeclare i64"
    " @llvm.abs.i64(i64, i1)\n"
)
DECLARED += "declare i64 @llvm.fptosi.sat.i64.f64(double)\n"


class Module:
    """The functions of a text, and those that are written so far.

    ``external`` are functions of other modules, which take precedence over its own; ``attributes`` are added
    to every function.
    """

    def __init__(self, text: str, external: dict[str, External] | None = None, attributes: str = "") -> None:
        self.external, self.attributes = external or {}, attributes
        self.trees: dict[str, ast.FunctionDef] = {}
        self.texts: list[str] = []
        self.known: dict[tuple[str, tuple[Kind, ...]], tuple[str, Kind | None]] = {}
        self.under_way: list[str] = []
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef):
                self.trees[node.name] = node
            elif (
                isinstance(node, ast.Assign)
                and isinstance(node.targets[0], ast.Name)
                and isinstance(node.value, ast.Name)
            ):
                self.trees[node.targets[0].id] = self.trees[node.value.id]
            else:
                raise SourceError(f"line {node.lineno}: no function: {ast.unparse(node)}")

    def function(self, name: str, kinds: tuple[Kind, ...]) -> tuple[str, Kind | None]:
        """Return the name in LLVM's text of a function for arguments of these kinds, and the kind of its
        answer, None without one; write the function if that has not been done.
        """
        if name in self.under_way:
            raise SourceError(f"{name} calls itself")
        if (name, kinds) not in self.known:
            self.under_way.append(name)
            function = Function(self, name, kinds, f'"{name}.{len(self.known) + len(self.under_way)}"')
            self.under_way.pop()
            self.texts.append(function.text())
            self.known[name, kinds] = function.symbol, function.answer
        return self.known[name, kinds]


def library_text(
    text: str,
    entries: dict[str, tuple[str, tuple[Kind, ...]]],
    external: dict[str, External] | None = None,
    attributes: str = "",
) -> str:
    """Return LLVM's text of several functions and of all that they call.

    ``entries`` maps the names by which they are called from outside to their names in ``text`` and the kinds
    of their arguments.
    """
    module, calls = Module(text, external, attributes), []
    for entry, (name, kinds) in entries.items():
        symbol, kind = module.function(name, kinds)
        places = [
            f"{part_type} {'noalias ' if part_type == 'ptr' else ''}%a{k}"
            for k, part_type in enumerate(types_of(kinds))
        ]
        answer = "void" if kind is None else answered(kind)
        names = ", ".join(place.replace(" noalias", "") for place in places)
        parameters, back = ("", "void") if kind is None else ("%x = ", f"{answer} %x")
        head = f'define {answer} @{entry}({", ".join(places)}) "stackrealign" {attributes}'
        calls.append(f"{head} {{\n  {parameters}call {answer} @{symbol}({names})\n  ret {back}\n}}\n")
    return "\n".join(
        [
            DECLARED,
            *(external_function.declared(name) for name, external_function in module.external.items()),
            *module.texts,
            *calls,
        ]
    )


class Function(Expressions):
    """The text of one function for one list of kinds.

    Names have places in memory (``alloca``), which LLVM turns into registers: no phi has to be placed here.
    ``assigned`` are the names that have a value on every path to the current line.
    """

    def __init__(self, module: Module, name: str, kinds: tuple[Kind, ...], symbol: str) -> None:
        super().__init__(name)
        self.module, self.tree, self.kinds, self.symbol = module, module.trees[name], kinds, symbol
        self.line = self.tree.lineno
        self.answer: Kind | None = None
        self.returns: list[str] = []
        self._write()

    def text(self) -> str:
        """Return the definition of the function."""
        inlined = "noinline" if self.name in NOINLINE else "alwaysinline"
        answer = "void" if self.answer is None else answered(self.answer)
        return (
            f"define internal {answer} @{self.symbol}({self.arguments}) {inlined} {self.module.attributes}"
            " {\nentry:\n" + "\n".join([*self.first, *self.out]) + "\n}\n"
        )

    def _write(self) -> None:
        self.places: dict[str, Value] = {}
        self.bound: dict[str, Value] = {}  # arrays, which are never assigned again
        self.loops: list[tuple[str, str]] = []
        self.assigned: set[str] = set()
        parameters, form = self.tree.args.args, self.tree.args
        if form.vararg or form.kwarg or form.kwonlyargs or form.posonlyargs or form.defaults:
            self.refuse(form, "a function takes plain arguments without defaults")
        if len(parameters) != len(self.kinds):
            self.refuse(
                form, f"{self.name} takes {len(parameters)} arguments and was given {len(self.kinds)}"
            )
        separate, texts = self.name in NOINLINE, []
        for argument, kind in zip(parameters, self.kinds, strict=True):
            parts = []
            for part_type in types_of(kind):
                self.count += 1
                parts.append(f"%a{self.count}")
                texts.append(
                    f"{part_type} {'noalias ' if part_type == 'ptr' and separate else ''}%a{self.count}"
                )
            self.assign(argument, argument.arg, Value(kind, tuple(parts)))
        self.arguments = ", ".join(texts)
        self.block(self.tree.body)
        if not self.ended:
            if self.answer is not None:
                self.refuse(
                    self.tree.body[-1],
                    "behind this line the function ends without the value that it returns elsewhere",
                )
            self.out.append("  ret void")
        self.first.append(f"  br label %{self.label('start')}")
        self.out.insert(0, f"{self.first[-1].rpartition('%')[2]}:")

    def resolve(
        self, node: ast.AST, name: str, kinds: tuple[Kind, ...]
    ) -> tuple[str, Kind | None] | External | None:
        """Return a function of another module, or name and answer of one of the same text; None if there is
        no function of this name.
        """
        external = self.module.external.get(name)
        if external is not None:
            if kinds != external.kinds:
                self.refuse(node, f"{name} takes {named(external.kinds)} and was given {named(kinds)}")
            return external
        if name not in self.module.trees:
            return None
        arrays = [
            ast.unparse(argument)
            for argument, kind in zip(getattr(node, "args", []), kinds, strict=True)
            if isinstance(kind, Array)
        ]
        if name in NOINLINE and len(set(arrays)) < len(arrays):
            self.refuse(
                node,
                "the same array is given twice, and the function is compiled for arrays that do not overlap",
            )
        return self.module.function(name, kinds)

    def block(self, statements: list[ast.stmt]) -> None:
        """Write statements up to one that leaves the block."""
        for statement in statements:
            if self.ended:
                return
            getattr(self, f"_{type(statement).__name__.lower()}", self._unknown)(statement)

    def _pass(self, statement: ast.Pass) -> None:
        pass

    def _expr(self, statement: ast.Expr) -> None:
        if isinstance(statement.value, ast.Call):
            self.call(statement.value)
        elif not isinstance(statement.value, ast.Constant):
            self.refuse(statement, "this line has no effect")

    def _assign(self, statement: ast.Assign) -> None:
        value = self.value(statement.value)
        for target in statement.targets:
            self.give(target, value)

    def _augassign(self, statement: ast.AugAssign) -> None:
        if isinstance(statement.target, ast.Subscript):
            item, place = self.place(statement.target, self.value(statement.target.value))
            current = self.item(item, place)
            self.put(
                statement,
                item,
                place,
                self.binary(statement, statement.op, current, self.value(statement.value), statement.value),
            )
        else:
            read = ast.copy_location(ast.parse(ast.unparse(statement.target), mode="eval").body, statement)
            current = self.value(read)
            self.give(
                statement.target,
                self.binary(statement, statement.op, current, self.value(statement.value), statement.value),
            )

    def give(self, target: ast.expr, value: Value) -> None:
        """Assign a value to a name, an item of an array, or a tuple of these."""
        if isinstance(target, ast.Tuple):
            parts = members(value)
            if len(parts) != len(target.elts):
                self.refuse(target, f"{len(target.elts)} names are given {named(value.kind)}")
            for element, part in zip(target.elts, parts, strict=True):
                self.give(element, part)
        elif isinstance(target, ast.Subscript):
            self.put(target, *self.place(target, self.value(target.value)), value)
        elif isinstance(target, ast.Name):
            self.assign(target, target.id, value)
        else:
            self._unknown(target)

    def put(self, node: ast.AST, item: str, place: str, value: Value) -> None:
        """Store an item of an array; an integer in an array of doubles becomes a double, as in numpy."""
        if item == "l" and value.kind == "i":
            self.out.append(f"  store i64 {value.parts[0]}, ptr {place}")
        elif item != "d":
            self.refuse(
                node, f"{named(value.kind)} is put into an array of {'unsigned ' * (item == 'u')}integers"
            )
        else:
            self.out.append(f"  store double {self.number(node, value)}, ptr {place}")

    def assign(self, node: ast.AST, name: str, value: Value) -> None:
        """Assign a value to a name. An array is bound once and for all: its address is not stored."""
        if isinstance(value.kind, Array) or (
            isinstance(value.kind, tuple) and any(isinstance(member, Array) for member in value.kind)
        ):
            if self.bound.setdefault(name, value) != value or name in self.places:
                self.refuse(node, f"{name} stands for two arrays")
            return
        if name in self.bound:
            self.refuse(node, f"{name} is an array")
        if name not in self.places:
            self.places[name] = self.allocate(value.kind)
        self.common_kind(node, self.places[name].kind, value.kind)
        self.store(self.places[name], value)
        self.assigned.add(name)

    def _if(self, statement: ast.If) -> None:
        yes, no, end = (self.label(name) for name in ("then", "else", "after"))
        self.fork(self.truth(statement.test), yes, no)
        outer_names, parameters = set(self.assigned), []
        for label, statements in ((yes, statement.body), (no, statement.orelse)):
            self.assigned = set(outer_names)
            self.begin(label)
            self.block(statements)
            parameters += [] if self.ended else [self.assigned]
            self.go(end)
        if parameters:
            self.assigned = set.intersection(*parameters)
            self.begin(end)

    def _while(self, statement: ast.While) -> None:
        head, body, end = (self.label(name) for name in ("while", "body", "done"))
        self.go(head)
        self.begin(head)
        self.fork(self.truth(statement.test), body, end)
        self.begin(body)
        outer_names = set(self.assigned)
        self._body(statement, head, end)
        self.assigned = outer_names
        self.begin(end)

    def _body(self, statement: ast.While | ast.For, head: str, end: str) -> None:
        """Write the body of a loop; ``break`` goes to ``end``, ``continue`` and its end go to ``head``."""
        if statement.orelse:
            self.refuse(statement, "a loop has no else")
        self.loops.append((head, end))
        self.block(statement.body)
        self.loops.pop()
        self.go(head)

    def _break(self, statement: ast.Break) -> None:
        self.go(self.loops[-1][1])

    def _continue(self, statement: ast.Continue) -> None:
        self.go(self.loops[-1][0])

    def _for(self, statement: ast.For) -> None:
        """Write a loop that counts in a place of its own: as in Python, the body may change the loop's name
        without changing the number of rounds.
        """
        start, end, step, item = self._counted(statement)
        place = self.allocate("i")
        test, body, advance, finish = (self.label(name) for name in ("for", "body", "next", "done"))
        self.store(place, Value("i", (start,)))
        self.go(test)
        self.begin(test)
        index = self.load(place).parts[0]
        self.fork(self.fresh(f"icmp {'slt' if step > 0 else 'sgt'} i64 {index}, {end}"), body, finish)
        self.begin(body)
        outer_names = set(self.assigned)
        self.give(statement.target, item(index))
        self._body(statement, advance, finish)
        # Names assigned in the body have values after the loop only if it has at least one round, and no
        # break or continue can skip the assignments.
        turns = _digits(start) and _digits(end) and len(range(int(start), int(end), step)) > 0
        self.assigned = (
            self.assigned
            if turns and not any(isinstance(node, ast.Break | ast.Continue) for node in ast.walk(statement))
            else outer_names
        )
        self.begin(advance)
        self.store(place, Value("i", (self.fresh(f"add nsw i64 {index}, {step}"),)))
        self.go(test)
        self.begin(finish)

    def _counted(self, statement: ast.For) -> tuple[str, str, int, Callable[[str], Value]]:
        """Return first number, end and step of a loop, and a function from the number of a round to the value
        of the loop's name.
        """
        sequence = statement.iter
        if (
            isinstance(sequence, ast.Call)
            and isinstance(sequence.func, ast.Name)
            and sequence.func.id == "range"
        ):
            if sequence.keywords or not 1 <= len(sequence.args) <= 3:
                self.refuse(sequence, "a range has one to three arguments")
            first, *ends = [self.integer(bound) for bound in sequence.args[:2]]
            step = written(sequence.args[2]) if len(sequence.args) == 3 else 1
            if not step:
                return self.refuse(
                    sequence, "the step of a range is an integer that is written there, and not 0"
                )
            return (
                first if ends else "0",
                ends[0] if ends else first,
                step,
                lambda index: Value("i", (index,)),
            )
        value = self.value(sequence)
        if isinstance(value.kind, Array) and value.kind.dimensions == 1:
            return "0", value.parts[1], 1, self._items(value.kind.item, value.parts[0])
        if not isinstance(value.kind, tuple) or value.kind not in (
            ("i",) * len(value.kind),
            ("d",) * len(value.kind),
        ):
            self.refuse(statement, f"{named(value.kind)} is nothing to go through")
        # A tuple of numbers becomes an array on the stack: its items are chosen by a number of the run.
        kind, size = str(value.kind[0]), len(value.parts)
        self.count += 1
        space = f"%p{self.count}"
        self.first.append(f"  {space} = alloca [{size} x {TYPES[kind]}]")
        for k, part in enumerate(value.parts):
            self.out.append(
                f"  store {TYPES[kind]} {part}, ptr"
                f" {self.fresh(f'getelementptr {TYPES[kind]}, ptr {space}, i64 {k}')}"
            )
        return "0", str(size), 1, self._items(kind, space)

    def _items(self, kind: str, space: str) -> Callable[[str], Value]:
        """Return a function from the index of an item to its value."""
        return lambda index: self.item(
            kind, self.fresh(f"getelementptr inbounds {TYPES[kind]}, ptr {space}, i64 {index}")
        )

    def _return(self, statement: ast.Return) -> None:
        value = None if statement.value is None else self.value(statement.value)
        kind = None if value is None else value.kind
        if self.returns and kind != self.answer:
            self.refuse(
                statement,
                f"elsewhere the function returns {named(self.answer) if self.answer else 'nothing'}; write"
                " one kind, such as 0.0 for 0",
            )
        self.answer = kind
        self.returns.append(ast.unparse(statement))
        self.ended = True
        if value is None or kind is None:
            self.out.append("  ret void")
            return
        types = types_of(kind)
        result = value.parts[0]
        if len(types) > 1:
            result = "poison"
            for k, (part_type, part) in enumerate(zip(types, value.parts, strict=True)):
                result = self.fresh(f"insertvalue {answered(kind)} {result}, {part_type} {part}, {k}")
        self.out.append(f"  ret {answered(kind)} {result}")


def _digits(text: str) -> bool:
    return text.lstrip("-").isdigit()
