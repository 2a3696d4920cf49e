"""Forces of the joints on their journals and of the mechanism on the ground; eccentricity, penetration and
mode of contacts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import GEARED
from ..kinematics.forces import driven_body
from ..model.geometry.path import Path
from ..model.wear import depth_at
from ..numerics.elementwise import atan2, hypot, sincos
from ..solvers.record import Record
from .motion import pin_places, velocities
from .turns import Window, of_window

Array = NDArray[np.float64]
FREE_FLIGHT, IMPACT, CONTINUOUS_CONTACT = 0, 1, 2
SIDES = ("bearing", "journal")
KINDS = ("bearing", "round", "line", "slot")  # of contacts, in the order of their numbers
MODES = ("free_flight", "impact", "continuous_contact")  # their names, in this order


def joint_rows(record: Record) -> dict[str, tuple[str, list[int]]]:
    """Return the kind of row (``clearance``, ``ideal``, ``driven``) of each joint and its places there, in
    the mechanism's order; gears and drivers last.

    A block in a guide with clearance has four contacts.
    """
    assembly = record.assembly
    rows: dict[str, tuple[str, list[int]]] = {}
    for kind, block in (("contact_joints", "contact"), ("ideals", "joint"), ("pivots", "driven")):
        for index, name in enumerate(getattr(assembly, kind)):
            _, places = rows.setdefault(name, (block, []))
            if block == "contact" or not places:  # what a driver of a slider exerts is no force of its guide
                places.append(index)
    return {name: rows[name] for name in (*assembly.mechanism.joints, *rows) if name in rows}


def eccentricity(record: Record) -> Array:
    """Return the journal centre seen from the bearing's pin, global axes (m), shape (outputs, contacts, 2):
    Eq. 20.
    """
    if not record.assembly.contacts:
        return np.zeros((len(record.steps), 0, 2))
    return np.asarray(
        pin_places(record, "contact", "journal") - pin_places(record, "contact", "bearing"), dtype=float
    )


def normals(record: Record) -> Array:
    """Return the unit vector of each contact against which its normal force acts on the journal, shape
    (outputs, contacts, 2): Eq. 24.

    From the bearing's centre to the journal's; outside, from the journal's to the bearing's; on a line, into
    its material; in a slot, from its middle to the journal's; on worn surfaces leaning by their slope.
    """
    topology = record.assembly.topology
    away = eccentricity(record)
    n = away / np.maximum(hypot(away[..., 0], away[..., 1])[..., None], 1e-300)
    kind = np.array(topology.contact_kind, dtype=int)
    n[:, kind == KINDS.index("round")] *= -1.0
    lines = np.flatnonzero(kind == KINDS.index("line"))
    if len(lines):
        angle = record.block("particle_theta")[:, [topology.contact_bearing[k] for k in lines]]
        x, y = (record.parameter(f"contact_line_{axis}")[lines] for axis in "xy")
        s, c = sincos(angle)
        n[:, lines] = np.stack([c * x - s * y, s * x + c * y], axis=2)
    for k in np.flatnonzero(kind == KINDS.index("slot")):
        angle = record.block("particle_theta")[:, topology.contact_bearing[k]]
        n[:, k] = _off_the_path(away[:, k], angle, record.assembly.contact_paths[k])
    for contact, counts in enumerate(topology.profiles):
        if any(counts):
            n[:, contact] = _leaning(record, contact, away[:, contact], n[:, contact])
    return np.asarray(n, dtype=float)


def _leaning(record: Record, k: int, away: Array, n: Array) -> Array:
    """Return the unit vectors (outputs, 2) along which the penetration of worn surfaces grows fastest; see
    ``kernels/wear.py``.
    """
    wear, slope = record.assembly.mechanism.contacts[record.assembly.contact_joints[k]].wear, 0.0
    for side in ("bearing", "journal"):
        angle = record.block("particle_theta")[:, getattr(record.assembly.topology, f"contact_{side}")[k]]
        slope = slope + depth_at(getattr(wear, f"{side}_profile"), atan2(n[:, 1], n[:, 0]) - angle)[1]
    inclination = (slope / np.maximum(hypot(*away.T), 0.5 * record.parameter("contact_size")[k]))[:, None]
    return np.asarray(
        (n - inclination * np.stack([-n[:, 1], n[:, 0]], axis=1)) / np.sqrt(1.0 + inclination * inclination),
        dtype=float,
    )


def _off_the_path(away: Array, angle: Array, path: Path | None) -> Array:
    """Return the unit vectors (outputs, 2) from the middle of a slot to the journal, which is at ``away`` (m)
    from the bearing's pin.
    """
    vectors = np.zeros_like(away)
    for row, ((x, y), s, c) in enumerate(zip(away, *sincos(angle), strict=True)):
        distance, nx, ny = (0.0, 0.0, 0.0) if path is None else path.nearest(c * x + s * y, c * y - s * x)
        side = 1.0 if distance >= 0.0 else -1.0
        vectors[row] = side * (c * nx - s * ny), side * (s * nx + c * ny)
    return vectors


def joint_force(record: Record) -> Array:
    """Return the force of each joint on its journal, global axes (N), shape (outputs, joints, 2).

    A joint with clearance gives -F_N n + F_T t, n from the bearing's centre to the journal's and t = n turned
    anticlockwise; the contacts of a block in a guide are summed.
    """
    rows = joint_rows(record)
    force = np.zeros((len(record.steps), len(rows), 2))
    contact = contact_force(record) if record.assembly.contacts else None
    for k, (name, (block, indices)) in enumerate(rows.items()):
        if block == "contact" and contact is not None:
            force[:, k] = contact[:, indices].sum(axis=1)
            continue
        force[:, k, 0], force[:, k, 1] = (record.block(f"{block}_f{axis}")[:, indices[0]] for axis in "xy")
        if block == "driven" and record.assembly.mechanism.joints[name].sides[0][0] != "ground":
            force[:, k] *= -1.0  # the row holds the force on the driven body, which is the bearing here
    return force


def contact_force(record: Record) -> Array:
    """Return the force of each contact on the journal (N), shape (outputs, contacts, 2)."""
    n = normals(record)
    t = np.stack([-n[..., 1], n[..., 0]], axis=2)
    normal, friction = record.block("contact_normal_force"), record.block("contact_friction_force")
    return np.asarray(friction[..., None] * t - normal[..., None] * n, dtype=float)


def joint_moment(record: Record) -> Array:
    """Return the moment of ideal joints on their journals' bodies (N m), 0 where none, shape (outputs,
    joints).
    """
    rows = joint_rows(record)
    moment = np.zeros((len(record.steps), len(rows)))
    for k, (block, indices) in enumerate(rows.values()):
        if block == "joint":
            moment[:, k] = record.block("joint_moment")[:, indices[0]]
    return moment


def joint_force_max(record: Record) -> Array:
    """Return the largest force of each joint in the interval up to an output (N), shape (outputs, joints); of
    a block in a guide that of its corners together.

    A file of a former version has the largest of one corner only.
    """
    squares = [
        record.block(f"{block}_force_squared_max")[:, places].max(axis=1)
        for block, places in peaks(record).values()
    ]
    return np.sqrt(np.stack(squares, axis=1)) if squares else np.zeros((len(record.steps), 0))


def peaks(record: Record) -> dict[str, tuple[str, list[int]]]:
    """Return :func:`joint_rows` for the extremes of joint forces: those of a block in a guide are of its
    corners together.
    """
    guides = (
        [first for first, _ in record.assembly.topology.guides]
        if record.keeps("guide_force_squared_max")
        else []
    )
    return {
        name: (
            ("guide", [guides.index(places[0])])
            if block == "contact" and places[0] in guides
            else (block, places)
        )
        for name, (block, places) in joint_rows(record).items()
    }


def modes(record: Record) -> NDArray[np.int8]:
    """Return the mode of each clearance joint at an output, shape (outputs, clearances).

    2 continuous contact where the penetration is positive, 0 free flight elsewhere, and 1 impact where a
    contact began since the output before: an impact lasts one step (Eq. 19), and no sample would meet it.
    """
    mode = np.where(record.block("contact_penetration") > 0.0, CONTINUOUS_CONTACT, FREE_FLIGHT)
    began = np.diff(record.block("contact_onsets"), axis=0, prepend=0.0) > 0.0
    return np.where(began, IMPACT, mode).astype(np.int8)


def shares(record: Record) -> dict[str, Array]:
    """Return the share of the time in each mode, shape (clearances,).

    An impact is a step in which a contact begins, continuous contact is all of it but for its first step.
    """
    steps = float(record.steps[-1] + 1)
    return _shares(record, steps, record.last("contact_onsets"), record.last("contact_duration"))


def shares_between(first: Record, last: Record) -> dict[str, Array]:
    """Return the share of the time in each mode from the first output of a record to the last of another of
    the same run, shape (clearances,).
    """
    steps = float(last.steps[-1] - first.steps[0])
    onsets, times = (
        last.last(name) - first.block(name)[0] for name in ("contact_onsets", "contact_duration")
    )
    return _shares(last, steps, onsets, times)


def _shares(record: Record, steps: float, onsets: Array, times: Array) -> dict[str, Array]:
    """Return shares of ``steps``, of the number of contacts and their ``times`` (s)."""
    impact, lasting = onsets / steps, times / (steps * record.assembly.choice.step)
    return dict(zip(MODES, (np.maximum(1.0 - impact - lasting, 0.0), impact, lasting), strict=True))


def arms(record: Record, stepped: bool = False) -> tuple[Array, Array]:
    """Return the distances (m) of the surfaces of bearing and journal from their pins along the contact's
    normal, shape (outputs, contacts) each.

    Radii, and half the overlap; where friction acts without a moment (``friction_moment`` off, films) the
    surfaces slide all the same. ``stepped``: the arms of friction instead, as the step has them.
    """
    mechanism, assembly = record.assembly.mechanism, record.assembly
    if stepped:
        change = record.parameter("contact_arm_overlap") * record.block("contact_penetration")
        return (
            record.parameter("contact_arm_bearing") + change,
            record.parameter("contact_arm_journal") - change,
        )
    depth = np.maximum(record.block("contact_penetration"), 0.0) * 0.5
    arms = [
        touching.arms
        for name in dict.fromkeys(assembly.contact_joints)
        for touching in mechanism.contacts[name].touchings(0.0)
    ]
    bearing, journal = np.array(arms).reshape(-1, 2).T
    return bearing + depth, journal - depth


def places(record: Record, stepped: bool = False) -> tuple[Array, Array]:
    """Return the vectors (m) from the pins of bearing and journal to the place of contact (where friction
    acts in the step if ``stepped``).

    Global axes, shape (outputs, contacts, 2) each.
    """
    n, away = normals(record), eccentricity(record)
    on_bearing, on_journal = arms(record, stepped)
    t = np.stack([-n[..., 1], n[..., 0]], axis=2)
    slip = (away * t).sum(axis=2)
    excess = np.zeros_like(slip)
    slots = [k for k, path in enumerate(record.assembly.contact_paths) if path is not None]
    if slots:  # the middle of a slot lies beside the bearing's pin
        middle = (away * n).sum(axis=2) - (
            record.block("contact_penetration") + record.parameter("contact_size")
        )
        excess[:, slots] = middle[:, slots]
    return (on_bearing + excess)[..., None] * n + slip[..., None] * t, on_journal[..., None] * n


def ground_load(record: Record) -> Array:
    """Return the force (N, N) of the mechanism on the ground, and its moment (N m) about the ground's origin,
    global axes, shape (outputs, 3).

    The sum of all that acts on the ground: joints, with clearance and without, pivots and torques of drivers,
    gears on fixed carriers, springs, and loads whose opposite the ground takes, as the head of a cylinder
    does. Other loads and weight act on bodies from outside; so the result is their sum less the rate of
    change of momentum: F = sum (F_ext - m a), the shaking force of a mechanism without loads and weight being
    -sum m a.
    """
    total = np.zeros((len(record.steps), 3))
    for part in (_ideals, _contacts, _springs, _drivers, _motors, _loads):
        total += part(record)
    return total


def _at(force: Array, place: Array, moment: Array | float = 0.0) -> Array:
    """Return a force at a place and a moment, as force and moment about the origin, (outputs, 3)."""
    return np.column_stack([force, place[:, 0] * force[:, 1] - place[:, 1] * force[:, 0] + moment])


def _ideals(record: Record) -> Array:
    """Joints without clearance, gears, and drivers that hold no pivot; on the bearing the opposite acts in
    the same place, -ratio times the moment.
    """
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    if not t.joint_bearing:
        return total
    place, ratios = pin_places(record, "joint", "journal"), record.parameter("joint_ratio")
    fx, fy, moment = (record.block(f"joint_{name}") for name in ("fx", "fy", "moment"))
    ends = zip(t.joint_bearing, t.joint_journal, t.carriers, strict=True)
    for k, ((bearing, journal, carrier), (_, turn)) in enumerate(zip(ends, t.held, strict=True)):
        force, ratio = np.column_stack([fx[:, k], fy[:, k]]), float(ratios[k]) if turn == GEARED else 1.0
        if bearing == 0:
            total += _at(-force, place[:, k], -ratio * moment[:, k])
        if journal == 0:
            total += _at(force, place[:, k], moment[:, k])
        if carrier == 0:
            total[:, 2] += (ratio - 1.0) * moment[:, k]
    return total


def _contacts(record: Record) -> Array:
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    if not t.contact_bearing:
        return total
    force = contact_force(record)
    for sign, side, reach in zip(
        (-1.0, 1.0), ("bearing", "journal"), places(record, stepped=True), strict=True
    ):
        pins = pin_places(record, "contact", side) + reach
        for k, body in enumerate(getattr(t, f"contact_{side}")):
            if body == 0:
                total += _at(sign * force[:, k], pins[:, k])
    return total


def _springs(record: Record) -> Array:
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    if not t.spring_first:
        return total
    pins = pin_places(record, "spring", "second")
    fx, fy, moment = (record.block(f"spring_{name}") for name in ("fx", "fy", "moment"))
    for k, ends in enumerate(zip(t.spring_first, t.spring_second, strict=True)):
        for sign, body in zip((-1.0, 1.0), ends, strict=True):
            if body == 0:
                total += _at(sign * np.column_stack([fx[:, k], fy[:, k]]), pins[:, k], sign * moment[:, k])
    return total


def _drivers(record: Record) -> Array:
    """Return the pivots of driven bodies, and the torques that turn them against the ground."""
    total = np.zeros((len(record.steps), 3))
    for k, p in enumerate(record.assembly.topology.driven):
        force = -np.column_stack([record.block(f"driven_f{axis}")[:, k] for axis in "xy"])
        place = np.column_stack([record.block(f"particle_{axis}")[:, p] for axis in "xy"])
        total += _at(force, place, -record.block("driven_torque")[:, k])
    return total


def _motors(record: Record) -> Array:
    """Return the torques against the ground, whose housings stand on it."""
    mechanism, total = record.assembly.mechanism, np.zeros((len(record.steps), 3))
    at = sum(len(load.pushes(mechanism.joints)) for load in mechanism.loads.values())
    for name, driver in mechanism.drivers.items():
        if driver.moves:
            continue
        if driven_body(name, driver) and driver.against == "ground":
            value = record.block("function_value")[:, record.assembly.topology.load_function[at]]
            total[:, 2] -= value * float(record.parameter("load_m")[at])
        at += 2 if driven_body(name, driver) and driver.against != "ground" else 1
    return total


def _loads(record: Record) -> Array:
    """Sum the loads on the ground itself, (outputs, 3) (N, N, N m)."""
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    for k, body in enumerate(t.load_particle):
        if body == 0:
            x, y, fx, fy, moment = (
                float(record.parameter(f"load_{name}")[k]) for name in ("x", "y", "fx", "fy", "m")
            )
            value = record.block("function_value")[:, t.load_function[k]]
            total += value[:, None] * np.array([fx, fy, x * fy - y * fx + moment])
    return total


def ground_joints(record: Record) -> list[str]:
    """Return the joints with a side on the ground, in the mechanism's order."""
    t = record.assembly.topology
    ends = {
        "contact": (t.contact_bearing, t.contact_journal),
        "ideal": (t.joint_bearing, t.joint_journal),
        "joint": (t.joint_bearing, t.joint_journal),
    }
    return [
        name
        for name, (block, indices) in joint_rows(record).items()
        if block == "driven" or any(side[k] == 0 for side in ends[block] for k in indices)
    ]


