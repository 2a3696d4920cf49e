"""Laws that make no sense of the surfaces they are given, which only the law itself can tell."""

from __future__ import annotations

from ...errors import Fault, place
from ...laws import ContactLaw, FrictionLaw, Law, Pair
from ..mechanism import Mechanism
from ..surfaces import surfaces

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
