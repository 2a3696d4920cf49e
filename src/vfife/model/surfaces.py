"""The two surfaces of a joint with clearance, and the range of validity of the laws that act between them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..laws import Law, Material, Pair
from .joints import Contact, Joint
from .lumping import rigid_properties

if TYPE_CHECKING:
    from .mechanism import Mechanism


def surfaces(mechanism: Mechanism, joint: Contact) -> Pair:
    """Return the pair of surfaces of a joint: sizes, materials and the effective mass (kg) of its bodies; the
    ground counts as infinitely heavy.
    """
    inverse = sum(
        1.0 / rigid_properties(mechanism.bodies[side[0]])[0] for side in joint.sides if side[0] != "ground"
    )
    return _weightless(mechanism, joint).between(1.0 / inverse if inverse else None)


def body_of(joint: Joint, side: str) -> str:
    """Return the body that has a ``side`` of a joint, "bearing" or "journal"."""
    return joint.sides[side == "journal"][0]


def surface_words(body: str, side: str) -> str:
    """Return a body and the side of a joint that it has, as text."""
    return f"{body} ({side})" if body else side


def _weightless(mechanism: Mechanism, joint: Contact) -> Pair:
    """Return the pair of surfaces of a joint without the mass of its bodies."""
    return joint.pair(
        *(mechanism.bodies[body].material if body != "ground" else Material() for body, _ in joint.sides)
    )


def cautions(
    mechanism: Mechanism, extremes: Mapping[str, tuple[float, float]] | None = None
) -> tuple[str, ...]:
    """Return a sentence for each law that is used outside its range; joints with the same sentence share it.

    Without ``extremes``: what is known before a run. With ``extremes``, by joint the deepest penetration (m)
    and the fastest impact (m/s) of a run: only the additional cautions that follow from them, for the worst
    of the joints with equal laws and surfaces.
    """
    joints: dict[str, list[str]] = {}
    for (law, pair), names in _alike(mechanism).items():
        sentences = law.cautions(pair)
        if extremes is not None:
            sentences = tuple(
                sentence
                for sentence in law.cautions(pair, *_worst(extremes, names))
                if sentence not in sentences
            )
        for sentence in sentences:
            joints.setdefault(f"{law.name}, {sentence}.", []).extend(names)
    return _by_joint(joints)


def law_facts(mechanism: Mechanism) -> tuple[str, ...]:
    """Return a sentence for each fact about the laws of the joints; joints with the same one share it."""
    joints: dict[str, list[str]] = {}
    for (law, pair), names in _alike(mechanism).items():
        for fact in law.facts(pair):
            joints.setdefault(f"{law.name}, {fact}.", []).extend(names)
    return _by_joint(joints)


def surface_facts(mechanism: Mechanism) -> tuple[str, ...]:
    """Return a sentence for each fact about the surfaces of the joints; joints with the same one share it."""
    joints: dict[str, list[str]] = {}
    for name, joint in mechanism.contacts.items():
        for fact in joint.facts():
            joints.setdefault(f"{fact}.", []).append(name)
    return _by_joint(joints)


def _by_joint(joints: Mapping[str, list[str]]) -> tuple[str, ...]:
    """Return sentences after the names of the joints that they concern."""
    return tuple(
        f"Joint{'s' * (len(names) > 1)} {', '.join(names)}: {sentence}" for sentence, names in joints.items()
    )


def remarks(mechanism: Mechanism, extremes: Mapping[str, tuple[float, float]]) -> tuple[str, ...]:
    """Return a line for each law whose impacts exceed its quasi-static range by no more than is usual in
    machines; ``extremes`` as in :func:`cautions`.
    """
    exceeded: dict[float, list[str]] = {}
    for (law, pair), names in _alike(mechanism).items():
        usual = law.usual(pair)
        if usual is not None and usual[0] < _worst(extremes, names)[1] <= usual[1]:
            exceeded.setdefault(usual[0], []).extend(names)
    return tuple(
        f"{', '.join(names)}: impacts of up to {_speed_words(_worst(extremes, names)[1])}, the law being"
        f" quasi-static up to {_speed_words(limit)}, as usual in machines"
        for limit, names in exceeded.items()
    )


def _speed_words(speed: float) -> str:
    """Return a speed (m/s) in the unit of the table of joints."""
    return f"{speed:.3g} m/s" if speed >= 1.0 else f"{1e3 * speed:.3g} mm/s"


def _alike(mechanism: Mechanism) -> dict[tuple[Law, Pair], list[str]]:
    """Group the joints with clearance by law and surfaces."""
    alike: dict[tuple[Law, Pair], list[str]] = {}
    for name, joint in mechanism.contacts.items():
        pair = _weightless(mechanism, joint)
        laws: tuple[Law, ...] = (joint.contact, joint.friction)
        for law in laws:
            alike.setdefault((law, pair), []).append(name)
    return alike


def _worst(extremes: Mapping[str, tuple[float, float]], names: list[str]) -> tuple[float, float]:
    """Return the largest penetration (m) and impact speed (m/s) of some joints."""
    depths, speeds = zip(*(extremes[name] for name in names), strict=True)
    return max(depths), max(speeds)
