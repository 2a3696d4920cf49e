"""The cheapest fits of the joints of a machine with which nearly all machines keep a limit."""

from __future__ import annotations

import heapq
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import Fault, VfifeError
from ..spec.limits import Estimate, allowed_failures, needed, quantile
from ..spec.sampling import Array, Distribution, of_fit, places

GRADE = re.compile(r"IT([0-9]{1,2})")
MOST_CHOICES = 200_000
FIRST = 8  # machines of a choice that are tried before more of them are


@dataclass(frozen=True)
class Option:
    """A fit that a joint may have, what it costs, and how the clearance is distributed then."""

    name: str
    cost: float
    clearance: Distribution


@dataclass(frozen=True)
class Choice:
    """An option for every joint, and what they cost together."""

    options: tuple[Option, ...]
    cost: float

    @property
    def names(self) -> tuple[str, ...]:
        """The fits."""
        return tuple(option.name for option in self.options)


@dataclass(frozen=True)
class Allocated:
    """The cheapest choice that keeps the limit (None where none does), its quantile, what was looked at on
    the way.

    ``rejected``: dearer or equal choices are not among them; ``machines``: members that were asked for;
    ``failures`` of the chosen of ``count``.
    """

    choice: Choice | None
    estimate: Estimate | None
    failures: int
    count: int
    rejected: tuple[Choice, ...]
    machines: int


Evaluate = Callable[[Sequence[Sequence[float]]], Array]


def options_of(letters: str, diameter: float, costs: Mapping[str, float]) -> list[Option]:
    """The fits that a joint may have, cheapest first.

    ``costs`` has either fits as they are ("H8/f7"), or grades ("IT7"), each with what a hole or a shaft of it
    costs: then the options are those of ``letters`` as in "H/f", in every pair of a hole with a shaft of its
    own grade or of the next finer one. Raises Fault.
    """
    if not costs:
        raise Fault("", "no costs", "", 'a cost for each grade, as in "IT7" = 5, or for each fit', "add them")
    for name, cost in costs.items():
        if not (math.isfinite(cost) and cost >= 0.0):
            raise Fault("", "a cost that is none", f"{name} = {cost:g}", "0 or more", "correct it")
    if all("/" in name for name in costs):
        named = [(name, cost) for name, cost in costs.items()]
    else:
        named = list(graded(letters, costs))
    found = [Option(name, float(cost), of_fit(name, diameter)) for name, cost in named]
    return sorted(found, key=lambda option: (option.cost, option.clearance.limits[1], option.name))


