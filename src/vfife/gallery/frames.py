"""Frames and beams in equilibrium far from their first shape: statics."""

from __future__ import annotations

import math

from ..laws import Material
from ..model.bodies import Member, Section
from ..model.drivers import AngleTable
from ..model.loads import PointForce
from ..model.mechanism import Mechanism, Settings

INCH = 0.0254


def elastica_circle(*, length: float = 1.0, elements: int = 20, factors: tuple[float, ...] = (0.25, 0.5, 0.75, 1.0)) -> Mechanism:
    """A clamped steel strip (m), 20 mm by 4 mm, rolled up by an end moment; factor q makes it an arc of q 360 degrees: M = q 2 pi E I/L."""
    m = Mechanism("cantilever rolled into a circle", settings=Settings(analysis="static", load_factors=factors))
    section = Section.rectangle(0.020, 0.004)
    steel = Material(youngs_modulus=200e9, poissons_ratio=0.3, density=7850.0)
    m.point("wall", 0.0, 0.0)
    m.link("strip", length=length, model="elastic", elements=elements, section=section, material=steel)
    m.weld("clamp", "ground.wall", "strip.start")
    moment = 2.0 * math.pi * steel.youngs_modulus * section.second_moment / length
    m.loads["end"] = PointForce(name="end", at="strip.end", moment=moment)
    return m


def williams_toggle(*, elements: int = 20, drops: tuple[float, ...] | None = None) -> Mechanism:
    """A shallow clamped toggle whose apex is pushed down by ``drops`` (inches, the load factors); the driver's force is the load.

    Source: F. W. Williams, An approach to the non-linear behaviour of the members of a rigid jointed plane framework with finite deflections,
    Quarterly Journal of Mechanics and Applied Mathematics 17 (1964) 451-469.
    """
    way = drops or (0.05, 0.1, 0.15, 0.2, 0.2328, 0.25, 0.3, 0.35, 0.3922, 0.4, 0.45, 0.5, 0.55, 0.6)
    m = Mechanism("Williams toggle", settings=Settings(analysis="static", load_factors=way))
    half, rise = 12.943 * INCH, 0.386 * INCH
    m.point("left", 0.0, 0.0)
    m.point("right", 2.0 * half, 0.0)
    m.frame(
        "toggle",
        nodes={"left": (0.0, 0.0), "apex": (half, rise), "right": (2.0 * half, 0.0)},
        members=(Member("left", "apex", elements), Member("apex", "right", elements)),
        section=Section.rectangle(0.753 * INCH, 0.243 * INCH),
        material=Material(youngs_modulus=71.0160e9, poissons_ratio=0.33, density=2700.0),
    )
    m.weld("left", "ground.left", "toggle.left")
    m.weld("right", "ground.right", "toggle.right")
    m.drivers["push"] = AngleTable(point="toggle.apex", direction=(0.0, -1.0), times=(0.0, 1.0), values=(0.0, INCH))
    return m


def lee_frame(*, elements: int = 10, drops: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.45, 0.5, 0.55)) -> Mechanism:
    """A hinged right-angled frame, 1.2 m by 1.2 m, pushed down at a fifth of its beam, by ``drops`` (m, the load factors).

    Source: S. L. Lee, F. S. Manuel, E. C. Rossow, Large deflections and stability of elastic frames, Journal of the Engineering Mechanics
    Division, ASCE 94 (1968) 521-547.
    """
    m = Mechanism("Lee frame", settings=Settings(analysis="static", load_factors=drops))
    side = 1.2
    m.point("foot", 0.0, 0.0)
    m.point("head", side, side)
    m.frame(
        "frame",
        nodes={"foot": (0.0, 0.0), "corner": (0.0, side), "load": (0.2 * side, side), "head": (side, side)},
        members=(
            Member("foot", "corner", elements),
            Member("corner", "load", max(2, elements // 5)),
            Member("load", "head", elements - elements // 5),
        ),
        section=Section(area=6e-4, second_moment=2e-8),
        material=Material(youngs_modulus=7.2e9, poissons_ratio=0.3, density=2700.0),
    )
    m.revolute("foot", "ground.foot", "frame.foot")
    m.revolute("head", "ground.head", "frame.head")
    m.drivers["push"] = AngleTable(point="frame.load", direction=(0.0, -1.0), times=(0.0, 1.0), values=(0.0, 1.0))
    return m
