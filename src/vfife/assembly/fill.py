"""Parameters and start values of assembled mechanisms, written into their states.

Mechanisms of one topology are written side by side: what is a number of one mechanism is a column [cases]
here, and one mechanism is a batch of one. Operations are elementwise, so no case sees another one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.arrays import Layout
from ..kernels.constraint import relative_turn
from ..kernels.polynomial import polynomial
from ..kernels.topology import ALONG_LINE, FREE, LINEAR, Topology
from ..kinematics.drives import kinematic_drivers
from ..kinematics.forces import spring_fields
from ..kinematics.initial import Motion
from ..kinematics.start import Seat
from ..laws import Pair
from ..model.joints import Contact
from ..model.mechanism import Mechanism
from ..model.rows import Touching
from ..numerics.elementwise import hypot, sincos
from .assembled import BodyMap
from .entities import Numbering, Parts
from .prestress import PrestressedState
from .timestep import StepModels

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Draft:
    """A mechanism numbered, with the motion of its start: all that its state is filled from.

    ``contacts``: values of the blocks TOUCHED of each contact; ``lengths``: free lengths of springs (m, rad)
    where the start is not the model's own; ``stressed``: a start without ringing, if it has one;
    ``notes``: cautions about the start.
    """

    mechanism: Mechanism
    motion: Motion
    numbering: Numbering
    parts: Parts
    contacts: Sequence[Sequence[Sequence[float]]]
    tables: Array
    topology: Topology
    seats: Mapping[str, Seat]
    lengths: Mapping[str, float]
    stressed: PrestressedState | None
    notes: tuple[str, ...] = ()

    @cached_property
    def moves(self) -> Array:
        """Position and velocity [2, bodies + 1, 3] of the centres of mass, or of the first particles in a
        start without ringing.
        """
        if self.stressed is None:
            return np.array([self.motion.position, self.motion.velocity])
        rows = self.stressed.position, self.stressed.velocity
        return np.array([[np.zeros(3), *(row[name][0] for name in self.mechanism.bodies)] for row in rows])


class Filler:
    """Writes parameters and start values of mechanisms of one topology into ``states`` [cases, rows]."""

    def __init__(self, drafts: Sequence[Draft], layout: Layout) -> None:
        self.drafts, self.layout, self.first = drafts, layout, drafts[0]
        self.states = np.zeros((len(drafts), layout.rows))
        with np.errstate(over="ignore", invalid="ignore"):
            self._bodies()
            self._ideals()
            self._contacts()
            self._springs()
            self._drivers_and_loads()

    def put(self, name: str, values: Any, index: Any = slice(None), case: Any = slice(None)) -> None:
        """Set a block, or some entries of it: [cases, entries], or those of one case."""
        self.states[case, self.layout[name][index]] = values

    def columns(self, values: Callable[[Draft], Any]) -> Array:
        """Numbers of each mechanism [cases, ...]."""
        return np.array([values(draft) for draft in self.drafts], dtype=float)

    def angle(self, particle: int) -> Array:
        """Return the angle (rad) of a particle at the start, shape (cases,)."""
        return self.states[:, self.layout.row("particle_theta", particle)]

    def pins(self, particles: Sequence[int], points: Array) -> tuple[Array, Array]:
        """Where points of particles [cases, particles, 2] are at the start (m) [cases, particles]."""
        px, py, angle = (
            self.states[:, self.layout[f"particle_{axis}"][list(particles)]] for axis in ("x", "y", "theta")
        )
        s, c = sincos(angle)
        x, y = points[..., 0], points[..., 1]
        return px + c * x - s * y, py + s * x + c * y

    def step_models(self, expected: Sequence[Mapping[str, float]], turning: Array | None) -> StepModels:
        """Return what the steps of the mechanisms depend on, with the ``expected`` forces (N) of their joints
        and the result of :func:`~.stability.turning_errors`.
        """
        first, drafts = self.first, self.drafts
        owners = [name for name, body in first.numbering.bodies.items() for _ in body.elements]
        ideals = [joint.name for joint in first.parts.ideals]
        free = [draft.motion.mobility.after_drives for draft in drafts]
        mechanisms, touches = [draft.mechanism for draft in drafts], [draft.parts.touches for draft in drafts]
        return StepModels(
            mechanisms,
            self.layout,
            self.states,
            first.topology,
            touches,
            owners,
            ideals,
            expected,
            free,
            turning,
        )

    def _bodies(self) -> None:
        """Masses, loads, positions and velocities of particles; stiffness and reference of elements."""
        bodies = self.first.numbering.bodies
        rigid = [name for name, body in bodies.items() if not body.elements]
        if rigid:
            lumps = self.columns(lambda draft: [_lump(draft.numbering.bodies[name]) for name in rigid])
            mass, inertia, x, y = np.moveaxis(lumps, -1, 0)
            rows = [self.first.motion.names.index(name) for name in rigid]
            moves = self.columns(lambda draft: draft.moves)[:, :, rows]
            position, velocity = np.moveaxis(moves, (1, 3), (0, 1))
            place, speed = point_motion(position, velocity, x, y)
            self._particles([bodies[name].particles[0] for name in rigid], mass, inertia, place, speed)
        for case, draft in enumerate(self.drafts if len(rigid) < len(bodies) else ()):
            for name in draft.numbering.meshes:
                self._elastic(case, draft, name)

    def _particles(
        self,
        particles: list[int],
        mass: Array,
        inertia: Array,
        place: Sequence[Array],
        speed: Sequence[Array],
    ) -> None:
        """Particles that stand for rigid bodies, their numbers [cases, particles]."""
        moving = set(self.first.numbering.free)
        free = np.array([particle in moving for particle in particles], dtype=bool)
        gravity = self.columns(lambda draft: draft.mechanism.gravity)
        turns = inertia > 0.0
        values = {
            "x": place[0], "y": place[1], "theta": place[2],
            "load_x": mass * gravity[:, :1], "load_y": mass * gravity[:, 1:],
            "u": np.where(free, speed[0], 0.0), "v": np.where(free, speed[1], 0.0), "w": speed[2],
            "inverse_mass": np.where(free, 1.0 / mass, 0.0),
            "inverse_inertia": np.where(free & turns, 1.0 / np.where(turns, inertia, 1.0), 0.0),
        }  # fmt: skip
        for name, columns in values.items():
            self.put(f"particle_{name}", columns, particles)

    def _elastic(self, case: int, draft: Draft, name: str) -> None:
        body, mesh = draft.numbering.bodies[name], draft.numbering.meshes[name]
        place, moving = _moved(draft, name)
        free = np.ones(len(body.particles), dtype=bool)
        if body.driven is not None:
            free[draft.numbering.driven_particle(name) - body.particles[0]] = False
        inertia = np.where(mesh.inertia > 0.0, mesh.inertia, np.inf)
        gravity = draft.mechanism.gravity
        lumps = {
            "x": place[:, 0], "y": place[:, 1], "theta": place[:, 2],
            "u": np.where(free, moving[:, 0], 0.0), "v": np.where(free, moving[:, 1], 0.0), "w": moving[:, 2],
            "inverse_mass": np.where(free, 1.0 / mesh.mass, 0.0),
            "inverse_inertia": np.where(free, 1.0 / inertia, 0.0),
            "load_x": mesh.mass * gravity[0], "load_y": mesh.mass * gravity[1],
        }  # fmt: skip
        chord = place[mesh.nodes[:, 1], :2] - place[mesh.nodes[:, 0], :2]
        length = hypot(chord[:, 0], chord[:, 1])
        values = {
            "reference_length": length,
            "reference_inverse_length": 1.0 / (mesh.length if mesh.strain == "reference" else length),
            "reference_cosine": chord[:, 0] / length, "reference_sine": chord[:, 1] / length,
            "reference_theta_1": place[mesh.nodes[:, 0], 2], "reference_theta_2": place[mesh.nodes[:, 1], 2],
            "frame_axial_stiffness": mesh.axial, "frame_bending_stiffness": mesh.bending,
        }  # fmt: skip
        if draft.stressed is not None and name in draft.stressed.shapes:
            shape = draft.stressed.shapes[name]
            for kind in ("frame", "reference") if draft.mechanism.settings.path_unit > 1 else ("frame",):
                values |= {
                    f"{kind}_axial_force": shape.axial,
                    f"{kind}_moment_1": shape.moment_1,
                    f"{kind}_moment_2": shape.moment_2,
                }
        particles, elements = (
            slice(indices[0], indices[-1] + 1) for indices in (body.particles, body.elements)
        )
        for block, value in lumps.items():
            self.put(f"particle_{block}", value, particles, case)
        for block, value in values.items():
            self.put(block, value, elements, case)

    def _ends(
        self, kind: str, ends: Callable[[Parts], Any], sides: tuple[str, str] = ("bearing", "journal")
    ) -> Array:
        """Write the two places of each entity and return their points (m) [cases, entities, 2 sides, 2]."""
        points = self.columns(lambda draft: [[place[1] for place in pair] for pair in ends(draft.parts)])
        return self._put_ends(kind, points.reshape(len(self.drafts), -1, 2, 2), sides)

    def _put_ends(self, kind: str, points: Array, sides: tuple[str, str] = ("bearing", "journal")) -> Array:
        """Write the points of entities (m) [cases, entities, 2 sides, 2] and return them."""
        for k, side in enumerate(sides):
            for axis, name in enumerate("xy"):
                self.put(f"{kind}_{side}_{name}", points[:, :, k, axis])
        return points

    def _ideals(self) -> None:
        """Pins, guides and ratios of ideal joints; what their bodies keep between them is what they have at
        the start.
        """
        self.put("size", 1.0)
        ideals = self.first.parts.ideals
        if not ideals:
            return
        values = self.columns(lambda draft: [joint.numbers for joint in draft.parts.ideals])
        points = self._put_ends("joint", values[..., :4].reshape(len(self.drafts), -1, 2, 2))
        numbers = values[..., 4:]
        for k, block in enumerate(("direction_x", "direction_y", "ratio")):
            self.put(f"joint_{block}", numbers[..., k])
        for index in range(len(ideals)):
            self.put("joint_offset", self._offset(index, points[:, index], numbers[:, index]), index)
        moving = np.array([[end[0] > 0 for end in (joint.bearing, joint.journal)] for joint in ideals])
        largest = np.where(moving, hypot(points[..., 0], points[..., 1]), 0.0).max(axis=(1, 2))
        self.put("size", np.where(largest > 0.0, largest, 1.0), 0)

    def _offset(self, index: int, points: Array, numbers: Array) -> Any:
        """Return the value that an ideal joint keeps constant (m or rad) [cases].

        points: pins of both sides (m) [cases, 2 sides, 2]
        numbers: direction, transmission ratio and length (m) [cases, 4]
        """
        joint = self.first.parts.ideals[index]
        if joint.restraint.turn == FREE and joint.restraint.place != ALONG_LINE:
            return numbers[:, 3]
        begin = 0.0 if joint.function < 0 else self.columns(lambda draft: _at_start(draft, joint.function))
        bearing, journal = joint.bearing[0], joint.journal[0]
        if joint.restraint.place != ALONG_LINE:
            angles = self.angle(bearing), self.angle(journal), self.angle(joint.carrier)
            return relative_turn(angles[0], angles[1], numbers[:, 2], angles[2]) - begin
        s, c = sincos(self.angle(bearing))
        dx, dy = c * numbers[:, 0] - s * numbers[:, 1], s * numbers[:, 0] + c * numbers[:, 1]
        x, y = self.pins((bearing, journal), points)
        return dx * (x[:, 1] - x[:, 0]) + dy * (y[:, 1] - y[:, 0]) - begin

    def _contacts(self) -> None:
        """Pins, sizes and laws of contacts; contact under way where journals start where the ideal reaction
        presses them.
        """
        self.contacts = self._ends(
            "contact", lambda parts: [(touch.bearing, touch.journal) for touch in parts.touches]
        )
        for index, touch in enumerate(self.first.parts.touches):
            blocks = zip(*(draft.contacts[index] for draft in self.drafts), strict=True)
            for block, values in zip(TOUCHED, blocks, strict=True):
                row = self.layout.row(block, index)
                self.states[:, row : row + len(values[0])] = values
            for case, draft in enumerate(self.drafts):
                if touch.name in draft.seats:
                    seat, floor = draft.seats[touch.name], draft.parts.touches[index].joint.impact_speed_floor
                    self.put("contact_slowness", 1.0 / floor, index, case)
                    self.put("contact_normal_force", seat.force, index, case)
                    self.put("contact_penetration", seat.depth, index, case)
        topology = self.first.topology
        if topology.contact_knots or topology.path_pieces or topology.wears:
            for case, draft in enumerate(self.drafts):
                self._records(self.states[case], draft.parts)

    def _records(self, state: Array, parts: Parts) -> None:
        """Laws that are tables, pieces of the paths of joints and contacts, and depths of worn surfaces, of
        bearing and journal of one contact after the other.
        """
        records = {
            "knot": [piece for touch in parts.touches for piece in touch.joint.contact.knots()],
            "piece": [numbers for path in parts.paths for numbers in path.numbers()],
        }
        for record, pieces in records.items():
            for index, numbers in enumerate(pieces):
                start = self.layout.record(record, index)
                state[start : start + len(numbers)] = numbers
        wears = [touch.joint.wear for touch in parts.touches if touch.joint.wear is not None]
        depths = [
            profile for wear in wears for profile in (wear.bearing_profile, wear.journal_profile) if profile
        ]
        harmonics = [number for mean, *coefficients in depths for number in (mean, 0.0, *coefficients)]
        state[self.layout.rows_of("harmonic_cosine")] = harmonics[::2]
        state[self.layout.rows_of("harmonic_sine")] = harmonics[1::2]

    @cached_property
    def depths(self) -> list[list[float]]:
        """Penetration (m) of each contact of each case at the start, negative where surfaces are apart."""
        touches = self.first.parts.touches
        if not touches:
            return [[]] * len(self.drafts)
        ends = [[touch.bearing[0] for touch in touches], [touch.journal[0] for touch in touches]]
        places = np.array([self.pins(particles, self.contacts[:, :, k]) for k, particles in enumerate(ends)])
        s, c = sincos(self.states[:, self.layout["particle_theta"][ends[0]]])
        x, y = places[1] - places[0]
        local = np.stack([c * x + s * y, c * y - s * x], axis=-1).tolist()
        return [
            [float(touch.touching.depth(*at)) for touch, at in zip(draft.parts.touches, points, strict=True)]
            for draft, points in zip(self.drafts, local, strict=True)
        ]

    def _springs(self) -> None:
        """Stiffness, damping and free lengths; those that are not given are what the start has, and the
        model's own where another one was given.
        """
        springs = self.first.parts.springs
        points = self._ends(
            "spring", lambda parts: [spring[2:4] for spring in parts.springs], ("first", "second")
        )
        for index, (_, kind, first, second) in enumerate(springs):
            starts = self._distance(kind, (first[0], second[0]), points[:, index])
            for case, draft in enumerate(self.drafts):
                spring = draft.parts.springs[index][0]
                start = draft.lengths.get(spring.name, float(starts[case]))
                for name, values in spring_fields(spring, start).items():
                    row = self.layout.row(f"spring_{name}", index)
                    self.states[case, row : row + len(values)] = values

    def _distance(self, kind: int, particles: tuple[int, int], points: Array) -> Array:
        """Distance (m) or angle (rad) between two places at the start [cases]."""
        if kind == LINEAR:
            x, y = self.pins(particles, points)
            return np.asarray(hypot(x[:, 1] - x[:, 0], y[:, 1] - y[:, 0]))
        return np.asarray(self.angle(particles[1]) - self.angle(particles[0]))

    def _drivers_and_loads(self) -> None:
        """Parameters of drivers and of loads."""
        for index, name in enumerate(self.first.numbering.driven):
            driven = np.array([_driven(draft, name) for draft in self.drafts])
            for k, block in enumerate(DRIVEN):
                self.put(f"driven_{block}", driven[:, k], index)
        if self.first.parts.loads:
            loads = self.columns(
                lambda draft: [(*load.place[1], *load.force, load.moment) for load in draft.parts.loads]
            )
            for k, block in enumerate(("load_x", "load_y", "load_fx", "load_fy", "load_m")):
                self.put(block, loads[..., k])
        for function, numbers in self.first.numbering.travels.items():
            row = self.layout.row("function_first_x", function)
            self.states[:, row : row + len(numbers)] = [
                draft.numbering.travels[function] for draft in self.drafts
            ]


def _lump(body: BodyMap) -> tuple[float, ...]:
    """Mass (kg), inertia (kg m^2), and the particle's place (m) seen from the centre of mass."""
    (x, y), (cx, cy) = body.reference, body.center
    return body.mass, body.inertia, x - cx, y - cy


