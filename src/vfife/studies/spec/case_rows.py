"""The cases of a study: grids, pairs, samples of distributions, and single points."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

from ...errors import Fault, kind_of, shown, suggestion
from ...schema import Integer, Measure, Reader
from .distributions import points
from .parameters import read_value
from .plan import GRIDS, MOST_CASES, SEARCH, Number, Plan, StudyParameter

Row = tuple[Number, ...]  # values of a case, in the order of the parameters


def with_cases(plan: Plan, extra: Any, by: Reader) -> Plan:
    """Return the plan with its cases; ``extra`` are further ones, as tables of values by name."""
    if not isinstance(extra, list):
        by.refuse(("point",), f"this is {kind_of(extra)}", shown(extra), "tables [[point]]", "write them so")
        extra = []
    singles = tuple(
        point for k, one in enumerate(extra) if (point := read_point(plan, one, k, by)) is not None
    )
    rows = case_rows(plan, by)
    return dataclasses.replace(
        plan, points=singles, cases=() if rows is None else tuple(dict.fromkeys((*rows, *singles)))
    )


def case_rows(plan: Plan, by: Reader) -> list[Row] | None:
    """Return the values of every case but the single points; None where there cannot be any."""
    method, count = plan.spec.method, plan.spec.count
    free = [one for one in plan.parameters if one.values is None]
    if method == SEARCH:
        return []
    if method in GRIDS:
        for one in free:
            what = f"a {method} takes values, and {one.name} has {described_distribution(one)}"
            remedy = 'list its values, give from, to and count, or take samples: method = "sobol" and count'
            by.refuse(("vary", one.name, ""), what, "", "", remedy)
        if count is not None:
            remedy = "remove it, or name another method"
            by.refuse(("count",), f"a {method} takes no samples", str(count), "", remedy)
        if free or count is not None:
            return None
        return paired_rows(plan, by) if method == "list" else grid_rows(plan, [()], by)
    if not free:
        remedy = 'give a number from and to, or mean and deviation, or set method = "grid"'
        what = "there is nothing to take samples of: every parameter has values"
        by.refuse(("method",), what, f'"{method}"', "", remedy)
    if count is None:
        by.refuse(("count",), "this key is missing", "", "number of samples", "add it, as in count = 256")
    if not free or count is None or too_many(plan, count, by):
        return None
    try:
        samples = sample_rows(free, method, count, plan.spec.seed, by)
    except Fault as fault:
        by.add(fault.at(("method",)))
        return None
    return grid_rows(plan, samples, by) if samples else None


def described_distribution(one: StudyParameter) -> str:
    """Return a description of the distribution of a parameter without values."""
    return (
        "a range"
        if one.kind == "uniform"
        else f"the fit {one.words}"
        if one.kind == "fit"
        else f"a {one.kind} distribution"
    )


def too_many(plan: Plan, samples: int, by: Reader) -> bool:
    """Refuse a number of cases that cannot be meant, before any is made."""
    sizes = [len(one.values) for one in plan.parameters if one.values is not None] + (
        [samples] if samples > 1 else []
    )
    count = math.prod(sizes)
    if count <= MOST_CASES:
        return False
    product = " x ".join(f"{size:,}" for size in sizes)
    remedy = "give fewer values, or take samples"
    by.refuse(("vary", ""), f"{product} = {count:,} cases", "", f"at most {MOST_CASES:,}", remedy)
    return True


def grid_rows(plan: Plan, samples: list[Row], by: Reader) -> list[Row] | None:
    """Combine all values of all parameters, and these with every sample of the parameters with
    distributions.
    """
    if too_many(plan, len(samples), by):
        return None
    axes = [one.values for one in plan.parameters if one.values is not None]
    rows = []
    for values, sample in itertools.product(itertools.product(*axes), samples):
        listed, drawn = iter(values), iter(sample)
        rows.append(tuple(next(drawn if one.values is None else listed) for one in plan.parameters))
    return rows


def paired_rows(plan: Plan, by: Reader) -> list[Row] | None:
    """Combine the k-th values of all parameters."""
    lists = [one.values or () for one in plan.parameters]
    if len({len(one) for one in lists}) > 1:
        sizes = ", ".join(
            f"{one.name} {len(values)}" for one, values in zip(plan.parameters, lists, strict=True)
        )
        what = "lists that go together are of different lengths"
        by.refuse(("vary", ""), what, sizes, "one length", 'complete them, or set method = "grid"')
        return None
    return list(zip(*lists, strict=True))


def sample_rows(
    parameters: list[StudyParameter], method: str, count: int, seed: int, by: Reader
) -> list[Row]:
    """Return the samples of parameters in the order of the method, a row for each draw; none if one is
    refused.

    Raises Fault for an impossible method or count.
    """
    drawn = points(
        [one.distribution for one in parameters if one.distribution is not None], method, count, seed
    )
    columns = [within_limits(one, drawn[:, k].tolist(), by) for k, one in enumerate(parameters)]
    return list(zip(*columns, strict=True)) if all(columns) else []


def within_limits(one: StudyParameter, values: list[float], by: Reader) -> list[Number]:
    """Return samples as the model takes them; none, with a fault, if some violate the limits of the field."""
    field, limits, beyond = one.field, "", list[float]()
    if isinstance(field, Integer):
        values = [float(round(value)) for value in values]
        limits = f"{field.low} to {field.high}"
        beyond = [value for value in values if not field.low <= value <= field.high]
    elif isinstance(field, Measure):
        limits, beyond = field.limits(), [value for value in values if not field.allows(value)]
    if beyond:
        what = f"{len(beyond)} of {len(values)} samples are beyond the limits of {one.paths[0]}"
        remedy = "cut the distribution off with from and to"
        by.refuse(("vary", one.name, ""), what, f"{beyond[0]:.6g} {one.unit}", limits, remedy)
    return [] if beyond else list(values)


def read_point(plan: Plan, table: Any, k: int, by: Reader) -> Row | None:
    """Read a single case: a value for each parameter by its name."""
    if not isinstance(table, dict):
        by.refuse(
            ("point", k), f"this is {kind_of(table)}", shown(table), "a table of values by name", "write one"
        )
        return None
    names, before = [one.name for one in plan.parameters], len(by.faults)
    for name in table:
        if name not in names:
            remedy = suggestion(name, names, "name one")
            by.refuse(("point", k, name), "no parameter is called so", shown(table[name]), "", remedy)
    values = []
    for one in plan.parameters:
        if one.name in table:
            values.append(read_value(table[one.name], one.field, ("point", k, one.name), by))
        else:
            what = "a point has a value for each parameter"
            by.refuse(("point", k, one.name), what, "", ", ".join(names), "add it")
    return None if len(by.faults) > before else tuple(value for value in values if value is not None)
