"""How a run ended, and where it stands."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """How a run ended, or where it stands. Each is also its text, in files and in comparisons:
    ``Status.COMPLETE == "complete"``.
    """

    COMPLETE = "complete"  # it came to its end
    INTERRUPTED = "interrupted"  # Ctrl-C; what was computed before is kept
    DIVERGED = "diverged"  # numbers beyond all bounds, or a structure that nothing holds
    ENERGY = "energy"  # more energy came or went than the ledger accounts for
    NOT_CONVERGED = "not converged"  # no equilibrium within the iterations allowed
    RUNNING = "running"  # what a run file says while it is written
    UNFINISHED = "unfinished"  # what a reader calls that: killed, or still at work


@dataclass(frozen=True)
class Progress:
    """Where a run stands."""

    done: int
    steps: int
    seconds: float
    text: str = ""

    @property
    def share(self) -> float:
        """Part that is done, 0 to 1."""
        return self.done / self.steps

    @property
    def speed(self) -> float:
        """Steps a second."""
        return self.done / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def left(self) -> float:
        """Seconds left."""
        return (self.steps - self.done) / self.speed if self.speed else float("nan")
