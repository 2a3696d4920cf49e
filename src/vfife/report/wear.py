"""What joints with play lose and bear, and what the machine does as a whole: a table and lines for the summary."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from .digits import decimals, fixed, mark, measured, prefixed, spread_of

MANY = 10.0  # times the mean: a torque that swings by more is told by its swing
CONFORMAL = "* wider than 0.3 of the journal's radius: Hertz' theory is coarse there, and the line pressure too low."
HEADINGS = ("joint", "friction", "impacts", "sliding", "line pressure", "half-width", "p v, mean")


def wear_table(told: dict[str, Any]) -> Table:
    """Mean powers of the losses, fastest sliding, Hertz' line pressure, and the mean of pressure times speed, joint by joint."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for k, heading in enumerate(HEADINGS):
        table.add_column(heading, justify="right" if k else "left")
    for name in worn(told):
        powers = (measured(told, f"{name}.{kind}_power.mean", "W") for kind in ("friction", "impact"))
        cells = [
            shown(*_most(told, name, kind, unit)) + mark(told, *_names(told, name, kind)) + (" *" if wide and name in told["conformal"] else "")
            for kind, unit, shown, wide in COLUMNS
        ]
        table.add_row(Text(name), *powers, *cells)
    return table


def archard_table(told: dict[str, Any]) -> Table:
    """What bearing and journal lose: volume, and depth of the place that loses most."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for k, heading in enumerate(("joint", "bearing, volume", "deepest", "journal, volume", "deepest")):
        table.add_column(heading, justify="right" if k else "left")
    for name in worn_off(told):
        cells = []
        for side in ("bearing", "journal"):
            depth = told["measures"].get(f"{name}.{side}_wear_depth.max")
            cells += [f"{1e9 * told['measures'][f'{name}.{side}_wear.total']:.3g} mm³{mark(told, f'{name}.{side}_wear.total')}"]
            cells += ["" if depth is None else f"{1e9 * depth:.3g} nm{mark(told, f'{name}.{side}_wear_depth.max')}"]
        table.add_row(Text(name), *cells)
    return table


def worn_off(told: dict[str, Any]) -> list[str]:
    """Joints of which wear is kept."""
    ending = ".bearing_wear.total"
    return [name.removesuffix(ending) for name in told["measures"] if name.endswith(ending)]


def worn(told: dict[str, Any]) -> list[str]:
    """Joints of which losses are known."""
    ending = ".friction_power.mean"
    return [name.removesuffix(ending) for name in told["measures"] if name.endswith(ending)]


def _most(told: dict[str, Any], joint: str, kind: str, unit: str) -> tuple[float, str, float]:
    """The largest of a measure over the contacts of a joint, its unit and what is not known of it; a block in a guide has four contacts."""
    known = [(told["measures"][name], unit, spread_of(told, name)) for name in _names(told, joint, kind)]
    return max(known, default=(0.0, unit, 0.0))


def _names(told: dict[str, Any], joint: str, kind: str) -> list[str]:
    """A measure of the contacts of a joint."""
    return [name for name in (f"{joint}.{kind}", *(f"{joint}.{number}.{kind}" for number in range(1, 5))) if name in told["measures"]]


def machine_lines(told: dict[str, Any]) -> Iterable[tuple[str, str]]:
    """Heading and line: mean torque and power of the drivers, efficiency, what shakes the ground."""
    found = told["measures"]
    for name in told["model"]["bodies"]:
        if f"{name}.torque.mean" in found:
            mean, ripple = found[f"{name}.torque.mean"], found.get(f"{name}.torque.ripple", 0.0)
            width = prefixed(ripple * abs(mean), "N m", spread_of(told, f"{name}.torque.max"))
            swing = f", ripple {100.0 * ripple:,.4g} %{mark(told, f'{name}.torque.ripple')}" if ripple < MANY else f", swinging by {width}"
            torque, power = measured(told, f"{name}.torque.mean", "N m"), measured(told, f"{name}.power.mean", "W")
            yield "", f"{name}: mean torque {torque}{swing if ripple else ''}, mean power {power} ({told['part']})"
    if "mechanism.efficiency" in found:
        doubt = mark(told, "mechanism.efficiency")
        yield "", f"efficiency {100.0 * found['mechanism.efficiency']:.4g} %{doubt} (given off over given off and lost)"
    if found.get("ground.shaking_force.max"):
        force, moment = measured(told, "ground.shaking_force.max", "N"), measured(told, "ground.shaking_moment.max", "N m")
        yield "Ground", f"shaken by up to {force} and {moment} about its origin ({told['part']})"


def mega(value: float, unit: str, spread: float = 0.0) -> str:
    """A pressure with its prefix."""
    factor, prefix = (1e9, "G") if value >= 1e9 else (1e6, "M")
    shown = fixed(value / factor, decimals(value / factor, spread / factor)) if spread > 0.0 else f"{value / factor:.4g}"
    return f"{shown} {prefix}{unit}"


COLUMNS = (  # of the table of losses: measure, unit, how it is shown, whether its contact may be too wide
    ("sliding_velocity.max", "m/s", prefixed, False),
    ("contact_pressure.max", "Pa", mega, False),
    ("contact_half_width.max", "m", prefixed, True),
    ("pressure_velocity.mean", "Pa m/s", mega, False),
)
