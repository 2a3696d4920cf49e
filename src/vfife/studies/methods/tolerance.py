"""Tolerance analysis: quantiles of each measure over all machines, and the share that fails a limit, from a
sample.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import VfifeError
from ...options import with_faults
from ...results.case_errors import ErrorEstimate
from ...results.study import Study
from ..engine.study_engine import plan_of
from ..spec.case_rows import case_rows
from ..spec.limits import CONFIDENCE, Bound, Estimate, mean, quantile, read_bounds, share, widened
from ..spec.study_file import StudyReader
from .sensitivity_indices import value_of

SHARES = (0.01, 0.5, 0.95, 0.99)


@dataclass(frozen=True)
class Spread:
    """The spread of a measure over all machines, estimated from a sample of ``machines``, a ``count`` of
    which have it.

    ``quantiles`` are by share; ``failing`` is the share that fails the limit ``bound`` (None without one), a
    machine without the measure among them; ``average`` is the mean with its limits. ``numerical`` is the
    numerical error of a case, which all limits include; None where it is not estimated.
    """

    measure: str
    unit: str
    machines: int
    count: int
    mean: float
    deviation: float
    quantiles: Mapping[float, Estimate]
    bound: Bound | None
    failing: Estimate | None
    average: Estimate
    numerical: ErrorEstimate | None


@with_faults()
def tolerance(
    study: Study | str | Path,
    limit: Mapping[str, Any] | None = None,
    *,
    quantiles: Sequence[float] = SHARES,
    confidence: float = CONFIDENCE,
) -> list[Spread]:
    """Estimate the spread of each measure of a study over all machines made to its fits and tolerances (SI
    units).

    >>> vfife.studies.tolerance("runs/crank.study", {"C.force.max": "2 kN"})[0].failing  # doctest: +SKIP

    ``study``: what :func:`vfife.study` gave, or a study file; its cases have to be drawn (``method``
    "random", "latin" or "sobol"). ``limit``: by measure the most that is allowed, a number in SI units or a
    text with a unit, or a mapping of ``low`` and ``high``; unless given, the table ``limit`` of the study.
    ``quantiles``: shares between 0 and 1; ``confidence``: that of all limits, between 0 and 1.

    Returns a spread for each measure. It has ``mean`` = Σ x / n and ``deviation`` = √(Σ (x - mean)² / (n -
    1)) of the ``count`` machines that have the measure, its ``quantiles`` by share, and ``failing``, the
    share p = k / n of the ``machines`` beyond the limit, one without the measure among them. Each estimate
    has ``value``, ``low`` and ``high``: of a quantile these are values of the sample of such ranks that the
    binomial number of draws below it leaves α/2 on each side (David, Nagaraja: Order Statistics, 7.1), of a
    share those of Clopper and Pearson (1934), of the mean (``average``) those of Student's t; infinite where
    the sample is too small. Where the numerical error of cases is estimated (``numerical``), limits hold it,
    too: those of a quantile are wider by :meth:`~vfife.results.case_errors.ErrorEstimate.at_quantile`, those
    of the mean by the root mean square of the error, and a machine within that of its limit counts as sound
    in ``low`` and as failing in ``high``.

    Raises VfifeError where cases were chosen and not drawn or fewer than two have ended, ModelError for a
    limit that cannot be read, ValueError for a share or a confidence that is none, RunFileError for what is
    no study file.
    """
    for name, probability in (
        *(("quantiles", probability) for probability in quantiles),
        ("confidence", confidence),
    ):
        if not 0.0 < probability < 1.0:
            raise ValueError(f"{name} = {probability:g}: it is not between 0 and 1; write 99 % as 0.99")
    opened = study if isinstance(study, Study) else Study.open(study)
    return spreads(opened, bounds_of(opened, limit), tuple(quantiles), confidence)


def bounds_of(study: Study, limit: Mapping[str, Any] | None = None) -> tuple[Bound, ...]:
    """Read limits, or those of the study where there are none. Raises ModelError."""
    reader = StudyReader()
    bounds = read_bounds(
        dict(limit) if limit else study.request["raw"].get("limit", {}), study.measures, reader
    )
    reader.check(str(study.path or "this study"))
    return bounds


def spreads(
    study: Study,
    bounds: Sequence[Bound] = (),
    shares: Sequence[float] = SHARES,
    confidence: float = CONFIDENCE,
) -> list[Spread]:
    """Estimate the spread of each measure. Raises VfifeError where the cases are no sample, or fewer than two
    have ended.
    """
    check_sample(study)
    outcomes, drawn = machines(study)
    if len(outcomes) < 2:
        name = study.path or "this study"
        raise VfifeError(f"{name}: {len(outcomes)} of {drawn} machines have ended, and a spread needs two")
    limits = {bound.measure: bound for bound in bounds}
    rows = []
    for measure, unit in study.measures.items():
        values = np.array([value_of(outcome, measure) for outcome in outcomes])
        finite, bound, error = values[np.isfinite(values)], limits.get(measure), study.errors.get(measure)
        failing = None if bound is None else failing_share(values.tolist(), bound, error, confidence)
        margins = {level: error.at_quantile(level) if error else 0.0 for level in shares}
        quantiles = {level: widened(quantile(finite, level, confidence), margins[level]) for level in shares}
        average = widened(mean(finite, confidence), error.rms if error else 0.0)
        deviation = float(np.std(finite, ddof=1)) if len(finite) > 1 else math.nan
        counts = len(values), len(finite), average.value, deviation
        rows.append(Spread(measure, unit, *counts, quantiles, bound, failing, average, error))
    return rows


def failing_share(
    values: Sequence[float], bound: Bound, error: ErrorEstimate | None, confidence: float
) -> Estimate:
    """Estimate the share of all machines that fails a limit.

    Machines nearer to it than their numerical error count as sound in the lower limit, as failing in the
    upper.
    """
    error_size, count = error.rms if error else 0.0, len(values)
    low, middle, high = (
        share(sum(bound.fails(value, margin) for value in values), count, confidence)
        for margin in (error_size, 0.0, -error_size)
    )
    return Estimate(middle.value, low.low, high.high)


def machines(study: Study) -> tuple[list[Mapping[str, Any]], int]:
    """Return the outcomes of the machines of the sample that have ended, each as often as it was drawn, and
    how many were drawn.

    Other cases in the file were not drawn: single points, cases of a search, samples of former tolerances.
    """
    rows = case_rows(plan_of(study), StudyReader()) or []
    outcomes = {study.at(case): study.outcomes[case.number] for case in study.done}
    return [outcomes[row] for row in rows if row in outcomes], len(rows)


def check_sample(study: Study) -> None:
    """Raise VfifeError where cases were chosen, not drawn: then they do not show how frequent a value is."""
    method = study.request["raw"].get("method", "grid")
    chosen = [parameter.name for parameter in study.parameters if parameter.gridded]
    if method not in ("random", "latin", "sobol") or chosen:
        message = f"{', '.join(chosen)} has values" if chosen else f'method = "{method}"'
        remedy = (
            'give every parameter a fit, a tolerance or a distribution, and method = "random" with a count'
        )
        name = study.path or "this study"
        raise VfifeError(
            f"{name}: its cases are chosen, not drawn ({message}), so no share of machines follows; {remedy}"
        )
