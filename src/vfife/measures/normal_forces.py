"""Largest normal force of a contact, from the largest resultant of normal and friction force between outputs.

The step keeps the largest resultant of all steps, and both forces at the outputs. Hertz' theory needs the
normal force alone, F_N = F/sqrt(1 + t^2) with t = |F_T|/F_N. Where an output nearly meets the largest
resultant, t is that of the output. Where a contact is shorter than the interval of the outputs t is unknown;
then the resultant stands for the normal force, which is less by 1/sqrt(1 + mu^2) at the most.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ..laws.law import FrictionLaw
from ..numerics.elementwise import hypot
from ..solvers.record import Record

Array = NDArray[np.float64]
Window = NDArray[np.bool_]  # shape (outputs,)
# Share of the largest resultant that the largest at the outputs must reach to be the same contact.
MET = 0.9
FORCES = ("contact_normal_force", "contact_friction_force")
COEFFICIENTS = ("coefficient", "static_coefficient")
UNKNOWN = 1.0  # largest coefficient of friction of a law that names none


def largest_normal_forces(record: Record, window: Window) -> Array:
    """Return the largest normal force of each contact over the window (N), shape (contacts,)."""
    resultant = np.sqrt(record.block("contact_force_squared_max")[window].max(axis=0))
    shares = normal_shares(record, window)
    return np.asarray(resultant * np.where(np.isnan(shares), 1.0, shares), dtype=float)


def normal_shares(record: Record, window: Window | slice) -> Array:
    """Return the share (1) of the normal force in the largest resultant of each contact, shape (contacts,);
    NaN where no output meets that.

    A companion, which has no forces at its outputs, has the shares of its run.
    """
    if not all(record.keeps(name) for name in FORCES):
        unknown = np.full(len(record.assembly.contacts), np.nan)
        return unknown if record.normal_shares is None else record.normal_shares
    largest = np.sqrt(record.block("contact_force_squared_max")[window].max(axis=0))
    normal, friction = (record.block(name)[window] for name in FORCES)
    resultant = hypot(normal, friction)
    row = resultant.argmax(axis=0), np.arange(resultant.shape[1])
    met = (resultant[row] > 0.0) & (resultant[row] >= MET * largest)
    shares: Array = np.full(len(largest), np.nan)
    np.divide(normal[row], resultant[row], out=shares, where=met)
    return shares


def lowest_shares(record: Record, window: Window | slice) -> dict[str, float]:
    """Return the least share (1) of its value that the normal force of a contact may have; 1 where outputs
    meet its largest resultant.
    """
    assembly = record.assembly
    met = ~np.isnan(normal_shares(record, window))
    laws = (assembly.mechanism.contacts[name].friction for name in assembly.contact_joints)
    bounds = 1.0 / hypot(1.0, np.array([largest_coefficient(law) for law in laws]))
    return dict(zip(assembly.contacts, np.where(met, 1.0, bounds).tolist(), strict=True))


def largest_coefficient(law: FrictionLaw) -> float:
    """Return the largest friction force over the normal force that a law gives in dry sliding (1)."""
    names = {field.name for field in dataclasses.fields(law)}
    if not names:
        return 0.0  # "none"
    return max((float(getattr(law, name)) for name in COEFFICIENTS if name in names), default=UNKNOWN)
