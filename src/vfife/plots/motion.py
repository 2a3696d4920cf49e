"""Motion as curves in a plane: paths of points, velocity over position, journals and blocks in their
clearances, forces on journals.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..measures.forces import IMPACT, eccentricity, joint_force, joint_rows
from ..measures.motion import body_motion, pin_path, rotation, slider_motion, sliders
from ..model.outlines import CENTER, loose_pins
from ..results.run_data import RunData
from .curves import largest_forces
from .layout import Panels
from .style import (
    BLUE,
    GREY,
    IDEAL,
    INK,
    ORANGE,
    SKY,
    VERMILION,
    Array,
    circle,
    corner_text,
    curve_look,
    dots_before,
    length_unit,
    peak_digits,
    readable,
    scale_of,
)
from .turn import shown_span, shown_turn

MOST_PATHS, MOST_PANELS, MOST_VECTORS = 12, 12, 9  # paths in a figure, panels, and panels of forces
MOST_PEAK = 3.0  # largest ratio of a peak between outputs to those at outputs with which its circle is drawn
RAYS = 90  # vectors of a polar figure that are drawn as lines from the centre
SIZE, SIDE = 5.4, 3.0  # inches of the longer side of paths, and of a square panel
COLUMNS = 3
ROUNDING = 1e-9  # of the size of the mechanism: a shorter path is none
MOVES = 1e-3  # of the longest path: a shorter one could not be seen
ALIKE = 6.0  # the largest panel over the smallest, up to which all have one scale
TURNING = 350.0  # degrees: the angle of a body that turns
LEAST_TURN = 1e-4  # rad: a body that turns by less has no portrait


def points(result: RunData) -> dict[str, tuple[str, str]]:
    """Return the body and pin of each moving point by its name; of points with the same path the first."""
    candidates = _named_points(result)
    paths = {name: pin_path(result.record, *at) for name, at in candidates.items()}
    size = float(np.ptp(np.concatenate(list(paths.values()) or [np.zeros((1, 2))]), axis=0).max())
    lengths = {name: float(np.ptp(path, axis=0).max()) for name, path in paths.items()}
    tolerance = max(MOVES * max(lengths.values(), default=0.0), ROUNDING * size)
    chosen: dict[str, tuple[str, str]] = {}
    for name, at in candidates.items():
        repeated = any(
            np.allclose(paths[name], paths[earlier], rtol=0.0, atol=tolerance) for earlier in chosen
        )
        if lengths[name] > tolerance and not repeated:
            chosen[name] = at
    return chosen


def _named_points(result: RunData) -> dict[str, tuple[str, str]]:
    """Joints by their names, other pins as ``body.pin``, bodies without any by their centre, driven points by
    their driver.
    """
    mechanism = result.record.assembly.mechanism
    points = {
        name: joint.sides[1] if joint.sides[1][0] != "ground" else joint.sides[0]
        for name, joint in mechanism.joints.items()
    }
    for name, body in result.record.assembly.bodies.items():
        points |= {f"{name}.{pin}": (name, pin) for pin in loose_pins(mechanism, name, bool(body.elements))}
        if (
            not body.elements
            and not any(owner == name for owner, _ in points.values())
            and CENTER in body.pins
        ):
            points[name] = (name, CENTER)
    for name, driver in mechanism.drivers.items():
        owner, _, pin = driver.point.partition(".")
        if driver.point and (owner, pin) not in points.values():
            points[name] = (owner, pin)
    return points


def traces(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of paths of points: the last turn as lines, the ideal mechanism thin."""
    chosen, span = dict(list(points(result).items())[:MOST_PATHS]), shown_span(result)
    paths = {name: pin_path(result.record, *at)[span.outputs] for name, at in chosen.items()}
    ideal = (
        {}
        if reference is None
        else {name: pin_path(reference.record, *at)[reference.last_turn] for name, at in chosen.items()}
    )
    places = np.concatenate([*paths.values(), *ideal.values()])
    low, high = places.min(axis=0), places.max(axis=0)
    size = float(np.max(high - low))
    low, high = low - 0.06 * size, high + 0.06 * size
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 0.22 * size)
    width, height = SIZE * 2.0 * half / (2.0 * half).max()
    factor, unit = length_unit(size)
    panels = Panels([(width, height)], 1)
    ax = panels.axes[0]
    for k, (name, path) in enumerate(paths.items()):
        look = curve_look(k)
        ax.plot(*(factor * path).T, lw=1.6, label=name, zorder=3, **look)
        ax.plot(
            *(factor * path[0]), color=look["color"], ls="", marker="o", ms=4.5, mec=INK, mew=0.6, zorder=4
        )
        if name in ideal:
            ax.plot(
                *(factor * ideal[name]).T,
                color=INK,
                lw=0.6,
                label="ideal joints" if k == 0 else None,
                zorder=2,
            )
    panels.extra_entries["begins here"] = ax.plot(
        [], [], color="white", ls="", marker="o", ms=4.5, mec=INK, mew=0.8
    )[0]
    limits = factor * np.stack([middle - half, middle + half], axis=1)
    ax.set(xlim=limits[0], ylim=limits[1], xlabel=f"x ({unit})", ylabel=f"y ({unit})")
    return panels.close(f"{result.name}: paths of points{shown_turn(result, span)}")


