"""What the joints carry and where their journals are: forces on the journal, eccentricity, penetration and
mode.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model.geometry.path import Path
from ..model.wear import depth_at
from ..numerics.elementwise import atan2, hypot, sincos
from ..solvers.record import Record
from .motion import seen

Array = NDArray[np.float64]
FREE_FLIGHT, IMPACT, CONTINUOUS_CONTACT = 0, 1, 2
KINDS = ("bearing", "round", "line", "slot")  # of contacts, in the order of their numbers
MODES = ("free_flight", "impact", "continuous_contact")  # their names, in this order


def joint_rows(record: Record) -> dict[str, tuple[str, list[int]]]:
    """Kind of row (``clearance``, ``ideal``, ``driven``) of each joint and its places there, in the
    mechanism's order; gears and drivers last.

    A block in a guide with play has four contacts.
    """
    assembly = record.assembly
    found: dict[str, tuple[str, list[int]]] = {}
    for kind, block in (("contact_joints", "contact"), ("ideals", "joint"), ("pivots", "driven")):
        for index, name in enumerate(getattr(assembly, kind)):
            found.setdefault(name, (block, []))[1].append(index)
    return {name: found[name] for name in (*assembly.mechanism.joints, *found) if name in found}


def eccentricity(record: Record) -> Array:
    """Journal centre seen from the bearing's pin, global axes (m), shape (outputs, contacts, 2): Eq. 20."""
    if not record.assembly.contacts:
        return np.zeros((len(record.steps), 0, 2))
    return np.asarray(seen(record, "contact", "journal") - seen(record, "contact", "bearing"), dtype=float)


def normals(record: Record) -> Array:
    """Unit vector of each contact against which its normal force acts on the journal, shape (outputs,
    contacts, 2): Eq. 24.

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
    """Unit vectors (outputs, 2) along which the penetration of worn surfaces grows fastest; see
    ``kernels/wear.py``.
    """
    wear, slope = record.assembly.mechanism.contacts[record.assembly.contact_joints[k]].wear, 0.0
    for side in ("bearing", "journal"):
        angle = record.block("particle_theta")[:, getattr(record.assembly.topology, f"contact_{side}")[k]]
        slope = slope + depth_at(getattr(wear, f"{side}_profile"), atan2(n[:, 1], n[:, 0]) - angle)[1]
    lean = (slope / np.maximum(hypot(*away.T), 0.5 * record.parameter("contact_size")[k]))[:, None]
    return np.asarray(
        (n - lean * np.stack([-n[:, 1], n[:, 0]], axis=1)) / np.sqrt(1.0 + lean * lean), dtype=float
    )


def _off_the_path(away: Array, angle: Array, path: Path | None) -> Array:
    """Unit vectors (outputs, 2) from the middle of a slot to the journal, which is at ``away`` (m) from the
    bearing's pin.
    """
    found = np.zeros_like(away)
    for row, ((x, y), s, c) in enumerate(zip(away, *sincos(angle), strict=True)):
        distance, nx, ny = (0.0, 0.0, 0.0) if path is None else path.seen(c * x + s * y, c * y - s * x)
        side = 1.0 if distance >= 0.0 else -1.0
        found[row] = side * (c * nx - s * ny), side * (s * nx + c * ny)
    return found


def joint_force(record: Record) -> Array:
    """Force of each joint on its journal, global axes (N), shape (outputs, joints, 2).

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
    """Force of each contact on the journal (N), shape (outputs, contacts, 2)."""
    n = normals(record)
    t = np.stack([-n[..., 1], n[..., 0]], axis=2)
    normal, friction = record.block("contact_normal_force"), record.block("contact_friction_force")
    return np.asarray(friction[..., None] * t - normal[..., None] * n, dtype=float)


def joint_moment(record: Record) -> Array:
    """Moment of each ideal joint on its journal's body (N m), 0 where it has none, shape (outputs, joints)."""
    rows = joint_rows(record)
    moment = np.zeros((len(record.steps), len(rows)))
    for k, (block, indices) in enumerate(rows.values()):
        if block == "joint":
            moment[:, k] = record.block("joint_moment")[:, indices[0]]
    return moment


def joint_force_max(record: Record) -> Array:
    """Largest force of each joint in the interval up to an output (N), shape (outputs, joints); of a block in
    a guide that of its corners together.

    A file of a former version has the largest of one corner only.
    """
    squares = [
        record.block(f"{block}_force_squared_max")[:, places].max(axis=1)
        for block, places in peaks(record).values()
    ]
    return np.sqrt(np.stack(squares, axis=1)) if squares else np.zeros((len(record.steps), 0))


def peaks(record: Record) -> dict[str, tuple[str, list[int]]]:
    """As :func:`joint_rows`, of the extremes of the joints' forces: those of a block in a guide are of its
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
    """Mode of each clearance joint at an output, shape (outputs, clearances).

    2 continuous contact where the penetration is positive, 0 free flight elsewhere, and 1 impact where a
    contact began since the output before: an impact lasts one step (Eq. 19), and no sample would meet it.
    """
    mode = np.where(record.block("contact_penetration") > 0.0, CONTINUOUS_CONTACT, FREE_FLIGHT)
    began = np.diff(record.block("contact_onsets"), axis=0, prepend=0.0) > 0.0
    return np.where(began, IMPACT, mode).astype(np.int8)


def shares(record: Record) -> dict[str, Array]:
    """Share of the time in each mode, shape (clearances,).

    An impact is a step in which a contact begins, continuous contact is all of it but for its first step.
    """
    steps = float(record.steps[-1] + 1)
    impact = record.block("contact_onsets")[-1] / steps
    lasting = record.block("contact_duration")[-1] / (steps * record.assembly.choice.step)
    return dict(zip(MODES, (np.maximum(1.0 - impact - lasting, 0.0), impact, lasting), strict=True))
