"""Joint forces and angular accelerations against crank angle, over the ideal ones (Figs. 16-17 of the VFIFE paper)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..analysis.forces import joint_force_max, joint_moment, joint_rows
from ..analysis.ranges import band
from .style import BLUE, ORANGE, SKY, VERMILION, heading, one_legend, panels, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.view import View
    from ..solvers.record import Record

Array = NDArray[np.float64]
NOISE = 1e-5  # of the largest force or moment (N, N m), below which a joint carries nothing
MOST = 16  # panels of a figure; of more joints those with the largest forces
Series = tuple[Array, Array | None]  # a line, and the extremes around it
Curve = Callable[["View", str], "Series | None"]
Bands = Callable[
    ["View", str], "tuple[Array, Array] | None"
]  # lowest and highest over run and companions, over the last turn and the output before


def force_curves(result: View, reference: View | None = None) -> Figure | None:
    """Size of each joint's force over the last crank turn, one panel a joint; joints with clearance first, None
    without any joint.

    The line is the largest force in each output interval, so that no peak is missed.
    """
    names = loaded_joints(result, MOST)
    return _figure(result, reference, names, (_force, _force_band), "joint force", "N", _titles(result))


def loaded_joints(result: View, most: int) -> list[str]:
    """Names of the joints that carry a force, joints with clearance first; of more than ``most`` those with the largest forces."""
    rows, kinds = joint_rows(result.record), {"contact": 0, "joint": 1, "driven": 2}
    loaded = {name: float(found[0].max()) for name in rows if (found := _force(result, name)) is not None}
    noise = NOISE * max([0.0, *loaded.values(), *(float(np.abs(_moment(result, name)[0]).max()) for name in rows)])
    names = sorted((name for name, most in loaded.items() if most > noise), key=lambda name: kinds[rows[name][0]])
    largest = sorted(names, key=lambda name: -loaded[name])[:most]
    return [name for name in names if name in largest]


@dataclass(frozen=True)
class ForceCurve:
    """Size of a joint's force (N) over the crank angle (degrees), time (ms) or load factor, and the ideal one's where there is one."""

    x: Array
    force: Array
    ideal: tuple[Array, Array] | None


def force_from(result: View, reference: View | None, name: str, first: int) -> ForceCurve:
    """The force of a joint from an output on; the ideal one's last turn again for each turn of it."""
    x, origin = one_turn(abscissa(result)[first:], result)
    force, ideal = _force_of(result, name)[first:], None if reference is None else _force(reference, name)
    if ideal is None or reference is None:
        return ForceCurve(x, force, None)
    at, values = _ideal_turn(reference, ideal[0], x, origin)
    if result.crank is not None and not result.record.static:
        turns = range(1 + int(abs(x[-1] - x[0]) / 360.0))
        at, values = np.concatenate([at + 360.0 * k for k in turns]), np.tile(values, len(turns))
    seen = (at >= min(x) - 1e-6) & (at <= max(x) + 1e-6)
    return ForceCurve(x, force, (at[seen], values[seen]) if seen.sum() > 1 else None)


def moment_curves(result: View, reference: View | None = None) -> Figure | None:
    """Moment of each gear, weld, guide and driver that has one, over the last crank turn; None without any."""
    most = {name: float(np.abs(_moment(result, name)[0]).max()) for name in joint_rows(result.record)}
    names = [name for name, size in most.items() if size > NOISE * max(most.values())][:MOST]
    return _figure(result, reference, names, (_moment, _moment_band), "moment", "N m", _titles(result))


def _titles(result: View) -> Callable[[str], str]:
    mechanism = result.record.assembly.mechanism

    def title(name: str) -> str:
        return ("joint " if name in mechanism.joints else "gear " if name in mechanism.gears else "driver ") + name

    return title


def acceleration_curves(result: View, reference: View | None = None) -> Figure | None:
    """Angular acceleration of each body that is not driven over the last crank turn, one panel a body, or None
    without any.

    The line joins the samples; the band reaches to the largest absolute value in each output interval, on the
    sample's side.
    """
    bodies = [body.name for body in result.record.assembly.bodies.values() if body.driven is None]
    names = [name for name in bodies if result.measures.get(f"{name}.angular_acceleration.max")]
    return _figure(result, reference, names[:MOST], (_acceleration, _acceleration_band), "angular acceleration", "rad/s²")


def _force(result: View, name: str) -> Series | None:
    return (_force_of(result, name), None) if name in joint_rows(result.record) else None


def _force_of(result: View, name: str) -> Array:
    channel = result.channels["joint_force" if result.record.static else "joint_force_max"]
    return channel.values[:, list(joint_rows(result.record)).index(name)]


def _force_band(result: View, name: str) -> tuple[Array, Array] | None:
    k = list(joint_rows(result.record)).index(name)
    return band(result.record, lambda record: joint_force_max(record)[:, k])


def _moment_band(result: View, name: str) -> tuple[Array, Array] | None:
    k = list(joint_rows(result.record)).index(name)
    return band(result.record, lambda record: joint_moment(record)[:, k])


def _acceleration_band(result: View, name: str) -> tuple[Array, Array] | None:
    row = result.record.assembly.bodies[name].row

    def extremes(record: Record) -> Array:
        sample = record.block("body_alpha")[:, row]
        return np.asarray(np.copysign(record.block("body_alpha_max")[:, row], sample), dtype=float)

    return band(result.record, extremes)


