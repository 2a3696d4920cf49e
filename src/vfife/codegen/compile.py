"""From a gathered text to a callable: compiled by LLVM and kept as object code, or run as plain Python."""

from __future__ import annotations

import ctypes
import math
import platform
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import cache, native
from .lock import WRITING
from .values import Array

DTYPES = {"f": np.float64, "u": np.uint32, "l": np.int64}
ITEMS = {"f": "d", "u": "u", "l": "l"}  # what the items of an array are called in a text


def interpreted(body: str, name: str) -> Callable[..., Any]:
    """The function ``name`` of a text run as plain Python: slow, and the same bits."""
    space: dict[str, Any] = {"math": math}
    exec(compile(body, f"<vfife {name}>", "exec"), space)  # the text is our own and the user's laws, never a model file's
    function: Callable[..., Any] = space[name]
    return function


def compiled(body: str, name: str, arguments: str) -> Callable[..., Any]:
    """The function ``name`` of a text, from the cache or compiled; it returns nothing.

    ``arguments`` are kinds, one each: ``d`` a number, ``i`` an integer, ``f2`` an array of numbers of two dimensions, ``u1`` one of unsigned
    integers of 32 bits. SourceError where the text says more than :mod:`~vfife.codegen.plain` can write.
    """
    return library(body, {name: arguments})[name]


def library(body: str, entries: dict[str, str], wide: bool = False, write: Callable[[], str] | None = None) -> dict[str, Called]:
    """Several functions of a text, as :func:`compiled` has one: by name, with the kinds of their arguments. They share one file of the cache.

    Kinds that begin with ``->`` say that an integer is returned. ``wide``: loops over rows of matrices, see
    :func:`~vfife.codegen.native.optimised_code`. With ``write``, which writes the text, ``body`` is only what decides it: to gather a text takes
    longer than to load its code.
    """

    def text() -> str:
        from .plain import library_text

        known = {f"entry_{name}": (name, [kind_of(one) for one in listed(kinds)]) for name, kinds in entries.items()}
        return library_text(write() if write else body, known)

    code = stored_code((body, repr(entries)), text, wide)
    with WRITING:
        memory = native.Code(code)
        return {name: Called(memory, f"entry_{name}", arguments) for name, arguments in entries.items()}


def stored_code(decisive: tuple[str, ...], write: Callable[[], str], wide: bool = False) -> bytes:
    """Optimised object code of a text, from the cache or compiled; what is ``decisive`` for the text, beside vfife's own, names its file."""
    parts = (*decisive, repr(wide), cache.sources().decode(), native.llvmlite_version(), platform.machine(), *native.processor())
    file = f"loop-{cache.digest(part.encode() for part in parts)}.o"
    with WRITING:
        code = cache.read(file)
        if code is None:
            cache.missed()
            code = native.optimised_code(write(), wide)
            cache.keep(file, code)
        return code


def listed(arguments: str) -> list[str]:
    """Kinds of the arguments."""
    return arguments.removeprefix("->").split()


def kind_of(word: str) -> Any:
    """A kind of :mod:`~vfife.codegen.plain`."""
    return Array(ITEMS[word[0]], int(word[1:])) if word[0] in ITEMS else word


def signature(kinds: list[str], returns: Any) -> Any:
    """Type of a function in C that takes such arguments: a number each, or an address and a shape."""
    types: list[Any] = []
    for kind in kinds:
        if kind[0] in DTYPES:
            types += [ctypes.c_void_p, *[ctypes.c_int64] * int(kind[1:])]
        else:
            types.append(ctypes.c_double if kind == "d" else ctypes.c_int64)
    return ctypes.CFUNCTYPE(returns, *types)


class Called:
    """A compiled function of a code in memory, called with numbers and contiguous arrays, each an address and its shape."""

    def __init__(self, code: native.Code, name: str, arguments: str) -> None:
        kinds = listed(arguments)
        self.kinds = [(kind[0] if kind[0] in DTYPES else "", int(kind[1:] or 0)) for kind in kinds]
        self.code = code  # kept as long as somebody may call it
        self.function = code.named(name, signature(kinds, ctypes.c_int64 if arguments.startswith("->") else None))

    def __call__(self, *arguments: Any) -> Any:
        return self.function(*flat(self.kinds, arguments))

    def bound(self, *first: Any) -> Callable[..., Any]:
        """The function with its first arguments given: their addresses are looked up once, which takes as long as a hundred steps."""
        known, rest = flat(self.kinds[: len(first)], first), self.kinds[len(first) :]

        def call(*last: Any) -> Any:
            _ = first  # arrays live as long as somebody may call it
            return self.function(*known, *flat(rest, last))

        return call


def flat(kinds: list[tuple[str, int]], arguments: Sequence[Any]) -> list[Any]:
    """Numbers as they are, arrays as their addresses and shapes; TypeError for an array of another kind."""
    given: list[Any] = []
    for (item, dimensions), value in zip(kinds, arguments, strict=True):
        if not item:
            given.append(value)
            continue
        if value.dtype != DTYPES[item] or value.ndim != dimensions or not value.flags.c_contiguous:
            wanted = f"{item}{dimensions}"
            raise TypeError(f"an array of {value.dtype} and shape {value.shape} was given where one of kind {wanted} is expected")
        given += (value.ctypes.data, *value.shape)
    return given
