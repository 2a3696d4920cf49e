"""Parameters that a fit looks for: numbers of a model, tied together where they are one, between two bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, shown, suggestion
from ..model.mechanism import Mechanism
from ..modelfile.parameter import NO_NUMBER, Parameter, numbers
from ..schema import Measure
from ..studies.methods.optimise import Between
from ..units import ends_of

Array = NDArray[np.float64]
Numbers = dict[str, float]
WIDE = 10.0  # ratio of the bounds from which a parameter is looked for by its logarithm


@dataclass(frozen=True)
class Sought(Between):
    """A parameter: its name, the paths of all numbers that it is, unit and bounds (SI), and the value that
    the model has, if they agree on one.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    low: float
    high: float
    here: float | None = None

    @property
    def logarithmic(self) -> bool:
        """Whether it is looked for by its logarithm; what has no unit is not."""
        return self.unit != "1" and self.low > 0.0 and self.high / self.low >= WIDE


def numbers_at(sought: Sequence[Sought], shares: Array) -> Numbers:
    """What each path is set to, at shares of the ways between the bounds."""
    return {
        path: one.value(float(share)) for one, share in zip(sought, shares, strict=True) for path in one.paths
    }


def parameters(given: Mapping[Any, Any] | Sequence[str], mechanism: Mechanism) -> list[Sought]:
    """Parameters from texts as ``"joint.C.clearance=0.1..1 mm"``, several paths with commas between and ``*``
    for any signs, or from a mapping of paths to two bounds. Raises ModelError with all that is wrong.
    """
    faults: list[Fault] = []
    known, found, owners = numbers(mechanism), list[Sought](), dict[str, str]()
    for told, bounds in pairs(given, faults):
        one = parameter(told, bounds, mechanism, known, faults)
        if one is None:
            continue
        for path in one.paths:
            if path in owners:
                faults.append(
                    Fault(
                        told, f"{path} is looked for by {owners[path]} already", remedy="remove one of them"
                    )
                )
            owners[path] = one.name
        found.append(one)
    if not faults and not found:
        faults.append(
            Fault(
                "parameters",
                "nothing is looked for",
                remedy='say what, as in -p "joint.C.clearance=0.1..1 mm"',
            )
        )
    if faults:
        raise ModelError(faults, "fit")
    return found


def pairs(given: Mapping[Any, Any] | Sequence[str], faults: list[Fault]) -> list[tuple[str, tuple[Any, Any]]]:
    """What is looked for with its bounds, as they are told."""
    found: list[tuple[str, tuple[Any, Any]]] = []
    items = given.items() if isinstance(given, Mapping) else [text.partition("=")[::2] for text in given]
    for told, bounds in items:
        name = ",".join(told) if isinstance(told, tuple | list) else str(told).strip()
        if isinstance(bounds, str):
            bounds = ends_of(bounds) or bounds
        if isinstance(bounds, tuple | list) and len(bounds) == 2:
            found.append((name, (bounds[0], bounds[1])))
        else:
            remedy = 'write PATH=LEAST..MOST, as in "joint.C.clearance=0.1..1 mm"'
            faults.append(Fault(name or "parameters", "two bounds are needed", shown(bounds), "", remedy))
    return found


def parameter(
    told: str, bounds: tuple[Any, Any], mechanism: Mechanism, known: Mapping[str, float], faults: list[Fault]
) -> Sought | None:
    """One parameter; None where something is wrong, which is told."""
    before, paths, held = len(faults), list[str](), list[Measure]()
    for text in (part.strip() for part in told.split(",")):
        several = (
            [path for path in known if fnmatchcase(path, text)] if "*" in text or "?" in text else [text]
        )
        if not several:
            faults.append(
                Fault(
                    told,
                    "fits no number of this model",
                    remedy=suggestion(text, known, "* stands for any characters"),
                )
            )
        for one in several:
            try:
                number = Parameter(mechanism, one)
            except Fault as fault:
                faults.append(fault.at(told, value=shown(one)))
                continue
            if number.quantity is None:
                faults.append(
                    Fault(
                        told,
                        "no number is there that can be looked for",
                        shown(one),
                        "",
                        suggestion(one, known, NO_NUMBER),
                    )
                )
                continue
            paths.append(number.path)
            held.append(number.quantity)
    if len({one.unit for one in held}) > 1:
        units = ", ".join(f"{path} in {one.unit}" for path, one in zip(paths, held, strict=True))
        faults.append(
            Fault(told, "numbers of different units cannot be one", units, remedy="look for each by itself")
        )
    if len(faults) > before:
        return None
    ends = [end(told, value, held[0], faults) for value in bounds]
    if None in ends:
        return None
    low, high = (float(value) for value in ends if value is not None)
    if not low < high:
        faults.append(
            Fault(
                told,
                "the bounds do not ascend",
                f"{shown(bounds[0])} .. {shown(bounds[1])}",
                "",
                "exchange or correct them",
            )
        )
        return None
    here = {known[path] for path in paths if path in known}
    own = here.pop() if len(here) == 1 else None
    return Sought(
        told, tuple(paths), held[0].unit, low, high, own if own is not None and low <= own <= high else None
    )


def end(told: str, value: Any, held: Measure, faults: list[Fault]) -> float | None:
    """A bound in SI units, within the limits of its number."""
    try:
        found: float = held.take(float(value) if isinstance(value, str) and bare(value) else value, True)
        return found
    except Fault as fault:
        faults.append(Fault(told, f"its bound: {fault.what}", fault.value, fault.limit, fault.remedy))
        return None


def bare(text: str) -> bool:
    """Whether a text is a number alone."""
    try:
        float(text)
    except ValueError:
        return False
    return True
