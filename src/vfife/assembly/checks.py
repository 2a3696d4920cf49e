"""What assemble refuses: couples on what has no angle, contacts that start deep, numbers beyond all bounds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import VfifeError
from ..kinematics.drives import constraint_drivers, spinless
from ..kinematics.forces import driven_body
from ..model.bodies import Link, PointMass
from ..model.mechanism import Mechanism
from ..model.rows import Coincide, Turn
from ..numerics.elementwise import sincos

if TYPE_CHECKING:
    from ..kinematics.initial import Motion
    from .entities import Touch
    from .fill import Filler

WHOLE_TURN = 6.283185307179586  # rad


def refuse_idle(mechanism: Mechanism) -> None:
    """VfifeError, all at once, for what turns or holds a particle without inertia, or an end of a link that is released."""
    points, faults = spinless(mechanism), []
    released = {name: body.release for name, body in mechanism.bodies.items() if isinstance(body, Link) and body.element_count}
    for what, bodies in turned(mechanism):
        for body in bodies:
            if body in points:
                faults.append(f"{what} acts on the angle of {body!r}, a particle without inertia, which has none: give it an inertia")
            elif released.get(body) in ("start", "both"):
                faults.append(
                    f"{what} acts on {body!r} at its start, which is released, and would turn nothing but the pin: exchange start and end, or "
                    "remove the release"
                )
    for name, joint in mechanism.joints.items():
        for body, pin in joint.sides if {Coincide(), Turn()} <= {*joint.rows()} else ():
            if released.get(body) in (pin, "both"):
                faults.append(
                    f"weld {name!r} holds {body}.{pin}, an end that is released, not the link: take an ideal joint, or remove the release"
                )
    if faults:
        raise VfifeError("; ".join(faults))


def turned(mechanism: Mechanism) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Everything that acts on angles of bodies, and those bodies; welds and guides are not among it."""
    for name, gear in mechanism.gears.items():
        yield f"gear {name!r}", (gear.first, gear.second)
    for name, spring in mechanism.springs.items():
        if spring.turns and spring.between_pins:
            points = [end.partition(".") for end in (spring.first, spring.second)]
            yield f"{spring.kind} {name!r}", tuple(body for body, _, _ in points if isinstance(mechanism.bodies.get(body), PointMass))
        elif spring.turns:
            yield f"spring {name!r}", (spring.first, spring.second)
    for name, driver in mechanism.drivers.items():
        if not driver.moves and not driver.point:
            yield f"driver {name!r}", (driven_body(name, driver), driver.against)
    for name, driver in constraint_drivers(mechanism).items():
        if driven_body(name, driver):
            yield f"driver {name!r}", (driven_body(name, driver), driver.against)
    for name, load in mechanism.loads.items():
        for push in load.pushes(mechanism.joints):
            if push.acts[2] and isinstance(mechanism.bodies.get(push.body), PointMass):
                yield f"the moment of load {name!r}", (push.body,)


def refuse_infinite(motion: Motion) -> None:
    """VfifeError where the start has numbers beyond all bounds."""
    for what, values in (("position", motion.position), ("velocity", motion.velocity), ("acceleration", motion.acceleration)):
        bad = [name for k, name in enumerate(motion.names) if not np.isfinite(values[..., k, :]).all()]
        if bad:
            raise VfifeError(
                f"the {what} of {', '.join(bad)} at the start is beyond all numbers: check the units of speeds, forces, lengths and masses"
            )


def refuse_deep(filler: Filler, touches: Sequence[Touch]) -> None:
    """VfifeError, all at once, for contacts that start so deep that a body stands in another."""
    faults = []
    for touch in touches:
        depth, (limit, told) = start_depth(filler, touch), touch.joint.deepest_start
        if depth > limit:
            bearing, journal = touch.joint.bearing, touch.joint.journal
            faults.append(
                f"joint {touch.joint.name!r} starts with {journal} {depth:.4g} m deep in {bearing}, beyond {told}: check position and angle of "
                f"{journal.partition('.')[0]!r}, the side of the surface (a line's material lies to the right of its direction), and units"
            )
    if faults:
        raise VfifeError("; ".join(dict.fromkeys(faults)))


def start_depth(filler: Filler, touch: Touch) -> Any:
    """Penetration (m) at the start, negative where the surfaces are apart."""
    (bx, by), (kx, ky) = filler.seen(touch.bearing), filler.seen(touch.journal)
    ex, ey = kx - bx, ky - by
    angle = filler.angle(touch.bearing)
    s, c = sincos(angle)
    return touch.touching.depth(c * ex + s * ey, c * ey - s * ex)


def refuse_stuck(motion: Motion) -> None:
    """VfifeError where joints and other drivers hold what a driver is to move."""
    drives = motion.system.drives
    found = motion.mobility
    if found.free - found.after_drives < len(drives):
        names = ", ".join(drive.name for drive in drives)
        left = found.free - found.after_drives
        raise VfifeError(
            f"the drivers ({names}) prescribe {len(drives)} motions, and the joints leave {left} of them free here: joints or another driver hold "
            "what is driven, or this is a dead centre; remove a driver, loosen a joint, or start elsewhere"
        )


def refuse_static(mechanism: Mechanism) -> None:
    """VfifeError, all faults at once, for settings and drivers that a static analysis, if there is to be one, has no use for."""
    if mechanism.settings.analysis != "static":
        return
    settings, faults = mechanism.settings, []
    if not settings.load_factors:
        faults.append("load_factors is empty: give one or more, as in load_factors = [0.5, 1]")
    for name in ("turns", "duration"):
        if getattr(settings, name) is not None:
            faults.append(f"{name} = {getattr(settings, name):g} has no meaning, since the load factor takes the place of time: leave it out")
    if settings.step != "auto":
        faults.append(f"step = {settings.step} has no meaning, since iterations have a step of their own: leave it out")
    widest = max((abs(b - a) for a, b in pairwise((0.0, *settings.load_factors))), default=0.0)
    for name, driver in mechanism.drivers.items():
        speed = driver.steady_speed
        if speed is None or driver.slider or driver.point:
            continue
        way = widest * abs(speed)
        if way > WHOLE_TURN * (1.0 + 1e-9):
            faults.append(
                f"driver {name!r} turns {way:.4g} rad from one load factor to the next (speed {speed:.4g} rad/s, the load factor being the "
                f"time); at most one turn, {WHOLE_TURN:.4g} rad, can be followed: take a table of angles, load factors closer together, or a "
                "dynamic analysis"
            )
    if faults:
        raise VfifeError("static analysis: " + "; ".join(faults))
