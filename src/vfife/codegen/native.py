"""Machine code by LLVM: what this processor is, object code of a text, and functions of it in memory, called without Python's lock."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from .lock import WRITING

SELDOM = 0  # effort of LLVM's code generator for what few steps need
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


# Lanes of a step with contact, on every processor. Eight are not faster on all that have AVX-512: a step of the
# four-bar took 1.2 times as long in eight lanes as in four on one of two processors. On the other it took 0.74 times
# as long with one contact, 0.82 with three, 1.0 with six, and 1.09 with one contact beside four elastic elements.
CONTACT_LANES = 4


def stream_lanes(contacts: int) -> int:
    """Count the lanes of a stream of simulations of one topology on this machine.

    Without contacts eight lanes were faster wherever they were measured: members took 1.2 to 1.5 times the processor
    time in four lanes with ideal joints, 1.13 to 1.22 times with elastic links (``benchmarks/lanes.py``). Results have
    the same bits in any number of lanes.

    ``contacts``: contacts of the topology (1). Returns 8 with AVX-512 without contacts, else 4, or 2 without AVX.
    """
    return min(widest(), CONTACT_LANES) if contacts else widest()


def machine(effort: int = EFFORT) -> Any:
    """LLVM's code generator for this processor."""
    name, features = processor()
    target = _target().Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=effort, codemodel="jitdefault", jit=True)


def object_code(text: str, effort: int = EFFORT) -> bytes:
    """Object code of a text."""
    with WRITING:
        module = _target().parse_assembly(text)
        module.verify()
        code: bytes = machine(effort).emit_object(module)
    return code


def optimised_code(text: str, wide: bool = False) -> bytes:
    """Object code of a text with loops and calls: these are written out, what does not change is kept in registers. Nothing of it changes a bit.

    Loops of a step have a few turns each, over joints or rows of a profile. They stay loops: unrolled, they take twice as long to compile, and
    ideal joints take a twelfth longer to step. In ``wide`` texts, loops over rows of matrices, turns that do not wait for each other are taken
    several at a time; sums keep their order, because nothing allows LLVM to change it.
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
