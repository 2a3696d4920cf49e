"""What ``vfife verify trends`` shows: statements of the literature that are true or false here, figures."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from vfife.report.document import Table

from ..paper.contents import Chart, Item, Line, Panel, Ribbon, Verdict
from . import runs
from .grid import PHASES, Grid
from .mechanisms import AXIAL_LENGTH, BEARING_RADIUS, RPM
from .statements import (
    EARLES,
    FARAHANCHI,
    FLORES,
    FOUR_BAR_WEAR,
    MA,
    MEASURED_CHAIN,
    further_joints,
    growth,
    larger_count,
    largest_effect,
    reversal,
)

TITLE = "Trends over clearance and speed"
INTRODUCTION = (
    "Statements of the literature on linkages with clearance, beside runs of vfife. Each number is the median"
    " over ten start angles of the crank; bands contain 10 to 90 % of them. A median rises or falls only"
    " where the intervals of 97.9 % confidence (order statistics) of two medians do not overlap. Statements"
    " are true or false for these mechanisms; contradictions are shown as openly as agreement."
)
STYLES = ("main", "second", "third", "fourth", "fifth")
SCATTERED = 0.05  # width of the band over the median, above which a motion counts as scattered
UNEVEN = 2.0  # times the mean depth of wear
# Largest acceleration of the ideal follower over the square of the crank speed.
IDEAL_ACCELERATION = 0.924700


def over_clearance(one: Grid, name: str, title: str, label: str, scale: float = 1.0) -> Panel:
    """Median and band of a measure over the clearance, a line for each speed."""
    places = 1e3 * np.asarray(one.clearances)
    middle, (low, high) = scale * one.median(name), (scale * each for each in one.band(name))
    lines, ribbons = list[Line](), list[Ribbon]()
    for k, (speed, style) in enumerate(zip(one.speeds, STYLES, strict=False)):
        lines.append(Line(places, middle[:, k], f"{speed / RPM:.0f} rpm", style))
        ribbons.append(Ribbon(places, low[:, k], high[:, k], style))
    return Panel(title, "clearance (mm)", label, lines, logarithmic="y", ribbons=ribbons)


def medians(one: Grid, name: str, title: str) -> Table:
    """Medians and their intervals, a row for each clearance."""
    low, high = one.interval(name)
    rows = [
        (f"{1e3 * clearance:g} mm", *(f"{m:.4g} ({a:.4g} to {b:.4g})" for m, a, b in zip(*each, strict=True)))
        for clearance, *each in zip(one.clearances, one.median(name), low, high, strict=True)
    ]
    return Table(("clearance", *(f"{speed / RPM:.0f} rpm" for speed in one.speeds)), rows, title=title)


def step_error(one: Grid, names: Sequence[str]) -> str:
    """How much repeated cases changed with a larger step."""
    changes = ", ".join(f"{name} by {one.step_errors[name][0]:.2g}" for name in names)
    return (
        f"Numerical error: of 20 cases repeated with 1.5 times the step, half change {changes} (SI units) or"
        " less. Irregular motions change by as much as between start angles, so that only medians and bands"
        " of them mean anything."
    )


def clearance_and_speed() -> Item:
    """Peak force, impact energy and wear of the slider-crank."""
    one = runs.pin()
    chart = Chart(
        "clearance_and_speed", "Slider-crank with a loose pin: median and 10 to 90 % of ten start angles",
        [
            over_clearance(one, runs.PEAK, "largest force at the pin", "force (N)"),
            over_clearance(one, runs.IMPACT, "energy lost in impacts in a turn", "energy (J)"),
            over_clearance(one, runs.VOLUME, "worn volume in a turn", "volume (mm³)", 1e9),
        ],
    )  # fmt: skip
    text = (
        "Slider-crank of the clearance literature: crank 50 mm, rod 120 mm, clearance between rod and block,"
        " Hertz contact with restitution 0.9, Coulomb friction 0.1. Runs have six turns, of which the last"
        " three count.",
        step_error(one, (runs.PEAK, runs.IMPACT, runs.VOLUME)),
    )
    tables = [medians(one, runs.PEAK, "Largest force (N): median and its interval of 97.9 %")]
    data = {name: one.median(name).tolist() for name in one.values}
    return Item(
        "clearance-and-speed", "Peak force, impact energy and wear", text, (), [chart], tables,
        slider_crank_statements(one), data,
    )  # fmt: skip


def slider_crank_statements(one: Grid) -> list[Verdict]:
    """Statements on growth with clearance and with speed, and on wear."""
    smooth = runs.pin_with(0.0, 0.9)
    ideal = f"; ideal forces by {(one.speeds[-1] / one.speeds[0]) ** 2:.0f}"
    mean_depth = one.median(runs.VOLUME) / (2.0 * math.pi * BEARING_RADIUS * AXIAL_LENGTH)
    uneven = one.median(runs.DEPTH) / mean_depth
    impacts = "the energy of impacts grows with the"
    return [
        growth("peaks grow with the clearance, friction 0.1", MEASURED_CHAIN, one, runs.PEAK, "clearance"),
        growth("peaks grow with the clearance, no friction", MEASURED_CHAIN, smooth, runs.PEAK, "clearance"),
        growth("peaks grow with the speed", MEASURED_CHAIN, one, runs.PEAK, "speed", ideal),
        growth(f"{impacts} clearance", MEASURED_CHAIN, one, runs.IMPACT, "clearance"),
        growth(f"{impacts} speed", MEASURED_CHAIN, one, runs.IMPACT, "speed", ideal),
        growth("wear grows with the speed", FOUR_BAR_WEAR, one, runs.VOLUME, "speed", ideal),
        growth("wear grows with the clearance", "an assumption", one, runs.VOLUME, "clearance"),
        Verdict(
            f"wear is not uniform: its depth exceeds {UNEVEN:g} times the mean around the joint ({FLORES})",
            bool((uneven > UNEVEN).all()), f"{uneven.min():.3g} to {uneven.max():.3g} times the mean",
        ),
        reversal(one, runs.PEAK),
    ]  # fmt: skip


def chain() -> Item:
    """Which joint of the four-bar matters most."""
    single, every = {joint: runs.loose(joint) for joint in runs.JOINTS}, runs.loose(runs.JOINTS)
    ideal = IDEAL_ACCELERATION * np.square(every.speeds)
    effects = {joint: one.median(runs.ACCELERATION) / ideal - 1.0 for joint, one in single.items()}
    work = {joint: one.median(f"{joint}.friction_energy.total") for joint, one in single.items()}
    ratios = work["D"] / work["C"]
    last, first = (
        "the joint at the end of the chain, D, matters most",
        "the joint at the crank, B, matters most",
    )
    impacts = "impacts grow with the clearance"
    verdicts = [
        largest_effect("D", last, MEASURED_CHAIN, effects),
        largest_effect("B", first, MA, effects),
        *(
            growth(f"{joint}: {impacts}", MEASURED_CHAIN, one, runs.ACCELERATION, "clearance")
            for joint, one in single.items()
        ),
        *(further_joints(joint, one, every) for joint, one in single.items()),
        Verdict(
            f"joints of one mechanism wear very differently ({FOUR_BAR_WEAR})", bool((ratios > 2.0).all()),
            f"work of friction in D over that in C: {ratios.min():.3g} to {ratios.max():.3g}",
        ),
    ]  # fmt: skip
    named = [*single.items(), ("B, C and D", every)]
    panels = [
        over_clearance(one, runs.ACCELERATION, f"clearance in {name}", "acceleration (rad/s²)")
        for name, one in named
    ]
    caption = "Four-bar: largest acceleration of the follower, median and 10 to 90 % of ten start angles"
    text = (
        "Four-bar of the source paper with uniform rods: B joins crank and coupler, C coupler and follower, D"
        " follower and ground; each is loose alone, then all are. The dimensions of the measured mechanism of"
        " 2021, which has three loose joints, could not be read; here the pivot of the follower is the end of"
        " the chain.",
        step_error(single["B"], (runs.ACCELERATION,)),
    )
    tables = [
        medians(one, runs.ACCELERATION, f"Clearance in {name}: acceleration (rad/s²)") for name, one in named
    ]
    data = {joint: values.tolist() for joint, values in effects.items()}
    chart = Chart("chain", caption, panels, 2)
    return Item("chain", "Which joint of a chain matters most", text, (), [chart], tables, verdicts, data)


def contact_loss() -> Item:
    """Where contact is lost."""
    every = runs.losses()
    count, predicted = sum(len(one.flight.losses) for one in every), sum(one.predicted for one in every)
    twice = sum(one.flight.regions == 2 for one in every)
    never = sum(one.flight.regions == 0 for one in every)
    where = (
        "contact is lost where the ideal force is small and turns fast: most losses lie in the quarter of the"
        " turn in which the rate of its direction over its size is largest"
    )
    verdicts = [
        Verdict(
            f"{where} ({EARLES})", predicted > count / 2 if count else None,
            f"{predicted} of {count} losses; 25 % by chance",
        ),
        Verdict(
            f"free flight, impact and contact follow each other twice a turn ({MEASURED_CHAIN})",
            twice == len(every), f"in {twice} of {len(every)} runs; {never} runs never lose contact",
        ),
    ]  # fmt: skip
    rows = [
        (one.name, f"{100.0 * one.flight.share:.2f} %", str(one.flight.regions),
         f"{one.flight.losses_per_turn:g}", f"{one.predicted} of {len(one.flight.losses)}",
         f"{one.largest_rate:.3g}")
        for one in every
    ]  # fmt: skip
    heads = ("joint", "free flight", "regions", "losses a turn", "predicted", "largest rate (rad/(s N))")
    text = (
        "Eight turns from one start, of which the last four count, at 720 outputs a turn. A loss follows at"
        " least 10° of contact, so that bounces do not count; regions of free flight are 20° apart.",
    )
    table = Table(heads, rows, title="Free flight after four turns")
    data = {"losses": count, "predicted": predicted, "twice": twice, "never": never}
    return Item("contact-loss", "Where contact is lost", text, (), (), [table], verdicts, data)


def scatter() -> Item:
    """Which motions depend on their start."""
    widths = {name: runs.pin_with(*one).scatter(runs.PEAK) for name, one in runs.SURFACES.items()}
    wide = {name: width > SCATTERED for name, width in widths.items()}
    counts = {name: int(one.sum()) for name, one in wide.items()}
    numbers = "; ".join(f"{name}: {count} of {wide[name].size}" for name, count in counts.items())
    slow, fast = (sum(int(one[:, k].sum()) for one in wide.values()) for k in (0, -1))
    dry, dry_soft, smooth, smooth_soft = counts.values()
    size = sum(one.size for one in wide.values()) // 2
    column = size * 2 // len(runs.FEW_SPEEDS)
    verdicts = [
        larger_count("irregular motion prevails where friction is low", FARAHANCHI, smooth + smooth_soft,
             dry + dry_soft, size, numbers),
        larger_count("motion is regular where restitution is low", FARAHANCHI, dry + smooth,
             dry_soft + smooth_soft, size, numbers),
        larger_count("irregular motion prevails at high speed", FARAHANCHI, fast, slow, column,
             f"{fast} of {column} at {runs.FEW_SPEEDS[-1] / RPM:.0f} rpm, {slow} at"
             f" {runs.FEW_SPEEDS[0] / RPM:.0f} rpm"),
    ]  # fmt: skip
    rows = [
        (name, f"{1e3 * clearance:g} mm", *(f"{100.0 * value:.2g} %" for value in line))
        for name, width in widths.items()
        for clearance, line in zip(runs.FEW_CLEARANCES, width, strict=True)
    ]
    text = (
        f"Width of the band of the largest force over its median, from {PHASES} start angles,"
        f" in turns 4 to 6. A regular motion forgets its start; more than {100.0 * SCATTERED:g} % counts as"
        " irregular, or not yet settled. The thesis classifies motions by Poincaré sections, which is a"
        " sharper criterion.",
    )
    heads = ("surfaces", "clearance", *(f"{speed / RPM:.0f} rpm" for speed in runs.FEW_SPEEDS))
    table = Table(heads, rows, title="Width of the band over the median")
    return Item("scatter", "Which motions depend on their start", text, (), (), [table], verdicts, counts)


ITEMS: dict[str, Callable[[], Item]] = {
    "clearance-and-speed": clearance_and_speed,
    "chain": chain,
    "contact-loss": contact_loss,
    "scatter": scatter,
}
