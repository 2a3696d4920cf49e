"""Sensitivities of the measures of a study that was planned by a design: which of its members stand where in it, and what follows."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import VfifeError
from ..results.studied import Study
from ..solvers.status import Status
from .distributions import Array
from .indices import Effect, Index, morris_effects, sobol_indices
from .more import base_of
from .plan import Parameter
from .planfile import Written, understood
from .points import fitting
from .sampling import places, points

DESIGNS = ("saltelli", "morris")


@dataclass(frozen=True)
class Sensitivity:
    """What a measure hangs on: an index or an effect for each parameter, and how many groups were left out for a member without it."""

    measure: str
    unit: str
    rows: Sequence[Index] | Sequence[Effect]
    left_out: int


def indices(study: Study | str | Path, measures: str | Sequence[str] = ()) -> list[Sensitivity]:
    """What each measure of a study hangs on, over all that is varied: Sobol' indices, or elementary effects of Morris; by SALib.

    >>> vfife.indices("runs/crank.study", "C.force.max")[0].rows  # doctest: +SKIP

    ``study``: what :func:`vfife.study` gave, or a study file, its members planned by ``method`` "saltelli" or "morris"; ``measures``: some of
    them, or all. Each has ``unit``, ``rows``, one for each parameter, and ``left_out``, the groups of the design with a member without a value.

    Of "saltelli" a row has, as shares of the variance V of the measure y (1), ``first`` = V(E(y | x)) / V, what the parameter x makes alone
    (Saltelli, Comput. Phys. Comm. 181, 2010), and ``total`` = E(V(y | all but x)) / V, with all that it acts together with (Jansen, Comput. Phys.
    Comm. 117, 1999), each with its ``_margin`` at 95 %. Of "morris" (Technometrics 33, 1991) a row has, in the unit of the measure, ``mean`` μ,
    ``size`` μ* of the absolute values (Campolongo, 2007), ``size_margin`` and ``deviation`` σ of the effects y(x + Δ) - y(x), Δ being half of the
    parameter's range of quantiles.

    Raises VfifeError without SALib (extra ``sensitivity``), for a study that no design planned, with fewer than eight whole groups, for a measure
    that was not wanted or is the same in all members; RunFileError for what is no study file.
    """
    found = study if isinstance(study, Study) else Study.open(study)
    return sensitivities(found, [measures] if isinstance(measures, str) else measures)


def sensitivities(found: Study, measures: Sequence[str] = ()) -> list[Sensitivity]:
    """Sensitivities of some measures, or all. Raises VfifeError without SALib, and for a study that no design planned or that is not far enough."""
    raw = copy.deepcopy(found.asked["raw"])
    method = raw.get("method", "grid")
    if method not in DESIGNS or any(one.gridded for one in found.parameters):
        raise VfifeError(
            f"{found.path or 'this study'}: indices need a design for them; give every parameter a range or a distribution, no values, and "
            'method = "saltelli" for Sobol\' indices (count = 256 or more) or "morris" for a first look (count = 20)'
        )
    plan, _ = understood(raw, str(found.path), base=base_of(found))
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


def planned(parameters: Sequence[Parameter], method: str, count: int, seed: int) -> list[tuple[float | str, ...]]:
    """Values of the members of a design in its order, a member as often as it stands there."""
    drawn: Array = points([one.distribution for one in parameters], method, count, seed)
    return list(zip(*(fitting(one, drawn[:, k], Written()) for k, one in enumerate(parameters)), strict=True))


def value_of(outcome: object, measure: str) -> float:
    """A measure of a member; NaN where it has none or has not ended."""
    if not isinstance(outcome, dict) or outcome["status"] != Status.COMPLETE:
        return math.nan
    return float(outcome["measures"].get(measure, math.nan))
