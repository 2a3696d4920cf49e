"""Quantiles, shares and means of all machines, estimated from a sample with confidence limits; limits of
measures.

Machines are taken to be independent draws. A hypercube or Sobol's sequence estimates better, so for them the
limits are wider than needed. scipy.stats has most of this, but takes half a second to import.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import Fault, kind_of, shown, suggestion
from ...schema import Reader
from ...units import number
from .distributions import Array

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """An estimate of a number of all machines with its confidence limits, which are infinite if the sample is
    too small.
    """

    value: float
    low: float
    high: float


def quantile(values: Array, share: float, confidence: float = CONFIDENCE) -> Estimate:
    """Estimate the value below which a share of all machines lies, from the finite ``values`` of a sample.

    The estimate lies between the values of ranks (n - 1) q below and above. The limits are values of the
    sample themselves: of n draws the number B below the quantile is binomial, so those of ranks r and s, the
    greatest r with P(B < r) ≤ α/2 and the least s with P(B ≥ s) ≤ α/2, hold it with at least the confidence 1
    - α, whatever the distribution (David, Nagaraja: Order Statistics, 7.1).
    """
    ranked = np.sort(values)
    n = len(ranked)
    if not n:
        return Estimate(math.nan, -math.inf, math.inf)
    half = 0.5 * (1.0 - confidence)
    probabilities = cumulative(n, share)  # P(B ≤ k) at k
    r = int(np.searchsorted(probabilities, half, side="right"))  # P(B < r) = P(B ≤ r - 1) ≤ α/2
    s = int(np.searchsorted(probabilities, 1.0 - half, side="left")) + 1  # P(B ≥ s) = 1 - P(B ≤ s - 1) ≤ α/2
    low = float(ranked[r - 1]) if r >= 1 else -math.inf
    high = float(ranked[s - 1]) if s <= n else math.inf
    return Estimate(float(np.quantile(ranked, share)), low, high)


def share(count: int, sample_size: int, confidence: float = CONFIDENCE) -> Estimate:
    """Estimate the share of all machines that have a property, from a ``count`` in a sample.

    The limits are those of Clopper and Pearson (1934): the shares p with P(B ≥ count) = α/2 and
    P(B ≤ count) = α/2 for B binomial of n and p. They hold any share with at least the confidence 1 - α.
    Wilson's (1927) hold a share of 0.18/n with 83 % only, because one such machine in n is above it.
    """
    from scipy.special import betaincinv

    if not sample_size:
        return Estimate(math.nan, 0.0, 1.0)
    half, rest = 0.5 * (1.0 - confidence), sample_size - count
    low = float(betaincinv(count, rest + 1, half)) if count else 0.0
    high = float(betaincinv(count + 1, rest, 1.0 - half)) if rest else 1.0
    return Estimate(count / sample_size, low, high)


def mean(values: Array, confidence: float = CONFIDENCE) -> Estimate:
    """Estimate the mean of all machines from the finite ``values`` of a sample.

    The limits are standard errors times the quantile of Student's t for n - 1 degrees of freedom, exact for
    normal values: of skewed measures and few machines they are too narrow. Infinite for fewer than two
    values.
    """
    from scipy.special import stdtrit

    n = len(values)
    if n < 2:
        return Estimate(float(values[0]) if n else math.nan, -math.inf, math.inf)
    middle = float(np.mean(values))
    half = float(stdtrit(n - 1, 0.5 * (1.0 + confidence)) * np.std(values, ddof=1)) / math.sqrt(n)
    return Estimate(middle, middle - half, middle + half)


def widened(estimate: Estimate, error: float) -> Estimate:
    """Return an estimate with limits that are wider by an error to both sides."""
    return Estimate(estimate.value, estimate.low - error, estimate.high + error)


def allowed_failures(sample_size: int, failing: float, confidence: float = CONFIDENCE) -> int:
    """Return how many of a sample may fail if at most a share ``failing`` of all machines does, with this
    confidence; -1 where the sample is too small.

    It is the greatest k with P(B ≤ k) ≤ 1 - confidence, B binomial of the share: if a larger share failed, so
    few failures in a sample would be less probable.
    """
    return int(np.searchsorted(cumulative(sample_size, failing), 1.0 - confidence, side="right")) - 1


def needed(failing: float, confidence: float = CONFIDENCE) -> int:
    """Return the size n of a sample without failures that shows with this confidence that at most a share
    ``failing`` of all machines fails: (1 - failing)^n ≤ 1 - confidence.
    """
    return math.ceil(math.log(1.0 - confidence) / math.log1p(-failing) - 1e-9)


def cumulative(n: int, p: float) -> Array:
    """Return P(B ≤ k) for k = 0 to n, B binomial of n and p."""
    from scipy.special import bdtr

    return np.asarray(bdtr(np.arange(n + 1.0), n, p))


ENDS = ("low", "high")


@dataclass(frozen=True)
class Bound:
    """A limit of a measure: at least ``low``, at most ``high``, in SI units."""

    measure: str
    low: float = -math.inf
    high: float = math.inf

    def excess(self, value: float) -> float:
        """Return how far a value is beyond the limit, zero or less if it keeps it; infinite for NaN."""
        excess = max(value - self.high, self.low - value)
        return excess if math.isfinite(value) else math.inf

    def fails(self, value: float, margin: float) -> bool:
        """Return whether a value exceeds the limit by more than a ``margin``, which may be negative; True for
        NaN.
        """
        return not math.isfinite(value) or value - margin > self.high or value + margin < self.low

    def words(self, unit: str) -> str:
        """Return the limit in words."""
        suffix = "" if unit == "1" else f" {unit}"
        ends = ((self.low, "at least"), (self.high, "at most"))
        return " and ".join(f"{word} {end:.9g}{suffix}" for end, word in ends if math.isfinite(end))


def read_bounds(raw: Any, units: Mapping[str, str], reader: Reader) -> tuple[Bound, ...]:
    """Read the table ``[limit]``: by measure the largest value, or a table of ``low`` and ``high``."""
    if not isinstance(raw, dict):
        remedy = 'write [limit] and, under it, "C.force.max" = "2 kN"'
        reader.refuse(("limit",), f"this is {kind_of(raw)}", shown(raw), "a table", remedy)
        return ()
    bounds = []
    for measure, limit in flat(raw):
        path = ("limit", measure)
        if measure not in units:
            remedy = suggestion(measure, units, "name one of the measures")
            reader.refuse(path, "a limit of a measure that is not listed", "", "", remedy)
            continue
        ends = limit if isinstance(limit, dict) else {"high": limit}
        read = {key: quantity(value, units[measure], (*path, key), reader) for key, value in ends.items()}
        sound = {key: value for key, value in read.items() if value is not None}
        if len(sound) < len(read):
            continue
        if not sound.get("low", -math.inf) < sound.get("high", math.inf):
            message, remedy = "no number is within this limit", "exchange or correct them"
            reader.refuse(path, message, shown(limit), "low below high", remedy)
        else:
            bounds.append(Bound(measure, **sound))
    return tuple(bounds)


def flat(raw: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield measures and their limits; of a name without quotes TOML has made tables in tables."""
    for key, value in raw.items():
        name = f"{prefix}.{key}" if prefix else str(key)
        if isinstance(value, dict) and value and not set(value) <= set(ENDS):
            yield from flat(value, name)
        else:
            yield name, value


def quantity(value: Any, unit: str, path: tuple[str, ...], reader: Reader) -> float | None:
    """Read a quantity in SI units; None where it is none."""
    try:
        return number(value, "1" if unit == "%" else unit)
    except Fault as error:
        reader.refuse(path, f"this is {error.what}", shown(value), error.limit, f"write {error.remedy}")
        return None
