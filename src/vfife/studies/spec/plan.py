"""A study as data: the tables of its file, the parameters that vary, and the resulting cases."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from ...errors import Fault, Path, kind_of, shown
from ...measures.catalogue import CASE, LAST
from ...model.mechanism import REPETITION, Mechanism
from ...schema import Choice, Integer, Json, Measure, Reader, Switch, Text, Value, described
from ...schema.parts import FreeList, Names
from ...schema.values import is_list
from ...store.studyfile import SEARCH
from .distributions import METHODS, Distribution

Number: TypeAlias = float | str  # SI; a text is a word of the model, such as a law's name
Numbers: TypeAlias = Mapping[str, Number]  # of a case, by path

GRIDS = ("grid", "list")
MOST_CASES = 1_000_000
MOST_TURNS = 1_000_000


@dataclass(frozen=True)
class Amount(Value):
    """A number, or a text with a unit, whose dimension follows from the path that it is for."""

    def take(self, value: Any, written: bool) -> Any:
        """Return the value unread."""
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            remedy = 'write it as in 2e-4 or "0.2 mm"'
            raise Fault(
                "", f"this is {kind_of(value)}", shown(value), "a number, or a text with a unit", remedy
            )
        return value

    def json(self) -> Json:
        """Return the schema of a number or a text."""
        return {"anyOf": [{"type": "number"}, {"type": "string"}]}


@dataclass(frozen=True)
class OneOrMore(Value):
    """A value, or a list of values."""

    part: Value

    def read(self, value: Any, path: Path, by: Reader) -> Any:
        """Return a tuple."""
        values = FreeList(self.part).read(value if is_list(value) else [value], path, by)
        if values == ():
            by.refuse(path, "an empty list", "[]", "one or more", "name one")
        return values or None

    def suits(self, value: Any) -> bool:
        """Return whether this is a value or a list."""
        return isinstance(value, list) or self.part.suits(value)

    def json(self) -> Json:
        """Return the schema of a value, or a list of values."""
        return {"anyOf": [self.part.json(), {"type": "array", "items": self.part.json()}]}


@dataclass(frozen=True)
class VaryTable:
    """A table under ``[vary]``: paths that take the same values, and these values or their distribution."""

    path: tuple[str, ...] = described(
        OneOrMore(Text()), "path of the number, as in joint.C.clearance; several are given the same values"
    )
    values: tuple[Any, ...] | None = described(FreeList(Amount()), "list of the values", None)
    low: Any = described(
        Amount(), "least value of a range; of a distribution, where it is cut off", None, key="from"
    )
    high: Any = described(
        Amount(), "largest value of a range; of a distribution, where it is cut off", None, key="to"
    )
    count: int | None = described(
        Integer(2, MOST_CASES),
        "number of values in a range, with both ends; without it samples are taken",
        None,
    )
    spacing: str = described(Choice(("linear", "logarithmic")), "spacing of the values of a range", "linear")
    mean: Any = described(Amount(), "mean of a normal distribution", None)
    deviation: Any = described(Amount(), "standard deviation of a normal distribution", None)
    fit: str | None = described(
        Text(), "an ISO 286 fit, as in H8/f7: the radial clearance is distributed accordingly", None
    )
    diameter: float | None = described(Measure("m", above=0.0), "nominal diameter of the fit", None)
    cut: bool = described(Switch(), "of a transition fit: pairs without clearance are omitted", False)
    nominal: Any = described(Amount(), "nominal size of what has a tolerance", None)
    tolerance: Any = described(
        OneOrMore(Amount()),
        "one size for both sides, lower and upper deviation, or an ISO 286 zone, as in h7",
        None,
    )


@dataclass(frozen=True)
class StudySpec:
    """The keys at the top of a study file."""

    model: str = described(Text(), "model file, beside the study file")
    measures: tuple[str, ...] = described(
        OneOrMore(Text()),
        "measures of each case, or max, min, mean, rms, range of a channel, as in mean(C.force)",
    )
    turns: int = described(Integer(1, MOST_TURNS), "turns of the crank in each case; with settle at most", 10)
    duration: float | None = described(
        Measure("s", above=0.0), "length of each case, instead of turns of a crank", None
    )
    settle: float | None = described(
        REPETITION, "end a case as soon as turns repeat within this share of their size", None
    )
    last: int | None = described(
        Integer(1, MOST_TURNS),
        "turns at the end over which measures are averaged; by default 1 and, of a case that ends with settle"
        " at a period of several turns, whole periods",
        None,
    )
    counts: str = described(
        Choice((CASE, LAST)),
        "turns over which impacts, approach speeds and shares of contact are counted: of the whole case, from"
        " its start on, or the last ones",
        CASE,
    )
    step: Any = described(Measure("s", above=0.0, words=("auto",)), "time step of every case", "auto")
    method: str = described(
        Choice((*GRIDS, *METHODS, SEARCH)),
        "grid: all combinations; list: row by row; else the kind of samples",
        "grid",
    )
    count: int | None = described(Integer(1, MOST_CASES), "number of samples", None)
    seed: int = described(Integer(0, 2**31 - 1), "seed of the samples: the same seed, the same samples", 1)
    note: str = described(Text(), "anything worth knowing", "")
    set: dict[str, Any] = described(Names(Amount()), "numbers replaced in all cases, by path", factory=dict)

    def of_case(self) -> CaseSpec:
        """Return the part of the specification that the engine needs."""
        step = None if self.step == "auto" else float(self.step)
        length = self.turns, self.settle, self.last or 1, step, self.duration
        period_means = self.last is None and self.settle is not None
        return CaseSpec(tuple(self.measures), *length, self.counts, period_means)


@dataclass(frozen=True)
class CaseSpec:
    """What is computed for every case: ``measures`` by name (all if empty), as means over the ``last`` turns.

    A case makes ``turns`` turns, or fewer if they repeat within ``settle`` (1), or lasts for a ``duration``
    (s). ``step`` (s): None for the automatic step of each case. ``counts``: whether contacts are counted over
    the whole "case" or the "last" turns. ``period_means``: cases whose turns repeat with a period of several
    turns are measured over whole periods instead. ``examine``: whether a case keeps what its cautions need.
    """

    measures: tuple[str, ...]
    turns: int
    settle: float | None = None
    last: int = 1
    step: float | None = None
    duration: float | None = None
    counts: str = CASE
    period_means: bool = False
    examine: bool = False

    @property
    def length(self) -> dict[str, Any]:
        """Length of a case, as arguments of a run."""
        return {"turns": float(self.turns) if self.duration is None else None, "duration": self.duration}

    @property
    def fields(self) -> dict[str, Any]:
        """The fields as JSON has them, without defaults that former versions lack."""
        fields = {**dataclasses.asdict(self), "measures": list(self.measures)}
        defaults = ("counts", CASE), ("period_means", False), ("examine", False)
        return {name: value for name, value in fields.items() if (name, value) not in defaults}

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> CaseSpec:
        """Return the spec with such fields, as JSON has them."""
        return cls(**{**fields, "measures": tuple(fields["measures"])})


@dataclass(frozen=True)
class StudyParameter:
    """A parameter of a study: the paths of its numbers, their unit, its values or their distribution.

    ``kind``: "values", "range", "uniform", "normal", "truncated", "fit" or "tolerance"; ``words``: the fit.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    kind: str
    words: str
    values: tuple[Number, ...] | None
    distribution: Distribution | None
    field: Value  # of the model


@dataclass(frozen=True)
class Plan:
    """A study of the model ``base``, ready to run: its parameters, and their values in each case, ``points``
    included.

    ``raw``: the tables as written.
    """

    name: str
    base: Mechanism
    spec: StudySpec
    parameters: tuple[StudyParameter, ...]
    points: tuple[tuple[Number, ...], ...] = ()
    cases: tuple[tuple[Number, ...], ...] = ()
    raw: dict[str, Any] = field(default_factory=dict)

    def numbers(self) -> list[dict[str, Number]]:
        """Return the numbers of each case by path."""
        names = [parameter.name for parameter in self.parameters]
        return [case_numbers(self.parameters, dict(zip(names, row, strict=True))) for row in self.cases]


def case_numbers(parameters: Sequence[StudyParameter], values: Mapping[str, Number]) -> dict[str, Number]:
    """Return the numbers of a case by path from the values of its parameters; whole ones are rounded."""
    numbers: dict[str, Number] = {}
    for parameter in parameters:
        value = values[parameter.name]
        if not isinstance(value, str):
            value = float(round(value)) if isinstance(parameter.field, Integer) else float(value)
        numbers |= dict.fromkeys(parameter.paths, value)
    return numbers
