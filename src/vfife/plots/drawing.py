"""The mechanism drawn: where it starts, faint positions over a turn, pins, ground and names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.motion import pin_path
from ..bodies import Link
from ..joints import ClearanceRevolute
from .style import BODIES, GREY, INK, heading, length_unit, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..result import Result

Array = NDArray[np.float64]
POSITIONS = 12  # faint ones over a turn
LARGE_BEARING = 0.03  # bearing radius, as a share of the drawing, from which its circle is drawn
GROUND_DEPTH = 0.065  # of the sign for the ground, as a share of the drawing


def drawing(result: Result) -> Figure:
    """Bodies at the start of the run, their positions over the last turn faint behind them, joints with their names."""
    mechanism = result.record.assembly.mechanism
    outlines = {name: outline(result, name) for name in result.record.assembly.bodies}
    places = {name: pin_path(result.record, *joint.sides[0]) for name, joint in mechanism.joints.items()}
    low, high = _extent(result, [*outlines.values(), *places.values()])
    size = float(np.max(high - low)) or 1.0
    factor, unit = length_unit(size)
    width, height = np.maximum((high - low) / size, 0.35) * 5.6
    figure, (ax,) = panels(1, 1, width + 2.9, height + 1.0, equal=True)
    later = _later(result)
    for path, colour in zip(outlines.values(), _colours(len(outlines)), strict=True):
        for k in later:
            ax.plot(*(factor * path[k]).T, color=colour, lw=1.0, alpha=0.28, zorder=1)
    _ground(ax, result, factor, size)
    for (name, path), colour in zip(outlines.items(), _colours(len(outlines)), strict=True):
        _body(ax, name, factor * path[0], colour)
    middle = np.mean([path[0].mean(axis=0) for path in outlines.values()], axis=0)
    signs = _joints(ax, result, {name: factor * path[0] for name, path in places.items()}, factor * middle, factor * size, factor)
    handles, labels = ax.get_legend_handles_labels()
    figure.legend([*handles, *signs.values()], [*labels, *signs], loc="outside right center")
    ax.set_aspect("equal")
    ax.set(xlim=factor * np.array([low[0], high[0]]), ylim=factor * np.array([low[1], high[1]]))
    ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})")
    behind = "" if not later else " (faint: over the last turn)" if result.crank is not None else " (faint: later)"
    heading(figure, f"{result.name} at the start{behind}")
    return figure


def _extent(result: Result, paths: list[Array]) -> tuple[Array, Array]:
    """Lower left and upper right corner (m) of what is drawn, with a margin that holds the signs for the ground."""
    points = [path.reshape(-1, 2) for path in paths]
    for joint in result.record.assembly.mechanism.clearances.values():
        centre = pin_path(result.record, *joint.sides[0])[0]
        points.append(np.stack([centre - joint.bearing_radius, centre + joint.bearing_radius]))
    everything = np.concatenate(points)
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.08 * float(np.max(high - low))
    return low - np.array([margin, 1.4 * margin]), high + margin


def outline(result: Result, name: str) -> Array:
    """Particles of an elastic link or pins of a rigid body at all outputs (m), shape (outputs, corners, 2)."""
    record = result.record
    body = record.assembly.bodies[name]
    if body.elements:
        nodes = list(body.particles)
        return np.stack([record.block("particle_x")[:, nodes], record.block("particle_y")[:, nodes]], axis=2)
    used = [pin for joint in record.assembly.mechanism.joints.values() for owner, pin in joint.sides if owner == name]
    noun = record.assembly.mechanism.bodies[name]
    pins = ["start", "end"] if isinstance(noun, Link) else [pin for pin in noun.pins if pin != "center"]
    pins += [pin for pin in used if pin not in pins]
    at = np.array([body.pins[pin] for pin in pins] or [(0.0, 0.0)])
    if len(pins) > 2:
        middle = at.mean(axis=0)
        order = np.argsort(np.arctan2(*(at - middle).T[::-1]), kind="stable")
        pins = [pins[k] for k in (*order, order[0])] if not _collinear(at) else [pins[k] for k in np.argsort(at @ (at[1] - at[0]))]
    elif len(pins) == 1 and at.any() and "center" in body.pins:
        pins.append("center")
    paths = [pin_path(record, name, pin) for pin in pins or ["center"]]
    return np.stack(paths, axis=1)


def _collinear(points: Array) -> bool:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[-1] < 1e-9 * spread[0])


def _colours(count: int) -> list[str]:
    return [BODIES[k % len(BODIES)] for k in range(count)]


def _later(result: Result) -> list[int]:
    """Outputs at which the mechanism is drawn faintly."""
    chosen = np.flatnonzero(result.last_turn)
    if len(chosen) < 2:
        return []
    return [int(k) for k in chosen[np.linspace(0, len(chosen) - 1, POSITIONS + 1).astype(int)][:-1]]


def _body(ax: Axes, name: str, path: Array, colour: str) -> None:
    if len(path) == 1:
        ax.plot(*path.T, color=colour, ls="", marker="o", ms=12, label=name, zorder=3)
    elif len(path) > 3 and np.array_equal(path[0], path[-1]):
        ax.fill(*path.T, facecolor=colour, alpha=0.3, edgecolor=colour, lw=2.5, label=name, zorder=3)
    else:
        ax.plot(*path.T, color=colour, lw=4.0, label=name, zorder=3)
        ax.plot(*path[1:-1].T, ls="", marker="o", ms=3, color="white", zorder=4)  # nodes of an elastic link


def _ground(ax: Axes, result: Result, factor: float, size: float) -> None:
    """A triangle on a hatched strip under each point of the ground that carries a joint."""
    mechanism = result.record.assembly.mechanism
    used = {pin for joint in mechanism.joints.values() for owner, pin in joint.sides if owner == "ground"}
    half, tall, deep = (part * size * factor for part in (0.028, 0.045, GROUND_DEPTH))
    for pin in used:
        x, y = (factor * value for value in mechanism.points[pin])
        ax.fill([x, x - half, x + half], [y, y - tall, y - tall], facecolor="white", edgecolor=INK, lw=1.2, zorder=2)
        strip: dict[str, Any] = {"facecolor": "none", "edgecolor": GREY, "hatch": "//////", "lw": 0.0, "zorder": 2}
        ax.fill([x - 1.6 * half, x + 1.6 * half] * 2, [y - tall, y - tall, y - deep, y - deep], **strip)
        ax.plot([x - 1.6 * half, x + 1.6 * half], [y - tall] * 2, color=INK, lw=1.2, zorder=2)


def _joints(ax: Axes, result: Result, places: dict[str, Array], middle: Array, size: float, factor: float) -> dict[str, Any]:
    """Joints as rings, with a dot where there is clearance, and their names; returns what a legend shows of them."""
    mechanism = result.record.assembly.mechanism
    signs: dict[str, Any] = {}
    for name, at in places.items():
        joint = mechanism.joints[name]
        clear = isinstance(joint, ClearanceRevolute)
        if isinstance(joint, ClearanceRevolute) and joint.bearing_radius > LARGE_BEARING * size / factor:
            _surfaces(ax, result, joint, factor)
            signs["bearing and journal"] = ax.plot([], [], ls="", marker="o", ms=9, mfc="none", mec=INK, mew=1.4)[0]
        else:
            ring = ax.plot(*at, ls="", marker="o", ms=9, mfc="white", mec=INK, mew=1.4, zorder=5)
            dot = ax.plot(*at, ls="", marker="o", ms=4, mfc=INK, mec=INK, zorder=6) if clear else []
            signs["joint with clearance" if clear else "ideal joint"] = (*ring, *dot)
        look: dict[str, Any] = {"ha": "center", "va": "center", "weight": "bold", "zorder": 7}
        look["bbox"] = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.8}
        if "ground" in (owner for owner, _ in joint.sides):
            ax.text(at[0], at[1] - (GROUND_DEPTH + 0.03) * size, name, **look)
        else:
            away = (at - middle) / (np.linalg.norm(at - middle) or 1.0)
            ax.annotate(name, (at[0], at[1]), xytext=(16.0 * away[0], 16.0 * away[1]), textcoords="offset points", **look)
    return signs


def _surfaces(ax: Axes, result: Result, joint: ClearanceRevolute, factor: float) -> None:
    """The circles of bearing and journal where they are large enough to be seen."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    radii = (joint.bearing_radius, joint.bearing_radius - joint.clearance)
    for side, radius, width in zip(joint.sides, radii, (1.8, 0.9), strict=True):
        centre = pin_path(result.record, *side)[0]
        ax.plot(*factor * (centre[:, None] + radius * circle), color=INK, lw=width, zorder=4)
