"""Status and progress of a run."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """Status of a run. A member equals its text, also in files: ``Status.COMPLETE == "complete"``."""

    COMPLETE = "complete"  # all steps are taken
    INTERRUPTED = "interrupted"  # Ctrl-C; what was computed before is kept
    DIVERGED = "diverged"  # numbers beyond their bounds, or a structure that nothing holds
    ENERGY = "energy"  # the energy balance is violated
    NOT_CONVERGED = "not converged"  # no equilibrium within the iterations of the settings
    RUNNING = "running"  # in a run file while it is written
    UNFINISHED = "unfinished"  # a reader's word for such a file: killed, or still running


@dataclass(frozen=True)
class Progress:
    """Progress of a run: ``done`` of ``steps`` steps after ``seconds``, and a ``text`` if that is not
    enough. ``beyond_forecast``: a search that needs more cases than forecast, so that its share means little.
    """

    done: int
    steps: int
    seconds: float
    text: str = ""
    beyond_forecast: bool = False

    @property
    def share(self) -> float:
        """Share of the steps that is done, 0 to 1."""
        return self.done / self.steps

    @property
    def speed(self) -> float:
        """Steps per second."""
        return self.done / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def left(self) -> float:
        """Estimated remaining seconds."""
        return (self.steps - self.done) / self.speed if self.speed else float("nan")