def _moved(draft: Draft, name: str) -> tuple[Array, Array]:
    """Positions and velocities (n, 3) of an elastic body's particles: bent as its forces want, or moved as a
    rigid body.
    """
    if draft.stressed is not None and name in draft.stressed.shapes:
        return draft.stressed.position[name], draft.stressed.velocity[name]
    position, velocity = draft.moves[:, draft.motion.names.index(name)]
    x, y = (draft.numbering.meshes[name].position - np.array(draft.numbering.bodies[name].center)).T
    place, moving = point_motion(position, velocity, x, y)
    row = np.ones(len(x))
    return np.column_stack([part * row for part in place]), np.column_stack([part * row for part in moving])


def _at_start(draft: Draft, function: int) -> float:
    """Return the value of a function of time at the start."""
    return float(polynomial(draft.tables, draft.topology.function_start[function], 0.0)[0])


DRIVEN = ("angle", "speed", "inertia", "moment_x", "moment_y", "weight_x", "weight_y")


def _driven(draft: Draft, name: str) -> tuple[float, ...]:
    """Return the values of the blocks DRIVEN of a driven body: angle (rad), speed (rad/s), inertia (kg m²),
    first moments of mass (kg m), gravity (m/s²).
    """
    numbering, mechanism = draft.numbering, draft.mechanism
    body, driver = numbering.bodies[name], kinematic_drivers(mechanism)[name]
    rx, ry = body.center[0] - body.reference[0], body.center[1] - body.reference[1]
    mass, inertia = body.mass, body.inertia + body.mass * (rx * rx + ry * ry)
    if body.elements:
        node, mesh = numbering.driven_particle(name) - body.particles[0], numbering.meshes[name]
        mass, inertia, rx, ry = float(mesh.mass[node]), float(mesh.inertia[node]), 0.0, 0.0
    angle = draft.motion.datum.angle.get(name, mechanism.bodies[name].angle)
    return angle, driver.steady_speed or 0.0, inertia, mass * rx, mass * ry, *mechanism.gravity


