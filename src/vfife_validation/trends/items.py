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
    "Statements of the literature on linkages with clearance, compared with runs of vfife. Each number is"
    " the median"
    " over ten start angles of the crank; bands contain 10 to 90 % of them. A median rises or falls only"
    " where the intervals of 97.9 % confidence (order statistics) of two medians do not overlap. Statements"
    " are true or false for these mechanisms; contradictions are shown as openly as agreement."
)
STYLES = ("main", "second", "third", "fourth", "fifth")
SCATTERED = 0.05  # width of the band over the median, above which a motion counts as scattered
UNEVEN = 2.0  # times the mean depth of wear
# Largest acceleration of the ideal follower over the square of the crank speed.
IDEAL_ACCELERATION = 0.924700


def over_clearance(grid: Grid, name: str, title: str, label: str, scale: float = 1.0) -> Panel:
    """Median and band of a measure over the clearance, a line for each speed."""
    places = 1e3 * np.asarray(grid.clearances)
    middle, (low, high) = scale * grid.median(name), (scale * limit for limit in grid.band(name))
    lines, ribbons = list[Line](), list[Ribbon]()
    for k, (speed, style) in enumerate(zip(grid.speeds, STYLES, strict=False)):
        lines.append(Line(places, middle[:, k], f"{speed / RPM:.0f} rpm", style))
        ribbons.append(Ribbon(places, low[:, k], high[:, k], style))
    return Panel(title, "clearance (mm)", label, lines, logarithmic="y", ribbons=ribbons)


def medians(grid: Grid, name: str, title: str) -> Table:
    """Medians and their intervals, a row for each clearance."""
    low, high = grid.interval(name)
    rows = [
        (
            f"{1e3 * clearance:g} mm",
            *(f"{m:.4g} ({a:.4g} to {b:.4g})" for m, a, b in zip(*values, strict=True)),
        )
        for clearance, *values in zip(grid.clearances, grid.median(name), low, high, strict=True)
    ]
    return Table(("clearance", *(f"{speed / RPM:.0f} rpm" for speed in grid.speeds)), rows, title=title)


def step_error(grid: Grid, names: Sequence[str]) -> str:
    """How much repeated cases changed with a larger step."""
    changes = ", ".join(f"{name} by {grid.step_errors[name][0]:.2g}" for name in names)
    return (
        f"Numerical error: of 20 cases repeated with 1.5 times the step, half change {changes} (SI units) or"
        " less. Irregular motions change by as much as between start angles, so only their medians and"
        " bands are meaningful."
    )


def clearance_and_speed() -> Item:
    """Peak force, impact energy and wear of the slider-crank."""
    grid = runs.pin()
    chart = Chart(
        "clearance_and_speed", "Slider-crank with a loose pin: median and 10 to 90 % of ten start angles",
        [
            over_clearance(grid, runs.PEAK, "largest force at the pin", "force (N)"),
            over_clearance(grid, runs.IMPACT, "energy lost in impacts in a turn", "energy (J)"),
            over_clearance(grid, runs.VOLUME, "worn volume in a turn", "volume (mm³)", 1e9),
        ],
    )  # fmt: skip
    text = (
        "Slider-crank of the clearance literature: crank 50 mm, rod 120 mm, clearance between rod and block,"
        " Hertz contact with restitution 0.9, Coulomb friction 0.1. Runs have six turns, of which the last"
        " three count.",
        step_error(grid, (runs.PEAK, runs.IMPACT, runs.VOLUME)),
    )
    tables = [medians(grid, runs.PEAK, "Largest force (N): median and its interval of 97.9 %")]
    data = {name: grid.median(name).tolist() for name in grid.values}
    return Item(
        "clearance-and-speed", "Peak force, impact energy and wear", text, (), [chart], tables,
        slider_crank_statements(grid), data,
    )  # fmt: skip


def slider_crank_statements(grid: Grid) -> list[Verdict]:
    """Statements on growth with clearance and with speed, and on wear."""
    smooth = runs.pin_with(0.0, 0.9)
    ideal = f"; ideal forces by {(grid.speeds[-1] / grid.speeds[0]) ** 2:.0f}"
    mean_depth = grid.median(runs.VOLUME) / (2.0 * math.pi * BEARING_RADIUS * AXIAL_LENGTH)
    uneven = grid.median(runs.DEPTH) / mean_depth
    impacts = "the energy of impacts grows with the"
    return [
        growth("peaks grow with the clearance, friction 0.1", MEASURED_CHAIN, grid, runs.PEAK, "clearance"),
        growth("peaks grow with the clearance, no friction", MEASURED_CHAIN, smooth, runs.PEAK, "clearance"),
        growth("peaks grow with the speed", MEASURED_CHAIN, grid, runs.PEAK, "speed", ideal),
        growth(f"{impacts} clearance", MEASURED_CHAIN, grid, runs.IMPACT, "clearance"),
        growth(f"{impacts} speed", MEASURED_CHAIN, grid, runs.IMPACT, "speed", ideal),
        growth("wear grows with the speed", FOUR_BAR_WEAR, grid, runs.VOLUME, "speed", ideal),
        growth("wear grows with the clearance", "an assumption", grid, runs.VOLUME, "clearance"),
        Verdict(
            f"wear is not uniform: its depth exceeds {UNEVEN:g} times the mean around the joint ({FLORES})",
            bool((uneven > UNEVEN).all()), f"{uneven.min():.3g} to {uneven.max():.3g} times the mean",
        ),
        reversal(grid, runs.PEAK),
    ]  # fmt: skip


