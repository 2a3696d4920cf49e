"""Parameters and start values of an assembled mechanism, written into S."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.arrays import Layout
from ..kernels.constraint import relative_turn
from ..kernels.polynomial import polynomial
from ..kernels.topology import ALONG, FREE, LINEAR
from ..kinematics.drives import kinematic_drivers
from ..kinematics.forces import spring_fields
from ..kinematics.initial import Motion, Seat
from ..laws import Pair
from ..model.geometry.path import Path
from ..model.joints import Contact
from ..model.mechanism import Mechanism
from ..model.rows import Touching
from ..model.springs import AnySpring
from ..model.surfaces import surfaces
from ..numerics.elementwise import hypot, sincos
from .assembled import BodyMap
from .entities import Numbering, Place
from .prestress import PrestressedState

if TYPE_CHECKING:
    from .entities import Ideal, Load, Touch


class Filler:
    """Writes parameters and start values into S."""

    def __init__(
        self,
        mechanism: Mechanism,
        numbering: Numbering,
        layout: Layout,
        motion: Motion,
        stressed: PrestressedState | None,
        *,
        restart: bool = False,
    ) -> None:
        self.lengths = motion.datum.spring if restart else {}
        self.mechanism, self.numbering, self.layout, self.motion, self.stressed = (
            mechanism,
            numbering,
            layout,
            motion,
            stressed,
        )
        self.state = np.zeros(layout.rows)
        self.free = frozenset(numbering.free)

    def put(self, name: str, value: Any, index: int | slice | None = None) -> None:
        """Sets a block, or some entries of it."""
        rows = self.layout[name]
        self.state[rows if index is None else rows[index]] = value

    def bodies(self) -> None:
        """Masses, loads, positions and velocities of particles; stiffness and reference of elements."""
        for name, where in self.numbering.bodies.items():
            if where.elements:
                self._elastic(name, where)
            else:
                self._rigid(where)

    def _particle(self, p: int, mass: float, inertia: float, motion: tuple[Any, Any]) -> None:
        position, velocity = motion
        for axis, value in zip(("x", "y", "theta"), coordinates(position), strict=True):
            self.put(f"particle_{axis}", value, p)
        self.put("particle_load_x", mass * self.mechanism.gravity[0], p)
        self.put("particle_load_y", mass * self.mechanism.gravity[1], p)
        if p not in self.free:
            self.put("particle_w", coordinates(velocity)[2], p)
            return
        for axis, value in zip("uvw", coordinates(velocity), strict=True):
            self.put(f"particle_{axis}", value, p)
        self.put("particle_inverse_mass", 1.0 / mass, p)
        self.put("particle_inverse_inertia", 1.0 / inertia if inertia > 0.0 else 0.0, p)

    def _rigid(self, where: BodyMap) -> None:
        position, velocity, _ = self.motion.of(where.name)
        if self.stressed is not None:
            position, velocity = self.stressed.position[where.name][0], self.stressed.velocity[where.name][0]
        beyond = (where.reference[k] - where.center[k] for k in (0, 1))
        at, moving = point_motion(coordinates(position), coordinates(velocity), *beyond)
        self._particle(where.particles[0], where.mass, where.inertia, (at, moving))

    def _elastic(self, name: str, where: BodyMap) -> None:
        mesh = self.numbering.meshes[name]
        there, moving = self._moved(name, where)
        particles = slice(where.particles[0], where.particles[-1] + 1)
        free = np.ones(len(where.particles), dtype=bool)
        if where.driven is not None:
            free[self.numbering.held(name) - where.particles[0]] = False
        for axis, block in enumerate(("x", "y", "theta")):
            self.put(f"particle_{block}", there[:, axis], particles)
        for axis, block in enumerate("uvw"):
            self.put(f"particle_{block}", np.where(free | (block == "w"), moving[:, axis], 0.0), particles)
        inertia = np.where(mesh.inertia > 0.0, mesh.inertia, np.inf)
        self.put("particle_inverse_mass", np.where(free, 1.0 / mesh.mass, 0.0), particles)
        self.put("particle_inverse_inertia", np.where(free, 1.0 / inertia, 0.0), particles)
        for axis, block in enumerate("xy"):
            self.put(f"particle_load_{block}", mesh.mass * self.mechanism.gravity[axis], particles)
        chord = there[mesh.nodes[:, 1], :2] - there[mesh.nodes[:, 0], :2]
        length = hypot(chord[:, 0], chord[:, 1])
        values = {
            "reference_length": length,
            "reference_inverse_length": 1.0 / (mesh.length if mesh.strain == "reference" else length),
            "reference_cosine": chord[:, 0] / length, "reference_sine": chord[:, 1] / length,
            "reference_theta_1": there[mesh.nodes[:, 0], 2], "reference_theta_2": there[mesh.nodes[:, 1], 2],
            "frame_axial_stiffness": mesh.axial, "frame_bending_stiffness": mesh.bending,
        }  # fmt: skip
        if self.stressed is not None and name in self.stressed.shapes:
            shape = self.stressed.shapes[name]
            for kind in ("frame", "reference") if self.mechanism.settings.path_unit > 1 else ("frame",):
                values |= {
                    f"{kind}_axial_force": shape.axial,
                    f"{kind}_moment_1": shape.moment_1,
                    f"{kind}_moment_2": shape.moment_2,
                }
        elements = slice(where.elements[0], where.elements[-1] + 1)
        for block, value in values.items():
            self.put(block, value, elements)

    def _moved(self, name: str, where: BodyMap) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions and velocities (n, 3) of an elastic body's particles: bent as its forces want, or moved
        as a rigid body.
        """
        position, velocity, _ = self.motion.of(name)
        if self.stressed is not None:
            if name in self.stressed.shapes:
                return self.stressed.position[name], self.stressed.velocity[name]
            position, velocity = self.stressed.position[name][0], self.stressed.velocity[name][0]
        x, y = (self.numbering.meshes[name].position - np.array(where.center)).T
        there, moving = point_motion(coordinates(position), coordinates(velocity), x, y)
        ones = np.ones(len(x))
        return np.column_stack([value * ones for value in there]), np.column_stack(
            [value * ones for value in moving]
        )

    def _pins(
        self, kind: str, index: int, ends: Sequence[Place], sides: tuple[str, str] = ("bearing", "journal")
    ) -> None:
        for side, (_, at) in zip(sides, ends, strict=True):
            for axis, value in zip("xy", at, strict=True):
                self.put(f"{kind}_{side}_{axis}", value, index)

    def ideals(self, ideals: Sequence[Ideal], tables: NDArray[np.float64]) -> None:
        """Pins, guides and ratios of ideal joints; what their bodies keep between them is what they have at
        the start.
        """
        for index, joint in enumerate(ideals):
            self._pins("joint", index, (joint.bearing, joint.journal))
            for axis, value in zip("xy", joint.direction, strict=True):
                self.put(f"joint_direction_{axis}", value, index)
            self.put("joint_ratio", joint.ratio, index)
            self.put("joint_offset", self._offset(joint, tables), index)
        arms = [hypot(*end[1]) for joint in ideals for end in (joint.bearing, joint.journal) if end[0] > 0]
        self.put("size", max(arms) or 1.0 if arms else 1.0, 0)

    def _offset(self, joint: Ideal, tables: NDArray[np.float64]) -> Any:
        if joint.turn == FREE and joint.place != ALONG:
            return joint.length
        angles = [self.angle(end) for end in (joint.bearing, joint.journal)]
        begin = 0.0 if joint.function < 0 else self._function(joint.function, tables)
        if joint.place != ALONG:
            carrier = self.angle((joint.carrier, (0.0, 0.0)))
            return relative_turn(angles[0], angles[1], joint.ratio, carrier) - begin
        s, c = sincos(angles[0])
        dx, dy = (
            c * joint.direction[0] - s * joint.direction[1],
            s * joint.direction[0] + c * joint.direction[1],
        )
        (bx, by), (kx, ky) = self.pin_place(joint.bearing), self.pin_place(joint.journal)
        return dx * (kx - bx) + dy * (ky - by) - begin

    def _function(self, index: int, tables: NDArray[np.float64]) -> float:
        start = 1 + sum(len(function.table()) for function in self.numbering.functions[:index])
        return float(polynomial(tables, start, 0.0)[0])

    def angle(self, place: Place) -> Any:
        """The angle of a particle at the start (rad)."""
        return float(self.state[self.layout.row("particle_theta", place[0])])

    def pin_place(self, place: Place) -> tuple[float, float]:
        """Where a place of a particle is at the start (m)."""
        p, (x, y) = place
        px, py = (float(self.state[self.layout.row(f"particle_{axis}", p)]) for axis in ("x", "y"))
        angle = self.angle(place)
        s, c = sincos(angle)
        return px + c * x - s * y, py + s * x + c * y

    def touches(self, touches: Sequence[Touch]) -> None:
        """Pins, sizes and laws of contacts."""
        for index, touch in enumerate(touches):
            self._pins("contact", index, (touch.bearing, touch.journal))
            for row, values in touch_rows(self.mechanism, self.layout, touch, index):
                self.state[row : row + len(values)] = values
        for index, piece in enumerate(piece for touch in touches for piece in touch.joint.contact.knots()):
            start = self.layout.record("knot", index)
            self.state[start : start + len(piece)] = piece

    def profiles(self, touches: Sequence[Touch]) -> None:
        """Depths of worn surfaces, of bearing and journal of one contact after the other."""
        wears = [touch.joint.wear for touch in touches if touch.joint.wear is not None]
        depths = [
            profile for wear in wears for profile in (wear.bearing_profile, wear.journal_profile) if profile
        ]
        numbers = [number for mean, *harmonics in depths for number in (mean, 0.0, *harmonics)]
        self.state[self.layout.rows_of("harmonic_cosine")] = numbers[::2]
        self.state[self.layout.rows_of("harmonic_sine")] = numbers[1::2]

    def paths(self, paths: Sequence[Path]) -> None:
        """Pieces of the paths of joints and contacts, one path after the other."""
        for index, numbers in enumerate(numbers for path in paths for numbers in path.numbers()):
            start = self.layout.record("piece", index)
            self.state[start : start + len(numbers)] = numbers

    def springs(self, springs: Sequence[tuple[AnySpring, int, Place, Place]]) -> None:
        """Stiffness, damping and free lengths; those that are not given are what the start has, and the
        model's own where another one was given.
        """
        for index, (spring, kind, first, second) in enumerate(springs):
            self._pins("spring", index, (first, second), ("first", "second"))
            start = (
                self.lengths[spring.name]
                if spring.name in self.lengths
                else self._free_length(kind, first, second)
            )
            for name, values in spring_fields(spring, start).items():
                row = self.layout.row(f"spring_{name}", index)
                self.state[row : row + len(values)] = values

    def _free_length(self, kind: int, first: Place, second: Place) -> Any:
        """Distance (m) or angle (rad) between two places at the start."""
        if kind == LINEAR:
            (ax, ay), (bx, by) = self.pin_place(first), self.pin_place(second)
            return hypot(bx - ax, by - ay)
        return self.angle(second) - self.angle(first)

    def seat(self, touches: Sequence[Touch], seats: Mapping[str, Seat]) -> None:
        """Contact under way in joints whose journals start where the ideal reaction presses them."""
        for index, touch in enumerate(touches):
            if touch.name in seats:
                self.put("contact_slowness", 1.0 / touch.joint.impact_speed_floor, index)
                self.put("contact_normal_force", seats[touch.name].force, index)
                self.put("contact_penetration", seats[touch.name].depth, index)

    def drivers_and_loads(self, loads: Sequence[Load]) -> None:
        """Parameters of drivers and of loads."""
        for index, name in enumerate(self.numbering.driven):
            where, driver = self.numbering.bodies[name], kinematic_drivers(self.mechanism)[name]
            rx, ry = where.center[0] - where.reference[0], where.center[1] - where.reference[1]
            mass, inertia = where.mass, where.inertia + where.mass * (rx * rx + ry * ry)
            if where.elements:
                held = self.numbering.held(name) - where.particles[0]
                mesh = self.numbering.meshes[name]
                mass, inertia, rx, ry = float(mesh.mass[held]), float(mesh.inertia[held]), 0.0, 0.0
            self.put(
                "driven_angle", self.motion.datum.angle.get(name, self.mechanism.bodies[name].angle), index
            )
            self.put("driven_speed", driver.steady_speed or 0.0, index)
            self.put("driven_inertia", inertia, index)
            self.put("driven_moment_x", mass * rx, index)
            self.put("driven_moment_y", mass * ry, index)
            self.put("driven_weight_x", self.mechanism.gravity[0], index)
            self.put("driven_weight_y", self.mechanism.gravity[1], index)
        for index, load in enumerate(loads):
            entries = (*load.place[1], *load.force, load.moment)
            for block, value in zip(
                ("load_x", "load_y", "load_fx", "load_fy", "load_m"), entries, strict=True
            ):
                self.put(block, value, index)
        for function, numbers in self.numbering.travels.items():
            first = self.layout.row("function_first_x", function)
            self.state[first : first + len(numbers)] = numbers


