"""What a study came to, in words and tables: extremes of its measures and where, values of its parameters."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from ..results.member_errors import NOT_ESTIMATED
from .digits import prefixed

if TYPE_CHECKING:
    from ..results.member_errors import MemberError
    from ..results.studied import Study
    from ..results.studyfile import StudyCase


def extremes(found: Study) -> dict[str, dict[str, Any]]:
    """Least, mean and largest value of each measure, and at which values of the parameters."""
    told = {}
    for name, unit in found.measures.items():
        values = [(float(value), one) for value, one in zip(found.values(name), found.done, strict=True) if math.isfinite(value)]
        least, largest = (min(values, key=lambda pair: pair[0]), max(values, key=lambda pair: pair[0])) if values else (None, None)
        names = [one.name for one in found.parameters]
        told[name] = {
            "unit": unit,
            "count": len(values),
            "least": None if least is None else least[0],
            "least_at": None if least is None else dict(zip(names, found.at(least[1]), strict=True)),
            "mean": math.fsum(value for value, _ in values) / len(values) if values else None,
            "largest": None if largest is None else largest[0],
            "largest_at": None if largest is None else dict(zip(names, found.at(largest[1]), strict=True)),
        }
    return told


def errors(found: Study) -> list[tuple[str, str, str, str]]:
    """Rows of the numerical error of a member: the measure, the error typically and at most, how it was estimated."""
    rows = []
    for name, unit in found.measures.items():
        if (one := found.errors.get(name)) is None:
            rows.append((name, NOT_ESTIMATED, "", ""))
        else:
            rows.append((name, quantity(one.typical, unit), quantity(one.most, unit), one.words))
    return rows


def error_words(one: MemberError | None, unit: str) -> str:
    """The numerical error of a member in a line."""
    if one is None:
        return f"Numerical error of a member: {NOT_ESTIMATED}."
    return f"Numerical error of a member: typically {quantity(one.typical, unit)}, at most {quantity(one.most, unit)} ({one.words})."


def errors_plainly(found: Study) -> dict[str, Any] | None:
    """Numerical errors of members for JSON, by measure; None where none is estimated."""
    return {name: dataclasses.asdict(one) for name, one in found.errors.items()} or None


def where(found: Study, member: StudyCase) -> str:
    """Values of a member's parameters in words."""
    return placed(found, dict(zip((one.name for one in found.parameters), found.at(member), strict=True)))


def placed(found: Study, at: dict[str, Any] | None) -> str:
    """Values of parameters in words."""
    units = {one.name: one.unit for one in found.parameters}
    return "" if at is None else ", ".join(f"{name} {quantity(value, units[name])}" for name, value in at.items())


def quantity(value: Any, unit: str) -> str:
    """A quantity with a prefix; words as they are."""
    if value is None or isinstance(value, str):
        return value or "-"
    if unit in ("1", "%") or not value or not math.isfinite(value):
        return f"{value:.6g}" + (" %" if unit == "%" else "")
    return prefixed(value, unit) if unit in ("m", "N", "Pa", "W", "J", "s") else f"{value:.5g} {unit.replace('^2', '²')}"


def said_of(values: list[Any], unit: str, kind: str, words: str) -> str:
    """Values of a parameter in words."""
    single = list(dict.fromkeys(values))
    if any(isinstance(value, str) for value in single):
        return ", ".join(map(str, single))
    if not single:
        return "-"
    low, high = quantity(min(single), unit), quantity(max(single), unit)
    named = {"fit": f"fit {words}, "}.get(kind, "" if kind in ("values", "range") else f"{kind}, ")
    return f"{named}{len(single):,} values, {low} to {high}" if len(single) > 1 else low
