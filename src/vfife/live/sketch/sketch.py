"""A mechanism as the drawing of an editor: bodies with their pins, joints, and the ideal motion."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import VfifeError
from ...kinematics.drives import kinematic_drivers
from ...kinematics.follower import TURN, Follower, Way, follow, ways_of
from ...kinematics.full_turn import full_turns
from ...kinematics.initial import Motion
from ...model.bodies import Link
from ...model.functions import turn_of
from ...model.joints import Joint
from ...model.mechanism import Mechanism
from ...model.outlines import corners, drawn_pins
from ...model.rows import Coincide, Guided, place_row, turn_row
from ...modelfile import loads
from .edit import resolution
from .operations import CHOICES, choice_of
from .pose import Pose, frames

Json = dict[str, Any]
Array = NDArray[np.float64]
STRIDES = 36  # between positions, on a way of a driver
OPEN = 1e-6  # of the size: distance of two pins that is drawn as a gap


def sketch(text: str, file: str | None = None) -> Json:
    """Return the drawing of a model (its tables are beside ``file``): names, places in m, angles in rad.

    ``resolution`` (m) is that of lengths as they are written. ``poses`` are places of the frames of
    ``bodies``, the start first. ``fault`` says why the mechanism does not close, with the open joints in
    ``gaps``; ``note`` says where it jams. Raises ModelError.
    """
    mechanism = loads(text, file=file)
    pose = Pose.of(mechanism)
    names = tuple(mechanism.bodies)
    positions, closed, note = pose.centers[None], False, ""
    if isinstance(pose.motion, Motion):
        positions, closed, note = ideal_positions(mechanism, pose.motion)
    drivers = {
        driver.body: {"name": name, "speed": driver.steady_speed}
        for name, driver in mechanism.drivers.items()
        if driver.target == "body"
    }
    return {
        "title": mechanism.name,
        "choices": list(CHOICES),
        "size": pose.size,
        "resolution": resolution(pose.size),
        "points": {name: list(place) for name, place in mechanism.points.items()},
        "bodies": [_body(pose, name, drivers.get(name)) for name in names],
        "joints": [_joint(pose, joint) for joint in mechanism.joints.values()],
        "springs": [
            {"name": name, "ends": [spring.first, spring.second]}
            for name, spring in mechanism.springs.items()
            if spring.between_pins
        ],
        "loads": [
            {"name": name, "at": load.place, "force": list(getattr(load, "force", (0.0, 0.0)))}
            for name, load in mechanism.loads.items()
            if not load.on_guide
        ],
        "poses": np.round(frames(mechanism, positions[:, 1:], names), 9).tolist(),
        "closed": closed,
        "free": pose.motion.mobility.after_drives if isinstance(pose.motion, Motion) else 0,
        "fault": _fault(pose, pose.motion) if isinstance(pose.motion, VfifeError) else "",
        "note": note,
        "gaps": [
            name for name, joint in mechanism.joints.items() if pose.gap(joint) > OPEN * pose.size
        ],
    }  # fmt: skip


def _fault(pose: Pose, error: VfifeError) -> str:
    """Return why a mechanism does not close: too many joints, or its gaps."""
    if pose.surplus <= 0:
        return str(error)
    freedoms = 3 * len(pose.mechanism.bodies)
    return (
        f"Joints and drivers hold {freedoms + pose.surplus} motions, and the bodies have {freedoms}, so that"
        " nothing can move: delete a joint or a driver, or add a body."
    )


def _body(pose: Pose, name: str, driver: Json | None) -> Json:
    """Return a body: its pins in its frame, those of its outline in order, and its driver."""
    body = pose.mechanism.bodies[name]
    forces = [load.place.partition(".") for load in pose.mechanism.loads.values() if not load.on_guide]
    pins = drawn_pins(pose.mechanism, name) or list(body.points)[:1]
    pins += [pin for pin in getattr(body, "pins", {}) if pin not in pins]
    pins += [pin for body_of_force, _, pin in forces if body_of_force == name and pin not in pins]
    via = [list(point) for point in body.via] if isinstance(body, Link) else []
    places = np.array([body.points[pin] for pin in pins], dtype=float)
    order, plate = corners(places)
    outline = [list(body.points[pins[k]]) for k in order]
    return {
        "name": name, "model": body.model, "driver": driver, "plate": plate and not via,
        "length": body.length if isinstance(body, Link) else None,
        "pins": {pin: list(place) for pin, place in body.points.items() if pin in pins},
        "outline": [[0.0, 0.0], *via, [body.length, 0.0]] if isinstance(body, Link) and via else outline,
    }  # fmt: skip


def _joint(pose: Pose, joint: Joint) -> Json:
    """Return a joint: its pins, and the direction of its guide in the frame of the bearing's body."""
    row = place_row(joint.rows())
    return {
        "name": joint.name, "kind": joint.kind, "words": joint.words, "choice": choice_of(joint),
        "bearing": joint.bearing, "journal": joint.journal,
        "clearance": getattr(joint, "clearance", None),
        "block": [getattr(joint, side, 0.0) for side in ("length", "height")],
        "drivers": [
            name for name, driver in pose.mechanism.drivers.items() if driver.slider == joint.name
        ],
        "guide": list(row.unit()) if isinstance(row, Guided) else None,
        "pinned": isinstance(row, Coincide), "fixed": turn_row(joint.rows()) is not None,
    }  # fmt: skip


