"""What happens in joints, seen from their bearings: journals in clearance circles, blocks in guides, forces
as vectors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..measures.forces import IMPACT, eccentricity, joint_force, joint_rows
from ..measures.guides import sliders, turning
from ..measures.motion import pin_path
from .curves import hardest, joint_forces
from .layout import Panels
from .style import BLUE, GREY, IDEAL, INK, ORANGE, SKY, VERMILION, digits, length_unit, scale_of
from .turn import said_shortly, span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
MOST, MOST_VECTORS, COLUMNS = 12, 9, 3  # panels of positions, of forces; columns
SIDE = 3.0  # inches
ALIKE = 6.0  # the largest panel over the smallest, up to which all have one scale
MOST_DOTS = 20_000


def orbits(result: View) -> Figure:
    """Path of each journal's centre seen from its bearing's centre, in the frame of the bearing's body, one
    panel a joint and one scale.

    The last turn is a line, what came before it dots, onsets of contact in the last turn are marked; in the
    circle of radius c surfaces are apart.
    """
    names = journals(result)[:MOST]
    over, reach = span(result), {name: _reach(result, name) for name in names}
    same = max(reach.values()) <= ALIKE * min(reach.values())
    panels = Panels([(SIDE, SIDE)] * len(names), 2 if len(names) == 4 else COLUMNS, across=0.95, down=0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        half = max(reach.values()) if same else reach[name]
        factor, unit = length_unit(
            max(
                result.record.assembly.mechanism.clearances[one].clearance
                for one in (names if same else [name])
            )
        )
        _journal(ax, result, name, factor, over.first)
        square(ax, factor * half)
        ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
    scales = "" if same or len(names) < 2 else ", scales differ"
    return panels.close(
        f"{result.name}: journal centres in their bearings{said_shortly(result, over)}{scales}"
    )


def journals(result: View) -> list[str]:
    """Revolute joints with clearance: those whose journal moves inside a circle."""
    return list(result.record.assembly.mechanism.clearances)


def seen_from_bearing(result: View, name: str) -> Array:
    """Centre of a journal from that of its bearing (m), in the frame of the bearing's body, shape (outputs,
    2).
    """
    record = result.record
    away = eccentricity(record)[:, list(record.assembly.contacts).index(name)]
    angle = turning(record, record.assembly.mechanism.joints[name].sides[0][0])[0]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]], axis=1)


def _reach(result: View, name: str) -> float:
    away = seen_from_bearing(result, name)
    return 1.08 * max(
        result.record.assembly.mechanism.clearances[name].clearance, float(np.hypot(*away.T).max())
    )


def _journal(ax: Axes, result: View, name: str, factor: float, first: int) -> None:
    record = result.record
    x, y = factor * seen_from_bearing(result, name).T
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    radius = factor * record.assembly.mechanism.clearances[name].clearance
    ax.plot(
        radius * np.cos(turn),
        radius * np.sin(turn),
        color=INK,
        lw=0.9,
        ls=(0, (5, 3)),
        label="clearance circle",
        zorder=5,
    )
    if first > 0:
        dots = np.unique(np.linspace(0, first, min(first + 1, MOST_DOTS)).astype(int))
        ax.plot(
            x[dots],
            y[dots],
            color=SKY,
            ls="",
            marker=".",
            ms=2.2,
            mew=0.0,
            alpha=0.8,
            label="before",
            zorder=2,
            rasterized=True,
        )
    ax.plot(x[first:], y[first:], color=BLUE, lw=0.9, label="journal centre", zorder=3)
    if not record.static:
        modes = result.channels["mode"].values[:, list(record.assembly.contacts).index(name)]
        began = (np.arange(len(x)) > first) & (modes == IMPACT)
        if began.any():
            ax.plot(
                x[began],
                y[began],
                color=VERMILION,
                ls="",
                marker="o",
                ms=3.2,
                mew=0.0,
                label="a contact began",
                zorder=4,
            )
    ax.plot(0.0, 0.0, color=GREY, ls="", marker="+", ms=8, mew=1.2, label="bearing centre", zorder=4)


def square(ax: Axes, half: float) -> None:
    """Equal scales to both sides of the origin, with few round ticks."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    ax.set(xlim=(-half, half), ylim=(-half, half))
    ax.set_aspect("equal")


def loose_guides(result: View) -> list[str]:
    """Blocks with play in a guide."""
    rows = joint_rows(result.record)
    return [name for name in sliders(result.record) if name in rows and len(rows[name][1]) > 1]


