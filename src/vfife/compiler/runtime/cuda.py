"""Cases on a graphics card, one per thread: access to NVIDIA's driver, and a stream with thousands of
independent lanes.

Failures of the driver become sentences with a remedy.
"""

from __future__ import annotations

import contextlib
import weakref
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import DeviceError
from ...kernels.arrays import Integers, Layout
from ...kernels.arrays import Numbers as Rows
from ...kernels.topology import Topology
from ..backends.gpu import ARGUMENTS, LEAST_CAPABILITY, TILE
from .ptx import program
from .runner import PARTS, STREAM_LOOK, Started

REASONS = {
    2: "its memory is full; run fewer cases at once, or end what else runs on it",
    100: (
        "the driver sees no card; nvidia-smi lists those there are, and CUDA_VISIBLE_DEVICES says which of"
        " them a process may use"
    ),
    101: "the driver sees no card of that number",
    209: f"it is too old: it needs compute capability {LEAST_CAPABILITY / 10} or more",
    218: "the driver refused the program; update the driver",
    222: "the driver is too old for the program; update the driver",
    700: "the program reached beyond its memory, which is a fault of vfife; please report the model",
    702: "the system ended a launch that took too long; close what else shows pictures with this card",
    803: "driver and kernel module are of two versions; restart the machine after an update of the driver",
}
WITHOUT = "without it the processor gives the same numbers"


class Card:
    """The first card that this process may use.

    ``driver`` is the module ``cuda.bindings.driver``, or an object with the same functions. Raises
    DeviceError if there is no such module, no driver, no card, or one that is too old.
    """

    def __init__(self, driver: Any = None) -> None:
        self.driver, self.programs = driver or _bindings(), dict[str, Any]()
        try:
            self.call("cuInit", 0)
        except RuntimeError as error:  # the bindings look for the driver when they are first used
            raise DeviceError(
                f"device cuda: there is no NVIDIA driver on this machine ({_line(error)}); install one;"
                f" {WITHOUT}"
            ) from error
        self._examine_driver()
        self.device = self.call("cuDeviceGet", 0)
        attributes = self.driver.CUdevice_attribute
        major, minor = (
            int(
                self.call(
                    "cuDeviceGetAttribute",
                    getattr(attributes, f"CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_{part}"),
                    self.device,
                )
            )
            for part in ("MAJOR", "MINOR")
        )
        if 10 * major + minor < LEAST_CAPABILITY:
            raise DeviceError(
                f"device cuda: the card has compute capability {major}.{minor}; it needs"
                f" {LEAST_CAPABILITY / 10} or more; {WITHOUT}"
            )
        self.context = self.call("cuDevicePrimaryCtxRetain", self.device)
        self.enter()

    def _examine_driver(self) -> None:
        installed, required = int(self.call("cuDriverGetVersion")), int(self.driver.CUDA_VERSION)
        if installed // 1000 < required // 1000:
            raise DeviceError(
                f"device cuda: the NVIDIA driver is too old: it knows CUDA {_version(installed)}, and the"
                f" cuda-bindings here want {_version(required)}; update the driver, or pip install"
                f" 'cuda-bindings<{required // 1000}'"
            )

    def call(self, name: str, *arguments: Any) -> Any:
        """Call a function of the driver; return its result. Raises DeviceError for an error code."""
        code, *values = getattr(self.driver, name)(*arguments)
        if int(code):
            word = self.driver.cuGetErrorName(code)[1]
            word = word.decode() if isinstance(word, bytes) else str(word)
            reason = REASONS.get(
                int(code), "it is not known why; update the driver, and see whether nvidia-smi answers"
            )
            raise DeviceError(f"device cuda: the card could not do {name} ({word}): {reason}; {WITHOUT}")
        return values[0] if values else None

    def enter(self) -> None:
        """Make the card current in the calling thread."""
        self.call("cuCtxSetCurrent", self.context)

    def free(self) -> int:
        """Return the number of free bytes on the card."""
        code, free, _ = self.driver.cuMemGetInfo()
        return int(free) if not int(code) else 0

    def program(self, ptx: str, name: str) -> Any:
        """Return a kernel of a PTX text.

        The driver compiles the text once in this process, which takes seconds, and has a cache of its own for
        other processes.
        """
        if ptx not in self.programs:
            self.programs[ptx] = self.call("cuModuleLoadData", ptx.encode() + b"\0")
        return self.call("cuModuleGetFunction", self.programs[ptx], name.encode())

    def memory(self, size: int) -> int:
        """Allocate ``size`` bytes, at least one; return their address."""
        return int(self.call("cuMemAlloc", max(size, 1)))

    def drop(self, address: int) -> None:
        """Free the memory at an address."""
        self.call("cuMemFree", address)

    def put(self, address: int, values: NDArray[Any]) -> None:
        """Copy an array to the card."""
        if values.nbytes:
            self.call("cuMemcpyHtoD", address, values.ctypes.data, values.nbytes)

    def fetch(self, address: int, values: NDArray[Any]) -> None:
        """Fill an array from the card."""
        if values.nbytes:
            self.call("cuMemcpyDtoH", values.ctypes.data, address, values.nbytes)

    def launch(self, kernel: Any, blocks: int, threads: int, arguments: list[int]) -> None:
        """Run a kernel, whose arguments are integers or addresses, and wait for its end."""
        values = np.array(arguments, dtype=np.uint64)
        places = values.ctypes.data + 8 * np.arange(len(values), dtype=np.uint64)
        self.call("cuLaunchKernel", kernel, blocks, 1, 1, threads, 1, 1, 0, 0, places.ctypes.data, 0)
        self.call("cuCtxSynchronize")


