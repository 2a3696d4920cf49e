"""Global sensitivity over the ranges of all parameters: Sobol' indices from Saltelli's design, elementary
effects of Morris (SALib).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import VfifeError
from ...options import with_faults
from ...report.html import fragment
from ...report.study import indices as indices_document
from ...report.terminal import as_text
from ...results.study import Study
from ...solvers.status import Status
from ..engine.study_engine import plan_of
from ..spec.case_rows import sample_rows
from ..spec.distributions import JUMP, LEVELS, Array, places
from ..spec.limits import CONFIDENCE
from ..spec.study_file import StudyReader

if TYPE_CHECKING:
    import pandas

    from ...report.document import Document

EXTRA = 'indices are computed by SALib, which is not installed here: pip install "vfife[sensitivity]"'
RESAMPLING: dict[str, Any] = {"num_resamples": 200, "conf_level": CONFIDENCE}  # for the margins


@dataclass(frozen=True)
class Index:
    """Share of a measure's variance that is due to a parameter alone (``first``), and including its
    interactions (``total``), each with its ``_margin`` at 95 %.
    """

    parameter: str
    first: float
    first_margin: float
    total: float
    total_margin: float


@dataclass(frozen=True)
class ElementaryEffect:
    """Effect of a parameter on a measure between its 12.5 % and 62.5 %, or 37.5 % and 87.5 % quantiles: mean,
    mean absolute value with its margin at 95 %, and standard deviation, which shows curvature and
    interaction.
    """

    parameter: str
    mean: float
    size: float
    size_margin: float
    deviation: float


def sobol_indices(parameters: Sequence[str], values: Array, seed: int = 0) -> tuple[list[Index], int]:
    """Return the Sobol' indices of a measure from its values at Saltelli's design, and the number of groups
    left out, as one of their cases has no value.

    First order by Saltelli (2010), total by Jansen (1999), margins by resampling. Raises VfifeError without
    SALib, where fewer than eight groups are left, and for a measure that is the same in all of them.
    """
    analyze, count = salib().sobol, len(parameters)
    groups, options = (
        complete_groups(values, count + 2),
        {"calc_second_order": False, **RESAMPLING, "seed": seed},
    )
    result = analyze.analyze(problem(parameters), groups.ravel(), **options)
    rows = zip(parameters, *(result[name] for name in ("S1", "S1_conf", "ST", "ST_conf")), strict=True)
    return [Index(name, *map(float, row)) for name, *row in rows], len(values) // (count + 2) - len(groups)


def morris_effects(
    parameters: Sequence[str], places: Array, values: Array, seed: int = 0
) -> tuple[list[ElementaryEffect], int]:
    """Return the elementary effects of a measure from its values along trajectories, whose ``places`` are in
    the unit cube, and the number of trajectories left out. Raises VfifeError as :func:`sobol_indices` does.
    """
    analyze, count = salib().morris, len(parameters)
    groups, options = complete_groups(values, count + 1), {"num_levels": LEVELS, **RESAMPLING, "seed": seed}
    complete = np.isfinite(values.reshape(-1, count + 1)).all(axis=1)
    levels = (places.reshape(-1, count + 1, count)[complete] * LEVELS - 0.5) / (LEVELS - 1)
    result = analyze.analyze(problem(parameters), levels.reshape(-1, count), groups.ravel(), **options)
    # SALib's effects are over the whole grid, three of its steps; ours are over the jump of two.
    scale = JUMP / (LEVELS - 1)
    rows = zip(
        parameters, *(result[name] for name in ("mu", "mu_star", "mu_star_conf", "sigma")), strict=True
    )
    effects = [ElementaryEffect(name, *(scale * float(value) for value in row)) for name, *row in rows]
    return effects, len(values) // (count + 1) - len(groups)


def complete_groups(values: Array, size: int) -> Array:
    """Return the groups of the design whose cases all have a value. Raises VfifeError."""
    groups: Array = values.reshape(-1, size)
    groups = groups[np.isfinite(groups).all(axis=1)]
    if len(groups) < 8:
        message = f"only {len(groups)} groups of {size} cases have values"
        raise VfifeError(f"{message}, and indices need eight; ask for more (count)")
    if np.ptp(groups) == 0.0:
        message = f"the measure is {groups[0, 0]:g} in every case"
        raise VfifeError(f"{message}, so it depends on no parameter; name another measure")
    return groups


def problem(parameters: Sequence[str]) -> dict[str, object]:
    """Return the problem as SALib takes it: parameters in the unit cube."""
    return {"num_vars": len(parameters), "names": list(parameters), "bounds": [[0.0, 1.0]] * len(parameters)}


def salib() -> ModuleType:
    """Return SALib. Raises VfifeError where it is not installed."""
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
class MeasureIndices:
    """An index or an effect of each parameter on a measure; ``left_out``: groups of the design with a case
    without the measure.
    """

    measure: str
    unit: str
    rows: Sequence[Index] | Sequence[ElementaryEffect]
    left_out: int


class StudyIndices(list[MeasureIndices]):
    """Indices or effects of each measure of a ``study``; print it for tables, the largest first."""

    def __init__(self, study: Study, answers: Iterable[MeasureIndices]) -> None:
        super().__init__(answers)
        self.study = study

    @property
    def document(self) -> Document:
        """The document that ``vfife study indices`` prints."""
        return indices_document(self.study, str(self.study.path or ""), self)

    def __str__(self) -> str:
        return as_text(self.document)

    def _repr_html_(self) -> str:
        return fragment(self.document)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each measure and parameter for pandas, by both names."""
        import pandas

        rows = [
            {"measure": result.measure, "unit": result.unit, **asdict(row)}
            for result in self
            for row in result.rows
        ]
        return pandas.DataFrame(rows).set_index(["measure", "parameter"])


