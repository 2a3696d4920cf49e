"""Laws by name: any law of the registry, its keys and limits taken from the law itself; for model files and for Python."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..errors import Fault, LawError, shown, suggestion
from ..fields import Field, Reading, required, value_of
from ..laws import ContactLaw, FrictionLaw, Law
from .joints import Contact

LAWS: dict[str, type[Law]] = {"contact": ContactLaw, "friction": FrictionLaw}
DEFAULTS: dict[str, Any] = {field.name: field.default_factory for field in dataclasses.fields(Contact) if field.name in LAWS}


class Parameters(Reading):
    """Reads the parameters of a law as they are written."""

    written = True


def read_law(kind: str, holder: Mapping[str, Any]) -> tuple[Law | None, list[Fault]]:
    """The law of a table [joint.NAME.contact] or [joint.NAME.friction], or its faults, by keys."""
    registry = LAWS[kind].known()
    name = holder.get("law", DEFAULTS[kind].name)
    if not isinstance(name, str) or name not in registry:
        remedy = suggestion(str(name), registry, f"name a {kind} law, and with --laws the file of one of your own")
        return None, [Fault(("law",), f"no {kind} law is called so", shown(name), "", remedy)]
    law, reading, values = registry[name], Parameters(), {}
    fields = {field.name: field for field in dataclasses.fields(law)}
    for key, value in holder.items():
        if key in fields:
            values[key] = value_of(fields[key]).read(value, (key,), reading)
        elif key != "law":
            remedy = suggestion(key, fields, f'remove it, or name another law than "{name}"')
            reading.refuse((key,), "unknown key", shown(value), "", remedy)
    for key, field in fields.items():
        if key not in holder and required(field):
            reading.refuse((key,), f'the law "{name}" needs this key, which is missing', "", needs(field), "add it")
    # Parameters that are known are compared with each other, whatever else is wrong.
    try:
        good = law(**{key: value for key, value in values.items() if value is not None})
    except LawError as error:
        known = {fault.path[0] for fault in reading.faults}
        for fault in error.faults:
            if fault.where not in known:
                reading.add(fault.at((fault.where,)))
    except (ArithmeticError, TypeError, ValueError) as error:
        if not reading.faults:
            reading.refuse(("",), f'the law "{name}" refuses these parameters: {error}')
    return (None, reading.faults) if reading.faults else (good, [])


def needs(field: Field) -> str:
    """Meaning and unit of a parameter."""
    meaning, unit = field.metadata.get("meaning", ""), field.metadata.get("unit", "1")
    return f"{meaning} in {unit}" if unit != "1" else str(meaning)
