"""From a gathered text to a callable: compiled by numba and kept as object code, or run as plain Python.

numba is imported where a text is compiled; what it made is read from the cache and called without it.
"""

from __future__ import annotations

import ctypes
import math
import platform
import re
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from . import cache
from .lock import WRITING
from .native import Code, object_code, processor

OPTIONS: dict[str, Any] = {"error_model": "numpy", "no_rewrites": True, "no_cfunc_wrapper": True, "no_cpython_wrapper": True, "_nrt": False}
CALLED = ("step", "functions", "resize")  # from several places: written into each, they would be compiled as often
EFFORT = 3  # of LLVM's code generator, as numba has it
DTYPES = {"f": np.float64, "u": np.uint32}


def interpreted(body: str, name: str) -> Callable[..., Any]:
    """The function ``name`` of a text run as plain Python: slow, and the same bits."""
    space: dict[str, Any] = {"math": math, "jit": lambda f: f}
    exec(compile(body, f"<vfife {name}>", "exec"), space)  # the text is our own and the user's laws, never a model file's
    function: Callable[..., Any] = space[name]
    return function


def compiled(body: str, name: str, arguments: str) -> Callable[..., Any]:
    """The function ``name`` of a text, from the cache or compiled; it returns nothing.

    ``arguments`` are kinds, one each: ``d`` a number, ``i`` an integer, ``f2`` an array of numbers of two dimensions, ``u1`` one of unsigned
    integers of 32 bits.
    """
    from importlib.metadata import version

    kinds = arguments.split()
    parts = (body, name, arguments, version("numba"), version("llvmlite"), sys.version, platform.machine(), *processor())
    file = f"loop-{cache.digest(part.encode() for part in parts)}.o"
    with WRITING:
        code = cache.read(file)
        if code is None:
            cache.missed()
            code = object_code(_machine_text(body, name, kinds), EFFORT)
            cache.keep(file, code)
        return _Called(code, kinds)


def _machine_text(body: str, name: str, kinds: list[str]) -> str:
    """LLVM's text of the function, called ``entry``, as numba writes it: a place for the answer and one for an error go first."""
    import numba
    from numba import types

    space: dict[str, Any] = {"math": math, "jit": numba.njit(forceinline=True, **OPTIONS), "called": numba.njit(**OPTIONS)}
    source = body.replace(f"@jit\ndef {name}(", f"def {name}(")
    for part in CALLED:
        source = source.replace(f"@jit\ndef {part}(", f"@called\ndef {part}(")
    exec(compile(source, f"<vfife {name}>", "exec"), space)  # our own text and the user's laws
    numbers = {"d": types.float64, "i": types.int64}
    signature = [numbers.get(kind) or types.Array(numba.from_dtype(np.dtype(DTYPES[kind[0]])), int(kind[1:]), "C") for kind in kinds]
    function = numba.njit(tuple(signature), nogil=True, **OPTIONS)(space[name])
    overload: Any = next(iter(function.overloads.values()))
    text: str = overload.library.get_llvm_str()
    symbol = overload.fndesc.llvm_func_name
    found = re.search(r'define [^@\n]*@("?)' + re.escape(symbol) + r"\1\(", text)
    if found is None:
        raise ImportError(f"numba gave no function {symbol}")
    return re.sub(rf'@"?{re.escape(symbol)}"?(?=\()', "@entry", text)


class _Called:
    """A compiled function, called with numbers and contiguous arrays.

    numba takes an array as owner, parent, number and size of its items, address, shape and strides.
    """

    def __init__(self, code: bytes, kinds: list[str]) -> None:
        self.kinds = kinds
        types: list[Any] = []
        for kind in kinds:
            if kind[0] in DTYPES:
                types += [*[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 2, ctypes.c_void_p, *[ctypes.c_int64] * 2 * int(kind[1:])]
            else:
                types.append(ctypes.c_double if kind == "d" else ctypes.c_int64)
        self.code = Code(code, "entry", ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *types))

    def __call__(self, *arguments: Any) -> None:
        given: list[Any] = []
        for kind, value in zip(self.kinds, arguments, strict=True):
            if kind[0] not in DTYPES:
                given.append(value)
                continue
            if value.dtype != DTYPES[kind[0]] or value.ndim != int(kind[1:]) or not value.flags.c_contiguous:
                raise TypeError(f"an array of {value.dtype} and shape {value.shape} was given where one of kind {kind} is expected")
            given += [None, None, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides]
        answer, error = ctypes.c_int64(), ctypes.c_void_p()
        self.code.function(ctypes.addressof(answer), ctypes.addressof(error), *given)