def portraits(result: RunData) -> dict[str, tuple[str, str, Array, Array]]:
    """Return the units, position and velocity by title: sliders along their guides, then bodies that turn and
    are not driven.
    """
    record = result.record
    if record.static or len(record.steps) < 3:
        return {}
    portraits: dict[str, tuple[str, str, Array, Array]] = {}
    gliding = set()
    for name in sliders(record):
        position, velocity, _ = slider_motion(record, name)
        glides = record.assembly.mechanism.joints[name].sides[1][0]
        gliding.add(glides)
        portraits[f"{glides} along {name}"] = ("m", "m/s", position, velocity)
    moved = body_motion(record)
    for k, (name, body) in enumerate(record.assembly.bodies.items()):
        angle = moved["angle"][:, k]
        if body.driven is None and name not in gliding and np.ptp(angle) > LEAST_TURN:
            degrees, velocity = np.degrees(angle), moved["angular_velocity"][:, k].copy()
            if np.ptp(degrees) > TURNING:
                degrees = np.mod(degrees, 360.0)
                velocity[1:][np.abs(np.diff(degrees)) > 180.0] = np.nan  # not a line across the portrait
            portraits[name] = ("degrees", "rad/s", degrees, velocity)
    return portraits


def phase(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of phase portraits: the last turn as a line, earlier outputs as dots, the ideal
    mechanism dashed.
    """
    chosen, span = dict(list(portraits(result).items())[:MOST_PANELS]), shown_span(result)
    ideal = {} if reference is None else portraits(reference)
    panels = Panels.alike(len(chosen), 2, (3.9, 2.7), across=1.1, down=0.95)
    for ax, (name, (first, second, position, velocity)) in zip(panels.axes, chosen.items(), strict=True):
        factor, unit = readable(position, first) if first == "m" else (1.0, first)
        rate_factor, rate_unit = readable(velocity, second)
        x, y = factor * position, rate_factor * velocity
        dots_before(ax, x, y, span.first)
        if reference is not None and name in ideal:
            turn = reference.last_turn
            ax.plot(factor * ideal[name][2][turn], rate_factor * ideal[name][3][turn], **IDEAL)
        ax.plot(x[span.outputs], y[span.outputs], color=BLUE, lw=0.9, label="this run", zorder=3)
        begin: Any = {"ls": "", "marker": "o", "ms": 4, "label": "begins here", "zorder": 5}
        ax.plot(x[span.first], y[span.first], color=INK, **begin)
        names = ("position", "velocity") if first == "m" else ("angle", "angular velocity")
        ax.set(xlabel=f"{names[0]} ({unit})", ylabel=f"{names[1]} ({rate_unit})", title=name)
    return panels.close(f"{result.name}: velocity over position{shown_turn(result, span)}")


# -------------------------------------------------------------------------------------- clearances and forces


def orbits(result: RunData) -> Figure:
    """Return a figure of the path of each journal's centre relative to its bearing's centre, in the frame of
    the bearing's body; panels have one scale if possible.

    The last turn is a line, earlier outputs are dots, onsets of contact in the last turn are marked; the
    clearance circle has the radius c.
    """
    names = journals(result)[:MOST_PANELS]
    span, reach = shown_span(result), {name: _reach(result, name) for name in names}
    clearances = result.record.assembly.mechanism.clearances
    one_scale = max(reach.values()) <= ALIKE * min(reach.values())
    panels = _square_panels(len(names), 0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        scaled = names if one_scale else [name]
        half = max(reach[joint] for joint in scaled)
        factor, unit = length_unit(max(clearances[joint].clearance for joint in scaled))
        _journal(ax, result, name, factor, span.first)
        square(ax, factor * half)
        ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
    scales = "" if one_scale or len(names) < 2 else ", scales differ"
    return panels.close(f"{result.name}: journal centres in their bearings{shown_turn(result, span)}{scales}")


def journals(result: RunData) -> list[str]:
    """Return the revolute joints with clearance: those whose journal moves inside a circle."""
    return list(result.record.assembly.mechanism.clearances)


def relative_to_bearing(result: RunData, name: str) -> Array:
    """Return the centre of a journal from that of its bearing (m), in the frame of the bearing's body, shape
    (outputs, 2).
    """
    record = result.record
    return _in_bearing_frame(
        result, name, eccentricity(record)[:, list(record.assembly.contacts).index(name)]
    )


def _in_bearing_frame(result: RunData, name: str, vectors: Array) -> Array:
    """Return the vectors, shape (outputs, 2), in the frame of the bearing's body of a joint; gears and
    drivers keep the global axes.
    """
    joint = result.record.assembly.mechanism.joints.get(name)
    if joint is None:
        return vectors
    angle = rotation(result.record, joint.sides[0][0]).position
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vectors[:, 0] + s * vectors[:, 1], c * vectors[:, 1] - s * vectors[:, 0]], axis=1)


def _reach(result: RunData, name: str) -> float:
    away = relative_to_bearing(result, name)
    return 1.08 * max(
        result.record.assembly.mechanism.clearances[name].clearance, float(np.hypot(*away.T).max())
    )


def _journal(ax: Axes, result: RunData, name: str, factor: float, first: int) -> None:
    record = result.record
    x, y = factor * relative_to_bearing(result, name).T
    radius = factor * record.assembly.mechanism.clearances[name].clearance
    ax.plot(*circle(radius), color=INK, lw=0.9, ls=(0, (5, 3)), label="clearance circle", zorder=5)
    dots_before(ax, x, y, first, alpha=0.8)
    ax.plot(x[first:], y[first:], color=BLUE, lw=0.9, label="journal centre", zorder=3)
    if not record.static:
        modes = result.channels["mode"].values[:, list(record.assembly.contacts).index(name)]
        began = (np.arange(len(x)) > first) & (modes == IMPACT)
        if began.any():
            onset: Any = {"ls": "", "marker": "o", "ms": 3.2, "mew": 0.0, "zorder": 4}
            ax.plot(x[began], y[began], color=VERMILION, label="a contact began", **onset)
    ax.plot(0.0, 0.0, color=GREY, ls="", marker="+", ms=8, mew=1.2, label="bearing centre", zorder=4)


def _square_panels(count: int, across: float) -> Panels:
    return Panels.alike(count, 2 if count == 4 else COLUMNS, (SIDE, SIDE), across=across, down=0.95)


def square(ax: Axes, half: float) -> None:
    """Set equal scales with the origin in the middle, and few round ticks."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    half = half or 1.0  # of a contact without a force
    ax.set(xlim=(-half, half), ylim=(-half, half))
    ax.set_aspect("equal")


def loose_guides(result: RunData) -> list[str]:
    """Return the sliders whose block has clearance in its guide."""
    return [name for name in sliders(result.record) if name in result.record.assembly.mechanism.contacts]


def tilt_and_offset(result: RunData, name: str) -> tuple[Array, Array]:
    """Return the tilt (rad) of a block from its guide, and offset (m) of its centre across the guide, to the
    left of its direction, shape (outputs,).
    """
    record, joint = result.record, _block(result, name)
    base, block_angle = (rotation(record, side[0]).position for side in joint.sides)
    away = pin_path(record, *joint.sides[1]) - pin_path(record, *joint.sides[0])
    direction = base + np.arctan2(*joint.direction[::-1])
    offset = np.cos(direction) * away[:, 1] - np.sin(direction) * away[:, 0]
    return (block_angle - block_angle[0]) - (base - base[0]), offset


def guides(result: RunData) -> Figure:
    """Return a figure of the tilt of each block over its offset across its guide; inside the diamond no
    corner touches a wall.

    The centres of corners' roundings are (L/2 - r) along the block from its middle: the corner farthest off
    has moved across the guide by the sizes of offset and (L/2 - r) tilt together, and touches where that is
    the clearance.
    """
    names, span = loose_guides(result)[:MOST_PANELS], shown_span(result)
    panels = Panels.alike(len(names), COLUMNS, (3.6, 3.0), across=1.1, down=0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        _guide(ax, result, name, span.first)
        ax.set_title(f"joint {name}")
    return panels.close(f"{result.name}: blocks in their guides{shown_turn(result, span)}")


def _guide(ax: Axes, result: RunData, name: str, first: int) -> None:
    joint = _block(result, name)
    tilt, offset = tilt_and_offset(result, name)
    arm = 0.5 * joint.length - joint.corner_radius
    factor, unit = length_unit(joint.clearance)
    angle_factor, angle_unit = (1e3, "mrad") if joint.clearance / arm < 0.5 else (1.0, "rad")
    corners = np.array([factor, angle_factor]) * touching(result, name)
    ax.plot(*corners.T, color=INK, lw=0.9, ls=(0, (5, 3)), label="a corner touches", zorder=5)
    x, y = factor * offset, angle_factor * tilt
    dots_before(ax, x, y, first)
    ax.plot(x[first:], y[first:], color=BLUE, lw=0.9, label="block", zorder=3)
    begin: Any = {"ls": "", "marker": "s", "ms": 4, "mec": INK, "mew": 0.5, "zorder": 6}
    ax.plot(x[first], y[first], color=ORANGE, label="where the part shown begins", **begin)
    width, height = 1.12 * np.abs(np.vstack([np.stack([x, y], axis=1), corners])).max(axis=0)
    ax.set(xlim=(-width, width), ylim=(-height, height))
    ax.set(xlabel=f"offset ({unit})", ylabel=f"tilt ({angle_unit})")


def touching(result: RunData, name: str) -> Array:
    """Return the offsets (m) and tilts (rad) of a block at which a corner touches, shape (5, 2)."""
    joint = _block(result, name)
    c, tilt = joint.clearance, joint.clearance / (0.5 * joint.length - joint.corner_radius)
    return np.array([(c, 0.0), (0.0, tilt), (-c, 0.0), (0.0, -tilt), (c, 0.0)])


def _block(result: RunData, name: str) -> Any:
    """Return a joint with a direction, a clearance and sizes of its block."""
    return result.record.assembly.mechanism.joints[name]


def bearing_force(result: RunData, name: str) -> Array:
    """Return the force of a joint on its journal (N), in the frame of its bearing's body, shape
    (outputs, 2).
    """
    record = result.record
    return _in_bearing_frame(result, name, joint_force(record)[:, list(joint_rows(record)).index(name)])


def polar(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of the force on each journal as a vector in the frame of its bearing's body; the circle
    is the reported peak, unless it occurred between outputs and would hide them.
    """
    names, span = list(largest_forces(result, MOST_VECTORS)), shown_span(result)
    panels = _square_panels(len(names), 1.0)
    for ax, name in zip(panels.axes, names, strict=True):
        forces, ideal = bearing_force(result, name)[span.outputs], _ideal(reference, name)
        peak = result.measures.get(f"{name}.force.max")
        drawn = forces if ideal is None else np.concatenate([forces, ideal])
        limit = float(np.hypot(*drawn.T).max(initial=0.0))
        outside = peak is not None and peak > MOST_PEAK * limit > 0.0
        limit = limit if outside else max(limit, float(peak or 0.0))
        factor, unit = scale_of(limit, "N")
        if peak is not None:
            if not outside:
                ax.plot(*circle(factor * peak), color=GREY, lw=0.8, label="peak that is reported", zorder=2)
            times, size = scale_of(peak, "N")
            mean = "mean " if span.turns is not None else ""
            remark = ", between outputs" if outside else ""
            corner_text(ax, f"{mean}peak {peak_digits(peak, times)} {size}{remark}")
        if ideal is not None:
            ax.plot(*(factor * ideal).T, **IDEAL, zorder=4)
        _rays(ax, factor * forces)
        ax.plot(*(factor * forces).T, color=BLUE, lw=1.2, label="at the outputs", zorder=3)
        ax.plot(0.0, 0.0, color=INK, ls="", marker="+", ms=8, mew=1.2, zorder=5)
        square(ax, 1.08 * factor * limit)
        ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
    return panels.close(
        f"{result.name}: forces on journals, in the frames of their bearings{shown_turn(result, span)}"
    )


def _rays(ax: Axes, forces: Array) -> None:
    """Draw some of the vectors themselves: those of a guide all have one direction."""
    tips = forces[np.linspace(0, len(forces) - 1, min(RAYS, len(forces))).astype(int)]
    rays = np.stack([np.zeros_like(tips), tips, np.full_like(tips, np.nan)], axis=1).reshape(-1, 2)
    ax.plot(*rays.T, color=SKY, lw=0.8, label="vectors", zorder=2.5)


def _ideal(reference: RunData | None, name: str) -> Array | None:
    if reference is None or name not in joint_rows(reference.record):
        return None
    return bearing_force(reference, name)[reference.last_turn]
