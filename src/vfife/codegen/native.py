"""Machine code of the straight-line step, made by LLVM and kept on disk as object code; called without Python's lock."""

from __future__ import annotations

import ctypes
import dataclasses
import gc
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import Topology
from . import cache
from .lock import WRITING
from .source import data_driven

if TYPE_CHECKING:
    from .pieces import Pieces

Rows = NDArray[np.float64]

SELDOM = 0  # effort of LLVM's code generator for what few steps need
EFFORT = 1  # of LLVM's code generator: the same code as with 2 in half the time; nothing of it changes a bit
OPTIMISED = 2  # of the same, for loops
POINTER, NUMBER = ctypes.c_void_p, ctypes.c_int64
BEFORE = (*[POINTER] * 3, *[NUMBER] * 5, POINTER, POINTER, POINTER, NUMBER, POINTER, NUMBER)
ADVANCE = ctypes.CFUNCTYPE(None, *BEFORE, NUMBER, NUMBER, POINTER, NUMBER, POINTER, POINTER)
WATCHING = (NUMBER, POINTER, NUMBER, POINTER, NUMBER, POINTER, POINTER)
STREAM = ctypes.CFUNCTYPE(NUMBER, *[POINTER] * 3, *[NUMBER] * 4, *[POINTER, NUMBER] * 2, *WATCHING, *[POINTER] * 4, NUMBER, POINTER)
NEVER = 2**62  # steps between two looks
Counts = NDArray[np.int64]


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


@contextmanager
def all_kept() -> Iterator[None]:
    """Nobody looks for what could be thrown away: a text is made of a hundred thousand small things that stay until it is done."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


@lru_cache(maxsize=8)
def _shared(text: str, _: tuple[str, str]) -> bytes:
    """Object code of what all steps of a width share, for a processor."""
    return object_code(text)


def step_code(pieces: Pieces) -> bytes:
    """Object code of a step, each piece behind its length."""
    codes = _shared(pieces.shared, processor()), object_code(pieces.often), object_code(pieces.seldom, SELDOM if pieces.hurried else EFFORT)
    return b"".join(len(code).to_bytes(8, "little") + code for code in codes)


def _apart(code: bytes) -> list[bytes]:
    """Object codes behind their lengths."""
    found, at = [], 0
    while at < len(code):
        end = at + 8 + int.from_bytes(code[at : at + 8], "little")
        found.append(code[at + 8 : end])
        at = end
    return found


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


def origin(topology: Topology) -> list[bytes]:
    """All that the text of a topology's step is made from."""
    laws = topology.contact_laws + topology.friction_laws
    numbers = {field.name: getattr(topology, field.name) for field in dataclasses.fields(topology)}
    numbers |= {"contact_laws": "", "friction_laws": ""}
    own = not all(law.__module__.startswith("vfife.laws.") for law in laws)  # these may call anything
    names = "" if not own else data_driven(topology.contact_laws, topology.friction_laws)
    return [cache.sources(), repr(numbers).encode(), repr([f"{law.__module__}.{law.__qualname__}" for law in laws]).encode(), names.encode()]


def name_of(topology: Topology, width: int, directions: int = 0) -> str:
    """File of the cache with a topology's machine code."""
    parts = (llvmlite_version(), platform.machine(), *processor(), str(width), str(directions))
    return f"step-{cache.digest([*origin(topology), *(part.encode() for part in parts)])}.o"


class Code:
    """Functions of object code in memory, which it keeps; ``function`` is the one that is called ``name``, and may call others."""

    def __init__(self, code: bytes, name: str, kind: Any, *others: bytes) -> None:
        llvm = _target()
        with WRITING:
            self.engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine())
            for one in (code, *others):
                self.engine.add_object_file(llvm.ObjectFileRef.from_data(one))
            self.engine.finalize_object()
            self.function = self.named(name, kind)

    def named(self, name: str, kind: Any) -> Any:
        """Another one of its functions."""
        return kind(self.engine.get_function_address(name))


