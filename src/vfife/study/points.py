"""A plan's members: every combination of the values that are given, with every sample of what has none, and points one by one."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

from ..errors import kind_of, shown, suggestion
from ..fields import Measure, Reading, Refused, Whole
from .plan import GRIDS, MOST_MEMBERS, SEARCH, Number, Parameter, Plan
from .sampling import points as sampled
from .varied import number


def spread(plan: Plan, extra: Any, by: Reading) -> Plan:
    """The plan with its members, ``extra`` ones among them as tables of values by name; what is wrong is told."""
    listed = tuple(single(plan, one, k, by) for k, one in enumerate(extra)) if isinstance(extra, list) else ()
    if not isinstance(extra, list):
        by.tell(("point",), Refused(f"this is {kind_of(extra)}", shown(extra), "tables [[point]]", "write them so"))
    points = tuple(one for one in listed if one is not None)
    members = planned(plan, by)
    every = tuple(dict.fromkeys((*members, *points))) if members is not None else ()
    return dataclasses.replace(plan, points=points, members=every)


def planned(plan: Plan, by: Reading) -> list[tuple[Number, ...]] | None:
    """Values of every member, in the order of the parameters; None where there cannot be any."""
    method, count = plan.asked.method, plan.asked.count
    free = [one for one in plan.parameters if one.values is None]
    if method == SEARCH:
        return []
    if method in GRIDS:
        for one in free:
            what = f"a {method} takes values, and {one.name} has {article_of(one)}"
            remedy = 'list its values, give from, to and count, or take samples: method = "sobol" and count'
            by.tell(("vary", one.name, ""), Refused(what, "", "", remedy))
        if count is not None:
            by.tell(("count",), Refused(f"a {method} takes no samples", str(count), "", "remove it, or name another method"))
        if free or count is not None:
            return None
        return rows_of_lists(plan, by) if method == "list" else grid(plan, None, by)
    if not free:
        remedy = 'give a number from and to, or mean and deviation, or set method = "grid"'
        by.tell(("method",), Refused("there is nothing to take samples of: every parameter has values", f'"{method}"', "", remedy))
    if count is None:
        by.tell(("count",), Refused("this key is missing", "", "how many samples are taken", "add it, as in count = 256"))
    if not free or count is None or too_many(plan, count, by):
        return None
    try:
        drawn = sampled([one.distribution for one in free], method, count, plan.asked.seed)
    except Refused as refused:
        by.tell(("method",), refused)
        return None
    columns = [fitting(one, drawn[:, k], by) for k, one in enumerate(free)]
    return grid(plan, list(zip(*columns, strict=True)), by) if all(columns) else None


def article_of(one: Parameter) -> str:
    """What a parameter without values has."""
    return "a range" if one.kind == "uniform" else f"a {one.kind} distribution" if one.kind != "fit" else f"the fit {one.words}"


def too_many(plan: Plan, samples: int, by: Reading) -> bool:
    """Whether there are more members than anybody means, counted before any is made."""
    sizes = [len(one.values) for one in plan.parameters if one.values is not None] + ([samples] if samples > 1 else [])
    count = math.prod(sizes)
    if count <= MOST_MEMBERS:
        return False
    counted = " x ".join(f"{size:,}" for size in sizes)
    by.tell(("vary", ""), Refused(f"{counted} = {count:,} members", "", f"at most {MOST_MEMBERS:,}", "give fewer values, or take samples"))
    return True


def grid(plan: Plan, samples: list[tuple[Number, ...]] | None, by: Reading) -> list[tuple[Number, ...]] | None:
    """Every value with every other, and with every sample of what has none."""
    if too_many(plan, len(samples or ()), by):
        return None
    axes = [one.values for one in plan.parameters if one.values is not None]
    found = []
    for values in itertools.product(*axes):
        for sample in samples or [()]:
            given, drawn = iter(values), iter(sample)
            found.append(tuple(next(given if one.values is not None else drawn) for one in plan.parameters))
    return found


def rows_of_lists(plan: Plan, by: Reading) -> list[tuple[Number, ...]] | None:
    """First with first, second with second."""
    lists = [one.values or () for one in plan.parameters]
    if len({len(one) for one in lists}) > 1:
        sizes = ", ".join(f"{one.name} {len(values)}" for one, values in zip(plan.parameters, lists, strict=True))
        by.tell(
            ("vary", ""), Refused("lists that go together are of different lengths", sizes, "one length", 'complete them, or set method = "grid"')
        )
        return None
    return list(zip(*lists, strict=True))


def fitting(one: Parameter, values: Any, by: Reading) -> list[Number]:
    """Samples of a parameter as the model takes them; none, and a fault, where some lie beyond the limits of the field."""
    found = [float(round(value)) if isinstance(one.held, Whole) else float(value) for value in values]
    limits = one.held
    bad = [value for value in found if isinstance(limits, Measure) and not limits.allows(value)]
    if isinstance(limits, Whole):
        bad = [value for value in found if not limits.low <= value <= limits.high]
    if bad:
        said = limits.limits() if isinstance(limits, Measure) else f"{limits.low} to {limits.high}"
        what = f"{len(bad)} of {len(found)} samples are beyond the limits of {one.paths[0]}"
        by.tell(("vary", one.name, ""), Refused(what, f"{bad[0]:.6g} {one.unit}", said, "cut the distribution off with from and to"))
    return [] if bad else list(found)


def single(plan: Plan, one: Any, k: int, by: Reading) -> tuple[Number, ...] | None:
    """A member given by itself: a value for each parameter."""
    if not isinstance(one, dict):
        by.tell(("point", k), Refused(f"this is {kind_of(one)}", shown(one), "a table of values by name", "write one"))
        return None
    names = [parameter.name for parameter in plan.parameters]
    before = len(by.refused)
    for name in one:
        if name not in names:
            by.tell(("point", k, name), Refused("no parameter is called so", shown(one[name]), "", suggestion(name, names, "name one")))
    found = []
    for parameter in plan.parameters:
        if parameter.name not in one:
            by.tell(("point", k, parameter.name), Refused("a point has a value for each parameter", "", ", ".join(names), "add it"))
        else:
            found.append(number(one[parameter.name], parameter.held, ("point", k, parameter.name), by))
    return None if len(by.refused) > before else tuple(value for value in found if value is not None)
