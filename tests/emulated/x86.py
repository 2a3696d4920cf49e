"""A processor with AVX-512: Bochs, as a library."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from emulated import PAGE, STACK, Room, mappings, numbers, wanted

ALLOWED = 0b111  # of a page: present, may be written, by everybody
REGISTERS = "rdi", "rsi", "rdx", "rcx", "r8", "r9"  # of the first arguments
SAVED_STATE = 0xE7  # x87, SSE, AVX, masks and both parts of what AVX-512 adds
EXTENDED = 1 << 9 | 1 << 10 | 1 << 18  # of control register 4: SSE, its exceptions, and the extended states
CALM_SSE, CALM_X87 = 0x1F80, 0x37F  # no operation stops the processor
HALT = 0xF4
# Names that the library asks of a C library newer than some have.
NEWER = """
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
unsigned long long __isoc23_strtoull(const char *text, char **end, int base)
{ return strtoull(text, end, base); }
int __isoc23_sscanf(const char *text, const char *format, ...)
{ va_list given; va_start(given, format); int found = vsscanf(text, format, given);
  va_end(given); return found; }
"""


@cache
def bochs() -> Any:
    """The library, or the test is skipped."""
    try:
        import bochscpu
    except ModuleNotFoundError:
        pytest.skip("needs bochscpu-python, which make verify installs where there is one for this Python")
    except ImportError:
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder, "newer.c"), Path(folder, "newer.so")
            source.write_text(NEWER)
            subprocess.run(["cc", "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
            ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
        import bochscpu
    return bochscpu


class X86:
    """One that begins anew with every call."""

    def __init__(self) -> None:
        self.bochs, self.room = bochs(), Room()
        from bochscpu import memory

        self.memory, self.session = memory, self.bochs.Session()
        self.session.missing_page_handler = self._missing
        self.physical, self.known = 0x100000, set[int]()
        self.top = self._table()
        self.stack, self.end = self.room.made(STACK), self.room.made(PAGE)
        ctypes.memset(self.end, HALT, 1)
        self.fault: tuple[int, ...] = ()

    def _missing(self, address: int) -> None:
        raise MemoryError(f"no page at {address:#x} of the emulated memory")

    def _page(self, address: int) -> int:
        """Number of a page of the emulated memory that is a page of this process."""
        self.physical += PAGE
        self.memory.page_insert(self.physical, address)
        return self.physical

    def _table(self) -> tuple[int, Any, dict[int, Any]]:
        address = self.room.made(PAGE)
        return self._page(address), (ctypes.c_uint64 * 512).from_address(address), {}

    def _insert(self, address: int) -> None:
        """The page of an address, by the four levels of tables."""
        if address in self.known:
            return
        self.known.add(address)
        node = self.top
        for shift in (39, 30, 21):
            entry = address >> shift & 511
            if entry not in node[2]:
                node[2][entry] = self._table()
                node[1][entry] = node[2][entry][0] | ALLOWED
            node = node[2][entry]
        node[1][address >> 12 & 511] = self._page(address) | ALLOWED

    def _state(self, function: int, arguments: list[int]) -> Any:
        """Registers and stack of a call in the convention of System V."""
        import bochscpu.cpu

        state = self.bochs.State()
        bochscpu.cpu.set_long_mode(state)
        state.cr4, state.cr3, state.xcr0 = state.cr4 | EXTENDED, self.top[0], SAVED_STATE
        state.mxcsr, state.fpcw, state.fptw, state.rflags = CALM_SSE, CALM_X87, 0xFFFF, 2
        words = [self.end, *arguments[len(REGISTERS) :]]
        state.rsp = (self.stack + STACK - 8 * len(words) - PAGE & ~63) - 8
        (ctypes.c_uint64 * len(words)).from_address(state.rsp)[:] = words
        for name, value in zip(REGISTERS, arguments, strict=False):
            setattr(state, name, value)
        state.rip = function
        for names, selector, attributes in (
            (("cs",), 0x10, 0x209B),
            (("ds", "ss", "es", "fs", "gs"), 0x18, 0xC93),
        ):
            segment = self.bochs.Segment()
            segment.present, segment.selector, segment.base, segment.limit, segment.attr = (
                True,
                selector,
                0,
                0xFFFF_FFFF,
                attributes,
            )
            for name in names:
                setattr(state, name, segment)
        return state

    def renewed(self) -> None:
        """What lay where code lies now is kept decoded by the number of its page, so the pages get others."""
        for begin, end, rights, nobodys in mappings():
            if "x" in rights and nobodys:
                self.known.difference_update(range(begin, end, PAGE))

    def call(self, function: int, *arguments: Any) -> int:
        """What a function returns."""
        given = numbers(arguments)
        for begin, end in wanted([function, self.stack, self.end, *given]):
            for page in range(begin, end, PAGE):
                self._insert(page)
        self.session.cpu.state = self._state(function, given)
        self.fault = ()
        hook = self.bochs.Hook()
        hook.hlt = lambda session, _: session.stop()
        hook.exception = self._stopped
        self.session.run([hook])
        if self.fault:
            raise RuntimeError(
                "the emulated processor stopped: exception {}, code {}, at {:#x}, of address {:#x}".format(
                    *self.fault
                )
            )
        return int(self.session.cpu.state.rax)

    def _stopped(self, session: Any, _: int, vector: int, code: int) -> None:
        self.fault = vector, code, session.cpu.state.rip, session.cpu.state.cr2
        session.stop()


@cache
def processor() -> X86:
    """One for all tests of a process."""
    return X86()
