"""Largest normal force of a contact, from the largest resultant of normal and friction force between outputs.

The step keeps the largest resultant of all steps, and both forces at the outputs. Hertz' theory needs the
normal force alone, F_N = F/sqrt(1 + t^2) with t = |F_T|/F_N. Where an output nearly meets the largest
resultant, t is that of the output. Else t is estimated: from the output before or after the largest resultant
that is in the contact, or, where the contact lies between both, from the friction law at the sliding velocity
between them. t is between 0 and the coefficient of friction, which bounds the error of the estimate.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ..assembly.stability import joint_mobility
from ..laws.law import FrictionLaw
from ..model.surfaces import surfaces
from ..numerics.elementwise import hypot
from ..solvers.record import Record, rows_between
from .forces import slip
from .impact import steady_sliding
from .turns import last_turn, of_window

Array = NDArray[np.float64]
Window = NDArray[np.bool_]  # shape (outputs,)
# Share of the largest resultant that the largest at the outputs must reach to be the same contact.
MET = 0.9
# Digits of an estimated share. Full friction has one share at any force, but for the rounding of both forces:
# rounded, a run has that of a companion with the same step.
DIGITS = 9
FORCES = ("contact_normal_force", "contact_friction_force")
COEFFICIENTS = ("coefficient", "static_coefficient")
UNKNOWN = 1.0  # largest coefficient of friction of a law that names none


def largest_normal_forces(record: Record, window: Window | slice) -> Array:
    """Return the largest normal force of each contact over the window (N), shape (contacts,)."""
    resultant = np.sqrt(record.block("contact_force_squared_max")[window].max(axis=0))
    return np.asarray(resultant * normal_shares(record, window), dtype=float)


def normal_shares(record: Record, window: Window | slice) -> Array:
    """Return the share (1) of the normal force in the largest resultant of each contact, shape (contacts,):
    that of the output that meets it, else an estimate; 1 without any force.

    A companion, which has no forces at its outputs, has the shares of the last turn of its run.
    """
    if not all(record.keeps(name) for name in FORCES):
        run = record.run
        if run is None:
            return np.ones(len(record.assembly.contacts))
        if run.normal_shares is None:
            run.normal_shares = normal_shares(*of_window(run, last_turn(run)))
        return run.normal_shares
    shares = met_shares(record, window)
    for k in np.flatnonzero(np.isnan(shares)):
        shares[k] = round(_estimated_share(record, window, int(k)), DIGITS)
    return shares


def met_shares(record: Record, window: Window | slice) -> Array:
    """Return the shares (1) of normal forces at the outputs that meet the largest resultants; NaN where none
    does, shape (contacts,).
    """
    largest = np.sqrt(record.block("contact_force_squared_max")[window].max(axis=0))
    normal, friction = (record.block(name)[window] for name in FORCES)
    resultant = hypot(normal, friction)
    row = resultant.argmax(axis=0), np.arange(resultant.shape[1])
    met = (resultant[row] > 0.0) & (resultant[row] >= MET * largest)
    shares: Array = np.full(len(largest), np.nan)
    np.divide(normal[row], resultant[row], out=shares, where=met)
    return shares


def _estimated_share(record: Record, window: Window | slice, contact: int) -> float:
    """Estimate the share (1) of the normal force in the largest resultant of a contact from the outputs
    before and after it.
    """
    numbers = np.arange(len(record.steps))[window]
    squares = record.block("contact_force_squared_max")[numbers, contact]
    largest, end = float(np.sqrt(squares.max())), int(numbers[squares.argmax()])
    if largest == 0.0:
        return 1.0
    begin = max(end - 1, 0)
    normal, friction = (record.block(name)[begin : end + 1, contact] for name in FORCES)
    resultant = hypot(normal, friction)
    row = int(resultant.argmax())
    if normal[row] > 0.0:
        return float(normal[row] / resultant[row])
    if not record.keeps("particle_u"):
        return 1.0
    rows = rows_between(record.rows, begin, end + 1)
    part = dataclasses.replace(record, steps=record.steps[begin : end + 1], source=rows, companions=None)
    assembly = record.assembly
    joint = assembly.mechanism.contacts[assembly.contact_joints[contact]]
    speed = float(np.abs(slip(part)[:, contact]).max())
    pair = surfaces(assembly.mechanism, joint)
    [force] = steady_sliding(joint.friction, pair, largest, [speed])
    return float(1.0 / hypot(1.0, force / largest))


def share_bounds(record: Record, window: Window | slice) -> dict[str, tuple[float, float]]:
    """Return the bounds of the normal force of each contact, as multiples of the estimate: from full friction
    to none. Contacts without any force, or whose largest resultant an output meets, are left out.
    """
    assembly, shares = record.assembly, normal_shares(record, window)
    estimated = record.block("contact_force_squared_max")[window].max(axis=0) > 0.0
    estimated &= np.isnan(met_shares(record, window))
    laws = (assembly.mechanism.contacts[name].friction for name in assembly.contact_joints)
    lowest = 1.0 / hypot(1.0, np.array([largest_coefficient(law) for law in laws]))
    return {
        contact: (min(1.0, float(lowest[k] / shares[k])), float(1.0 / shares[k]))
        for k, contact in enumerate(assembly.contacts)
        if estimated[k]
    }


def largest_coefficient(law: FrictionLaw) -> float:
    """Return the largest friction force over the normal force that a law gives in dry sliding (1)."""
    names = {field.name for field in dataclasses.fields(law)}
    if not names:
        return 0.0  # "none"
    return max((float(getattr(law, name)) for name in COEFFICIENTS if name in names), default=UNKNOWN)


def friction_changes(record: Record) -> Array:
    """Return the change of the sliding velocity (m/s) of each contact that its largest coefficient of
    friction makes within a step, shape (contacts,): under the median of its normal forces at the outputs, and
    with the least mass in any direction at the start; 0 without any force.
    """
    assembly = record.assembly
    forces = record.block("contact_normal_force")
    usual = [float(np.median(column[column > 0.0])) if (column > 0.0).any() else 0.0 for column in forces.T]
    laws = [assembly.mechanism.contacts[name].friction for name in assembly.contact_joints]
    coefficients = np.array([largest_coefficient(law) for law in laws])
    inverse = joint_mobility(assembly.layout, assembly.state, assembly.topology)
    return np.asarray(coefficients * np.array(usual) * inverse * assembly.choice.step)
