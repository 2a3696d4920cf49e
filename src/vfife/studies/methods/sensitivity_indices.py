"""Which parameters a measure hangs on: Sobol' indices from Saltelli's design, elementary effects from
trajectories of Morris, by SALib.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from ...errors import VfifeError
from ...results.studied import Study
from ...solvers.status import Status
from ..engine.run_missing import plan_of
from ..engine.study_file import Written, fitting
from ..spec.limits import CONFIDENCE
from ..spec.plan import Parameter
from ..spec.sampling import JUMP, LEVELS, Array, places, points

EXTRA = 'indices are computed by SALib, which is not installed here: pip install "vfife[sensitivity]"'
RESAMPLED = 200  # times, for limits of confidence


@dataclass(frozen=True)
class Index:
    """The share of a measure's variance that a parameter makes: alone (``first``), and with all it acts
    together with (``total``).

    Each is give or take its ``_margin`` at 95 %.
    """

    parameter: str
    first: float
    first_margin: float
    total: float
    total_margin: float


@dataclass(frozen=True)
class Effect:
    """How a measure moves when a parameter goes from its 12.5 % to its 62.5 % quantile, or from 37.5 to 87.5
    %, over that half of its range: the mean of the effects, of their sizes with its margin at 95 %, and their
    standard deviation, which tells curvature and interaction.
    """

    parameter: str
    mean: float
    size: float
    size_margin: float
    deviation: float


def sobol_indices(parameters: Sequence[str], values: Array, seed: int = 0) -> tuple[list[Index], int]:
    """Sobol' indices of a measure from its values at Saltelli's design, and how many of its groups were left
    out for a member without a value.

    First order by Saltelli (2010), total by Jansen (1999), margins by resampling. Raises VfifeError without
    SALib, where fewer than eight groups are left, and for a measure that is the same in all of them.
    """
    analyze, count = salib().sobol, len(parameters)
    groups = whole_groups(values, count + 2)
    found = analyze.analyze(
        problem(parameters),
        groups.ravel(),
        calc_second_order=False,
        num_resamples=RESAMPLED,
        conf_level=CONFIDENCE,
        seed=seed,
    )
    rows = zip(parameters, found["S1"], found["S1_conf"], found["ST"], found["ST_conf"], strict=True)
    return [Index(name, *map(float, row)) for name, *row in rows], len(values) // (count + 2) - len(groups)


def morris_effects(
    parameters: Sequence[str], places: Array, values: Array, seed: int = 0
) -> tuple[list[Effect], int]:
    """Elementary effects of a measure from its values along trajectories, ``places`` being those in the unit
    cube, and how many were left out.

    Raises VfifeError as :func:`sobol_indices` does.
    """
    analyze, count = salib().morris, len(parameters)
    groups = whole_groups(values, count + 1)
    kept = np.flatnonzero(np.isfinite(values.reshape(-1, count + 1)).all(axis=1))
    levels = (places.reshape(-1, count + 1, count)[kept] * LEVELS - 0.5) / (LEVELS - 1)
    rows = levels.reshape(-1, count)
    found = analyze.analyze(
        problem(parameters),
        rows,
        groups.ravel(),
        num_levels=LEVELS,
        num_resamples=RESAMPLED,
        conf_level=CONFIDENCE,
        seed=seed,
    )
    # SALib's effects are over the whole grid, three of its steps; ours are over the jump of two.
    over = JUMP / (LEVELS - 1)
    told = zip(parameters, found["mu"], found["mu_star"], found["mu_star_conf"], found["sigma"], strict=True)
    return [Effect(name, *(over * float(one) for one in row)) for name, *row in told], len(values) // (
        count + 1
    ) - len(groups)


def whole_groups(values: Array, size: int) -> Array:
    """Groups of the design of which every member has a value. Raises VfifeError."""
    groups: Array = values.reshape(-1, size)
    groups = groups[np.isfinite(groups).all(axis=1)]
    if len(groups) < 8:
        raise VfifeError(
            f"only {len(groups)} groups of {size} members have values, and indices need eight; ask for more"
            " (count)"
        )
    if np.ptp(groups) == 0.0:
        raise VfifeError(
            f"the measure is {groups[0, 0]:g} in every member, so nothing in it hangs on any parameter; name"
            " another measure"
        )
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


DESIGNS = ("saltelli", "morris")


@dataclass(frozen=True)
class Sensitivity:
    """What a measure hangs on: an index or an effect for each parameter, and how many groups were left out
    for a member without it.
    """

    measure: str
    unit: str
    rows: Sequence[Index] | Sequence[Effect]
    left_out: int


def indices(study: Study | str | Path, measures: str | Sequence[str] = ()) -> list[Sensitivity]:
    """What each measure of a study hangs on, over all that is varied: Sobol' indices, or elementary effects
    of Morris; by SALib.

    >>> vfife.indices("runs/crank.study", "C.force.max")[0].rows  # doctest: +SKIP

    ``study``: what :func:`vfife.study` gave, or a study file, its members planned by ``method`` "saltelli" or
    "morris"; ``measures``: some of them, or all. Each has ``unit``, ``rows``, one for each parameter, and
    ``left_out``, the groups of the design with a member without a value.

    Of "saltelli" a row has, as shares of the variance V of the measure y (1), ``first`` = V(E(y | x)) / V,
    what the parameter x makes alone (Saltelli, Comput. Phys. Comm. 181, 2010), and ``total`` = E(V(y | all
    but x)) / V, with all that it acts together with (Jansen, Comput. Phys. Comm. 117, 1999), each with its
    ``_margin`` at 95 %. Of "morris" (Technometrics 33, 1991) a row has, in the unit of the measure, ``mean``
    μ, ``size`` μ* of the absolute values (Campolongo, 2007), ``size_margin`` and ``deviation`` σ of the
    effects y(x + Δ) - y(x), Δ being half of the parameter's range of quantiles.

    Raises VfifeError without SALib (extra ``sensitivity``), for a study that no design planned, with fewer
    than eight whole groups, for a measure that was not wanted or is the same in all members; RunFileError for
    what is no study file.
    """
    found = study if isinstance(study, Study) else Study.open(study)
    return sensitivities(found, [measures] if isinstance(measures, str) else measures)


def sensitivities(found: Study, measures: Sequence[str] = ()) -> list[Sensitivity]:
    """Sensitivities of some measures, or all. Raises VfifeError without SALib, and for a study that no design
    planned or that is not far enough.
    """
    method = found.asked["raw"].get("method", "grid")
    if method not in DESIGNS or any(one.gridded for one in found.parameters):
        raise VfifeError(
            f"{found.path or 'this study'}: indices need a design for them; give every parameter a range or a"
            ' distribution, no values, and method = "saltelli" for Sobol\' indices (count = 256 or more) or'
            ' "morris" for a first look (count = 20)'
        )
    plan = plan_of(found)
    count, seed = int(plan.asked.count or 0), plan.asked.seed
    rows = planned(plan.parameters, method, count, seed)
    at = {found.at(one): found.outcomes[one.number] for one in found.done}
    names, told = [one.name for one in plan.parameters], []
    for measure in measures or tuple(found.measures):
        found.values(measure)  # raises for what was not wanted
        values = np.array([value_of(at.get(row), measure) for row in rows])
        if method == "morris":
            effects, left_out = morris_effects(names, places(method, count, len(names), seed), values, seed)
            told.append(Sensitivity(measure, found.measures[measure], effects, left_out))
        else:
            indices, left_out = sobol_indices(names, values, seed)
            told.append(Sensitivity(measure, found.measures[measure], indices, left_out))
    return told


def planned(
    parameters: Sequence[Parameter], method: str, count: int, seed: int
) -> list[tuple[float | str, ...]]:
    """Values of the members of a design in its order, a member as often as it stands there."""
    drawn: Array = points([one.distribution for one in parameters], method, count, seed)
    return list(zip(*(fitting(one, drawn[:, k], Written()) for k, one in enumerate(parameters)), strict=True))


def value_of(outcome: object, measure: str) -> float:
    """A measure of a member; NaN where it has none or has not ended."""
    if not isinstance(outcome, dict) or outcome["status"] != Status.COMPLETE:
        return math.nan
    return float(outcome["measures"].get(measure, math.nan))
