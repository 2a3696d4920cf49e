"""What a model amounts to: bodies, joints and laws as they will be calculated, in plain numbers (SI)."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..model.joints import Joint


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
    from ..model.drivers import AngleTable, ConstantSpeed, Harmonic, Ramp, StepTo

    unit = "m" if noun.slider or noun.point else "rad"
    against = f", against {noun.against}" if noun.against != "ground" else ""
    if isinstance(noun, ConstantSpeed):
        said = f"constant speed {noun.speed:.6g} {unit}/s"
    elif isinstance(noun, Ramp):
        said = f"smooth ramp to {noun.speed:.6g} {unit}/s within {noun.duration:.6g} s"
    elif isinstance(noun, StepTo):
        said = f"smooth step by {noun.travel:.6g} {unit} from {noun.begin:.6g} to {noun.begin + noun.duration:.6g} s"
    elif isinstance(noun, Harmonic):
        said = f"harmonic, {noun.amplitude:.6g} {unit} at {noun.frequency:.6g} Hz"
    elif isinstance(noun, AngleTable):
        said = f"table of {len(noun.times)} {'travels' if unit == 'm' else 'angles'} up to {noun.times[-1]:.6g} s"
    else:
        what, newton = ("force", "N") if noun.point else ("torque", "N m")
        over = " over speed" if noun.speeds else " over " + ("travel" if noun.point else "angle") if noun.angles else ""
        constant = isinstance(noun.value, int | float)
        said = f"{what} {noun.value:.6g} {newton}" if constant else f"table of {len(noun.value)} {what}s{over}"
    return said + against


def joints(assembly: Assembly, expected: Mapping[str, float]) -> list[dict[str, Any]]:
    """Kind, sides, clearance (m), laws and expected force (N) of each joint."""
    contacts = assembly.mechanism.contacts
    found = []
    for name, joint in assembly.mechanism.joints.items():
        entry = {
            "name": name,
            "kind": kind(joint) + (", driven pivot" if name in assembly.pivots else ""),
            "bearing": joint.bearing,
            "journal": joint.journal,
            "expected_force": expected.get(name),
        }
        found.append(entry | (contact(assembly, joint) if name in contacts else {}))
    return found


def kind(joint: Joint) -> str:
    """What kind of joint it is, in words."""
    from ..model import joints

    if isinstance(joint, joints.Slider):
        return "pin in a slot" if joint.turning else "slider"
    if isinstance(joint, joints.ExternalContact):
        return "contact with a line" if joint.bearing_radius is None else "contact of rounds"
    words = {joints.Weld: "weld", joints.ClearanceRevolute: "clearance", joints.ClearanceSlider: "clearance slider"}
    return words.get(type(joint), "ideal")


SIZES = ("clearance", "bearing_radius", "journal_radius", "length", "height", "corner_radius", "axial_length", "friction_moment", "landing")


def contact(assembly: Assembly, joint: Joint) -> dict[str, Any]:
    """Sizes and laws of a joint with play."""
    from ..model.surfaces import surfaces

    noun = assembly.mechanism.contacts[joint.name]
    pair = surfaces(assembly.mechanism, noun)
    sizes = {key: getattr(noun, key) for key in SIZES if getattr(noun, key, None) is not None}
    found = sizes | {kind: law(getattr(noun, kind), pair) for kind in ("contact", "friction")}
    found["contact"] |= {"modulus": pair.composite_modulus, "exponent": noun.contact.exponent_at(noun.landing, pair)}
    return found | {"bearing_material": pair.bearing.name, "journal_material": pair.journal.name}


def couplings(assembly: Assembly) -> list[dict[str, str]]:
    """Gears, springs, and drivers that do not bear the name of the body they turn: name, what it is, what it acts on."""
    mechanism = assembly.mechanism
    found = [
        {"name": name, "what": f"gear, ratio {gear.ratio:.6g}", "first": gear.first, "second": gear.second}
        for name, gear in mechanism.gears.items()
    ]
    for name, one in mechanism.springs.items():
        found.append({"name": name, "what": spring(one), "first": one.first, "second": one.second})
    for name, noun in mechanism.drivers.items():
        if name not in mechanism.bodies:
            found.append({"name": name, "what": f"driver: {driver(noun)}", "first": noun.body or noun.slider or noun.point, "second": ""})
    return found


def spring(noun: Any) -> str:
    """A spring in words."""
    from ..model.springs import Bushing, Spring, Stop

    if isinstance(noun, Stop):
        return f"stop between {noun.low:.6g} and {noun.high:.6g} rad, {noun.stiffness:.6g} N m/rad"
    if isinstance(noun, Bushing):
        x, y, turning = noun.stiffness
        return f"bushing, {x:.6g} and {y:.6g} N/m, {turning:.6g} N m/rad"
    if isinstance(noun, Spring):
        return f"spring, {noun.stiffness:.6g} N/m, {noun.damping:.6g} N s/m"
    return f"torsional spring, {noun.stiffness:.6g} N m/rad, {noun.damping:.6g} N m s/rad"


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
    """Degrees of freedom of the ideal mechanism, joints that hold what is held already, singular ones, and the class of a four-bar."""
    from ..kinematics.grashof import grashof

    mobility = assembly.mobility
    return {
        "free": mobility.free,
        "after_drives": mobility.after_drives,
        "redundant": mobility.redundant,
        "redundant_joints": list(mobility.redundant_joints),
        "singular": list(mobility.singular),
        "four_bar": grashof(assembly.mechanism),
    }
