"""What a study file asks of a search: what ``[optimise]``, ``[allocation]`` and ``[cost]`` say, beside what
is varied and ``[limit]``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...errors import Fault, ModelError, kind_of, shown, suggestion
from ...schema import Measure, Text, Whole, described
from ...schema.parts import Many
from ..engine.run_missing import Engine, units_of
from ..engine.study_file import StudyTables, Written
from ..spec.limits import CONFIDENCE, Bound, flat, needed, read_bounds
from ..spec.plan import MOST_MEMBERS, SEARCH, Parameter, Plan
from ..spec.sampling import Array, Clearance, Uniform
from .allocation import Allocated, Choice, Option, allocate, options_of
from .local_search import Refined, refined, slopes_of
from .optimise import BATCH, Axis, Found, Search, searched

REFINE = 20  # members more that derivatives may lead to
WIDTH = 128  # members that an allocation asks for at once
OPTIMISE, ALLOCATION, COST, LIMIT = "optimise", "allocation", "cost", "limit"


@dataclass(frozen=True)
class Optimised:
    """The table ``[optimise]``."""

    minimise: tuple[str, ...] = described(
        Many(Text()), "measures that shall be as small as possible; of several the Pareto front is told", ()
    )
    maximise: tuple[str, ...] = described(Many(Text()), "measures that shall be as large as possible", ())
    members: int = described(Whole(1, MOST_MEMBERS), "how many members are computed", 200)
    seed: int = described(
        Whole(0, 2**31 - 1), "which members the search asks for: the same seed, the same search", 1
    )
    batch: int = described(Whole(1, 4096), "members that are asked for at once", BATCH)
    refine: int = described(
        Whole(0, 10000),
        "members more that derivatives may lead to from the best one of one measure on; 0: none",
        REFINE,
    )


@dataclass(frozen=True)
class Allotted:
    """The table ``[allocation]``."""

    measure: str = described(Text(), "the measure that has a limit")
    share: float = described(
        Measure("1", above=0.0, high=0.9999), "share of all machines that shall keep the limit", 0.99
    )
    confidence: float = described(
        Measure("1", above=0.0, high=0.9999), "with which the sample shall show that", CONFIDENCE
    )
    count: int | None = described(
        Whole(1, MOST_MEMBERS), "machines that are drawn; the fewest that can show it unless given", None
    )
    seed: int = described(Whole(0, 2**31 - 1), "which machines are drawn", 1)


@dataclass(frozen=True)
class Allotment:
    """An allocation understood: the parameters, of each the fits it may have (one option for what has no
    costs), the limit.
    """

    parameters: tuple[Parameter, ...]
    options: tuple[tuple[Option, ...], ...]
    bound: Bound
    asked: Allotted
    fits: tuple[bool, ...]  # whose are to be chosen

    def chosen(self, choice: Choice) -> dict[str, str]:
        """The fits of a choice by the parameters for which there was one to be made."""
        return {
            one.name: fit
            for one, fit, own in zip(self.parameters, choice.names, self.fits, strict=True)
            if own
        }


def search_of(tables: StudyTables) -> tuple[Plan, Search]:
    """The search of a study file with ``[optimise]``. Raises ModelError with every fault."""
    raw = tables.raw
    plan, units = search_plan(tables, OPTIMISE, 'minimise = ["C.force.max"]')
    by = Written()
    asked = by.table((OPTIMISE,), Optimised, raw[OPTIMISE])
    bounds = read_bounds(raw.get(LIMIT, {}), units, by)
    sought = {key: getattr(asked, key) or () for key in ("minimise", "maximise")}
    for key, names in sought.items():
        for k, name in enumerate(names):
            if name not in units:
                by.refuse(
                    (OPTIMISE, key, k),
                    "it is not measured",
                    shown(name),
                    "",
                    suggestion(name, units, "name one of the measures"),
                )
            elif key == "maximise" and name in sought["minimise"]:
                by.refuse(
                    (OPTIMISE, key, k),
                    "it shall be small as well",
                    shown(name),
                    "",
                    "leave it out of one of both",
                )
    if asked.minimise == () == asked.maximise:
        by.refuse(
            (OPTIMISE, "minimise"),
            "nothing is sought",
            "[]",
            "one measure or more, here or in maximise",
            "name one",
        )
    axes = []
    for one in plan.parameters:
        if one.values is None and not isinstance(one.distribution, Uniform):
            what = "a search needs a range or values, and this has a distribution"
            by.refuse(("vary", one.name, ""), what, one.words, "from and to, or values", "give these")
        elif one.values is not None:
            axes.append(Axis(one.name, values=one.values))
        else:
            low, high = one.distribution.limits
            axes.append(Axis(one.name, low, high, whole=isinstance(one.held, Whole)))
    finished(by, tables.source)
    refine = asked.refine if len(asked.minimise) + len(asked.maximise) == 1 else 0
    return plan, Search(
        tuple(axes),
        tuple(asked.minimise),
        bounds,
        asked.members,
        asked.seed,
        asked.batch,
        tuple(asked.maximise),
        refine,
    )


def allotment_of(tables: StudyTables) -> tuple[Plan, Allotment]:
    """The allocation of a study file with ``[allocation]`` and ``[cost]``. Raises ModelError with every
    fault.
    """
    raw = tables.raw
    plan, units = search_plan(tables, ALLOCATION, 'measure = "C.force.max"')
    by = Written()
    asked = by.table((ALLOCATION,), Allotted, raw[ALLOCATION])
    bounds = {one.measure: one for one in read_bounds(raw.get(LIMIT, {}), units, by)}
    if asked.measure is not None and asked.measure not in dict(flat(raw.get(LIMIT, {}))):
        remedy = f'add it under [limit], as in "{asked.measure}" = ...'
        by.refuse(
            (ALLOCATION, "measure"), "it has no limit", shown(asked.measure), "a measure of [limit]", remedy
        )
    elif asked.measure in bounds and math.isfinite(bounds[asked.measure].low):
        by.refuse(
            (LIMIT, asked.measure, "low"),
            "an allocation keeps a largest value alone",
            "",
            "",
            "leave low out",
        )
    if None not in (asked.share, asked.confidence, asked.count) and asked.count < (
        least := needed(1.0 - asked.share, asked.confidence)
    ):
        what = (
            f"too few machines to show {100.0 * asked.share:g} % with {100.0 * asked.confidence:g} %"
            " confidence"
        )
        by.refuse(
            (ALLOCATION, "count"),
            what,
            str(asked.count),
            f"at least {least}",
            "ask for more, or leave it out",
        )
    costs = raw.get(COST, {})
    names = [one.name for one in plan.parameters]
    for name in costs if isinstance(costs, dict) else ():
        if name not in names:
            by.refuse(
                (COST, name, ""),
                "costs of what is not varied",
                "",
                "",
                suggestion(name, names, "name a table of [vary]"),
            )
    options = [
        options_at(one, costs.get(one.name) if isinstance(costs, dict) else None, by)
        for one in plan.parameters
    ]
    if not any(one.name in costs for one in plan.parameters if isinstance(costs, dict)):
        remedy = "add [cost.NAME] for a parameter with a fit, with a cost for each grade, as in IT7 = 5"
        by.refuse((COST, ""), "no fit has costs, so there is nothing to choose", "", "", remedy)
    bound = bounds.get(asked.measure or "")
    finished(by, tables.source)
    if bound is None:  # told above
        raise ModelError(by.faults, tables.source)
    return plan, Allotment(
        plan.parameters, tuple(options), bound, asked, tuple(one.name in costs for one in plan.parameters)
    )


def options_at(one: Parameter, costs: Any, by: Written) -> tuple[Option, ...]:
    """The fits that a parameter may have; itself where it has no costs."""
    where = (COST, one.name)
    if costs is None:
        if one.distribution is None:
            by.refuse(
                ("vary", one.name, ""),
                "machines are drawn, and this has values",
                "",
                "a fit, a tolerance or a distribution",
                "give one",
            )
            return ()
        return (Option("", 0.0, one.distribution),)
    if not isinstance(one.distribution, Clearance):
        by.refuse(
            where,
            "costs of what has no fit",
            "",
            'fit = "H8/f7" and diameter in its table of [vary]',
            "add the fit",
        )
        return ()
    bad = (
        {
            key: value
            for key, value in costs.items()
            if isinstance(value, bool) or not isinstance(value, int | float)
        }
        if isinstance(costs, dict)
        else costs
    )
    if bad or not isinstance(costs, dict):
        by.refuse(
            where,
            f"this is {kind_of(costs)}",
            shown(bad),
            "a number for each grade or fit",
            "write them as in IT7 = 5",
        )
        return ()
    fit = one.distribution.fit
    letters = "/".join(name.rstrip("0123456789") for name in (fit.hole.name, fit.shaft.name))
    try:
        return tuple(options_of(letters, fit.diameter, costs))
    except Fault as refused:
        by.add(refused.at(where))
        return ()


def search_plan(tables: StudyTables, table: str, example: str) -> tuple[Plan, Mapping[str, str]]:
    """The plan of tables without members of its own, and units of the measures. Raises ModelError."""
    by = Written()
    if not isinstance(tables.raw.get(table), dict):
        by.refuse(
            (table, ""), "this table is missing", "", "what the search is for", f"add it, as in {example}"
        )
        finished(by, tables.source)
    raw = {**{key: value for key, value in tables.raw.items() if key != "count"}, "method": SEARCH}
    plan = replace(tables, raw=raw).plan()
    return plan, units_of(plan)


def finished(by: Written, known_as: str) -> None:
    """Raises ModelError with what was refused."""
    if by.faults:
        raise ModelError(by.faults, known_as)


def numbers_at(parameters: Sequence[Parameter], values: Mapping[str, float | str]) -> dict[str, float | str]:
    """Numbers of a member by path from the values of the parameters by name; whole ones are rounded."""
    found: dict[str, float | str] = {}
    for one in parameters:
        value = values[one.name]
        if not isinstance(value, str):
            value = float(round(value)) if isinstance(one.held, Whole) else float(value)
        found |= dict.fromkeys(one.paths, value)
    return found


def optimised(
    engine: Engine, plan: Plan, search: Search, told: Callable[[list[Found]], None] | None = None
) -> tuple[list[Found], Refined]:
    """The members of a search, in a study file, and of these the last that derivatives led to."""

    def at(parameters: Mapping[str, float | str]) -> dict[str, float | str]:
        return numbers_at(plan.parameters, parameters)

    def ask(asked: Sequence[Mapping[str, float | str]]) -> Sequence[Mapping[str, float] | None]:
        return engine.ask([at(one) for one in asked])

    found = searched(search, ask, told)
    more = refined(search, found, ask, slopes_of(plan, search, at), told) if search.refine else Refined()
    return [*found, *more.members], more


def allotted(
    engine: Engine, task: Allotment, told: Callable[[Choice, int, int], None] | None = None
) -> Allocated:
    """The allocation of fits, its machines being members of a study file. Raises ModelError, VfifeError."""
    names, bound, asked = [one.name for one in task.parameters], task.bound, task.asked

    def values(rows: Sequence[Sequence[float]]) -> Array:
        found = engine.ask([numbers_at(task.parameters, dict(zip(names, row, strict=True))) for row in rows])
        return np.array([math.nan if one is None else one.get(bound.measure, math.nan) for one in found])

    return allocate(
        task.options,
        values,
        bound.high,
        asked.share,
        confidence=asked.confidence,
        count=asked.count,
        seed=asked.seed,
        width=WIDTH,
        told=told,
    )
