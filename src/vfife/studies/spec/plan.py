"""The nouns of a study file: what is varied and how, what is wanted of each member."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, TypeAlias

from ...errors import Fault, Path, kind_of, shown
from ...model.mechanism import Mechanism
from ...schema import Choice, Json, Measure, Reading, Switch, Text, Value, Whole, described
from ...schema.parts import Many, Names
from ...schema.values import is_list
from . import sampling

Number: TypeAlias = float | str  # SI; a text is a word of the model, such as a law's name

GRIDS = ("grid", "list")
SEARCH = "search"  # members are asked for as they are needed
MOST_MEMBERS = 1_000_000
MOST_TURNS = 1_000_000


@dataclass(frozen=True)
class Amount(Value):
    """A number or a text with a unit, whose dimension the path says."""

    def take(self, value: Any, written: bool) -> Any:
        """The value as it stands."""
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise Fault(
                "",
                f"this is {kind_of(value)}",
                shown(value),
                "a number, or a text with a unit",
                'write it as in 2e-4 or "0.2 mm"',
            )
        return value

    def json(self) -> Json:
        """A number or a text."""
        return {"anyOf": [{"type": "number"}, {"type": "string"}]}


@dataclass(frozen=True)
class Several(Value):
    """A value, or a list of such."""

    part: Value

    def read(self, value: Any, path: Path, by: Reading) -> Any:
        """A tuple."""
        found = Many(self.part).read(value if is_list(value) else [value], path, by)
        if found == ():
            by.refuse(path, "an empty list", "[]", "one or more", "name one")
        return found or None

    def suits(self, value: Any) -> bool:
        """A value or a list."""
        return isinstance(value, list) or self.part.suits(value)

    def json(self) -> Json:
        """A value, or a list of such."""
        return {"anyOf": [self.part.json(), {"type": "array", "items": self.part.json()}]}


@dataclass(frozen=True)
class Varied:
    """Numbers of the model that move together: where they are, and which values they take."""

    path: tuple[str, ...] = described(
        Several(Text()), "path of the number, as in joint.C.clearance; several are given the same values"
    )
    values: tuple[Any, ...] | None = described(Many(Amount()), "the values, one by one", None)
    low: Any = described(
        Amount(), "least value of a range; of a distribution, where it is cut off", None, key="from"
    )
    high: Any = described(
        Amount(), "largest value of a range; of a distribution, where it is cut off", None, key="to"
    )
    count: int | None = described(
        Whole(2, MOST_MEMBERS),
        "values a range is cut into, its ends among them; without it samples are taken",
        None,
    )
    spacing: str = described(Choice(("linear", "logarithmic")), "how the values of a range lie", "linear")
    mean: Any = described(Amount(), "mean of a normal distribution", None)
    deviation: Any = described(Amount(), "standard deviation of a normal distribution", None)
    fit: str | None = described(
        Text(),
        "an ISO 286 fit of hole and shaft, as in H8/f7, which says how a radial clearance is distributed",
        None,
    )
    diameter: float | None = described(Measure("m", above=0.0), "nominal diameter of the fit", None)
    cut: bool = described(Switch(), "of a transition fit: pairs without play are left out", False)
    nominal: Any = described(Amount(), "nominal size of what has a tolerance", None)
    tolerance: Any = described(
        Several(Amount()),
        "its tolerance: one size for both sides, the lower and the upper deviation, or a zone of ISO 286, as"
        " in h7",
        None,
    )


@dataclass(frozen=True)
class Asked:
    """A study: a model, what is varied, what is wanted."""

    model: str = described(Text(), "model file, beside the study file")
    measures: tuple[str, ...] = described(
        Several(Text()),
        "what is kept of each member: names of measures, or max, min, mean, rms or range of a channel, as in"
        " mean(C.force)",
    )
    turns: int = described(
        Whole(1, MOST_TURNS), "turns of the crank that each member makes, or makes at most", 10
    )
    settle: float | None = described(
        Measure("1", above=0.0, high=1.0),
        "a member ends as soon as its turns repeat within this share of their largest values",
        None,
    )
    last: int = described(
        Whole(1, MOST_TURNS), "so many turns at the end are measured, and their mean is told", 1
    )
    step: Any = described(
        Measure("s", above=0.0, words=("auto",)), "time step of every member, or auto", "auto"
    )
    method: str = described(
        Choice((*GRIDS, *sampling.METHODS, SEARCH)),
        "grid: every value with every other; list: first with first; else how samples are taken of what has"
        " no values",
        "grid",
    )
    count: int | None = described(Whole(1, MOST_MEMBERS), "how many samples are taken", None)
    seed: int = described(Whole(0, 2**31 - 1), "which samples are taken: the same seed, the same samples", 1)
    note: str = described(Text(), "anything worth knowing", "")
    set: dict[str, Any] = described(
        Names(Amount()), "numbers of the model that are replaced for all members, by path", factory=dict
    )


@dataclass(frozen=True)
class Parameter:
    """What is varied, understood: paths of the model, unit, and values one by one or a distribution of them.

    ``kind``: "values", "range", "uniform", "normal", "truncated" or "fit"; ``words`` how a person reads it.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    kind: str
    words: str
    values: tuple[Number, ...] | None = None
    distribution: Any = None
    held: Any = None  # what the field of the model takes


@dataclass(frozen=True)
class Plan:
    """A study that can be made, of the model ``base``: what is asked, its parameters, members added point by
    point.
    """

    name: str
    base: Mechanism
    asked: Asked
    parameters: tuple[Parameter, ...]
    points: tuple[tuple[Number, ...], ...] = ()
    members: tuple[tuple[Number, ...], ...] = ()
    raw: dict[str, Any] = field(default_factory=dict)

    def numbers(self) -> list[dict[str, Number]]:
        """Of each member the numbers that it changes, by path."""
        return [
            {path: value for one, value in zip(self.parameters, values, strict=True) for path in one.paths}
            for values in self.members
        ]
