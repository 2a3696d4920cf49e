"""Distributions of varied numbers, as given by tolerances and fits, and the places of samples in their space.

With random and Sobol' sampling a case keeps its place when more are requested; a hypercube holds for one
count. Places are the same on every machine: they use the integers of PCG64 and of the sequence, and quantiles
rounded to ten digits. scipy.stats has the same distributions to those digits, but takes a second to import.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from ...errors import Fault
from .iso286 import Fit, fit, zone

SIGMAS = 3.0  # standard deviations from the middle of a tolerance to its limits
NODES = 32  # of a Gauss-Legendre rule over at most six standard deviations: 1e-14 of a probability
GRID = 513  # points of a table of probabilities between which a quantile is sought
DIGITS = 10  # of a drawn value: the last bits of exp and erf differ between machines, these digits do not
Array = np.ndarray[Any, np.dtype[np.float64]]


class Distribution:
    """Distribution of a number in SI units: ``quantile`` at a probability, and ``limits``."""

    def quantile(self, u: Any) -> Array:
        """Return the values at probabilities ``u`` between 0 and 1 (both excluded where a limit is infinite),
        of the shape of ``u``, to ten digits.
        """
        return rounded(self._quantile(np.asarray(u, dtype=float)))

    def _quantile(self, u: Array) -> Array:
        raise NotImplementedError

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest value; infinite where there is none."""
        raise NotImplementedError


@dataclass(frozen=True)
class Uniform(Distribution):
    """A uniform distribution between two values."""

    low: float
    high: float

    def __post_init__(self) -> None:
        ordered(self.low, self.high)

    def _quantile(self, u: Array) -> Array:
        return self.low + u * (self.high - self.low)

    @property
    def limits(self) -> tuple[float, float]:
        """The two values."""
        return self.low, self.high


@dataclass(frozen=True)
class Truncated(Distribution):
    """A normal distribution truncated at two limits; ``centre`` and ``deviation`` are those before
    truncation.

    x = m + s Φ⁻¹(Φ(a) + u (Φ(b) - Φ(a))), with a and b the limits minus m, divided by s.
    """

    centre: float
    deviation: float
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        if not 0.0 < self.deviation < math.inf:
            message = "a standard deviation that is not positive"
            remedy = "give the number itself if it does not vary"
            raise Fault("", message, f"{self.deviation:g}", "above 0", remedy)
        ordered(self.low, self.high)
        if self._share < 1e-6:
            message = "a normal distribution of which almost nothing lies between the limits"
            normal = f"mean {self.centre:g}, standard deviation {self.deviation:g}"
            value = f"{normal}, from {self.low:g} to {self.high:g}"
            limit = "limits that leave a millionth of it"
            raise Fault("", message, value, limit, "move the limits or the mean")

    @property
    def _ends(self) -> tuple[float, float]:
        return (self.low - self.centre) / self.deviation, (self.high - self.centre) / self.deviation

    @property
    def _share(self) -> float:
        a, b = self._ends
        return phi(-a) - phi(-b) if a > 0.0 else phi(b) - phi(a)

    def _quantile(self, u: Array) -> Array:
        from scipy.special import ndtri

        a, b = self._ends
        # In the tail above the mean the mirror image keeps its digits.
        z = -ndtri(phi(-b) + (1.0 - u) * self._share) if a > 0.0 else ndtri(phi(a) + u * self._share)
        return np.asarray(np.clip(self.centre + self.deviation * z, self.low, self.high))

    @property
    def limits(self) -> tuple[float, float]:
        """The limits."""
        return self.low, self.high


@dataclass(frozen=True)
class Normal(Truncated):
    """A normal distribution with mean ``centre`` and a standard deviation."""


