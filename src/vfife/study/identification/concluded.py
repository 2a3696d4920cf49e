"""What a fit has found: the best point with its confidence, what casts doubt on it, and its curves."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...errors import VfifeError
from ...results.fitted import Fit, Laid, Value
from .confidence import confident, offset_error
from .doubt import Doubt, doubt, widened
from .evaluations import Evaluations
from .jacobians import Slopes
from .measurements import Measured
from .misfit import Fitted

Array = NDArray[np.float64]
UNSETTLED = 0.25  # of what is left, from which on turns that differ are told
WIDER = 1.1  # times the squares of the best point with other steps, from which on that is told
MISSED = 0.25  # of the data's deviation, from which on what is left is told: ± knows of noise alone


@dataclass
class Ended:
    """How searches ended: cost and values of each, whether derivatives were carried along, and notes."""

    searches: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    tangents: bool = False
    notes: list[str] = field(default_factory=list)


def concluded(
    name: str, seen: Measured, units: Mapping[str, str], looked: Evaluations, ended: Ended, slopes: Slopes | None, confidence: float
) -> Fit:
    """The fit at the best point; without ``slopes`` it was broken off, and nothing is known of its errors."""
    if looked.best is None:  # told before
        raise VfifeError("no member has a motion")
    _, shares, best = looked.best
    one, misfit, sought = best.fitted, looked.misfit, looked.sought
    if one is None:
        raise VfifeError("no member has a motion")
    found = None if slopes is None else doubt(looked.curves, sought, misfit, shares, one, slopes.jacobian)
    nuisance = 2 * int(misfit.proportional.sum()) + (0 if misfit.offset.fixed else 1)
    parts, jacobian = list(misfit.columns(one.residuals).T), None if slopes is None else slopes.jacobian
    told = confident(parts, sought, shares, jacobian, len(sought) + nuisance, confidence, 1.0 if found is None else found.inflation)
    errors, limits = (told.errors, told.limits) if found is None else widened(told, found, sought, shares, looked.points)
    values = [
        Value(
            s.name, s.paths, s.unit, s.value(float(x)), float(e), float(low), float(high), (s.low, s.high), s.here, s.logarithmic,
            found is None or found.known,
        )
        for s, x, e, (low, high) in zip(sought, shares, errors, limits, strict=True)
    ]  # fmt: skip
    notes = [*ended.notes, *warnings(looked, best.unsettled, found)]
    by = "derivatives of the steps" if ended.tangents else "differences of runs"
    return Fit(
        name, seen.name, "interrupted" if slopes is None else "complete", values, told.correlation, told.directions, where(looked, one),
        offset_error(slopes, told, misfit, one.along), seen.over, curves_of(looked, one, units), sorted(ended.searches), looked.runs,
        len(looked.reasons), by, told.autocorrelation, confidence, time.monotonic() - looked.began, misfit.how, [*notes, *looked.reasons[:3]],
    )  # fmt: skip


def warnings(looked: Evaluations, unsettled: float, found: Doubt | None) -> Iterator[str]:
    """What the errors do not know, or had to be widened for."""
    if unsettled > UNSETTLED * max(looked.share, 1e-3):
        said = f"the model's turns do not repeat after those that are skipped (they differ by {100.0 * unsettled:.2g} % of the curves' deviations)"
        remedy = "skip more, measure a motion that repeats, or give the offset from the start"
        yield f"{said}: numbers that rule how it settles may be wrong; {remedy}"
    if looked.share > MISSED:
        causes = "much noise, another minimum, a motion that does not repeat, or a model that is wrong"
        yield f"the model misses the data by {100.0 * looked.share:.3g} % of their deviation, by {causes}: of these the errors know only noise"
    if found is None or found.inflation < WIDER:
        return
    ways = [(found.by_steps, "with other steps"), (found.by_turns, "from the next turn on")]
    size, way = max(ways)
    alike = sum(cost <= found.cost for cost, _ in looked.points)
    what = f"at these numbers the model's own curves differ by {100.0 * size:.2g} % of the data's deviations {way}"
    if found.known:
        yield f"{what}: errors and limits are widened by it, {alike} of {len(looked.points)} points fit as well"
    else:
        remedy = "compare envelopes or spectra, measure fewer turns from a known start, or a motion that repeats"
        yield f"{what}, so no confidence is known: {alike} of {len(looked.points)} points fit as well as they; {remedy}"


def where(looked: Evaluations, one: Fitted) -> float:
    """The offset; of a free one within a turn."""
    offset = looked.misfit.offset
    span = offset.high if looked.misfit.measured.over == "time" else 2.0 * math.pi
    return one.offset % span if offset.free else one.offset


def curves_of(looked: Evaluations, one: Fitted, units: Mapping[str, str]) -> list[Laid]:
    """Measured and model's curves."""
    misfit, found = looked.misfit, []
    over, places = misfit.places()
    for k, curve in enumerate(misfit.measured.curves):
        factor, level = (float(value) for value in one.gains[:, k])
        unit = units.get(curve.channel, "") if not curve.proportional else "1"
        found.append(Laid(curve.channel, curve.head, unit, over, places, misfit.wanted[:, k], one.values[:, k], factor, level))
    return found