def graded(letters: str, costs: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Fits of the grades that have a cost. Raises Fault."""
    parts = letters.split("/")
    if len(parts) != 2 or not parts[0].isupper() or not parts[1].islower():
        raise Fault(
            "",
            "no letters of a fit",
            f'"{letters}"',
            "that of the hole, a stroke, that of the shaft",
            'write them as in "H/f"',
        )
    grades = {}
    for name, cost in costs.items():
        if (found := GRADE.fullmatch(name)) is None:
            raise Fault(
                "",
                "neither a grade nor a fit",
                f'"{name}"',
                '"IT7" or "H8/f7", all of one kind',
                "correct the name",
            )
        grades[int(found[1])] = cost
    for hole, shaft in itertools.product(sorted(grades), repeat=2):
        if hole - 1 <= shaft <= hole:
            yield f"{parts[0]}{hole}/{parts[1]}{shaft}", grades[hole] + grades[shaft]


def by_cost(joints: Sequence[Sequence[Option]]) -> Iterator[Choice]:
    """Every combination of the options of the joints, the cheapest first. The options of a joint are in the
    order of their costs.
    """
    start = (0,) * len(joints)
    heap, seen = [(math.fsum(options[0].cost for options in joints), start)], {start}
    while heap:
        cost, places_ = heapq.heappop(heap)
        yield Choice(tuple(options[k] for options, k in zip(joints, places_, strict=True)), cost)
        for joint, k in enumerate(places_):
            following = (*places_[:joint], k + 1, *places_[joint + 1 :])
            if k + 1 < len(joints[joint]) and following not in seen:
                seen.add(following)
                heapq.heappush(
                    heap,
                    (
                        math.fsum(options[n].cost for options, n in zip(joints, following, strict=True)),
                        following,
                    ),
                )


def allocate(
    joints: Sequence[Sequence[Option]],
    evaluate: Evaluate,
    limit: float,
    share: float = 0.99,
    *,
    confidence: float = 0.95,
    count: int | None = None,
    seed: int = 0,
    width: int = 64,
    told: Callable[[Choice, int, int], None] | None = None,
) -> Allocated:
    """The cheapest choice with which a measure is at most ``limit`` in a share of all machines.

    Of every choice the same ``count`` machines are drawn, independent ones, those with most play first. A
    choice is refused as soon as more of them are beyond the limit (or without a value) than show the share
    with this confidence, and taken when all have been tried: so the first that is taken is the cheapest of
    all. ``evaluate`` gives the measure at rows of clearances, one for each joint; rows that it had may come
    again. ``width``: as many rows are asked for at once. ``told`` hears of each choice that is decided, of
    its failures and machines. Raises Fault for a count too small to show the share, VfifeError for more
    choices than can be looked at.
    """
    least = needed(1.0 - share, confidence)
    count = least if count is None else count
    allowed = allowed_failures(count, 1.0 - share, confidence)
    if allowed < 0:
        raise Fault(
            "",
            f"too few machines to show {100 * share:g} % with {100 * confidence:g} % confidence",
            str(count),
            f"at least {least}",
            "ask for more",
        )
    if math.prod(map(len, joints)) > MOST_CHOICES:
        raise VfifeError(
            f"{math.prod(map(len, joints)):,} choices of fits are more than {MOST_CHOICES:,}; leave grades or"
            " joints out"
        )
    unit = places("random", count, len(joints), seed)
    unit = unit[np.argsort(-unit.sum(axis=1), kind="stable")]
    # Of each option the clearances of all machines, once: choices share them.
    drawn = {
        id(option): option.clearance.quantile(unit[:, k])
        for k, options in enumerate(joints)
        for option in options
    }
    left, rejected, machines = by_cost(joints), list[Choice](), 0
    trials = list[Trial]()
    while True:
        trials += [
            Trial(choice, np.stack([drawn[id(one)] for one in choice.options], axis=1))
            for choice in itertools.islice(left, max(0, width // FIRST - len(trials)))
        ]
        if not trials:
            return Allocated(None, None, 0, count, tuple(rejected), machines)
        batch = next_rows(trials, width)
        rows = [row for trial, many in batch for row in trial.next(many)]
        values, at = evaluate(rows), 0
        machines += len(rows)
        for trial, many in batch:
            trial.values = np.concatenate([trial.values, values[at : at + many]])
            at += many
        for trial in [trial for trial in trials if trial.failures(limit) > allowed]:
            trials.remove(trial)
            rejected.append(trial.choice)
            if told is not None:
                told(trial.choice, trial.failures(limit), len(trial.values))
        if trials and len(trials[0].values) == count:
            first = trials[0]
            if told is not None:
                told(first.choice, first.failures(limit), count)
            known = np.where(np.isfinite(first.values), first.values, math.inf)
            cheaper = tuple(one for one in rejected if one.cost <= first.choice.cost)
            return Allocated(
                first.choice, quantile(known, share), first.failures(limit), count, cheaper, machines
            )


class Trial:
    """A choice under trial: its machines, and the values of those that were tried."""

    def __init__(self, choice: Choice, clearances: Array) -> None:
        self.choice, self.clearances, self.values = choice, clearances, np.empty(0)

    def next(self, many: int) -> list[list[float]]:
        """Clearances of the next machines."""
        start = len(self.values)
        found: list[list[float]] = self.clearances[start : start + many].tolist()
        return found

    def failures(self, limit: float) -> int:
        """Machines beyond the limit, or without a value."""
        return int(np.count_nonzero(~(self.values <= limit)))


def next_rows(trials: Sequence[Trial], width: int) -> list[tuple[Trial, int]]:
    """Whose machines are tried next, and how many: the cheapest choice first, as many again as it has had;
    room that is left goes to others.
    """
    found, room = [], width
    for trial in trials:
        many = min(max(FIRST, len(trial.values)), len(trial.clearances) - len(trial.values), room)
        if many > 0:
            found.append((trial, many))
            room -= many
    return found
