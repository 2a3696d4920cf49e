"""Parameters that a fit identifies: numbers of a model between two bounds, of which several may share one
value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, shown, suggestion
from ..model.mechanism import Mechanism
from ..modelfile.parameter import NO_NUMBER, Parameter, numbers
from ..schema import Measure
from ..studies.methods.optimise import Interval
from ..units import ends_of
from .starts import PREFIX, start_paths, unit_of_start

Array = NDArray[np.float64]
Numbers = dict[str, float]
# From this ratio of the bounds on, the logarithm of a parameter is identified: most points between 1e6 and
# 1e9 would otherwise lie above 1e8.
LOGARITHMIC_RATIO = 10.0


class Number(NamedTuple):
    """A number that can be identified: its path, its unit, and what reads and limits its values."""

    path: str
    unit: str
    quantity: Measure


@dataclass(frozen=True)
class FitParameter(Interval):
    """A parameter: its name, the paths of all numbers that have its value, unit and bounds (SI), and the
    value in the model, if there is one.

    ``signs``: -1 for a number that has the opposite value, 1 for the others; all 1 where it is empty.
    ``record``: the record whose own it is; empty where all records have it in common.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    low: float
    high: float
    initial: float | None = None
    signs: tuple[float, ...] = ()
    record: str = ""

    @property
    def logarithmic(self) -> bool:
        """Whether the logarithm is identified: the bounds differ by a factor of ten, and there is a unit."""
        return self.unit != "1" and self.low > 0.0 and self.high / self.low >= LOGARITHMIC_RATIO


def numbers_at(parameters: Sequence[FitParameter], shares: Array) -> Numbers:
    """Return values (SI) by path at ``shares`` (1) of the intervals between bounds, shape (parameters,)."""
    return {
        path: sign * parameter.value(float(share))
        for parameter, share in zip(parameters, shares, strict=True)
        for path, sign in zip(parameter.paths, parameter.signs or (1.0,) * len(parameter.paths), strict=True)
    }


@dataclass
class Parameters:
    """Reads the parameters of a fit, common ones and those of records; faults are collected."""

    mechanism: Mechanism
    faults: list[Fault]

    def __post_init__(self) -> None:
        self.values = numbers(self.mechanism)
        self.owners: dict[tuple[str, str], str] = {}  # of paths, by record; "" where all have them in common

    def read(self, texts: Mapping[Any, Any] | Sequence[str], record: str = "") -> list[FitParameter]:
        """Parameters from texts or from a mapping of paths to two bounds; with ``record`` they are its own.

        Texts are as ``"joint.C.clearance=0.1..1 mm"``, with commas between several paths, ``*`` for any
        characters and ``-`` before a number that has the opposite value.
        """
        parameters = []
        items = texts.items() if isinstance(texts, Mapping) else [text.partition("=")[::2] for text in texts]
        for key, value in items:
            name = ",".join(key) if isinstance(key, tuple | list) else str(key).strip()
            bounds = ends_of(value) or value if isinstance(value, str) else value
            if not (isinstance(bounds, tuple | list) and len(bounds) == 2):
                remedy = 'write PATH=LEAST..MOST, as in "joint.C.clearance=0.1..1 mm"'
                self.faults.append(
                    Fault(name or "parameters", "two bounds are needed", shown(bounds), "", remedy)
                )
            elif (parameter := self.parameter(name, (bounds[0], bounds[1]))) is not None:
                self.claim(parameter, record)
                parameters.append(replace(parameter, record=record))
        return parameters

    def claim(self, parameter: FitParameter, record: str) -> None:
        """Note which paths a parameter changes. A path that another one changes is a fault."""
        for path in parameter.paths:
            owner = self.owners.get((path, record)) or self.owners.get((path, ""))
            if owner is not None:
                message = f"{path} is identified by {owner} already"
                self.faults.append(Fault(parameter.name, message, remedy="remove one of them"))
            self.owners[path, record] = parameter.name

    def matches(self, name: str) -> list[tuple[float, Number]]:
        """Return the numbers that a name denotes, each with its sign."""
        matches: list[tuple[float, Number]] = []
        for text in (part.strip() for part in name.split(",")):
            sign, text = (-1.0, text[1:].strip()) if text.startswith("-") else (1.0, text)
            pattern = "*" in text or "?" in text
            paths = [path for path in self.values if fnmatchcase(path, text)] if pattern else [text]
            if not paths:
                remedy = suggestion(text, self.values, "* stands for any characters")
                self.faults.append(Fault(name, "matches no number of this model", remedy=remedy))
            numbers = (self.number(name, path) for path in paths)
            matches += [(sign, number) for number in numbers if number is not None]
        return matches

    def number(self, name: str, path: str) -> Number | None:
        """Return a number of the model or of a start; None for another path, whose fault is collected."""
        if (unit := unit_of_start(self.mechanism, path)) is not None:
            return Number(path, unit, Measure(unit))
        try:
            parameter = Parameter(self.mechanism, path)
        except Fault as fault:
            starts = start_paths(self.mechanism) if path.startswith(PREFIX) else ()
            remedy = suggestion(path, starts, fault.remedy) if starts else fault.remedy
            value = fault.value or shown(path)
            self.faults.append(Fault(name, fault.what, value, fault.limit, remedy))
            return None
        if parameter.quantity is None:
            remedy = suggestion(path, self.values, NO_NUMBER)
            message = "there is no number here that can be identified"
            self.faults.append(Fault(name, message, shown(path), "", remedy))
            return None
        return Number(parameter.path, parameter.unit, parameter.quantity)

    def parameter(self, name: str, bounds: tuple[Any, Any]) -> FitParameter | None:
        """One parameter; None if there is a fault, which is noted."""
        fault_count, signed = len(self.faults), self.matches(name)
        matches = [number for _, number in signed]
        if len({number.unit for number in matches}) > 1:
            units = ", ".join(f"{number.path} in {number.unit}" for number in matches)
            message, remedy = "numbers of different units cannot be one", "look for each by itself"
            self.faults.append(Fault(name, message, units, remedy=remedy))
        if len(self.faults) > fault_count:
            return None
        ends = [bound_of(name, value, matches[0], self.faults) for value in bounds]
        if None in ends:
            return None
        low, high = (float(value) for value in ends if value is not None)
        if not low < high:
            text = f"{shown(bounds[0])} .. {shown(bounds[1])}"
            message, remedy = "the bounds do not ascend", "exchange or correct them"
            self.faults.append(Fault(name, message, text, "", remedy))
            return None
        signs = tuple(sign for sign, _ in signed)
        values = {sign * self.values[number.path] for sign, number in signed if number.path in self.values}
        initial = values.pop() if len(values) == 1 else None
        inside = initial is not None and low <= initial <= high
        return FitParameter(
            name, tuple(number.path for number in matches), matches[0].unit, low, high,
            initial if inside else None, signs if min(signs) < 0.0 else (),
        )  # fmt: skip


def bound_of(name: str, value: Any, number: Number, faults: list[Fault]) -> float | None:
    """Return a bound in SI units, or None after adding a fault if it is outside the limits of ``number``."""
    with suppress(ValueError):
        value = float(value) if isinstance(value, str) else value
    try:
        bound: float = number.quantity.take(value, True)
        return bound
    except Fault as fault:
        faults.append(Fault(name, f"its bound: {fault.what}", fault.value, fault.limit, fault.remedy))
        return None
