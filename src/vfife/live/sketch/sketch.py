"""A mechanism as the drawing of an editor: bodies with their pins, joints, and the ideal motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import VfifeError
from ...kinematics.initial import Motion
from ...model.bodies import Link
from ...model.joints import Joint
from ...model.outlines import corners, drawn_pins
from ...model.rows import Coincide, Guided, place_row, turn_row
from ...modelfile import loads
from .ideal_turn import ideal_positions
from .joint_kinds import CHOICES, choice_of
from .pose import Pose, frames

Json = dict[str, Any]
OPEN = 1e-6  # of the size: distance of two pins that is drawn as a gap


def sketch(text: str, file: str | None = None) -> Json:
    """Return the drawing of a model (its tables are beside ``file``): names, places in m, angles in rad.

    ``poses`` are places of the frames of ``bodies``, the start first. ``fault`` says why the mechanism does
    not close, with the open joints in ``gaps``; ``note`` says where it jams. Raises ModelError.
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
        "drivers": [
            name for name, driver in pose.mechanism.drivers.items() if driver.slider == joint.name
        ],
        "guide": list(row.unit()) if isinstance(row, Guided) else None,
        "pinned": isinstance(row, Coincide), "fixed": turn_row(joint.rows()) is not None,
    }  # fmt: skip