def touch_rows(
    mechanism: Mechanism, layout: Layout, touch: Touch, index: int
) -> list[tuple[int, tuple[float, ...]]]:
    """First row and values of a contact's numbers decided by its noun: sizes, arms of friction, laws."""
    values = touch_values(touch.joint, touch.touching, surfaces(mechanism, touch.joint))
    return [(layout.row(block, index), own) for block, own in zip(TOUCHED, values, strict=True)]


TOUCHED = (
    "contact_size", "contact_line_x", "contact_line_y", "contact_arm_bearing", "contact_arm_journal",
    "contact_arm_overlap", "contact_floor", "contact_landing", "contact_slots", "contact_friction_slots",
)  # fmt: skip


def touch_values(joint: Contact, touching: Touching, pair: Pair) -> tuple[tuple[float, ...], ...]:
    """The values of the blocks TOUCHED, of a contact between such surfaces."""
    arms = touching.centred if joint.friction_moment == "off" or joint.contact.film else touching.arms
    overlap = 0.5 if joint.friction_moment == "mid-overlap" and not joint.contact.film else 0.0
    return (
        (touching.size,), (touching.normal[0],), (touching.normal[1],), (arms[0],), (arms[1],), (overlap,),
        (joint.impact_speed_floor,), (joint.landing,),
        joint.contact.parameters(pair)[: len(joint.contact.slots)], joint.friction.parameters(pair),
    )  # fmt: skip


def coordinates(values: Any) -> tuple[Any, ...]:
    """x, y and angle of a motion."""
    return tuple(values)


def point_motion(position: Any, velocity: Any, x: Any, y: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Position and velocity of points (m) of a rigid body, seen from its centre of mass in its frame."""
    s, c = sincos(position[2])
    rx, ry, w = c * x - s * y, s * x + c * y, velocity[2]
    return (position[0] + rx, position[1] + ry, position[2]), (velocity[0] - w * ry, velocity[1] + w * rx, w)
