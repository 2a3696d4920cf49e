"""Values between two bounds, by the share of the way from one to the other: an even way, or one by the logarithm."""

from __future__ import annotations

from typing import Protocol

from ..numerics.scalar import log, power


class Ends(Protocol):
    """What lies between two bounds (SI)."""

    @property
    def low(self) -> float: ...

    @property
    def high(self) -> float: ...

    @property
    def logarithmic(self) -> bool: ...

    def value(self, share: float) -> float: ...


class Between:
    """The way from ``low`` to ``high``, both above zero where it is ``logarithmic``."""

    def value(self: Ends, share: float) -> float:
        """The value (SI) at a share of the way, which is held between the bounds; at its ends it is a bound to the bit."""
        share = min(max(share, 0.0), 1.0)
        if share == 1.0:
            return self.high
        found = self.low * power(self.high / self.low, share) if self.logarithmic else self.low + share * (self.high - self.low)
        return min(max(found, self.low), self.high)

    def share(self: Ends, value: float) -> float:
        """Where a value lies on the way."""
        if self.logarithmic:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def slope(self: Ends, share: float) -> float:
        """Derivative of the value by the share."""
        return self.value(share) * log(self.high / self.low) if self.logarithmic else self.high - self.low
