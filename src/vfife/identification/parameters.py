"""Parameters that a fit identifies: numbers of a model between two bounds, several numbers perhaps with one
value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, shown, suggestion
from ..model.mechanism import Mechanism
from ..modelfile.parameter import NO_NUMBER, Parameter, numbers
from ..studies.methods.optimise import Interval
from ..units import ends_of

Array = NDArray[np.float64]
Numbers = dict[str, float]
LOGARITHMIC_RATIO = 10.0  # of the bounds, from which the logarithm of a parameter is identified


@dataclass(frozen=True)
class FitParameter(Interval):
    """A parameter: its name, the paths of all numbers that have its value, unit and bounds (SI), and the
    value in the model, if there is one.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    low: float
    high: float
    initial: float | None = None

    @property
    def logarithmic(self) -> bool:
        """Whether its logarithm is identified: bounds a factor of ten apart, of what has a unit."""
        return self.unit != "1" and self.low > 0.0 and self.high / self.low >= LOGARITHMIC_RATIO


def numbers_at(parameters: Sequence[FitParameter], shares: Array) -> Numbers:
    """Values by path at ``shares`` of the ways between the bounds, shape (parameters,)."""
    return {
        path: one.value(float(share))
        for one, share in zip(parameters, shares, strict=True)
        for path in one.paths
    }


def parameters_of(texts: Mapping[Any, Any] | Sequence[str], mechanism: Mechanism) -> list[FitParameter]:
    """Parameters from texts or from a mapping of paths to two bounds.

    Texts are as ``"joint.C.clearance=0.1..1 mm"``, with commas between several paths and ``*`` for any
    characters. Raises ModelError with all faults.
    """
    faults: list[Fault] = []
    values, parameters, owners = numbers(mechanism), list[FitParameter](), dict[str, str]()
    items = texts.items() if isinstance(texts, Mapping) else [text.partition("=")[::2] for text in texts]
    for key, value in items:
        name = ",".join(key) if isinstance(key, tuple | list) else str(key).strip()
        bounds = ends_of(value) or value if isinstance(value, str) else value
        if not (isinstance(bounds, tuple | list) and len(bounds) == 2):
            remedy = 'write PATH=LEAST..MOST, as in "joint.C.clearance=0.1..1 mm"'
            faults.append(Fault(name or "parameters", "two bounds are needed", shown(bounds), "", remedy))
            continue
        one = parameter_of(name, (bounds[0], bounds[1]), mechanism, values, faults)
        for path in one.paths if one is not None else ():
            if path in owners:
                faults.append(
                    Fault(
                        name, f"{path} is looked for by {owners[path]} already", remedy="remove one of them"
                    )
                )
            owners[path] = name
        parameters += [one] if one is not None else []
    if not faults and not parameters:
        remedy = 'say what, as in -p "joint.C.clearance=0.1..1 mm"'
        faults.append(Fault("parameters", "nothing is looked for", remedy=remedy))
    if faults:
        raise ModelError(faults, "fit")
    return parameters


def parameter_of(
    name: str,
    bounds: tuple[Any, Any],
    mechanism: Mechanism,
    model_values: Mapping[str, float],
    faults: list[Fault],
) -> FitParameter | None:
    """One parameter; None if there is a fault, which is added to ``faults``."""
    before, matches = len(faults), list[Parameter]()
    for text in (part.strip() for part in name.split(",")):
        paths = (
            [path for path in model_values if fnmatchcase(path, text)]
            if "*" in text or "?" in text
            else [text]
        )
        if not paths:
            remedy = suggestion(text, model_values, "* stands for any characters")
            faults.append(Fault(name, "fits no number of this model", remedy=remedy))
        for path in paths:
            try:
                number = Parameter(mechanism, path)
            except Fault as fault:
                faults.append(fault.at(name, value=shown(path)))
                continue
            if number.quantity is None:
                remedy = suggestion(path, model_values, NO_NUMBER)
                faults.append(
                    Fault(name, "no number is there that can be looked for", shown(path), "", remedy)
                )
                continue
            matches.append(number)
    if len({one.unit for one in matches}) > 1:
        units = ", ".join(f"{one.path} in {one.unit}" for one in matches)
        faults.append(
            Fault(name, "numbers of different units cannot be one", units, remedy="look for each by itself")
        )
    ends = [bound_of(name, value, matches[0], faults) for value in bounds] if len(faults) == before else []
    if not ends or None in ends:
        return None
    low, high = (float(value) for value in ends if value is not None)
    if not low < high:
        text = f"{shown(bounds[0])} .. {shown(bounds[1])}"
        faults.append(Fault(name, "the bounds do not ascend", text, "", "exchange or correct them"))
        return None
    values = {model_values[one.path] for one in matches if one.path in model_values}
    initial = values.pop() if len(values) == 1 else None
    inside = initial is not None and low <= initial <= high
    return FitParameter(
        name, tuple(one.path for one in matches), matches[0].unit, low, high, initial if inside else None
    )


def bound_of(name: str, value: Any, number: Parameter, faults: list[Fault]) -> float | None:
    """A bound in SI units, within the limits of its number."""
    with suppress(ValueError):
        value = float(value) if isinstance(value, str) else value
    try:
        bound: float = number.quantity.take(value, True)  # type: ignore[union-attr]
        return bound
    except Fault as fault:
        faults.append(Fault(name, f"its bound: {fault.what}", fault.value, fault.limit, fault.remedy))
        return None