@with_faults()
def indices(study: Study | str | Path, measures: str | Sequence[str] = ()) -> StudyIndices:
    """Return how each measure of a study depends on its parameters over their whole ranges: Sobol' indices,
    or elementary effects of Morris; by SALib.

    >>> vfife.studies.indices("runs/crank.study", "C.force.max")[0].rows  # doctest: +SKIP

    ``study``: what :func:`vfife.study` gave, or a study file, its cases planned by ``method`` "saltelli" or
    "morris"; ``measures``: some of them, or all. Each has ``unit``, ``rows``, one for each parameter, and
    ``left_out``, the groups of the design with a case without a value. The list prints as tables, and
    ``to_dataframe()`` gives it to pandas.

    Of "saltelli" a row has, as shares of the variance V of the measure y (1), ``first`` = V(E(y | x)) / V,
    what the parameter x makes alone (Saltelli, Comput. Phys. Comm. 181, 2010), and ``total`` = E(V(y | all
    but x)) / V, with all that it acts together with (Jansen, Comput. Phys. Comm. 117, 1999), each with its
    ``_margin`` at 95 %. Of "morris" (Technometrics 33, 1991) a row has, in the unit of the measure, ``mean``
    μ, ``size`` μ* of the absolute values (Campolongo, 2007), ``size_margin`` and ``deviation`` σ of the
    effects y(x + Δ) - y(x), Δ being half of the parameter's range of quantiles.

    Raises VfifeError without SALib (extra ``sensitivity``), for a study that no design planned, with fewer
    than eight whole groups, for a measure that was not wanted or is the same in all cases; RunFileError for
    what is no study file.
    """
    opened = study if isinstance(study, Study) else Study.open(study)
    return sensitivities(opened, [measures] if isinstance(measures, str) else measures)


def sensitivities(study: Study, measures: Sequence[str] = ()) -> StudyIndices:
    """Return the sensitivities of some measures, or all. Raises VfifeError as :func:`indices` does."""
    method = study.request["raw"].get("method", "grid")
    if method not in DESIGNS or any(parameter.gridded for parameter in study.parameters):
        raise VfifeError(
            f"{study.path or 'this study'}: indices need a design for them; give every parameter a range or a"
            ' distribution, no values, and method = "saltelli" for Sobol\' indices (count = 256 or more) or'
            ' "morris" for a first look (count = 20)'
        )
    plan = plan_of(study)
    count, seed = int(plan.spec.count or 0), plan.spec.seed
    rows = sample_rows(list(plan.parameters), method, count, seed, StudyReader())
    outcomes = {study.at(case): study.outcomes[case.number] for case in study.done}
    names, answers = [parameter.name for parameter in plan.parameters], []
    for measure in measures or tuple(study.measures):
        study.values(measure)  # raises for what was not wanted
        values = np.array([value_of(outcomes.get(row), measure) for row in rows])
        answer: tuple[Sequence[Index] | Sequence[ElementaryEffect], int]
        if method == "morris":
            answer = morris_effects(names, places(method, count, len(names), seed), values, seed)
        else:
            answer = sobol_indices(names, values, seed)
        answers.append(MeasureIndices(measure, study.measures[measure], *answer))
    return StudyIndices(study, answers)


def value_of(outcome: object, measure: str) -> float:
    """Return a measure of a case; NaN where it has none or has not ended."""
    if not isinstance(outcome, dict) or outcome["status"] != Status.COMPLETE:
        return math.nan
    return float(outcome["measures"].get(measure, math.nan))
