"""Fictitious masses of a static analysis: each particle as heavy as its stiffness wants it, so that one step suits all of them.

For a stiffness k g g^T on the motions g of its bodies w^2 = k sum(g_i^2/m_i). Where every body takes the share m_i = n k g_i^2/Omega of its n
motions, w^2 <= Omega holds for this stiffness, and for all of them together, since masses and stiffnesses are sums over the same pieces.
The stable step of the central difference, 2/w, is then at least 2/sqrt(Omega): one iteration, with Omega below 4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..assembly.stability import element_stiffness, held
from ..laws.elasticity import tangent
from ..numerics.elementwise import hypot

Array = NDArray[np.float64]

OMEGA = 3.6  # square of the highest frequency (rad/iteration)^2; 4 is the limit of stability
SWAY = 0.8  # share of the bending frequency that goes to translations, the rest to rotations


def demands(assembly: Assembly, state: Array, force: float, pressed: Array) -> tuple[Array, Array]:
    """Mass (N s^2/m, the iteration being the second) and inertia that each particle needs for iterations to be stable, shape (particles,).

    ``state``: S at present, for lengths and axial forces of elements; ``pressed`` (N): what each contact has carried of late, ``force`` at least.
    """
    mass, inertia = _elements(assembly, state)
    load = held(assembly.layout, state, assembly.topology, _contacts(assembly, np.maximum(2.0 * pressed, force)))
    # springs, axes of bushings and contacts are on four motions, torsional springs on two
    return (mass + 4.0 * load.straight) / OMEGA, (inertia + 4.0 * load.levers + 2.0 * load.about) / OMEGA


def _elements(assembly: Assembly, state: Array) -> tuple[Array, Array]:
    """Axial stiffness on two motions; bending on two across and two turns, or one where an end is released; N/l across."""
    mass, inertia = np.zeros(assembly.topology.particles), np.zeros(assembly.topology.particles)
    if not assembly.topology.frame_nodes:
        return mass, inertia
    k = element_stiffness(assembly.layout, state, assembly.topology)
    pulled = np.abs(state[assembly.layout["frame_axial_force"]]) / state[assembly.layout["reference_length"]]
    turns = np.where(k.other > 0.0, 2.0, 1.0) / (1.0 - SWAY)
    for column in (0, 1):
        np.add.at(mass, k.nodes[:, column], 2.0 * (k.along + pulled) + 2.0 / SWAY * k.across)
        np.add.at(inertia, k.nodes[:, column], turns * k.own[:, column])
    return mass, inertia


def _contacts(assembly: Assembly, force: Array) -> list[float]:
    """The tangent (N/m) of each contact law under a force (N) for each."""
    found = []
    for index, name in enumerate(assembly.contact_joints):
        law = assembly.mechanism.contacts[name].contact
        found.append(tangent(law, assembly.contact_slots(index), float(force[index]))[1] if force[index] > 0.0 else 0.0)
    return found


class Floors:
    """The least masses and inertias of an assembly's particles."""

    def __init__(self, assembly: Assembly) -> None:
        self.size = extent(assembly, assembly.state)
        self.gyration = np.zeros(assembly.topology.particles)
        for body in assembly.bodies.values():
            if body.elements:
                continue
            reach = max([0.0, *(hypot(x - body.reference[0], y - body.reference[1]) for x, y in body.pins.values())])
            self.gyration[body.particles[0]] = max(body.inertia / body.mass if body.mass > 0.0 else 0.0, reach * reach)

    def __call__(self, mass: Array, inertia: Array, least: float) -> tuple[Array, Array]:
        """Masses and inertias with ``least`` (N/m) for what has no stiffness of its own, which loads alone would hold: a pendulum, a cable.

        Inertias of rigid bodies are at least the mass times the square of their radius of gyration.
        """
        if least <= 0.0:
            positive = mass[mass > 0.0]
            least = float(np.median(positive)) * OMEGA if len(positive) else OMEGA
        mass = np.maximum(mass, least / OMEGA)
        inertia = np.maximum(inertia, self.gyration * mass)
        return mass, np.where(inertia > 0.0, inertia, mass * (self.size * self.size))


def extent(assembly: Assembly, state: Array) -> float:
    """Diagonal of the box around the particles and the points of the ground, and no less than the largest body or bearing (m)."""
    points = np.array(list(assembly.mechanism.points.values())).reshape(-1, 2)
    places = [state[assembly.layout[f"particle_{axis}"]] for axis in "xy"]
    columns = [np.concatenate([place[1:], points[:, axis]]) for axis, place in enumerate(places)]
    box = float(hypot(*(column.max() - column.min() for column in columns))) if len(columns[0]) else 0.0
    pins = [float(hypot(*at)) for body in assembly.bodies.values() for at in body.pins.values()]
    bearings = [joint.reach for joint in assembly.mechanism.contacts.values()]
    return max([box, *pins, *bearings, 1e-9])
