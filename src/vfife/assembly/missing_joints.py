"""Cautions about joints that a model seems to lack: pins and points of the ground that nothing uses, and
freedoms that nothing determines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import VfifeError
from ..kinematics.batch import Structures
from ..kinematics.drives import standing
from ..kinematics.initial import Motion, attempt, ideal_motion
from ..kinematics.linalg import DENSE
from ..kinematics.mobility import MOVES, FreeMotions
from ..model.bodies import Frame, Link, PointMass
from ..model.mechanism import Mechanism
from ..model.rows import Coincide, place_row
from ..model.validation.checks import connections, used_pins
from ..model.validation.magnitudes import extents_of
from ..model.validation.plausibility import unconnected
from ..numerics.scalar import distance

CLOSENESS = 0.01  # of the largest body: pins so close at the start may be meant as one


def missing_joints(
    mechanism: Mechanism, motion: Motion | VfifeError | None = None, structures: Structures | None = None
) -> tuple[str, ...]:
    """Return the cautions about joints that seem to be missing; mechanisms of one structure share those of
    the first. ``motion`` is that of the start, if solved before.
    """

    def cautions() -> tuple[str, ...]:
        texts = unconnected(mechanism)
        if texts or len(mechanism.bodies) > DENSE // 3:
            return texts
        start = motion or attempt(ideal_motion, mechanism)
        if isinstance(start, Motion) and not start.mobility.blocked:
            if texts := _unheld(_freedom(mechanism, start)):
                return texts
        elif not isinstance(start, Motion):  # a travel that only elastic bodies yield to
            start = attempt(ideal_motion, standing(mechanism))
        return _at_idle_points(_freedom(mechanism, start)) if isinstance(start, Motion) else ()

    structures = structures or Structures()
    key = "missing", structures.mechanism(mechanism)
    return structures.shared.recall(key, (mechanism.loads, mechanism.joints), cautions)


def _freedom(mechanism: Mechanism, motion: Motion) -> FreeMotions:
    return FreeMotions(mechanism, motion.system, motion.position, motion.hand)


def _unheld(freedom: FreeMotions) -> tuple[str, ...]:
    """Return a caution where drivers leave motions and a joint seems to be missing: nothing acts in them, a
    pin that is joined to nothing lies beside another, a point of the ground is used by nothing, or nothing
    that is driven leads there.

    Mechanisms with fewer drivers than freedoms are meant where weight, loads or springs move the rest, as of
    pendulums on a crank.
    """
    if not len(freedom.motions):
        return ()
    mechanism = freedom.mechanism
    moved = freedom.moved(freedom.motions)
    pair = _neighbours(freedom) or next(iter(_pins_at_idle_points(freedom)), None)
    idle = freedom.moved(freedom.idle) if mechanism.drivers else []
    open_pins, points = _open_pins(mechanism), _idle_points(mechanism)
    unled = bool(mechanism.drivers) and _without_lead(freedom, moved, open_pins)
    if not (pair or idle or points or unled):
        return ()
    causes = [f"no load, spring or weight acts on {_listed(idle)} there"] if idle else []
    remedy = "Is a joint forgotten?"
    ends = [pin for pin, is_end in open_pins.items() if is_end]
    if pair:
        first, second, away = pair
        causes.append(f"{first} is joined to nothing and lies {1e3 * round(away, 8):.3g} mm from {second}")
        remedy = f"Is a joint between {second} and {first} forgotten?"
    elif ends or points:
        unused = [*ends, *points]
        causes.append(f"{_listed(unused)} {'is' if len(unused) == 1 else 'are'} joined to nothing")
    subject = "The drivers leave" if mechanism.drivers else "The mechanism has"
    degrees = "1 degree" if len(freedom.motions) == 1 else f"{len(freedom.motions)} degrees"
    detail = f": {'; '.join(causes)}" if causes else ""
    return (f"{subject} {degrees} of freedom, in which {_listed(moved)} can move{detail}. {remedy}",)


def _at_idle_points(freedom: FreeMotions) -> tuple[str, ...]:
    """Return cautions about pins that nothing holds at points of the ground that nothing uses."""
    return tuple(
        f"{point} and {pin} lie in one place, and no joint uses them. Is a joint between {point} and {pin}"
        " forgotten?"
        for pin, point, _ in _pins_at_idle_points(freedom)
    )


def _pins_at_idle_points(freedom: FreeMotions) -> list[tuple[str, str, float]]:
    """Return the pins that nothing uses at points of the ground that nothing uses, with the point and the
    distance (m).
    """
    mechanism = freedom.mechanism
    used, reach = used_pins(mechanism), _closeness(mechanism)
    return [
        (f"{name}.{pin}", point, away)
        for point in _idle_points(mechanism)
        for name, body in mechanism.bodies.items()
        for pin in body.points
        if f"{name}.{pin}" not in used
        and (away := distance(freedom.place((name, pin)), freedom.place(("ground", point.partition(".")[2]))))
        <= reach
    ]


def _idle_points(mechanism: Mechanism) -> list[str]:
    """Return the points of the ground that nothing uses."""
    used = used_pins(mechanism)
    return [point for name in mechanism.points if (point := f"ground.{name}") not in used]


def _closeness(mechanism: Mechanism) -> float:
    return CLOSENESS * max(extents_of(mechanism), default=0.0)


def _listed(names: Sequence[str]) -> str:
    return " and ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)


def _open_pins(mechanism: Mechanism) -> dict[str, bool]:
    """Return the pins without joint, load and mass, and whether each is an end of a link."""
    used, result = used_pins(mechanism), {}
    for name, body in mechanism.bodies.items():
        masses = getattr(body, "masses", None) or {}
        pins = () if isinstance(body, Frame | PointMass) else body.points
        for pin in pins:
            end = isinstance(body, Link) and pin in body.own_points
            heavy = pin in masses or (end and getattr(body, f"{pin}_mass"))
            if f"{name}.{pin}" not in used and not heavy and pin != "center":
                result[f"{name}.{pin}"] = end
    return result


def _neighbours(freedom: FreeMotions) -> tuple[str, str, float] | None:
    """Return a pin that is joined to nothing, the pin beside it at the start that can move away from it, and
    their distance (m). Without drivers these are ends of links, which no joint connects.
    """
    mechanism, driven = freedom.mechanism, bool(freedom.mechanism.drivers)
    pinned = {
        end for joint in mechanism.joints.values() if isinstance(place_row(joint.rows()), Coincide)
        for end in (joint.bearing, joint.journal)
    }  # fmt: skip
    joined = {frozenset(end.partition(".")[0] for end in pair) for pair in connections(mechanism)}
    sides = [("ground", name) for name in mechanism.points]
    sides += [(name, pin) for name, body in mechanism.bodies.items() for pin in body.points]
    reach, pairs = _closeness(mechanism), []
    for pin, is_end in _open_pins(mechanism).items():
        owner, _, name = pin.partition(".")
        for side in sides:
            intended = {owner, side[0]} in joined or (side[0] == "ground" and ".".join(side) in pinned)
            if side[0] == owner or not (driven or (is_end and not intended)):
                continue
            away = distance(freedom.place((owner, name)), freedom.place(side))
            parting = np.abs(freedom.speeds((owner, name)) - freedom.speeds(side)).max()
            if away <= reach and parting > MOVES:
                pairs.append((away, pin, ".".join(side)))
    if not pairs:
        return None
    away, pin, neighbour = min(pairs)
    return pin, neighbour, away


def _without_lead(freedom: FreeMotions, moved: Sequence[str], open_pins: Mapping[str, bool]) -> bool:
    """Return whether bodies that drivers leave free, and that no spring holds, are joined to nothing that is
    driven, or to each other in a loop, while a pin is joined to nothing; or whether an end of a driven link
    is joined to nothing. A crank that moves no other body, such as the clock of a load, is meant.
    """
    mechanism = freedom.mechanism
    pairs = [{end.partition(".")[0] for end in pair} for pair in connections(mechanism)]
    linked = {body for pair in pairs if "ground" not in pair for body in pair}
    owners = {pin.partition(".")[0] for pin, is_end in open_pins.items() if is_end} & linked
    sprung = {
        end.partition(".")[0]
        for spring in mechanism.springs.values()
        for end in (spring.first, spring.second)
    }
    sprung |= {body for joint in mechanism.joints.values() if not joint.rows() for body, _ in joint.sides}
    return bool(owners - set(moved)) or any(
        (owners - group.bodies and not group.led)
        or (group.looped and any(pin.partition(".")[0] in group.bodies for pin in open_pins))
        for group in freedom.groups
        if not group.bodies & sprung
    )
