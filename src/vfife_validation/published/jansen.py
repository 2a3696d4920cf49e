"""Jansen's leg with one and with two loose pins, beside the abstracts of J. Wang (2026)."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import Mechanism, gallery
from vfife.modelfile.parameter import with_values
from vfife.report.document import Table
from vfife.studies import indices
from vfife.studies.methods.sensitivity_indices import Index

from ..paper.contents import Chart, Item, Line, Panel, Parameter, Verdict
from . import phases

Array = NDArray[np.float64]
IDEAL, ONE_LOOSE, TWO_LOOSE = 48.0, 104.0, 426.0  # N, peaks of the abstract
ARC, GROWTH = 10.0, 36.0  # degrees that wear concentrates on; growth there over the uniform one
PINS = ("C", "G")  # the load-bearing ones: strut on the frame, strut on the lower rod
BASE: dict[str, float] = {
    "joint.C.clearance": 1e-4, "material.bush.youngs_modulus": 3e9, "driver.crank.speed": 2.0 * math.pi,
    "load.payload.force.1": 1e-3, "joint.C.contact.restitution": 0.9, "joint.C.friction.coefficient": 0.1,
}  # fmt: skip
SCALES: tuple[tuple[str, str, float], ...] = (
    ("clearance 0.05 mm", "joint.C.clearance", 5e-5),
    ("clearance 0.2 mm", "joint.C.clearance", 2e-4),
    ("modulus 0.3 GPa", "material.bush.youngs_modulus", 3e8),
    ("modulus 30 GPa", "material.bush.youngs_modulus", 3e10),
    ("crank 30 rpm", "driver.crank.speed", math.pi),
    ("crank 120 rpm", "driver.crank.speed", 4.0 * math.pi),
    ("20 N upwards at the foot", "load.payload.force.1", 20.0),
    ("restitution 0.5", "joint.C.contact.restitution", 0.5),
    ("friction 0.01", "joint.C.friction.coefficient", 0.01),
)
SCALE_ANGLES = 4  # crank angles of the scales
GROUPS = 32  # of Saltelli's design
RANGES: dict[str, tuple[str, float, float]] = {
    "clearance": ("joint.C.clearance", 5e-5, 2e-4),
    "modulus of the bush": ("material.bush.youngs_modulus", 1e9, 1e10),
    "speed": ("driver.crank.speed", math.pi, 4.0 * math.pi),
    "restitution": ("joint.C.contact.restitution", 0.5, 0.9),
    "friction": ("joint.C.friction.coefficient", 0.01, 0.1),
    "crank angle at the start": ("body.crank.angle", 0.0, 2.0 * math.pi),
}
STRUT = 0.393, 0.397  # m, of the classical leg, and of a second design
BINS = 36  # of 10 degrees
PEAK = "C.force.max"


def leg(loose: str = "C") -> Mechanism:
    """Build the leg with clearance in the pins that ``loose`` names."""
    m = gallery.jansen_leg_loose()
    m.joints.update({name: joint.ideal() for name, joint in m.clearances.items() if name not in loose})
    return m


def other_pins(loose: str) -> dict[str, list[str]]:
    """Paths of the other loose pins, which get the numbers of the first."""
    return {path: [path.replace(".C.", f".{pin}.") for pin in loose[1:]] for path in BASE if ".C." in path}


def ideal_peak(numbers: Mapping[str, float]) -> float:
    """Largest force (N) of pin C of the ideal leg, whose speed and load are those of ``numbers``."""
    chosen = {path: value for path, value in numbers.items() if path.startswith(("driver", "load"))}
    return float(vfife.simulate(with_values(leg(""), chosen), companions=0).measures[PEAK])


def at_base(loose: str) -> phases.Scatters:
    """Both designs of the leg from sixteen crank angles."""
    designs = [{"body.strut.length": length} for length in STRUT]
    return phases.scatters(leg(loose), designs, [PEAK])


def scales(loose: str) -> list[phases.Scatter]:
    """Peak forces over ideal ones, with our numbers and with one of them changed, as SCALES lists them."""
    sets = [BASE, *({**BASE, path: value} for _, path, value in SCALES)]
    peaks = phases.scatters(leg(loose), sets, [PEAK], count=SCALE_ANGLES, shared=other_pins(loose))
    return [peaks.of(PEAK, k).relative_to(ideal_peak(numbers)) for k, numbers in enumerate(sets)]


def reversals(first: Array, second: Array) -> float:
    """Share of pairs of single runs that order two designs otherwise than their means do (1)."""
    order = np.sign(first.mean() - second.mean())
    return float((np.sign(first[:, None] - second[None, :]) != order).mean())


def wear_around(count: int = SCALE_ANGLES) -> Array:
    """Friction energy (J) of pin C around its bearing in one turn, in bins of 10 degrees, (phases, bins)."""
    rows = []
    for angle in phases.angles(count):
        model = with_values(leg("C"), {"body.crank.angle": angle, "run.turns": 2.0})
        rows.append(vfife.simulate(model, companions=0).around(bins=BINS, last_turn=True).friction[0])
    return np.stack(rows)


def verdicts(single: phases.Scatters, double: phases.Scatters, wear: Array) -> list[Verdict]:
    """Statements of the abstract that hold or fail with our numbers alone."""
    ideal = ideal_peak(BASE)
    one_pin, two_pins = single.of(PEAK), double.of(PEAK)
    designs = [(peaks.of(PEAK, 0), peaks.of(PEAK, 1)) for peaks in (single, double)]
    lengths = [reversals(first.values, second.values) for first, second in designs]
    pins = reversals(one_pin.values, two_pins.values)
    spread = max(float(peaks.values.max() / peaks.values.min()) for pair in designs for peaks in pair)
    mean = wear.mean(axis=0)
    concentration = float(BINS * mean.max() / mean.sum())
    return [
        Verdict(
            "an ideal pin underestimates the peak force", one_pin.values.min() > ideal,
            f"{one_pin.text('N')} with one loose pin, {ideal:.3g} N with none",
        ),
        Verdict(
            "a single run can reverse the order of two designs, so their means have to be compared",
            max(*lengths, pins) > 0.0,
            f"one against two loose pins: {100 * pins:.0f} % of pairs of runs, means {one_pin.mean:.3g} and"
            f" {two_pins.mean:.3g} N; struts of {1e3 * STRUT[0]:.0f} and {1e3 * STRUT[1]:.0f} mm:"
            f" {100 * lengths[0]:.0f} and {100 * lengths[1]:.0f} %",
        ),
        Verdict(
            "it can reverse designs whose mean peaks differ 4 times, as those of the abstract do",
            spread >= 4.0, f"single runs of one design differ up to {spread:.2g} times here",
        ),
        Verdict(
            f"wear concentrates on an arc of {ARC:.0f}°: local growth is {GROWTH:.0f} times the uniform one",
            concentration >= 0.8 * GROWTH,
            f"the worst {ARC:.0f}° take {100 * concentration / BINS:.0f} % of the friction energy,"
            f" {concentration:.3g} times the uniform share; half of it lies within {half_arc(mean):.0f}°."
            f" {GROWTH:.0f} times is 360° over 10°: all wear in one such arc",
        ),
    ]  # fmt: skip


def scale_verdicts(rows: list[tuple[phases.Scatter, phases.Scatter]]) -> list[Verdict]:
    """Statements of the abstract on peak forces; ``rows``: over the ideal peak, with one and two loose
    pins, our numbers first.
    """
    singles = [single.mean for single, _ in rows]
    ratios = [double.mean / single.mean for single, double in rows]
    goal = ONE_LOOSE / IDEAL
    inside = min(singles) <= goal <= max(singles)
    return [
        Verdict(
            f"one loose pin gives about {goal:.2g} times the ideal peak (104 N of 48 N)",
            True if 0.8 <= singles[0] / goal <= 1.25 else None if inside else False,
            f"{rows[0][0].text('times')} with our numbers; what the abstract leaves open moves it from"
            f" {min(singles):.3g} to {max(singles):.3g}",
        ),
        Verdict(
            f"a second loose pin raises the peak {TWO_LOOSE / ONE_LOOSE:.2g} times above that of one"
            " (426 N of 104 N)",
            max(ratios) >= 0.8 * TWO_LOOSE / ONE_LOOSE,
            f"{min(ratios):.3g} to {max(ratios):.3g} times over all rows of the table",
        ),
    ]  # fmt: skip


def half_arc(mean: Array) -> float:
    """Angle (degrees) of the fewest bins that hold half of the sum."""
    largest = np.sort(mean)[::-1]
    return float((1 + np.searchsorted(np.cumsum(largest), 0.5 * largest.sum())) * 360.0 / BINS)


def chart(single: phases.Scatters, double: phases.Scatters, wear: Array) -> Chart:
    """Peak forces over the crank angle at the start, and friction around the bearing."""
    angles = np.degrees(phases.angles())
    places = np.arange(BINS) * 360.0 / BINS - 180.0 + 180.0 / BINS
    shares = 100.0 * wear.mean(axis=0) / wear.mean(axis=0).sum()
    return Chart(
        "published_jansen", "Peak force of pin C from 16 crank angles, and friction around its bearing",
        [
            Panel("peak force", "crank angle at the start (°)", "force (N)", [
                Line(angles, single.of(PEAK).values, "one loose pin", "main", True),
                Line(angles, double.of(PEAK).values, "two loose pins", "second", True),
                Line(angles, np.full(len(angles), IDEAL), "ideal", "ideal"),
                Line(angles, np.full(len(angles), ONE_LOOSE), "abstract, one loose pin", "circle"),
            ]),
            Panel("friction around the bearing", "angle (°)", "share in 10° (%)", [Line(places, shares)]),
        ], 2,
    )  # fmt: skip


def item() -> Item:
    """Peaks from sixteen crank angles, the order of two designs, and the arc of wear."""
    began = time.perf_counter()
    single = at_base("C")
    seconds = time.perf_counter() - began
    two, wear = at_base("CG"), wear_around()
    changes = [100.0 * peaks.step_change(PEAK) for peaks in (single, two)]
    text = (
        "J. Wang, arXiv:2606.25208 and arXiv:2606.22129 (2026). We could read the abstracts, but not the"
        " papers. They leave open clearance, stiffness, restitution, friction, speed, payload, masses, the"
        " loose"
        " pins and the optimised lengths.",
        f"Means over crank angles change by {changes[0]:+.1f} and {changes[1]:+.1f} % (one and two loose"
        " pins) with 1.5 times the step.",
        f"{phases.COUNT} crank angles of two designs with one loose pin took {seconds:.0f} s here.",
    )
    parameters = [
        Parameter("contact and friction", "lankarani-nikravesh, ambrosio", "stated", "abstract"),
        Parameter("lengths", "the classical ones", "chosen", "the optimised ones are unknown"),
        Parameter("masses", "rods of 77 g/m", "chosen", "such that the ideal pin C carries 48 N"),
        Parameter("clearance, bush", "0.1 mm; 5 mm, 3 GPa", "chosen", "not in the abstract"),
        Parameter("restitution, friction", "0.9; 0.1", "chosen", "not in the abstract"),
        Parameter("speed, payload", "60 rpm; none", "chosen", "not in the abstract"),
    ]
    data: dict[str, Any] = {
        "one": single.of(PEAK).values.tolist(), "two": two.of(PEAK).values.tolist(),
        "wear": wear.mean(axis=0).tolist(),
    }  # fmt: skip
    return Item(
        "jansen-leg", "Wang 2026: Jansen's leg with loose pins", text, parameters,
        [chart(single, two, wear)], [], verdicts(single, two, wear), data,
    )  # fmt: skip


def sobol_item(groups: int = GROUPS) -> Item:
    """Rank the numbers that the abstracts leave open by Sobol' indices of the peak force of one loose pin."""
    vary = {name: {"path": path, "from": low, "to": high} for name, (path, low, high) in RANGES.items()}
    study = vfife.study(leg("C"), vary, [PEAK], method="saltelli", count=groups, turns=2, last=1)
    shares = cast(Sequence[Index], indices(study, PEAK)[0].rows)
    ranking = sorted(shares, key=lambda index: -index.total)
    low_high = {name: f"{low:.3g} to {high:.3g}" for name, (_, low, high) in RANGES.items()}
    rows = [
        (index.parameter, low_high[index.parameter], f"{index.first:.2f} ± {index.first_margin:.2f}",
         f"{index.total:.2f} ± {index.total_margin:.2f}")
        for index in ranking
    ]  # fmt: skip
    heads = ("number", "range (SI units)", "first order", "total")
    title = f"Sobol' indices of the peak force of pin C, {len(study.done)} runs, with 95 % confidence"
    text = (
        "The share of the variance of the peak that each open number makes alone, and with all that it acts"
        " together with. The crank angle at the start stands for what a single run cannot know. The Sobol'"
        " indices of the second abstract are of wear with ideal joints and optimised lengths; ours are not"
        " comparable with them.",
    )
    data = {index.parameter: [index.first, index.total] for index in ranking}
    table = Table(heads, rows, title=title, numbers=(2, 3))
    return Item("jansen-sobol", "Jansen's leg: which unknown number decides", text, (), [], [table], [], data)


def scale_item() -> Item:
    """How much each number that the abstracts leave open changes the peak force over the ideal one."""
    names = ["none", *(name for name, _, _ in SCALES)]
    rows = list(zip(scales("C"), scales("CG"), strict=True))
    change = [single.mean / rows[0][0].mean for single, _ in rows]
    strongest = max(range(len(rows)), key=lambda k: abs(math.log(change[k])))
    table = Table(
        ("changed number", "one loose pin / ideal", "two loose pins / ideal"),
        [
            (name, single.text(""), double.text(""))
            for name, (single, double) in zip(names, rows, strict=True)
        ],
        title="Peak force of pin C over the ideal one: mean ± 95 % confidence (single runs),"
        f" {SCALE_ANGLES} angles",
    )
    text = (
        "The ratio to the ideal leg is compared, because the abstracts leave open all numbers that the force"
        f" depends on. The strongest of the changes: {names[strongest]}, {change[strongest]:.2g} times the"
        " ratio of the first row.",
    )
    data = {name: [single.mean, double.mean] for name, (single, double) in zip(names, rows, strict=True)}
    return Item(
        "jansen-scales", "Jansen's leg: what the unknown numbers do", text, (), [], [table],
        scale_verdicts(rows), data,
    )  # fmt: skip
