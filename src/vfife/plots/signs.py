"""What is drawn of a mechanism: bodies as outlines, signs of joints, springs, gears and loads, as the nouns
say how they are drawn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..measures.motion import pin_path
from ..model.drawing.strokes import JointSeen, Label, PairSeen
from ..model.joints import Gear, Joint
from ..model.loads.load import Push
from ..model.outlines import CENTER, FEW, axis_between, corners, drawn_pins, wheels_at
from ..model.springs import AnySpring
from .sheet import Sheet, draw
from .style import LOADS

if TYPE_CHECKING:
    from ..results.view import View

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outline:
    """``path`` (m), shape (outputs, corners, 2), with NaN between pieces that do not hang together; ``plate``
    if it encloses an area.
    """

    path: Array
    plate: bool = False
    dots: bool = False


def outline(result: View, name: str) -> Outline:
    """Nodes of an elastic link, members of a frame, or the pins of a rigid body that lie on its hull."""
    record = result.record
    body = record.assembly.bodies[name]
    if body.model == "frame":
        return Outline(_members(result, list(body.elements)))
    if body.elements:
        return Outline(_particles(result, list(body.particles)), dots=len(body.particles) <= FEW)
    pins = drawn_pins(record.assembly.mechanism, name)
    order, plate = corners(np.array([body.pins[pin] for pin in pins], dtype=float))
    pins = [pins[k] for k in order]
    return Outline(np.stack([pin_path(record, name, pin) for pin in pins or [CENTER]], axis=1), plate)


def _particles(result: View, nodes: list[int]) -> Array:
    return np.stack([result.record.block(f"particle_{axis}")[:, nodes] for axis in "xy"], axis=2)


def _members(result: View, elements: list[int]) -> Array:
    pairs = np.array([result.record.assembly.topology.frame_nodes[e][:2] for e in elements])
    ends = [_particles(result, list(pairs[:, k])) for k in (0, 1)]
    gaps = np.full_like(ends[0], np.nan)
    return np.asarray(np.stack([*ends, gaps], axis=2).reshape(len(gaps), -1, 2), dtype=float)


def joint_signs(sheet: Sheet) -> None:
    """Every joint, and the ground's points that carry one."""
    for joint in sheet.mechanism.joints.values():
        draw(sheet, joint.strokes(seen(sheet, joint)), (joint.sides[0][0], joint.sides[1][0]))


def seen(sheet: Sheet, joint: Joint) -> JointSeen:
    """A joint as the sheet shows it."""
    bodies = (joint.sides[0][0], joint.sides[1][0])
    angles = [sheet.angles(body) for body in bodies]

    def way(tilt: float) -> tuple[float, float]:
        away = sheet.path(*joint.sides[1]) - sheet.path(*joint.sides[0])
        turned = angles[0] + tilt
        gone = np.cos(turned) * away[:, 0] + np.sin(turned) * away[:, 1]
        return float(gone.min()), float(gone.max())

    now, start = ((float(angles[0][k]), float(angles[1][k])) for k in (sheet.shown, 0))
    ground = (bodies[0] == "ground", bodies[1] == "ground")
    at = sheet.at(joint.bearing)
    return JointSeen(
        at, sheet.at(joint.journal), now, start, ground, sheet.factor, sheet.size, way, lambda: _leaving(sheet, joint, at)
    )  # fmt: skip


def _leaving(sheet: Sheet, joint: Joint, at: Array) -> Array:
    """Unit vector, one of the four along the axes, in which a body that the ground holds leaves it."""
    body = next(owner for owner, _ in joint.sides if owner != "ground")
    where = sheet.result.record.assembly.bodies[body]
    if where.elements:
        nodes = np.stack(
            [
                sheet.factor * sheet.result.record.block(f"particle_{axis}")[0, list(where.particles)]
                for axis in "xy"
            ],
            axis=1,
        )
        gap = np.linalg.norm(nodes - at, axis=1)
        other = nodes[np.argsort(gap)[min(1, len(nodes) - 1)]]
    else:
        column = list(sheet.result.record.assembly.bodies).index(body)
        other = sheet.factor * np.array(
            [sheet.result.channels[f"body_{axis}"].values[0, column] for axis in "xy"]
        )
    dx, dy = other - at
    return np.array([np.sign(dx) or 1.0, 0.0]) if abs(dx) >= abs(dy) else np.array([0.0, np.sign(dy)])


