"""A slider-crank with a loose or lubricated pin: what compliance of the rod and a film of oil do to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import Material, Mechanism, gallery
from vfife.bodies import Link
from vfife.laws import ContactLaw, Hydrodynamic
from vfife.model.bodies import Section
from vfife.modelfile.parameter import with_values
from vfife.report.document import Table

from ..paper.contents import Chart, Item, Line, Panel, Parameter, Verdict
from . import phases
from .phases import RPM

Array = NDArray[np.float64]
ROD, ROD_MASS = 0.12, 0.21  # m, kg
STEEL = Material("steel of the rod", youngs_modulus=207e9, poissons_ratio=0.3, density=7850.0)
SPEED, CLEARANCE, VISCOSITY = 5000.0, 0.5e-3, 0.4  # rpm, m, Pa s
CLEARANCE_PATH, SPEED_PATH = "joint.pin.clearance", "driver.crank.speed"
AXIAL_LENGTH, ROD_DIAMETER = 20e-3, 16.8e-3  # m; a round steel rod of this diameter has the mass of the rod
FRICTIONS, CLEARANCES = (0.0, 0.1), (0.1e-3, 0.5e-3)  # 1, m, of dry pins
ANGLES, TURNS, LAST, OUTPUTS = 16, 4, 2, 1440  # start angles; turns, and those that count; outputs a turn
PEAK = "pin.force.max"
SCHWAB = "Schwab, Meijaard, Meijers 2002"
# Values of each number of the film while the others are as above, from little to large effect there.
RANGES: dict[str, tuple[float, ...]] = {
    "clearance": (0.2e-3, 0.3e-3, 0.5e-3),
    "speed": (1000.0, 2500.0, 5000.0),
    "viscosity": (0.8, 0.4, 0.2, 0.1, 0.05),
}
UNITS = {"clearance": (1e3, "mm"), "speed": (1.0, "rpm"), "viscosity": (1.0, "Pa s")}


class Film(NamedTuple):
    """Numbers of the last turns with a lubricated pin: the largest force (N); from the ideal mechanism, the
    rms deviation of the block's acceleration (m/s^2) and the range of that of its place (m); the thinnest
    film (m).
    """

    force: float
    acceleration: float
    place: float
    film: float


def slider_crank(friction: float = 0.0, law: ContactLaw | None = None) -> Mechanism:
    """Build the slider-crank of the gallery at 5000 rpm, with another contact law in its pin."""
    m = gallery.slider_crank_loose_pin(speed=SPEED * RPM, friction=friction, turns=TURNS)
    pin = m.clearances["pin"]
    m.joints["pin"] = replace(pin, contact=law or pin.contact, axial_length=AXIAL_LENGTH)
    return m


def elastic(m: Mechanism) -> Mechanism:
    """Make the rod an elastic bar of steel that keeps its mass."""
    section = Section.round(ROD_DIAMETER)
    material = replace(STEEL, density=ROD_MASS / (section.area * ROD))
    m.bodies["rod"] = Link(name="rod", length=ROD, model="elastic", section=section, material=material)
    return m


def peaks(m: Mechanism) -> list[phases.Scatter]:
    """Return the largest forces of the pin from several start angles, at each of CLEARANCES."""
    sets = [{CLEARANCE_PATH: clearance} for clearance in CLEARANCES]
    results = phases.scatters(m, sets, [PEAK], turns=TURNS, last=LAST, count=ANGLES)
    return [results.of(PEAK, k) for k in range(len(sets))]


@cache
def film(clearance: float = CLEARANCE, speed: float = SPEED, viscosity: float = VISCOSITY) -> Film:
    """Run the slider-crank with a lubricated pin of a clearance (m), speed (rpm) and viscosity (Pa s)."""
    m = slider_crank(law=Hydrodynamic(viscosity=viscosity))
    m = with_values(m, {CLEARANCE_PATH: clearance, SPEED_PATH: speed * RPM})
    result, ideal = (vfife.simulate(model, outputs=OUTPUTS, companions=0) for model in (m, m.ideal()))
    late = slice((TURNS - LAST) * OUTPUTS + 1, None)

    def deviation(name: str) -> Array:
        real, exact = (np.asarray(run.series[name], dtype=np.float64)[late] for run in (result, ideal))
        return real - exact

    eccentricity = np.hypot(*(np.asarray(result.series[f"pin.eccentricity_{axis}"]) for axis in "xy"))
    return Film(
        float(np.max(result.series["pin.force_max"][late])),
        float(np.sqrt(np.mean(deviation("guide.acceleration") ** 2))),
        float(np.ptp(deviation("block.x"))), clearance - float(eccentricity[late].max()),
    )  # fmt: skip


def films(name: str) -> list[Film]:
    """Return the lubricated pins along a range."""
    return [film(**{name: value}) for value in RANGES[name]]


def monotonic(values: list[float]) -> bool:
    """Return whether each value is larger than the one before."""
    return bool(np.all(np.diff(values) > 0.0))


def smooth(statement: str, pairs: Mapping[str, tuple[phases.Scatter, phases.Scatter]]) -> Verdict:
    """Judge whether a second peak is below a first one; both are means over start angles."""
    lower = all(second.mean + second.error < first.mean - first.error for first, second in pairs.values())
    higher = any(second.mean - second.error > first.mean + first.error for first, second in pairs.values())
    numbers = "; ".join(
        f"{name}: {first.mean:.3g} ± {first.error:.2g} N, {second.mean:.3g} ± {second.error:.2g} N"
        for name, (first, second) in pairs.items()
    )
    return Verdict(statement, False if higher else True if lower else None, numbers)


def by_clearance(
    dry: list[phases.Scatter], lubricated: list[phases.Scatter]
) -> dict[str, tuple[phases.Scatter, phases.Scatter]]:
    """Return pairs of peaks by the clearance in words."""
    return {
        f"{1e3 * clearance:g} mm": pair
        for clearance, pair in zip(CLEARANCES, zip(dry, lubricated, strict=True), strict=True)
    }


def schwab(dry: dict[float, list[phases.Scatter]]) -> list[Verdict]:
    """Statements of the abstract of Schwab, Meijaard and Meijers; ``dry`` peaks by friction."""
    verdicts = []
    for friction, rigid in dry.items():
        surface = f"with friction {friction:g}" if friction else "without friction"
        bar = peaks(elastic(slider_crank(friction)))
        verdicts.append(
            smooth(
                f"compliance of the links lowers the peak force, {surface} ({SCHWAB})",
                by_clearance(rigid, bar),
            )
        )
    force = [film.force for film in films("viscosity")]
    for friction, rows in dry.items():
        largest = rows[-1]
        holds = max(force) < largest.mean - largest.error, max(force) <= largest.mean + largest.error
        verdicts.append(
            Verdict(
                f"lubrication lowers the peak force, beside a dry pin of friction {friction:g} ({SCHWAB})",
                True if holds[0] else None if holds[1] else False,
                f"{min(force):.3g} to {max(force):.3g} N with 0.8 to 0.05 Pa s, dry {largest.text('N')};"
                " 0.5 mm",
            )
        )
    return verdicts


def film_verdicts() -> list[Verdict]:
    """Statements of the abstract of the study of lubricated joints."""
    source = "Advances in Mechanical Engineering 2017"
    words = {"clearance": "larger clearance", "speed": "higher speed", "viscosity": "lower viscosity"}
    verdicts = []
    for name, text in words.items():
        results = films(name)
        amplitude, place, thin = (
            [getattr(film, key) for film in results] for key in ("acceleration", "place", "film")
        )
        scale, unit = UNITS[name]
        points = " to ".join(f"{scale * value:g}" for value in (RANGES[name][0], RANGES[name][-1]))
        verdicts += [
            Verdict(
                f"{text} raises the amplitude of vibration ({source})", monotonic(amplitude),
                f"{points} {unit}: rms deviation of the block's acceleration"
                f" {', '.join(f'{number:.0f}' for number in amplitude)} m/s², range of that of its place"
                f" {', '.join(f'{1e6 * number:.0f}' for number in place)} µm",
            ),
            Verdict(
                f"{text} lowers the thinnest film ({source})", monotonic([-number for number in thin]),
                f"{points} {unit}: {', '.join(f'{1e6 * number:.1f}' for number in thin)} µm",
            ),
        ]  # fmt: skip
    return verdicts


def table(dry: dict[float, list[phases.Scatter]]) -> Table:
    """Tabulate dry pins, and the film with each number changed."""
    rows = [
        (
            f"dry, friction {friction:g}",
            f"{1e3 * clearance:g} mm",
            f"{scatter.mean:.0f} ± {scatter.error:.0f} N",
            "",
            "",
        )
        for friction, row in dry.items()
        for clearance, scatter in zip(CLEARANCES, row, strict=True)
    ]
    for name, values in RANGES.items():
        scale, unit = UNITS[name]
        rows += [
            (f"film, {name}", f"{scale * value:g} {unit}", f"{film.force:.0f} N",
             f"{film.acceleration:.0f} m/s²", f"{1e6 * film.film:.1f} µm")
            for value, film in zip(values, films(name), strict=True)
        ]  # fmt: skip
    heads = ("pin", "number", "peak force", "deviation of acceleration", "thinnest film")
    return Table(heads, rows, title="Pin of the slider-crank at 5000 rpm; film 0.5 mm, 0.4 Pa s unless given")


def chart() -> Chart:
    """Draw the amplitude and the thinnest film over each number."""
    panels = []
    for name, values in RANGES.items():
        scale, unit = UNITS[name]
        results, places = films(name), scale * np.array(values)
        thin = Line(places, np.array([1e6 * film.film for film in results]), "thinnest film (µm)")
        deviation = Line(
            places, np.array([film.acceleration for film in results]), "deviation (m/s²)", "second"
        )
        panels.append(
            Panel(f"over the {name}", f"{name} ({unit})", "µm, m/s²", [thin, deviation], logarithmic="y")
        )
    return Chart(
        "published_film", "Film of the pin, and how far the block's acceleration is from ideal", panels
    )


def item() -> Item:
    """Judge what compliance and lubrication do to a loose pin."""
    dry = {friction: peaks(slider_crank(friction)) for friction in FRICTIONS}
    text = (
        "A. L. Schwab, J. P. Meijaard, P. Meijers: Mechanism and Machine Theory 37 (2002) 895-913, and a"
        " study of a slider-crank with a lubricated joint: Advances in Mechanical Engineering 2017, doi"
        " 10.1177/1687814017744086. We could read the abstracts, but not the papers; they state"
        " trends, not numbers.",
        "Mechanism: the slider-crank of P. Flores and co-workers, crank 50 mm, rod 120 mm, here with"
        f" clearance between rod and block. Means over {ANGLES} start angles with their confidence of 95 %; a"
        " film forgets the start.",
        "Friction, which the abstract does not mention, decides whether compliance helps. Clearances of films"
        " begin at 0.2 mm: where the relative turning of rod and block changes its sign, our law moves the"
        " film to the other half of the bearing at once, and in stiff films (0.05 mm and less) this jump is"
        " the peak, which no smaller step makes converge. Means of dry peaks change by less than 10 % with"
        " 1.5 times"
        " the step.",
    )
    parameters = [
        Parameter(
            "mechanism, clearance 0.5 mm, 5000 rpm",
            "slider_crank_loose_pin",
            "chosen",
            "not in the abstracts",
        ),
        Parameter("dry contact", "lankarani-nikravesh, restitution 0.9", "chosen", "not in the abstracts"),
        Parameter("film", "hydrodynamic, 20 mm wide, 0.05 to 0.8 Pa s", "chosen", "not in the abstracts"),
        Parameter("compliance", "rod a round steel bar of 16.8 mm", "chosen", "keeps the mass of the rod"),
    ]
    data = {name: [film._asdict() for film in films(name)] for name in RANGES}
    return Item(
        "lubricated-pin", "Schwab and others 2002, and a film: what lowers the peaks of a loose pin", text,
        parameters, [chart()], [table(dry)], [*schwab(dry), *film_verdicts()], data,
    )  # fmt: skip
