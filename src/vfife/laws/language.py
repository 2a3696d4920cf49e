"""The language of a law's function: the part of Python that every loop of vfife computes with the same bits.

A law is written into straight-line code (for vectors of several widths, JavaScript and graphics cards) and
into a compiled loop, and is run as plain Python. Any construct that these three might treat differently is
refused here, before anything is traced or compiled, with line, construct and replacement. Tracing alone would
find many faults, but later, and it could not name the line and the remedy. The language:

- a function is `def` with plain arguments, statements and one `return`, its last line; it may call functions
  of the same kind, none of which leads back to itself, and those of ``vfife.kernels.elementary``;
- statements give values to names (`a = ...`, `a += ...`, `a, b = ...`) or repeat with a fixed number of
  rounds (`for k in range(4):`, `for x in p:`);
- an expression is a number, a truth value, a whole number or a tuple (:mod:`~vfife.laws.grammar`), and a name
  keeps the kind of its first value;
- `+ - * /`, `abs`, `math.sqrt`, comparisons and powers with a literal whole or half exponent
  (:mod:`~vfife.compiler.trace.powers`) take numbers; `and`, `or` and the condition of
  `a if condition else b` take truth values, and nothing else does;
- a whole number is known when the law is compiled and is below 2^53, so that converting it to a double
  changes nothing.

Where Python raises (a division by zero, the root of a negative number), all compiled loops continue with the
same infinity or NaN of IEEE 754. Both arms of `a if condition else b` are computed, and one is dropped.
"""

from __future__ import annotations

import ast
import linecache
import math
from functools import lru_cache
from types import CodeType, FunctionType
from typing import Any

from ..compiler.trace.traceable import WRITING, function_text, parsed, with_products
from .expressions import Expressions, shown
from .grammar import (
    NUMBER,
    REMEDY,
    RESERVED,
    TRUTH,
    UNKNOWN,
    Integer,
    Kind,
    TupleKind,
    category,
    exclusion,
    is_typed,
    numeric,
    words,
)

# Largest number of operations of a law in a step. The largest built-in law has some 400; 5,000 take a second
# to compile for all loops.
LONGEST = 5_000
DEEPEST_LOOP = 4  # nested loops: the body of each is examined twice, so that the work doubles with each
DEEPEST_CALL = 40  # nested calls of functions


class Language:
    """Examine a function and all that it calls; ``faults`` are the sentences on all that is wrong.

    Each function is examined once for each list of kinds of its arguments, as a compiler would translate
    it. ``stack`` are the functions under examination, in which a recursion shows.
    """

    def __init__(self) -> None:
        self.faults: dict[str, None] = {}
        self.known: dict[tuple[FunctionType, tuple[Kind, ...]], tuple[Kind, int]] = {}
        self.stack: list[FunctionType] = []

    def answer(self, function: FunctionType, kinds: tuple[Kind, ...]) -> tuple[Kind, int]:
        """Return the kind of a function's answer for arguments of these kinds, and its number of
        operations.
        """
        if (function, kinds) not in self.known:
            self.stack.append(function)
            try:
                self.known[function, kinds] = Function(self, function, kinds).answer()
            finally:
                self.stack.pop()
        return self.known[function, kinds]

    def examine(
        self, function: FunctionType, kinds: tuple[Kind, ...], numbers: tuple[int, ...], answer_text: str
    ) -> list[str]:
        """Return all faults of a function whose answer has to have the shape ``numbers``: one entry for each
        part, 1 for a number, more for a tuple. ``answer_text`` describes the answer in messages.
        """
        try:
            kind, cost = self.answer(function, kinds)
        except RecursionError:
            self.faults[
                f"function {function.__name__}: its expressions are nested too deeply; give parts of them"
                " names of their own"
            ] = None
            return list(self.faults)
        if cost > LONGEST:
            text = (
                f"function {function.__name__} takes {cost:,} operations in every step; at most {LONGEST:,}:"
                " use fewer rounds of its loops"
            )
            self.faults[text] = None
        expected = shape(numbers)
        if not self.faults and not fits(kind, expected):
            self.faults[
                f"function {function.__name__} returns {answer_words(kind)}; it has to return {answer_text}"
            ] = None
        return list(self.faults)


def shape(numbers: tuple[int, ...]) -> Kind:
    """Return the kind of an answer with these parts."""
    parts = tuple(NUMBER if count == 1 else TupleKind((NUMBER,) * count) for count in numbers)
    return parts[0] if len(parts) == 1 else TupleKind(parts)


def answer_words(kind: Kind) -> str:
    """Return an answer in words."""
    return " and ".join(words(part) for part in kind.kinds) if isinstance(kind, TupleKind) else words(kind)


