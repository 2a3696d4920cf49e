"""From a gathered text to a callable: compiled by LLVM and kept as object code, or run as plain Python."""

from __future__ import annotations

import ctypes
import math
import platform
from collections.abc import Callable
from typing import Any

import numpy as np

from . import cache
from .lock import WRITING
from .native import Code, llvmlite_version, optimised_code, processor
from .values import Array

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
    integers of 32 bits. SourceError where the text says more than :mod:`~vfife.codegen.plain` can write.
    """
    kinds = arguments.split()
    parts = (body, name, arguments, cache.sources().decode(), llvmlite_version(), platform.machine(), *processor())
    file = f"loop-{cache.digest(part.encode() for part in parts)}.o"
    with WRITING:
        code = cache.read(file)
        if code is None:
            from .plain import compiled_text

            cache.missed()
            items = {"f": "d", "u": "u"}
            code = optimised_code(compiled_text(body, name, [Array(items[kind[0]], int(kind[1:])) if kind[0] in items else kind for kind in kinds]))
            cache.keep(file, code)
        return _Called(code, kinds)


class _Called:
    """A compiled function, called with numbers and contiguous arrays, each an address and its shape."""

    def __init__(self, code: bytes, kinds: list[str]) -> None:
        self.kinds = kinds
        types: list[Any] = []
        for kind in kinds:
            if kind[0] in DTYPES:
                types += [ctypes.c_void_p, *[ctypes.c_int64] * int(kind[1:])]
            else:
                types.append(ctypes.c_double if kind == "d" else ctypes.c_int64)
        self.code = Code(code, "entry", ctypes.CFUNCTYPE(None, *types))

    def __call__(self, *arguments: Any) -> None:
        given: list[Any] = []
        for kind, value in zip(self.kinds, arguments, strict=True):
            if kind[0] not in DTYPES:
                given.append(value)
                continue
            if value.dtype != DTYPES[kind[0]] or value.ndim != int(kind[1:]) or not value.flags.c_contiguous:
                raise TypeError(f"an array of {value.dtype} and shape {value.shape} was given where one of kind {kind} is expected")
            given += [value.ctypes.data, *value.shape]
        self.code.function(*given)
