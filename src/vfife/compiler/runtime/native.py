"""Machine code by LLVM: properties of this processor, object code of a text, and functions in memory that run
without Python's global lock.

A text becomes a callable either compiled by LLVM, with its object code kept in the cache, or as plain Python.
"""

from __future__ import annotations

import ctypes
import math
import platform
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..backends.kinds import Array, Entry, Kind, entry_of
from ..trace.traceable import WRITING
from . import cache

# Optimisation levels of LLVM's code generator, none of which changes a bit: for code that few steps need; for
# straight-line code, for which 2 gives the same code in twice the time; and for loops.
LEAST_EFFORT = 0
EFFORT = 1
OPTIMISED = 2


@lru_cache(maxsize=1)
def _target() -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


def llvmlite_version() -> str:
    """Return the version of llvmlite, without loading LLVM."""
    import llvmlite

    return str(llvmlite.__version__)


def processor() -> tuple[str, str]:
    """Return name and features of this machine's processor in LLVM's words."""
    llvm = _target()
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def widest() -> int:
    """Return the number of doubles in a vector register: 8 with AVX-512, 4 with AVX, else 2."""
    features = set(processor()[1].split(","))
    return 8 if "+avx512f" in features else 4 if "+avx" in features else 2


# Lanes of a step with contact, on every processor. Eight are not always faster with AVX-512: on one of two
# processors, a step of the four-bar took 1.2 times as long in eight lanes as in four. On the other it took
# 0.74 times as long with one contact, 0.82 with three, 1.0 with six, and 1.09 with one contact and four
# elastic elements.
CONTACT_LANES = 4


def stream_lanes(contacts: int) -> int:
    """Return the number of lanes of a stream of simulations of one topology with so many ``contacts``.

    It is 8 with AVX-512 and no contacts, else 4, or 2 without AVX. Without contacts eight lanes were faster
    in every measurement: cases took 1.2 to 1.5 times the processor time in four lanes with ideal joints, 1.13
    to 1.22 times with elastic links (``benchmarks/lanes.py``). Results have the same bits in any number of
    lanes.
    """
    return min(widest(), CONTACT_LANES) if contacts else widest()


def machine(effort: int = EFFORT) -> Any:
    """Return LLVM's code generator for this processor."""
    name, features = processor()
    target = _target().Target.from_default_triple()
    return target.create_target_machine(
        cpu=name, features=features, opt=effort, codemodel="jitdefault", jit=True
    )


def parsed(text: str) -> Any:
    """Return LLVM's module of a text, verified."""
    module = _target().parse_assembly(text)
    module.verify()
    return module


def object_code(text: str, effort: int = EFFORT) -> bytes:
    """Return the object code of a text in LLVM's language, without optimisation of the text itself."""
    with WRITING:
        code: bytes = machine(effort).emit_object(parsed(text))
    return code


def optimised_code(text: str, wide: bool = False) -> bytes:
    """Return the object code of a text with loops and calls, optimised without changing a bit: functions are
    inlined, and loop-invariant numbers are kept in registers.

    Loops of a step have few rounds, over joints or rows of a profile, and are not unrolled: that would take
    twice as long to compile, and a step of ideal joints would take a twelfth longer. In ``wide`` texts (loops
    over rows of matrices) independent rounds are vectorised; sums keep their order, because the text does not
    permit LLVM to change it.
    """
    with WRITING:
        llvm, module = _target(), parsed(text)
        code = machine(OPTIMISED)
        options = llvm.create_pipeline_tuning_options(speed_level=3)
        options.loop_unrolling = options.loop_interleaving = False
        options.loop_vectorization = wide
        passes = llvm.create_pass_builder(code, options)
        passes.getModulePassManager().run(module, passes)
        emitted: bytes = code.emit_object(module)
    return emitted


def simplified(text: str) -> Any:
    """Return LLVM's module of a text with variables in registers and inlined functions only: it takes a
    twentieth of the time of full optimisation.
    """
    with WRITING:
        llvm, module = _target(), parsed(text)
        passes = llvm.create_new_module_pass_manager()
        passes.add_always_inliner_pass()
        passes.add_sroa_pass()
        passes.add_simplify_cfg_pass()
        passes.add_global_dead_code_eliminate_pass()
        passes.add_strip_dead_prototype_pass()
        passes.run(module, llvm.create_pass_builder(machine(), llvm.create_pipeline_tuning_options()))
        return module


class Code:
    """Object codes in memory, whose functions may call each other. It must live as long as any function of it
    may be called.
    """

    def __init__(self, *codes: bytes) -> None:
        llvm = _target()
        with WRITING:
            self.engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine())
            for code in codes:
                self.engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            self.engine.finalize_object()

    def named(self, name: str, kind: Any) -> Any:
        """Return one of its functions with a type of ctypes."""
        return kind(self.engine.get_function_address(name))


DTYPES = {"d": np.float64, "u": np.uint32, "l": np.int64}


