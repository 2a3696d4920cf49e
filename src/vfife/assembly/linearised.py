"""A mechanism as linear about its start, at rest: masses, tangent stiffness and constraints of its particles.

Joints count as ideal, drivers hold what they drive (or are released), and weight and springs press. What
bends under them has bent; rigid motions stay where the start has them. The stiffness is that of all forces, M
q'' + K q = 0 in motions that leave the joints closed, G q = 0: K = -d(f + G^T lambda)/dq with the forces f of
elements and springs, and the reactions lambda that carry them and the weight.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kernels import frame
from ..kernels.topology import LINEAR
from ..kinematics.constraints import Constraint
from ..kinematics.drives import standing
from ..kinematics.forces import End, kind_of_spring, pull
from ..kinematics.initial import ideal_motion
from ..kinematics.rows import ConstraintRows
from ..model.functions import bodies_at_rest
from ..model.lumping import Mesh
from ..model.mechanism import Mechanism
from ..model.springs import AnySpring
from ..numerics import dense
from ..numerics.dense import norm, product, times
from ..numerics.elementwise import atan2, hypot, sincos
from .entities import Numbering, Place, ideal_joints, spring_places

Array = NDArray[np.float64]
CHANGE = 2e-4  # m or rad: of differences of fourth order of springs and of directions of constraints
# of the largest w^2: motions that springs and elements hold by more settle under weight, others stay
STIFF = 1e-10
SETTLINGS = 3  # Newton steps of that
RANK = 1e-7  # singular value of constraints, of 1 each, below which they depend on one another


@dataclass(frozen=True, eq=False)
class Linearised:
    """M q'' + K q = 0 in the motions G q = 0 of the particles' (x, y, theta).

    ``mass`` (3 n,), 0 where nothing moves; ``stiffness`` and ``motions`` in mass-weighted coordinates sqrt(M)
    q of the ``moving`` ones of these: (m, m) and (m, k), whose k columns are orthonormal and leave the joints
    closed. ``position`` (n, 3) of the particles, the ground first. ``unbalanced`` is the share of weight and
    springs that nothing carries: 0 in equilibrium.
    """

    numbering: Numbering
    position: Array
    mass: Array
    moving: NDArray[np.intp]
    stiffness: Array
    motions: Array
    unbalanced: float


def linearised(mechanism: Mechanism, released: bool = False) -> Linearised:
    """About the start; ``released``: without drivers. Raises AssemblyError where the links cannot reach."""
    joints = {
        name: ideal for name, joint in mechanism.joints.items() if (ideal := joint.reference) is not None
    }
    bodies = bodies_at_rest(mechanism)
    drivers = {} if released else {name: driver for name, driver in mechanism.drivers.items() if driver.moves}
    reference = dataclasses.replace(mechanism, joints=joints, bodies=bodies, drivers=drivers, loads={})
    return _Parts(reference).settled()


@dataclass(frozen=True, eq=False)
class _There:
    """At one position, mass-weighted but for the stiffness: forces, constraints with the sizes of their rows,
    motions that these leave.
    """

    push: Array
    stiffness: Array
    rows: Array
    sizes: Array
    motions: Array


class _Parts:
    """What pulls and holds, particle by particle."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.numbering = mechanism, Numbering(mechanism)
        self.position, self.mass = self._start(), self._masses()
        self.moving = np.flatnonzero(self.mass > 0.0)
        self.elements = [
            element
            for name, part in self.numbering.meshes.items()
            for element in elements_of(part, self.numbering.bodies[name].particles[0])
        ]
        self.springs = [
            (spring, *spring_places(self.numbering, spring)) for spring in mechanism.springs.values()
        ]
        self.apart = [_free_length(spring, ends, self.position) for spring, *ends in self.springs]
        self.joints = [
            Constraint(
                joint.name,
                joint.bearing[0],
                joint.journal[0],
                joint.restraint.rows,
                joint.bearing[1],
                joint.journal[1],
                body_c=joint.carrier,
            )
            for joint in ideal_joints(mechanism, self.numbering)
        ]

    def _start(self) -> Array:
        """Particles (n, 3) as the rigid mechanism closes, at rest."""
        settings = dataclasses.replace(self.mechanism.settings, analysis="static")
        motion = ideal_motion(standing(dataclasses.replace(self.mechanism, settings=settings)))
        result = np.zeros((self.numbering.count, 3))
        for name, body in self.numbering.bodies.items():
            at = motion.of(name)[0]
            s, c = sincos(at[2])
            local = (
                self.numbering.meshes[name].position
                if name in self.numbering.meshes
                else np.array([body.reference])
            )
            arms = product(local - np.array(body.center), np.array([[c, s], [-s, c]]))
            result[list(body.particles)] = np.column_stack([at[:2] + arms, np.full(len(arms), at[2])])
        return result

    def _masses(self) -> Array:
        result = np.zeros((self.numbering.count, 3))
        for name, body in self.numbering.bodies.items():
            particles = list(body.particles)
            part = self.numbering.meshes.get(name)
            result[particles, 0] = result[particles, 1] = body.mass if part is None else part.mass
            result[particles, 2] = body.inertia if part is None else part.inertia
        fixed = np.setdiff1d(np.arange(self.numbering.count), self.numbering.free)
        result[fixed] = 0.0
        return result.reshape(-1)

    def settled(self) -> Linearised:
        """Return the mechanism linearised about its static deflection under its weight.

        Newton's method in the directions that the constraints leave free. It stops where the unbalanced force
        no longer decreases, and keeps the best position.
        """
        self._leave_spinning(self.position)
        root = np.sqrt(self.mass[self.moving])
        position, smallest = self.position, np.inf
        trial = self.position.copy()
        for _ in range(SETTLINGS + 1):
            trial_state = self._at(trial, root)
            values, vectors = dense.eigh(
                product(
                    product(trial_state.motions.T, self._weighted(trial_state.stiffness, root)),
                    trial_state.motions,
                )
            )
            stiff = values > STIFF * max(float(values.max(initial=0.0)), 1e-300)
            unbalanced = times(vectors[:, stiff].T, times(trial_state.motions.T, trial_state.push))
            if not norm(unbalanced) < smallest:  # too soft for a few steps of Newton's method: as it starts
                break
            position, smallest = trial.copy(), norm(unbalanced)
            trial.reshape(-1)[self.moving] += (
                times(trial_state.motions, times(vectors[:, stiff], unbalanced / values[stiff])) / root
            )
        result, load = self._at(position, root), norm(self._applied()[self.moving] / root)
        multiplier = (
            dense.least_squares((result.rows / result.sizes[:, None]).T, -result.push, RANK) / result.sizes
        )
        weighted = self._weighted(result.stiffness + self.turning(position, multiplier), root)
        left = norm(times(result.motions.T, result.push))
        return Linearised(
            self.numbering,
            position,
            self.mass,
            self.moving,
            weighted,
            result.motions,
            left / load if load > 0.0 else 0.0,
        )

    def _at(self, position: Array, root: Array) -> _There:
        """Return forces, stiffness and constraint gradients at a position, scaled by the masses' roots."""
        force, stiffness = self.pulls(position)
        rows = self.rows(position)[:, self.moving] / root
        sizes = norm(rows, axis=1)
        sizes[sizes == 0.0] = 1.0
        return _There(force[self.moving] / root, stiffness, rows, sizes, null_space(rows / sizes[:, None]))

    def _applied(self) -> Array:
        """Return the forces of weight and springs at the start (N, N m), shape (3 n,)."""
        force = self.mass * np.tile([*self.mechanism.gravity, 0.0], len(self.position))
        for (spring, *ends), start in zip(self.springs, self.apart, strict=True):
            at = self.position[[place[0] for place in ends]].reshape(-1)
            np.add.at(
                force,
                [3 * place[0] + axis for place in ends for axis in range(3)],
                pulled_at(spring, start, at, ends),
            )
        return np.asarray(force, dtype=float)

    def _weighted(self, stiffness: Array, root: Array) -> Array:
        result = stiffness[np.ix_(self.moving, self.moving)] / np.outer(root, root)
        return np.asarray(0.5 * (result + result.T), dtype=float)

    def _leave_spinning(self, position: Array) -> None:
        """Remove the free rotations of released element ends: no force holds them, so they take part in no
        motion.
        """
        stiffness, rows = self.pulls(position)[1], self.rows(position)
        nodes = [p for name in self.numbering.meshes for p in self.numbering.bodies[name].particles]
        idle = [3 * p + 2 for p in nodes if not stiffness[3 * p + 2].any() and not rows[:, 3 * p + 2].any()]
        self.moving = np.setdiff1d(self.moving, idle)

    def pulls(self, position: Array) -> tuple[Array, Array]:
        """Return the forces of weight, elements and springs (N, N m) (3 n,), and their stiffness -df/dq (3 n,
        3 n).
        """
        gravity = np.array([*self.mechanism.gravity, 0.0])
        force = self.mass * np.tile(gravity, len(position))
        stiffness = np.zeros((len(force), len(force)))
        for element in self.elements:
            element.put(position, force, stiffness)
        for (spring, *ends), start in zip(self.springs, self.apart, strict=True):
            columns = [3 * place[0] + axis for place in ends for axis in range(3)]
            coordinates = position.reshape(-1)[columns]

            def pulled(
                at: Array, spring: AnySpring = spring, ends: Sequence[Place] = ends, start: float = start
            ) -> Array:
                return pulled_at(spring, start, at, ends)

            np.add.at(force, columns, pulled(coordinates))
            np.add.at(stiffness, np.ix_(columns, columns), -differences(pulled, coordinates))
        return force, stiffness

    def rows(self, position: Array) -> Array:
        """G (rows, 3 n)."""
        if not self.joints:
            return np.zeros((0, position.size))
        rows = ConstraintRows([self.joints], np.ones(len(self.joints)), np.ones(len(position)), single=True)
        result = rows.dense(rows.at(position)[1])
        return np.concatenate([np.zeros((len(result), 3)), result], axis=1)

    def turning(self, position: Array, multiplier: Array) -> Array:
        """-d(G^T lambda)/dq at constant lambda (3 n, 3 n): reactions keep their sizes and turn with their
        joints.
        """
        result, first = np.zeros((position.size, position.size)), 0
        for joint in self.joints:
            multipliers = multiplier[first : first + joint.size]
            first += joint.size
            columns = [3 * body + axis for body in (joint.body_a, joint.body_b) for axis in range(3)]
            alone = dataclasses.replace(
                joint, body_a=min(joint.body_a, 1), body_b=2 * min(joint.body_b, 1), body_c=0
            )
            rows = ConstraintRows([[alone]], np.ones(1), np.ones(3), single=True)

            def pressed(at: Array, rows: ConstraintRows = rows, multipliers: Array = multipliers) -> Array:
                positions = np.concatenate([np.zeros(3), at]).reshape(3, 3)
                return np.asarray(times(rows.dense(rows.at(positions)[1]).T, multipliers))

            np.add.at(result, np.ix_(columns, columns), -differences(pressed, position.reshape(-1)[columns]))
        return result


