"""Runs machine code of this process in an emulated processor of another kind.

Code and data lie where they lie in this process: the emulated memory has the same addresses, and what is
stored there is seen here.
"""

from __future__ import annotations

import ctypes
import mmap
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Protocol

from vfife.compiler.runtime import loops

PAGE, STACK = 4096, 1 << 20  # bytes
WIDEST, SMALL = (
    512 << 20,
    16 << 20,
)  # bytes of mappings: the widest that is taken in, and those that are so though nobody asks


class Processor(Protocol):
    """An emulated processor: its memory is renewed when code is laid somewhere, and it calls functions of
    whole numbers and addresses.
    """

    def renewed(self) -> None: ...
    def call(self, function: int, *arguments: Any) -> int: ...


def mappings() -> Iterator[tuple[int, int, str, bool]]:
    """Begin, end and rights of the memory of this process, and whether it is nobody's file."""
    for line in Path("/proc/self/maps").read_text().splitlines():
        where, rights, *_ = words = line.split()
        begin, end = (int(one, 16) for one in where.split("-"))
        yield begin, end, rights, len(words) == 5


def wanted(addresses: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Whole mappings of addresses, those that join them, and all small ones that are nobody's file: tables of
    code lie apart from it.
    """
    joined = 0
    for begin, end, rights, nobodys in mappings():
        asked = any(begin <= one < end for one in addresses) or begin == joined
        if "r" in rights and end - begin <= WIDEST and (asked or (nobodys and end - begin < SMALL)):
            joined = end if asked else joined
            yield begin, end


def numbers(arguments: Sequence[Any]) -> list[int]:
    """Arguments as they lie in registers."""
    return [int(one or 0) % 2**64 for one in arguments]


class Room:
    """Memory of an emulated processor's own: zeros of this process."""

    def __init__(self) -> None:
        self.kept: list[mmap.mmap] = []

    def made(self, size: int) -> int:
        """Address of so many bytes."""
        self.kept.append(mmap.mmap(-1, size))
        return ctypes.addressof(ctypes.c_char.from_buffer(self.kept[-1]))


STRAIGHT = loops.straight


def loading(processor: Callable[[], Processor]) -> Callable[[bytes], loops.Stepped]:
    """Steps in memory that are called in an emulated processor."""

    def emulated(code: bytes) -> loops.Stepped:
        stepped = STRAIGHT(code)
        processor().renewed()
        for name, called in stepped.functions.items():
            address = called.code.engine.get_function_address(name)
            called.function = lambda *arguments, address=address: processor().call(address, *arguments)
        return stepped

    return emulated
