"""Signs of springs, stops, bushings, gears and loads."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.joints import Gear
from ..model.loads.load import Push
from ..model.outlines import axis_between, wheels_at
from ..model.springs import AnySpring
from ..model.strokes import PairSeen
from .sheet import Sheet
from .strokes import draw
from .style import LOADS

Array = NDArray[np.float64]


def spring_signs(sheet: Sheet) -> None:
    """Every spring, as it says that it is drawn."""
    for spring in sheet.mechanism.springs.values():
        draw(sheet, spring.strokes(spring_seen(sheet, spring)))


def spring_seen(sheet: Sheet, spring: AnySpring) -> PairSeen:
    """A spring as the sheet shows it: its pins, or twice the place where its bodies turn against each other."""
    if spring.between_pins:
        return PairSeen(sheet.at(spring.first), sheet.at(spring.second), 0.0, sheet.size)
    at = axis_of(sheet, spring.first, spring.second)
    return PairSeen(at, at, float(sheet.angles(spring.first)[sheet.shown]), sheet.size)


def gear_signs(sheet: Sheet) -> None:
    """Every gear and belt."""
    for gear in sheet.mechanism.gears.values():
        draw(sheet, gear.strokes(gear_seen(sheet, gear)), (gear.first, gear.second))


def gear_seen(sheet: Sheet, gear: Gear) -> PairSeen:
    """A gear as the sheet shows it: where its wheels turn."""
    one, two = wheels_at(sheet.mechanism, gear, lambda first, second: axis_of(sheet, first, second), lambda a, b: bool(np.allclose(a, b)))
    return PairSeen(one, two, 0.0, sheet.size)


def axis_of(sheet: Sheet, first: str, second: str) -> Array:
    """Where two bodies turn against each other: at a pin, else at the centre of mass of the second."""
    end = axis_between(sheet.mechanism, first, second)
    if end is not None:
        return sheet.at(end)
    column = list(sheet.result.record.assembly.bodies).index(second)
    return sheet.factor * np.array([sheet.result.channels[f"body_{axis}"].values[sheet.shown, column] for axis in "xy"])


def tails(sheet: Sheet, length: float) -> list[tuple[Array, Array]]:
    """Tip and tail of the arrow of each force and driven point."""
    arrows = [(f"{push.body}.{push.pin}", push.acts[:2]) for push in pushes(sheet) if any(push.acts[:2])]
    arrows += [(driver.point, driver.direction) for driver in sheet.mechanism.drivers.values() if driver.point]
    return [(sheet.at(end), sheet.at(end) - length * np.array(force) / np.hypot(*force)) for end, force in arrows]


def pushes(sheet: Sheet) -> list[Push]:
    """What loads do to bodies that can move."""
    loads = sheet.mechanism.loads.values()
    return [push for load in loads for push in load.pushes(sheet.mechanism.joints) if push.body != "ground"]


def load_signs(sheet: Sheet) -> None:
    """Arrows for forces and driven points, arcs for moments."""
    look: dict[str, Any] = {"arrowstyle": "-|>", "color": LOADS, "lw": 2.0, "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 14.0}
    for tip, tail in tails(sheet, 0.13 * sheet.size):
        sheet.ax.annotate("", tuple(tip), xytext=tuple(tail), arrowprops=look | {"shrinkB": 5.0}, zorder=8)
    moments = [push for push in pushes(sheet) if push.acts[2]]
    for push in moments:
        turn = np.linspace(-2.4, 1.2, 60) * np.sign(push.acts[2])
        arc = sheet.at(f"{push.body}.{push.pin}") + 0.045 * sheet.size * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        sheet.line(arc, color=LOADS, lw=2.0, zorder=8)
        sheet.ax.annotate("", tuple(arc[-1]), xytext=tuple(arc[-4]), arrowprops=look, zorder=8)
    if sheet.mechanism.loads or any(driver.point for driver in sheet.mechanism.drivers.values()):
        sheet.signs["load"] = sheet.ax.plot([], [], color=LOADS, lw=2.0)[0]
