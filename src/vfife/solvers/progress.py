"""Where a run stands."""

from __future__ import annotations

from dataclasses import dataclass


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