# ------------------------------------------------------------------------------------------- ideal motion


def ideal_positions(mechanism: Mechanism, motion: Motion) -> tuple[Array, bool, str]:
    """Return positions of the centres of mass through the ideal motion, shape (k, bodies + 1, 3), whether the
    last leads to the first, and the sentence that says where the mechanism jams; "" if it does not.

    One position if drivers do not determine the motion. Positions are evenly spaced over the crank angle, or
    over the way of the driver.
    """
    start = motion.position[None]
    moving = [driver for driver in mechanism.drivers.values() if driver.moves]
    if len(moving) == 1 and (speed := moving[0].steady_speed):
        [turn] = full_turns([motion], [speed])
        if turn is not None:
            return turn.positions[:-1] * (1.0, motion.hand, motion.hand), True, ""
    follower = Follower.of(motion.system, motion.position * (1.0, motion.hand, motion.hand))
    duration = turn_of(mechanism) or mechanism.settings.duration or 0.0
    if follower is None or not moving or not duration:
        return start, False, ""
    ways = ways_of(mechanism, motion, duration)
    positions, jammed = [motion.position * (1.0, motion.hand, motion.hand)], ""
    for way in ways[:1]:
        way = replace(way, length=min(way.length, TURN)) if way.turning else way
        for _ in range(STRIDES):
            result = _stride(follower, positions[-1], way, (len(positions) - 1) / STRIDES)
            if result is None:
                jammed = _jam(mechanism, way, (len(positions) - 1) / STRIDES)
                break
            positions.append(result)
    return np.array(positions) * (1.0, motion.hand, motion.hand), False, jammed


def _stride(follower: Follower, position: Array, way: Way, share: float) -> Array | None:
    """Return the position a stride further on a way; None if the mechanism jams before."""
    begin, length = share * way.length, way.length / STRIDES
    passage = follow(
        follower, position, lambda s: way.aims(begin + s), lambda s: way.rates(begin + s), length, way.pace
    )
    return None if passage.jammed or passage.reached < length * (1.0 - 1e-9) else passage.position


def _jam(mechanism: Mechanism, way: Way, share: float) -> str:
    time = way.time(share * way.length)
    driven = ", ".join(kinematic_drivers(mechanism)) or "the driver"
    turned = (
        f" {math.degrees(share * way.length):.0f}° from the start" if way.turning else f" after {time:.3g} s"
    )
    return f"With ideal joints it jams{turned} of {driven}: change a length, or let the driver stay clear."