def chain() -> Item:
    """Which joint of the four-bar matters most."""
    single, all_loose = {joint: runs.loose(joint) for joint in runs.JOINTS}, runs.loose(runs.JOINTS)
    ideal = IDEAL_ACCELERATION * np.square(all_loose.speeds)
    effects = {joint: grid.median(runs.ACCELERATION) / ideal - 1.0 for joint, grid in single.items()}
    work = {joint: grid.median(f"{joint}.friction_energy.total") for joint, grid in single.items()}
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
            growth(f"{joint}: {impacts}", MEASURED_CHAIN, grid, runs.ACCELERATION, "clearance")
            for joint, grid in single.items()
        ),
        *(further_joints(joint, grid, all_loose) for joint, grid in single.items()),
        Verdict(
            f"joints of one mechanism wear very differently ({FOUR_BAR_WEAR})", bool((ratios > 2.0).all()),
            f"work of friction in D over that in C: {ratios.min():.3g} to {ratios.max():.3g}",
        ),
    ]  # fmt: skip
    named = [*single.items(), ("B, C and D", all_loose)]
    panels = [
        over_clearance(grid, runs.ACCELERATION, f"clearance in {name}", "acceleration (rad/s²)")
        for name, grid in named
    ]
    caption = "Four-bar: largest acceleration of the follower, median and 10 to 90 % of ten start angles"
    text = (
        "Four-bar of the source paper with uniform rods: B joins crank and coupler, C coupler and follower, D"
        " follower and ground; each is loose alone, then all are. The dimensions of the measured mechanism of"
        " 2021, which has three loose joints, were not available; here the pivot of the follower is the"
        " end of"
        " the chain.",
        step_error(single["B"], (runs.ACCELERATION,)),
    )
    tables = [
        medians(grid, runs.ACCELERATION, f"Clearance in {name}: acceleration (rad/s²)")
        for name, grid in named
    ]
    data = {joint: values.tolist() for joint, values in effects.items()}
    chart = Chart("chain", caption, panels, 2)
    return Item("chain", "Which joint of a chain matters most", text, (), [chart], tables, verdicts, data)


def contact_loss() -> Item:
    """Where contact is lost."""
    losses = runs.losses()
    count, predicted = sum(len(loss.flight.losses) for loss in losses), sum(loss.predicted for loss in losses)
    two_regions = sum(loss.flight.regions == 2 for loss in losses)
    no_region = sum(loss.flight.regions == 0 for loss in losses)
    finding = (
        "contact is lost where the ideal force is small and its direction turns fast: most losses lie in"
        " the quarter of the"
        " turn in which the rate of its direction over its size is largest"
    )
    verdicts = [
        Verdict(
            f"{finding} ({EARLES})", predicted > count / 2 if count else None,
            f"{predicted} of {count} losses; 25 % by chance",
        ),
        Verdict(
            f"free flight, impact and contact follow each other twice a turn ({MEASURED_CHAIN})",
            two_regions == len(losses),
            f"in {two_regions} of {len(losses)} runs; {no_region} runs never lose contact",
        ),
    ]  # fmt: skip
    rows = [
        (loss.name, f"{100.0 * loss.flight.share:.2f} %", str(loss.flight.regions),
         f"{loss.flight.losses_per_turn:g}", f"{loss.predicted} of {len(loss.flight.losses)}",
         f"{loss.largest_rate:.3g}")
        for loss in losses
    ]  # fmt: skip
    heads = ("joint", "free flight", "regions", "losses a turn", "predicted", "largest rate (rad/(s N))")
    text = (
        "Eight turns from one start, of which the last four count, at 720 outputs a turn. A loss follows at"
        " least 10° of contact, so that bounces do not count; regions of free flight are 20° apart.",
    )
    table = Table(heads, rows, title="Free flight after four turns")
    data = {"losses": count, "predicted": predicted, "twice": two_regions, "never": no_region}
    return Item("contact-loss", "Where contact is lost", text, (), (), [table], verdicts, data)


def scatter() -> Item:
    """Which motions depend on their start."""
    widths = {name: runs.pin_with(*surface).scatter(runs.PEAK) for name, surface in runs.SURFACES.items()}
    wide = {name: width > SCATTERED for name, width in widths.items()}
    counts = {name: int(flags.sum()) for name, flags in wide.items()}
    numbers = "; ".join(f"{name}: {count} of {wide[name].size}" for name, count in counts.items())
    slow, fast = (sum(int(flags[:, k].sum()) for flags in wide.values()) for k in (0, -1))
    dry, dry_soft, smooth, smooth_soft = counts.values()
    size = sum(flags.size for flags in wide.values()) // 2
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
# Processor time (s) of each item, on a common machine.
SECONDS = {"clearance-and-speed": 12.0, "chain": 13.0, "contact-loss": 9.0, "scatter": 9.0}
