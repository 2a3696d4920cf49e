"""The force of each joint as a vector that turns: where a bearing is loaded, and from where."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..analysis.forces import joint_force, joint_rows
from ..analysis.guides import turning
from .layout import Panels
from .orbits import SIDE, square
from .quantities import hardest, joint_forces
from .style import BLUE, GREY, INK, VERMILION, digits, scale_of
from .turn import said_shortly, span

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
MOST, COLUMNS = 9, 3


def bearing_force(result: View, name: str) -> Array:
    """Force of a joint on its journal (N), in the frame of its bearing's body, shape (outputs, 2)."""
    record = result.record
    force = joint_force(record)[:, list(joint_rows(record)).index(name)]
    joint = record.assembly.mechanism.joints.get(name)
    angle = np.zeros(len(force)) if joint is None else turning(record, joint.sides[0][0])[0]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * force[:, 0] + s * force[:, 1], c * force[:, 1] - s * force[:, 0]], axis=1)


def polar(result: View, reference: View | None = None) -> Figure:
    """Force on each journal as a point of a plane that turns with its bearing, one panel a joint; the circle is the peak that is reported."""
    names, over = list(hardest(result, joint_forces(result), MOST)), span(result)
    panels = Panels([(SIDE, SIDE)] * len(names), 2 if len(names) == 4 else COLUMNS, across=1.0, down=0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        own, ideal = bearing_force(result, name)[over.first : over.last + 1], _ideal(reference, name)
        told = result.measures.get(f"{name}.force.max")
        most = max(float(np.hypot(*own.T).max()), 0.0 if ideal is None else float(np.hypot(*ideal.T).max()), 0.0 if told is None else float(told))
        factor, unit = scale_of(most, "N")
        if told is not None:
            turn = np.linspace(0.0, 2.0 * np.pi, 361)
            ax.plot(factor * told * np.cos(turn), factor * told * np.sin(turn), color=GREY, lw=0.8, label="peak that is reported", zorder=2)
            ax.set_title(f"{digits(factor * told)} {unit}", loc="right", fontsize=9, fontweight="normal")
        if ideal is not None:
            ax.plot(*(factor * ideal).T, color=VERMILION, lw=1.3, ls=(0, (5, 1.6)), label="ideal joints", zorder=4)
        ax.plot(*(factor * own).T, color=BLUE, lw=0.8, label="at the outputs", zorder=3)
        ax.plot(0.0, 0.0, color=INK, ls="", marker="+", ms=8, mew=1.2, zorder=5)
        square(ax, 1.08 * factor * most)
        ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
    return panels.close(f"{result.name}: forces on journals, in the frames of their bearings{said_shortly(result, over)}")


def _ideal(reference: View | None, name: str) -> Array | None:
    if reference is None or name not in joint_rows(reference.record):
        return None
    return bearing_force(reference, name)[reference.last_turn]
