"""The step of a graphics card's thread as PTX, the language that the drivers of NVIDIA's cards compile."""

from __future__ import annotations

import re
from functools import lru_cache

from ...kernels.topology import Topology
from ..backends.gpu import LEAST_CAPABILITY, kernel, module
from ..backends.modules import STEPS, driver_text
from ..trace.traceable import WRITING
from . import cache
from .native import llvmlite_version, simplified

TRIPLE = "nvptx64-nvidia-cuda"


@lru_cache(maxsize=1)
def stream() -> str:
    """Return the driver's ``stream`` with all that it calls except the steps, with its variables in
    registers: on a card, variables in memory would be in another address space than the rows.
    """
    text = str(simplified(driver_text("stream")))
    steps = "|".join(STEPS)
    text = re.sub(rf"^declare [^@]*@({steps})\(.*\n", "", text, flags=re.M)
    return re.sub(r"^(; ModuleID|source_filename|target ).*\n", "", text, flags=re.M)


def ptx(text: str, capability: int = LEAST_CAPABILITY) -> str:
    """Return a text with ``member`` as PTX for cards of a compute capability (70: 7.0) and all later ones."""
    return assembly(text, kernel(), capability)


def assembly(text: str, kernels: str, capability: int = LEAST_CAPABILITY) -> str:
    """Return a text, with the ``kernels`` that call its functions, as PTX."""
    import llvmlite.binding as llvm

    with WRITING:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        # All addresses are in the card's global memory (address space 1), which is faster than generic
        # addresses.
        text = re.sub(r"^define (?!internal)", "define internal ", text, flags=re.M) + kernels
        module = llvm.parse_assembly(re.sub(r"\bptr\b", "ptr addrspace(1)", text))
        machine = llvm.Target.from_triple(TRIPLE).create_target_machine(cpu=f"sm_{capability}", opt=3)
        module.triple, module.data_layout = TRIPLE, str(machine.target_data)
        module.verify()
        return str(machine.emit_assembly(module))


@lru_cache(maxsize=16)
def program(topology: Topology) -> str:
    """Return the PTX of a topology for all cards, from the cache or written."""
    name = f"step-{cache.digest([*cache.origin(topology), llvmlite_version().encode(), TRIPLE.encode()])}.ptx"
    return cache.stored(name, lambda: ptx(module(topology, stream())).encode()).decode()
