"""The text of the data-driven loop for a set of laws: kernels, laws and driver gathered into one module.

The text is compiled (:mod:`~vfife.compiler.backends.plain`) or run as plain Python. Fields of records and
constants are written into it as numbers, so it contains everything that decides its bits, and its hash is a
complete cache key.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from types import FunctionType
from typing import Any, Protocol

from ...errors import SourceError
from ...kernels import advance as loop
from ...kernels.arrays import Fields
from ...kernels.blocks import CONTACT_SLOTS, FRICTION_MEMORY, FRICTION_SLOTS
from .traceable import WRITING, function_text, function_tree

# Cache of definitions: writing them takes most of the time of a text.
_DEFINITIONS: dict[tuple[object, ...], str] = {}


class Collector(Protocol):
    """An object that collects the functions that a text calls."""

    def add(self, function: Callable[..., Any], name: str | None = None) -> str:
        """Add a function; return the name by which the text calls it."""


class Gathered:
    """Source texts of functions by name, each after those that it calls.

    ``written`` are texts that replace names of the kernels, such as the choices between laws.
    """

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        self.origin: dict[str, object] = {}
        self.written: dict[str, str] = {}

    def add(self, function: Callable[..., Any], name: str | None = None) -> str:
        """Add a function, under another name if given, and all that it calls; return its name in the text.

        Raises SourceError for two functions of one name, or for one that is no plain function.
        """
        require_plain(function)
        name = name or function.__name__
        if name in self.origin:
            if self.origin[name] is not function:
                raise SourceError(f"two different functions are called {name!r}; rename one of them")
            return name
        self.origin[name] = function
        for used in global_names(function):
            if function.__module__.startswith("vfife.") or used in names_of(function):
                self._resolve(function, used)
        self.texts.pop(name, None)
        self.texts[name] = definition(function, name)
        return name

    def _resolve(self, function: Callable[..., Any], used: str) -> None:
        if used in self.written:
            if used not in self.texts:
                self.texts[used] = self.written[used]
            return
        value = function.__globals__.get(used, math)
        if value is math or isinstance(value, Fields) or is_record(value):
            return
        if isinstance(value, FunctionType):
            name_of_value = self.add(value)
            if name_of_value != used:
                self.texts[used] = f"{used} = {name_of_value}\n"
        elif not isinstance(value, (bool, int, float)):
            raise SourceError(
                f"{function.__module__}.{function.__qualname__} uses {used!r}, a {type(value).__name__}; a"
                " law's function may use its arguments, math.sqrt, numbers and plain functions of numbers"
            )

    def text(self) -> str:
        """Return all texts, each after those that it calls."""
        return "\n\n".join(self.texts.values())


def require_plain(function: Callable[..., Any]) -> None:
    """Raise SourceError unless ``function`` is a plain Python function without a closure."""
    if not isinstance(function, FunctionType):
        raise SourceError(f"{function!r} is not a plain function")
    if function.__closure__:
        raise SourceError(
            f"{function.__qualname__} closes over {', '.join(function.__code__.co_freevars)}; pass numbers as"
            " parameters"
        )


def global_names(function: Callable[..., Any]) -> list[str]:
    """Return the names that a function takes from its module, in the order of their first use."""
    code = function.__code__
    space = function.__globals__
    return [name for name in code.co_names if name in space]


@lru_cache(maxsize=512)
def names_of(function: Callable[..., Any]) -> frozenset[str]:
    """Return the names in a function's text that are not attributes: the ``sqrt`` of ``math.sqrt`` is none,
    even if the file has a function of this name.
    """
    return frozenset(node.id for node in ast.walk(function_tree(function)) if isinstance(node, ast.Name))


def definition(function: Callable[..., Any], name: str) -> str:
    """Return the source of a function as a definition called ``name``, without decorators, annotations and
    docstring.
    """
    key = function_text(function), name, _decisive(function)
    if key not in _DEFINITIONS:
        _DEFINITIONS[key] = _definition(function, name)
    return _DEFINITIONS[key]


def _decisive(function: Callable[..., Any]) -> tuple[object, ...]:
    """Return what decides a definition in addition to its text: the values of the names that it takes from
    its module.
    """
    space = function.__globals__
    result = [(used, space[used]) for used in global_names(function)]
    return tuple(
        (used, value if isinstance(value, Fields) else repr(value))
        for used, value in result
        if not isinstance(value, FunctionType)
    )


def _definition(function: Callable[..., Any], name: str) -> str:
    tree = function_tree(function)
    if not isinstance(tree, ast.FunctionDef):
        raise SourceError(f"{function.__qualname__} is no def")
    tree.name = name
    if ast.get_docstring(tree) is not None:
        tree.body = tree.body[1:] or [ast.Pass()]
    tree = ast.fix_missing_locations(_Literal(function).visit(tree))
    return ast.unparse(tree) + "\n"


def is_record(value: object) -> bool:
    """Return whether a value is a NamedTuple class: kernels pass values that belong together as one, and the
    text has a plain tuple in its place.
    """
    return isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")


class _Literal(ast.NodeTransformer):
    """Replace fields such as ``PARTICLE.x``, numbers of the function's module and those of the module math by
    their values, and NamedTuples by tuples.

    ``Central(h, decay, gain, p)`` becomes (h, decay, gain, p), and ``central.gain`` becomes central[2]. For
    that, ``central`` must be an argument annotated with the class, or be assigned from a call of the class or
    of a function whose return is annotated with it.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.space = function.__globals__
        self.local = set(function.__code__.co_varnames)
        self.records = {
            name: record for name, record in function.__annotations__.items() if is_record(record)
        }

    def _record(self, node: ast.expr) -> Any:
        """Return the NamedTuple class that a call returns, None for any other expression."""
        called = (
            self.space.get(node.func.id)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
            else None
        )
        result = called if isinstance(called, type) else getattr(called, "__annotations__", {}).get("return")
        return result if is_record(result) else None

    def visit_Assign(self, node: ast.Assign) -> ast.AST:
        record = self._record(node.value)
        if record is not None and isinstance(node.targets[0], ast.Name):
            self.records[node.targets[0].id] = record
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        visited = self.generic_visit(node)
        return (
            ast.Tuple(node.args, ast.Load())
            if is_record(self.space.get(getattr(node.func, "id", "")))
            else visited
        )

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        if isinstance(node.value, ast.Name) and node.value.id in self.records:
            return ast.Subscript(
                node.value, ast.Constant(self.records[node.value.id]._fields.index(node.attr)), ast.Load()
            )
        owner = self.space.get(node.value.id) if isinstance(node.value, ast.Name) else None
        if owner is math:
            value = getattr(math, node.attr, None)
            if isinstance(value, float):
                return ast.Constant(value)
            if node.attr != "sqrt":
                raise SourceError(
                    f"math.{node.attr} differs between machines in its last bits; math.sqrt alone does not"
                )
            return ast.Attribute(ast.Name("math", ast.Load()), "sqrt", ast.Load())
        return (
            ast.Constant(getattr(owner, node.attr)) if isinstance(owner, Fields) else self.generic_visit(node)
        )

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        return node if node.value is None else ast.Assign([node.target], self.visit(node.value))

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        integers = [
            operand.value
            for operand in (node.left, node.right)
            if isinstance(operand, ast.Constant) and type(operand.value) is int
        ]
        return (
            ast.Constant(integers[0] ** integers[1])
            if isinstance(node.op, ast.Pow) and len(integers) == 2
            else self.generic_visit(node)
        )

    def visit_Name(self, node: ast.Name) -> ast.AST:
        value = (
            self.space.get(node.id) if isinstance(node.ctx, ast.Load) and node.id not in self.local else None
        )
        if not isinstance(value, (bool, int, float)):
            return node
        return ast.UnaryOp(ast.USub(), ast.Constant(-value)) if value < 0 else ast.Constant(value)