def other_ground_force(record: Record, window: Window) -> float:
    """Return an upper bound of the force (N) of springs and loads on the ground over a window, apart from
    joints: the sum of the largest of each.
    """
    t, bound = record.assembly.topology, 0.0
    if t.spring_first:
        squares = record.block("spring_force_squared_max")[window].max(axis=0)
        on_ground = [0 in ends for ends in zip(t.spring_first, t.spring_second, strict=True)]
        bound += float(np.sqrt(squares)[on_ground].sum())
    for k, body in enumerate(t.load_particle):
        if body == 0:
            value = np.abs(record.block("function_value")[window, t.load_function[k]]).max()
            fx, fy = (float(record.parameter(f"load_{name}")[k]) for name in ("fx", "fy"))
            bound += float(value * hypot(fx, fy))
    return bound


def largest_shaking(record: Record, window: Window) -> dict[str, float]:
    """Return ``ground.shaking_force.max`` (N) and ``ground.shaking_moment.max`` (N m, about the ground's
    origin).

    Largest sizes of :func:`ground_load` at the outputs.
    """
    part, inside = of_window(record, window)
    load = ground_load(part)[inside]
    force, moment = hypot(load[:, 0], load[:, 1]), np.abs(load[:, 2])
    return {"ground.shaking_force.max": float(force.max()), "ground.shaking_moment.max": float(moment.max())}


