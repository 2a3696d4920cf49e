"""Which parameters a measure hangs on: Sobol' indices from Saltelli's design, elementary effects from trajectories of Morris, by SALib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from ..errors import VfifeError
from .distributions import Array
from .quantiles import CONFIDENCE
from .sampling import JUMP, LEVELS

EXTRA = 'indices are computed by SALib, which is not installed here: pip install "vfife[sensitivity]"'
RESAMPLED = 200  # times, for limits of confidence


@dataclass(frozen=True)
class Index:
    """The share of a measure's variance that a parameter makes: alone (``first``), and with all it acts together with (``total``).

    Each is give or take its ``_margin`` at 95 %.
    """

    parameter: str
    first: float
    first_margin: float
    total: float
    total_margin: float


@dataclass(frozen=True)
class Effect:
    """How a measure moves when a parameter goes from its 12.5 % to its 62.5 % quantile, or from 37.5 to 87.5 %, over that half of its range: the
    mean of the effects, of their sizes with its margin at 95 %, and their standard deviation, which tells curvature and interaction."""

    parameter: str
    mean: float
    size: float
    size_margin: float
    deviation: float


def sobol_indices(parameters: Sequence[str], values: Array, seed: int = 0) -> tuple[list[Index], int]:
    """Sobol' indices of a measure from its values at Saltelli's design, and how many of its groups were left out for a member without a value.

    First order by Saltelli (2010), total by Jansen (1999), margins by resampling. Raises VfifeError without SALib, where fewer than eight groups
    are left, and for a measure that is the same in all of them.
    """
    analyze, count = salib().sobol, len(parameters)
    groups = whole_groups(values, count + 2)
    found = analyze.analyze(problem(parameters), groups.ravel(), calc_second_order=False, num_resamples=RESAMPLED, conf_level=CONFIDENCE, seed=seed)
    rows = zip(parameters, found["S1"], found["S1_conf"], found["ST"], found["ST_conf"], strict=True)
    return [Index(name, *map(float, row)) for name, *row in rows], len(values) // (count + 2) - len(groups)


def morris_effects(parameters: Sequence[str], places: Array, values: Array, seed: int = 0) -> tuple[list[Effect], int]:
    """Elementary effects of a measure from its values along trajectories, ``places`` being those in the unit cube, and how many were left out.

    Raises VfifeError as :func:`sobol_indices` does.
    """
    analyze, count = salib().morris, len(parameters)
    groups = whole_groups(values, count + 1)
    kept = np.flatnonzero(np.isfinite(values.reshape(-1, count + 1)).all(axis=1))
    levels = (places.reshape(-1, count + 1, count)[kept] * LEVELS - 0.5) / (LEVELS - 1)
    rows = levels.reshape(-1, count)
    found = analyze.analyze(problem(parameters), rows, groups.ravel(), num_levels=LEVELS, num_resamples=RESAMPLED, conf_level=CONFIDENCE, seed=seed)
    # SALib's effects are over the whole grid, three of its steps; ours are over the jump of two.
    over = JUMP / (LEVELS - 1)
    told = zip(parameters, found["mu"], found["mu_star"], found["mu_star_conf"], found["sigma"], strict=True)
    return [Effect(name, *(over * float(one) for one in row)) for name, *row in told], len(values) // (count + 1) - len(groups)


def whole_groups(values: Array, size: int) -> Array:
    """Groups of the design of which every member has a value. Raises VfifeError."""
    groups: Array = values.reshape(-1, size)
    groups = groups[np.isfinite(groups).all(axis=1)]
    if len(groups) < 8:
        raise VfifeError(f"only {len(groups)} groups of {size} members have values, and indices need eight; ask for more (count)")
    if np.ptp(groups) == 0.0:
        raise VfifeError(f"the measure is {groups[0, 0]:g} in every member, so nothing in it hangs on any parameter; name another measure")
    return groups


def problem(parameters: Sequence[str]) -> dict[str, object]:
    """What SALib is told of the parameters: places in the unit cube."""
    return {"num_vars": len(parameters), "names": list(parameters), "bounds": [[0.0, 1.0]] * len(parameters)}


def salib() -> ModuleType:
    """SALib. Raises VfifeError where it is not installed."""
    try:
        import SALib.analyze
        import SALib.analyze.morris
        import SALib.analyze.sobol
    except ImportError:
        raise VfifeError(EXTRA) from None
    module: ModuleType = SALib.analyze
    return module