def law_name(kind: str, law: type) -> str:
    """Return the name of a law's function in a gathered text; ``kind`` is contact, friction or film."""
    return f"{kind}_{(law.__dict__.get('name') or law.__name__).replace('-', '_')}"


def choice(head: str, answers: Sequence[str], cases: Mapping[int, Sequence[str]]) -> str:
    """Return the text of a function with the head ``head`` that executes the lines of the case ``kind``; its
    answers are zero if there is no such case.
    """
    lines = [f"def {head}:", *(f"    {answer} = 0.0" for answer in answers)]
    for number, case in cases.items():
        lines += [f"    if kind == {number}:", *(f"        {line}" for line in case)]
    return "\n".join([*lines, f"    return {', '.join(answers)}"]) + "\n"


def slots_of(law: Any) -> str:
    """Return the text of the tuple of a law's parameters, which are the rows from ``base``."""
    return f"({''.join(f'S[base + {k}], ' for k in range(len(law.slots)))})"


def dispatch(kind: str, laws: tuple[type, ...], gathered: Collector) -> str:
    """Return the text of the choice between contact laws, ``contact_law(kind, depth, slowness, S, base)``, or
    friction laws, ``friction_law(kind, normal, free, mobility, dt, S, base, memory)``.

    The memory of a friction law is in the rows from ``memory``; it is set to zero where the normal force is
    zero. A law with a table has no case: its numbers are not among the slots (kernels/tabled.py).
    """
    cases: dict[int, list[str]] = {}
    for number, law in enumerate(laws):
        if getattr(law, "tabled", False):
            continue
        rows = memory_rows(kind, law)
        name = gathered.add(law.force, law_name(kind, law))  # type: ignore[attr-defined]
        if kind == "contact":
            cases[number] = [f"elastic, damping = {name}(depth, slowness, {slots_of(law)})"]
            continue
        row = [f"S[memory + {k}]" for k in range(rows)]
        memory = row[0] if rows == 1 else f"({', '.join(row)})" if rows else "0.0"
        new_memory = [f"after{number}"] if rows == 1 else [f"after{number}[{k}]" for k in range(rows)]
        cases[number] = [
            f"force, after{number} = {name}(normal, free, mobility, {memory}, dt, {slots_of(law)})",
            *(f"{to} = {value} if normal > 0.0 else 0.0" for to, value in zip(row, new_memory, strict=True)),
        ]
    if kind == "contact":
        return choice("contact_law(kind, depth, slowness, S, base)", ("elastic", "damping"), cases)
    return choice("friction_law(kind, normal, free, mobility, dt, S, base, memory)", ("force",), cases)


