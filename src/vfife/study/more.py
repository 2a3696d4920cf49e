"""Members added to a study that is there: values of a parameter, points one by one, more samples; and a study taken up from its file alone."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import VfifeError, shown, suggestion
from ..laws import ContactLaw, FrictionLaw
from ..model.mechanism import Mechanism
from ..modelfile import loads
from ..modelfile.override import parsed
from ..results.studied import Study
from .carry import asked_of
from .plan import Parameter, Plan
from .planfile import Written, understood
from .varied import number


def split(text: str, what: str) -> list[tuple[str, str]]:
    """Names and values of ``name=value,value,name=value``. Raises ValueError."""
    found: list[tuple[str, str]] = []
    for part in text.split(","):
        name, sign, value = part.partition("=")
        if sign:
            found.append((name.strip(), value.strip()))
        elif found:
            found[-1] = (found[-1][0], f"{found[-1][1]},{part.strip()}")
        else:
            raise ValueError(f'{what} {text}: this is not NAME=VALUE; write it as in play="0.3 mm, 0.4 mm"')
    return found


def added(
    path: Path, values: Mapping[str, Any], points: Sequence[Mapping[str, Any]] = (), count: int | None = None
) -> tuple[Plan, Mechanism, dict[str, Any]]:
    """The plan of a study file with what is added, the model, and what the file is to say. Raises ModelError with all faults, VfifeError."""
    found = Study.open(path)
    base = base_of(found)
    raw = copy.deepcopy(found.asked["raw"])
    before, _ = understood(raw, str(path), base=base)
    for name, more in values.items():
        listed = [parsed(one.strip()) for one in more.split(",")] if isinstance(more, str) else list(more)
        extend(raw, next(one for one in before.parameters if one.name == found.parameter(name).name), listed, str(path))
    if points:
        own = [{found.parameter(name).name: parsed(one) if isinstance(one, str) else one for name, one in point.items()} for point in points]
        raw["point"] = [*raw.get("point", []), *own]
    if count is not None:
        if count < (drawn := before.asked.count or 0):
            raise VfifeError(f"{path}: {drawn:,} samples are asked for already, and --count {count} says how many there shall be in all; give more")
        raw["count"] = count
    plan, base = understood(raw, str(path), base=base)
    return plan, base, asked_of(plan, base, found.name)


def extend(raw: dict[str, Any], one: Parameter, more: list[Any], where: str) -> None:
    """Adds values to a parameter, which has them one by one from then on. Raises VfifeError for one of which samples are taken."""
    if one.values is None:
        raise VfifeError(f"{where}: samples are taken of {one.name}; add some with --count, or single members with --point")
    had = list(one.values)
    new = [value for value in more if number(value, one.held, ("vary", one.name, "values"), Written()) not in had]
    raw["vary"][one.name] = {"path": list(one.paths), "values": [*had, *new]}


def base_of(found: Study) -> Mechanism:
    """The model of a study, from the text in its file. Raises VfifeError where a law of the user's own is not at hand."""
    unknown = [law for law in found.asked["own_laws"] if law["name"] not in (ContactLaw if law["kind"] == "contact" else FrictionLaw).registry]
    if unknown:
        names = ", ".join(law["name"] for law in unknown)
        remedy = suggestion(names, [], f"give the file that defines it: --laws {unknown[0]['file']}")
        raise VfifeError(f"{found.path}: its model uses the law {shown(names)} of your own, which is not known here; {remedy}")
    base = loads(found.asked["text"])
    base.source = found.asked["source"]
    return base
