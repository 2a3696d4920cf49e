"""What to write in the function of a law for what of Python does not go into a compiled step."""

from __future__ import annotations

import ast
from types import FunctionType

from ..kernels import elementary

ELEMENTARY = tuple(name for name, value in vars(elementary).items() if isinstance(value, FunctionType) and not name.startswith("_"))
REMEDY = (
    "A law's function may use + - * /, math.sqrt, abs, comparisons, `a if condition else b`, numbers and plain functions of its file, "
    f"and {', '.join(ELEMENTARY)} of vfife.kernels.elementary"
)
INSTEAD: dict[type[ast.AST], tuple[str, str]] = {
    ast.If: ("an `if` statement", "compute both and choose by `a if condition else b`"),
    ast.While: ("a `while` loop", "take a fixed number of rounds, `for _ in range(4):`"),
    ast.FloorDiv: ("`//`", "use / and numbers that are not whole"),
    ast.Mod: ("`%`", "use + - * /"),
    ast.Not: ("`not`", "turn the comparison round"),
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
    ast.BitXor: ("`^`", "write x * x for a square, or power(x, n) of vfife.kernels.elementary"),
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
    ast.Continue: ("`continue`", "take all rounds, and choose by `a if condition else b` what each of them keeps"),
}
FUNCTIONS = {
    "exp": "write exp2 of vfife.kernels.elementary, e^x = 2^(x/ln 2)",
    "log": "see what vfife.kernels.elementary has, or work it out in parameters()",
    "pow": "write power(x, n) of vfife.kernels.elementary, or x * x",
    "sin": "write sincos(x) of vfife.kernels.elementary, which gives both",
    "cos": "write sincos(x) of vfife.kernels.elementary, which gives both",
    "sqrt": "import math, and write math.sqrt",
    "min": "write `a if a < b else b`",
    "max": "write `a if a > b else b`",
    "fabs": "write abs(x)",
    "float": "leave it out: every argument is a number",
    "sum": "write a + b",
}
# Names that the texts of a step have for themselves: a law that gives one of them to something else would change the step.
RESERVED = frozenset(
    ("abs", "range", "min", "max", "len", "int", "float", "math", "jit", "select", "both", "either", "seldom", "seldom_ends", "nearest")
    + ("contact_law", "friction_law", "friction_regime", "film_law")
)
