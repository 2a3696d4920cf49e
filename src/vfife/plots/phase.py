"""Phase portraits: velocity over position, of every body that turns by itself and every slider."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.guides import slider_motion, sliders
from ..analysis.motion import body_motion
from .layout import Panels
from .style import BLUE, INK, SKY, VERMILION, length_unit, scale_of
from .turn import said_shortly, span

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
MOST, COLUMNS = 12, 2
TURNING = 350.0  # degrees: the angle of a body that turns by more is counted within one turn
STILL = 1e-4  # rad: a body that turns by less has no portrait


def portraits(result: View) -> dict[str, tuple[str, str, Array, Array]]:
    """Position and velocity by title, with what each axis is: sliders along their guides, then bodies that turn and are not driven."""
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
    """A panel for each of them: the last turn as a line, what came before it dots, the ideal mechanism dashed."""
    found, over = dict(list(portraits(result).items())[:MOST]), span(result)
    ideal = {} if reference is None else portraits(reference)
    panels = Panels([(3.9, 2.7)] * len(found), COLUMNS, across=1.1, down=0.95)
    for ax, (name, (first, second, position, velocity)) in zip(panels.axes, found.items(), strict=True):
        factor, unit = length_unit(float(np.abs(position).max())) if first == "m" else (1.0, first)
        power, rate = scale_of(float(np.nanmax(np.abs(velocity))), second)
        if over.first > 0:
            part = slice(0, over.first, max(1, over.first // 20_000))
            dots: dict[str, Any] = {"color": SKY, "ls": "", "marker": ".", "ms": 2.2, "mew": 0.0}
            ax.plot(factor * position[part], power * velocity[part], label="before", zorder=2, rasterized=True, **dots)
        shown = slice(over.first, over.last + 1)
        if reference is not None and name in ideal:
            turn = reference.last_turn
            ax.plot(factor * ideal[name][2][turn], power * ideal[name][3][turn], color=VERMILION, lw=1.3, ls=(0, (5, 1.6)), label="ideal joints")
        ax.plot(factor * position[shown], power * velocity[shown], color=BLUE, lw=0.9, label="this run", zorder=3)
        ax.plot(factor * position[over.first], power * velocity[over.first], color=INK, ls="", marker="o", ms=4, label="begins here", zorder=5)
        what = ("position", "velocity") if first == "m" else ("angle", "angular velocity")
        ax.set(xlabel=f"{what[0]} ({unit})", ylabel=f"{what[1]} ({rate})", title=name)
    return panels.close(f"{result.name}: velocity over position{said_shortly(result, over)}")
