"""Machine code by LLVM: what this processor is, object code of a text, and functions of it in memory, called
without Python's lock.

From a gathered text to a callable: compiled by LLVM and kept as object code, or run as plain Python.
"""

from __future__ import annotations

import ctypes
import math
import platform
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..backends.kinds import kinds_of, listed
from ..trace.functiontext import WRITING
from . import cache

LEAST_EFFORT = 0  # effort of LLVM's code generator for what few steps need
EFFORT = 1  # of LLVM's code generator: the same code as with 2 in half the time; nothing of it changes a bit
OPTIMISED = 2  # of the same, for loops


@lru_cache(maxsize=1)
def _target() -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


def llvmlite_version() -> str:
    """Version of the compiler, which is not loaded for it."""
    import llvmlite

    return str(llvmlite.__version__)


def processor() -> tuple[str, str]:
    """Name and features of this machine's processor, as LLVM has them."""
    llvm = _target()
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def widest() -> int:
    """Doubles in a vector register of this machine: 8 with AVX-512, 4 with AVX, else 2."""
    features = set(processor()[1].split(","))
    return 8 if "+avx512f" in features else 4 if "+avx" in features else 2


# Lanes of a step with contact, on every processor. Eight are not faster on all that have AVX-512: a step of
# the four-bar took 1.2 times as long in eight lanes as in four on one of two processors. On the other it took
# 0.74 times as long with one contact, 0.82 with three, 1.0 with six, and 1.09 with one contact beside four
# elastic elements.
CONTACT_LANES = 4


def stream_lanes(contacts: int) -> int:
    """Count the lanes of a stream of simulations of one topology on this machine.

    Without contacts eight lanes were faster wherever they were measured: members took 1.2 to 1.5 times the
    processor time in four lanes with ideal joints, 1.13 to 1.22 times with elastic links
    (``benchmarks/lanes.py``). Results have the same bits in any number of lanes.

    ``contacts``: contacts of the topology (1). Returns 8 with AVX-512 without contacts, else 4, or 2 without
    AVX.
    """
    return min(widest(), CONTACT_LANES) if contacts else widest()


def machine(effort: int = EFFORT) -> Any:
    """LLVM's code generator for this processor."""
    name, features = processor()
    target = _target().Target.from_default_triple()
    return target.create_target_machine(
        cpu=name, features=features, opt=effort, codemodel="jitdefault", jit=True
    )


def object_code(text: str, effort: int = EFFORT) -> bytes:
    """Object code of a text."""
    with WRITING:
        module = _target().parse_assembly(text)
        module.verify()
        code: bytes = machine(effort).emit_object(module)
    return code


def optimised_code(text: str, wide: bool = False) -> bytes:
    """Object code of a text with loops and calls: these are written out, what does not change is kept in
    registers. Nothing of it changes a bit.

    Loops of a step have a few turns each, over joints or rows of a profile. They stay loops: unrolled, they
    take twice as long to compile, and ideal joints take a twelfth longer to step. In ``wide`` texts, loops
    over rows of matrices, turns that do not wait for each other are taken several at a time; sums keep their
    order, because nothing allows LLVM to change it.
    """
    with WRITING:
        llvm = _target()
        module = llvm.parse_assembly(text)
        module.verify()
        code = machine(OPTIMISED)
        options = llvm.create_pipeline_tuning_options(speed_level=3)
        options.loop_unrolling = options.loop_interleaving = False
        options.loop_vectorization = wide
        passes = llvm.create_pass_builder(code, options)
        passes.getModulePassManager().run(module, passes)
        emitted: bytes = code.emit_object(module)
    return emitted


def simplified(text: str) -> Any:
    """LLVM's module of a text, variables in registers and small functions in those that call them: a
    twentieth of the time of optimisation.
    """
    with WRITING:
        llvm = _target()
        module = llvm.parse_assembly(text)
        module.verify()
        passes = llvm.create_new_module_pass_manager()
        passes.add_always_inliner_pass()
        passes.add_sroa_pass()
        passes.add_simplify_cfg_pass()
        passes.add_global_dead_code_eliminate_pass()
        passes.add_strip_dead_prototype_pass()
        passes.run(module, llvm.create_pass_builder(machine(), llvm.create_pipeline_tuning_options()))
        return module


class Code:
    """Functions of object codes in memory, which it keeps; those of one code may call those of another."""

    def __init__(self, *codes: bytes) -> None:
        llvm = _target()
        with WRITING:
            self.engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine())
            for one in codes:
                self.engine.add_object_file(llvm.ObjectFileRef.from_data(one))
            self.engine.finalize_object()

    def named(self, name: str, kind: Any) -> Any:
        """One of its functions, of a type of ctypes."""
        return kind(self.engine.get_function_address(name))