def named_places(sheet: Sheet) -> list[tuple[Label, list[str]]]:
    """Where names of joints stand, those in one place together."""
    places: list[tuple[Label, list[str]]] = []
    for name, joint in sheet.mechanism.joints.items():
        label = joint.label(seen(sheet, joint))
        for place, names in places:
            if np.linalg.norm(place.at - label.at) < 0.02 * sheet.size and place.fixed == label.fixed:
                names.append(name)
                break
        else:
            places.append((label, [name]))
    return places


def joint_names(sheet: Sheet, middle: Array, farther: float = 0.0) -> None:
    """Names of the joints beside their signs, away from the ``middle``, by so many points ``farther``: in a
    film they keep their side.
    """
    look: dict[str, Any] = {"ha": "center", "va": "center", "weight": "bold", "zorder": 9, "fontsize": 9}
    look["bbox"] = {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.75}
    for label, names in named_places(sheet):
        at, text = label.at, ", ".join(names)
        if label.fixed:
            sheet.ax.text(at[0], at[1], text, **look)
            continue
        away = (at - middle) / (np.linalg.norm(at - middle) or 1.0)
        reach = np.array([12.0 + 2.6 * len(text), 17.0]) + farther
        sheet.ax.annotate(
            text, (at[0], at[1]), xytext=tuple(reach * away), textcoords="offset points", **look
        )


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
    one, two = wheels_at(
        sheet.mechanism,
        gear,
        lambda first, second: axis_of(sheet, first, second),
        lambda a, b: bool(np.allclose(a, b)),
    )
    return PairSeen(one, two, 0.0, sheet.size)


def axis_of(sheet: Sheet, first: str, second: str) -> Array:
    """Where two bodies turn against each other: at a pin, else at the centre of mass of the second."""
    end = axis_between(sheet.mechanism, first, second)
    if end is not None:
        return sheet.at(end)
    column = list(sheet.result.record.assembly.bodies).index(second)
    return sheet.factor * np.array(
        [sheet.result.channels[f"body_{axis}"].values[sheet.shown, column] for axis in "xy"]
    )


def tails(sheet: Sheet, length: float) -> list[tuple[Array, Array]]:
    """Tip and tail of the arrow of each force and driven point."""
    arrows = [(f"{push.body}.{push.pin}", push.acts[:2]) for push in pushes(sheet) if any(push.acts[:2])]
    arrows += [
        (driver.point, driver.direction) for driver in sheet.mechanism.drivers.values() if driver.point
    ]
    return [
        (sheet.at(end), sheet.at(end) - length * np.array(force) / np.hypot(*force)) for end, force in arrows
    ]


def pushes(sheet: Sheet) -> list[Push]:
    """What loads do to bodies that can move."""
    loads = sheet.mechanism.loads.values()
    return [push for load in loads for push in load.pushes(sheet.mechanism.joints) if push.body != "ground"]


def load_signs(sheet: Sheet) -> None:
    """Arrows for forces and driven points, arcs for moments."""
    look: dict[str, Any] = {
        "arrowstyle": "-|>",
        "color": LOADS,
        "lw": 2.0,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
        "mutation_scale": 14.0,
    }
    for tip, tail in tails(sheet, 0.13 * sheet.size):
        sheet.ax.annotate("", tuple(tip), xytext=tuple(tail), arrowprops=look | {"shrinkB": 5.0}, zorder=8)
    moments = [push for push in pushes(sheet) if push.acts[2]]
    for push in moments:
        turn = np.linspace(-2.4, 1.2, 60) * np.sign(push.acts[2])
        arc = sheet.at(f"{push.body}.{push.pin}") + 0.045 * sheet.size * np.stack(
            [np.cos(turn), np.sin(turn)], axis=1
        )
        sheet.line(arc, color=LOADS, lw=2.0, zorder=8)
        sheet.ax.annotate("", tuple(arc[-1]), xytext=tuple(arc[-4]), arrowprops=look, zorder=8)
    if sheet.mechanism.loads or any(driver.point for driver in sheet.mechanism.drivers.values()):
        sheet.signs["load"] = sheet.ax.plot([], [], color=LOADS, lw=2.0)[0]
