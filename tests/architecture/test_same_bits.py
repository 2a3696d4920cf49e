"""What decides a run has the same bits on every machine: no function of the C library, BLAS, LAPACK, NumPy or SciPy with bits of its own."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from architecture.sources import files, imports, report

# Packages and modules whose numbers decide a run: masses, functions, closing of positions, the step, what follows a run from step to step.
DECIDING = (
    "assembly/",
    "codegen/",
    "fields/",
    "gallery/",
    "kernels/",
    "kinematics/",
    "laws/",
    "model/",
    "modelfile/",
    "numerics/",
    "solvers/",
    "study/",
    "units.py",
)
# Why others may call what they like.
EXCEPTIONS = {
    "codegen/source.py": "a power of two whole numbers, which is exact",
    "laws/agreement.py": "states at which loops are compared with Python, whatever they are",
    "laws/expressions.py": "a power of two whole numbers, which is exact",
    "model/strokes.py": "draws",
    "model/outlines.py": "chooses in which order the corners of a body are drawn",
    "numerics/scalar.py": "math.pow of zeros and infinities, which is exact",
    "study/distributions.py": "values of members are rounded to ten digits",
    "study/identification/": "compares records with data",
    "study/quantiles.py": "statistics of results",
    "study/refining.py": "a search that chooses its next members",
    "units.py": "powers of fractions, and of forty digits in decimal arithmetic",
    "study/sampling.py": "SciPy's Sobol' points are whole numbers over a power of two",
}
NUMPY = {
    "arccos", "arccosh", "arcsin", "arcsinh", "arctan", "arctan2", "arctanh", "cbrt", "convolve", "correlate", "cos", "cosh", "dot", "einsum",
    "exp", "exp2", "expm1", "fft", "float_power", "hypot", "inner", "interp", "lib", "log", "log10", "log1p", "log2", "logaddexp", "matmul",
    "polyfit", "power", "roots", "sin", "sinc", "sinh", "tan", "tanh", "tensordot", "vdot",
}  # fmt: skip
# Of math what only moves bits, or is exact, or rounds once as IEEE 754 says.
MATH = {
    "ceil", "comb", "copysign", "e", "fabs", "factorial", "floor", "fmod", "frexp", "fsum", "gcd", "inf", "isclose", "isfinite", "isinf", "isnan",
    "isqrt", "ldexp", "modf", "nan", "nextafter", "perm", "pi", "prod", "radians", "degrees", "remainder", "sqrt", "tau", "trunc", "ulp",
}  # fmt: skip


def dotted(node: ast.expr) -> str:
    """A name with its attributes, "" for another expression."""
    if isinstance(node, ast.Name):
        return node.id
    inner = dotted(node.value) if isinstance(node, ast.Attribute) else ""
    return f"{inner}.{node.attr}" if inner and isinstance(node, ast.Attribute) else ""


def whole(node: ast.expr) -> bool:
    """Whether an expression is a whole number that is written out, or a power of two."""
    return isinstance(node, ast.Constant) and (isinstance(node.value, int) or node.value in (0.5, 2.0))


def faults(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Lines and what they call."""
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp | ast.AugAssign):
            if isinstance(node.op, ast.MatMult):
                yield node.lineno, "@ is a product of BLAS: numerics.products"
            left = node.left if isinstance(node, ast.BinOp) else node.target
            if isinstance(node.op, ast.Pow) and not whole(left):
                yield node.lineno, "** is the C library's power: x * x, or numerics.scalar.power"
        elif isinstance(node, ast.Attribute):
            name = dotted(node)
            first, _, rest = name.partition(".")
            if first == "math" and rest not in MATH:
                yield node.lineno, f"{name}: numerics.scalar"
            elif first == "np" and rest.split(".")[0] in NUMPY:
                yield node.lineno, f"{name}: numerics.elementwise, numerics.products"
            elif name.startswith("np.linalg.") and name != "np.linalg.LinAlgError":
                yield node.lineno, f"{name}: numerics.dense"
            elif name.startswith("np.polynomial.") and not name.endswith((".polynomial", ".polyval")):
                yield node.lineno, f"{name}: numerics"
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "pow":
            yield node.lineno, "pow is the C library's: numerics.scalar.power"
        elif (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and node.func.attr == "dot"
            and dotted(node.func.value) != "products"
        ):
            yield node.lineno, "the method dot is a product of BLAS: numerics.products"


def test_what_decides_a_run_has_bits_of_its_own() -> None:
    offenders, seen = [], set()
    for name, tree, _ in files():
        own = name.removeprefix("vfife/")
        excepted = next((one for one in EXCEPTIONS if own.startswith(one)), None)
        if not own.startswith(DECIDING):
            continue
        found = [f"{name}:{line} {what}" for line, what in faults(tree)]
        found += [f"{name}:{one.line} imports {one.module}" for one in imports(name, tree) if one.module.split(".")[0] == "scipy"]
        found += [f"{name}:{one.line} imports from math" for one in imports(name, tree) if one.module.startswith("math.")]
        if excepted is None:
            offenders += found
        elif found:
            seen.add(excepted)
    report("The last bits of these differ between machines, and what they compute decides a run:", sorted(offenders))
    assert seen == EXCEPTIONS.keys(), "an exception that nothing needs"


@pytest.mark.parametrize(
    "text",
    ["a @ b", "x**2", "x **= y", "math.sin(x)", "math.log2(x)", "np.linalg.svd(a)", "np.exp(x)", "np.interp(x, y, z)", "a.dot(b)", "pow(x, 3)",
     "np.polynomial.legendre.leggauss(3)"],
)  # fmt: skip
def test_the_rule_sees(text: str) -> None:
    assert list(faults(ast.parse(text)))


@pytest.mark.parametrize(
    "text", ["a * b", "2.0**-52", "10**6", "math.sqrt(x)", "np.sqrt(x)", "except_(np.linalg.LinAlgError)", "np.cumsum(x)", "f(**x)"]
)
def test_the_rule_lets_through(text: str) -> None:
    assert not list(faults(ast.parse(text)))
