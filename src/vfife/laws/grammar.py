"""Kinds of values in the function of a law (:mod:`~vfife.laws.language`), and replacements for the parts of
Python that cannot be compiled.

Python converts between truth values, whole numbers and doubles implicitly; compiled code does not. A value
therefore has one kind:

- a *number*, a double;
- a *truth value*, which a comparison gives and a condition takes;
- a *whole number*, whose limits are known when the law is compiled: a literal, a constant of the file, the
  counter of a loop;
- a tuple of these.
"""

from __future__ import annotations

import ast
from types import FunctionType
from typing import NamedTuple

from ..kernels import elementary

NUMBER = "a number"
TRUTH = "a truth value"
UNKNOWN = "unknown"  # of an expression with a fault: nothing more is reported about it
LARGEST = 2**53  # up to here every whole number is a double, and comparing, adding and converting commute


class Integer(NamedTuple):
    """A whole number between two limits."""

    low: int
    high: int


class TupleKind(NamedTuple):
    """A tuple. ``slots`` marks the tuple of parameters, whose length is checked by a trial with numbers."""

    kinds: tuple[Kind, ...]
    slots: bool = False


Kind = str | Integer | TupleKind


def category(kind: Kind) -> object:
    """Return the category that a variable keeps. Kinds of one category differ only in the limits of
    integers.
    """
    if isinstance(kind, TupleKind):
        return tuple(category(part) for part in kind.kinds)
    return "a whole number" if isinstance(kind, Integer) else kind


def size(kind: Kind) -> int:
    """Return the count of numbers in a kind."""
    return sum(map(size, kind.kinds)) if isinstance(kind, TupleKind) else 1


def is_typed(kind: Kind) -> bool:
    """Return whether nothing in a kind is unknown."""
    return all(is_typed(part) for part in kind.kinds) if isinstance(kind, TupleKind) else kind != UNKNOWN


def numeric(kind: Kind) -> bool:
    """Return whether arithmetic accepts a kind."""
    return kind in (NUMBER, UNKNOWN) or isinstance(kind, Integer)


def words(kind: Kind) -> str:
    """Name a kind in words."""
    if isinstance(kind, TupleKind):
        return f"a tuple of {len(kind.kinds)}"
    return "a whole number" if isinstance(kind, Integer) else kind


ELEMENTARY = tuple(
    name
    for name, value in vars(elementary).items()
    if isinstance(value, FunctionType) and not name.startswith("_")
)
REMEDY = (
    "A law's function may use + - * /, x ** 2.5, math.sqrt, abs, comparisons, `a if condition else b`,"
    f" numbers and plain functions of its file, and {', '.join(ELEMENTARY)} of vfife.kernels.elementary"
)
INSTEAD: dict[type[ast.AST], tuple[str, str]] = {
    ast.If: ("an `if` statement", "compute both and choose by `a if condition else b`"),
    ast.While: ("a `while` loop", "take a fixed number of rounds, `for _ in range(4):`"),
    ast.FloorDiv: ("`//`", "use / and numbers that are not whole"),
    ast.Mod: ("`%`", "use + - * /"),
    ast.Not: ("`not`", "reverse the comparison"),
    ast.Lambda: ("a lambda", "write a function in the file"),
    ast.List: ("a list", "use single numbers and tuples"),
    ast.Try: ("`try`", "choose by `a if condition else b`"),
    ast.Raise: ("`raise`", "check parameters in parameters(); in the step nothing can be raised"),
    ast.Import: ("an import", "import at the top of the file"),
    ast.ImportFrom: ("an import", "import at the top of the file"),
    ast.JoinedStr: ("a text", "use numbers"),
    ast.In: ("`in`", "compare numbers"),
    ast.NotIn: ("`not in`", "compare numbers"),
    ast.Is: ("`is`", "compare numbers"),
    ast.IsNot: ("`is not`", "compare numbers"),
    ast.MatMult: ("`@`", "use + - * /"),
    ast.LShift: ("`<<`", "multiply by a number, as in 8.0 * x"),
    ast.RShift: ("`>>`", "multiply by a number, as in 0.125 * x"),
    ast.BitAnd: ("`&`", "join conditions with `and`"),
    ast.BitOr: ("`|`", "join conditions with `or`"),
    ast.BitXor: ("`^`", "write x ** 2 for a square"),
    ast.NamedExpr: ("`:=`", "give the value a name in a line before"),
    ast.ListComp: ("a list", "use single numbers and tuples"),
    ast.GeneratorExp: ("a loop in an expression", "write `for x in p:` as a statement"),
    ast.Starred: ("`*`", "write the parts one by one"),
    ast.With: ("`with`", "leave it out; a step opens nothing"),
    ast.Match: ("`match`", "compute all and choose by `a if condition else b`"),
    ast.Assert: ("`assert`", "check parameters in parameters(); in the step nothing can be raised"),
    ast.Delete: ("`del`", "leave it out"),
    ast.Global: ("`global`", "make it a number of slots"),
    ast.Nonlocal: ("`nonlocal`", "make it a number of slots"),
    ast.FunctionDef: ("a function within a function", "write it in the file, beside the class"),
    ast.ClassDef: ("a class", "use numbers"),
    ast.Break: ("`break`", "take all rounds, and choose by `a if condition else b` what each of them keeps"),
    ast.Continue: (
        "`continue`",
        "take all rounds, and choose by `a if condition else b` what each of them keeps",
    ),
}


def exclusion(node: ast.AST) -> str:
    """Return why a node cannot be compiled, and what to write instead; "" for a node of the language."""
    construct, instead = INSTEAD.get(type(node), ("", ""))
    return f"{construct} cannot be compiled into the step; {instead}" if construct else ""


FUNCTIONS = {
    "exp": "write exp of vfife.kernels.elementary, for |x| below 88",
    "log": "write log of vfife.kernels.elementary",
    "pow": "write x ** 2.5, or power(x, n) of vfife.kernels.elementary for other exponents",
    "sin": "write sincos(x) of vfife.kernels.elementary, which gives both",
    "cos": "write sincos(x) of vfife.kernels.elementary, which gives both",
    "sqrt": "import math, and write math.sqrt",
    "min": "write `a if a < b else b`",
    "max": "write `a if a > b else b`",
    "fabs": "write abs(x)",
    "float": "leave it out: every argument is a number",
    "sum": "write a + b",
}
# Names that the texts of a step have for themselves: a law that gives one of them to something else would
# change the step.
RESERVED = frozenset(
    (
        "abs",
        "range",
        "min",
        "max",
        "len",
        "int",
        "float",
        "math",
        "jit",
        "select",
        "both",
        "either",
        "unlikely",
        "unlikely_ends",
        "nearest",
    )
    + ("contact_law", "friction_law", "friction_regime", "film_law")
)