def memory_rows(kind: str, law: Any) -> int:
    """Return the number of rows of memory that a law takes.

    Raises SourceError if a law has more memory or more parameters than there are rows.
    """
    slots, memory = {"contact": (CONTACT_SLOTS, 0), "friction": (FRICTION_SLOTS, FRICTION_MEMORY)}[kind]
    count, rows = len(law.slots), len(law.memory) if kind == "friction" else 0
    if count > slots:
        raise SourceError(f"law {law.name or law.__name__!r} has {count} parameters; a law may have {slots}")
    if rows > memory:
        raise SourceError(
            f"law {law.name or law.__name__!r} remembers {rows} numbers; a law may remember {memory}"
        )
    return rows


def regimes(laws: tuple[type, ...], gathered: Collector) -> str:
    """Return the text of the choice between friction laws whose curves have kinks,
    ``friction_regime(kind, sliding, S, base)``.
    """
    cases = {}
    for number, law in enumerate(laws):
        if getattr(law, "regime", None) is not None:
            name = gathered.add(law.regime, f"regime_{law_name('friction', law)}")  # type: ignore[attr-defined]
            cases[number] = [f"regime = {name}(sliding, {slots_of(law)})"]
    return choice("friction_regime(kind, sliding, S, base)", ("regime",), cases)


def films(laws: tuple[type, ...], gathered: Collector) -> str:
    """Return the text of the choice between contact laws with a film,
    ``film_law(kind, penetration, turning, sense, S, base)``.
    """
    answers, cases = ("radial", "across", "damping", "tangential", "cross"), {}
    for number, law in enumerate(laws):
        if getattr(law, "film", False):
            name = gathered.add(law.film_force, f"film_{law_name('contact', law)}")  # type: ignore[attr-defined]
            cases[number] = [f"{', '.join(answers)} = {name}(penetration, turning, sense, {slots_of(law)})"]
    return choice("film_law(kind, penetration, turning, sense, S, base)", answers, cases)


def data_driven(contact_laws: tuple[type, ...], friction_laws: tuple[type, ...]) -> str:
    """Return the text of the data-driven loop with a chain of ifs over the given laws."""
    with WRITING:
        return _data_driven(contact_laws, friction_laws)


def _data_driven(contact_laws: tuple[type, ...], friction_laws: tuple[type, ...]) -> str:
    gathered = Gathered()
    gathered.written = choices(contact_laws, friction_laws, gathered)
    gathered.add(loop.advance)
    gathered.add(loop.stream)
    return gathered.text()


def choices(
    contact_laws: tuple[type, ...], friction_laws: tuple[type, ...], gathered: Collector
) -> dict[str, str]:
    """Return the texts of the choices between laws, by the names by which the kernels call them."""
    return {
        "contact_law": dispatch("contact", contact_laws, gathered),
        "friction_law": dispatch("friction", friction_laws, gathered),
        "friction_regime": regimes(friction_laws, gathered),
        "film_law": films(contact_laws, gathered),
    }
