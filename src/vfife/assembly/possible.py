"""Whether the ideal mechanism can do what its drivers ask for, in words: refused where it cannot, a caution
where it may be bridged or splits.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..errors import AssemblyError, VfifeError
from ..kinematics.batch import Structures
from ..kinematics.drives import constraint_drivers, kinematic_drivers, spinless
from ..kinematics.forces import driven_body
from ..kinematics.full_turn import FullTurn, full_turns
from ..kinematics.initial import Motion, attempt, ideal_motion, ideal_motions
from ..kinematics.linalg import DENSE
from ..kinematics.mobility import MOVES, FreeMotions
from ..kinematics.passage import Jam, Singular, passage, unclosed
from ..kinematics.stroke import stroke_cautions
from ..kinematics.table_peak import misplaced_peaks
from ..model.bodies import Frame, Link, PointMass
from ..model.functions import turn_of
from ..model.mechanism import Mechanism, Settings
from ..model.rows import Coincide, place_row
from ..model.validation.checks import connections, used_pins
from ..model.validation.magnitudes import extents_of
from ..model.validation.plausibility import suspect_connections, suspect_sizes, suspects, unconnected
from ..modelfile import dump
from ..numerics.scalar import distance
from .timestep import length_of

STRETCH = 0.01  # of the length of the two-particle links of a loop: more is beyond any metal
LARGE_ANGLE = math.radians(50.0)  # from an approximate angle, to close
MOST_LENGTHS = 3
MOST_PLACES = 4
CLOSENESS = 0.01  # of the largest body: pins so close at the start may be meant as one
# motions whose outlook is kept: to follow one takes longer than to assemble it, and commands ask several
# times
CACHE_SIZE = 64


@dataclass(frozen=True)
class Outlook:
    """What the ideal mechanism makes of a motion: ``notes`` for people, and whether it ``passes``, so that a
    reference can be run.

    ``motion`` is the start that was solved for that, ``turn`` the turn of its crank, or of that of the
    neighbour, where one was looked at as a whole.
    """

    notes: tuple[str, ...] = ()
    passes: bool = True
    motion: Motion | None = None
    turn: FullTurn | None = None


CACHE: OrderedDict[tuple[str, float], Outlook] = OrderedDict()


def outlook(mechanism: Mechanism, turns: float | None = None, duration: float | None = None) -> Outlook:
    """Follows the ideal mechanism through a run. AssemblyError where it jams and neither clearance nor
    elastic links can bridge what opens.

    Nothing is said of mechanisms that their drivers do not determine, of more than some 30 bodies, nor of a
    static analysis.
    """
    [result] = outlooks([mechanism], turns, duration=duration)
    if isinstance(result, VfifeError):
        raise result
    return result


def outlooks(
    mechanisms: Sequence[Mechanism],
    turns: float | None,
    neighbour: Outlook | None = None,
    duration: float | None = None,
    structures: Structures | None = None,
) -> list[Outlook | VfifeError]:
    """Follow each of many mechanisms through its motion; the error of one that jams stands in its place.
    Starts of one structure are solved at once.

    A turn of a crank is looked at as a whole, from that of the ``neighbour`` if there is one, the outlook of
    a mechanism that may differ from them in numbers alone; only where that leaves doubt is it followed.
    """
    neighbour, structures = neighbour or Outlook(), structures or Structures()
    followed = [k for k, mechanism in enumerate(mechanisms) if _followable(mechanism)]
    solutions = ideal_motions([mechanisms[k] for k in followed], structures=structures)
    motions = dict(zip(followed, solutions, strict=True))
    solved = {k: motion for k, motion in motions.items() if isinstance(motion, Motion)}
    same_turn = {
        k: neighbour.turn
        for k, motion in solved.items()
        if neighbour.passes and neighbour.motion and _moves_alike(motion, neighbour.motion)
    }
    speeds = {k: speed for k in solved if k not in same_turn and (speed := _one_speed(mechanisms[k]))}
    result = full_turns([solved[k] for k in speeds], list(speeds.values()), neighbour.turn)
    clear = same_turn | {k: turn for k, turn in zip(speeds, result, strict=True) if turn is not None}
    cases = {k: (mechanisms[k], solved[k], turn) for k, turn in clear.items() if turn is not None}
    strokes = stroke_cautions(cases, structures)
    answers: list[Outlook | VfifeError] = []
    for k, mechanism in enumerate(mechanisms):
        if k in clear:
            notes = (*_suspects(structures, mechanism), *_missing(structures, mechanism, solved[k]))
            notes += (*turned(mechanism, solved[k]), *strokes.get(k, ()))
            notes += misplaced_peaks(*cases[k]) if k in cases else ()
            answers.append(Outlook(notes, True, solved[k], clear[k]))
        elif k in motions:
            followed_outlook = attempt(_followed_once, mechanism, turns, duration, motions[k])
            if isinstance(followed_outlook, Outlook) and neighbour.turn is not None:
                followed_outlook = replace(followed_outlook, turn=neighbour.turn)
            answers.append(followed_outlook)
        else:
            answers.append(Outlook((*suspects(mechanism), *_missing(structures, mechanism))))
    return answers


def _suspects(structures: Structures, mechanism: Mechanism) -> tuple[str, ...]:
    """Return cautions about a mechanism; those about connections are those of mechanisms like it."""
    # Whether a load has a size follows from the numbers of loads and joints.
    objects, key = (mechanism.loads, mechanism.joints), structures.mechanism(mechanism)
    return (
        *suspect_sizes(mechanism),
        *structures.shared.recall(key, objects, partial(suspect_connections, mechanism)),
    )


def joint_cautions(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the caution about missing joints of a mechanism that may have no start; see
    :func:`missing_joints`.
    """
    return _missing(Structures(), mechanism)


