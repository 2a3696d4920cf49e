"""Rows of S gathered into one a turn: the largest of what is an extreme, the last of all else."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class TurnRows:
    """Gathers outputs, so many in a turn, into rows of whole turns, shape (rows, lanes) each; ``extreme`` says which rows are extremes."""

    outputs: int
    extreme: NDArray[np.bool_]
    turns: list[Array] = field(default_factory=list)
    inside: int = 0  # outputs of the turn under way
    largest: Array | None = None

    def take(self, rows: Array) -> int:
        """Outputs after that of step 0, shape (outputs, rows, lanes), in pieces of any size; how many turns they end."""
        before = len(self.turns)
        while len(rows):
            part, rows = rows[: self.outputs - self.inside], rows[self.outputs - self.inside :]
            most = part.max(axis=0)
            self.largest = most if self.largest is None else np.maximum(self.largest, most)
            self.inside += len(part)
            if self.inside == self.outputs:
                self.turns.append(np.where(self.extreme[:, None], self.largest, part[-1]))
                self.inside, self.largest = 0, None
        return len(self.turns) - before

    @property
    def remembered(self) -> list[Any]:
        """What a checkpoint keeps of the turn under way, for JSON."""
        return [self.inside, [] if self.largest is None else self.largest.tolist()]

    def restore(self, remembered: list[Any], turns: list[Array]) -> None:
        """Takes up what a checkpoint remembers, and the turns before it."""
        self.inside, self.turns = int(remembered[0]), turns
        self.largest = np.array(remembered[1], dtype=float) if self.inside else None

    def array(self, lanes: int, last: int | None = None) -> Array:
        """The turns, shape (turns, rows, lanes); up to the one that ends with the output ``last``, where it is given."""
        some = self.turns if last is None else self.turns[: last // self.outputs]
        return np.array(some).reshape(len(some), len(self.extreme), lanes)