@dataclass(frozen=True)
class Element:
    """A frame element between two particles, with its length without forces (m), E A (N), the matrix of its
    end moments (N m) and rest angles.
    """

    first: int
    second: int
    length: float
    axial: float
    moments: Array
    rest_angles: tuple[float, float]

    def put(self, position: Array, force: Array, stiffness: Array) -> None:
        """Add the internal forces and the tangent stiffness of the element to ``force`` and
        ``stiffness``.

        With B the change of length and of both end rotations, K = B^T D B + N/l z z^T + (m_1 + m_2)/l^2 (r
        z^T + z r^T), r along and z across; Crisfield, Non-linear Finite Element Analysis of Solids and
        Structures 1 (1991), Section 7.3.
        """
        (x1, y1, t1), (x2, y2, t2) = position[self.first].tolist(), position[self.second].tolist()
        length, inverse, c, s = frame.chord(x2 - x1, y2 - y1)
        r, z = np.array([-c, -s, 0.0, c, s, 0.0]), np.array([s, -c, 0.0, -s, c, 0.0])
        turns = np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]) - z * inverse
        chord = atan2(s, c)
        bent = np.array([_near(t1 - self.rest_angles[0] - chord), _near(t2 - self.rest_angles[1] - chord)])
        n, moments = self.axial / self.length * (length - self.length), times(self.moments, bent)
        columns = [3 * body + axis for body in (self.first, self.second) for axis in range(3)]
        np.add.at(force, columns, -(n * r + times(turns.T, moments)))
        tangent = self.axial / self.length * np.outer(r, r) + product(product(turns.T, self.moments), turns)
        tangent += n * inverse * np.outer(z, z) + moments.sum() * inverse * inverse * (
            np.outer(r, z) + np.outer(z, r)
        )
        np.add.at(stiffness, np.ix_(columns, columns), tangent)


