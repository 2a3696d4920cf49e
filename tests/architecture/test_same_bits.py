"""What a run, its measures, ranges and decisions are computed with: nothing whose last bit depends on a
processor or a library.

Forbidden are functions of the C library and of NumPy that no standard rounds, BLAS and LAPACK (``@`` too),
powers, which are the C library's, sorts that leave the order of equals open, and draws that NumPy computes
from uniform ones; ``vfife.numerics`` has them with the same bits everywhere. Fine are + - * / and roots,
remainders, roundings, comparisons and NumPy's sums, whose order is that of its text.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from architecture.sources import SOURCE, report

MATH = {
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "exp2", "expm1", "log", "log1p", "log2",
    "log10", "pow", "hypot", "dist", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "erf", "erfc",
    "gamma", "lgamma", "cbrt", "sumprod",
}  # fmt: skip
NUMPY = {
    "sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "exp", "exp2", "expm1", "log", "log1p",
    "log2", "log10", "power", "float_power", "hypot", "sinh", "cosh", "tanh", "arcsinh", "arccosh", "arctanh",
    "cbrt", "sinc", "logaddexp", "dot", "vdot", "vecdot", "inner", "tensordot",
    "einsum", "matmul", "matvec", "vecmat", "interp", "convolve", "correlate", "polyfit", "polyval",
    "corrcoef", "cov", "geomspace", "logspace", "linalg", "fft", "polynomial", "histogram", "histogram2d",
    "kron", "angle", "i0",
}  # fmt: skip
DRAWS = {"uniform", "normal", "standard_normal", "exponential", "choice", "shuffle", "permutation"}
ALLOWED = {"LinAlgError"}  # of np.linalg: an exception
# Packages, or files of them, from which a run, its measures and its decisions come.
DECIDING = (
    "assembly", "compiler", "schema", "gallery.py", "kernels", "kinematics", "laws", "model", "modelfile",
    "numerics", "solvers", "studies", "identification", "dynamics", "tribology", "simulation", "measures",
    "results", "store", "report", "units.py",
)  # fmt: skip
# Files, or folders, that may, and why.
EXCEPTIONS = {
    "measures/modes.py": (
        "natural frequencies of up to thousands of coordinates are LAPACK's; `vfife run` prints none"
    ),
    "measures/spectral.py": (
        "spectra are a fast Fourier transform's, known to rounding; `vfife run` prints none, and nothing is"
        " decided by them"
    ),
    "measures/impact.py": "curves of a law for a figure start from steps in even ratios",
    "results/export.py": "writes MATLAB's files",
    "compiler/trace/source.py": "a power of two whole numbers, which is exact",
    "laws/agreement.py": "states at which loops are compared with Python, whatever they are",
    "laws/expressions.py": "a power of two whole numbers, which is exact",
    "model/geometry/tabulated.py": "values of a polynomial by Horner, products and sums of NumPy's own",
    "model/drawing/strokes.py": "draws",
    "model/outlines.py": "chooses in which order the corners of a body are drawn",
    "numerics/scalar.py": "math.pow of zeros and infinities, which is exact",
    "studies/spec/distributions.py": (
        "values of cases are rounded to ten digits; SciPy's Sobol' points are whole numbers over a power"
        " of two"
    ),
    "identification/": "compares records with data",
    "studies/spec/limits.py": "statistics of results",
    "studies/methods/local_search.py": "a search that chooses its next cases",
    "units.py": "powers of fractions, and of forty digits in decimal arithmetic",
}


def files() -> Iterator[str]:
    """The files of ``DECIDING``."""
    for name in DECIDING:
        place = SOURCE / name
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            yield path.relative_to(SOURCE).as_posix()


def offences(text: str) -> list[str]:
    """What of a file no two machines round alike, with its line."""
    return [f"{line}: {what}" for line, what in sorted(set(found(ast.parse(text))))]


def found(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp | ast.AugAssign):
            yield from operators(node)
        elif isinstance(node, ast.ImportFrom) and node.module is not None and not node.level:
            yield from imported(node)
        elif isinstance(node, ast.Import):
            yield from (
                (node.lineno, one.name) for one in node.names if one.name.partition(".")[0] == "scipy"
            )
        elif isinstance(node, ast.Attribute):
            yield from attributes(node)
        elif isinstance(node, ast.Call):
            yield from calls(node)


def operators(node: ast.BinOp | ast.AugAssign) -> Iterator[tuple[int, str]]:
    if isinstance(node.op, ast.MatMult):
        yield node.lineno, "@, which is BLAS"
    if isinstance(node.op, ast.Pow):
        sides = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.target, node.value)
        base, exponent = (one.operand if isinstance(one, ast.UnaryOp) else one for one in sides)
        exact = (
            isinstance(base, ast.Constant)
            and isinstance(exponent, ast.Constant)
            and isinstance(exponent.value, int)
        )
        if not (exact and (isinstance(base.value, int) or base.value in (0.5, 2.0))):
            yield (
                node.lineno,
                "**, which is the C library's pow: write x * x, math.sqrt or vfife.numerics.scalar.power",
            )


def imported(node: ast.ImportFrom) -> Iterator[tuple[int, str]]:
    module = str(node.module)
    whole = module.startswith(("scipy", "numpy.linalg", "numpy.fft"))
    some = {"math": MATH, "numpy": NUMPY}.get(module, set())
    yield from ((node.lineno, f"{module}.{one.name}") for one in node.names if whole or one.name in some)


def attributes(node: ast.Attribute) -> Iterator[tuple[int, str]]:
    owner = ast.unparse(node.value)
    if (owner == "math" and node.attr in MATH) or (owner == "np" and node.attr in NUMPY - {"linalg"}):
        yield node.lineno, f"{owner}.{node.attr}"
    if owner == "np.linalg" and node.attr not in ALLOWED:
        yield node.lineno, f"np.linalg.{node.attr}"


def calls(node: ast.Call) -> Iterator[tuple[int, str]]:
    stable = any(
        one.arg == "kind" and isinstance(one.value, ast.Constant) and one.value.value == "stable"
        for one in node.keywords
    )
    name = (
        node.func.attr
        if isinstance(node.func, ast.Attribute)
        else node.func.id
        if isinstance(node.func, ast.Name)
        else ""
    )
    if name == "argsort" and not stable:
        yield (
            node.lineno,
            'argsort without kind="stable": equals come in an order that depends on the processor',
        )
    if (
        isinstance(node.func, ast.Attribute)
        and name in {"dot", "trace", *DRAWS}
        and not isinstance(node.func.value, ast.Name)
    ):
        yield node.lineno, f".{name}()"
    if isinstance(node.func, ast.Name) and name == "pow":
        yield node.lineno, "pow()"


@pytest.mark.slow("parses every file")
def test_what_decides_a_run_has_the_same_bits_everywhere() -> None:
    wrong, needed = [], set()
    for name in files():
        found = offences((SOURCE / name).read_text(encoding="utf-8"))
        excepted = next(
            (one for one in EXCEPTIONS if name == one or (one.endswith("/") and name.startswith(one))), None
        )
        if excepted is None:
            wrong += [f"{name}:{one}" for one in found]
        elif found:
            needed.add(excepted)
    report("Use vfife.numerics, or give the reason in EXCEPTIONS:", wrong)
    assert needed == EXCEPTIONS.keys(), "an exception that nothing needs"


@pytest.mark.parametrize(
    "text",
    [
        "import numpy as np\nx = np.sin(y)",
        "import math\nx = math.hypot(y, z)",
        "from math import log2",
        "x = a @ b",
        "x = a ** 2",
        "x **= 2",
        "x = 2.0 ** n",
        "import numpy as np\nx = np.linalg.norm(y)",
        "from scipy.linalg import eigh",
        "import scipy.special",
        "x = y.argsort()",
        "import numpy as np\nx = np.argsort(y)",
        "import numpy as np\nx = np.random.default_rng(1).normal(0.0, 1.0)",
        "x = a.b.dot(c)",
        "x = a ** -0.5",
        "import numpy as np\nx = np.polynomial.legendre.leggauss(3)",
        "from numpy.linalg import svd",
        "import numpy as np\nx = np.fft.rfft(y)",
        "x = pow(a, b)",
    ],
)
def test_the_rule_sees(text: str) -> None:
    assert offences(text)


@pytest.mark.parametrize(
    "text",
    [
        "x = a * a",
        "x = 2**20",
        "x = 2.0**-52",
        "import numpy as np\nx = np.sqrt(y)",
        'import numpy as np\nx = np.argsort(y, kind="stable")',
        "x = {**a}",
        "import numpy as np\ntry:\n    f()\nexcept np.linalg.LinAlgError:\n    pass",
        "import math\nx = math.sqrt(y) + math.fsum(z) + math.floor(y)",
        "from ..numerics.scalar import sin\nx = sin(y)",
    ],
)
def test_the_rule_allows(text: str) -> None:
    assert not offences(text)