def _missing(structures: Structures, mechanism: Mechanism, motion: Motion | None = None) -> tuple[str, ...]:
    """Return the caution about missing joints, from the ``motion`` of the start."""

    def cautions() -> tuple[str, ...]:
        if mechanism.settings.analysis == "static" or not 1 < len(mechanism.bodies) <= DENSE // 3:
            return ()
        start = motion or attempt(ideal_motion, mechanism)
        return missing_joints(mechanism, start) if isinstance(start, Motion) else ()

    key = "missing", structures.mechanism(mechanism)
    return structures.shared.recall(key, (mechanism.loads, mechanism.joints), cautions)


def _followed_once(
    mechanism: Mechanism, turns: float | None, duration: float | None, motion: Motion | VfifeError
) -> Outlook:
    """Return the outlook of a mechanism followed from the motion of its start, from the cache if possible."""
    length = length_of(mechanism, turns, duration, turn_of(mechanism))
    key = _key(mechanism, length)
    result = CACHE.get(key) if key is not None else None
    if result is None:
        result = _followed(mechanism, length, motion)
        if key is not None:
            CACHE[key] = result
            if len(CACHE) > CACHE_SIZE:
                CACHE.popitem(last=False)
    return result


def _followable(mechanism: Mechanism) -> bool:
    """Whether anything is said of a mechanism."""
    driven = any(driver.moves for driver in mechanism.drivers.values())
    return mechanism.settings.analysis != "static" and driven and 3 * len(mechanism.bodies) <= DENSE


def _key(mechanism: Mechanism, length: float) -> tuple[str, float] | None:
    """Return the cache key of an outlook: the model text without settings of the step, and the length. None
    where no text describes the whole mechanism.
    """
    try:
        return dump(replace(mechanism, settings=Settings(analysis=mechanism.settings.analysis))), length
    except (TypeError, ValueError):
        return None


def _followed(mechanism: Mechanism, length: float, motion: Motion | VfifeError) -> Outlook:
    """Follow a mechanism for ``length`` (s) from the motion of its start, and return the outlook."""
    doubts = suspects(mechanism)
    if isinstance(motion, AssemblyError) and motion.gaps:
        lengths = _lengths(unclosed(mechanism, motion, length))
        remedy = f". One length that would work: {lengths}" if lengths else ""
        as_it_is = "As it is, " if doubts else ""
        raise AssemblyError(" ".join((*doubts, f"{as_it_is}{motion}{remedy}")), motion.joints, motion.gaps)
    if isinstance(motion, VfifeError):
        return Outlook(doubts)  # told where the run is assembled
    notes = (*doubts, *missing_joints(mechanism, motion), *turned(mechanism, motion))
    jam, passed = passage(
        mechanism, max(length, turn_of(mechanism) or 0.0), motion
    )  # the reference takes a whole turn
    notes = (*notes, *singular(mechanism, tuple(position for position in passed if position.time <= length)))
    if jam is None or jam.time > length:
        return Outlook(notes, jam is None, motion)
    bridge = bridged(mechanism, jam)
    if bridge is None:
        raise AssemblyError(" ".join((*doubts, refused(mechanism, jam))), jam.joints)
    return Outlook(
        (*notes, f"{jammed(mechanism, jam)}. {bridge} There is no ideal motion to compare with."),
        False,
        motion,
    )


