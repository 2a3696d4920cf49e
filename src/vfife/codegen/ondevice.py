"""Members on a graphics card, one a thread: a stream with thousands of lanes, of which each goes its own way."""

from __future__ import annotations

import contextlib
import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DeviceError
from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from .cuda import WITHOUT, Card, card
from .gpu import ARGUMENTS, TILE
from .loops import Integers, Rows
from .ptx import program
from .runner import PARTS
from .streams import LOOK, Begun

MEMBERS = 1 << 15  # side by side: as many as an H100 has in work at once
SHARE = 0.75  # of the free memory; the driver wants some for what registers do not hold
MOST = 1 << 30  # bytes of what members have here, too


class DeviceStream:
    """What :class:`~vfife.codegen.streams.Stream` is, on a card: the same rows, to the bit.

    There are as many of the ``lanes`` asked for as the card's memory holds, in whole tiles. Each counts its own steps, none waits for another: one
    that has its outputs rests until a call is over. A call is one launch, which nothing interrupts: callers pace their calls. States and outputs
    stay on the card; tiles of 32 lanes are copied here when one of them is asked for, and back when one was given a simulation. Raises
    DeviceError.
    """

    beat = 0  # a lane may be filled at any time
    done = 1  # steps of the lane that has made most, call by call

    def __init__(
        self, topology: Topology, lanes: int, loop: str, handed: Integers, room: int, sound: Integers, limited: Integers, tables: int,
        parts: int = PARTS, own: Card | None = None,
    ) -> None:  # fmt: skip
        if loop != "generated":
            raise DeviceError(f"device cuda: a card steps straight-line code, and one of these needs the {loop} loop; {WITHOUT}")
        self.card, self.layout, self.room = own or card(), Layout(topology), room
        self.card.enter()
        self.kernel = self.card.program(program(topology), "simulate")
        rows, bounds = self.layout.rows, 2 * len(limited)
        sizes = {"S": rows, "Q": rows, "C": 3, "T": tables, "limits": bounds, "out": room * len(handed)} | dict.fromkeys(COUNTS, 1)
        tiles = min(-(-lanes // TILE), self._room_for(8 * TILE * sum(sizes.values())))
        self.lanes = lanes = TILE * tiles
        self.extremes = np.array(self.layout.of("extreme"), dtype=np.uint32)
        self.places: dict[str, int] = {}
        weakref.finalize(self, _drop, self.card, self.places)
        for name, size in sizes.items():
            self.places[name] = self.card.memory(8 * lanes * size)
        numbers = np.array([1, TILE, rows, parts, LOOK], dtype=np.int64)
        shared: dict[str, NDArray[Any]] = {"N": numbers, "kept": handed, "extremes": self.extremes, "sound": sound, "limited": limited}
        for name, given in shared.items():
            self.places[name] = self.card.memory(given.nbytes)
            self.card.put(self.places[name], given)
        self.numbers = {
            "stride": tables, "keeping": len(handed), "resetting": len(self.extremes), "look": LOOK, "finite": len(sound),
            "limiting": len(limited), "room": room,
        }  # fmt: skip
        # What lies on the card, here: of these a tile is as it is there where it is ``known``, and goes there where it is ``changed``.
        self.S, self.T, self.limits = np.zeros((tiles, rows, TILE)), np.zeros((tiles, TILE, tables)), np.zeros((tiles, bounds, TILE))
        self.handed = np.zeros((tiles, TILE, room, len(handed)))
        self.known, self.changed, self.told = (np.zeros(tiles, dtype=bool) for _ in range(3))
        self.broken = np.full(lanes, -1.0)
        self.due, self.every, self.at, self.stop, self.reached = (np.zeros(lanes, dtype=np.int64) for _ in range(5))
        self.known[:] = True

    def _room_for(self, tile: int) -> int:
        free = self.card.free()
        if SHARE * free < tile:
            raise DeviceError(
                f"device cuda: {TILE} members take {tile} bytes of the card, of which {free} are free; end what else runs on it; {WITHOUT}"
            )
        return int(min(SHARE * free, max(MOST, tile)) / tile)

    def put(self, lane: int, simulation: Begun, every: int, outputs: int) -> int:
        """A simulation that begins in a lane; 0 steps were made there before its own."""
        tile, at = divmod(lane, TILE)
        state = self._tile(tile)[:, at]
        state[:] = simulation.state
        state[self.extremes] = 0.0
        self.T[tile, at] = simulation.tables
        self.limits[tile, :, at] = simulation.bounds.T.reshape(-1)
        self.broken[lane], self.every[lane], self.due[lane], self.reached[lane] = 0.0, every, 1 + every, 1
        self.at[lane], self.stop[lane] = 0, outputs
        self.changed[tile] = True
        return 0

    def go_on(self, lane: int, outputs: int) -> None:
        """So many outputs more, from the first place on."""
        self.at[lane], self.stop[lane] = 0, outputs

    def leave(self, lane: int) -> None:
        """Nobody waits for a lane any more: it rests."""
        self.broken[lane], self.at[lane], self.stop[lane] = -1.0, 0, 0

    def repeat(self, lane: int, other: int) -> None:
        """A lane that nobody waits for rests."""

    def state(self, lane: int) -> Rows:
        """Present state of a lane, (rows,)."""
        tile, at = divmod(lane, TILE)
        return self._tile(tile)[:, at].copy()

    def rows(self, lane: int) -> Rows:
        """What a lane has handed out since it went on, (outputs, handed)."""
        tile, at = divmod(lane, TILE)
        if not self.told[tile]:
            self.card.enter()
            self.card.fetch(self.places["out"] + tile * self.handed[tile].nbytes, self.handed[tile])
            self.told[tile] = True
        found: Rows = self.handed[tile, at, : self.at[lane]] + 0.0
        return found

    def _tile(self, tile: int) -> Rows:
        """States of a tile."""
        if not self.known[tile]:
            self.card.enter()
            self.card.fetch(self.places["S"] + tile * self.S[tile].nbytes, self.S[tile])
            self.known[tile] = True
        found: Rows = self.S[tile]
        return found

    def advance(self, count: int) -> None:
        """So many steps of each lane, or fewer: up to where it has its outputs, or breaks."""
        there = self.card
        there.enter()
        for tile in np.flatnonzero(self.changed):
            for name, all_tiles in (("S", self.S), ("T", self.T), ("limits", self.limits)):
                there.put(self.places[name] + int(tile) * all_tiles[tile].nbytes, all_tiles[tile])
        self.changed[:] = self.known[:] = self.told[:] = False
        for name in COUNTS:
            there.put(self.places[name], getattr(self, name))
        before = self.reached.copy()
        given = self.numbers | {"count": count} | self.places
        there.launch(self.kernel, self.lanes // TILE, TILE, [given[name] for name in ARGUMENTS])
        for name in COUNTS:
            there.fetch(self.places[name], getattr(self, name))
        self.done += int((self.reached - before).max())


COUNTS = ("broken", "due", "every", "at", "stop", "reached")  # a number of each lane, copied there and back with each call


def _drop(there: Card, places: dict[str, int]) -> None:
    with contextlib.suppress(DeviceError):  # at the end of a process the driver may have gone first
        there.enter()
        for address in places.values():
            there.drop(address)
