"""Clearance, stiffness and drag from a loop of force over displacement.

The loop is made by a plain model that knows nothing of vfife: a force that is zero within the clearance and
grows with the stiffness beyond it, the drag against the motion, and noise. vfife looks for the three numbers
in a lever whose pin has clearance in a hole that a load cell holds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import vfife
from vfife import Mechanism, Settings
from vfife.drivers import Torque
from vfife.identification.measurements import Curve, Measured
from vfife.results.fit import Fit

ARM, SWING, FREQUENCY, SPAN = 0.05, 6e-3, 2.0, 0.5  # m, rad, 1/s, s
CONTACT = 1e7  # N/m, of the surfaces, in series with the cell
CLEARANCE, STIFFNESS, DRAG = 1e-4, 2e5, 3.0  # m, N/m, N: the truth
SAMPLES = 500
CELL = "spring.cell.stiffness.0,spring.cell.stiffness.1"
FRICTION = "driver.drag.torque.0,-driver.drag.torque.1"
BOUNDS: dict[str, Any] = {
    "joint.pin.clearance": (2e-5, 2.5e-4), CELL: (5e4, 1e6), FRICTION: (0.0, 10.0 * ARM)
}  # fmt: skip


def rig() -> Mechanism:
    """Build a lever that moves slowly to and fro; its pin has clearance in the hole of a load cell."""
    m = Mechanism("hysteresis rig", gravity=(0.0, 0.0))
    m.settings = Settings(duration=SPAN)
    m.point("O", 0.0, 0.0)
    m.point("A", 0.0, ARM)
    m.rigid_body("lever", mass=0.05, inertia=1e-5, pins={"pivot": (0.0, 0.0), "pin": (0.0, ARM)})
    m.rigid_body("cell", mass=0.02, inertia=1e-4, pins={"hole": (0.0, 0.0)}, position=(0.0, ARM))
    m.revolute("O", "ground.O", "lever.pivot")
    m.harmonic("lever", amplitude=SWING, frequency=FREQUENCY)
    law = {"law": "kelvin-voigt", "stiffness": CONTACT, "damping_coefficient": 100.0}
    m.clearance_joint(
        "pin", "cell.hole", "lever.pin", clearance=5e-5, bearing_radius=5e-3, contact=law, friction="none"
    )
    m.bushing("cell", "ground.A", "cell.hole", stiffness=(1e5, 1e5, 100.0), damping=(10.0, 10.0, 0.05))
    m.drivers["drag"] = Torque(body="lever", value=(0.1, -0.1), speeds=(-1e-3, 1e-3), interpolation="linear")
    return m


def loop(seed: int, noise: float = 0.03) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compute times (s), displacements (m) and forces (N) at the pin of a loop from an independent model,
    with noise (a share of the standard deviation of the force).
    """
    times = SPAN * (np.arange(SAMPLES) + 0.5) / SAMPLES
    displacements, forces = [], []
    for time in times.tolist():
        place = ARM * math.sin(SWING * math.sin(2.0 * math.pi * FREQUENCY * time))
        forward = math.cos(2.0 * math.pi * FREQUENCY * time) > 0.0
        deformation = (
            place - CLEARANCE if place > CLEARANCE else place + CLEARANCE if place < -CLEARANCE else 0.0
        )
        displacements.append(place)
        forces.append(STIFFNESS * deformation + (DRAG if forward else -DRAG))
    force = np.array(forces)
    error = noise * force.std() * np.random.default_rng(seed).standard_normal(len(force))
    return times, np.array(displacements), force + error


def identify(seed: int, noise: float = 0.03, **options: Any) -> Fit:
    """Fit the model to a loop. The force at the pin times the arm is the torque of the lever's driver."""
    times, _, force = loop(seed, noise)
    data = Measured("time", times, (Curve("lever.torque", "torque", ARM * force),), "loop")
    settings: dict[str, Any] = {
        "step": "50 us", "screened": 8, "starts": 1, "restarts": 0, "derivatives": "differences"
    }  # fmt: skip
    return vfife.fit(rig(), data, BOUNDS, **{**settings, **options})


def answers(fit: Fit) -> dict[str, tuple[float, float, float, float]]:
    """Value, limits and truth of clearance (m), stiffness (N/m) and drag (N); surfaces and cell are springs
    in series.
    """
    clearance, cell, drag = fit.values

    def series(stiffness: float) -> float:
        return 1.0 / (1.0 / stiffness + 1.0 / CONTACT)

    return {
        "clearance": (clearance.value, clearance.low, clearance.high, CLEARANCE),
        "stiffness": (series(cell.value), series(cell.low), series(cell.high), STIFFNESS),
        "drag": (drag.value / ARM, drag.low / ARM, drag.high / ARM, DRAG),
    }


def coverage(seeds: int, noise: float = 0.03) -> tuple[dict[str, int], dict[str, float]]:
    """How many of the limits of 95 % hold the truth over seeds of noise, and the largest error of each."""
    covered, worst = dict.fromkeys(("clearance", "stiffness", "drag"), 0), dict[str, float]()
    for seed in range(seeds):
        for name, (value, low, high, truth) in answers(identify(seed, noise)).items():
            covered[name] += low <= truth <= high
            worst[name] = max(worst.get(name, 0.0), abs(value / truth - 1.0))
    return covered, worst
