"""Degrees of freedom, redundant constraints, singular positions, and Grashof's class of four-bar linkages."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..model.joints import Joint
from ..model.lumping import rigid_properties
from ..model.mechanism import Mechanism
from ..model.rows import Guided, place_row
from ..model.validation.checks import connections, neighbours_of, reached
from ..numerics import dense
from ..numerics.dense import dot, norm, product, times
from ..numerics.elementwise import cos
from ..numerics.scalar import distance
from .drives import spinless
from .forces import driven_body
from .linalg import Matrix, constrained, dependent_rows, self_stress
from .pins import from_center, world
from .solve import close
from .system import RigidSystem, checked, equations

Array = NDArray[np.float64]

SHIFT = 1e-2  # share of its reach (or rad) by which a mechanism is moved to compare a nearby position
MOST_FREE_MOTIONS = 12  # free motions up to which a blocked motion is detected
BENT = 1e-6  # of squares of velocities over the size of the largest body: smaller ones are rounding
LEAST_STEPS = 60  # of Marquardt's method: at a double root each leaves a sixteenth of the squares
STARTS, SIDES = 6, 12  # largest numbers of starts of the search for a free motion
RANK = 1e-9  # of the largest singular value: motions with smaller ones are free
MOVES = 1e-6  # of a motion of length 1: less is rounding


@dataclass(frozen=True)
class Mobility:
    """Instantaneous degrees of freedom with released drives, ``free``, and with drives, ``after_drives``, and
    the number of redundant constraints.

    ``redundant_joints`` are the joints whose rows depend on those of joints before them. ``singular`` are the
    joints and drives whose rows are dependent only in this position (a change point or a dead centre), and
    not in one nearby. ``blocked``: a motion that joints and drives permit to first order leads nowhere, like
    that of a hinge between two links in line whose other ends are fixed.
    """

    free: int
    after_drives: int
    redundant: int
    redundant_joints: tuple[str, ...]
    singular: tuple[str, ...] = ()
    blocked: bool = False


class Group(NamedTuple):
    """Joined ``bodies`` that drivers leave free: ``led`` if, without the ground, a driven body is joined to
    them, ``looped`` if more joints hold them than there are bodies, ``hanging`` if they hang in pins from a
    driven body.
    """

    bodies: set[str]
    led: bool
    looped: bool
    hanging: bool


@dataclass(frozen=True)
class FreeMotions:
    """The motions of first order that drivers leave a ``mechanism`` at a closed ``position`` [n, 3] (m, m,
    rad) of its ideal ``system``; ``hand`` is -1 if the system is the mirror image.
    """

    mechanism: Mechanism
    system: RigidSystem
    position: Array
    hand: float

    @cached_property
    def motions(self) -> Array:
        """Motions [count, bodies, 3] in which no driver moves: a torque or force is taken for a motion."""
        return self._without([], [])

    @cached_property
    def groups(self) -> list[Group]:
        """The groups of free bodies that joints, springs and gears join to each other."""
        mechanism, free = self.mechanism, self.moved(self.motions)
        pairs = [{end.partition(".")[0] for end in pair} for pair in connections(mechanism)]
        moving_pairs = [pair for pair in pairs if "ground" not in pair and len(pair) == 2]
        neighbours = neighbours_of(mechanism.bodies, moving_pairs)
        near = neighbours_of(free, (pair for pair in moving_pairs if pair <= set(free)))
        driven = {
            driven_body(name, driver)
            or (driver.point or mechanism.joints[driver.slider].journal).partition(".")[0]
            for name, driver in mechanism.drivers.items()
        }
        pins = [{joint.bearing, joint.journal} for joint in mechanism.joints.values() if joint.revolves]
        guided = {
            end.partition(".")[0] for pair in connections(mechanism) if set(pair) not in pins for end in pair
        }
        result: list[Group] = []
        for name in free:
            if not any(name in group.bodies for group in result):
                bodies = reached(near, name)
                looped = sum(1 for pair in pairs if bodies & pair) > len(bodies)
                led = bool(reached(neighbours, name) & driven)
                result.append(Group(bodies, led, looped, led and not looped and not bodies & guided))
        return result

    @cached_property
    def idle(self) -> Array:
        """Those of them in which nothing moves on which weight, a load, spring, contact, velocity or a driven
        body from which it hangs acts.
        """
        mechanism, acting = self.mechanism, {"ground"}
        acting |= {name for name, body in mechanism.bodies.items() if any(body.velocity)}
        acting |= {push.body for load in mechanism.loads.values() for push in load.pushes(mechanism.joints)}
        ends = [pair for spring in mechanism.springs.values() for pair in (spring.first, spring.second)]
        for joint in mechanism.joints.values():
            ends += () if joint.rows() else (joint.bearing, joint.journal)
        acting |= {end.partition(".")[0] for end in ends}
        return self._without(
            [(name, axis) for name in acting - {"ground"} for axis in range(3)], self._weights()
        )

    def _weights(self) -> list[tuple[str, tuple[float, float]]]:
        """Return the ways in which gravity acts on bodies: all, but one where a guide of the ground keeps a
        body straight.
        """
        gx, gy = self.mechanism.gravity
        hanging = {name for group in self.groups if group.hanging for name in group.bodies}
        guided = {
            journal[0]
            for joint in self.mechanism.joints.values()
            for bearing, journal in (joint.sides, joint.sides[::-1])
            if bearing[0] == "ground" and isinstance(place_row(joint.rows()), Guided)
        }
        turning, result = self.moved(self.motions[:, :, 2:]), []
        for name, body in self.mechanism.bodies.items():
            if not (gx or gy or name in hanging):
                continue
            straight = name in guided and name not in turning
            ways = [(gx, self.hand * gy)] if straight else [(1.0, 0.0), (0.0, 1.0)]
            result += [(name, way) for way in ways if rigid_properties(body).mass > 0.0]
        return result

    def _without(self, fixed: list[tuple[str, int]], ways: list[tuple[str, tuple[float, float]]]) -> Array:
        """Return the motions without those along ``fixed`` coordinates (0 to 2) of bodies, and along ``ways``
        of their centres of mass.
        """
        mechanism, names, rows_of_zero = self.mechanism, list(self.mechanism.bodies), []
        for name, driver in mechanism.drivers.items():
            if not driver.moves and (body := driven_body(name, driver)):
                fixed = [*fixed, (body, 2)]
            elif not driver.moves:
                side = driver.point or mechanism.joints[driver.slider].journal
                fixed = [*fixed, *((side.partition(".")[0], axis) for axis in range(2))]
        units = {name: np.eye(3) for name in names}
        rows = [(name, units[name][axis]) for name, axis in fixed if name in units]
        rows += [(name, units[name][2]) for name in spinless(mechanism)]
        for name, way in [*rows, *((name, np.array([*way, 0.0])) for name, way in ways)]:
            row = np.zeros((len(names), 3))
            row[names.index(name)] = way
            rows_of_zero.append(row.ravel())
        place = self.position * (1.0, self.hand, self.hand)
        return _free(self.system, place, np.reshape(rows_of_zero, (-1, 3 * len(names))))

    def moved(self, motions: Array) -> list[str]:
        """Return the bodies that take part in motions."""
        sizes = np.abs(motions).max(axis=(0, 2)) if len(motions) else np.zeros(len(self.mechanism.bodies))
        return [name for name, size in zip(self.mechanism.bodies, sizes, strict=True) if size > MOVES]

    def speeds(self, side: tuple[str, str]) -> Array:
        """Return the velocity of a pin in each of the motions left, [count, 2]."""
        if side[0] == "ground":
            return np.zeros((len(self.motions), 2))
        k, hand = list(self.mechanism.bodies).index(side[0]), self.hand
        x, y = np.subtract(self.place(side), self.position[k + 1, :2])
        turning = self.motions[:, k, 2] / self.system.metric[0][3 * k + 2]
        return np.asarray(self.motions[:, k, :2] + turning[:, None] * (-hand * y, x))

    def place(self, side: tuple[str, str]) -> tuple[float, float]:
        """Return the place of a pin at the start (m)."""
        return world(self.mechanism, self.position, self.system.names, side)


def _free(system: RigidSystem, position: Array, rows_of_zero: Array) -> Array:
    """Return orthonormal motions [count, n - 1, 3] of first order, (x, y, l theta) of each body, that joints
    and drives permit at a closed position [n, 3] and that have no part along the rows of ``rows_of_zero``
    [rows, 3(n-1)]. Large systems, whose equations are sparse, return none.
    """
    jacobian, columns = equations(system, position).jacobian, 3 * (len(system.names) - 1)
    if not isinstance(jacobian, np.ndarray):
        return np.zeros((0, len(system.names) - 1, 3))
    # A row of zeros, so that a system without rows has singular values too.
    _, sizes, right = dense.svd(np.vstack([jacobian, rows_of_zero, np.zeros((1, columns))]))
    rank = int(np.count_nonzero(sizes > RANK * max(1.0, float(sizes.max()))))
    return np.asarray(right[rank:].reshape(-1, len(system.names) - 1, 3))


def mobility(system: RigidSystem, position: Array) -> Mobility:
    """Count the instantaneous freedoms and redundant constraints at a closed position [n, 3] (m, m, rad).

    free = 3(n-1) - rank(G of the joints); after_drives includes the rows of drives; redundant = rows - rank(G
    of the joints). The position is singular if the rank is larger in a nearby position (along a free motion,
    with released drives), or if a free motion leads nowhere. Raises VfifeError for bad shapes.
    """
    position = checked(system, position, "position")
    columns = 3 * (len(system.names) - 1)
    stuck, all_stuck = _dependent(system, position)
    free, after_drives = (
        columns - (system.joint_rows - len(stuck)),
        columns - (system.starts[-1] - len(all_stuck)),
    )
    aside = _aside(system, position) if all_stuck and free else position
    lasting = [] if aside is None else all_stuck if aside is position else _dependent(system, aside)[1]
    owners_at, owners_aside = Counter(_owners(system, all_stuck)), Counter(_owners(system, lasting))
    singular = (
        sorted((owners_at - owners_aside).keys() or owners_at.keys()) if len(lasting) < len(all_stuck) else []
    )
    redundant = _named(system, _owners(system, stuck))
    return Mobility(
        free,
        after_drives,
        len(stuck),
        redundant,
        _named(system, singular),
        bool(all_stuck and after_drives) and _blocked(system, position),
    )


def _dependent(system: RigidSystem, position: Array) -> tuple[list[int], list[int]]:
    """Return the rows that depend on rows before them: of the joints alone, and with the drives."""
    jacobian = equations(system, position).jacobian
    rows = dependent_rows(jacobian)
    return [row for row in rows if row < system.joint_rows], rows


def _owners(system: RigidSystem, rows: list[int]) -> list[int]:
    """Return the number of the joint or drive of each row; drives follow the joints."""
    return [int(np.searchsorted(system.starts, row, side="right")) - 1 for row in rows]


def _named(system: RigidSystem, owners: list[int]) -> tuple[str, ...]:
    """Return the names of joints and drives by number, without repetition."""
    names = [*(joint.name for joint in system.joints), *(system.drive_name(drive) for drive in system.drives)]
    return tuple(dict.fromkeys(names[k] for k in owners))


def _blocked(system: RigidSystem, position: Array) -> bool:
    """Return whether every motion of first order, G v = 0, is blocked by a self-stress N: N^T gamma(v) has
    one sign for all of them and is not zero.

    If it has both signs, two motions branch off; if it is zero, the mechanism moves on (Pellegrino and
    Calladine, Int. J. Solids Struct. 22 (1986) 409-428). N^T gamma is a quadratic form of v; its eigenvalues
    give the signs. Only for up to some 30 bodies and a dozen free motions; False for others.
    """
    at_rest = equations(system, position)
    if not isinstance(at_rest.jacobian, np.ndarray):
        return False
    lengths, stress = system.metric[0], self_stress(at_rest.jacobian)
    null = dense.svd(at_rest.jacobian)[2][len(at_rest.jacobian) - stress.shape[1] :]
    count = len(null)
    if count > MOST_FREE_MOTIONS:
        return False

    def bent(motion: Array) -> Array:
        velocity = np.vstack([np.zeros(3), (motion / lengths).reshape(-1, 3)])
        return np.asarray(
            times(stress.T, equations(system, position, velocity).gamma - at_rest.gamma)
            * system.reach[1:].max()
        )

    alone = [bent(motion) for motion in null]
    forms = np.zeros((stress.shape[1], count, count))
    for i in range(count):
        for j in range(i + 1):
            forms[:, i, j] = forms[:, j, i] = (
                alone[i] if i == j else 0.5 * (bent(null[i] + null[j]) - alone[i] - alone[j])
            )
    sizes = dense.eigh(forms)[0]
    curved = [eigenvalues for eigenvalues in sizes if np.abs(eigenvalues).max() > BENT]
    return bool(curved) and all(
        eigenvalues.min() > -BENT or eigenvalues.max() < BENT for eigenvalues in curved
    )


def _aside(system: RigidSystem, position: Array) -> Array | None:
    """Return a closed position a little along a free motion, with released drives; None if no free motion
    leads anywhere.
    """
    released = dataclasses.replace(system, drives=())
    jacobian = equations(released, position).jacobian
    lengths = system.metric[0]
    scale = np.column_stack([np.ones_like(system.reach), np.ones_like(system.reach), system.reach])
    for motion in _directions(released, position, jacobian):
        size = max(np.abs(motion).max() / system.reach[1:].max(), np.abs((motion / lengths)[2::3]).max())
        step = np.vstack([np.zeros(3), (SHIFT / size * motion / lengths).reshape(-1, 3)])
        try:
            result = close(released, position + step, named=False).position
        except AssemblyError:
            continue
        if norm((result - position) * scale) > 0.1 * norm(step * scale):
            return result
    return None


def _directions(system: RigidSystem, position: Array, jacobian: Matrix) -> Iterator[Array]:
    """Yield free motions in (x, y, l theta) that may continue to second order, N^T gamma(v) = 0 for every
    self-stress N, as far as such are found; and last any free motion.
    """
    lengths = system.metric[0]
    wish = cos(np.square(np.arange(1, len(lengths) + 1))) * np.repeat(system.reach[1:], 3)
    if isinstance(jacobian, np.ndarray):
        stress = self_stress(jacobian)
        null = dense.svd(jacobian)[2][len(jacobian) - stress.shape[1] :].T

        def bent(part: Array) -> Array:
            velocity = np.vstack([np.zeros(3), (times(null, part) / lengths).reshape(-1, 3)])
            return np.append(
                times(stress.T, equations(system, position, velocity).gamma), dot(part, part) - 1.0
            )

        for start in _starts(null.shape[1]) if stress.size else ():
            part, cost = _least(bent, start)
            if cost < 1e-16:
                yield times(null, part)
    yield constrained(jacobian, np.zeros(jacobian.shape[0]), np.ones_like(wish), wish)[0]


def _starts(count: int) -> Iterator[Array]:
    """Yield starts of the search for a free motion with ``count`` parts: some without order, then along each
    part and between two neighbours.

    The sum of squares has minima that are no solutions, in which a search may end; which starts lead there
    depends on the basis of the free motions. Starts along the parts and between them cover all sides of it.
    """
    for start in range(STARTS):
        yield cos(np.square(np.arange(1, count + 1)) + float(start))
    units = np.eye(count)
    sides = (
        *units,
        *(part + neighbour for part, neighbour in pairwise(units)),
        *(part - neighbour for part, neighbour in pairwise(units)),
    )
    yield from sides[:SIDES]


def _least(function: Callable[[Array], Array], at: Array) -> tuple[Array, float]:
    """Return the place near ``at`` with the least half sum of squares of quadratic functions, and that sum,
    by Marquardt's method.
    """
    place, damping = at, 1e-3
    error = function(place)
    cost = 0.5 * dot(error, error)
    for _ in range(LEAST_STEPS):
        # Central differences are exact for quadratic functions, with steps of any size.
        slopes = np.stack(
            [0.5 * (function(place + unit) - function(place - unit)) for unit in np.eye(len(place))], axis=1
        )
        square = product(slopes.T, slopes)
        while damping < 1e8:
            step = -dense.solve(square + damping * np.eye(len(place)), times(slopes.T, error))
            tried = function(place + step)
            if 0.5 * dot(tried, tried) < cost:
                break
            damping *= 8.0
        else:
            break
        place, error, damping = place + step, tried, max(damping / 8.0, 1e-14)
        previous_cost, cost = cost, 0.5 * dot(tried, tried)
        if cost < 1e-30 or previous_cost - cost < 1e-12 * previous_cost:
            break
    return place, cost


CHANGE_POINT = 1e-9  # relative difference of s + l and p + q at a change point


def grashof(mechanism: Mechanism) -> str | None:
    """Return Grashof's class of the four-bar of ground, three bodies and four revolutes in a mechanism, with
    its lengths; None without one.

    With s the shortest, l the longest, p and q the other lengths: s + l < p + q lets the shortest turn fully
    against the others (crank-rocker if it is pivoted on the ground, double crank or drag link if it is the
    ground, double rocker if it is the coupler), s + l = p + q is a change point, and s + l > p + q a triple
    rocker. The first such loop is described, the bodies in the order of the loop.
    """
    for loop in _loops(mechanism):
        lengths = {body: _length(mechanism, body, *ends) for body, ends in loop.items()}
        if min(lengths.values()) > 0.0:
            lengths_text = ", ".join(f"{body} {1e3 * length:.6g} mm" for body, length in lengths.items())
            return f"{classified(*lengths.values())}: {lengths_text}"
    return None


def classified(ground: float, first: float, coupler: float, second: float) -> str:
    """Return Grashof's class from four lengths in the order of the loop (in one unit)."""
    lengths = (ground, first, coupler, second)
    shortest, p, q, longest = sorted(lengths)
    excess = shortest + longest - p - q
    if abs(excess) <= CHANGE_POINT * longest:
        opposite = math.isclose(ground, coupler, rel_tol=CHANGE_POINT) and math.isclose(
            first, second, rel_tol=CHANGE_POINT
        )
        deltoid = math.isclose(shortest, p, rel_tol=CHANGE_POINT) and math.isclose(
            q, longest, rel_tol=CHANGE_POINT
        )
        return (
            "parallelogram, a change-point four-bar"
            if opposite
            else "deltoid, a change-point four-bar"
            if deltoid
            else "change-point four-bar"
        )
    if excess > 0.0:
        return "triple rocker, a non-Grashof four-bar"
    if shortest == ground:
        return "double crank (drag link), a Grashof four-bar"
    return "double rocker, a Grashof four-bar" if shortest == coupler else "crank-rocker, a Grashof four-bar"


