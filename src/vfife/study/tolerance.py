"""What a sample of machines says of all that are made to these tolerances: quantiles of each measure, and the share that fails a limit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import VfifeError
from ..results.studied import Study
from .limits import Bound
from .quantiles import CONFIDENCE, Estimate, quantile, share

SHARES = (0.01, 0.5, 0.95, 0.99)


@dataclass(frozen=True)
class Spread:
    """A measure of all machines: how many of the sample have it, mean, standard deviation, quantiles by their shares, and of its limit (None
    without one) the share of the machines that fail it; a machine that failed as a whole is among them."""

    measure: str
    unit: str
    count: int
    mean: float
    deviation: float
    quantiles: Mapping[float, Estimate]
    bound: Bound | None
    failing: Estimate | None


def spreads(found: Study, bounds: Sequence[Bound] = (), shares: Sequence[float] = SHARES, confidence: float = CONFIDENCE) -> list[Spread]:
    """How each measure of a study spreads over its machines. Raises VfifeError where the members are no sample, or fewer than two have ended."""
    sampled(found)
    if len(found.done) < 2:
        raise VfifeError(f"{found.path or 'this study'}: {len(found.done)} of {len(found.members)} members have ended, and a spread needs two")
    limits = {one.measure: one for one in bounds}
    rows = []
    for measure, unit in found.measures.items():
        values = found.values(measure)
        kept, bound = values[np.isfinite(values)], limits.get(measure)
        failing = None if bound is None else share(sum(bound.excess(value) > 0.0 for value in values.tolist()), len(values), confidence)
        quantiles = {one: quantile(kept, one, confidence) for one in shares}
        mean = float(np.mean(kept)) if len(kept) else math.nan
        deviation = float(np.std(kept, ddof=1)) if len(kept) > 1 else math.nan
        rows.append(Spread(measure, unit, len(kept), mean, deviation, quantiles, bound, failing))
    return rows


def sampled(found: Study) -> None:
    """Raises VfifeError where members of a study are chosen, not drawn: then they say nothing of how often a value comes."""
    method = found.asked["raw"].get("method", "grid")
    chosen = [one.name for one in found.parameters if one.gridded]
    if method not in ("random", "latin", "sobol") or chosen:
        what = f"{', '.join(chosen)} has values" if chosen else f'method = "{method}"'
        raise VfifeError(
            f"{found.path or 'this study'}: its members are chosen, not drawn ({what}), so no share of machines follows; "
            'give every parameter a fit, a tolerance or a distribution, and method = "random" with a count'
        )
