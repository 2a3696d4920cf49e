"""A runner whose members are stepped by a graphics card, one a thread."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DeviceError
from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from .cuda import WITHOUT, Card, card
from .gpu import ARGUMENTS, TILE
from .native import NEVER, Memory, Rows, Take
from .ptx import program
from .runner import Integers, Runner

STATES, OUTPUTS = 0.5, 0.25  # shares of the free memory: of the states of a batch and what belongs to them, of what one launch hands out


class DeviceRunner(Runner):
    """A :class:`~vfife.codegen.runner.Runner` of as many members as there are ``states``, on a card; the same rows, to the bit.

    A call is one launch for as many members as the card's memory holds, and nothing interrupts a launch: callers pace their calls as those of any
    loop. States stay on the card between calls; who reads ``states`` has them copied here, and may write to them: the next call takes them back
    there. Where members are watched, one that is broken, or that nobody looks at, ends at its next look, and the others go on. Raises DeviceError.
    """

    def __init__(
        self, topology: Topology, states: Rows, functions: Rows, loop: str, kept: Integers, *, own: Card | None = None, **options: Any
    ) -> None:
        if loop != "generated":
            raise DeviceError(f"device cuda: a card steps straight-line code, and this is for the {loop} loop; {WITHOUT}")
        self.card = own or card()
        super().__init__(topology, states, functions, loop, kept, **options)

    def _chosen(self) -> Callable[[Memory], Take]:
        def made(memory: Memory) -> Take:
            self.batches = Batches(self.card, self.topology, memory, self.lanes)
            return self.batches

        return made

    @property
    def states(self) -> Rows:
        """Present state, shape (rows, members)."""
        if hasattr(self, "batches"):
            self.batches.bring_back()
        return super().states


class Batches:
    """Steps on a memory, by as many tiles of members at once as a card has room for."""

    def __init__(self, card: Card, topology: Topology, memory: Memory, members: int) -> None:
        self.card, self.memory, self.members, self.layout = card, memory, members, Layout(topology)
        card.enter()
        self.kernel = card.program(program(topology), "simulate")
        self.length, self.tiles = len(memory.T) // members, -(-members // TILE)
        sizes = {"S": self.layout.rows, "Q": self.layout.rows, "T": self.length, "shares": 1, "limits": 2 * len(memory.limited), "broken": 1}
        free, one = card.free(), 8 * TILE * sum(sizes.values())
        if STATES * free < one:
            raise DeviceError(
                f"device cuda: {TILE} members take {one} bytes of the card, of which {free} are free; end what else runs on it; {WITHOUT}"
            )
        self.batch = min(self.tiles, int(STATES * free / one))
        self.most = int(OUTPUTS * free / (8 * TILE * self.batch * max(len(memory.kept), 1)))  # outputs of a launch
        self.places: dict[str, int] = {}
        weakref.finalize(self, _drop, card, self.places)
        for name, size in sizes.items():
            self.places[name] = card.room(TILE * self.batch * size)
        for name in ("kept", "extremes", "limited"):
            self.places[name] = card.room(len(getattr(memory, name)))
            card.put(self.places[name], getattr(memory, name))
        self.room, self.first = 0, -1  # numbers handed out that there is room for; the first tile of the batch that is on the card

    def __call__(self, n0: int, steps: int, out: Rows, anew: bool = True, look: int = NEVER) -> None:
        """As all loops are called."""
        self.card.enter()
        some = max(1, min(self.most, len(out)))
        for first in range(0, self.tiles, self.batch):
            self._bring(first)
            for m in range(0, len(out), some):
                self._launch(n0 + m * steps, steps, out[m : m + some], anew, look)

    def _launch(self, n0: int, steps: int, out: Rows, anew: bool, look: int) -> None:
        m, there, (first, last), where = self.memory, self.card, self._range(), self.places
        outputs, keeping, _ = out.shape
        found = np.empty((self._tiles(), outputs * keeping, TILE))
        if found.size > self.room:
            if "out" in where:
                there.drop(where.pop("out"))
            where["out"], self.room = there.room(found.size), found.size
        there.clear(where.get("out", 0), found.size)  # of a member that breaks, what comes after that is zero
        broken = m.broken[self._members()]
        there.put(where["broken"], broken)
        numbers = {"stride": self.length, "n0": n0, "count": steps, "outputs": outputs, "parts": m.parts, "keeping": keeping, "look": look}
        numbers |= {"resetting": len(m.extremes) * anew, "finite": len(m.kept), "limiting": len(m.limited)} | {"out": 0} | where
        there.launch(self.kernel, self._tiles(), TILE, [numbers[name] for name in ARGUMENTS])
        there.fetch(where["broken"], broken)
        there.fetch(where.get("out", 0), found)
        m.broken[first:last] = broken[: last - first]
        out[:, :, first:last] = rows_of(found)[:, : last - first].reshape(outputs, keeping, last - first)

    def _tiles(self) -> int:
        """Tiles of the batch that is on the card."""
        return min(self.batch, self.tiles - self.first)

    def _range(self) -> tuple[int, int]:
        """The first member of the batch, and the first beyond it."""
        return TILE * self.first, min(TILE * (self.first + self._tiles()), self.members)

    def _members(self) -> NDArray[np.intp]:
        """Members of the batch, one a thread; threads without one repeat the last."""
        first, last = self._range()
        return np.minimum(np.arange(first, first + TILE * self._tiles()), last - 1)

    def _bring(self, first: int) -> None:
        """Copies a batch to the card, and the one there back."""
        if self.first == first:
            return
        self.bring_back()
        self.first = first
        m, members = self.memory, self._members()
        for name, rows in (("S", m.S), ("limits", m.limits), ("shares", m.shares)):
            self.card.put(self.places[name], tiles_of(rows.reshape(-1, self.members)[:, members]))
        self.card.put(self.places["T"], m.T.reshape(self.members, self.length)[members])

    def bring_back(self) -> None:
        """Copies the states that are on the card back; the next call takes them there again."""
        if self.first < 0:
            return
        self.card.enter()
        tiles, (first, last) = np.empty((self._tiles(), self.layout.rows, TILE)), self._range()
        self.card.fetch(self.places["S"], tiles)
        self.memory.S.reshape(-1, self.members)[:, first:last] = rows_of(tiles)[:, : last - first]
        self.first = -1


def tiles_of(rows: Rows) -> Rows:
    """Rows of whole tiles of members, tile by tile: shape (tiles, rows, 32)."""
    count, members = rows.shape
    return np.ascontiguousarray(rows.reshape(count, members // TILE, TILE).transpose(1, 0, 2))


def rows_of(tiles: Rows) -> Rows:
    """The reverse."""
    number, count, _ = tiles.shape
    return tiles.transpose(1, 0, 2).reshape(count, number * TILE)


def _drop(card: Card, places: dict[str, int]) -> None:
    for address in places.values():
        card.drop(address)