def interpreted(body: str, name: str) -> Callable[..., Any]:
    """Return the function ``name`` of a text as plain Python: slow, with the same bits."""
    space: dict[str, Any] = {"math": math}
    # The text consists of the package's functions and the user's laws; model files contain no code.
    exec(compile(body, f"<vfife {name}>", "exec"), space)
    function: Callable[..., Any] = space[name]
    return function


def compiled(body: str, name: str, arguments: str) -> Callable[..., Any]:
    """Return the function ``name`` of a text, from the cache or compiled; it has no return value.

    ``arguments`` are words for the kinds of its arguments (:func:`~vfife.compiler.backends.kinds.entry_of`).
    Raises SourceError for a text outside the language of :mod:`~vfife.compiler.backends.plain`.
    """
    return library(body, {name: entry_of(arguments)})[name]


def library(
    body: str, entries: dict[str, Entry], wide: bool = False, write: Callable[[], str] | None = None
) -> dict[str, Called]:
    """Return several functions of a text by name, like :func:`compiled`; they share one file of the cache.

    ``wide``: loops over rows of matrices (:func:`optimised_code`). If ``write`` is given, it writes the text
    when the cache has no code, and ``body`` only has to identify it: gathering a text takes longer than
    loading its code.
    """

    def text() -> str:
        from ..backends.plain import library_text

        signatures = {f"entry_{name}": (name, entry.kinds) for name, entry in entries.items()}
        return library_text(write() if write else body, signatures)

    code = stored_code((body, repr((entries, wide))), text, lambda text: optimised_code(text, wide))
    with WRITING:
        memory = Code(code)
        return {name: Called(memory, f"entry_{name}", entry) for name, entry in entries.items()}


def stored_code(decisive: tuple[str, ...], write: Callable[[], str], make: Callable[[str], bytes]) -> bytes:
    """Return the object code of a text from the cache, or ``write`` the text and ``make`` its code.

    ``decisive`` is all that decides the text in addition to the package's own texts.
    """
    parts = (*decisive, cache.sources().decode(), llvmlite_version(), platform.machine(), *processor())
    file = f"loop-{cache.digest(part.encode() for part in parts)}.o"
    with WRITING:
        return cache.stored(file, lambda: make(write()))


def signature(kinds: Sequence[Kind], returns: bool) -> Any:
    """Return the C type of a function with arguments of these kinds; an array is an address and a shape."""
    types: list[Any] = []
    for kind in kinds:
        if isinstance(kind, Array):
            types += [ctypes.c_void_p, *[ctypes.c_int64] * kind.dimensions]
        else:
            types.append(ctypes.c_double if kind == "d" else ctypes.c_int64)
    return ctypes.CFUNCTYPE(ctypes.c_int64 if returns else None, *types)


class Called:
    """A compiled function, called with numbers, contiguous arrays, and NamedTuples of these."""

    def __init__(self, code: Code, name: str, entry: Entry) -> None:
        kinds = spread(entry.kinds)
        # Type and number of dimensions of each array; None for a number.
        self.arrays = [
            (DTYPES[kind.item], kind.dimensions) if isinstance(kind, Array) else None for kind in kinds
        ]
        self.code = code  # kept as long as somebody may call it
        self.function = code.named(name, signature(kinds, entry.returns))

    def __call__(self, *arguments: Any) -> Any:
        """Call the machine code with the arguments of the traced function, each flattened to plain
        numbers.
        """
        return self.function(
            *flat(self.arrays, arguments if len(arguments) == len(self.arrays) else spread(arguments))
        )

    def bound(self, *first: Any) -> Callable[..., Any]:
        """Return the function with its first arguments bound: their addresses are looked up once, which takes
        as long as a hundred steps.
        """
        values = spread(first)
        addresses, last_arrays = flat(self.arrays[: len(values)], values), self.arrays[len(values) :]

        def call(*last: Any) -> Any:
            _ = values  # keeps the arrays alive as long as this function
            return self.function(*addresses, *flat(last_arrays, last))

        return call


def spread(arguments: Sequence[Any]) -> list[Any]:
    """Return arguments one by one, with the fields of NamedTuples in their places."""
    return [
        value
        for argument in arguments
        for value in (argument if isinstance(argument, tuple) else (argument,))
    ]


def flat(arrays: Sequence[tuple[type, int] | None], arguments: Sequence[Any]) -> list[Any]:
    """Return numbers as they are and arrays as their addresses and shapes.

    Raises TypeError for an array of another kind.
    """
    values: list[Any] = []
    for array, value in zip(arrays, arguments, strict=True):
        if array is None:
            values.append(value)
            continue
        (dtype, dimensions), flags = array, value.flags
        if value.dtype != dtype or value.ndim != dimensions or not flags.c_contiguous:
            raise TypeError(
                f"an array of {value.dtype} and shape {value.shape} was given where one of {dtype.__name__}"
                f" with {dimensions} dimensions, row by row, is expected"
            )
        # The buffer's address is found four times as fast as ``ctypes.data``, but exists only for arrays that
        # have numbers and may be written.
        fast = flags.writeable and value.size
        place = ctypes.addressof(ctypes.c_char.from_buffer(value)) if fast else value.ctypes.data
        values += (place, *value.shape)
    return values