def fits(kind: Kind, expected: Kind) -> bool:
    """Return whether an answer has the expected shape."""
    if isinstance(expected, TupleKind):
        return (
            isinstance(kind, TupleKind)
            and len(kind.kinds) == len(expected.kinds)
            and all(map(fits, kind.kinds, expected.kinds))
        )
    return numeric(kind)


class Function(Expressions):
    """The examination of one function for one list of kinds of arguments; ``place`` maps names to kinds."""

    def __init__(self, language: Language, function: FunctionType, kinds: tuple[Kind, ...]) -> None:
        self.language, self.kinds = language, kinds
        self.function: Any = function
        self.place: dict[str, Kind] = {}
        self.local = frozenset((*function.__code__.co_varnames, *function.__code__.co_cellvars))
        self.cost, self.loops = 0, 0
        self.returned: Kind | None = None

    def fault(self, node: ast.AST, text: str) -> Kind:
        """Add a fault of a node with its line; return the kind UNKNOWN, of which nothing more is reported."""
        line = getattr(node, "lineno", 1) + self.function.__code__.co_firstlineno - 1
        if any(isinstance(kind, Integer) for kind in self.kinds):
            text += f" (a call hands a whole number to {self.function.__name__}: write 1.0 for 1 there)"
        self.language.faults[f"function {self.function.__name__}, line {line}: {text}"] = None
        return UNKNOWN

    def answer(self) -> tuple[Kind, int]:
        """Return the kind of the function's answer and its number of operations."""
        function = self.function
        if function.__closure__:
            names = ", ".join(function.__code__.co_freevars)
            self.language.faults[
                f"function {function.__name__} uses {names} from around it. Make it a field of the law"
            ] = None
            return UNKNOWN, 0
        tree = parsed(function_text(function))
        if not isinstance(tree, ast.FunctionDef):
            self.language.faults[f"{function.__name__} is no def. Write it as one"] = None
            return UNKNOWN, 0
        if not self.signature(tree):
            return UNKNOWN, 0
        body = tree.body[1:] if ast.get_docstring(tree) is not None else tree.body
        for statement in body:
            if self.returned is not None:
                self.fault(statement, "a line behind `return`; leave it out, or return at the end alone")
                return UNKNOWN, 0
            self.statement(statement)
        if self.returned is None:
            self.fault(tree, f"{function.__name__} returns nothing; end it with `return`")
        return self.returned or UNKNOWN, self.cost

    def signature(self, tree: ast.FunctionDef) -> bool:
        """Examine the arguments; return whether the body can be examined."""
        name, arguments = self.function.__name__, tree.args
        if not self.function.__module__.startswith("vfife.") and not written_out(self.function):
            self.fault(
                tree, f"the text of {name} is not what Python runs: the file has changed since; load it again"
            )
            return False
        if [
            decorator
            for decorator in tree.decorator_list
            if not isinstance(decorator, ast.Name) or decorator.id != "staticmethod"
        ]:
            self.fault(
                tree, f"{name} has a decorator, which the step would leave out; write a plain function"
            )
        elif arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.posonlyargs:
            self.fault(
                tree, f"{name} has arguments behind `*` or `/`; write plain ones, as in def {name}(a, b)"
            )
        elif arguments.defaults:
            self.fault(tree, f"{name} has arguments with defaults; hand all of them over, as in {name}(a, b)")
        elif len(arguments.args) != len(self.kinds):
            if len(self.language.stack) > 1:  # the check of the class reports those of the law's own function
                self.fault(
                    tree,
                    f"{name} takes {len(arguments.args)} arguments and is given {len(self.kinds)}; correct"
                    " the call",
                )
        else:
            for argument, kind in zip(arguments.args, self.kinds, strict=True):
                self.store(argument, argument.arg, kind)
            return True
        return False

    def called(self, node: ast.Call, function: FunctionType, kinds: tuple[Kind, ...]) -> Kind:
        """Return the kind of the answer of another function, with the faults of the call."""
        name = function.__name__
        if function in self.language.stack:
            return self.fault(
                node, f"{name} leads back to itself; take a fixed number of rounds, `for _ in range(4):`"
            )
        if len(self.language.stack) > DEEPEST_CALL:
            return self.fault(
                node, f"more than {DEEPEST_CALL} functions call one another; write some of them out"
            )
        if not isinstance(function, FunctionType):
            return self.fault(node, f"{name} is no plain function; write it as a `def` in the file")
        user_function = not function.__module__.startswith("vfife.")
        if not user_function and any(isinstance(kind, Integer) for kind in kinds):
            return self.fault(
                node, f"`{shown(node)}` hands over a whole number; write it with a point, as in 2.0"
            )
        if not user_function and TRUTH in kinds:
            return self.fault(node, f"`{shown(node)}` hands over a truth value; write a number, as in 1.0")
        try:
            kind, cost = self.language.answer(function, kinds)
        except (OSError, TypeError):
            return self.fault(node, f"the text of {name} cannot be read; write the function in the file")
        self.cost += cost
        return kind

    def store(self, node: ast.AST, name: str, kind: Kind) -> None:
        """Assign a kind to a name, which keeps the kind of its first value."""
        if name in RESERVED and not self.function.__module__.startswith("vfife."):
            self.fault(node, f"{name} is a name that the step itself uses; choose another, as in my_{name}")
        if name.startswith("__"):
            self.fault(
                node,
                f"{name}: within a class Python gives such a name another one; choose one without `__` in"
                " front",
            )
        former = self.place.get(name, kind)
        if category(former) != category(kind) and is_typed(former) and is_typed(kind):
            text = f"{name} is {words(former)} before and {words(kind)} here"
            integer = isinstance(former, Integer) or isinstance(kind, Integer)
            self.fault(
                node,
                f"{text}; {'write whole numbers with a point, as in 1.0' if integer else 'take two names'}",
            )
            kind = UNKNOWN
        self.place[name] = kind

    def give(self, target: ast.expr, kind: Kind) -> None:
        """Assign a kind to a name, or the kinds of a tuple's parts to several."""
        if isinstance(target, ast.Name):
            self.store(target, target.id, kind)
        elif isinstance(target, ast.Tuple):
            parts = kind.kinds if isinstance(kind, TupleKind) else ()
            if kind != UNKNOWN and not isinstance(kind, TupleKind):
                self.fault(target, f"`{shown(target)}` takes {words(kind)} apart; only a tuple has parts")
            elif isinstance(kind, TupleKind) and len(parts) != len(target.elts) and not kind.slots:
                self.fault(
                    target,
                    f"`{shown(target)}` takes {len(parts)} parts for {len(target.elts)} names; write as many",
                )
            if len(parts) != len(target.elts):
                parts = (UNKNOWN,) * len(target.elts)
            for element, part in zip(target.elts, parts, strict=True):
                self.give(element, part)
        else:
            self.fault(target, f"`{shown(target)}` is given a value; only names can be, as in a = b")

    def statement(self, node: ast.stmt) -> None:
        """Examine a statement."""
        if excluded := exclusion(node):
            self.fault(node, excluded)
            self.place |= {
                name.id: UNKNOWN
                for name in ast.walk(node)
                if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)
            }
            return
        if isinstance(node, ast.Assign):
            kind = self.kind(node.value)
            for target in node.targets:
                self.give(target, kind)
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            self.give(node.target, self.kind(node.value))
        elif isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name):
            read = ast.copy_location(ast.Name(node.target.id, ast.Load()), node)
            self.give(node.target, self.kind(ast.copy_location(ast.BinOp(read, node.op, node.value), node)))
        elif isinstance(node, ast.For):
            self.loop(node)
        elif isinstance(node, ast.Return):
            if self.loops:
                self.fault(
                    node, "`return` within a loop; return at the end, and choose by `a if condition else b`"
                )
            elif node.value is None:
                self.fault(node, "`return` without a value; return numbers")
                self.returned = UNKNOWN
            else:
                self.returned = self.kind(node.value)
        elif not isinstance(node, ast.Pass):
            self.fault(node, f"`{shown(node)}` cannot be compiled into the step. {REMEDY}")

    def loop(self, node: ast.For) -> None:
        """Examine a loop with a fixed number of rounds. Its body is examined twice, because the second round
        uses values of the first, which may be of another kind; more rounds bring nothing new.
        """
        rounds, kind = self.rounds(node)
        if node.orelse:
            self.fault(
                node.orelse[0],
                "`for … else` cannot be compiled into the step; write what follows after the loop",
            )
        if not isinstance(node.target, ast.Name):
            self.fault(node.target, f"`{shown(node.target)}` counts a loop; count with a single name")
            return
        if self.loops == DEEPEST_LOOP:
            self.fault(node, f"more than {DEEPEST_LOOP} loops stand in one another; write some of them out")
            return
        self.loops += 1
        former_kinds, cost = dict(self.place), self.cost
        for _ in range(2):
            self.give(node.target, kind)
            for statement in node.body:
                self.statement(statement)
        for name, former in former_kinds.items():
            present = self.place[name]
            if (
                isinstance(former, Integer)
                and isinstance(present, Integer)
                and present != former
                and name != node.target.id
            ):
                self.fault(
                    node,
                    f"{name} is a whole number that changes from round to round; write it with a point, as"
                    " in 1.0",
                )
        self.loops -= 1
        self.cost = cost + rounds * ((self.cost - cost) // 2 + 1)

    def rounds(self, node: ast.For) -> tuple[int, Kind]:
        """Return the number of rounds of a loop and the kind of its name."""
        iterated = node.iter
        if (
            isinstance(iterated, ast.Call)
            and isinstance(iterated.func, ast.Name)
            and iterated.func.id == "range"
            and "range" not in self.local
        ):
            if "range" in self.function.__globals__:
                self.outside(iterated.func)
                return 1, UNKNOWN
            return self.counted(iterated)
        kind = self.kind(iterated)
        if kind == UNKNOWN:
            return 1, UNKNOWN
        if not isinstance(kind, TupleKind) or any(part != NUMBER for part in kind.kinds) or not kind.kinds:
            self.fault(
                iterated,
                f"`for ... in {shown(iterated)}` goes over {words(kind)}; go over range(4), or a tuple of"
                " numbers with points",
            )
            return 1, UNKNOWN
        return len(kind.kinds), NUMBER

    def counted(self, iterated: ast.Call) -> tuple[int, Kind]:
        """Return the number of rounds of a range and the kind of its counter."""
        values: list[int] = []
        for argument in iterated.args:
            kind = self.kind(argument)
            if kind == UNKNOWN:
                return 1, UNKNOWN
            if not isinstance(kind, Integer) or kind.low != kind.high:
                self.fault(
                    argument,
                    f"`{shown(iterated)}`: {shown(argument)} is no whole number that is known here; write"
                    " one, as in range(4)",
                )
                return 1, UNKNOWN
            values.append(kind.low)
        steps = isinstance(iterated.args[2], ast.Constant | ast.UnaryOp) if len(values) == 3 else True
        if not 1 <= len(values) <= 3 or iterated.keywords or not steps or values[2:] == [0]:
            self.fault(
                iterated,
                f"`{shown(iterated)}` is no range with a fixed number of rounds; write range(4) or range(0,"
                " 8, 2)",
            )
            return 1, UNKNOWN
        result = range(*values)
        if not result:
            self.fault(iterated, f"`{shown(iterated)}` has no rounds; leave the loop out")
            return 1, UNKNOWN
        return len(result), Integer(min(result[0], result[-1]), max(result[0], result[-1]))


@lru_cache(maxsize=16)
def codes(text: str, file: str, products: bool, single: bool) -> dict[tuple[int, str], CodeType]:
    """Return the code objects of the functions in the text of a file, by line and name, with powers as
    ``products`` or as they are; none if it is no Python. ``single``: each statement is compiled by itself.
    """
    try:
        with WRITING:
            tree = with_products(text) if products else ast.parse(text)
            parts = [ast.Module([statement], []) for statement in tree.body] if single else [tree]
            waiting = [compile(part, file, "exec", dont_inherit=True) for part in parts]
    except (SyntaxError, ValueError):
        return {}
    result: dict[tuple[int, str], CodeType] = {}
    while waiting:
        code = waiting.pop()
        result[code.co_firstlineno, code.co_name] = code
        waiting += [constant for constant in code.co_consts if isinstance(constant, CodeType)]
    return result


def written_out(function: FunctionType) -> bool:
    """Make Python run a function with its powers as products, as all loops do; return False, and leave it
    alone, if Python runs another text than the one in the file: the step would be compiled from the new text,
    and Python would run the old one.

    A notebook compiles each statement of a cell by itself. Its instructions differ from those of a file as a
    whole, in which Python calls functions of modules that the file imports in another way.
    """
    code = function.__code__
    text = "".join(linecache.getlines(code.co_filename, function.__globals__))
    place = code.co_firstlineno, code.co_name
    for single in (False, True):
        plain, product = (codes(text, code.co_filename, products, single) for products in (False, True))
        if not plain:
            return True
        if place in plain and text_of(code) in (text_of(plain[place]), text_of(product[place])):
            if text_of(code) != text_of(product[place]):
                function.__globals__.setdefault("math", math)
                function.__code__ = product[place]
            return True
    return False


def text_of(code: CodeType) -> tuple[Any, ...]:
    """Return what decides a code object's behaviour: instructions, names, and constants with their types and
    signs. Line numbers are not part of it.
    """
    constants = tuple(
        text_of(constant) if isinstance(constant, CodeType) else repr(constant) for constant in code.co_consts
    )
    return code.co_code, code.co_names, code.co_varnames, code.co_freevars, constants
