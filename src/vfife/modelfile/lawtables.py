"""Law tables: any law of the registry, its keys and limits taken from the law itself."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

from pydantic_core import PydanticCustomError

from ..errors import Fault, Path, kind_of, place, shown, suggestion
from ..laws import ContactLaw, FrictionLaw, Law, Pair
from ..model.joints import ClearanceRevolute
from ..model.readers import Choice, Measure, refuse
from .tables import LAWS, Raw, law_fields

DEFAULTS: dict[str, Any] = {field.name: field.default_factory for field in dataclasses.fields(ClearanceRevolute) if field.name in LAWS}
# A unit such as N/m^n is known only once the law has its exponent: such a parameter is a bare number in SI units.
SYMBOLIC = re.compile(r"\^\(?-?[a-z]")


def read_law(kind: str, holder: Raw, path: Path, given: set[Path]) -> tuple[Law | None, list[Fault]]:
    """The law of a table [joint.NAME.contact] or [joint.NAME.friction], or the faults in it."""
    registry = LAWS[kind].known()
    name = holder.get("law", DEFAULTS[kind].name)
    if not isinstance(name, str) or name not in registry:
        remedy = suggestion(str(name), registry, f"name a {kind} law, and with --laws the file of one of your own")
        return None, [Fault(place((*path, "law"), given), f"no {kind} law is called so", shown(name), "", remedy)]
    law, faults, values = registry[name], [], {}
    fields = {field.name: field for field in dataclasses.fields(law)}
    for key, value in holder.items():
        where = place((*path, key), given)
        if key in fields:
            try:
                values[key] = read_field(fields[key], value)
            except PydanticCustomError as error:
                ctx = error.context or {}
                faults.append(Fault(where, ctx["what"], ctx["value"], ctx["limit"], ctx["remedy"]))
        elif key != "law":
            remedy = suggestion(key, fields, f'remove it, or name another law than "{name}"')
            faults.append(Fault(where, "unknown key", shown(value), "", remedy))
    lacks = f'the law "{name}" needs this key, which is missing'
    faults += [
        Fault(place((*path, key), given), lacks, "", needs(field), "add it")
        for key, field in fields.items()
        if key not in holder and field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
    ]
    faults += speeds_in_order(law, values, path, given)
    if faults:
        return None, faults
    try:
        return law(**values), []
    except (ArithmeticError, TypeError, ValueError) as error:
        return None, [Fault(place((*path, ""), given), f'the law "{name}" refuses these parameters: {error}')]


def read_field(field: dataclasses.Field[Any], value: Any) -> Any:
    """A parameter of a law, by its unit and limits, or a text or a switch where its default or its type is one."""
    wanted = bool if field.type in (bool, "bool") else str if field.type in (str, "str") else type(field.default)
    if wanted not in (bool, str):
        unit = field.metadata.get("unit", "1")
        if SYMBOLIC.search(unit):
            unit = "1"
        above, low, high = (field.metadata.get(limit) for limit in ("above", "low", "high"))
        return Measure(unit, above=above, low=low, high=high).read(value)
    if choices := field.metadata.get("choices"):
        return Choice(tuple(choices)).read(value)
    if not isinstance(value, wanted):
        raise refuse(value, kind_of(value), kind_of(wanted()), f"write {kind_of(wanted())}")
    return value


def needs(field: dataclasses.Field[Any]) -> str:
    """Meaning and unit of a parameter."""
    meaning, unit = field.metadata.get("meaning", ""), field.metadata.get("unit", "1")
    return f"{meaning} in {unit}" if unit != "1" else str(meaning)


def speeds_in_order(law: type[Law], values: Raw, path: Path, given: set[Path]) -> list[Fault]:
    """A ramp of friction between v0 and v1 has to rise."""
    if not {"v0", "v1"} <= set(law_fields(law)):
        return []
    whole: Raw = {field.name: field.default for field in dataclasses.fields(law)} | values
    if whole["v1"] > whole["v0"]:
        return []
    what, limit = "friction would have no ramp between v0 and v1", f"above v0 = {whole['v0']:g} m/s"
    return [Fault(place((*path, "v1"), given), what, f"{whole['v1']:g}", limit, "raise v1 or lower v0")]


def law_or_default(kind: str, holder: Raw) -> Any:
    """The law of a table that has no faults."""
    return read_law(kind, holder, (), set())[0]


def senseless(law: Law, pair: Pair) -> str:
    """What a law cannot make of these two surfaces, or nothing: its numbers must be real and finite."""
    try:
        values = [float(value) for value in law.parameters(pair)]
    except ValueError as error:  # the law's own sentence, if it has one
        if law.name in str(error):
            return str(error)
        values = [float("nan")]
    except (ArithmeticError, TypeError):
        values = [float("nan")]
    if all(abs(value) < float("inf") for value in values):
        return ""
    kind = "contact" if isinstance(law, ContactLaw) else "friction" if isinstance(law, FrictionLaw) else ""
    return f'the {kind} law "{law.name}" gives no finite numbers for these surfaces'