def _moment(result: View, name: str) -> Series:
    joints = list(joint_rows(result.record))
    values = result.channels["joint_moment"].values
    return values[:, joints.index(name)] if name in joints else np.zeros(len(values)), None


def _acceleration(result: View, name: str) -> Series | None:
    bodies = list(result.record.assembly.bodies)
    if name not in bodies:
        return None
    k = bodies.index(name)
    sample = result.channels["body_angular_acceleration"].values[:, k]
    return sample, np.copysign(result.channels["body_angular_acceleration_max"].values[:, k], sample)


def _figure(
    result: View, reference: View | None, names: Sequence[str], curves: tuple[Curve, Bands], what: str, unit: str, title: Callable[[str], str] = str
) -> Figure | None:
    if not names:
        return None
    curve, banded = curves
    columns = 2 if len(names) > 1 else 1
    rows = -(-len(names) // columns)
    figure, axes = panels(rows, columns, 5.2, 2.7 + 0.9 / rows, sharex=True)
    for k, (ax, name) in enumerate(zip(axes, names, strict=False)):
        found = curve(result, name)
        if found is not None:
            drawn = found, None if reference is None else curve(reference, name), banded(result, name)
            _panel(ax, result, reference, drawn, (what, unit))
            ax.set_title(title(name))
        if k >= len(names) - columns:
            ax.set_xlabel(axis_title(result))
            ax.tick_params(labelbottom=True)
    for ax in axes[len(names) :]:
        ax.set_visible(False)
    one_legend(figure, axes)
    turn = "" if result.crank is None or result.record.static or result.last_turn.all() else ", last turn"
    heading(figure, f"{result.name}: {what}{turn}")
    return figure


def _panel(
    ax: Axes,
    result: View,
    reference: View | None,
    curves: tuple[Series, Series | None, tuple[Array, Array] | None],
    quantity: tuple[str, str],
) -> None:
    (line, extreme), ideal, over = curves
    first = max(int(np.argmax(result.last_turn)) - 1, 0)  # the output at which the turn's first interval begins
    x, origin = one_turn(abscissa(result)[first:], result)
    line, extreme = line[first:], None if extreme is None else extreme[first:]
    factor, unit = scale_of(float(np.abs(line if extreme is None else extreme).max()), quantity[1])
    if ideal is not None and reference is not None:
        at, values = _ideal_turn(reference, ideal[0], x, origin)
        seen = (at >= min(x) - 1e-6) & (at <= max(x) + 1e-6)
        if seen.sum() > 1:  # a reference that turned elsewhere, as while it gathers speed, is none
            ax.plot(at[seen], factor * values[seen], color=VERMILION, lw=1.6, label="ideal joints", zorder=3)
    if extreme is not None:
        label = "extremes between the samples"
        ax.fill_between(x[1:], factor * line[1:], factor * extreme[1:], color=SKY, alpha=0.5, lw=0.0, label=label)
    if over is not None and len(over[0]) == len(x):
        ax.fill_between(x, factor * over[0], factor * over[1], color=ORANGE, alpha=0.55, lw=0.4, label="range of the companions", zorder=3.5)
    label = "with clearance" if ideal is not None else "this run"
    ax.plot(x, factor * line, color=BLUE, lw=1.1, label=label, zorder=4)
    ax.set_ylabel(f"{quantity[0]}\n({unit})")
    ax.margins(x=0.0)
    if result.crank is not None and not result.record.static and 300.0 < abs(x[-1] - x[0]) <= 361.0:
        ax.set_xticks(np.arange(np.ceil(min(x) / 60.0 - 1e-6) * 60.0, max(x) + 1e-6, 60.0))


def axis_title(result: View) -> str:
    """What curves are drawn over, with its unit."""
    if result.record.static:
        return "load factor"
    return "time (ms)" if result.crank is None else f"angle of {result.crank} (degrees)"


def abscissa(result: View) -> Array:
    """Crank angle (degrees), or time (ms) without a crank, at the outputs; load factors of a static analysis."""
    if result.record.static:
        return result.time
    return 1e3 * result.time if result.crank_angle is None else result.crank_angle


def one_turn(angle: Array, result: View) -> tuple[Array, float]:
    """Angles of a turn counted from the last whole turn before it, and that whole turn's angle; times as they are."""
    if result.crank is None or result.record.static:
        return angle, 0.0
    origin = 360.0 * np.floor(min(angle[0], angle[-1]) / 360.0 + 1e-6)
    return angle - origin, float(origin)


def _ideal_turn(reference: View, values: Array, x: Array, origin: float) -> tuple[Array, Array]:
    """The reference's curve over the same angles: its last turn, shifted by whole turns; times are compared as they
    are.
    """
    window = reference.last_turn
    at = abscissa(reference)[window]
    chosen = values[window]
    if reference.crank is None or abs(at[-1] - at[0]) < 300.0:
        return at - origin, chosen
    low = min(x[0], x[-1])
    at = low + np.mod(at - low - 1e-6, 360.0) + 1e-6
    order = np.argsort(at, kind="stable")
    at, chosen = at[order], chosen[order]
    return np.concatenate([[at[-1] - 360.0], at]), np.concatenate([chosen[-1:], chosen])