TOUCHED = (
    "contact_size", "contact_line_x", "contact_line_y", "contact_arm_bearing", "contact_arm_journal",
    "contact_arm_overlap", "contact_floor", "contact_landing", "contact_slots", "contact_friction_slots",
)  # fmt: skip


def touch_values(joint: Contact, touching: Touching, pair: Pair) -> tuple[tuple[float, ...], ...]:
    """Return the values of the blocks TOUCHED of a contact between the surfaces of ``pair``."""
    arms = touching.centred if joint.friction_moment == "off" or joint.contact.film else touching.arms
    overlap = 0.5 if joint.friction_moment == "mid-overlap" and not joint.contact.film else 0.0
    return (
        (touching.size,), (touching.normal[0],), (touching.normal[1],), (arms[0],), (arms[1],), (overlap,),
        (joint.impact_speed_floor,), (joint.landing,),
        joint.contact.parameters(pair)[: len(joint.contact.slots)], joint.friction.parameters(pair),
    )  # fmt: skip


def point_motion(position: Any, velocity: Any, x: Any, y: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Position and velocity of points (m) of a rigid body, seen from its centre of mass in its frame."""
    s, c = sincos(position[2])
    rx, ry, w = c * x - s * y, s * x + c * y, velocity[2]
    return (position[0] + rx, position[1] + ry, position[2]), (velocity[0] - w * ry, velocity[1] + w * rx, w)
