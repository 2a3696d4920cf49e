"""Where the parts of a mechanism are at its start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...errors import VfifeError
from ...kinematics.drives import standing
from ...kinematics.guess import first_guess
from ...kinematics.initial import Motion, attempt, ideal_motion
from ...kinematics.pins import world
from ...model.joints import Joint
from ...model.lumping import rigid_properties
from ...model.mechanism import Mechanism
from ...model.rows import Coincide, place_row

Array = NDArray[np.float64]
Side = tuple[str, str]  # body or ground, and pin
Point = tuple[float, float]


def pin_side(pin: str) -> Side:
    """Return the body and the name of a pin."""
    body, _, name = pin.partition(".")
    return body, name


@dataclass(frozen=True, eq=False)
class Pose:
    """A mechanism at its start: its ``motion`` there, or the error that says why it cannot be closed.

    ``centers`` are positions and angles of the centres of mass, shape (bodies + 1, 3), ground first: closed,
    or approximate if it cannot be closed.
    """

    mechanism: Mechanism
    motion: Motion | VfifeError
    centers: Array

    @classmethod
    def of(cls, mechanism: Mechanism) -> Pose:
        """Close a mechanism."""
        motion = attempt(ideal_motion, standing(mechanism))
        place = motion.position if isinstance(motion, Motion) else first_guess(mechanism)
        return cls(mechanism, motion, place)

    @property
    def names(self) -> tuple[str, ...]:
        """Bodies in the order of ``centers``."""
        return ("ground", *self.mechanism.bodies)

    def place(self, side: Side) -> Point:
        """Return the position of a pin (m)."""
        return world(self.mechanism, self.centers, self.names, side)

    def angle(self, body: str) -> float:
        """Return the angle of a body (rad)."""
        return 0.0 if body == "ground" else float(self.centers[self.names.index(body)][2])

    def local(self, body: str, place: Point) -> Point:
        """Return a place (m) in the frame of a body."""
        x, y = np.subtract(place, self.origin(body)).tolist()
        return turned((x, y), -self.angle(body))

    def origin(self, body: str) -> Point:
        """Return the position of the origin of a body's frame (m)."""
        if body == "ground":
            return 0.0, 0.0
        [frame] = frames(self.mechanism, self.centers[None, [self.names.index(body)]], (body,))[0]
        return float(frame[0]), float(frame[1])

    @cached_property
    def size(self) -> float:
        """Largest extent of pins and points of the ground (m)."""
        places = [self.place(side) for side in self.sides]
        return float(np.ptp(np.array(places or [(0.0, 0.0)]), axis=0).max()) or 1.0

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """All pins and points of the ground."""
        ground = [("ground", name) for name in self.mechanism.points]
        bodies = [(body, pin) for body, part in self.mechanism.bodies.items() for pin in part.points]
        return (*ground, *bodies)

    def cluster(self, side: Side) -> tuple[Side, ...]:
        """Return a pin with all that revolute joints and welds hold in the same place."""
        result, waiting = {side: None}, [side]
        while waiting:
            side_to_visit = waiting.pop()
            for joint in self.mechanism.joints.values():
                if side_to_visit in joint.sides and isinstance(place_row(joint.rows()), Coincide):
                    for neighbour in joint.sides:
                        if neighbour not in result:
                            result[neighbour] = None
                            waiting.append(neighbour)
        return tuple(result)

    @cached_property
    def surplus(self) -> int:
        """Number of motions that joints, gears and drivers hold beyond those of the bodies (Grübler's
        count); redundant ones are counted.
        """
        rows = [row for joint in self.mechanism.joints.values() for row in joint.rows()]
        constraints = sum(2 if isinstance(row, Coincide) else 1 for row in rows) + len(self.mechanism.gears)
        constraints += sum(driver.moves for driver in self.mechanism.drivers.values())
        return constraints - 3 * len(self.mechanism.bodies)

    def gap(self, joint: Joint) -> float:
        """Return the distance (m) of the two pins of a joint that is to hold them together; 0 for others."""
        if not isinstance(place_row(joint.rows()), Coincide):
            return 0.0
        return math.dist(self.place(joint.sides[0]), self.place(joint.sides[1]))


def turned(vector: Point, angle: float) -> Point:
    """Return a vector turned by an angle (rad)."""
    (x, y), c, s = vector, math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def frames(mechanism: Mechanism, centers: Array, names: tuple[str, ...]) -> Array:
    """Return positions and angles (..., bodies, 3) of the frames' origins from those of centres of mass."""
    offset = np.array([rigid_properties(mechanism.bodies[name])[1] for name in names]).reshape(-1, 2)
    c, s = np.cos(centers[..., 2]), np.sin(centers[..., 2])
    result = centers.copy()
    result[..., 0] -= c * offset[:, 0] - s * offset[:, 1]
    result[..., 1] -= s * offset[:, 0] + c * offset[:, 1]
    return result
