"""Signs of joints: rings, welds, guides with their blocks, surfaces that touch, and the ground under them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.joints import ClearanceRevolute, ClearanceSlider, ExternalContact, Joint, Slider, Weld
from .sheet import Sheet
from .style import INK

Array = NDArray[np.float64]
LARGE_BEARING = 0.03  # bearing radius, as a share of the drawing, from which its circle is drawn
GROUND_DEPTH = 0.065  # of the sign for the ground, as a share of the drawing
BLOCK = (0.06, 0.036)  # length and height of an ideal slider's block, as shares of the drawing


def joint_signs(sheet: Sheet) -> None:
    """Every joint, and the ground's points that carry one."""
    for joint in sheet.mechanism.joints.values():
        if isinstance(joint, Slider | ClearanceSlider):
            _guide(sheet, joint)
        elif isinstance(joint, ExternalContact):
            _surfaces_outside(sheet, joint)
        elif isinstance(joint, Weld):
            _weld(sheet, joint)
        else:
            _pin(sheet, joint)


def _pin(sheet: Sheet, joint: Joint) -> None:
    """A ring, with a dot where there is clearance; the two circles where they are large enough to be seen."""
    _ground(sheet, joint)
    at, loose = sheet.at(joint.bearing), isinstance(joint, ClearanceRevolute)
    if isinstance(joint, ClearanceRevolute) and joint.bearing_radius * sheet.factor > LARGE_BEARING * sheet.size:
        radii = (joint.bearing_radius, joint.bearing_radius - joint.clearance)
        for end, radius, width in zip((joint.bearing, joint.journal), radii, (1.8, 0.9), strict=True):
            sheet.circle(sheet.at(end), sheet.factor * radius, lw=width, zorder=4)
        sheet.signs["bearing and journal"] = sheet.ax.plot([], [], ls="", marker="o", ms=9, mfc="none", mec=INK, mew=1.4)[0]
        return
    ring = sheet.ax.plot(*at, ls="", marker="o", ms=8, mfc="white", mec=INK, mew=1.4, zorder=7)
    dot = sheet.ax.plot(*at, ls="", marker="o", ms=3.5, mfc=INK, mec=INK, zorder=8) if loose else []
    sheet.signs["joint with clearance" if loose else "ideal joint"] = (*ring, *dot)


def _weld(sheet: Sheet, joint: Weld) -> None:
    """A filled square; with the ground, a clamp in a wall."""
    at = sheet.at(joint.bearing)
    if "ground" in (joint.sides[0][0], joint.sides[1][0]):
        half, deep = 0.045 * sheet.size, 0.03 * sheet.size
        away = _clamped_along(sheet, joint, at)
        across = np.array([-away[1], away[0]])
        sheet.hatched(at - half * across, at + half * across, -away, deep)
    sheet.signs["weld"] = sheet.ax.plot(*at, ls="", marker="s", ms=6, mfc=INK, mec=INK, zorder=7)[0]


def _clamped_along(sheet: Sheet, joint: Weld, at: Array) -> Array:
    """Unit vector, one of the four along the axes, in which the clamped body leaves the wall."""
    body = next(owner for owner, _ in joint.sides if owner != "ground")
    where = sheet.result.record.assembly.bodies[body]
    if where.elements:
        nodes = np.stack([sheet.factor * sheet.result.record.block(f"particle_{axis}")[0, list(where.particles)] for axis in "xy"], axis=1)
        gap = np.linalg.norm(nodes - at, axis=1)
        other = nodes[np.argsort(gap)[min(1, len(nodes) - 1)]]
    else:
        column = list(sheet.result.record.assembly.bodies).index(body)
        other = sheet.factor * np.array([sheet.result.channels[f"body_{axis}"].values[0, column] for axis in "xy"])
    dx, dy = other - at
    return np.array([np.sign(dx) or 1.0, 0.0]) if abs(dx) >= abs(dy) else np.array([0.0, np.sign(dy)])


def _guide(sheet: Sheet, joint: Slider | ClearanceSlider) -> None:
    """Two rails as far as the journal goes, and the block between them; hatched outside where the guide is the ground's."""
    owner, slider = joint.sides[0][0], joint.sides[1][0]
    along, reach = _travel(sheet, joint)
    across = np.array([-along[1], along[0]])
    base, at = sheet.at(joint.bearing), sheet.at(joint.journal)
    slot = isinstance(joint, Slider) and joint.turning
    length, height = (share * sheet.size * (0.6 if slot else 1.0) for share in BLOCK)
    gap = 0.5 * height
    if isinstance(joint, ClearanceSlider):
        length, height = sheet.factor * joint.length, sheet.factor * joint.height
        gap = 0.5 * height + sheet.factor * joint.clearance
    ends = [base + (reach[0] - 0.8 * length) * along, base + (reach[1] + 0.8 * length) * along]
    for side in (1.0, -1.0):
        rail = [end + side * gap * across for end in ends]
        if owner == "ground":
            sheet.hatched(rail[0], rail[1], side * across, 0.02 * sheet.size)
        else:
            sheet.line(rail, color=sheet.colour(owner), lw=1.6, zorder=3.5)
    colour = sheet.colour(slider)
    if slot:
        sheet.signs["pin in a slot"] = sheet.ax.plot(*at, ls="", marker="o", ms=6.5, mfc="white", mec=colour, mew=2.0, zorder=7)[0]
        return
    angle = sheet.angles(slider)[sheet.shown] - sheet.angles(slider)[0] + _start_angle(sheet, joint)
    facing = np.array([np.cos(angle), np.sin(angle)]) if isinstance(joint, ClearanceSlider) else along
    sheet.box(at, facing, length, height, facecolor="white", edgecolor="none", zorder=3.2)
    sheet.box(at, facing, length, height, facecolor=colour, alpha=0.35, edgecolor="none", zorder=3.3)
    block = sheet.box(at, facing, length, height, facecolor="none", edgecolor=colour, lw=1.8, zorder=5)
    sheet.signs["block with play" if isinstance(joint, ClearanceSlider) else "ideal slider"] = block