def _one_speed(mechanism: Mechanism) -> float | None:
    """Return the constant speed (rad/s) of the only driver that prescribes a motion; None where there is
    none.
    """
    speeds = [driver.steady_speed for driver in mechanism.drivers.values() if driver.moves]
    return speeds[0] if len(speeds) == 1 else None


def _moves_alike(first: Motion, second: Motion) -> bool:
    """Whether two mechanisms pass the same positions in a run of as many turns: masses and the size of a
    steady speed do not change them.
    """
    if first.mechanism is None or second.mechanism is None or first.hand != second.hand:
        return False
    speeds = _one_speed(first.mechanism), _one_speed(second.mechanism)
    driven = speeds[0] is not None and speeds[1] is not None and speeds[0] * speeds[1] > 0.0
    constraints = zip(first.system.constraints, second.system.constraints, strict=False)
    alike = first.system.structure == second.system.structure and all(
        a.geometry == b.geometry for a, b in constraints
    )
    return alike and (driven or first.mechanism.drivers == second.mechanism.drivers)


def missing_joints(mechanism: Mechanism, motion: Motion) -> tuple[str, ...]:
    """Return a caution where drivers leave motions and a joint seems to be missing: nothing acts in them, a
    pin that is joined to nothing lies beside another, or nothing that is driven leads there.

    Mechanisms with fewer drivers than freedoms are meant where weight, loads or springs move the rest, as of
    pendulums on a crank. ``motion`` is that of the start. Nothing is said where :func:`unconnected` finds the
    joint.
    """
    freedom = FreeMotions(mechanism, motion.system, motion.position, motion.hand)
    if unconnected(mechanism) or motion.mobility.blocked or not len(freedom.motions):
        return ()
    moved, pair = freedom.moved(freedom.motions), _neighbours(freedom)
    idle = freedom.moved(freedom.idle) if mechanism.drivers else []
    open_pins = _open_pins(mechanism)
    if not (pair or idle or (mechanism.drivers and _without_lead(freedom, moved, open_pins))):
        return ()
    causes = [f"no load, spring or weight acts on {_listed(idle)} there"] if idle else []
    remedy = "Is a joint forgotten?"
    ends = [pin for pin, is_end in open_pins.items() if is_end]
    if pair:
        first, second, away = pair
        causes.append(f"{first} is joined to nothing and lies {1e3 * round(away, 8):.3g} mm from {second}")
        remedy = f"Is a joint between {second} and {first} forgotten?"
    elif ends:
        causes.append(f"{_listed(ends)} {'is' if len(ends) == 1 else 'are'} joined to nothing")
    subject = "The drivers leave" if mechanism.drivers else "The mechanism has"
    degrees = "1 degree" if len(freedom.motions) == 1 else f"{len(freedom.motions)} degrees"
    detail = f": {'; '.join(causes)}" if causes else ""
    return (f"{subject} {degrees} of freedom, in which {_listed(moved)} can move{detail}. {remedy}",)


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
    near, pairs = CLOSENESS * max(extents_of(mechanism), default=0.0), []
    for pin, is_end in _open_pins(mechanism).items():
        owner, _, name = pin.partition(".")
        for side in sides:
            intended = {owner, side[0]} in joined or (side[0] == "ground" and ".".join(side) in pinned)
            if side[0] == owner or not (driven or (is_end and not intended)):
                continue
            away = distance(freedom.place((owner, name)), freedom.place(side))
            parting = np.abs(freedom.speeds((owner, name)) - freedom.speeds(side)).max()
            if away <= near and parting > MOVES:
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


def refused(mechanism: Mechanism, jam: Jam) -> str:
    """State a jam as a fault, with the link length that would avoid it."""
    sentence = jammed(mechanism, jam)
    lengths = _lengths(jam.lengths)
    drivers = ", ".join(_drivers(mechanism))
    remedy = (
        f"One length that would do: {lengths}"
        if lengths
        else "No length of a single link was found that would work: check all lengths and guides"
    )
    return f"{sentence}. {remedy}; or let the driver ({drivers}) keep away from this position"