def relative_velocity(record: Record, arms: tuple[Array, Array] | None = None) -> Array:
    """Return the velocity (m/s) of the journal's material minus that of the bearing's, global axes, shape
    (outputs, contacts, 2), at their pins, or at ``arms`` from them (m, global axes, of that shape each).
    """
    topology, moving = record.assembly.topology, velocities(record)
    total = np.zeros((len(record.steps), len(record.assembly.contacts), 2))
    # Of a body: velocity of its particle plus rotation times the arm from its centre to the place.
    for sign, side, arm in zip((-1.0, 1.0), SIDES, (0.0 * total,) * 2 if arms is None else arms, strict=True):
        body = list(getattr(topology, f"contact_{side}"))
        angle = record.block("particle_theta")[:, body]
        x, y = (record.parameter(f"contact_{side}_{axis}") for axis in "xy")
        s, c = sincos(angle)
        rx, ry, w = c * x - s * y + arm[..., 0], s * x + c * y + arm[..., 1], moving["w"][:, body]
        total += sign * np.stack([moving["u"][:, body] - w * ry, moving["v"][:, body] + w * rx], axis=2)
    return total


def slip(record: Record, reaches: tuple[Array, Array] | None = None) -> Array:
    """Return the velocity (m/s) of the journal's surface relative to the bearing's along t = n turned
    anticlockwise, at the place of contact or, apart, the nearest to it, shape (outputs, contacts).

    ``reaches`` are the :func:`places`, if they are known.
    """
    n = normals(record)
    t = np.stack([-n[..., 1], n[..., 0]], axis=2)
    total = relative_velocity(record, places(record) if reaches is None else reaches)
    return np.asarray((total * t).sum(axis=2), dtype=float)
