"""Motion as curves in a plane: paths of points, and velocity over position."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..measures.guides import slider_motion, sliders
from ..measures.motion import body_motion, pin_path
from ..model.outlines import CENTER, loose_pins
from .layout import Panels
from .style import BLUE, BODIES, IDEAL, INK, SKY, length_unit, readable
from .turn import said_shortly, span

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
MOST = 12  # paths
SIZE = 5.4  # inches of the longer side
LINES = ("-", (0, (4, 1.2)), (0, (1.2, 1.0)))
ROUNDING = 1e-9  # of the size of what moves: a way below it is none
MOVES = 1e-3  # of the largest way: what moves by less has no path to be seen


def points(result: View) -> dict[str, tuple[str, str]]:
    """Body and pin of each point whose path is drawn, by what it is called; of those that go together the
    first.
    """
    found = _named(result)
    paths = {name: pin_path(result.record, *at) for name, at in found.items()}
    size = float(np.ptp(np.concatenate(list(paths.values()) or [np.zeros((1, 2))]), axis=0).max())
    ways = {name: float(np.ptp(path, axis=0).max()) for name, path in paths.items()}
    least = max(MOVES * max(ways.values(), default=0.0), ROUNDING * size)
    kept: dict[str, tuple[str, str]] = {}
    for name, at in found.items():
        same = any(np.allclose(paths[name], paths[other], rtol=0.0, atol=least) for other in kept)
        if ways[name] > least and not same:
            kept[name] = at
    return kept


def _named(result: View) -> dict[str, tuple[str, str]]:
    """Joints by their names, other pins as ``body.pin``, bodies without any by their centre, driven points by
    their driver.
    """
    mechanism = result.record.assembly.mechanism
    found = {
        name: joint.sides[1] if joint.sides[1][0] != "ground" else joint.sides[0]
        for name, joint in mechanism.joints.items()
    }
    for name, body in result.record.assembly.bodies.items():
        found |= {f"{name}.{pin}": (name, pin) for pin in loose_pins(mechanism, name, bool(body.elements))}
        if (
            not body.elements
            and not any(owner == name for owner, _ in found.values())
            and CENTER in body.pins
        ):
            found[name] = (name, CENTER)
    for name, driver in mechanism.drivers.items():
        owner, _, pin = driver.point.partition(".")
        if driver.point and (owner, pin) not in found.values():
            found[name] = (owner, pin)
    return found


def traces(result: View, reference: View | None = None) -> Figure:
    """Where points go, in one plane: the last turn as lines, the ideal mechanism thin."""
    found, over = dict(list(points(result).items())[:MOST]), span(result)
    shown = slice(over.first, over.last + 1)
    paths = {name: pin_path(result.record, *at)[shown] for name, at in found.items()}
    ideal = (
        {}
        if reference is None
        else {name: pin_path(reference.record, *at)[reference.last_turn] for name, at in found.items()}
    )
    every = np.concatenate([*paths.values(), *ideal.values()])
    low, high = every.min(axis=0), every.max(axis=0)
    size = float(np.max(high - low))
    low, high = low - 0.06 * size, high + 0.06 * size
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 0.22 * size)
    width, height = SIZE * 2.0 * half / (2.0 * half).max()
    factor, unit = length_unit(size)
    panels = Panels([(width, height)], 1)
    ax = panels.axes[0]
    for k, (name, path) in enumerate(paths.items()):
        colour = BODIES[k % len(BODIES)]
        ax.plot(
            *(factor * path).T,
            color=colour,
            lw=1.6,
            ls=LINES[k // len(BODIES) % len(LINES)],
            label=name,
            zorder=3,
        )
        ax.plot(*(factor * path[0]), color=colour, ls="", marker="o", ms=4.5, mec=INK, mew=0.6, zorder=4)
        if name in ideal:
            ax.plot(
                *(factor * ideal[name]).T,
                color=INK,
                lw=0.6,
                label="ideal joints" if k == 0 else None,
                zorder=2,
            )
    panels.signs["begins here"] = ax.plot([], [], color="white", ls="", marker="o", ms=4.5, mec=INK, mew=0.8)[
        0
    ]
    limits = factor * np.stack([middle - half, middle + half], axis=1)
    ax.set(xlim=limits[0], ylim=limits[1], xlabel=f"x ({unit})", ylabel=f"y ({unit})")
    return panels.close(f"{result.name}: paths of points{said_shortly(result, over)}")


MOST_PORTRAITS, COLUMNS = 12, 2
TURNING = 350.0  # degrees: the angle of a body that turns by more is counted within one turn
STILL = 1e-4  # rad: a body that turns by less has no portrait


def portraits(result: View) -> dict[str, tuple[str, str, Array, Array]]:
    """Position and velocity by title, with what each axis is: sliders along their guides, then bodies that
    turn and are not driven.
    """
    record = result.record
    if record.static or len(record.steps) < 3:
        return {}
    found: dict[str, tuple[str, str, Array, Array]] = {}
    gliding = set()
    for name in sliders(record):
        position, velocity, _ = slider_motion(record, name)
        glides = record.assembly.mechanism.joints[name].sides[1][0]
        gliding.add(glides)
        found[f"{glides} along {name}"] = ("m", "m/s", position, velocity)
    moved = body_motion(record)
    for k, (name, body) in enumerate(record.assembly.bodies.items()):
        angle = moved["angle"][:, k]
        if body.driven is None and name not in gliding and np.ptp(angle) > STILL:
            degrees, velocity = np.degrees(angle), moved["angular_velocity"][:, k].copy()
            if np.ptp(degrees) > TURNING:
                degrees = np.mod(degrees, 360.0)
                velocity[1:][np.abs(np.diff(degrees)) > 180.0] = np.nan  # not a line across the portrait
            found[name] = ("degrees", "rad/s", degrees, velocity)
    return found


def phase(result: View, reference: View | None = None) -> Figure:
    """A panel for each of them: the last turn as a line, what came before it dots, the ideal mechanism
    dashed.
    """
    found, over = dict(list(portraits(result).items())[:MOST_PORTRAITS]), span(result)
    ideal = {} if reference is None else portraits(reference)
    panels = Panels([(3.9, 2.7)] * len(found), COLUMNS, across=1.1, down=0.95)
    for ax, (name, (first, second, position, velocity)) in zip(panels.axes, found.items(), strict=True):
        factor, unit = readable(position, first) if first == "m" else (1.0, first)
        power, rate = readable(velocity, second)
        if over.first > 0:
            part = slice(0, over.first, max(1, over.first // 20_000))
            dots: dict[str, Any] = {"color": SKY, "ls": "", "marker": ".", "ms": 2.2, "mew": 0.0}
            ax.plot(
                factor * position[part],
                power * velocity[part],
                label="before",
                zorder=2,
                rasterized=True,
                **dots,
            )
        shown = slice(over.first, over.last + 1)
        if reference is not None and name in ideal:
            turn = reference.last_turn
            ax.plot(factor * ideal[name][2][turn], power * ideal[name][3][turn], **IDEAL)
        ax.plot(
            factor * position[shown], power * velocity[shown], color=BLUE, lw=0.9, label="this run", zorder=3
        )
        ax.plot(
            factor * position[over.first],
            power * velocity[over.first],
            color=INK,
            ls="",
            marker="o",
            ms=4,
            label="begins here",
            zorder=5,
        )
        what = ("position", "velocity") if first == "m" else ("angle", "angular velocity")
        ax.set(xlabel=f"{what[0]} ({unit})", ylabel=f"{what[1]} ({rate})", title=name)
    return panels.close(f"{result.name}: velocity over position{said_shortly(result, over)}")
