"""The mechanism of limit/four_bar_limit.c as the array and the integers that the kernels step.

Built here row by row and not through a mechanism, because it has to be exactly what the C program has: the
masses, the rotary inertia, the unstressed start and the prescribed crank pin.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vfife.compiler.runtime.runner import Runner
from vfife.kernels.arrays import Layout
from vfife.kernels.topology import Topology
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh, Pereira

FOLLOWER_PIN = 4  # particle
TOPOLOGY = Topology(
    particles=6,  # ground, crank, coupler's ends, follower's ends (upper first)
    free=(2, 3, 4, 5),
    trig=(1,),
    frame_nodes=((2, 3), (5, 4)),
    frame_release=(0, 0),
    contact_bearing=(1, 3, 0),
    contact_journal=(2, 4, 5),
    contact_form=(0, 0, 0),
    friction_form=(0, 0, 0),
    driven=(1,),
    driven_function=(-1,),
    weightless=True,  # as assembly says of a mechanism without gravity
    body_nodes=((1, 1), (2, 3), (5, 4)),
    contact_laws=(LankaraniNikravesh, Pereira),
    friction_laws=(Ambrosio, Frictionless),
)
STEP = 1e-6
GROUND, CRANK, COUPLER, FOLLOWER = 0.15, 0.4, 0.26, 0.46
SPEED, AREA, MODULUS, RADIUS = 50 * math.pi, 1e-3, 207e9, 0.01
LAWS = {"contact_slots": (6.6e10, 0.75 * (1 - 0.81)), "contact_friction_slots": (0.1, 1e-2, 1e-1 - 1e-2)}


def state(clearance: float = 2e-4) -> NDArray[np.float64]:
    """S at the start, shape (rows,)."""
    layout = Layout(TOPOLOGY)
    S = np.zeros(layout.rows)
    g, r, a, b, w = GROUND, CRANK, COUPLER, FOLLOWER, SPEED
    mc, mf, gyration = 7.8 * a / 2, 7.8 * b / 2, AREA / 12
    d = g - r
    th = math.atan2(0.0, d) - math.acos((a * a + d * d - b * b) / (2 * a * abs(d)))
    x, y = r + a * math.cos(th), a * math.sin(th)
    det = (x - r) * y - y * (x - g)
    u, v = y * r * w * y / det, -y * r * w * (x - g) / det
    oc, of = ((x - r) * (v - r * w) - y * u) / (a * a), ((x - g) * v - y * u) / (b * b)
    masses, inertias = np.array([mc, mc, mf, mf]), gyration * np.array([mc, mc, mf, mf])
    values = {
        "particle_x": [0, 0, r, x, x, g],
        "particle_y": [0, 0, 0, y, y, 0],
        "particle_u": [0, 0, 0, u, u, 0],
        "particle_v": [0, 0, r * w, v, v, 0],
        "particle_w": [0, w, oc, oc, of, of],
        "particle_inverse_mass": [0, 0, *(1 / masses)],
        "particle_inverse_inertia": [0, 0, *(1 / inertias)],
        "reference_length": [a, b],
        "reference_inverse_length": [1 / a, 1 / b],
        "reference_cosine": [(x - r) / a, (x - g) / b],
        "reference_sine": [y / a, y / b],
        "frame_axial_stiffness": MODULUS * AREA,
        "frame_bending_stiffness": MODULUS * AREA * gyration,
        "contact_bearing_x": [r, 0, g],
        "contact_size": clearance,
        "contact_floor": 0.01,
        "contact_landing": 1e-5,
        "contact_arm_bearing": RADIUS,
        "contact_arm_journal": RADIUS - clearance,
        "driven_speed": w,
        "driven_inertia": 1.0,
        "step": STEP,
    }
    for name, value in values.items():
        S[layout[name]] = value
    for joint in range(3):
        for block, law in LAWS.items():
            row = layout.row(block, joint)
            S[row : row + len(law)] = law
    return S


def runner(loop: str, lanes: int = 1) -> Runner:
    """The model at its start; lane i has a clearance i micrometres larger, as in the C program."""
    layout = Layout(TOPOLOGY)
    states = np.stack([state(2e-4 + 1e-6 * i) for i in range(lanes)], axis=1)
    kept = np.array(layout.of("state", "extreme"), dtype=np.uint32)
    return Runner(TOPOLOGY, states, np.zeros((lanes, 1)), loop, kept)