def jammed(mechanism: Mechanism, jam: Jam) -> str:
    """Where a mechanism ends, and what opens."""
    place = f"{_place(mechanism, jam.aims)}, {jam.time:.3g} s after the start"
    first = f"the mechanism cannot perform this motion: with ideal joints it jams at {place}"
    if math.isnan(jam.gap):
        return f"{first}, where joints {jam.joint} hold it"
    place = (
        ""
        if jam.gap == 0.0
        else (
            f"; further on {jam.joint} would be open by {1e3 * jam.gap:.4g} mm (at"
            f" {_place(mechanism, jam.widest)})"
        )
    )
    return f"{first}, where joint {jam.joint} opens{place}"


def bridged(mechanism: Mechanism, jam: Jam) -> str | None:
    """State which clearances or flexible links may bridge the gap of a jam; None where none does."""
    loose = [joint for name in jam.joints if (joint := mechanism.contacts.get(name)) is not None]
    slack = sum(float(getattr(joint, "clearance", 0.0)) for joint in loose)
    if loose and jam.gap <= slack:
        listed = ", ".join(joint.name for joint in loose)
        return f"The clearance of {listed}, {1e3 * slack:.4g} mm together, may bridge that."
    soft = [
        name
        for name in jam.bodies
        if isinstance(body := mechanism.bodies[name], Frame)
        or (isinstance(body, Link) and body.model == "elastic")
    ]
    if soft:
        return (
            f"Only {', '.join(soft)}, which {'is' if len(soft) == 1 else 'are'} elastic, can give way to it."
        )
    bars = [
        body
        for name in jam.bodies
        if isinstance(body := mechanism.bodies[name], Link) and body.model == "two-particle"
    ]
    if bars and jam.gap - slack <= STRETCH * sum(body.length for body in bars):
        return f"Only a stretch of {', '.join(body.name for body in bars)} can bridge that."
    return None


def singular(mechanism: Mechanism, passed: tuple[Singular, ...]) -> tuple[str, ...]:
    """Singular positions passed, as one caution."""
    if not passed:
        return ()
    places = ", ".join(_place(mechanism, position.aims) for position in passed[:MOST_PLACES]) + (
        ", ..." if len(passed) > MOST_PLACES else ""
    )
    joints = ", ".join(dict.fromkeys(name for position in passed for name in position.joints))
    return (
        (
            f"The ideal mechanism passes a singular position (a change point) at {places}, with joints"
            f" {joints}: it can continue in two ways there, and the choice is not determined. A slightly"
            " different length, or a second linkage with another phase, determines it."
        ),
    )


def turned(mechanism: Mechanism, motion: Motion) -> tuple[str, ...]:
    """Bodies that had to turn far from their approximate angles to close the mechanism, which may be the
    mirror image of what is meant.
    """
    result = []
    points = spinless(mechanism)
    for name, body in mechanism.bodies.items():
        off = math.remainder(motion.of(name)[0][2] - body.angle, 2.0 * math.pi)
        if body.angle and abs(off) > LARGE_ANGLE and name not in points:
            start = math.remainder(body.angle, 2.0 * math.pi)
            result.append(f"{name} from {math.degrees(start):.4g}° to {math.degrees(start + off):.4g}°")
    if not result:
        return ()
    return (
        (
            f"To close the mechanism, {' and '.join(result)} had to be turned: is this its mirror image?"
            " Approximate angles choose the branch."
        ),
    )


def _drivers(mechanism: Mechanism) -> list[str]:
    return [*kinematic_drivers(mechanism), *constraint_drivers(mechanism)]


def _place(mechanism: Mechanism, aims: tuple[float, ...]) -> str:
    """Values of the drivers, as in "crank angle 112°"."""
    drivers, result = mechanism.drivers, []
    by_body = {driven_body(name, driver) or name: driver for name, driver in drivers.items()}
    for name, value in zip(_drivers(mechanism), aims, strict=True):
        driver = by_body.get(name) or drivers[name]
        if driver.is_linear:
            result.append(f"{driver.slider or driver.point} at {1e3 * value:.4g} mm")
        else:
            degrees = round(math.degrees(value), 1)
            result.append(f"{driven_body(name, driver)} angle {degrees % 360.0:.5g}°")
    return " and ".join(result)


def _lengths(lengths: tuple[tuple[str, float, float], ...]) -> str:
    return " or ".join(_length(*change) for change in lengths[:MOST_LENGTHS])


def _length(name: str, present: float, required: float) -> str:
    limit = "at least" if required > present else "at most"
    return f"{name} {limit} {1e3 * required:.5g} mm (now {1e3 * present:.5g} mm)"
