"""Signs of springs, stops, bushings, gears and loads."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.joints import Gear, IdealRevolute
from ..model.springs import Bushing, Spring, Stop, TorsionalSpring
from .sheet import Sheet
from .style import GREEN, GREY, INK, VERMILION

Array = NDArray[np.float64]
COILS = 7


def spring_signs(sheet: Sheet) -> None:
    """Every spring: zigzags, spirals, the two cheeks of a stop, rings of rubber."""
    for spring in sheet.mechanism.springs.values():
        if isinstance(spring, Spring):
            points = zigzag(sheet.at(spring.first), sheet.at(spring.second), 0.018 * sheet.size)
            sheet.signs["spring"] = sheet.line(points, color=GREEN, lw=1.5, zorder=6)
        elif isinstance(spring, Bushing):
            at = sheet.at(spring.first)
            sheet.circle(at, 0.022 * sheet.size, color=GREEN, lw=3.5, alpha=0.6)
            sheet.signs["bushing"] = sheet.circle(at, 0.012 * sheet.size, color=GREEN, lw=1.2)
        elif isinstance(spring, Stop):
            _stop(sheet, spring)
        else:
            _spiral(sheet, spring)


def zigzag(first: Array, second: Array, width: float) -> Array:
    """Corners of a spring drawn between two points, straight for an eighth at each end, shape (corners, 2)."""
    along = second - first
    across = np.array([-along[1], along[0]]) / (np.linalg.norm(along) or 1.0) * width
    shares = np.concatenate([[0.0, 0.125], np.linspace(0.125, 0.875, 2 * COILS + 1)[1:-1], [0.875, 1.0]])
    sides = np.zeros(len(shares))
    sides[2:-2] = np.where(np.arange(len(shares) - 4) % 2 == 0, 1.0, -1.0)
    return np.asarray(first + shares[:, None] * along + sides[:, None] * across, dtype=float)


def axis_of(sheet: Sheet, first: str, second: str) -> Array:
    """Where two bodies turn against each other: their common pin, else the pivot of the second, else its centre of mass."""
    pins = [joint for joint in sheet.mechanism.joints.values() if isinstance(joint, IdealRevolute)]
    for wanted in ({first, second}, {"ground", second}):
        for joint in pins:
            if {joint.sides[0][0], joint.sides[1][0]} == wanted:
                return sheet.at(joint.bearing)
    for other in sheet.mechanism.joints.values():
        for (body, _), end in zip(other.sides, (other.bearing, other.journal), strict=True):
            if body == second:
                return sheet.at(end)
    column = list(sheet.result.record.assembly.bodies).index(second)
    return sheet.factor * np.array([sheet.result.channels[f"body_{axis}"].values[sheet.shown, column] for axis in "xy"])


def _spiral(sheet: Sheet, spring: TorsionalSpring) -> None:
    turn = np.linspace(0.0, 4.5 * np.pi, 200)
    radius = sheet.size * (0.012 + 0.022 * turn / turn[-1])
    points = axis_of(sheet, spring.first, spring.second) + radius[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    sheet.signs["torsional spring"] = sheet.line(points, color=GREEN, lw=1.3, zorder=6)


def _stop(sheet: Sheet, stop: Stop) -> None:
    """Cheeks at the two angles of the second body seen from the first; the sector between them is free."""
    at = axis_of(sheet, stop.first, stop.second)
    base = 0.0 if stop.first == "ground" else float(sheet.angles(stop.first)[sheet.shown])
    radius = 0.06 * sheet.size
    for angle in (stop.low, stop.high):
        out = np.array([np.cos(base + angle), np.sin(base + angle)])
        sheet.line([at + 0.4 * radius * out, at + 1.25 * radius * out], lw=2.6, zorder=6)
    turn = base + np.linspace(stop.low, stop.high, 60)
    arc = at + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    sheet.signs["stop"] = sheet.line(arc, lw=1.0, ls=(0, (2, 2)), zorder=6)


def gear_signs(sheet: Sheet) -> None:
    """Pitch circles of external gears; wheels with a belt where both turn the same way."""
    for gear in sheet.mechanism.gears.values():
        first, second = wheels(sheet, gear)
        for (centre, radius), body in ((first, gear.first), (second, gear.second)):
            sheet.circle(centre, radius, color=sheet.colour(body), lw=1.6, ls="-." if gear.ratio < 0.0 else "-", zorder=4)
        sign = sheet.ax.plot([], [], color=INK, lw=1.4, ls="-." if gear.ratio < 0.0 else "-")[0]
        sheet.signs["gears, pitch circles" if gear.ratio < 0.0 else "wheels with a belt"] = sign
        if gear.ratio > 0.0:
            for side in (1.0, -1.0):
                sheet.line(tangent(first, second, side), color=GREY, lw=1.4, zorder=4)


def wheels(sheet: Sheet, gear: Gear) -> tuple[tuple[Array, float], tuple[Array, float]]:
    """Centre and radius of both wheels: r_1 = |ratio| r_2, touching where the gears are external."""
    one, two = axis_of(sheet, "ground", gear.first), axis_of(sheet, gear.first, gear.second)
    if np.allclose(one, two):
        two = axis_of(sheet, "ground", gear.second)
    distance, ratio = float(np.linalg.norm(two - one)) or 0.2 * sheet.size, abs(gear.ratio)
    second = distance / (1.0 + ratio) if gear.ratio < 0.0 else 0.3 * distance / max(1.0, ratio)
    return (one, ratio * second), (two, second)


def tangent(first: tuple[Array, float], second: tuple[Array, float], side: float) -> Array:
    """Ends of the outer tangent of two circles on one side, shape (2, 2)."""
    (p, r), (q, s) = first, second
    along = (q - p) / (np.linalg.norm(q - p) or 1.0)
    across = side * np.array([-along[1], along[0]])
    sine = (r - s) / (np.linalg.norm(q - p) or 1.0)
    n = sine * along + np.sqrt(max(0.0, 1.0 - sine**2)) * across
    return np.array([p + r * n, q + s * n])


def tails(sheet: Sheet, length: float) -> list[tuple[Array, Array]]:
    """Tip and tail of the arrow of each force and driven point."""
    arrows = [(load.at, load.force) for load in sheet.mechanism.loads.values() if any(load.force)]
    arrows += [(driver.point, driver.direction) for driver in sheet.mechanism.drivers.values() if driver.point]
    return [(sheet.at(end), sheet.at(end) - length * np.array(force) / np.hypot(*force)) for end, force in arrows]


def load_signs(sheet: Sheet) -> None:
    """Arrows for forces and driven points, arcs for moments."""
    look: dict[str, Any] = {"arrowstyle": "-|>", "color": VERMILION, "lw": 2.0, "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 14.0}
    for tip, tail in tails(sheet, 0.13 * sheet.size):
        sheet.ax.annotate("", tuple(tip), xytext=tuple(tail), arrowprops=look | {"shrinkB": 5.0}, zorder=8)
    moments = [load for load in sheet.mechanism.loads.values() if load.moment]
    for load in moments:
        turn = np.linspace(-2.4, 1.2, 60) * np.sign(load.moment)
        arc = sheet.at(load.at) + 0.045 * sheet.size * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        sheet.line(arc, color=VERMILION, lw=2.0, zorder=8)
        sheet.ax.annotate("", tuple(arc[-1]), xytext=tuple(arc[-4]), arrowprops=look, zorder=8)
    if sheet.mechanism.loads or any(driver.point for driver in sheet.mechanism.drivers.values()):
        sheet.signs["load"] = sheet.ax.plot([], [], color=VERMILION, lw=2.0)[0]
