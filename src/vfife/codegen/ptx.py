"""The text of a thread as PTX, the language that the drivers of NVIDIA's cards compile."""

from __future__ import annotations

import re
from functools import lru_cache

from ..kernels.topology import Topology
from . import cache
from .cuda import LEAST
from .gpu import ARGUMENTS, TILE, kind, written
from .lock import WRITING
from .loops import origin
from .native import llvmlite_version

TRIPLE = "nvptx64-nvidia-cuda"


def kernel() -> str:
    """``simulate(...)``: ``member`` for each thread."""
    given = ", ".join(f"{kind(size)} %{name}" for name, size in ARGUMENTS.items())
    return f"""declare i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.tid.x()
define ptx_kernel void @simulate({given}) {{
  %block = call i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
  %thread = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()
  %block.long = zext i32 %block to i64
  %thread.long = zext i32 %thread to i64
  %before = mul i64 %block.long, {TILE}
  %m = add i64 %before, %thread.long
  call void @member({given}, i64 %m)
  ret void
}}
"""


def ptx(text: str, capability: int = LEAST) -> str:
    """A text with ``member`` as PTX for cards of a compute capability (70: 7.0) and all later ones."""
    return assembly(text, kernel(), capability)


def assembly(text: str, kernels: str, capability: int = LEAST) -> str:
    """A text as PTX, with the kernels that call its functions."""
    import llvmlite.binding as llvm

    with WRITING:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        # Whatever is read or written lies in the card's own memory, which is quicker than an address that may be of any kind.
        text = re.sub(r"^define (?!internal)", "define internal ", text, flags=re.M) + kernels
        module = llvm.parse_assembly(re.sub(r"\bptr\b", "ptr addrspace(1)", text))
        machine = llvm.Target.from_triple(TRIPLE).create_target_machine(cpu=f"sm_{capability}", opt=3)
        module.triple, module.data_layout = TRIPLE, str(machine.target_data)
        module.verify()
        return str(machine.emit_assembly(module))


@lru_cache(maxsize=16)
def program(topology: Topology) -> str:
    """PTX of a topology for all cards, from the cache or written."""
    name = f"step-{cache.digest([*origin(topology), llvmlite_version().encode(), TRIPLE.encode()])}.ptx"
    found = cache.read(name)
    if found is not None:
        return found.decode()
    cache.missed()
    text = ptx(written(topology))
    cache.keep(name, text.encode())
    return text