class Memory(NamedTuple):
    """What a loop works on.

    S (rows x lanes) is the state, ``spare`` room for two more of it in whole lines of the cache, T the tables of all lanes. Steps with events are
    taken again in ``parts``; ``shares`` (lanes) are first steps that come beside those that are counted, where they are not zero. The rows ``kept``
    are handed out, ``extremes`` are rows that start anew before each time. A number of the rows ``limited`` lies between two of ``limits``
    (limited x 2 x lanes), and those that are kept are finite, or the lane breaks: ``broken`` (lanes) then says after how many steps that was seen.
    It is 0 before, and less in lanes that nobody looks at.
    """

    S: Rows
    spare: Rows
    T: Rows
    parts: int
    shares: Rows
    kept: NDArray[np.uint32]
    extremes: NDArray[np.uint32]
    limited: NDArray[np.uint32]
    limits: Rows
    broken: Rows


# (n0, steps, out, anew, look): len(out) times so many steps from step n0, out[m] filled with the rows kept after each, or of no rows; whether
# extremes begin anew before each; lanes are looked at where look divides the number of steps made.
Take = Callable[[int, int, Rows, bool, int], None]


class Loaded:
    """A step in memory; given a memory to work on, it is called as :class:`~vfife.codegen.runner.Runner` calls its loops."""

    def __init__(self, code: bytes, width: int) -> None:
        """Of :func:`step_code`."""
        self.width = width
        shared, *own = _apart(code)
        self.code = Code(shared, "advance", ADVANCE, *own)
        self.stream = self.code.named("stream", STREAM)

    def __call__(self, memory: Memory) -> Take:
        """Steps on a memory; its addresses are looked up once, for that takes as long as a hundred steps."""
        S, spare, T, _, shares, *others = (None if name == "parts" else getattr(memory, name).ctypes.data for name in Memory._fields)
        kept, extremes, limited, limits, broken = others
        code, stride, parts = self.code, len(memory.T) // self.width, memory.parts  # the code lives as long as somebody may call it
        resetting, finite, limiting = len(memory.extremes), len(memory.kept), len(memory.limited)

        def take(n0: int, steps: int, out: Rows, anew: bool = True, look: int = NEVER) -> None:
            outputs, keeping, _ = out.shape
            code.function(
                S, spare, T, stride, n0, steps, outputs, parts, shares, out.ctypes.data, kept, keeping, extremes, resetting * anew,
                look, finite, limited, limiting, limits, broken,
            )  # fmt: skip

        return take

    def streaming(
        self, memory: Memory, sound: NDArray[np.uint32], due: Counts, every: Counts, at: Counts, stop: Counts, out: Rows, look: int
    ) -> Callable[[int, int], int]:
        """What steps lanes of which each hands out its own rows: from a step on, so many or fewer; the number of steps made is returned."""
        S, spare, T, _, _, *others = (None if name == "parts" else getattr(memory, name).ctypes.data for name in Memory._fields)
        kept, extremes, limited, limits, broken = others
        own = [one.ctypes.data for one in (due, every, at, stop)]
        code, stride, parts = self.stream, len(memory.T) // self.width, memory.parts
        keeping, resetting, finite, limiting = len(memory.kept), len(memory.extremes), len(sound), len(memory.limited)
        seen, room, into = sound.ctypes.data, out.shape[1], out.ctypes.data

        def take(n0: int, count: int) -> int:
            return int(
                code(
                    S, spare, T, stride, n0, count, parts, kept, keeping, extremes, resetting, look, seen, finite, limited, limiting, limits,
                    broken, *own, room, into,
                )
            )  # fmt: skip

        return take


@lru_cache(maxsize=64)
def straight_line(topology: Topology, width: int, directions: int = 0) -> Loaded:
    """The step of a topology in so many lanes, with its derivatives in so many directions, from the cache or compiled."""
    with WRITING:
        name = name_of(topology, width, directions)
        code = cache.read(name)
        if code is not None:
            return Loaded(code, width)
        from .pieces import pieces

        cache.missed()
        with all_kept():
            made = pieces(topology, width, directions)
        code = step_code(made)
        cache.keep(name, code)
        return Loaded(code, width)