def _start_angle(sheet: Sheet, joint: Slider | ClearanceSlider) -> float:
    return float(sheet.angles(joint.sides[0][0])[0] + np.arctan2(joint.direction[1], joint.direction[0]))


def _travel(sheet: Sheet, joint: Slider | ClearanceSlider | ExternalContact) -> tuple[Array, Array]:
    """Direction of a guide as it is drawn, and the least and largest way of the journal along it over the run."""
    tilt = float(np.arctan2(joint.direction[1], joint.direction[0]))
    turned = sheet.angles(joint.sides[0][0]) + tilt
    away = sheet.path(*joint.sides[1]) - sheet.path(*joint.sides[0])
    way = np.cos(turned) * away[:, 0] + np.sin(turned) * away[:, 1]
    angle = turned[sheet.shown]
    return np.array([np.cos(angle), np.sin(angle)]), np.array([way.min(), way.max()])


def _beside(sheet: Sheet, joint: Slider | ClearanceSlider) -> Array:
    """Where the name of a guide stands: over its upper rail, or to the right of it."""
    along, _ = _travel(sheet, joint)
    across = np.array([-along[1], along[0]])
    across *= 1.0 if across[1] > 0.3 or (abs(across[1]) <= 0.3 and across[0] > 0.0) else -1.0
    gap = sheet.factor * (0.5 * joint.height + joint.clearance) if isinstance(joint, ClearanceSlider) else 0.5 * BLOCK[1] * sheet.size
    return np.asarray(sheet.at(joint.journal) + (gap + (0.05 + 0.03 * abs(across[0])) * sheet.size) * across, dtype=float)


def _surfaces_outside(sheet: Sheet, joint: ExternalContact) -> None:
    """A round on a line, hatched if it is the ground's, or beside another round."""
    sheet.signs["contact"] = sheet.circle(
        sheet.at(joint.journal), sheet.factor * joint.journal_radius, color=sheet.colour(joint.sides[1][0]), lw=1.6
    )
    base, owner = sheet.at(joint.bearing), joint.sides[0][0]
    if joint.bearing_radius is not None:
        sheet.circle(base, sheet.factor * joint.bearing_radius, color=sheet.colour(owner), lw=1.6)
        return
    along, reach = _travel(sheet, joint)
    beyond = max(0.05 * sheet.size, 1.5 * sheet.factor * joint.journal_radius)
    ends = [base + (reach[0] - beyond) * along, base + (reach[1] + beyond) * along]
    if owner == "ground":
        sheet.hatched(ends[0], ends[1], np.array([along[1], -along[0]]), 0.03 * sheet.size)
    else:
        sheet.line(ends, color=sheet.colour(owner), lw=3.0, zorder=3.5)


def _ground(sheet: Sheet, joint: Joint) -> None:
    """A triangle on a hatched strip where a pin is the ground's."""
    if "ground" not in (joint.sides[0][0], joint.sides[1][0]):
        return
    x, y = sheet.at(joint.bearing if joint.sides[0][0] == "ground" else joint.journal)
    half, tall, deep = (part * sheet.size for part in (0.028, 0.045, GROUND_DEPTH))
    sheet.ax.fill([x, x - half, x + half], [y, y - tall, y - tall], facecolor="white", edgecolor=INK, lw=1.2, zorder=2)
    sheet.hatched(np.array([x - 1.6 * half, y - tall]), np.array([x + 1.6 * half, y - tall]), np.array([0.0, -1.0]), deep - tall)


def joint_names(sheet: Sheet, middle: Array) -> None:
    """Names of the joints beside their signs, those in one place together."""
    places: list[tuple[Array, list[str], bool]] = []
    for name, joint in sheet.mechanism.joints.items():
        sliding = isinstance(joint, Slider | ClearanceSlider)
        grounded = joint.sides[0][0] == "ground" and not sliding and not isinstance(joint, ExternalContact | Weld)
        at = _beside(sheet, joint) if isinstance(joint, Slider | ClearanceSlider) else sheet.at(joint.bearing if grounded else joint.journal)
        at = at - np.array([0.0, (GROUND_DEPTH + 0.03) * sheet.size * grounded])
        for place, names, fixed in places:
            if np.linalg.norm(place - at) < 0.02 * sheet.size and fixed == (grounded or sliding):
                names.append(name)
                break
        else:
            places.append((at, [name], grounded or sliding))
    look: dict[str, Any] = {"ha": "center", "va": "center", "weight": "bold", "zorder": 9, "fontsize": 9}
    look["bbox"] = {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.75}
    for at, names, fixed in places:
        text = ", ".join(names)
        if fixed:
            sheet.ax.text(at[0], at[1], text, **look)
            continue
        away = (at - middle) / (np.linalg.norm(at - middle) or 1.0)
        reach = np.array([12.0 + 2.6 * len(text), 17.0])
        sheet.ax.annotate(text, (at[0], at[1]), xytext=tuple(reach * away), textcoords="offset points", **look)
