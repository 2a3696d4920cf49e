"""What a model amounts to: bodies, joints and laws as they will be calculated, in plain numbers (SI)."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..joints import Joint


def bodies(assembly: Assembly) -> list[dict[str, Any]]:
    """Model, mass (kg), inertia about the centre of mass (kg m^2) and centre of mass (m) of each body."""
    drivers = assembly.mechanism.drivers
    return [
        {
            "name": name,
            "model": where.model,
            "elements": len(where.elements),
            "mass": where.mass,
            "inertia": where.inertia,
            "center": list(where.center),
            "driver": driver(drivers[name]) if name in drivers else None,
        }
        for name, where in assembly.bodies.items()
    ]


def driver(noun: Any) -> str:
    """A driver in words."""
    from ..drivers import AngleTable, ConstantSpeed, Ramp

    if isinstance(noun, ConstantSpeed):
        return f"constant speed {noun.speed:.6g} rad/s"
    if isinstance(noun, Ramp):
        return f"smooth ramp to {noun.speed:.6g} rad/s within {noun.duration:.6g} s"
    if isinstance(noun, AngleTable):
        return f"table of {len(noun.times)} angles up to {noun.times[-1]:.6g} s"
    if isinstance(noun.torque, int | float):
        return f"torque {noun.torque:.6g} N m"
    return f"table of {len(noun.torque)} torques"


def joints(assembly: Assembly, expected: Mapping[str, float]) -> list[dict[str, Any]]:
    """Kind, sides, clearance (m), laws and expected force (N) of each joint."""
    clearances = assembly.mechanism.clearances
    found = []
    for name, joint in assembly.mechanism.joints.items():
        kind = "clearance" if name in clearances else "ideal, driven pivot" if name in assembly.pivots else "ideal"
        entry = {
            "name": name,
            "kind": kind,
            "bearing": joint.bearing,
            "journal": joint.journal,
            "expected_force": expected.get(name),
        }
        found.append(entry | (clearance(assembly, joint) if name in clearances else {}))
    return found


def clearance(assembly: Assembly, joint: Joint) -> dict[str, Any]:
    """Size and laws of a joint with clearance."""
    from ..start import surfaces

    noun = assembly.mechanism.clearances[joint.name]
    pair = surfaces(assembly.mechanism, noun)
    sizes = {key: getattr(noun, key) for key in ("clearance", "bearing_radius", "axial_length", "friction_moment", "landing")}
    found = sizes | {kind: law(getattr(noun, kind), pair) for kind in ("contact", "friction")}
    found["contact"] |= {"modulus": pair.composite_modulus, "exponent": noun.contact.exponent_at(0.05 * pair.clearance, pair)}
    return found | {"bearing_material": pair.bearing.name, "journal_material": pair.journal.name}


def law(noun: Any, pair: Any) -> dict[str, Any]:
    """A law with its parameters and what is derived from them and the two surfaces."""
    given = {field.name: getattr(noun, field.name) for field in dataclasses.fields(noun)}
    return {"law": noun.name, "parameters": given, "derived": noun.derived(pair), "units": noun.units(pair)}


def step(assembly: Assembly) -> dict[str, Any]:
    """The step (s), what set it, and every limit."""
    choice = assembly.choice
    return {
        "size": choice.step,
        "automatic": choice.automatic,
        "set_by": choice.culprit,
        "stable": choice.stable,
        "limits": dict(choice.limits),
    }


def freedom(assembly: Assembly) -> dict[str, Any]:
    """Degrees of freedom of the ideal mechanism and joints that hold what is held already."""
    mobility = assembly.mobility
    return {
        "free": mobility.free,
        "after_drives": mobility.after_drives,
        "redundant": mobility.redundant,
        "redundant_joints": list(mobility.redundant_joints),
    }
