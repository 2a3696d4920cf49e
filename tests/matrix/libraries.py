"""Libraries of another machine, imitated: what BLAS, LAPACK, the C library and NumPy may round otherwise is
one unit in the last place larger.

A machine of another kind (macOS, musl, AArch64, MKL) cannot be had here. What its libraries decide can: every
function whose last bit no standard fixes is wrapped, in :mod:`math` and in NumPy, before the package is
imported. A result that changes then depends on one of them. Left alone are + - * / and square roots,
remainders and roundings, which are the same everywhere, and ``@``, which cannot be replaced and which
``tests/architecture`` forbids.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from types import ModuleType
from typing import Any

MATH = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "exp2", "expm1", "log", "log1p", "log2",
    "log10", "pow", "hypot", "dist", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "erf", "erfc",
    "gamma", "lgamma", "cbrt",
)  # fmt: skip
NUMPY = (
    "sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "exp", "exp2", "expm1", "log", "log1p",
    "log2", "log10", "power", "float_power", "hypot", "sinh", "cosh", "tanh", "arcsinh", "arccosh", "arctanh",
    "cbrt", "logaddexp", "sinc", "dot", "vdot", "inner", "outer", "tensordot",
    "einsum", "matmul", "interp", "convolve", "correlate", "polyfit", "polyval", "corrcoef", "cov", "vander",
    "kron",
)  # fmt: skip
LINEAR = (
    "norm",
    "solve",
    "inv",
    "pinv",
    "lstsq",
    "svd",
    "eig",
    "eigh",
    "eigvals",
    "eigvalsh",
    "qr",
    "det",
    "slogdet",
    "cholesky",
    "cond",
)
FOURIER = ("fft", "ifft", "rfft", "irfft", "hfft", "ihfft")


def imitate() -> None:
    """Wraps them all, in the modules that are shared by a process."""
    import numpy as np

    with suppress(ImportError):
        import dask.array  # noqa: F401  it looks whether the functions of NumPy are those that it knows
    for name in MATH:
        if hasattr(math, name):
            setattr(math, name, higher(getattr(math, name)))
    for module, names in ((np, NUMPY), (np.linalg, LINEAR), (np.fft, FOURIER)):
        replaced(module, names)


def replaced(module: ModuleType, names: tuple[str, ...]) -> None:
    """Wraps functions of a module of NumPy; the methods of a ufunc stay as they are."""
    for name in names:
        if hasattr(module, name):
            setattr(module, name, higher(getattr(module, name)))


def higher(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function with every result one unit in the last place further from zero; what is zero, infinite or
    whole numbers stays.
    """

    @wraps(function)
    def wrapped(*arguments: Any, **named: Any) -> Any:
        return raised(function(*arguments, **named))

    for part in ("reduce", "accumulate", "outer", "at", "nin", "nout", "identity", "types"):
        if hasattr(function, part):
            setattr(wrapped, part, getattr(function, part))
    return wrapped


def raised(found: Any) -> Any:
    """Numbers, arrays and tuples of them, each one unit further from zero."""
    import numpy as np

    if isinstance(found, float) and not isinstance(found, np.floating):
        return (
            math.nextafter(found, math.copysign(math.inf, found)) if found and math.isfinite(found) else found
        )
    if isinstance(found, np.ndarray | np.floating) and found.dtype == float:
        next_one = np.nextafter(found, np.copysign(np.inf, found))
        unchanged = (np.asarray(found) == 0.0) | ~np.isfinite(np.asarray(found))
        answer = np.where(unchanged, found, next_one)
        return answer if isinstance(found, np.ndarray) else np.float64(answer)
    if isinstance(found, tuple):
        every = [raised(one) for one in found]
        return type(found)(*every) if hasattr(found, "_fields") or type(found) is not tuple else tuple(every)
    return found
