"""A single-cylinder air compressor: a slider-crank with the gas in its cylinder and play in both pins of its rod and of its piston."""

from __future__ import annotations

import math
from typing import Any

from ..laws import Ambrosio, LankaraniNikravesh
from ..model.loads import GuideForce
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..numerics.scalar import power

BORE, STROKE, ROD = 0.065, 0.046, 0.100  # m
DEAD = 0.05  # volume left at the upper dead centre over that of the stroke
SUCTION, DELIVERY, AMBIENT = 0.95e5, 8.4e5, 1.013e5  # Pa
POLYTROPIC = 1.3
PLACES = (0, 1, 2, 3, 4, 5, 6, 6.73, 8, 10, 11, 13, 15, 18, 22, 26, 30, 36, 42, 46)  # mm under the upper dead centre
FITS = {"big-end": (14e-3, 22e-3, 20e-6), "small-end": (8e-3, 20e-3, 10e-6)}  # m: radius, length, radial play
PISTON = (0.050, BORE, 40e-6)  # m: length, diameter, radial play
LAWS: dict[str, Any] = {"contact": LankaraniNikravesh(restitution=0.5), "friction": Ambrosio(coefficient=0.05, v0=1e-3, v1=1e-2)}


def compressor(*, wear: float = 1.0, speed: float = 1450.0 * 2.0 * math.pi / 60.0, turns: float = 6.0) -> Mechanism:
    """Bore 65 mm, stroke 46 mm, 8.4 bar: some 200 l of free air a minute at 1450 rpm (``speed`` in rad/s), as workshops have them.

    Both pins of the rod and the piston in its cylinder have play, which ``wear`` multiplies: at 1 they are new, 28 mm H7/f7 and 16 mm H7/g6 in the
    middle of the tolerances of ISO 286-2, and a piston with 80 um; at 0 they are ideal. The gas goes from suction to delivery along
    p V^1.3 = const, and back from a dead space of 5 % of the stroke: values of small air-cooled compressors, as in Dubbel, Taschenbuch fuer den
    Maschinenbau, chapter Kolbenverdichter.
    """
    crank, head = 0.5 * STROKE, 0.5 * STROKE + ROD
    m = Mechanism("air compressor", gravity=(-9.81, 0.0), settings=Settings(turns=turns), start=StartSettings(journals="seated"))
    m.point("shaft", 0.0, 0.0)
    m.link("crank", length=crank, mass=2.4, inertia=0.012, center_at=0.0, angle=math.pi)  # a balanced crankshaft with its flywheel
    m.link("rod", length=ROD, mass=0.23, inertia=3.4e-4, center_at=0.03)  # steel; a third of it goes with the piston
    m.rigid_body("piston", mass=0.28, inertia=1.5e-4, position=(ROD - crank, 0.0))  # aluminium, with its pin and rings
    m.revolute("main", "ground.shaft", "crank.start")
    for name, bearing, journal in (("big-end", "crank.end", "rod.start"), ("small-end", "rod.end", "piston.center")):
        radius, width, play = FITS[name]
        if wear:
            m.clearance(name, bearing, journal, clearance=wear * play, bearing_radius=radius, axial_length=width, **LAWS)
        else:
            m.revolute(name, bearing, journal)
    length, height, play = PISTON
    if wear:
        m.clearance_slider("cylinder", "ground.shaft", "piston.center", clearance=wear * play, length=length, height=height, **LAWS)
    else:
        m.slider("cylinder", "ground.shaft", "piston.center")
    m.drive("crank", speed=speed)
    places, up, down = gas()
    m.loads["gas"] = GuideForce(
        name="gas", slider="cylinder", reverse=True, bore=BORE, ambient=AMBIENT, zero_travel=head, travels=places, pressure=up, pressure_back=down,
    )  # fmt: skip
    return m


def gas() -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Places of the piston (m, negative below the upper dead centre), and pressures there on its way up and down (Pa)."""
    left = DEAD * STROKE

    def along(start: float, pressure: float, place: float) -> float:
        return float(pressure * power((start + left) / (place + left), POLYTROPIC))

    ways = sorted(1e-3 * place for place in PLACES)[::-1]
    up = tuple(round(min(DELIVERY, along(STROKE, SUCTION, place)), -1) for place in ways)
    down = tuple(round(max(SUCTION, along(0.0, DELIVERY, place)), -1) for place in ways)
    return tuple(-place for place in ways), up, down
