"""Signs of joints and their names, as the nouns say how they are drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.joints import Joint
from ..model.strokes import JointSeen, Label
from .sheet import Sheet
from .strokes import draw

Array = NDArray[np.float64]


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
        nodes = np.stack([sheet.factor * sheet.result.record.block(f"particle_{axis}")[0, list(where.particles)] for axis in "xy"], axis=1)
        gap = np.linalg.norm(nodes - at, axis=1)
        other = nodes[np.argsort(gap)[min(1, len(nodes) - 1)]]
    else:
        column = list(sheet.result.record.assembly.bodies).index(body)
        other = sheet.factor * np.array([sheet.result.channels[f"body_{axis}"].values[0, column] for axis in "xy"])
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
    """Names of the joints beside their signs, away from the ``middle``, by so many points ``farther``: in a film they keep their side."""
    look: dict[str, Any] = {"ha": "center", "va": "center", "weight": "bold", "zorder": 9, "fontsize": 9}
    look["bbox"] = {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.75}
    for label, names in named_places(sheet):
        at, text = label.at, ", ".join(names)
        if label.fixed:
            sheet.ax.text(at[0], at[1], text, **look)
            continue
        away = (at - middle) / (np.linalg.norm(at - middle) or 1.0)
        reach = np.array([12.0 + 2.6 * len(text), 17.0]) + farther
        sheet.ax.annotate(text, (at[0], at[1]), xytext=tuple(reach * away), textcoords="offset points", **look)
