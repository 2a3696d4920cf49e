"""Whether the ideal mechanism can do what its drivers ask for, in words: refused where it cannot, a caution
where it may be bridged or splits.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..errors import AssemblyError, VfifeError
from ..kinematics.batch import Structures
from ..kinematics.drives import constraint_drivers, kinematic_drivers, spinless
from ..kinematics.forces import driven_body
from ..kinematics.full_turn import FullTurn, full_turns
from ..kinematics.initial import Motion, attempt, ideal_motions
from ..kinematics.linalg import DENSE
from ..kinematics.passage import Jam, Singular, passage, unclosed
from ..kinematics.stroke import stroke_cautions
from ..kinematics.table_peak import misplaced_peaks
from ..model.bodies import Frame, Link
from ..model.functions import turn_of
from ..model.mechanism import Mechanism, Settings
from ..model.validation.plausibility import suspects
from ..modelfile import dump
from .missing_joints import missing_joints
from .timestep import length_of

STRETCH = 0.01  # of the length of the two-particle links of a loop: more is beyond any metal
LARGE_ANGLE = math.radians(50.0)  # from an approximate angle, to close
MOST_LENGTHS = 3
MOST_PLACES = 4
# motions whose outlook is kept: to follow one takes longer than to assemble it, and commands ask several
# times
CACHE_SIZE = 64


@dataclass(frozen=True)
class Outlook:
    """What the ideal mechanism makes of a motion: ``notes`` for people, cautions about ``missing_joints``,
    and whether it ``passes``, so that a reference can be run.

    ``motion`` is the start that was solved for that, ``turn`` the turn of its crank, or of that of the
    neighbour, where one was looked at as a whole.
    """

    notes: tuple[str, ...] = ()
    passes: bool = True
    motion: Motion | None = None
    turn: FullTurn | None = None
    missing_joints: tuple[str, ...] = ()

    @property
    def cautions(self) -> tuple[str, ...]:
        """All sentences, those about missing joints first."""
        return *self.missing_joints, *self.notes


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
            notes = (*suspects(mechanism), *turned(mechanism, solved[k]), *strokes.get(k, ()))
            notes += misplaced_peaks(*cases[k]) if k in cases else ()
            missing = missing_joints(mechanism, solved[k], structures)
            answers.append(Outlook(notes, True, solved[k], clear[k], missing))
        elif k in motions:
            followed_outlook = attempt(_followed_once, mechanism, turns, duration, motions[k])
            if isinstance(followed_outlook, Outlook) and neighbour.turn is not None:
                followed_outlook = replace(followed_outlook, turn=neighbour.turn)
            answers.append(followed_outlook)
        else:
            notes = suspects(mechanism)
            answers.append(Outlook(notes, missing_joints=missing_joints(mechanism, structures=structures)))
    return answers


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
    notes, missing = suspects(mechanism), missing_joints(mechanism, motion)
    doubts = (*missing, *notes)
    if isinstance(motion, AssemblyError) and motion.gaps:
        lengths = _lengths(unclosed(mechanism, motion, length))
        remedy = f". One length that would work: {lengths}" if lengths else ""
        as_it_is = "As it is, " if doubts else ""
        raise AssemblyError(" ".join((*doubts, f"{as_it_is}{motion}{remedy}")), motion.joints, motion.gaps)
    if isinstance(motion, VfifeError):
        return Outlook(notes, missing_joints=missing)  # told where the run is assembled
    notes = (*notes, *turned(mechanism, motion))
    jam, passed = passage(
        mechanism, max(length, turn_of(mechanism) or 0.0), motion
    )  # the reference takes a whole turn
    notes = (*notes, *singular(mechanism, tuple(position for position in passed if position.time <= length)))
    if jam is None or jam.time > length:
        return Outlook(notes, jam is None, motion, missing_joints=missing)
    bridge = bridged(mechanism, jam)
    if bridge is None:
        raise AssemblyError(" ".join((*doubts, refused(mechanism, jam))), jam.joints)
    return Outlook(
        (*notes, f"{jammed(mechanism, jam)}. {bridge} There is no ideal motion to compare with."),
        False,
        motion,
        missing_joints=missing,
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