@dataclass(frozen=True)
class Clearance(Distribution):
    """Distribution of the clearance (m) of a fit as a joint uses it: half the difference of the diameters, or
    the gap on each side of a block.

    Hole and shaft are independent, each normal about the middle of its tolerance, with its limits at three
    standard deviations and nothing beyond: P(H - S ≤ d) is the integral of the density of S times the
    distribution function of H. If some pairs have no clearance, the distribution is that of the others, and
    ``without`` is the share left out.
    """

    fit: Fit

    @cached_property
    def without(self) -> float:
        """Share of the pairs without clearance."""
        return float(self._cumulative(np.zeros(1))[0]) if self.fit.least < 0.0 else 0.0

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest radial clearance of pairs with clearance (m)."""
        return max(0.5 * self.fit.least, 0.0), 0.5 * self.fit.most

    def _cumulative(self, d: Array) -> Array:
        """Return the probability that the diameters differ by at most d (m), shape (count,)."""
        return self._integrals(d)[0]

    def _integrals(self, d: Array) -> tuple[Array, Array]:
        """Return probability and density at differences d of the diameters (m), shape (count,).

        With s the difference from its middle and y the shaft from its own, the hole is s + y. Between the y
        at which the hole meets its limits the integrand is smooth, so that Gauss' rule converges; beyond the
        upper one every hole is small enough, which adds the probability of these shafts.
        """
        from scipy.special import ndtr

        hole_half, shaft_half = 0.5 * self.fit.hole.width, 0.5 * self.fit.shaft.width
        s = d - 0.5 * (self.fit.least + self.fit.most)
        low, high = (
            np.clip(-hole_half - s, -shaft_half, shaft_half),
            np.clip(hole_half - s, -shaft_half, shaft_half),
        )
        nodes, weights = gauss(NODES)
        y = low[:, None] + 0.5 * (high - low)[:, None] * (nodes + 1.0)
        inside = phi(SIGMAS) - phi(-SIGMAS)
        zy, zx = SIGMAS * y / shaft_half, SIGMAS * (s[:, None] + y) / hole_half
        scale = SIGMAS / (shaft_half * inside * math.sqrt(2.0 * math.pi))
        shaft = scale * np.exp(-0.5 * zy * zy) * 0.5 * (high - low)[:, None]
        hole = (ndtr(zx) - phi(-SIGMAS)) / inside
        density = SIGMAS / (hole_half * inside * math.sqrt(2.0 * math.pi)) * np.exp(-0.5 * zx * zx)
        upper_share = (ndtr(SIGMAS) - ndtr(SIGMAS * high / shaft_half)) / inside
        return (shaft * hole) @ weights + upper_share, (shaft * density) @ weights

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        low, high = (2.0 * end for end in self.limits)
        d = np.linspace(low, high, GRID)
        return d, np.maximum.accumulate(self._cumulative(d))

    def _quantile(self, u: Array) -> Array:
        """Solve for the differences at probabilities by Newton's method, all at once.

        Each stays between two points of a table, which brackets its root; where a step would leave the
        bracket, in the flat tails, it is halved instead.
        """
        d, share = self._table
        target = np.clip(self.without + u.ravel() * (1.0 - self.without), share[0], share[-1])
        k = np.clip(np.searchsorted(share, target), 1, GRID - 1)
        low, high, root, left = d[k - 1], d[k], np.interp(target, share, d), np.arange(len(target))
        for _ in range(12):
            x, goal = root[left], target[left]
            value, slope = self._integrals(x)
            low[left] = np.where(value < goal, x, low[left])
            high[left] = np.where(value < goal, high[left], x)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = x - (value - goal) / slope
            # The ends belong to the bracket: a quantile may be a point of the table.
            inside = (step >= low[left]) & (step <= high[left])
            root[left] = np.where(inside, step, 0.5 * (low[left] + high[left]))
            left = left[np.abs(root[left] - x) > 1e-14 * d[-1]]
            if not len(left):
                break
        return (0.5 * root).reshape(u.shape)


def of_fit(text: str, diameter: float, cut: bool = False) -> Clearance:
    """Return the radial clearance of a fit such as "H8/f7" at a diameter (m).

    Raises Fault for a fit of which no pair has clearance, and for one of which some pairs have none, unless
    ``cut`` leaves those out.
    """
    clearance = Clearance(fit(text, diameter))
    smallest, largest = 1e6 * clearance.fit.least, 1e6 * clearance.fit.most
    value = f'"{text}" at {1e3 * diameter:g} mm, clearance {smallest:g} to {largest:g} µm'
    message = remedy = ""
    if largest <= 0.0 or clearance.without > 0.999:
        message, remedy = (
            "an interference fit: no journal has clearance in its bearing",
            'choose one such as "H8/f7"',
        )
    elif clearance.without and not cut:
        message = f"a transition fit: {100.0 * clearance.without:.2g} % of the pairs have no clearance"
        remedy = "choose a shaft from a to h, or set cut = true to omit those pairs"
    if message:
        raise Fault("", message, value, "a fit with clearance", remedy)
    return clearance


def of_tolerance(nominal: float, lower: float, upper: float) -> Truncated:
    """Return the distribution of a nominal size between two deviations (m): normal around their middle, with
    its limits at three standard deviations. Raises Fault.
    """
    ordered(lower, upper)
    centre, deviation = nominal + 0.5 * (lower + upper), (upper - lower) / (2.0 * SIGMAS)
    return Truncated(centre, deviation, nominal + lower, nominal + upper)


def of_zone(name: str, nominal: float) -> Truncated:
    """Return the distribution of a nominal size (m) in a zone of ISO 286-1, such as "h7". Raises Fault."""
    deviations = zone(name, nominal)
    return of_tolerance(nominal, deviations.low, deviations.high)


def ordered(low: float, high: float) -> None:
    """Raise Fault where limits are not in order."""
    if not low < high:
        message, limit = "limits that are not in order", "the lower one first, and two that differ"
        raise Fault("", message, f"from {low:g} to {high:g}", limit, "correct the limits")


def phi(z: float) -> float:
    """Return the normal distribution function Φ."""
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Return nodes and weights of a Gauss-Legendre rule over -1 to 1, read only."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


def rounded(values: Array) -> Array:
    """Round values to ten digits."""
    return np.array([float(f"{value:.{DIGITS - 1}e}") for value in values.ravel()]).reshape(values.shape)


MOST_DIMENSIONS = 1000
HALF = 0.5**54  # no place lies on a limit
LEVELS, JUMP = 4, 2  # of Morris's grid


def points(parameters: Sequence[Distribution], method: str, count: int, seed: int = 0) -> Array:
    """Return values in SI units, shape (rows, parameters), a row for each place of a method. Raises Fault."""
    unit = places(method, count, len(parameters), seed)
    columns = [distribution.quantile(unit[:, k]) for k, distribution in enumerate(parameters)]
    return np.stack(columns, axis=1) if parameters else unit


def places(method: str, count: int, dimensions: int, seed: int = 0) -> Array:
    """Return places in the unit cube, shape (rows, dimensions), all numbers above 0 and below 1. Raises
    Fault.

    "random", "latin" and "sobol" have ``count`` rows; the designs for sensitivities have more: "saltelli"
    count (dimensions + 2), "morris" count (dimensions + 1).
    """
    if method not in METHODS:
        message, remedy = "an unknown way to choose points", "write one of these words"
        raise Fault("", message, f'"{method}"', ", ".join(METHODS), remedy)
    if not 0 < count <= 2**30:
        message, remedy = "an impossible number of points", "correct the count"
        raise Fault("", message, str(count), f"1 to {2**30}", remedy)
    if dimensions > MOST_DIMENSIONS:
        message, limit = "more parameters than can be sampled", f"at most {MOST_DIMENSIONS}"
        raise Fault("", message, str(dimensions), limit, "tie some together")
    return METHODS[method](count, dimensions, seed) if dimensions else np.empty((count, 0))


def random(count: int, dimensions: int, seed: int) -> Array:
    """Return independent places, row after row, so that a place stays when more are drawn."""
    return fractions(np.random.PCG64(seed), count * dimensions).reshape(count, dimensions)


def latin(count: int, dimensions: int, seed: int) -> Array:
    """Return a Latin hypercube: of ``count`` slices along each axis every one holds one place (McKay,
    Beckman, Conover 1979).

    The order of random numbers is a random order of the slices, and a second number the place in each.
    """
    drawn = fractions(np.random.PCG64(seed), 2 * count * dimensions).reshape(2, count, dimensions)
    return np.asarray((np.argsort(drawn[0], axis=0, kind="stable") + drawn[1]) / count)


def sobol(count: int, dimensions: int, seed: int) -> Array:
    """Return Sobol's sequence with the direction numbers of Joe and Kuo, scrambled (Matoušek) by the seed;
    its balance needs a power of two.
    """
    from scipy.stats.qmc import Sobol

    keyword = "rng" if "rng" in inspect.signature(Sobol.__init__).parameters else "seed"  # scipy renames it
    source: dict[str, Any] = {keyword: np.random.Generator(np.random.PCG64(seed))}
    sequence = Sobol(dimensions, scramble=True, bits=53, **source)
    power = max(count - 1, 1).bit_length()
    return np.asarray(np.maximum(sequence.random_base2(power)[:count], HALF))


def saltelli(count: int, dimensions: int, seed: int) -> Array:
    """Return Saltelli's design (2010) on Sobol's sequence: groups of two independent places A and B, and
    between them A with one number of B, for each number.
    """
    pairs = sobol(count, 2 * dimensions, seed)
    first, second = pairs[:, :dimensions], pairs[:, dimensions:]
    rows = np.repeat(first[:, None, :], dimensions + 2, axis=1)
    for k in range(dimensions):
        rows[:, k + 1, k] = second[:, k]
    rows[:, -1] = second
    return rows.reshape(-1, dimensions)


def morris(count: int, dimensions: int, seed: int) -> Array:
    """Return trajectories of Morris (1991): from a place on a grid of four levels, 1/8 to 7/8, each number in
    a random order is moved by two levels, up from the lower ones and down from the upper.
    """
    drawn = fractions(np.random.PCG64(seed), 2 * count * dimensions).reshape(count, 2, dimensions)
    start = np.floor(LEVELS * drawn[:, 0])
    order = np.argsort(drawn[:, 1], axis=1, kind="stable")
    rows = np.repeat(start[:, None, :], dimensions + 1, axis=1)
    for k in range(count):
        for turn, axis in enumerate(order[k]):
            rows[k, turn + 1 :, axis] += JUMP if start[k, axis] < JUMP else -JUMP
    return np.asarray((rows.reshape(-1, dimensions) + 0.5) / LEVELS)


def fractions(source: np.random.PCG64, count: int) -> Array:
    """Return numbers above 0 and below 1 from the integers of a generator, whose stream NumPy keeps from
    version to version; Generator.random may change.
    """
    integers: np.ndarray[Any, np.dtype[np.uint64]] = np.asarray(source.random_raw(count)) >> np.uint64(11)
    return np.asarray(integers * 0.5**53 + HALF)


METHODS: dict[str, Callable[[int, int, int], Array]] = {
    method.__name__: method for method in (latin, random, sobol, saltelli, morris)
}
