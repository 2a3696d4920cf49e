"""What a model amounts to: bodies, joints and laws as they will be calculated, in plain numbers (SI)."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..laws.wear import PAIRS, coefficient
from ..model.wear import deepest

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..laws import Pair
    from ..model.drivers import Driver
    from ..model.joints import Joint
    from ..model.wear import Wear


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


def driver(noun: Driver) -> str:
    """A driver in words."""
    return noun.words + (f", against {noun.against}" if noun.against != "ground" else "")


def joints(assembly: Assembly, expected: Mapping[str, float]) -> list[dict[str, Any]]:
    """Kind, sides, clearance (m), laws and expected force (N) of each joint."""
    contacts = assembly.mechanism.contacts
    found = []
    for name, joint in assembly.mechanism.joints.items():
        entry = {
            "name": name,
            "kind": joint.words + (", driven pivot" if name in assembly.pivots else ""),
            "bearing": joint.bearing,
            "journal": joint.journal,
            "expected_force": expected.get(name),
        }
        found.append(entry | (contact(assembly, joint) if name in contacts else {}))
    return found


SIZES = ("axial_length", "friction_moment", "landing")  # of all joints with play, after their own


def contact(assembly: Assembly, joint: Joint) -> dict[str, Any]:
    """Sizes and laws of a joint with play."""
    from ..model.surfaces import surfaces

    noun = assembly.mechanism.contacts[joint.name]
    pair = surfaces(assembly.mechanism, noun)
    sizes = {key: getattr(noun, key) for key in (*noun.sizes, *SIZES) if getattr(noun, key, None) is not None}
    found = sizes | {kind: law(getattr(noun, kind), pair) for kind in ("contact", "friction")}
    found["contact"] |= {"modulus": pair.composite_modulus, "exponent": noun.contact.exponent_at(noun.landing, pair)}
    worn = {} if noun.wear is None else {"wear": wear(noun.wear, pair)}
    return found | worn | {"bearing_material": pair.bearing.name, "journal_material": pair.journal.name}


def wear(noun: Wear, pair: Pair) -> dict[str, dict[str, Any]]:
    """Of bearing and journal the coefficient of wear (1/Pa), the pair of materials that it is of, with its source, and the deepest place (m) that
    each has from the start.
    """
    found: dict[str, dict[str, Any]] = {}
    for side in ("bearing", "journal"):
        named = getattr(noun, side)
        source = {"pair": named, "source": PAIRS[named][1]} if isinstance(named, str) else {}
        depth = {"worn": deepest(profile)} if (profile := getattr(noun, f"{side}_profile")) else {}
        found[side] = {"coefficient": coefficient(named, getattr(pair, side)), **source, **depth}
    return found


def couplings(assembly: Assembly) -> list[dict[str, str]]:
    """Gears, springs, and drivers that do not bear the name of the body they turn: name, what it is, what it acts on."""
    mechanism = assembly.mechanism
    found = [{"name": name, "what": gear.words, "first": gear.first, "second": gear.second} for name, gear in mechanism.gears.items()]
    for name, one in mechanism.springs.items():
        found.append({"name": name, "what": one.words, "first": one.first, "second": one.second})
    for name, noun in mechanism.drivers.items():
        if name not in mechanism.bodies:
            found.append({"name": name, "what": f"driver: {driver(noun)}", "first": noun.body or noun.slider or noun.point, "second": ""})
    return found


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
        "shared": list(assembly.shared),
        "singular": list(mobility.singular),
        "blocked": mobility.blocked,
        "four_bar": grashof(assembly.mechanism),
    }