def tilt_and_offset(result: View, name: str) -> tuple[Array, Array]:
    """Tilt (rad) of a block from its guide, and offset (m) of its centre across the guide, to the left of its
    direction, shape (outputs,).
    """
    record, joint = result.record, _block(result, name)
    base, own = (turning(record, side[0])[0] for side in joint.sides)
    away = pin_path(record, *joint.sides[1]) - pin_path(record, *joint.sides[0])
    along = base + np.arctan2(*joint.direction[::-1])
    return (own - own[0]) - (base - base[0]), np.cos(along) * away[:, 1] - np.sin(along) * away[:, 0]


def guides(result: View) -> Figure:
    """Tilt of each block over its offset across its guide; inside the diamond no corner touches a wall.

    The centres of corners' roundings are (L/2 - r) along the block from its middle: the corner farthest off
    has moved across the guide by the sizes of offset and (L/2 - r) tilt together, and touches where that is
    the clearance.
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
    corners = np.array(
        [
            (c, 0.0),
            (0.0, power * joint.clearance / arm),
            (-c, 0.0),
            (0.0, -power * joint.clearance / arm),
            (c, 0.0),
        ]
    )
    ax.plot(*corners.T, color=INK, lw=0.9, ls=(0, (5, 3)), label="a corner touches", zorder=5)
    x, y = factor * offset, power * tilt
    if first > 0:
        ax.plot(
            x[:first],
            y[:first],
            color=SKY,
            ls="",
            marker=".",
            ms=2.2,
            mew=0.0,
            label="before",
            zorder=2,
            rasterized=True,
        )
    ax.plot(x[first:], y[first:], color=BLUE, lw=0.9, label="block", zorder=3)
    ax.plot(
        x[first],
        y[first],
        color=ORANGE,
        ls="",
        marker="s",
        ms=4,
        mec=INK,
        mew=0.5,
        label="where the part shown begins",
        zorder=6,
    )
    reach = [
        1.12 * max(float(np.abs(one).max()), float(np.abs(corners[:, k]).max()))
        for k, one in enumerate((x, y))
    ]
    ax.set(
        xlim=(-reach[0], reach[0]),
        ylim=(-reach[1], reach[1]),
        xlabel=f"offset ({unit})",
        ylabel=f"tilt ({angle})",
    )


def _block(result: View, name: str) -> Any:
    """The joint, which has a direction, a clearance and sizes of its block."""
    return result.record.assembly.mechanism.joints[name]


def bearing_force(result: View, name: str) -> Array:
    """Force of a joint on its journal (N), in the frame of its bearing's body, shape (outputs, 2)."""
    record = result.record
    force = joint_force(record)[:, list(joint_rows(record)).index(name)]
    joint = record.assembly.mechanism.joints.get(name)
    angle = np.zeros(len(force)) if joint is None else turning(record, joint.sides[0][0])[0]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * force[:, 0] + s * force[:, 1], c * force[:, 1] - s * force[:, 0]], axis=1)


def polar(result: View, reference: View | None = None) -> Figure:
    """Force on each journal as a point of a plane that turns with its bearing, one panel a joint; the circle
    is the peak that is reported.
    """
    names, over = list(hardest(result, joint_forces(result), MOST_VECTORS)), span(result)
    panels = Panels([(SIDE, SIDE)] * len(names), 2 if len(names) == 4 else COLUMNS, across=1.0, down=0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        own, ideal = bearing_force(result, name)[over.first : over.last + 1], _ideal(reference, name)
        told = result.measures.get(f"{name}.force.max")
        most = max(
            float(np.hypot(*own.T).max()),
            0.0 if ideal is None else float(np.hypot(*ideal.T).max()),
            0.0 if told is None else float(told),
        )
        factor, unit = scale_of(most, "N")
        if told is not None:
            turn = np.linspace(0.0, 2.0 * np.pi, 361)
            ax.plot(
                factor * told * np.cos(turn),
                factor * told * np.sin(turn),
                color=GREY,
                lw=0.8,
                label="peak that is reported",
                zorder=2,
            )
            ax.set_title(f"{digits(factor * told)} {unit}", loc="right", fontsize=9, fontweight="normal")
        if ideal is not None:
            ax.plot(*(factor * ideal).T, **IDEAL, zorder=4)
        ax.plot(*(factor * own).T, color=BLUE, lw=0.8, label="at the outputs", zorder=3)
        ax.plot(0.0, 0.0, color=INK, ls="", marker="+", ms=8, mew=1.2, zorder=5)
        square(ax, 1.08 * factor * most)
        ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
    return panels.close(
        f"{result.name}: forces on journals, in the frames of their bearings{said_shortly(result, over)}"
    )


def _ideal(reference: View | None, name: str) -> Array | None:
    if reference is None or name not in joint_rows(reference.record):
        return None
    return bearing_force(reference, name)[reference.last_turn]
