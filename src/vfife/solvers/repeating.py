"""Turns of a crank at constant speed, and whether they repeat: what two turns are compared by, and a watch
that ends a run which has settled.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, StepChoice
from ..kernels.arrays import Layout

Array = NDArray[np.float64]

LONGEST = 8  # turns of a period that is looked for
LEAST_STREAK = 2  # turns in a row that repeat, after which a run ends: once may be by chance
SETTLED = 0.01  # distance at which turns are said to repeat, where the settings of a run do not say another
REPEATED = ("body_alpha", "contact_normal_force")  # beside the extremes, what two turns are compared by
SQUARES = tuple(f"{entity}_force_squared_max" for entity in ("contact", "guide", "joint", "driven", "spring"))
MOMENTS = ("joint_moment_max", "driven_torque_max")
ACCELERATIONS = ("body_alpha", "body_alpha_max")
LEAST = 0.1  # of the largest of its kind: what is smaller is compared with that
ROUNDING = 16.0 * 2.2e-16  # of an angle (rad), which shows in its second difference
NOISE = 1e-9  # of the largest load
OVER_NOISE = 1e3  # times which a quantity has to be, or it is compared with that
GLANCES = (
    24  # outputs of a turn by which it is told that it does not repeat another one; that it does, by all
)
SURE = 1.0 + 1e-9  # times which a difference has to be, beyond all rounding


def distance(before: Array, after: Array, least: Array | None = None) -> float:
    """How far two turns lie apart: the largest difference at an output over the largest absolute value of a
    quantity, of all the worst.

    Shapes (outputs, quantities). A quantity that is zero in both turns does not count; one smaller than its
    ``least`` is compared with that.
    """
    size = np.maximum(np.abs(before).max(axis=0), np.abs(after).max(axis=0))
    size = size if least is None else np.maximum(size, least)
    change = np.abs(after - before).max(axis=0)
    return float(np.max(np.divide(change, size, out=np.zeros_like(change), where=size > 0.0), initial=0.0))


def compared_rows(layout: Layout) -> list[int]:
    """Rows of S by which two turns are compared: extremes, angular accelerations and contact forces."""
    return [*layout.of("extreme"), *(int(row) for name in REPEATED for row in layout[name])]


def outputs_of_a_turn(assembly: Assembly) -> int | None:
    """Outputs in a turn of a crank at constant speed; None where nothing turns so, or where a turn holds no
    whole number of them.
    """
    moving = [driver for driver in assembly.mechanism.drivers.values() if driver.moves]
    return (
        None if any(driver.steady_speed is None for driver in moving) else outputs_per_turn(assembly.choice)
    )


def outputs_per_turn(choice: StepChoice) -> int | None:
    """Outputs in a turn; None where there is no turn, or it holds no whole number of them."""
    if choice.turn is None:
        return None
    exact = choice.turn / (choice.step * choice.outputs_every)
    count = round(exact)
    return count if count >= 1 and abs(exact - count) <= 1e-9 * count else None


class Comparison:
    """Compares turns of a run by the rows that it kept: what is small beside others of its kind, or noise,
    counts for little.
    """

    def __init__(self, assembly: Assembly, recorded: NDArray[np.uint32]) -> None:
        self.layout, self.step = assembly.layout, assembly.choice.step
        place = {int(row): k for k, row in enumerate(recorded)}
        self.rows = [row for row in compared_rows(self.layout) if row in place]
        self.columns = np.array([place[row] for row in self.rows], dtype=np.intp)

    @cached_property
    def families(self) -> dict[str, NDArray[np.intp]]:
        """Places among the columns of quantities of one kind."""
        kinds = {"squares": SQUARES, "moments": MOMENTS, "accelerations": ACCELERATIONS}
        kinds |= {name: (name,) for name in ("contact_normal_force", "contact_penetration_max")}
        rows_of_kind = {
            kind: {int(row) for name in names for row in self.layout.rows_of(name)}
            for kind, names in kinds.items()
        }
        return {
            kind: np.array([k for k, row in enumerate(self.rows) if row in rows], dtype=np.intp)
            for kind, rows in rows_of_kind.items()
        }

    def distance(self, before: Array, after: Array) -> float:
        """:func:`distance` of two turns, shapes (outputs, columns)."""
        return distance(
            before, after, self.least(np.maximum(np.abs(before).max(axis=0), np.abs(after).max(axis=0)))
        )

    def least(self, size: Array) -> Array:
        """What each quantity is compared with at least, from the largest absolute values of all."""
        largest = {kind: float(size[places].max(initial=0.0)) for kind, places in self.families.items()}
        load = max(math.sqrt(largest["squares"]), largest["moments"])
        noise = {
            "squares": (OVER_NOISE * NOISE * load) * (OVER_NOISE * NOISE * load),
            "moments": OVER_NOISE * NOISE * load,
            "accelerations": OVER_NOISE * ROUNDING / (self.step * self.step),
        }
        least = np.zeros_like(size)
        for kind, places in self.families.items():
            share = LEAST * LEAST if kind == "squares" else LEAST
            least[places] = max(share * largest[kind], noise.get(kind, 0.0))
        return least


class Settling:
    """Takes the outputs of a run and knows, at the end of each turn, whether turns repeat within a
    ``tolerance``: then the run has settled.

    They repeat with a period of p turns when as many in a row, and two at the least, have each been within
    the tolerance of the turn p before it.
    """

    def __init__(self, assembly: Assembly, recorded: NDArray[np.uint32], tolerance: float) -> None:
        outputs = outputs_of_a_turn(assembly)
        self.tolerance, self.outputs = tolerance, outputs or 0
        self.comparison = Comparison(assembly, recorded)
        self.turns: deque[Array] = deque(maxlen=LONGEST)
        self.sizes: deque[Array] = deque(maxlen=LONGEST)  # the largest absolute values of each
        self.parts: list[Array] = []
        self.inside = 0  # outputs of the turn under way
        self.streaks = [0] * LONGEST

    @property
    def room(self) -> int:
        """Outputs up to the end of the turn under way; 0 where there are no turns to compare."""
        return self.outputs - self.inside if self.outputs else 0

    @property
    def settled(self) -> bool:
        """Whether turns repeat."""
        return any(streak >= max(period, LEAST_STREAK) for period, streak in enumerate(self.streaks, 1))

    def take(self, rows: Array) -> None:
        """Outputs after that of step 0, no more than there is room for."""
        if not self.outputs or not len(rows):
            return
        self.parts.append(rows[:, self.comparison.columns])
        self.inside += len(rows)
        if self.inside < self.outputs:
            return
        turn = self.parts[0] if len(self.parts) == 1 else np.concatenate(self.parts)
        self.parts, self.inside = [], 0
        size = np.abs(turn).max(axis=0)
        hopeless = self._differing(turn, size)
        for period, before in enumerate(reversed(self.turns), 1):
            near = not hopeless[-period] and self.comparison.distance(before, turn) <= self.tolerance
            self.streaks[period - 1] = self.streaks[period - 1] + 1 if near else 0
        self.turns.append(turn)
        self.sizes.append(size)

    def _differing(self, turn: Array, size: Array) -> NDArray[np.bool_]:
        """Which of the turns before lie further apart than the tolerance already at some outputs, over the
        most that they may be compared with.
        """
        if not self.turns:
            return np.zeros(0, dtype=bool)
        most = np.max([size, *self.sizes], axis=0)
        limit = self.tolerance * SURE * np.maximum(most, self.comparison.least(most))
        some = slice(None, None, max(1, len(turn) // GLANCES))
        return np.asarray(
            (np.abs(np.stack([before[some] for before in self.turns]) - turn[some]) > limit).any(axis=(1, 2))
        )

    def restore(self, rows: Array) -> None:
        """All outputs so far, that of step 0 with them: of those the latest turns decide."""
        if not self.outputs:
            return
        turns = (len(rows) - 1) // self.outputs
        first = 1 + max(turns - 2 * LONGEST, 0) * self.outputs
        while first < len(rows):
            self.take(rows[first : first + self.room])
            first += self.outputs


def repeated_since(
    turns: Sequence[Array], comparison: Comparison, tolerance: float
) -> tuple[int, int] | None:
    """The period (turns) with which the turns of a run repeat, the shortest there is, and the first turn,
    counted from 1, from which on each is within ``tolerance`` of the one a period before; None where they do
    not.

    As many turns as a period has are asked for. ``turns`` have the shape (outputs, columns).
    """
    count = len(turns)
    for period in range(1, min(LONGEST, count // 2) + 1):
        first = count
        while (
            first > period and comparison.distance(turns[first - 1 - period], turns[first - 1]) <= tolerance
        ):
            first -= 1
        if count - first >= period:
            return period, first + 1
    return None
