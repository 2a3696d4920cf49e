"""Where in the space of parameters the members of a study lie: at random, in a Latin hypercube, on Sobol's sequence.

A member of a number keeps its place when more are asked for, at random and on the sequence; a hypercube is one of a given count. Places are the
same on every machine: whole numbers of PCG64 and of the sequence, and quantiles to ten digits.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..errors import Fault
from .distributions import Array, Distribution

MOST_DIMENSIONS = 1000
HALF = 0.5**54  # no place lies on a limit
LEVELS, JUMP = 4, 2  # of Morris's grid


def points(parameters: Sequence[Distribution], method: str, count: int, seed: int = 0) -> Array:
    """Values in SI units, a row for each place of a method. Raises Fault."""
    unit = places(method, count, len(parameters), seed)
    return np.stack([one.quantile(unit[:, k]) for k, one in enumerate(parameters)], axis=1) if parameters else unit


def places(method: str, count: int, dimensions: int, seed: int = 0) -> Array:
    """Places in the unit cube, shape (rows, dimensions), every number above 0 and below 1. Raises Fault.

    "random", "latin" and "sobol" have ``count`` rows. Two designs ask for sensitivities: "saltelli" has count (dimensions + 2) rows, "morris"
    count (dimensions + 1).
    """
    if method not in METHODS:
        raise Fault("", "an unknown way to choose points", f'"{method}"', ", ".join(METHODS), "write one of these words")
    if not 0 < count <= 2**30:
        raise Fault("", "a count of points that cannot be had", str(count), f"1 to {2**30}", "correct the count")
    if dimensions > MOST_DIMENSIONS:
        raise Fault("", "more parameters than can be sampled", str(dimensions), f"at most {MOST_DIMENSIONS}", "tie some together")
    return METHODS[method](count, dimensions, seed) if dimensions else np.empty((count, 0))


def random(count: int, dimensions: int, seed: int) -> Array:
    """Independent places, row after row."""
    return fractions(np.random.PCG64(seed), count * dimensions).reshape(count, dimensions)


def latin(count: int, dimensions: int, seed: int) -> Array:
    """A Latin hypercube: of ``count`` slices along each axis every one holds one place (McKay, Beckman, Conover 1979)."""
    drawn = fractions(np.random.PCG64(seed), 2 * count * dimensions).reshape(2, count, dimensions)
    found: Array = (np.argsort(drawn[0], axis=0, kind="stable") + drawn[1]) / count
    return found


def sobol(count: int, dimensions: int, seed: int) -> Array:
    """Sobol's sequence with the direction numbers of Joe and Kuo, scrambled (Matoušek) by the seed; best taken in powers of two."""
    from scipy.stats.qmc import Sobol

    source = np.random.Generator(np.random.PCG64(seed))
    known = inspect.signature(Sobol.__init__).parameters
    given: dict[str, Any] = {"rng" if "rng" in known else "seed": source}  # scipy renames it
    sequence = Sobol(dimensions, scramble=True, bits=53, **given)
    power = max(count - 1, 1).bit_length()
    found: Array = np.maximum(sequence.random_base2(power)[:count], HALF)
    return found


def saltelli(count: int, dimensions: int, seed: int) -> Array:
    """Saltelli's design (2010) on Sobol's sequence: two independent places A and B, and between them A with one number of B, for each number."""
    both = sobol(count, 2 * dimensions, seed)
    first, second = both[:, :dimensions], both[:, dimensions:]
    rows = np.repeat(first[:, None, :], dimensions + 2, axis=1)
    for k in range(dimensions):
        rows[:, k + 1, k] = second[:, k]
    rows[:, -1] = second
    return rows.reshape(-1, dimensions)


def morris(count: int, dimensions: int, seed: int) -> Array:
    """Trajectories of Morris (1991): from a place on a grid of four levels, 1/8 to 7/8, each number in turn is moved by two of them."""
    drawn = fractions(np.random.PCG64(seed), 2 * count * dimensions).reshape(count, 2, dimensions)
    start = np.floor(LEVELS * drawn[:, 0])
    order = np.argsort(drawn[:, 1], axis=1, kind="stable")
    rows = np.repeat(start[:, None, :], dimensions + 1, axis=1)
    for k in range(count):
        for turn, axis in enumerate(order[k]):
            rows[k, turn + 1 :, axis] += JUMP if start[k, axis] < JUMP else -JUMP
    found: Array = (rows.reshape(-1, dimensions) + 0.5) / LEVELS
    return found


def fractions(source: np.random.PCG64, count: int) -> Array:
    """Numbers above 0 and below 1 from the whole numbers of a generator, whose stream NumPy keeps from version to version."""
    whole: np.ndarray[Any, np.dtype[np.uint64]] = np.asarray(source.random_raw(count)) >> np.uint64(11)
    return np.asarray(whole * 0.5**53 + HALF)


METHODS: dict[str, Callable[[int, int, int], Array]] = {"latin": latin, "random": random, "sobol": sobol, "saltelli": saltelli, "morris": morris}