def elements_of(part: Mesh, first: int) -> list[Element]:
    """Return the elements of an elastic body whose particles are numbered from ``first``. Without forces its
    nodes do not rotate relative to it.
    """
    result = []
    for (a, b), length, release, axial, bending in zip(
        part.nodes, part.length, part.release, part.axial, part.bending, strict=True
    ):
        inverse = 1.0 / float(length)
        _, _, direct, coupling = frame.stiffness(inverse, inverse, float(axial), float(bending))
        alone = frame.stiffness_released(inverse, inverse, float(bending))[1]
        moments = {
            0: [[direct, coupling], [coupling, direct]],
            1: [[0.0, 0.0], [0.0, alone]],
            2: [[alone, 0.0], [0.0, 0.0]],
            3: [[0.0, 0.0], [0.0, 0.0]],
        }[release]
        dx, dy = (part.position[b] - part.position[a]).tolist()
        angle = -float(atan2(dy, dx))
        result.append(
            Element(
                first + int(a), first + int(b), float(length), float(axial), np.array(moments), (angle, angle)
            )
        )
    return result


def null_space(rows: Array) -> Array:
    """Orthonormal motions (m, k) that no row sees."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, sizes, right = dense.svd(rows)
    return np.asarray(right[int(np.sum(sizes > RANK)) :].T)


def differences(function: Callable[[Array], Array], at: Array) -> Array:
    """d function/d at by central differences of fourth order, (values, len(at))."""
    result = []
    for step in np.eye(len(at)) * CHANGE:
        step_change, double_change = (
            function(at + step) - function(at - step),
            function(at + 2.0 * step) - function(at - 2.0 * step),
        )
        result.append((8.0 * step_change - double_change) / (12.0 * CHANGE))
    return np.array(result).T


def pulled_at(spring: AnySpring, start: float, at: Array, ends: Sequence[Place]) -> Array:
    """Return the forces (N, N, N m) of a spring on the two particles that carry its pins, shape
    (6,).

    at: position and angle (m, m, rad) of both particles, shape (6,)
    """
    pins = [
        End("", "", _pin_place(particle, place), float(particle[2]), (0.0, 0.0, 0.0))
        for particle, (_, place) in zip((at[:3], at[3:]), ends, strict=True)
    ]
    result = []
    for particle, pin, (fx, fy, moment) in zip(
        (at[:3], at[3:]), pins, pull(spring, start, pins), strict=True
    ):
        result += [fx, fy, moment + (pin.at[0] - particle[0]) * fy - (pin.at[1] - particle[1]) * fx]
    return np.array(result, dtype=float)


def _near(angle: float) -> float:
    """Return the angle (rad) less whole turns, between -pi and pi."""
    return float(angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)))


def _free_length(spring: AnySpring, ends: Sequence[Place], position: Array) -> float:
    """Distance (m) or angle (rad) of a spring's ends at the start, where it is free if none is given."""
    (a, first_pin), (b, second_pin) = ends
    if kind_of_spring(spring) != LINEAR:
        return float(position[b, 2] - position[a, 2])
    first, second = (_pin_place(position[p], place) for p, place in ((a, first_pin), (b, second_pin)))
    return float(hypot(*np.subtract(second, first)))


def _pin_place(particle: Array, place: tuple[float, float]) -> tuple[float, float]:
    s, c = sincos(particle[2])
    return float(particle[0] + c * place[0] - s * place[1]), float(particle[1] + s * place[0] + c * place[1])
