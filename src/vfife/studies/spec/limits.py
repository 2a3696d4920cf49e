"""What a sample of machines says of all of them: quantiles and shares, with limits of confidence.

The machines are taken to be independent draws; samples of a hypercube or of Sobol's sequence say more than
that, so their limits are wide ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import Fault, kind_of, shown, suggestion
from ...schema import Reading
from ...units import number
from .sampling import Array

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """A number of all machines as a sample shows it, and limits between which it lies with the confidence
    asked for; infinite where the sample is too small to say.
    """

    value: float
    low: float
    high: float


def quantile(values: Array, share: float, confidence: float = CONFIDENCE) -> Estimate:
    """The value below which a share of all machines lies, from the finite ``values`` of a sample.

    The estimate lies between the values of ranks (n - 1) q below and above. The limits are values of the
    sample themselves: of n draws the number B below the quantile is binomial, so those of ranks r and s, the
    greatest r with P(B < r) ≤ α/2 and the least s with P(B ≥ s) ≤ α/2, hold it with at least the confidence 1
    - α, whatever the distribution (David, Nagaraja: Order Statistics, 7.1).
    """
    import numpy as np

    ranked = np.sort(values)
    n = len(ranked)
    if not n:
        return Estimate(math.nan, -math.inf, math.inf)
    half = 0.5 * (1.0 - confidence)
    below = cumulative(n, share)  # P(B ≤ k) at k
    r = int(np.searchsorted(below, half, side="right"))  # P(B < r) = P(B ≤ r - 1) ≤ α/2
    s = int(np.searchsorted(below, 1.0 - half, side="left")) + 1  # P(B ≥ s) = 1 - P(B ≤ s - 1) ≤ α/2
    low = float(ranked[r - 1]) if r >= 1 else -math.inf
    high = float(ranked[s - 1]) if s <= n else math.inf
    return Estimate(float(np.quantile(ranked, share)), low, high)


def share(count: int, of: int, confidence: float = CONFIDENCE) -> Estimate:
    """The share of all machines, of whom ``count`` were found in a sample, with Wilson's limits: the shares p
    for which the count is not further than z standard deviations √(p (1 - p) n) from p n (Wilson 1927).
    """
    from scipy.special import ndtri

    if not of:
        return Estimate(math.nan, 0.0, 1.0)
    z = float(ndtri(0.5 * (1.0 + confidence)))
    z2 = z * z
    p = count / of
    middle, half = p + 0.5 * z2 / of, math.sqrt(z2 / of * (p * (1.0 - p) + 0.25 * z2 / of))
    low, high = ((middle + side * half) / (1.0 + z2 / of) for side in (-1.0, 1.0))
    return Estimate(p, max(low, 0.0) if count else 0.0, min(high, 1.0) if count < of else 1.0)


def mean(values: Array, confidence: float = CONFIDENCE) -> Estimate:
    """Estimate the mean of all machines from the finite ``values`` of a sample.

    The limits are z standard errors from the mean of the sample, by the central limit theorem: of skewed
    measures and few machines they are too narrow. Infinite for fewer than two values.
    """
    import numpy as np
    from scipy.special import ndtri

    n = len(values)
    if n < 2:
        return Estimate(float(values[0]) if n else math.nan, -math.inf, math.inf)
    middle, half = (
        float(np.mean(values)),
        float(ndtri(0.5 * (1.0 + confidence)) * np.std(values, ddof=1)) / math.sqrt(n),
    )
    return Estimate(middle, middle - half, middle + half)


def widened(estimate: Estimate, error: float) -> Estimate:
    """An estimate whose limits hold a further error to both sides, too."""
    return Estimate(estimate.value, estimate.low - error, estimate.high + error)


def allowed_failures(of: int, failing: float, confidence: float = CONFIDENCE) -> int:
    """How many of a sample may fail where at most a share ``failing`` of all machines shall, with this
    confidence; -1 where it is too small.

    The greatest k with P(B ≤ k) ≤ 1 - confidence, B binomial of the share: did more machines than that fail,
    so few in a sample would be rarer.
    """
    import numpy as np

    return int(np.searchsorted(cumulative(of, failing), 1.0 - confidence, side="right")) - 1


def needed(failing: float, confidence: float = CONFIDENCE) -> int:
    """Machines of which none fails that show with this confidence that at most a share does: (1 - failing)^n
    ≤ 1 - confidence.
    """
    return math.ceil(math.log(1.0 - confidence) / math.log1p(-failing) - 1e-9)


def cumulative(n: int, p: float) -> Array:
    """P(B ≤ k) for k = 0 to n, B binomial."""
    import numpy as np
    from scipy.special import bdtr

    found: Array = bdtr(np.arange(n + 1.0), n, p)
    return found


ENDS = ("low", "high")


@dataclass(frozen=True)
class Bound:
    """A limit of a measure: at least ``low``, at most ``high``, in SI units."""

    measure: str
    low: float = -math.inf
    high: float = math.inf

    def excess(self, value: float) -> float:
        """How far beyond it a value is, zero or less where it is kept; infinite for no value."""
        over = max(value - self.high, self.low - value)
        return over if math.isfinite(value) else math.inf

    def surely_fails(self, value: float, error: float) -> bool:
        """Whether a value is beyond the limit, to whichever side it is wrong by an ``error``; no value fails."""
        return not math.isfinite(value) or value - error > self.high or value + error < self.low

    def may_fail(self, value: float, error: float) -> bool:
        """Whether a value is beyond the limit, or would be if it is wrong by an ``error``."""
        return not math.isfinite(value) or value + error > self.high or value - error < self.low

    def words(self, unit: str) -> str:
        """The limit as a person says it."""
        said = "" if unit == "1" else f" {unit}"
        ends = ((self.low, "at least"), (self.high, "at most"))
        return " and ".join(f"{word} {end:.6g}{said}" for end, word in ends if math.isfinite(end))


def read_bounds(raw: Any, units: Mapping[str, str], by: Reading) -> tuple[Bound, ...]:
    """The limits of a table ``[limit]``: by measure the most that is allowed, or a table of ``low`` and
    ``high``. What is wrong is told.
    """
    if not isinstance(raw, dict):
        by.refuse(
            ("limit",),
            f"this is {kind_of(raw)}",
            shown(raw),
            "a table",
            'write [limit] and, under it, "C.force.max" = "2 kN"',
        )
        return ()
    found = []
    for measure, given in flat(raw):
        where = ("limit", measure)
        if measure not in units:
            by.refuse(
                where,
                "a limit of what is not measured",
                "",
                "",
                suggestion(measure, units, "name one of the measures"),
            )
            continue
        ends = given if isinstance(given, dict) else {"high": given}
        read = {key: quantity(value, units[measure], (*where, key), by) for key, value in ends.items()}
        known = {key: value for key, value in read.items() if value is not None}
        if len(known) < len(read):
            continue
        if not known.get("low", -math.inf) < known.get("high", math.inf):
            by.refuse(
                where,
                "no number is within this limit",
                shown(given),
                "low below high",
                "exchange or correct them",
            )
        else:
            found.append(Bound(measure, **known))
    return tuple(found)


def flat(raw: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Measures and what is said of them; a name without quotes has become tables in tables."""
    for key, value in raw.items():
        name = f"{above}.{key}" if above else str(key)
        if isinstance(value, dict) and value and not set(value) <= set(ENDS):
            yield from flat(value, name)
        else:
            yield name, value


def quantity(value: Any, unit: str, where: tuple[str, ...], by: Reading) -> float | None:
    """A quantity in SI units; None where it is none, which is told."""
    try:
        return number(value, "1" if unit == "%" else unit)
    except Fault as error:
        by.refuse(where, f"this is {error.what}", shown(value), error.limit, f"write {error.remedy}")
        return None
