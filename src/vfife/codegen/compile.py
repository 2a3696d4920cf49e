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
ITEMS = {"f": "d", "u": "u"}  # what the items of an array are called in a text


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
    return library(body, {name: arguments})[name]


def library(body: str, entries: dict[str, str], wide: bool = False, write: Callable[[], str] | None = None) -> dict[str, Callable[..., Any]]:
    """Several functions of a text, as :func:`compiled` has one: by name, with the kinds of their arguments. They share one file of the cache.

    ``wide``: loops over rows of matrices, see :func:`~vfife.codegen.native.optimised_code`. With ``write``, which writes the text, ``body`` is only
    what decides it: to gather a text takes longer than to load its code.
    """
    parts = (body, repr((entries, wide)), cache.sources().decode(), llvmlite_version(), platform.machine(), *processor())
    file = f"loop-{cache.digest(part.encode() for part in parts)}.o"
    kinds = {name: arguments.split() for name, arguments in entries.items()}
    with WRITING:
        code = cache.read(file)
        if code is None:
            from .plain import library_text

            cache.missed()
            known = {f"entry_{name}": (name, [_kind(one) for one in kinds[name]]) for name in entries}
            code = optimised_code(library_text(write() if write else body, known), wide)
            cache.keep(file, code)
        memory = Code(code, f"entry_{next(iter(entries))}", signature(kinds[next(iter(entries))]))
        return {name: _Called(memory, f"entry_{name}", kinds[name]) for name in entries}


def _kind(word: str) -> Any:
    """A kind of :mod:`~vfife.codegen.plain`."""
    return Array(ITEMS[word[0]], int(word[1:])) if word[0] in ITEMS else word


def signature(kinds: list[str]) -> Any:
    """Type of a function in C that takes such arguments: a number each, or an address and a shape."""
    types: list[Any] = []
    for kind in kinds:
        if kind[0] in DTYPES:
            types += [ctypes.c_void_p, *[ctypes.c_int64] * int(kind[1:])]
        else:
            types.append(ctypes.c_double if kind == "d" else ctypes.c_int64)
    return ctypes.CFUNCTYPE(None, *types)


class _Called:
    """A compiled function of a code in memory, called with numbers and contiguous arrays, each an address and its shape."""

    def __init__(self, code: Code, name: str, kinds: list[str]) -> None:
        self.kinds = [(kind[0] if kind[0] in DTYPES else "", int(kind[1:] or 0)) for kind in kinds]
        self.code = code  # kept as long as somebody may call it
        self.function = code.named(name, signature(kinds))

    def __call__(self, *arguments: Any) -> None:
        given: list[Any] = []
        for (item, dimensions), value in zip(self.kinds, arguments, strict=True):
            if not item:
                given.append(value)
                continue
            if value.dtype != DTYPES[item] or value.ndim != dimensions or not value.flags.c_contiguous:
                wanted = f"{item}{dimensions}"
                raise TypeError(f"an array of {value.dtype} and shape {value.shape} was given where one of kind {wanted} is expected")
            given += (value.ctypes.data, *value.shape)
        self.function(*given)
