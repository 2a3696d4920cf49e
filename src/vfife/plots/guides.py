"""Blocks with play in their guides: how far they tilt and are off the middle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.forces import joint_rows
from ..analysis.guides import sliders, turning
from ..analysis.motion import pin_path
from .layout import Panels
from .style import BLUE, INK, ORANGE, SKY, length_unit
from .turn import said_shortly, span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
MOST, COLUMNS = 12, 3


def loose_guides(result: View) -> list[str]:
    """Blocks with play in a guide."""
    rows = joint_rows(result.record)
    return [name for name in sliders(result.record) if name in rows and len(rows[name][1]) > 1]


def tilt_and_offset(result: View, name: str) -> tuple[Array, Array]:
    """Tilt (rad) of a block from its guide, and offset (m) of its centre across the guide, to the left of its direction, shape (outputs,)."""
    record, joint = result.record, _block(result, name)
    base, own = (turning(record, side[0])[0] for side in joint.sides)
    away = pin_path(record, *joint.sides[1]) - pin_path(record, *joint.sides[0])
    along = base + np.arctan2(*joint.direction[::-1])
    return (own - own[0]) - (base - base[0]), np.cos(along) * away[:, 1] - np.sin(along) * away[:, 0]


def guides(result: View) -> Figure:
    """Tilt of each block over its offset across its guide; inside the diamond no corner touches a wall.

    The centres of corners' roundings are (L/2 - r) along the block from its middle: the corner farthest off has moved across the guide by
    the sizes of offset and (L/2 - r) tilt together, and touches where that is the clearance.
    """
    names, over = loose_guides(result)[:MOST], span(result)
    panels = Panels([(3.6, 3.0)] * len(names), COLUMNS, across=1.1, down=0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        _guide(ax, result, name, over.first)
        ax.set_title(f"joint {name}")
    return panels.close(f"{result.name}: blocks in their guides{said_shortly(result, over)}")


def _guide(ax: Axes, result: View, name: str, first: int) -> None:
    joint = _block(result, name)
    tilt, offset = tilt_and_offset(result, name)
    arm = 0.5 * joint.length - joint.corner_radius
    factor, unit = length_unit(joint.clearance)
    power, angle = (1e3, "mrad") if joint.clearance / arm < 0.5 else (1.0, "rad")
    c = factor * joint.clearance
    corners = np.array([(c, 0.0), (0.0, power * joint.clearance / arm), (-c, 0.0), (0.0, -power * joint.clearance / arm), (c, 0.0)])
    ax.plot(*corners.T, color=INK, lw=0.9, ls=(0, (5, 3)), label="a corner touches", zorder=5)
    x, y = factor * offset, power * tilt
    if first > 0:
        ax.plot(x[:first], y[:first], color=SKY, ls="", marker=".", ms=2.2, mew=0.0, label="before", zorder=2, rasterized=True)
    ax.plot(x[first:], y[first:], color=BLUE, lw=0.9, label="block", zorder=3)
    ax.plot(x[first], y[first], color=ORANGE, ls="", marker="s", ms=4, mec=INK, mew=0.5, label="where the part shown begins", zorder=6)
    reach = [1.12 * max(float(np.abs(one).max()), float(np.abs(corners[:, k]).max())) for k, one in enumerate((x, y))]
    ax.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]), xlabel=f"offset ({unit})", ylabel=f"tilt ({angle})")


def _block(result: View, name: str) -> Any:
    """The joint, which has a direction, a clearance and sizes of its block."""
    return result.record.assembly.mechanism.joints[name]
