"""The cases of a study: grids, pairs, samples of distributions, and single points."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

from ...errors import Fault, kind_of, shown, suggestion
from ...schema import Integer, Measure, Reader
from ...store.studyfile import SEARCH
from .distributions import points
from .parameters import read_value
from .plan import GRIDS, MOST_CASES, Number, Plan, StudyParameter

Row = tuple[Number, ...]  # values of a case, in the order of the parameters


def with_cases(plan: Plan, extra: Any, reader: Reader) -> Plan:
    """Return the plan with its cases; ``extra`` are further ones, as tables of values by name."""
    if not isinstance(extra, list):
        reader.refuse(
            ("point",), f"this is {kind_of(extra)}", shown(extra), "tables [[point]]", "write them so"
        )
        extra = []
    singles = tuple(
        point for k, table in enumerate(extra) if (point := read_point(plan, table, k, reader)) is not None
    )
    rows = case_rows(plan, reader)
    return dataclasses.replace(
        plan, points=singles, cases=() if rows is None else tuple(dict.fromkeys((*rows, *singles)))
    )


def case_rows(plan: Plan, reader: Reader) -> list[Row] | None:
    """Return the values of every case but the single points; None where there cannot be any."""
    method, count = plan.spec.method, plan.spec.count
    free = [parameter for parameter in plan.parameters if parameter.values is None]
    if method == SEARCH:
        return []
    if method in GRIDS:
        for parameter in free:
            message = f"a {method} takes values, and {parameter.name} has {described_distribution(parameter)}"
            remedy = 'list its values, give from, to and count, or take samples: method = "sobol" and count'
            reader.refuse(("vary", parameter.name, ""), message, "", "", remedy)
        if count is not None:
            remedy = "remove it, or name another method"
            reader.refuse(("count",), f"a {method} takes no samples", str(count), "", remedy)
        if free or count is not None:
            return None
        return paired_rows(plan, reader) if method == "list" else grid_rows(plan, [()], reader)
    if not free:
        remedy = 'give a number from and to, or mean and deviation, or set method = "grid"'
        message = "there is nothing to take samples of: every parameter has values"
        reader.refuse(("method",), message, f'"{method}"', "", remedy)
    if count is None:
        reader.refuse(("count",), "this key is missing", "", "number of samples", "add it, as in count = 256")
    if not free or count is None or too_many(plan, count, reader):
        return None
    try:
        samples = sample_rows(free, method, count, plan.spec.seed, reader)
    except Fault as fault:
        reader.add(fault.at(("method",)))
        return None
    return grid_rows(plan, samples, reader) if samples else None


def described_distribution(parameter: StudyParameter) -> str:
    """Return a description of the distribution of a parameter without values."""
    words = {"uniform": "a range", "fit": f"the fit {parameter.words}"}
    return words.get(parameter.kind, f"a {parameter.kind} distribution")


def too_many(plan: Plan, samples: int, reader: Reader) -> bool:
    """Refuse a number of cases that cannot be meant, before any is made."""
    sizes = [len(parameter.values) for parameter in plan.parameters if parameter.values is not None] + (
        [samples] if samples > 1 else []
    )
    count = math.prod(sizes)
    if count <= MOST_CASES:
        return False
    product = " x ".join(f"{size:,}" for size in sizes)
    remedy = "give fewer values, or take samples"
    reader.refuse(("vary", ""), f"{product} = {count:,} cases", "", f"at most {MOST_CASES:,}", remedy)
    return True


def grid_rows(plan: Plan, samples: list[Row], reader: Reader) -> list[Row] | None:
    """Combine all values of all parameters, and these with every sample of the parameters with
    distributions.
    """
    if too_many(plan, len(samples), reader):
        return None
    axes = [parameter.values for parameter in plan.parameters if parameter.values is not None]
    rows = []
    for values, sample in itertools.product(itertools.product(*axes), samples):
        listed, drawn = iter(values), iter(sample)
        rows.append(
            tuple(next(drawn if parameter.values is None else listed) for parameter in plan.parameters)
        )
    return rows


def paired_rows(plan: Plan, reader: Reader) -> list[Row] | None:
    """Combine the k-th values of all parameters."""
    lists = [parameter.values or () for parameter in plan.parameters]
    if len({len(values) for values in lists}) > 1:
        sizes = ", ".join(
            f"{parameter.name} {len(values)}"
            for parameter, values in zip(plan.parameters, lists, strict=True)
        )
        message = "lists that go together are of different lengths"
        reader.refuse(("vary", ""), message, sizes, "one length", 'complete them, or set method = "grid"')
        return None
    rows = list(zip(*lists, strict=True))
    repeated = next((k for k, row in enumerate(rows) if row in rows[:k]), None)
    if repeated is not None:
        numbers = ", ".join(map(shown, rows[repeated]))
        reader.refuse(("vary", ""), "the same case twice", numbers, "each case once", "remove one of them")
        return None
    return rows


def sample_rows(
    parameters: list[StudyParameter], method: str, count: int, seed: int, reader: Reader
) -> list[Row]:
    """Return the samples of parameters in the order of the method, a row for each draw; none if one is
    refused.

    Raises Fault for an impossible method or count.
    """
    drawn = points(
        [parameter.distribution for parameter in parameters if parameter.distribution is not None],
        method,
        count,
        seed,
    )
    columns = [
        within_limits(parameter, drawn[:, k].tolist(), reader) for k, parameter in enumerate(parameters)
    ]
    return list(zip(*columns, strict=True)) if all(columns) else []


def within_limits(parameter: StudyParameter, values: list[float], reader: Reader) -> list[Number]:
    """Return samples as the model takes them; none, with a fault, if some violate the limits of the field."""
    field, limits, violations = parameter.field, "", list[float]()
    if isinstance(field, Integer):
        values = [float(round(value)) for value in values]
        limits = f"{field.low} to {field.high}"
        violations = [value for value in values if not field.low <= value <= field.high]
    elif isinstance(field, Measure):
        limits, violations = field.limits(), [value for value in values if not field.allows(value)]
    if violations:
        message = f"{len(violations)} of {len(values)} samples are beyond the limits of {parameter.paths[0]}"
        remedy = "cut the distribution off with from and to"
        reader.refuse(
            ("vary", parameter.name, ""), message, f"{violations[0]:.6g} {parameter.unit}", limits, remedy
        )
    return [] if violations else list(values)


def read_point(plan: Plan, table: Any, k: int, reader: Reader) -> Row | None:
    """Read a single case: a value for each parameter by its name."""
    if not isinstance(table, dict):
        reader.refuse(
            ("point", k), f"this is {kind_of(table)}", shown(table), "a table of values by name", "write one"
        )
        return None
    names, fault_count = [parameter.name for parameter in plan.parameters], len(reader.faults)
    for name in table:
        if name not in names:
            remedy = suggestion(name, names, "name one")
            reader.refuse(("point", k, name), "there is no such parameter", shown(table[name]), "", remedy)
    values = []
    for parameter in plan.parameters:
        if parameter.name in table:
            values.append(
                read_value(table[parameter.name], parameter.field, ("point", k, parameter.name), reader)
            )
        else:
            message = "a point has a value for each parameter"
            reader.refuse(("point", k, parameter.name), message, "", ", ".join(names), "add it")
    return None if len(reader.faults) > fault_count else tuple(value for value in values if value is not None)
