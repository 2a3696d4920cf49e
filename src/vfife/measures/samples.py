"""A measure at several step sizes, and the range of its error that follows from them."""

from __future__ import annotations

from dataclasses import dataclass

from .extrapolation import LANES_OF_MEANS, SCATTER, SCATTER_OF_MEANS, error_range, widen
from .values import Measured


@dataclass(frozen=True)
class Samples:
    """A measure at the step sizes of a run and its companions: ``value`` is reported, ``values`` are those of
    all lanes, the run's first.

    ``ratios`` are the steps of the lanes over that of the run. ``lowest`` and ``highest`` are the extremes
    over turns. ``scatters``: the value is a mean over all lanes, whose differences are random.
    ``mean_error``: by how much the mean over turns of another run differs
    (:func:`~.extrapolation.error_of_mean`), if the motion is not periodic.
    """

    value: float
    values: tuple[float, ...]
    ratios: tuple[float, ...]
    lowest: float
    highest: float
    scatters: bool = False
    mean_error: float = 0.0

    @property
    def low(self) -> float:
        """Least value of all lanes."""
        return min(self.values)

    @property
    def high(self) -> float:
        """Largest value of all lanes."""
        return max(self.values)

    @property
    def hull(self) -> Measured:
        """The measure with the range of its values."""
        return Measured(self.value, self.low, self.high, lowest=self.lowest, highest=self.highest)

    def draws(self, name: str) -> tuple[float, float]:
        """Return the range of the values and of means over turns of other runs."""
        low, high = widen(name, self.value, self.value, self.mean_error)
        return min(self.low, low), max(self.high, high)

    def error_range(self, name: str) -> tuple[float, float]:
        """Return the range that estimates the error; that of the values if all lanes have one step size.

        The range of a mean over turns is not cut at ``lowest`` and ``highest``, although no mean lies beyond
        all of its turns: it is that of the mean over all turns of the motion, for vanishing steps, of which
        these are a sample. If a share p of all turns lies beyond the mean, n independent turns miss all of
        them with the probability (1 - p)^n, and rare turns, as with a hard knock, may decide a mean.
        """
        if len(set(self.ratios)) < 2:
            return self.low, self.high
        if self.scatters:
            share = SCATTER_OF_MEANS if len(self.values) >= LANES_OF_MEANS else SCATTER
            low, high = widen(name, self.low, self.high, share * (self.high - self.low))
            lower, upper = self.draws(name)
            return min(low, lower), max(high, upper)
        return error_range(name, self.ratios, self.values)
