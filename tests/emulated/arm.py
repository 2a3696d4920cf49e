"""A processor of the kind AArch64: QEMU, as the library Unicorn; and how code is written for it here."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import pytest

from emulated import PAGE, STACK, Room, numbers, wanted
from vfife.compiler.runtime import native

TRIPLE, NAME = "aarch64-unknown-linux-gnu", "neoverse-n1"
VECTORS = 0b11 << 20  # of the register that allows them
REGISTERS = 8  # of the first arguments


def machine(effort: int = native.EFFORT) -> Any:
    """LLVM's code generator for it."""
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    return llvm.Target.from_triple(TRIPLE).create_target_machine(
        cpu=NAME, opt=effort, codemodel="jitdefault", jit=True
    )


def module(text: str) -> Any:
    """A text for it."""
    found = native._target().parse_assembly(text)
    found.triple, found.data_layout = TRIPLE, str(machine().target_data)
    return found


def object_code(text: str, effort: int = native.EFFORT) -> bytes:
    """Object code of a text."""
    code: bytes = machine(effort).emit_object(module(text))
    return code


class Arm:
    """One that begins anew with every call."""

    def __init__(self) -> None:
        self.unicorn, self.room = pytest.importorskip("unicorn", reason="make verify installs it"), Room()
        self.stack, self.end = self.room.made(STACK), self.room.made(PAGE)

    def renewed(self) -> None:
        """Nothing is kept from call to call."""

    def call(self, function: int, *arguments: Any) -> int:
        """What a function returns, in the convention of AArch64."""
        from unicorn import arm64_const as names

        given = numbers(arguments)
        emulated = self.unicorn.Uc(self.unicorn.UC_ARCH_ARM64, self.unicorn.UC_MODE_ARM)
        for begin, end in wanted([function, self.stack, self.end, *given]):
            emulated.mem_map_ptr(begin, end - begin, self.unicorn.UC_PROT_ALL, begin)
        words = given[REGISTERS:]
        top = self.stack + STACK - 8 * len(words) - PAGE & ~63
        (ctypes.c_uint64 * len(words)).from_address(top)[:] = words
        emulated.reg_write(names.UC_ARM64_REG_CPACR_EL1, VECTORS)
        emulated.reg_write(names.UC_ARM64_REG_SP, top)
        emulated.reg_write(names.UC_ARM64_REG_LR, self.end)
        for k, value in enumerate(given[:REGISTERS]):
            emulated.reg_write(getattr(names, f"UC_ARM64_REG_X{k}"), value)
        emulated.emu_start(function, self.end)
        return int(emulated.reg_read(names.UC_ARM64_REG_X0))


@cache
def processor() -> Arm:
    """One for all tests of a process."""
    return Arm()
