"""How many steps go into one call of a loop, which nothing can interrupt: as many as last a quarter of a second."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .synchronised import Stepper

SECONDS = 0.25  # of one call, between two looks at signals, the clock and the progress line
FIRST = 16  # steps of the first call, when nobody knows how long one lasts
QUICK = 1000  # the same where a step is known to be short: some 50 microseconds at the most
GROWTH = 4  # from one call to the next, at the most


class Pace:
    """Learns how long steps last, from so many in the ``first`` call; ``look`` is called after each call of the loop."""

    def __init__(self, look: Callable[[], None] | None = None, first: int = FIRST) -> None:
        self.look, self.room, self.seconds = look, first, 0.0

    def call(self, runner: Stepper, count: int, outputs: int = 1, *, anew: bool = True, record: bool = True) -> NDArray[np.float64]:
        """One call of the loop, timed; see :meth:`~vfife.codegen.runner.Runner.advance`."""
        began = time.perf_counter()
        rows = runner.advance(count, outputs, anew=anew, record=record)
        spent = time.perf_counter() - began
        self.seconds += spent
        steps = count * outputs
        self.room = max(1, min(GROWTH * max(steps, FIRST), int(steps * SECONDS / max(spent, 1e-6))))
        if self.look is not None:
            self.look()
        return rows

    def advance(self, runner: Stepper, count: int, outputs: int) -> NDArray[np.float64]:
        """``outputs`` times ``count`` steps, in as many calls as it takes; the same rows as in one."""
        parts = []
        done = 0
        while done < outputs:
            if (some := min(outputs - done, self.room // count)) > 0:
                parts.append(self.call(runner, count, some))
            else:
                some, inside = 1, 0
                while inside < count:
                    piece = min(self.room, count - inside)
                    rows = self.call(runner, piece, anew=inside == 0, record=inside + piece == count)
                    inside += piece
                parts.append(rows)
            done += some
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
