"""A bearing under a steady load: Hertz' line pressure and Archard's wear by hand."""

from __future__ import annotations

import math

import vfife
from vfife.laws import Coulomb, Frictionless
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.wear import Wear
from vfife.simulation.result import Result

from .case import Nudge, Row, Rows, verified

FORCE, SPEED, CLEARANCE, RADIUS, LENGTH = 100.0, 50.0, 5e-5, 0.01, 0.02  # N, rad/s, m
WEAR = 1e-15, 2e-16  # 1/Pa, of bearing and journal
YOUNG, POISSON = 2.07e11, 0.3  # of steel, the material of both surfaces by default


def bearing(friction: Coulomb | Frictionless, load: float) -> Result:
    """Run ten turns of a shaft in the loose bearing of a housing that a steady ``load`` (N) presses
    sideways.
    """
    m = Mechanism("bearing under a steady load")
    m.point("A", 0.0, 0.0)
    m.rigid_body("shaft", mass=2.0, inertia=2e-3, pins={"c": (0.0, 0.0)})
    m.rigid_body("housing", mass=1.0, inertia=1e-3, pins={"c": (0.0, 0.0)})
    m.revolute("A", "ground.A", "shaft.c")
    m.slider("guide", "ground.A", "housing.c", direction=(1.0, 0.0))
    m.clearance_joint(
        "J", "housing.c", "shaft.c", clearance=CLEARANCE, bearing_radius=RADIUS, axial_length=LENGTH,
        friction=friction, wear=Wear(bearing=WEAR[0], journal=WEAR[1]),
    )  # fmt: skip
    m.loads["press"] = PointForce(name="press", at="housing.c", force=(load, 0.0))
    m.drive("shaft", speed=SPEED)
    return vfife.simulate(m, turns=10, outputs=720, reference=False)


@verified(
    "Bearing under a steady load",
    "Hertz: p = √(F E*/(π L R)), a = √(4 F R/(π L E*)), R = r(r - c)/c, 1/E* = 2 (1 - ν²)/E; Archard:"
    " V = k F s",
    nudges={"load": 1.02},
)
def loaded_bearing(nudge: Nudge) -> Rows:
    """Line pressure and half-width of a journal without friction; with friction, the volumes that a turn
    wears off bearing and journal, whose surfaces slide by the circumference of the journal.
    """
    load = FORCE * nudge("load")
    modulus = YOUNG / (2.0 * (1.0 - POISSON**2))
    journal = RADIUS - CLEARANCE
    curvature = RADIUS * journal / CLEARANCE
    smooth = bearing(Frictionless(), load).measures
    pressure = math.sqrt(FORCE * modulus / (math.pi * LENGTH * curvature))
    width = math.sqrt(4.0 * FORCE * curvature / (math.pi * LENGTH * modulus))
    yield Row("line pressure", "Pa", pressure, smooth["J.contact_pressure.max"], 1e-3)
    yield Row("half-width of the contact", "m", width, smooth["J.contact_half_width.max"], 1e-3)
    rough = bearing(Coulomb(coefficient=0.1), load).measures
    for name, coefficient in zip(("bearing", "journal"), WEAR, strict=True):
        volume = coefficient * FORCE * 2.0 * math.pi * journal
        yield Row(f"wear of the {name} in a turn", "m³", volume, rough[f"J.{name}_wear.total"], 1e-3)
