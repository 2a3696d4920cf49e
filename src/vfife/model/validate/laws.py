"""Laws that make no sense of the surfaces they are given, which only the law itself can tell."""

from __future__ import annotations

from ...errors import Fault, place, shown
from ...laws import ContactLaw, FrictionLaw, Law, Pair
from ...laws.wear import coefficient
from ..mechanism import Mechanism
from ..surfaces import surfaces
from ..wear import Wear

LAWS: dict[str, type[Law]] = {"contact": ContactLaw, "friction": FrictionLaw}


def check_laws(mechanism: Mechanism) -> list[Fault]:
    """Faults of the laws of all joints with play, of a mechanism that has no other fault."""
    found = []
    for name, joint in mechanism.contacts.items():
        pair = surfaces(mechanism, joint)
        for kind in LAWS:
            what = senseless(getattr(joint, kind), pair)
            if what:
                size = f" (clearance {pair.clearance:g} m)" if pair.clearance else ""
                remedy = "check clearance, bearing_radius, axial_length and materials, or take another law"
                found.append(Fault(place(("joint", name, kind)), what + size, "", "", remedy))
        found += [] if joint.wear is None else softless(name, joint.wear, pair)
    return found


def softless(name: str, wear: Wear, pair: Pair) -> list[Fault]:
    """Surfaces that wear by a pair of materials by name, whose hardness is not known."""
    found = []
    for side in ("bearing", "journal"):
        named, material = getattr(wear, side), getattr(pair, side)
        if coefficient(named, material) is None:
            what = f"the coefficient of this pair is over the hardness of the {side}, and that of {material.name} is not known"
            remedy = f'give the material of the {side} its hardness, or the coefficient itself, as in "1e-15 1/Pa"'
            found.append(Fault(place(("joint", name, "wear", side)), what, shown(named), "", remedy))
    return found


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
    kind = next((kind for kind, base in LAWS.items() if isinstance(law, base)), "")
    return f'the {kind} law "{law.name}" gives no finite numbers for these surfaces'
