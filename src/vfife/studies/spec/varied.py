"""What is varied, understood by the model: where its numbers are, in which unit, which values they take."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from ...errors import Fault, Path, shown
from ...model.mechanism import Mechanism
from ...modelfile.parameter import NO_NUMBER
from ...modelfile.parameter import Parameter as ModelParameter
from ...numerics.scalar import power
from ...schema import Choice, Measure, Reading, Value, Whole
from .plan import Number, Parameter, Varied
from .sampling import Distribution, Normal, Truncated, Uniform, of_fit, of_tolerance, of_zone

ZONE = re.compile(r"[A-Za-z]{1,2}[0-9]{1,2}")
WAYS = {
    "values": ("values",),
    "range": ("low", "high"),
    "normal": ("mean", "deviation"),
    "fit": ("fit", "diameter"),
    "tolerance": ("nominal", "tolerance"),
}
SAID = {
    "turns": "set turns at the top of the study", "duration": "set turns at the top of the study", "settle": "set settle at the top of the study",
    "companions": "a study takes none", "analysis": "members turn a crank",
}  # fmt: skip
ALLOWED = (
    "values, or from and to, or mean and deviation (with from and to it is cut off), or fit and diameter, or"
    " nominal and tolerance"
)


def parameters(varied: Mapping[str, Varied], model: Mechanism | None, by: Reading) -> list[Parameter]:
    """The parameters, as far as they can be understood; without a model none."""
    found, owners = [], dict[str, str]()
    for name, one in varied.items():
        if model is None or one.path is None:
            continue
        held, paths = places(("vary", name, "path"), one.path, model, by)
        for path in paths:
            if path in owners:
                what = f"{path} is varied by {owners[path]} already"
                by.refuse(("vary", name, "path"), what, "", "one name for each number", "remove one of them")
            owners[path] = name
        if held is not None and (parameter := understood(name, one, held, paths, by)) is not None:
            found.append(parameter)
    return found


def places(
    where: Path, texts: tuple[str, ...], model: Mechanism, by: Reading
) -> tuple[Value | None, tuple[str, ...]]:
    """What the numbers at some paths may be, and the paths in full; None where they do not agree, or lead
    nowhere.
    """
    found: list[tuple[str, Value]] = []
    for text in texts:
        try:
            one = ModelParameter(model, text)
        except Fault as fault:
            by.add(fault.at(where, value=shown(text)))
            continue
        if one.keys[0] == "run" and one.keys[-1] in SAID:
            remedy = f"remove it: {SAID[str(one.keys[-1])]}"
            by.refuse(where, "the study says this itself, for all members", shown(text), "", remedy)
            continue
        held = one.field
        if not isinstance(held, Measure | Whole | Choice):
            kind = "what stands there is of a kind that has no such number"
            kind = kind if len(one.keys) > 2 else "a table, not a number of the model, is there"
            what = kind if held is None else "this is no number that can be varied"
            by.refuse(where, what, shown(text), "", NO_NUMBER)
            continue
        found.append((one.path, held))
    if len(found) < len(texts):
        return None, tuple(path for path, _ in found)
    kinds = {(type(held), unit_of(held)) for _, held in found}
    if len(kinds) > 1:
        units = ", ".join(f"{path} in {unit_of(held)}" for path, held in found)
        by.refuse(
            where,
            "numbers of different kinds cannot be the same",
            units,
            "one unit",
            "vary them under names of their own",
        )
        return None, tuple(path for path, _ in found)
    return found[0][1], tuple(path for path, _ in found)


def unit_of(held: Value) -> str:
    """The unit of what is varied."""
    return held.unit if isinstance(held, Measure) else "1"


def understood(name: str, one: Varied, held: Value, paths: tuple[str, ...], by: Reading) -> Parameter | None:
    """A parameter; None where something of it was refused."""
    where, before = ("vary", name), len(by.faults)
    way = way_of(one, where, by)
    numbers = {
        key: number(getattr(one, key), held, (*where, file_key), by)
        for key, file_key in KEYS.items()
        if getattr(one, key) is not None
    }
    if "deviation" in numbers and isinstance(numbers["deviation"], float) and numbers["deviation"] <= 0.0:
        by.refuse(
            (*where, "deviation"),
            "zero or negative",
            shown(one.deviation),
            "a deviation above 0",
            "correct it",
        )
    if one.values is not None:
        listed = [number(value, held, (*where, "values", k), by) for k, value in enumerate(one.values)]
        twice = next((k for k, value in enumerate(listed) if value is not None and value in listed[:k]), None)
        if twice is not None:
            by.refuse(
                (*where, "values", twice),
                "the same value twice",
                shown(one.values[twice]),
                "each value once",
                "remove it",
            )
        if not listed:
            by.refuse((*where, "values"), "an empty list", "[]", "one value or more", "add values")
    if way is None or len(by.faults) > before:
        return None
    if one.values is not None:
        return Parameter(
            name,
            paths,
            unit_of(held),
            "values",
            "",
            tuple(value for value in listed if value is not None),
            None,
            held,
        )
    if isinstance(held, Choice):
        by.refuse(
            (*where, "values"),
            "words have no range",
            "",
            " or ".join(held.options[:8]),
            "list them as values",
        )
        return None
    try:
        return spread_out(name, one, way, numbers, held, paths)
    except Fault as refused:
        by.add(refused.at((*where, FAULTY[way])))
        return None


KEYS = {"low": "from", "high": "to", "mean": "mean", "deviation": "deviation", "nominal": "nominal"}
FAULTY = {
    "fit": "fit",
    "range": "to",
    "normal": "mean",
    "tolerance": "tolerance",
}  # the key at which a distribution is refused


def way_of(one: Varied, where: Path, by: Reading) -> str | None:
    """How the values are given; None where that is not said, said twice or in part."""
    given = [way for way, keys in WAYS.items() if any(getattr(one, key) is not None for key in keys)]
    if "normal" in given and "range" in given:
        given.remove("range")
    if len(given) != 1:
        what = f"{' and '.join(given)} exclude each other" if given else "nothing says which values it takes"
        by.refuse((*where, ""), what, "", ALLOWED, "give one of these")
        return None
    way = given[0]
    missing = [KEYS.get(key, key) for key in WAYS[way] if getattr(one, key) is None]
    for key in missing:
        by.refuse((*where, key), "this key is missing", "", ALLOWED, "add it")
    for key in ("count", "spacing"):
        if way != "range" and getattr(one, key) not in (None, "linear"):
            by.refuse(
                (*where, key), "only a range is cut into values", shown(getattr(one, key)), "", "remove it"
            )
    return None if missing else way


def number(value: Any, held: Value, where: Path, by: Reading) -> Number | None:
    """A value in SI units as the model's field takes it; a word where the field takes words. A deviation has
    no limits but its unit's.
    """
    if where[-1] == "deviation" and isinstance(held, Measure):
        held = Measure(held.unit)
    elif isinstance(held, Measure) and where[-1] in ("from", "to", "mean") and isinstance(value, str):
        held = Measure(held.unit, held.above, held.low, held.high)
    found: Any = held.read(value, where, by)
    return found if found is None or isinstance(found, str) else float(found)


def spread_out(
    name: str, one: Varied, way: str, numbers: Mapping[str, Any], held: Value, paths: tuple[str, ...]
) -> Parameter:
    """A parameter of a range or a distribution. Raises Fault."""
    unit = unit_of(held)
    low: Any = numbers.get("low")
    high: Any = numbers.get("high")
    if low is not None and high is not None and not low < high:
        raise Fault(
            "", "not above from", shown(one.high), f"above {shown(one.low)}", "exchange them, or correct one"
        )
    if way == "range" and one.count is not None:
        listed = cut(low, high, one.count, one.spacing)
        if isinstance(held, Whole):
            listed = sorted({float(round(value)) for value in listed})
        return Parameter(name, paths, unit, "range", "", tuple(listed), None, held)
    if way == "range" and one.spacing == "logarithmic":
        raise Fault(
            "", "samples of a range are spread evenly", "", "", "give count as well, or leave spacing out"
        )
    if way == "range":
        return Parameter(name, paths, unit, "uniform", "", None, Uniform(low, high), held)
    if way == "fit":
        if unit != "m":
            raise Fault(
                "",
                f"a fit says a clearance in m, and this is a number in {unit}",
                "",
                "a path of a clearance",
                "name one",
            )
        return Parameter(
            name,
            paths,
            unit,
            "fit",
            f"{one.fit}",
            None,
            of_fit(str(one.fit), float(one.diameter or 0.0), cut=one.cut),
            held,
        )
    if way == "tolerance":
        return Parameter(
            name, paths, unit, way, "", None, toleranced(numbers["nominal"], one.tolerance, unit), held
        )
    mean, deviation = numbers["mean"], numbers["deviation"]
    if low is None and high is None:
        return Parameter(name, paths, unit, "normal", "", None, Normal(mean, deviation), held)
    ends = (-math.inf if low is None else low, math.inf if high is None else high)
    return Parameter(name, paths, unit, "truncated", "", None, Truncated(mean, deviation, *ends), held)


def toleranced(nominal: float, given: tuple[Any, ...], unit: str) -> Distribution:
    """The distribution of a size with a tolerance. Raises Fault."""
    if len(given) == 1 and isinstance(given[0], str) and ZONE.fullmatch(given[0].strip()):
        if unit != "m":
            raise Fault(
                "",
                f"a zone of ISO 286 is one of lengths, and this is a number in {unit}",
                shown(given[0]),
                "",
                "give both deviations",
            )
        return of_zone(given[0].strip(), nominal)
    if len(given) > 2:
        raise Fault(
            "", "a tolerance has one size or two", shown(given), "", "give the lower and the upper deviation"
        )
    sizes = [Measure(unit).take(one, True) for one in given]
    return of_tolerance(nominal, *((-abs(sizes[0]), abs(sizes[0])) if len(sizes) == 1 else sizes))


def cut(low: float, high: float, count: int, spacing: str) -> list[float]:
    """Values from ``low`` to ``high``, both among them. Raises Fault for a logarithmic range that does not
    begin above 0.
    """
    if spacing == "linear":
        return [low + (high - low) * k / (count - 1) if k < count - 1 else high for k in range(count)]
    if low <= 0.0:
        raise Fault(
            "",
            "a logarithmic range begins above 0",
            f"{low:g}",
            "a from above 0",
            'set spacing = "linear", or correct from',
        )
    ratio = high / low
    return [low * power(ratio, k / (count - 1)) if k < count - 1 else high for k in range(count)]