@lru_cache(maxsize=1)
def card() -> Card:
    """Return the card of this process, opened at the first call."""
    return Card()


def _bindings() -> Any:
    try:
        from cuda.bindings import driver
    except ImportError as error:
        raise DeviceError(
            "device cuda: an NVIDIA card is reached by NVIDIA's bindings, which are not here: pip install"
            f" 'vfife[gpu]'; {WITHOUT}"
        ) from error
    return driver


def _version(number: int) -> str:
    return f"{number // 1000}.{number % 1000 // 10}"


def _line(error: Exception) -> str:
    return " ".join(str(error).split()).rstrip(".")


CARD_CASES = 1 << 15  # cases side by side: as many as an H100 executes at once
SHARE = 0.75  # of the free memory that is used; the driver needs some for spilled registers
MOST_BYTES = 1 << 30  # bytes of the states of cases, which have a copy in this process


class DeviceStream:
    """A :class:`~vfife.compiler.runtime.runner.Stream` on a card, with the same rows to the bit.

    It has ``lanes`` lanes, or as many as the card's memory holds, in whole tiles. Each lane counts its own
    steps; one that has all its outputs rests until the call ends. A call is one launch, which cannot be
    interrupted: callers limit the steps of a call. States and outputs remain on the card. A tile of 32 lanes
    is copied to this process when one of its lanes is read, and back when a simulation was put into one.
    Raises DeviceError.
    """

    beat = 0  # a lane may be filled at any time
    done = 1  # steps of the lane that has made most, call by call

    def __init__(
        self, topology: Topology, lanes: int, loop: str, handed: Integers, room: int, sound: Integers,
        limited: Integers, tables: int, parts: int = PARTS, device: Card | None = None,
    ) -> None:  # fmt: skip
        if loop != "generated":
            raise DeviceError(
                f"device cuda: a card steps straight-line code, and one of these needs the {loop} loop;"
                f" {WITHOUT}"
            )
        self.card, self.layout, self.room = device or card(), Layout(topology), room
        self.card.enter()
        self.kernel = self.card.program(program(topology), "simulate")
        rows, bounds = self.layout.rows, 2 * len(limited)
        sizes = {
            "S": rows,
            "Q": rows,
            "C": 3,
            "T": tables,
            "limits": bounds,
            "out": room * len(handed),
        } | dict.fromkeys(COUNTS, 1)
        tiles = min(-(-lanes // TILE), self._room_for(8 * TILE * sum(sizes.values())))
        self.lanes = lanes = TILE * tiles
        self.extremes = np.array(self.layout.of("extreme"), dtype=np.uint32)
        self.places: dict[str, int] = {}
        weakref.finalize(self, _drop, self.card, self.places)
        for name, size in sizes.items():
            self.places[name] = self.card.memory(8 * lanes * size)
        numbers = np.array([1, TILE, rows, parts, STREAM_LOOK], dtype=np.int64)
        shared: dict[str, NDArray[Any]] = {
            "N": numbers,
            "recorded": handed,
            "extremes": self.extremes,
            "sound": sound,
            "limited": limited,
        }
        for name, array in shared.items():
            self.places[name] = self.card.memory(array.nbytes)
            self.card.put(self.places[name], array)
        self.numbers = {
            "stride": tables, "keeping": len(handed), "resetting": len(self.extremes), "look": STREAM_LOOK,
            "finite": len(sound), "limiting": len(limited), "room": room,
        }  # fmt: skip
        # Copies of the arrays on the card. A tile of them is valid if it is ``known`` (its outputs:
        # ``told``), and is copied to the card before the next call if it is ``changed``.
        self.S, self.T = np.zeros((tiles, rows, TILE)), np.zeros((tiles, TILE, tables))
        self.limits = np.zeros((tiles, bounds, TILE))
        self.handed = np.zeros((tiles, TILE, room, len(handed)))
        self.known, self.changed, self.told = (np.zeros(tiles, dtype=bool) for _ in range(3))
        self.broken = np.full(lanes, -1.0)
        self.due, self.interval, self.at, self.stop, self.reached = (
            np.zeros(lanes, dtype=np.int64) for _ in range(5)
        )
        self.known[:] = True

    def _room_for(self, tile: int) -> int:
        free = self.card.free()
        if SHARE * free < tile:
            raise DeviceError(
                f"device cuda: {TILE} cases take {tile} bytes of the card, of which {free} are free; end"
                f" what else runs on it; {WITHOUT}"
            )
        return int(min(SHARE * free, max(MOST_BYTES, tile)) / tile)

    def put(self, lane: int, simulation: Started, interval: int, outputs: int) -> int:
        """Put a simulation into a lane; return 0, the number of steps of the lane before its own."""
        tile, at = divmod(lane, TILE)
        state = self._tile(tile)[:, at]
        state[:] = simulation.state
        state[self.extremes] = 0.0
        self.T[tile, at] = simulation.tables
        self.limits[tile, :, at] = simulation.bounds.T.reshape(-1)
        self.broken[lane], self.interval[lane], self.due[lane], self.reached[lane] = (
            0.0,
            interval,
            1 + interval,
            1,
        )
        self.at[lane], self.stop[lane] = 0, outputs
        self.changed[tile] = True
        return 0

    def go_on(self, lane: int, outputs: int) -> None:
        """Continue a lane for ``outputs`` more outputs, written from the beginning."""
        self.at[lane], self.stop[lane] = 0, outputs

    def leave(self, lane: int) -> None:
        """Free a lane: it rests."""
        self.broken[lane], self.at[lane], self.stop[lane] = -1.0, 0, 0

    def repeat(self, lane: int, source: int) -> None:
        """Do nothing: a free lane of a card rests."""

    def state(self, lane: int) -> Rows:
        """Return the present state of a lane, (rows,)."""
        tile, at = divmod(lane, TILE)
        return self._tile(tile)[:, at].copy()

    def rows(self, lane: int) -> Rows:
        """Return the outputs of a lane since it was filled or continued, (outputs, handed)."""
        tile, at = divmod(lane, TILE)
        if not self.told[tile]:
            self.card.enter()
            self.card.fetch(self.places["out"] + tile * self.handed[tile].nbytes, self.handed[tile])
            self.told[tile] = True
        rows: Rows = self.handed[tile, at, : self.at[lane]] + 0.0
        return rows

    def _tile(self, tile: int) -> Rows:
        """Return the states of a tile, (rows, 32)."""
        if not self.known[tile]:
            self.card.enter()
            self.card.fetch(self.places["S"] + tile * self.S[tile].nbytes, self.S[tile])
            self.known[tile] = True
        rows: Rows = self.S[tile]
        return rows

    def advance(self, count: int) -> None:
        """Take up to ``count`` steps in each lane; a lane stops when it has its outputs or breaks."""
        device = self.card
        device.enter()
        for tile in np.flatnonzero(self.changed):
            for name, all_tiles in (("S", self.S), ("T", self.T), ("limits", self.limits)):
                device.put(self.places[name] + int(tile) * all_tiles[tile].nbytes, all_tiles[tile])
        self.changed[:] = self.known[:] = self.told[:] = False
        for name in COUNTS:
            device.put(self.places[name], getattr(self, name))
        reached = self.reached.copy()
        array = self.numbers | {"count": count} | self.places
        device.launch(self.kernel, self.lanes // TILE, TILE, [array[name] for name in ARGUMENTS])
        for name in COUNTS:
            device.fetch(self.places[name], getattr(self, name))
        self.done += int((self.reached - reached).max())


# Arrays with a number for each lane, copied to the card and back with each call.
COUNTS = ("broken", "due", "interval", "at", "stop", "reached")


def _drop(device: Card, places: dict[str, int]) -> None:
    with contextlib.suppress(DeviceError):  # at the end of a process the driver may have gone first
        device.enter()
        for address in places.values():
            device.drop(address)
