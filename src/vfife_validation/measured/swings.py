"""Swings of the measured pendulums: fits of records, their starts from a first piece, and what follows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import Mechanism
from vfife.identification.fit_task import plan_fit
from vfife.identification.measurements import Measured
from vfife.identification.residuals import interpolated
from vfife.modelfile.parameter import with_values
from vfife.results.fit import Fit

Array = NDArray[np.float64]
Starts = Sequence[Mapping[str, float]]
STEP = 1e-3  # s: half of it moves no angle by more than a tenth of what is left
SEARCH: dict[str, Any] = {
    "start": "data", "step": STEP, "screened": 1, "starts": 1, "restarts": 0, "derivatives": "differences",
    "confirm": True,
}  # fmt: skip


def fitted(
    mechanism: Mechanism, records: Sequence[Measured], parameters: Mapping[str, Any], **options: Any
) -> Fit:
    """One parameter set for records, each from its own start."""
    return vfife.fit(mechanism, list(records), parameters, **{**SEARCH, **options})


def with_numbers(mechanism: Mechanism, fit: Fit) -> Mechanism:
    """Return the mechanism with the parameters that a fit identified for all records."""
    return with_values(mechanism, dict(fit.set))


def starts(mechanism: Mechanism, pieces: Sequence[Measured]) -> list[dict[str, float]]:
    """Angles (rad) and speeds (rad/s) at the first samples, from the first piece of each record alone."""
    return [dict(record.set) for record in fitted(mechanism, pieces, {}, every=5).records]


def swings(mechanism: Mechanism, records: Sequence[Measured], begins: Starts) -> list[Array]:
    """Angles (rad) of the model at the samples of each record, shape (samples, bodies), from known starts."""
    task = plan_fit(mechanism, list(records), {}, **{k: v for k, v in SEARCH.items() if k != "confirm"})
    cases = [(case.curves, dict(start)) for case, start in zip(task.evaluated, begins, strict=True)]
    traces = cases[0][0].case_traces(cases)
    faults = [trace for trace in traces if isinstance(trace, str)]
    if faults:
        raise ValueError(f"a swing cannot be run: {faults[0]}")
    return [
        interpolated(data.places, trace)  # type: ignore[arg-type]
        for data, trace in zip(records, traces, strict=True)
    ]


def angles_of(data: Measured) -> Array:
    """Measured angles (rad), shape (samples, bodies)."""
    return np.stack([curve.values for curve in data.curves], axis=1)


def misses(model: Array, measured: Array, part: slice = slice(None)) -> float:
    """Root mean square of what a model misses, each angle over its standard deviation in the whole record."""
    left = (model - measured)[part] / measured.std(axis=0)
    return math.sqrt(float((left * left).mean()))
