"""Rows of a comparison: numbers of a run over its joints, with ranges where errors were estimated."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ...measures.catalogue import is_ideal_zero
from ...measures.values import Measured
from ...simulation.result import Result

PER_JOINT = "force.max", "penetration.max", "impacts", "grazing", "deep_landings", "share.continuous_contact"


def row_of(result: Result, joints: Sequence[str]) -> dict[str, Any]:
    """Return the row of a run in the table of a comparison."""
    measures, joint = result.measures, result.record.assembly.mechanism.clearances[joints[0]]
    by_joint: dict[str, dict[str, Any]] = {}
    for name in joints:
        numbers: dict[str, Measured | None] = {
            key: measures[f"{name}.{key}"] for key in PER_JOINT if f"{name}.{key}" in measures
        }
        by_joint[name] = {**numbers, "lip_force": influence_on(result, f"{name}.force")}
    ledger, rows = result.ledger, by_joint.values()
    bodies = [key.removesuffix(".lip") for key in measures if key.endswith(".angular_acceleration.lip")]
    accelerations = [value for body in bodies if (value := influence_on(result, body)) is not None]
    forces = [row["lip_force"] for row in rows if row["lip_force"] is not None]
    shares = [row["share.continuous_contact"] for row in rows]
    numbers = {
        "force": over_joints(max, [row["force.max"] for row in rows]),
        "lip_force": over_joints(max, forces),
        "lip_acceleration": over_joints(max, accelerations),
        "penetration": over_joints(max, [row["penetration.max"] for row in rows]),
        "impacts": over_joints(sum, [row["impacts"] for row in rows]),
        "contact_share": over_joints(lambda values: sum(values) / len(by_joint), shares),
    }
    return {
        "contact": joint.contact.name,
        "friction": joint.friction.name,
        "status": result.record.status,
        "part": measures.part,
        **with_ranges(numbers),
        "impacts": int(sum(row["impacts"] for row in rows)),
        "energy_lost": float(ledger.terms["contact_loss"][-1] + ledger.terms["friction_loss"][-1]),
        "energy_error": ledger.error,
        "wall_s": result.record.wall,
        "joints": {name: with_ranges(numbers) for name, numbers in by_joint.items()},
    }


def influence_on(result: Result, name: str) -> Measured | None:
    """Return the influence of clearances on a force or acceleration; None without one, and where that of the
    ideal mechanism is rounding.
    """
    measures, ideal = result.measures, result.reference.measures if result.reference else {}
    ending = f".{name.rpartition('.')[2]}.max"
    sizes = [value for numbers in (measures, ideal) for key, value in numbers.items() if key.endswith(ending)]
    zero = is_ideal_zero(ideal.get(f"{name}.max", 0.0), sizes)
    return None if zero else measures.get(f"{name}.lip")


def over_joints(function: Callable[[Sequence[float]], float], values: Sequence[Measured]) -> Measured | None:
    """Return a function of the numbers of several joints, which grows with each of them, with the range by
    their ranges; None without any number.
    """
    if not values:
        return None
    low, high = (function([getattr(value, end) for value in values]) for end in ("low", "high"))
    estimated = all(value.estimated for value in values)
    return Measured(function([value.value for value in values]), low, high, estimated=estimated)


def with_ranges(numbers: Mapping[str, Measured | None]) -> dict[str, float | None]:
    """Return plain numbers, each followed by the ends of its range if its error was estimated."""
    plain: dict[str, float | None] = {}
    for name, measured in numbers.items():
        plain[name] = None if measured is None else measured.value
        if measured is not None and measured.estimated:
            plain |= {f"{name}.low": measured.low, f"{name}.high": measured.high}
    return plain
