"""Parameters of a study, read from the tables under ``[vary]``: paths of the model, unit, values or their
distribution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ...errors import Fault, Path, shown
from ...model.mechanism import Mechanism
from ...modelfile.parameter import NO_NUMBER, Parameter
from ...numerics.scalar import power
from ...schema import Choice, Integer, Measure, Reader, Value
from .distributions import Distribution, Normal, Truncated, Uniform, of_fit, of_tolerance, of_zone
from .iso286 import ZONE
from .plan import Number, StudyParameter, VaryTable

KINDS = {  # keys of each kind of table
    "values": ("values",),
    "range": ("low", "high"),
    "normal": ("mean", "deviation"),
    "fit": ("fit", "diameter"),
    "tolerance": ("nominal", "tolerance"),
}
ALLOWED = (
    "values, or from and to, or mean and deviation (with from and to it is cut off), or fit and diameter, or"
    " nominal and tolerance"
)
# Keys of numbers in a file by their fields, and the key at which the distribution of a kind is refused.
FILE_KEYS = {"low": "from", "high": "to", "mean": "mean", "deviation": "deviation", "nominal": "nominal"}
FAULTY = {"fit": "fit", "range": "to", "normal": "mean", "tolerance": "tolerance"}
AT_TOP = "set {} at the top of the study"
RUN_KEYS = {  # numbers of the run that a study sets itself, and what to do instead
    "turns": AT_TOP.format("turns"), "duration": AT_TOP.format("turns"), "settle": AT_TOP.format("settle"),
    "companions": "a study takes none", "analysis": "cases turn a crank",
}  # fmt: skip


def read_parameters(
    tables: Mapping[str, VaryTable], model: Mechanism | None, reader: Reader, paired: bool = False
) -> list[StudyParameter]:
    """Read the parameters, none without a model; those with faults are left out. ``paired``: the values of
    one go with those of the others.
    """
    parameters, owners = [], dict[str, str]()
    for name, table in tables.items():
        if model is None or table.path is None:
            continue
        field, paths = read_paths(("vary", name, "path"), table.path, model, reader)
        for path in paths:
            if path in owners:
                message = f"{path} is varied by {owners[path]} already"
                reader.refuse(
                    ("vary", name, "path"), message, "", "one name for each number", "remove one of them"
                )
            owners[path] = name
        if field is None:
            continue
        if (parameter := read_parameter(name, table, field, paths, reader, paired)) is not None:
            parameters.append(parameter)
    return parameters


def read_paths(
    place: Path, texts: tuple[str, ...], model: Mechanism, reader: Reader
) -> tuple[Value | None, tuple[str, ...]]:
    """Return the field of the numbers at some paths, None where they have none in common, and the paths in
    full.
    """
    fields: list[tuple[str, Value]] = []
    for text in texts:
        try:
            parameter = Parameter(model, text)
            if (misfit := parameter.misfit) is not None:
                raise misfit
        except Fault as fault:
            reader.add(fault.at(place, value=shown(text)))
            continue
        if parameter.keys[0] == "run" and parameter.keys[-1] in RUN_KEYS:
            remedy = f"remove it: {RUN_KEYS[str(parameter.keys[-1])]}"
            reader.refuse(place, "the study file sets this for all cases", shown(text), "", remedy)
        elif isinstance(parameter.field, Measure | Integer | Choice):
            fields.append((parameter.path, parameter.field))
        else:
            kind = "what stands there is of a kind that has no such number"
            kind = kind if len(parameter.keys) > 2 else "a table, not a number of the model, is there"
            message = kind if parameter.field is None else "this number cannot be varied"
            reader.refuse(place, message, shown(text), "", NO_NUMBER)
    paths, kinds = tuple(path for path, _ in fields), {(type(field), unit_of(field)) for _, field in fields}
    if len(fields) < len(texts):
        return None, paths
    if len(kinds) > 1:
        units = ", ".join(f"{path} in {unit_of(field)}" for path, field in fields)
        message = "numbers of different kinds cannot be the same"
        reader.refuse(place, message, units, "one unit", "vary them under names of their own")
        return None, paths
    return fields[0][1], paths


def unit_of(field: Value) -> str:
    """Return the unit of a field."""
    return field.unit if isinstance(field, Measure) else "1"


def read_parameter(
    name: str, table: VaryTable, field: Value, paths: tuple[str, ...], reader: Reader, paired: bool = False
) -> StudyParameter | None:
    """Read a parameter; None where something of it was refused. ``paired``: its values go with those of
    others.
    """
    place, fault_count, unit = ("vary", name), len(reader.faults), unit_of(field)
    kind = kind_of_table(table, place, reader)
    numbers: dict[str, Any] = {
        key: read_value(value, field, (*place, FILE_KEYS[key]), reader)
        for key in FILE_KEYS
        if (value := getattr(table, key)) is not None
    }
    if isinstance(numbers.get("deviation"), float) and numbers["deviation"] <= 0.0:
        limit = "a deviation above 0"
        reader.refuse((*place, "deviation"), "zero or negative", shown(table.deviation), limit, "correct it")
    values = None if table.values is None else read_values(table.values, field, place, reader, paired)
    if kind is None or len(reader.faults) > fault_count:
        return None
    if isinstance(field, Choice) and values is None:
        limit = " or ".join(field.options[:8])
        reader.refuse((*place, "values"), "words have no range", "", limit, "list them as values")
        return None
    distribution = None
    try:
        check_ends(table, numbers)
        if kind == "range" and table.count is not None:
            values = range_values(table, numbers, field)
        elif values is None:
            distribution = distribution_of(table, kind, numbers, unit)
            if kind in ("range", "normal"):
                kind = {Uniform: "uniform", Truncated: "truncated"}.get(type(distribution), kind)
    except Fault as fault:
        reader.add(fault.at((*place, FAULTY[kind])))
        return None
    return StudyParameter(
        name, paths, unit, kind, f"{table.fit}" if kind == "fit" else "", values, distribution, field
    )


def kind_of_table(table: VaryTable, place: Path, reader: Reader) -> str | None:
    """Return the kind of values that a table has; None where it has none, two or part of one."""
    kinds = [kind for kind, keys in KINDS.items() if any(getattr(table, key) is not None for key in keys)]
    if "normal" in kinds and "range" in kinds:
        kinds.remove("range")
    if len(kinds) != 1:
        message = f"{' and '.join(kinds)} exclude each other" if kinds else "its values are missing"
        reader.refuse((*place, ""), message, "", ALLOWED, "give one of these")
        return None
    (kind,) = kinds
    missing = [FILE_KEYS.get(key, key) for key in KINDS[kind] if getattr(table, key) is None]
    for key in missing:
        reader.refuse((*place, key), "this key is missing", "", ALLOWED, "add it")
    for key in ("count", "spacing"):
        if kind != "range" and getattr(table, key) not in (None, "linear"):
            reader.refuse(
                (*place, key), "only a range is cut into values", shown(getattr(table, key)), "", "remove it"
            )
    return None if missing else kind


def read_value(value: Any, field: Value, place: Path, reader: Reader) -> Number | None:
    """Read a value in SI units as the model's field takes it; a word where the field takes words.

    A deviation has the unit of the field but not its limits; words that stand for a number are no ends of a
    range.
    """
    if isinstance(field, Measure) and place[-1] == "deviation":
        field = Measure(field.unit)
    elif isinstance(field, Measure) and place[-1] in ("from", "to", "mean") and isinstance(value, str):
        field = Measure(field.unit, field.above, field.low, field.high)
    read: Any = field.read(value, place, reader)
    return read if read is None or isinstance(read, str) else float(read)


def read_values(
    values: tuple[Any, ...], field: Value, place: Path, reader: Reader, paired: bool
) -> tuple[Number, ...]:
    """Read values that are listed one by one. Each may come once unless they are ``paired`` with those of
    other parameters.
    """
    read = [read_value(value, field, (*place, "values", k), reader) for k, value in enumerate(values)]
    repeated = next((k for k, value in enumerate(read) if value is not None and value in read[:k]), None)
    if repeated is not None and not paired:
        message = "the same value twice"
        reader.refuse(
            (*place, "values", repeated), message, shown(values[repeated]), "each value once", "remove it"
        )
    if not read:
        reader.refuse((*place, "values"), "an empty list", "[]", "one value or more", "add values")
    return tuple(value for value in read if value is not None)


def check_ends(table: VaryTable, numbers: Mapping[str, Any]) -> None:
    """Raise Fault where the ends of a range are not in order."""
    low, high = numbers.get("low"), numbers.get("high")
    if low is not None and high is not None and not low < high:
        remedy = "exchange them, or correct one"
        raise Fault("", "not above from", shown(table.high), f"above {shown(table.low)}", remedy)


def range_values(table: VaryTable, numbers: Mapping[str, Any], field: Value) -> tuple[Number, ...]:
    """Return the values that a range is cut into, its ends among them. Raises Fault for a logarithmic range
    that does not begin above 0.
    """
    low, high, count = numbers["low"], numbers["high"], table.count or 2
    if table.spacing == "linear":
        values = [low + (high - low) * k / (count - 1) for k in range(count - 1)]
    elif low > 0.0:
        values = [low * power(high / low, k / (count - 1)) for k in range(count - 1)]
    else:
        remedy = 'set spacing = "linear", or correct from'
        raise Fault("", "a logarithmic range begins above 0", f"{low:g}", "a from above 0", remedy)
    values.append(high)
    return tuple(sorted({float(round(value)) for value in values}) if isinstance(field, Integer) else values)


def distribution_of(table: VaryTable, kind: str, numbers: Mapping[str, Any], unit: str) -> Distribution:
    """Return the distribution of a table. Raises Fault."""
    low, high = numbers.get("low"), numbers.get("high")
    if kind == "range":
        if table.spacing == "logarithmic":
            raise Fault(
                "", "samples of a range are spread evenly", "", "", "give count as well, or leave spacing out"
            )
        return Uniform(numbers["low"], numbers["high"])
    if kind == "fit":
        if unit != "m":
            message = f"a fit gives a clearance in m, but this number is in {unit}"
            raise Fault("", message, "", "a path of a clearance", "name one")
        return of_fit(f"{table.fit}", float(table.diameter or 0.0), cut=table.cut)
    if kind == "tolerance":
        return tolerance_distribution(numbers["nominal"], table.tolerance, unit)
    if low is None and high is None:
        return Normal(numbers["mean"], numbers["deviation"])
    ends = (-math.inf if low is None else low, math.inf if high is None else high)
    return Truncated(numbers["mean"], numbers["deviation"], *ends)


def tolerance_distribution(nominal: float, tolerance: tuple[Any, ...], unit: str) -> Distribution:
    """Return the distribution of a size with a tolerance. Raises Fault."""
    if len(tolerance) == 1 and isinstance(tolerance[0], str) and ZONE.fullmatch(tolerance[0].strip()):
        if unit != "m":
            message = f"a zone of ISO 286 applies to lengths, but this number is in {unit}"
            raise Fault("", message, shown(tolerance[0]), "", "give both deviations")
        return of_zone(tolerance[0].strip(), nominal)
    if len(tolerance) > 2:
        remedy = "give the lower and the upper deviation"
        raise Fault("", "a tolerance has one size or two", shown(tolerance), "", remedy)
    sizes = [Measure(unit).take(size, True) for size in tolerance]
    return of_tolerance(nominal, *((-abs(sizes[0]), abs(sizes[0])) if len(sizes) == 1 else sizes))
