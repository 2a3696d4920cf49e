"""What a sample of machines says of all that are made to these tolerances: quantiles of each measure, and the share that fails a limit."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import VfifeError
from ..results.studied import Study
from .designs import value_of
from .limits import Bound
from .more import base_of
from .planfile import Written, understood
from .points import planned
from .quantiles import CONFIDENCE, Estimate, quantile, share

SHARES = (0.01, 0.5, 0.95, 0.99)


@dataclass(frozen=True)
class Spread:
    """A measure of all machines: how many of the sample's ``machines`` have it (``count``), mean, standard deviation, quantiles by
    their shares, and of its limit (None without one) the share of the machines that fail it; a machine that failed as a whole is among them."""

    measure: str
    unit: str
    machines: int
    count: int
    mean: float
    deviation: float
    quantiles: Mapping[float, Estimate]
    bound: Bound | None
    failing: Estimate | None


def spreads(found: Study, bounds: Sequence[Bound] = (), shares: Sequence[float] = SHARES, confidence: float = CONFIDENCE) -> list[Spread]:
    """How each measure of a study spreads over its machines. Raises VfifeError where the members are no sample, or fewer than two have ended."""
    sampled(found)
    outcomes, wanted = machines(found)
    if len(outcomes) < 2:
        raise VfifeError(f"{found.path or 'this study'}: {len(outcomes)} of {wanted} machines have ended, and a spread needs two")
    limits = {one.measure: one for one in bounds}
    rows = []
    for measure, unit in found.measures.items():
        values = np.array([value_of(one, measure) for one in outcomes])
        kept, bound = values[np.isfinite(values)], limits.get(measure)
        failing = None if bound is None else share(sum(bound.excess(value) > 0.0 for value in values.tolist()), len(values), confidence)
        quantiles = {one: quantile(kept, one, confidence) for one in shares}
        mean = float(np.mean(kept)) if len(kept) else math.nan
        deviation = float(np.std(kept, ddof=1)) if len(kept) > 1 else math.nan
        rows.append(Spread(measure, unit, len(values), len(kept), mean, deviation, quantiles, bound, failing))
    return rows


def machines(found: Study) -> tuple[list[Mapping[str, Any]], int]:
    """What the machines of the sample came to that have ended, each as often as it was drawn, and how many were drawn.

    The file may have others: points one by one, members of a search, samples of former tolerances. They are no draws.
    """
    plan, _ = understood(copy.deepcopy(found.asked["raw"]), str(found.path), base=base_of(found))
    rows = planned(plan, Written()) or []
    at = {found.at(one): found.outcomes[one.number] for one in found.done}
    return [at[row] for row in rows if row in at], len(rows)


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
