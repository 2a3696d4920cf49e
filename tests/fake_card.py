"""A graphics card without one: NVIDIA's driver as its bindings for Python have it, whose kernels the
processor carries out, thread by thread.

Every call is noted. A kernel is the text that the card would be given, but for the lines that ask which
thread this is, compiled for this machine; its arguments are read from memory as the driver reads them.
"""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Iterator
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from vfife.assembly.assembled import Assembly, bounds, limited_rows
from vfife.compiler.backends import gpu
from vfife.compiler.runtime import cuda, ptx
from vfife.compiler.runtime.cuda import Card, DeviceStream
from vfife.compiler.runtime.native import Code, object_code
from vfife.compiler.runtime.runner import Starter
from vfife.kernels.topology import Topology
from vfife.solvers.record import recorded_rows

NAMES = {
    2: "CUDA_ERROR_OUT_OF_MEMORY",
    100: "CUDA_ERROR_NO_DEVICE",
    222: "CUDA_ERROR_UNSUPPORTED_PTX_VERSION",
    999: "CUDA_ERROR_UNKNOWN",
}


@lru_cache(maxsize=4)
def compiled(topology: Topology) -> SimpleNamespace:
    """``member`` for this machine."""
    types = [ctypes.c_int64 if size == "" else ctypes.c_void_p for size in gpu.ARGUMENTS.values()]
    code = Code(object_code(gpu.module(topology, ptx.stream()), 0))
    return SimpleNamespace(
        code=code, function=code.named("member", ctypes.CFUNCTYPE(None, *types, ctypes.c_int64))
    )


class FakeDriver:
    """Has ``memory`` bytes; ``failing`` are functions with the error codes that they give."""

    CUDA_VERSION = 13000
    CUdevice_attribute = SimpleNamespace(
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR=75, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR=76
    )

    def __init__(
        self,
        topology: Topology | None,
        *,
        memory: int = 1 << 30,
        version: int = 13000,
        capability: int = 90,
        **failing: int,
    ) -> None:
        self.topology, self.memory, self.version, self.capability, self.failing = (
            topology,
            memory,
            version,
            capability,
            failing,
        )
        self.calls: list[str] = []
        self.given: dict[int, np.ndarray] = {}
        self.threads: list[int] = []

    def __getattribute__(self, name: str):
        found = object.__getattribute__(self, name)
        if not name.startswith("cu"):
            return found

        def called(*arguments):
            self.calls.append(name)
            return (self.failing[name],) if name in self.failing else (0, *found(*arguments))

        return called

    def cuInit(self, flags):
        return ()

    def cuGetErrorName(self, code):
        return (NAMES[code].encode(),)

    def cuDriverGetVersion(self):
        return (self.version,)

    def cuDeviceGet(self, number):
        return (number,)

    def cuDeviceGetAttribute(self, attribute, device):
        return (self.capability // 10 if attribute == 75 else self.capability % 10,)

    def cuDevicePrimaryCtxRetain(self, device):
        return ("context",)

    def cuCtxSetCurrent(self, context):
        return ()

    def cuMemGetInfo(self):
        return self.memory - sum(one.nbytes for one in self.given.values()), self.memory

    def cuModuleLoadData(self, image):
        assert image.endswith(b"\0") and b".entry simulate" in image
        return (compiled(self.topology),)

    def cuModuleGetFunction(self, module, name):
        assert name == b"simulate"
        return (module,)

    def cuMemAlloc(self, size):
        one = np.full(size, 0xFF, dtype=np.uint8)  # what nobody wrote is no number
        self.given[one.ctypes.data] = one
        return (one.ctypes.data,)

    def cuMemFree(self, address):
        del self.given[address]
        return ()

    def _reach(self, address: int, size: int) -> None:
        assert any(
            start <= address and address + size <= start + one.nbytes for start, one in self.given.items()
        )

    def cuMemcpyHtoD(self, there, here, size):
        self._reach(there, size)
        ctypes.memmove(there, here, size)
        return ()

    def cuMemcpyDtoH(self, here, there, size):
        self._reach(there, size)
        ctypes.memmove(here, there, size)
        return ()

    def cuLaunchKernel(self, kernel, gx, gy, gz, bx, by, bz, shared, stream, parameters, extra):
        assert (gy, gz, by, bz, shared, extra) == (1, 1, 1, 1, 0, 0) and bx == gpu.TILE
        places = (ctypes.c_uint64 * len(gpu.ARGUMENTS)).from_address(parameters)
        arguments = [ctypes.c_int64.from_address(place).value for place in places]
        for thread in range(gx * bx):
            kernel.function(*arguments, thread)
        self.threads.append(gx * bx)
        return ()

    def cuCtxSynchronize(self):
        return ()


@contextlib.contextmanager
def in_this_machine(driver: FakeDriver) -> Iterator[FakeDriver]:
    """Meanwhile this machine has the card."""
    real, cuda._bindings = cuda._bindings, lambda: driver
    cuda.card.cache_clear()
    try:
        yield driver
    finally:
        cuda._bindings = real
        cuda.card.cache_clear()


def rows_on_card(assembly: Assembly, driver: Any = None, lane: int = 0) -> np.ndarray:
    """What a card would hand out of one member, stepped by one of its threads: the start and every output,
    shape (outputs, kept).
    """
    topology, choice, kept, parts = (
        assembly.topology,
        assembly.choice,
        recorded_rows(assembly),
        assembly.mechanism.settings.parts,
    )
    first = Starter(topology, 1, "generated", assembly.tables.size, parts).started(
        assembly.state, assembly.tables, np.stack(bounds(assembly))
    )
    own = Card(driver or FakeDriver(topology))
    limited = limited_rows(assembly)
    stream = DeviceStream(
        topology, lane + 1, "generated", kept, choice.outputs, kept, limited, assembly.tables.size, parts, own
    )
    stream.put(lane, first, choice.outputs_every, choice.outputs)
    stream.advance(choice.outputs_every * choice.outputs)
    return np.concatenate([first.state[None, kept] + 0.0, stream.rows(lane)])
