"""NVIDIA's driver behind a few words: a card, memory on it, a program, a launch. Whatever fails is told as a sentence."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DeviceError

LEAST = 70  # compute capability (7.0) for which programs are written; later cards run them
SAID = {
    2: "its memory is full; run fewer members at once, or end what else runs on it",
    100: "the driver sees no card; nvidia-smi lists those there are, and CUDA_VISIBLE_DEVICES says which of them a process may use",
    101: "the driver sees no card of that number",
    209: f"it is too old: it needs compute capability {LEAST / 10} or more",
    218: "the driver refused the program; update the driver",
    222: "the driver is too old for the program; update the driver",
    700: "the program reached beyond its memory, which is a fault of vfife; please report the model",
    702: "the system ended a launch that took too long; close what else shows pictures with this card",
    803: "driver and kernel module are of two versions; restart the machine after an update of the driver",
}
WITHOUT = "without it the processor gives the same numbers"


class Card:
    """The first card that this process may use. ``driver`` is the module ``cuda.bindings.driver``, or what behaves as it does.

    Raises DeviceError with one sentence where there is no such module, no driver, no card, or one that is too old.
    """

    def __init__(self, driver: Any = None) -> None:
        self.driver, self.programs = driver or _bindings(), dict[str, Any]()
        try:
            self.call("cuInit", 0)
        except RuntimeError as error:  # the bindings look for the driver when they are first used
            raise DeviceError(f"device cuda: there is no NVIDIA driver on this machine ({_line(error)}); install one; {WITHOUT}") from error
        self._examine_driver()
        self.device = self.call("cuDeviceGet", 0)
        attributes = self.driver.CUdevice_attribute
        major, minor = (
            int(self.call("cuDeviceGetAttribute", getattr(attributes, f"CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_{part}"), self.device))
            for part in ("MAJOR", "MINOR")
        )
        if 10 * major + minor < LEAST:
            raise DeviceError(f"device cuda: the card has compute capability {major}.{minor}; it needs {LEAST / 10} or more; {WITHOUT}")
        self.context = self.call("cuDevicePrimaryCtxRetain", self.device)
        self.enter()

    def _examine_driver(self) -> None:
        has, wants = int(self.call("cuDriverGetVersion")), int(self.driver.CUDA_VERSION)
        if has // 1000 < wants // 1000:
            raise DeviceError(
                f"device cuda: the NVIDIA driver is too old: it knows CUDA {_version(has)}, and the cuda-bindings here want {_version(wants)}; "
                f"update the driver, or pip install 'cuda-bindings<{wants // 1000}'"
            )

    def call(self, name: str, *arguments: Any) -> Any:
        """What a function of the driver gives beside its error code, which is zero."""
        code, *values = getattr(self.driver, name)(*arguments)
        if int(code):
            word = self.driver.cuGetErrorName(code)[1]
            word = word.decode() if isinstance(word, bytes) else str(word)
            said = SAID.get(int(code), "it is not known why; update the driver, and see whether nvidia-smi answers")
            raise DeviceError(f"device cuda: the card could not do {name} ({word}): {said}; {WITHOUT}")
        return values[0] if values else None

    def enter(self) -> None:
        """Makes the card that of the calling thread."""
        self.call("cuCtxSetCurrent", self.context)

    def free(self) -> int:
        """Bytes that are free."""
        code, free, _ = self.driver.cuMemGetInfo()
        return int(free) if not int(code) else 0

    def program(self, ptx: str, name: str) -> Any:
        """A kernel of a text. The driver makes machine code of it, which takes seconds, once in this process, and keeps it for others."""
        if ptx not in self.programs:
            self.programs[ptx] = self.call("cuModuleLoadData", ptx.encode() + b"\0")
        return self.call("cuModuleGetFunction", self.programs[ptx], name.encode())

    def memory(self, size: int) -> int:
        """Address of so many bytes, at least one."""
        return int(self.call("cuMemAlloc", max(size, 1)))

    def drop(self, address: int) -> None:
        """Gives memory back."""
        self.call("cuMemFree", address)

    def put(self, address: int, values: NDArray[Any]) -> None:
        """Copies an array to the card."""
        if values.nbytes:
            self.call("cuMemcpyHtoD", address, values.ctypes.data, values.nbytes)

    def fetch(self, address: int, values: NDArray[Any]) -> None:
        """Fills an array from the card."""
        if values.nbytes:
            self.call("cuMemcpyDtoH", values.ctypes.data, address, values.nbytes)

    def launch(self, kernel: Any, blocks: int, threads: int, arguments: list[int]) -> None:
        """Runs a kernel, whose arguments are integers or addresses, and waits for its end."""
        values = np.array(arguments, dtype=np.uint64)
        places = values.ctypes.data + 8 * np.arange(len(values), dtype=np.uint64)
        self.call("cuLaunchKernel", kernel, blocks, 1, 1, threads, 1, 1, 0, 0, places.ctypes.data, 0)
        self.call("cuCtxSynchronize")


@lru_cache(maxsize=1)
def card() -> Card:
    """The card of this process, opened when it is first asked for."""
    return Card()


def _bindings() -> Any:
    try:
        from cuda.bindings import driver
    except ImportError as error:
        raise DeviceError(
            f"device cuda: an NVIDIA card is reached by NVIDIA's bindings, which are not here: pip install 'vfife[gpu]'; {WITHOUT}"
        ) from error
    return driver


def _version(number: int) -> str:
    return f"{number // 1000}.{number % 1000 // 10}"


def _line(error: Exception) -> str:
    return " ".join(str(error).split()).rstrip(".")
