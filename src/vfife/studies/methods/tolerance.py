"""What a sample of machines says of all that are made to these tolerances: quantiles of each measure, and the
share that fails a limit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ModelError, VfifeError
from ...results.studied import Study
from ...store.member_errors import MemberError
from ..engine.run_missing import plan_of
from ..engine.study_file import Written, planned
from ..spec.limits import CONFIDENCE, Bound, Estimate, mean, quantile, read_bounds, share, widened
from .sensitivity_indices import value_of

SHARES = (0.01, 0.5, 0.95, 0.99)


@dataclass(frozen=True)
class Spread:
    """A measure of all machines: how many of the sample's ``machines`` have it (``count``), mean, standard
    deviation, quantiles by their shares, and of its limit (None without one) the share of the machines that
    fail it; a machine that failed as a whole is among them.

    ``average`` is the mean with its limits. ``numerical`` is the numerical error of a member, which all
    limits hold; None where it is not estimated: then they are those of sampling alone.
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
    numerical: MemberError | None


def tolerance(
    study: Study | str | Path,
    limit: Mapping[str, Any] | None = None,
    *,
    quantiles: Sequence[float] = SHARES,
    confidence: float = CONFIDENCE,
) -> list[Spread]:
    """What the machines of a study say of all that are made to its fits and tolerances: a spread for each
    measure, in SI units.

    >>> vfife.tolerance("runs/crank.study", {"C.force.max": "2 kN"})[0].failing  # doctest: +SKIP

    ``study``: what :func:`vfife.study` gave, or a study file; its members have to be drawn (``method``
    "random", "latin" or "sobol"). ``limit``: by measure the most that is allowed, a number in SI units or a
    text with a unit, or a mapping of ``low`` and ``high``; unless given, the table ``limit`` of the study.
    ``quantiles``: shares between 0 and 1; ``confidence``: that of all limits, between 0 and 1.

    A spread has ``mean`` = Σ x / n and ``deviation`` = √(Σ (x - mean)² / (n - 1)) of the ``count`` machines
    that have the measure, its ``quantiles`` by share, and ``failing``, the share p = k / n of the
    ``machines`` beyond the limit, one without the measure among them. Each estimate has ``value``, ``low``
    and ``high``: of a quantile these are values of the sample of such ranks that the binomial number of draws
    below it leaves α/2 on each side (David, Nagaraja: Order Statistics, 7.1), of a share those of Wilson
    (1927), of the mean (``average``) those of the central limit theorem; infinite where the sample is too
    small. Where the numerical error of members is estimated (``numerical``), limits hold it, too: those of a
    quantile are wider by :meth:`~vfife.store.member_errors.MemberError.at_quantile`, those of the mean by the
    root mean square of the error, and a machine within that of its limit counts as sound in ``low`` and as
    failing in ``high``.

    Raises VfifeError where members were chosen and not drawn or fewer than two have ended, ModelError for a
    limit that cannot be read, ValueError for a share or a confidence that is none, RunFileError for what is
    no study file.
    """
    for name, one in (*(("quantiles", one) for one in quantiles), ("confidence", confidence)):
        if not 0.0 < one < 1.0:
            raise ValueError(f"{name} = {one:g}: it is not between 0 and 1; write 99 % as 0.99")
    found = study if isinstance(study, Study) else Study.open(study)
    return spreads(found, bounds_of(found, limit), tuple(quantiles), confidence)


def bounds_of(found: Study, limit: Mapping[str, Any] | None = None) -> tuple[Bound, ...]:
    """Limits as given, or else those of the study. Raises ModelError."""
    by = Written()
    bounds = read_bounds(dict(limit) if limit else found.asked["raw"].get("limit", {}), found.measures, by)
    if by.faults:
        raise ModelError(by.faults, str(found.path or "this study"))
    return bounds


def spreads(
    found: Study,
    bounds: Sequence[Bound] = (),
    shares: Sequence[float] = SHARES,
    confidence: float = CONFIDENCE,
) -> list[Spread]:
    """How each measure of a study spreads over its machines. Raises VfifeError where the members are no
    sample, or fewer than two have ended.
    """
    sampled(found)
    outcomes, wanted = machines(found)
    if len(outcomes) < 2:
        raise VfifeError(
            f"{found.path or 'this study'}: {len(outcomes)} of {wanted} machines have ended, and a spread"
            " needs two"
        )
    limits = {one.measure: one for one in bounds}
    rows = []
    for measure, unit in found.measures.items():
        values = np.array([value_of(one, measure) for one in outcomes])
        kept, bound = values[np.isfinite(values)], limits.get(measure)
        error = found.errors.get(measure)
        failing = None if bound is None else share_that_fails(values.tolist(), bound, error, confidence)
        quantiles = {
            one: widened(quantile(kept, one, confidence), error.at_quantile(one) if error else 0.0)
            for one in shares
        }
        average = widened(mean(kept, confidence), error.rms if error else 0.0)
        deviation = float(np.std(kept, ddof=1)) if len(kept) > 1 else math.nan
        rows.append(
            Spread(
                measure,
                unit,
                len(values),
                len(kept),
                average.value,
                deviation,
                quantiles,
                bound,
                failing,
                average,
                error,
            )
        )
    return rows


def share_that_fails(
    values: Sequence[float], bound: Bound, error: MemberError | None, confidence: float
) -> Estimate:
    """The share of all machines that fails a limit; machines nearer to it than their numerical error count to
    both sides.
    """
    near, count = error.rms if error else 0.0, len(values)
    found = [share(sum(fails), count, confidence) for fails in (
        (bound.surely_fails(value, near) for value in values), (bound.excess(value) > 0.0 for value in values),
        (bound.may_fail(value, near) for value in values),
    )]  # fmt: skip
    return Estimate(found[1].value, found[0].low, found[2].high)


def machines(found: Study) -> tuple[list[Mapping[str, Any]], int]:
    """What the machines of the sample came to that have ended, each as often as it was drawn, and how many
    were drawn.

    The file may have others: points one by one, members of a search, samples of former tolerances. They are
    no draws.
    """
    rows = planned(plan_of(found), Written()) or []
    at = {found.at(one): found.outcomes[one.number] for one in found.done}
    return [at[row] for row in rows if row in at], len(rows)


def sampled(found: Study) -> None:
    """Raises VfifeError where members of a study are chosen, not drawn: then they say nothing of how often a
    value comes.
    """
    method = found.asked["raw"].get("method", "grid")
    chosen = [one.name for one in found.parameters if one.gridded]
    if method not in ("random", "latin", "sobol") or chosen:
        what = f"{', '.join(chosen)} has values" if chosen else f'method = "{method}"'
        raise VfifeError(
            f"{found.path or 'this study'}: its members are chosen, not drawn ({what}), so no share of"
            " machines follows; give every parameter a fit, a tolerance or a distribution, and method ="
            ' "random" with a count'
        )
