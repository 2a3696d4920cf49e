"""Piston slap: a slider-crank whose block has clearance in its guide, after Farahanchi (1991)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vfife import Mechanism, gallery
from vfife.dynamics import bifurcation, poincare_section
from vfife.measures.chaos import STEP_UNKNOWN, kind_words
from vfife.modelfile.parameter import with_values
from vfife.report.document import Table

from ..paper.contents import Chart, Item, Line, Panel, Parameter, Verdict
from .phases import RPM

Array = NDArray[np.float64]
SPEEDS = (200.0, 1000.0, 3000.0, 6000.0)  # rpm
RESTITUTIONS = (0.5, 0.6, 0.7, 0.8, 0.9)
FRICTIONS = (0.0, 0.3)
SLOW = 2  # speeds without gravity: the first ones
TURNS, SECTION_TURNS = 90, 300  # of a motion
BINS = 36  # of 10 degrees of the crank
RESTITUTION_PATH, SPEED_PATH = "joint.guide.contact.restitution", "driver.crank.speed"
FRICTION_PATH = "joint.guide.friction.coefficient"
SERIES = ("block.y", "block.v")
CLEARANCE = 0.5e-3  # m
PRINTED = ((3000.0, 0.5), (3000.0, 0.9), (6000.0, 0.9))  # rpm and restitution of the sections
CHAOTIC, PERIODIC = "chaotic", "period"


class Kinds(NamedTuple):
    """Kinds of motion and largest Lyapunov exponents (1/turn) over restitutions, a row for each speed."""

    speeds: tuple[float, ...]
    kinds: list[tuple[str, ...]]
    exponents: list[Array]

    def count(self, kind: str, restitution: float | None = None, speed: float | None = None) -> int:
        """Count motions of a kind, all or those of a restitution and speed."""
        return sum(
            label.startswith(kind)
            for row_speed, row in zip(self.speeds, self.kinds, strict=True)
            for e, label in zip(RESTITUTIONS, row, strict=True)
            if restitution in (None, e) and speed in (None, row_speed)
        )


class Impacts(NamedTuple):
    """Section of a motion: its kind, height over clearance (1) and speed (m/s) of the block once a turn;
    crank angles (degrees) and speeds (m/s) of its impacts.
    """

    kind: str
    height: Array
    velocity: Array
    crank: Array
    speed: Array

    @property
    def spread(self) -> float:
        """Number of bins of the turn over which the impacts spread, exp of the entropy of their shares."""
        count = np.histogram(self.crank, BINS, (0.0, 360.0))[0]
        share = count[count > 0] / count.sum()
        return float(np.exp(-(share * np.log(share)).sum()))


def slap(speed: float, restitution: float = 0.9, friction: float = 0.0, gravity: bool = True) -> Mechanism:
    """Build the slider-crank with a speed (rpm) of its crank, with or without gravity across the walls."""
    numbers = {SPEED_PATH: speed * RPM, RESTITUTION_PATH: restitution, FRICTION_PATH: friction}
    m = with_values(gallery.piston_slap(), numbers)
    m.gravity = m.gravity if gravity else (0.0, 0.0)
    return m


def kinds(friction: float = 0.0, gravity: bool = True, speeds: tuple[float, ...] = SPEEDS) -> Kinds:
    """Classify the motion at each speed and restitution."""
    models = [slap(speed, friction=friction, gravity=gravity) for speed in speeds]
    ends = RESTITUTIONS[0], RESTITUTIONS[-1]
    diagrams = [
        bifurcation(
            m, RESTITUTION_PATH, *ends, count=len(RESTITUTIONS), starts=[{}], companions=0, turns=TURNS
        )
        for m in models
    ]
    return Kinds(
        speeds,
        [diagram.kinds[0] for diagram in diagrams],
        [diagram.exponents[0, :, 0] for diagram in diagrams],
    )


def impacts(speed: float, restitution: float, turns: int = SECTION_TURNS) -> Impacts:
    """Compute the Poincaré section of a motion and its impacts."""
    section = poincare_section(slap(speed, restitution), joints=["guide"], series=SERIES, turns=turns)
    struck = section.struck["guide"]
    height, velocity = (section.points[name] for name in SERIES)
    crank = np.degrees(struck["crank"]) % 360.0
    return Impacts(section.verdict.kind, height / CLEARANCE, velocity, crank, struck["speed"])


def verdicts(results: dict[float, Kinds], floating: Kinds, sections: list[Impacts]) -> list[Verdict]:
    """Judge the statements of the abstract; ``results`` by friction, ``floating`` without gravity."""
    smooth, rough = results[FRICTIONS[0]], results[FRICTIONS[-1]]
    size, periods = len(SPEEDS) * len(RESTITUTIONS), (smooth.count(PERIODIC), smooth.count(CHAOTIC))
    by_speed = [smooth.count(CHAOTIC, speed=speed) for speed in SPEEDS]
    by_restitution = [smooth.count(CHAOTIC, restitution=e) for e in RESTITUTIONS]
    chaos = smooth.count(CHAOTIC), rough.count(CHAOTIC)
    loose = floating.count(PERIODIC, speed=SPEEDS[0])
    chaotic_spreads = [section.spread for section in sections if section.kind == CHAOTIC]
    uneven = [section.spread for section in sections if section.kind != CHAOTIC]
    slow = smooth.count(PERIODIC, speed=SPEEDS[0])
    return [
        Verdict(
            "chaotic motion prevails at high crank speeds", by_speed[0] == 0 < by_speed[-1],
            f"{', '.join(map(str, by_speed))} of {len(RESTITUTIONS)} restitutions at"
            f" {', '.join(f'{speed:g}' for speed in SPEEDS)} rpm are chaotic within {TURNS} turns",
        ),
        Verdict(
            "chaotic motion prevails with relatively ideal impacts",
            bool(by_restitution[-1] > by_restitution[0]),
            f"{', '.join(map(str, by_restitution))} of {len(SPEEDS)} speeds with restitution"
            f" {', '.join(f'{e:g}' for e in RESTITUTIONS)} are chaotic within {TURNS} turns",
        ),
        Verdict(
            "it prevails with low friction of the bearing",
            chaos[0] > 1.25 * chaos[1],
            f"{chaos[0]} of {size} motions without friction and {chaos[1]} with {FRICTIONS[-1]:g} are"
            f" chaotic within {TURNS} turns; the friction of the thesis may be another one",
        ),
        Verdict(
            "motion is periodic at low crank speeds", slow == len(RESTITUTIONS),
            f"{slow} of {len(RESTITUTIONS)} at {SPEEDS[0]:g} rpm; gravity decides, without it {loose} of"
            f" {len(RESTITUTIONS)} within {TURNS} turns",
        ),
        Verdict(
            "motion is periodic with low restitution",
            smooth.count(PERIODIC, 0.5) + rough.count(PERIODIC, 0.5) == 2 * len(SPEEDS),
            f"{smooth.count(PERIODIC, 0.5)} and {rough.count(PERIODIC, 0.5)} of {len(SPEEDS)} speeds with"
            f" restitution 0.5, friction {FRICTIONS[0]:g} and {FRICTIONS[-1]:g}",
        ),
        Verdict(
            "chaotic motions spread their impacts over the turn, periodic ones do not",
            bool(chaotic_spreads and uneven)
            and min(chaotic_spreads) > 2.0 * max(uneven),
            f"over {', '.join(f'{spread:.0f}' for spread in chaotic_spreads)} of {BINS} bins of 10° where"
            f" chaotic within {SECTION_TURNS} turns,"
            f" {', '.join(f'{spread:.0f}' for spread in uneven)} where periodic",
        ),
        Verdict(
            "three types of motion occur: periodic, chaotic and transient chaos",
            None if min(periods) else False,
            f"{periods[0]} periodic motions of {size} and {periods[1]} chaotic within {TURNS} turns, which do"
            " not show whether chaos ends later",
        ),
    ]  # fmt: skip


def table(results: Kinds, title: str) -> Table:
    """Tabulate kinds of motion and exponents."""
    rows = [
        (f"{speed:g} rpm", *(
            kind_words(kind, TURNS) + ("" if math.isnan(value) else f" ({value:.1f})")
            for kind, value in zip(row, values, strict=True)
        ))
        for speed, row, values in zip(results.speeds, results.kinds, results.exponents, strict=True)
    ]  # fmt: skip
    return Table(("speed", *(f"restitution {e:g}" for e in RESTITUTIONS)), rows, title=title)


def chart(sections: list[Impacts]) -> Chart:
    """Draw the Poincaré section and the impacts of each motion."""
    panels = []
    for (speed, e), section in zip(PRINTED, sections, strict=True):
        name = f"{speed:g} rpm, restitution {e:g}: {kind_words(section.kind, SECTION_TURNS)}"
        # Rounded, because a periodic motion has one point, whose last digits would set the axes.
        points = Line(np.round(section.height, 6), np.round(1e3 * section.velocity, 3), dots=True)
        hits = Line(section.crank, 1e3 * section.speed, dots=True)
        panels += [
            Panel(f"once a turn, {name}", "height over clearance", "speed (mm/s)", [points]),
            Panel(f"impacts, {name}", "crank angle (°)", "speed of impact (mm/s)", [hits]),
        ]
    return Chart("published_slap", "Poincaré sections and impacts of the block in its guide", panels, 2)


def item() -> Item:
    """Judge which motions of a block between two walls are chaotic."""
    results = {friction: kinds(friction) for friction in FRICTIONS}
    floating = kinds(gravity=False, speeds=SPEEDS[:SLOW])
    sections = [impacts(*operating_point) for operating_point in PRINTED]
    text = (
        "F. Farahanchi: thesis, Michigan State University 1991 (d.lib.msu.edu/etd/23236). We could read the"
        " abstract, but neither the thesis nor the paper with S. W. Shaw. The abstract states no number.",
        "Without gravity and with rigid walls nothing in the model depends on the speed: the speed only"
        " scales time. Gravity across the walls, which the abstract does not"
        " mention, therefore decides what happens at low speed. A block with four corners instead of a round"
        " one (slider_crank_loose_guide) is chaotic in all cases that were tried, with restitution 0.4 too.",
    )
    parameters = [
        Parameter("lengths, masses", "50 mm, 120 mm", "chosen", "not in the abstract"),
        Parameter("clearance, gravity", "0.5 mm; across the walls", "chosen", "not in the abstract"),
        Parameter("walls", "hertz, gonthier-exact; coulomb", "chosen", "not in the abstract"),
    ]
    tables = [
        *(
            table(result, f"Motion with friction {friction:g} (exponent a turn, {STEP_UNKNOWN})")
            for friction, result in results.items()
        ),
        table(floating, "Motion without friction and without gravity"),
    ]
    data = {
        "kinds": [list(row) for row in results[0.0].kinds],
        "spread": [section.spread for section in sections],
    }
    return Item(
        "piston-slap", "Farahanchi 1991: chaotic and periodic piston slap", text, parameters,
        [chart(sections)], tables, verdicts(results, floating, sections), data,
    )  # fmt: skip
