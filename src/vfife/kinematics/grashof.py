"""Grashof's classes of the four-bar linkage (Grashof 1883; Norton, Design of Machinery, section 2.12)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

from ..model.joints import Joint
from ..model.mechanism import Mechanism
from ..numerics.scalar import distance
from .pins import from_center

EVEN = 1e-9  # a change point: s + l = p + q to so many parts


def grashof(mechanism: Mechanism) -> str | None:
    """Class of the four-bar that ground, three bodies and four revolutes of a mechanism make, with its lengths; None without one.

    With s the shortest, l the longest, p and q the other lengths: s + l < p + q lets the shortest turn fully against the others (crank-rocker
    if it is pivoted on the ground, double crank or drag link if it is the ground, double rocker if it is the coupler), s + l = p + q is a
    change point, and s + l > p + q a triple rocker. The first such loop is described, the bodies in the order of the loop.
    """
    for loop in _loops(mechanism):
        lengths = {body: _length(mechanism, body, *ends) for body, ends in loop.items()}
        if min(lengths.values()) > 0.0:
            said = ", ".join(f"{body} {1e3 * length:.6g} mm" for body, length in lengths.items())
            return f"{classified(*lengths.values())}: {said}"
    return None


def classified(ground: float, first: float, coupler: float, second: float) -> str:
    """Grashof's class from four lengths in the order of the loop (in one unit)."""
    lengths = (ground, first, coupler, second)
    shortest, p, q, longest = sorted(lengths)
    excess = shortest + longest - p - q
    if abs(excess) <= EVEN * longest:
        opposite = math.isclose(ground, coupler, rel_tol=EVEN) and math.isclose(first, second, rel_tol=EVEN)
        deltoid = math.isclose(shortest, p, rel_tol=EVEN) and math.isclose(q, longest, rel_tol=EVEN)
        return "parallelogram, a change-point four-bar" if opposite else "deltoid, a change-point four-bar" if deltoid else "change-point four-bar"
    if excess > 0.0:
        return "triple rocker, a non-Grashof four-bar"
    if shortest == ground:
        return "double crank (drag link), a Grashof four-bar"
    return "double rocker, a Grashof four-bar" if shortest == coupler else "crank-rocker, a Grashof four-bar"


def _loops(mechanism: Mechanism) -> Iterator[dict[str, tuple[str, str]]]:
    """Loops of ground, first, coupler and second body: the two pins of each, in order."""
    revolutes = [joint for joint in mechanism.joints.values() if joint.revolves]
    grounded = [joint for joint in revolutes if "ground" in (joint.sides[0][0], joint.sides[1][0])]
    for one, two in combinations(grounded, 2):
        (foot_1, (first, pin_1)), (foot_2, (second, pin_2)) = _from(one, "ground"), _from(two, "ground")
        for three in (joint for joint in revolutes if joint not in (one, two) and first in _bodies(joint)):
            knee_1, (coupler, end_1) = _from(three, first)
            for four in (joint for joint in revolutes if joint not in (one, two, three) and {coupler, second} == set(_bodies(joint))):
                knee_2, (_, end_2) = _from(four, second)
                if len({"ground", first, coupler, second}) == 4:
                    yield {
                        "ground": (foot_1[1], foot_2[1]), first: (pin_1, knee_1[1]), coupler: (end_1, end_2), second: (pin_2, knee_2[1]),
                    }  # fmt: skip


def _bodies(joint: Joint) -> tuple[str, str]:
    return joint.sides[0][0], joint.sides[1][0]


def _from(joint: Joint, body: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """The joint's sides, that of ``body`` first."""
    return joint.sides if joint.sides[0][0] == body else joint.sides[::-1]


def _length(mechanism: Mechanism, body: str, one: str, two: str) -> float:
    return distance(from_center(mechanism, (body, one)), from_center(mechanism, (body, two)))
