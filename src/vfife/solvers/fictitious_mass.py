"""Fictitious masses of a static analysis: each particle as heavy as its stiffness wants it, so that one step suits all of them.

For a stiffness k g g^T on the motions g of its bodies w^2 = k sum(g_i^2/m_i). Where every body takes the share m_i = n k g_i^2/Omega of its n
motions, w^2 <= Omega holds for this stiffness, and for all of them together, since masses and stiffnesses are sums over the same pieces.
The stable step of the central difference, 2/w, is then at least 2/sqrt(Omega): one iteration, with Omega below 4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..laws.elasticity import tangent

Array = NDArray[np.float64]

OMEGA = 3.6  # square of the highest frequency (rad/iteration)^2; 4 is the limit of stability
SWAY = 0.8  # share of the bending frequency that goes to translations, the rest to rotations


def demands(assembly: Assembly, state: Array, force: float, pressed: Array) -> tuple[Array, Array]:
    """Mass (N s^2/m, the iteration being the second) and inertia that each particle needs for iterations to be stable, shape (particles,).

    ``state``: S at present, for lengths and axial forces of elements; ``pressed`` (N): what each contact has carried of late, ``force`` at least.
    """
    mass, inertia = np.zeros(assembly.topology.particles), np.zeros(assembly.topology.particles)
    _elements(assembly, state, mass, inertia)
    _springs(assembly, state, mass, inertia)
    _contacts(assembly, state, np.maximum(2.0 * pressed, force), mass, inertia)
    return mass / OMEGA, inertia / OMEGA


def _elements(assembly: Assembly, state: Array, mass: Array, inertia: Array) -> None:
    """Axial EA/l on two motions; bending 12 EI/l^3 and 4 EI/l (one end released: 3 EI/l on its rotation and 3 EI/l^3); N/l across."""
    topology, layout = assembly.topology, assembly.layout
    if not topology.frame_nodes:
        return
    nodes, release = np.array(topology.frame_nodes), np.array(topology.frame_release)
    inverse = state[layout["reference_inverse_length"]]
    bend = state[layout["frame_bending_stiffness"]] * inverse
    along = 2.0 * (state[layout["frame_axial_stiffness"]] + np.abs(state[layout["frame_axial_force"]])) * inverse
    across = np.select([release == 0, release == 3], [24.0, 0.0], 6.0) / SWAY * bend * inverse**2
    whole, one = 8.0 / (1.0 - SWAY) * bend, 3.0 / (1.0 - SWAY) * bend
    for column, free in ((0, 1), (1, 2)):
        np.add.at(mass, nodes[:, column], along + across)
        turn = np.select([release == 0, release == 3 - free], [whole, one], 0.0)
        np.add.at(inertia, nodes[:, column], turn)


def _springs(assembly: Assembly, state: Array, mass: Array, inertia: Array) -> None:
    """Axes of springs and bushings on four motions, torsional ones on two."""
    topology, layout = assembly.topology, assembly.layout
    for index, pair in enumerate(zip(topology.spring_first, topology.spring_second, strict=True)):
        row = layout.row("spring_stiffness", index)
        straight, turning = float(state[row : row + 2].max()), float(state[row + 2])
        for side, body in zip(("first", "second"), pair, strict=True):
            arm = sum(float(state[layout.row(f"spring_{side}_{axis}", index)]) ** 2 for axis in "xy")
            mass[body] += 4.0 * straight
            inertia[body] += 4.0 * straight * arm + 2.0 * turning


def _contacts(assembly: Assembly, state: Array, force: Array, mass: Array, inertia: Array) -> None:
    """The tangent of each contact law under a force (N) for each."""
    topology, layout = assembly.topology, assembly.layout
    for index, name in enumerate(assembly.contact_joints):
        law = assembly.mechanism.contacts[name].contact
        row = layout.row("contact_slots", index)
        slots = tuple(float(value) for value in state[row : row + len(law.slots)])
        if force[index] <= 0.0:
            continue
        stiffness = tangent(law, slots, float(force[index]))[1]
        for side, body in (("bearing", topology.contact_bearing[index]), ("journal", topology.contact_journal[index])):
            arm = sum(float(state[layout.row(f"contact_{side}_{axis}", index)]) ** 2 for axis in "xy")
            mass[body] += 4.0 * stiffness
            inertia[body] += 4.0 * stiffness * arm


def floors(assembly: Assembly, mass: Array, inertia: Array, least: float) -> tuple[Array, Array]:
    """Masses and inertias with ``least`` (N/m) for what has no stiffness of its own, which loads alone would hold: a pendulum, a cable.

    Inertias of rigid bodies are at least the mass times the square of their radius of gyration.
    """
    if least <= 0.0:
        positive = mass[mass > 0.0]
        least = float(np.median(positive)) * OMEGA if len(positive) else OMEGA
    mass = np.maximum(mass, least / OMEGA)
    gyration = np.zeros(len(mass))
    for body in assembly.bodies.values():
        if body.elements:
            continue
        reach = max([0.0, *(np.hypot(x - body.reference[0], y - body.reference[1]) for x, y in body.pins.values())])
        gyration[body.particles[0]] = max(body.inertia / body.mass if body.mass > 0.0 else 0.0, reach**2)
    inertia = np.maximum(inertia, gyration * mass)
    return mass, np.where(inertia > 0.0, inertia, mass * extent(assembly, assembly.state) ** 2)


def extent(assembly: Assembly, state: Array) -> float:
    """Diagonal of the box around the particles and the points of the ground, and no less than the largest body or bearing (m)."""
    points = np.array(list(assembly.mechanism.points.values())).reshape(-1, 2)
    places = [state[assembly.layout[f"particle_{axis}"]] for axis in "xy"]
    columns = [np.concatenate([place[1:], points[:, axis]]) for axis, place in enumerate(places)]
    box = float(np.hypot(*(column.max() - column.min() for column in columns))) if len(columns[0]) else 0.0
    pins = [float(np.hypot(*at)) for body in assembly.bodies.values() for at in body.pins.values()]
    bearings = [joint.reach for joint in assembly.mechanism.contacts.values()]
    return max([box, *pins, *bearings, 1e-9])
