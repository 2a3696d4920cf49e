"""What the joints carry and where their journals are: forces on the journal, eccentricity, penetration and mode."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..assembly import Record
from .motion import pin_path

Array = NDArray[np.float64]
FREE_FLIGHT, IMPACT, CONTINUOUS_CONTACT = 0, 1, 2
MODES = ("free_flight", "impact", "continuous_contact")  # their names, in this order
BLOCK = {"clearances": "clearance", "ideals": "ideal", "pivots": "driven"}


def joint_rows(record: Record) -> dict[str, tuple[str, int]]:
    """Kind of row (``clearance``, ``ideal``, ``driven``) of each joint and its place there, joints in the mechanism's
    order.
    """
    found = {}
    for kind, block in BLOCK.items():
        for index, name in enumerate(getattr(record.assembly, kind)):
            found[name] = (block, index)
    return {name: found[name] for name in record.assembly.mechanism.joints if name in found}


def eccentricity(record: Record) -> Array:
    """Journal centre seen from the bearing centre, global axes (m), shape (outputs, clearances, 2): Eq. 20."""
    paths = []
    for name in record.assembly.clearances:
        bearing, journal = (pin_path(record, *side) for side in record.assembly.mechanism.joints[name].sides)
        paths.append(journal - bearing)
    return np.stack(paths, axis=1) if paths else np.zeros((len(record.steps), 0, 2))


def joint_force(record: Record) -> Array:
    """Force of each joint on its journal, global axes (N), shape (outputs, joints, 2).

    A joint with clearance gives -F_N n + F_T t, n from the bearing's centre to the journal's and t = n turned
    anticlockwise.
    """
    rows = joint_rows(record)
    force = np.zeros((len(record.steps), len(rows), 2))
    contact = _contact_force(record) if record.assembly.clearances else None
    for k, (name, (block, index)) in enumerate(rows.items()):
        if block == "clearance" and contact is not None:
            force[:, k] = contact[:, index]
            continue
        force[:, k, 0], force[:, k, 1] = record.block(f"{block}_fx")[:, index], record.block(f"{block}_fy")[:, index]
        if block == "driven" and record.assembly.mechanism.joints[name].sides[0][0] != "ground":
            force[:, k] *= -1.0  # the row holds the force on the driven body, which is the bearing here
    return force


def _contact_force(record: Record) -> Array:
    away = eccentricity(record)
    n = away / np.maximum(np.linalg.norm(away, axis=2, keepdims=True), 1e-300)
    t = np.stack([-n[..., 1], n[..., 0]], axis=2)
    normal, friction = record.block("clearance_normal_force"), record.block("clearance_friction_force")
    return np.asarray(friction[..., None] * t - normal[..., None] * n, dtype=float)


def joint_force_max(record: Record) -> Array:
    """Largest force of each joint in the interval up to an output (N), shape (outputs, joints)."""
    rows = joint_rows(record)
    squares = [record.block(f"{block}_force_squared_max")[:, index] for block, index in rows.values()]
    return np.sqrt(np.stack(squares, axis=1)) if squares else np.zeros((len(record.steps), 0))


def modes(record: Record) -> NDArray[np.int8]:
    """Mode of each clearance joint at an output, shape (outputs, clearances).

    2 continuous contact where the penetration is positive, 0 free flight elsewhere, and 1 impact where a contact
    began since the output before: an impact lasts one step (Eq. 19), and no sample would meet it.
    """
    mode = np.where(record.block("clearance_penetration") > 0.0, CONTINUOUS_CONTACT, FREE_FLIGHT)
    began = np.diff(record.block("clearance_onsets"), axis=0, prepend=0.0) > 0.0
    return np.where(began, IMPACT, mode).astype(np.int8)


def shares(record: Record) -> dict[str, Array]:
    """Share of all steps in each mode, shape (clearances,).

    An impact is a step at which a contact begins, continuous contact is every further step of it.
    """
    steps = float(record.steps[-1] + 1)
    impact = record.block("clearance_onsets")[-1] / steps
    lasting = record.block("clearance_contact_steps")[-1] / steps
    return dict(zip(MODES, (1.0 - impact - lasting, impact, lasting), strict=True))