DTYPES = {"f": np.float64, "u": np.uint32, "l": np.int64}


def interpreted(body: str, name: str) -> Callable[..., Any]:
    """The function ``name`` of a text run as plain Python: slow, and the same bits."""
    space: dict[str, Any] = {"math": math}
    exec(
        compile(body, f"<vfife {name}>", "exec"), space
    )  # the text is our own and the user's laws, never a model file's
    function: Callable[..., Any] = space[name]
    return function


def compiled(body: str, name: str, arguments: str) -> Callable[..., Any]:
    """The function ``name`` of a text, from the cache or compiled; it returns nothing.

    ``arguments`` are kinds, one each: ``d`` a number, ``i`` an integer, ``f2`` an array of numbers of two
    dimensions, ``u1`` one of unsigned integers of 32 bits. SourceError where the text says more than
    :mod:`~vfife.compiler.backends.plain` can write.
    """
    return library(body, {name: arguments})[name]


def library(
    body: str, entries: dict[str, str], wide: bool = False, write: Callable[[], str] | None = None
) -> dict[str, Called]:
    """Several functions of a text, as :func:`compiled` has one: by name, with the kinds of their arguments.

    They share one file of the cache.

    Kinds that begin with ``->`` say that an integer is returned. ``wide``: loops over rows of matrices, see
    :func:`~vfife.compiler.runtime.native.optimised_code`. With ``write``, which writes the text, ``body`` is
    only what decides it: to gather a text takes longer than to load its code.
    """

    def text() -> str:
        from ..backends.plain import library_text

        signatures = {f"entry_{name}": (name, kinds_of(kinds)) for name, kinds in entries.items()}
        return library_text(write() if write else body, signatures)

    code = stored_code((body, repr((entries, wide))), text, lambda text: optimised_code(text, wide))
    with WRITING:
        memory = Code(code)
        return {name: Called(memory, f"entry_{name}", arguments) for name, arguments in entries.items()}


def stored_code(decisive: tuple[str, ...], write: Callable[[], str], make: Callable[[str], bytes]) -> bytes:
    """Object code of a text, from the cache or made; what is ``decisive`` for the text, beside vfife's own,
    names its file.
    """
    parts = (*decisive, cache.sources().decode(), llvmlite_version(), platform.machine(), *processor())
    file = f"loop-{cache.digest(part.encode() for part in parts)}.o"
    with WRITING:
        code = cache.read(file)
        if code is None:
            cache.missed()
            code = make(write())
            cache.keep(file, code)
        return code


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
    """A compiled function of a code in memory, called with numbers, contiguous arrays, each an address and
    its shape, and NamedTuples of these.
    """

    def __init__(self, code: Code, name: str, arguments: str) -> None:
        kinds = listed(arguments)
        self.kinds = [(kind[0] if kind[0] in DTYPES else "", int(kind[1:] or 0)) for kind in kinds]
        self.code = code  # kept as long as somebody may call it
        self.function = code.named(
            name, signature(kinds, ctypes.c_int64 if arguments.startswith("->") else None)
        )

    def __call__(self, *arguments: Any) -> Any:
        return self.function(
            *flat(self.kinds, arguments if len(arguments) == len(self.kinds) else spread(arguments))
        )

    def bound(self, *first: Any) -> Callable[..., Any]:
        """The function with its first arguments given: their addresses are looked up once, which takes as
        long as a hundred steps.
        """
        own = spread(first)
        signatures, rest = flat(self.kinds[: len(own)], own), self.kinds[len(own) :]

        def call(*last: Any) -> Any:
            _ = own  # arrays live as long as somebody may call it
            return self.function(*signatures, *flat(rest, last))

        return call


def spread(arguments: Sequence[Any]) -> list[Any]:
    """Arguments one by one, those in a NamedTuple too."""
    return [
        one for argument in arguments for one in (argument if isinstance(argument, tuple) else (argument,))
    ]


def flat(kinds: list[tuple[str, int]], arguments: Sequence[Any]) -> list[Any]:
    """Numbers as they are, arrays as their addresses and shapes; TypeError for an array of another kind."""
    values: list[Any] = []
    for (item, dimensions), value in zip(kinds, arguments, strict=True):
        if not item:
            values.append(value)
            continue
        if value.dtype != DTYPES[item] or value.ndim != dimensions or not value.flags.c_contiguous:
            expected = f"{item}{dimensions}"
            raise TypeError(
                f"an array of {value.dtype} and shape {value.shape} was given where one of kind {expected} is"
                " expected"
            )
        values += (value.ctypes.data, *value.shape)
    return values