def _loops(mechanism: Mechanism) -> Iterator[dict[str, tuple[str, str]]]:
    """Yield loops of ground, first, coupler and second body, each with its two pins, in order."""
    revolutes = [joint for joint in mechanism.joints.values() if joint.revolves]
    grounded = [joint for joint in revolutes if "ground" in (joint.sides[0][0], joint.sides[1][0])]
    for left, right in combinations(grounded, 2):
        (foot_1, (first, pin_1)), (foot_2, (second, pin_2)) = _from(left, "ground"), _from(right, "ground")
        for left_knee in (
            joint for joint in revolutes if joint not in (left, right) and first in _bodies(joint)
        ):
            knee_1, (coupler, end_1) = _from(left_knee, first)
            for right_knee in (
                joint
                for joint in revolutes
                if joint not in (left, right, left_knee) and {coupler, second} == set(_bodies(joint))
            ):
                knee_2, (_, end_2) = _from(right_knee, second)
                if len({"ground", first, coupler, second}) == 4:
                    yield {
                        "ground": (foot_1[1], foot_2[1]), first: (pin_1, knee_1[1]), coupler: (end_1, end_2),
                        second: (pin_2, knee_2[1]),
                    }  # fmt: skip


def _bodies(joint: Joint) -> tuple[str, str]:
    return joint.sides[0][0], joint.sides[1][0]


def _from(joint: Joint, body: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return the joint's sides, that of ``body`` first."""
    return joint.sides if joint.sides[0][0] == body else joint.sides[::-1]


def _length(mechanism: Mechanism, body: str, start: str, end: str) -> float:
    return distance(from_center(mechanism, (body, start)), from_center(mechanism, (body, end)))
