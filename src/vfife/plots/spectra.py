"""What joint forces are made of: amplitudes over orders of the crank or frequencies, of the last turns, and turn by turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..solvers.repeating import outputs_of_a_turn
from .curves import Quantity, hardest, joint_forces
from .layout import Panels
from .style import BLUE, RAISED, VERMILION, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
Places = NDArray[np.int64]
MOST = 6  # panels
TURNS = 4  # the latest ones, over which a spectrum is the root of the mean square
PIECES, LEAST = 15, 256  # pieces of a run without turns, and outputs that it needs for them
FEW = 3  # turns that a waterfall needs
DECADES = 5.0  # below the largest amplitude


def amplitudes(values: Array, repeats: bool) -> Array:
    """Amplitudes of series, shape (.., n), at 0, 1, .. n/2 waves in it; weighted by Hann's window where it does not repeat itself."""
    count = values.shape[-1]
    weight = np.ones(count) if repeats else 1.0 - np.cos(2.0 * np.pi * np.arange(count) / count)
    found = np.abs(np.fft.rfft(values * weight, axis=-1)) / count
    found[..., 1 : (count + 1) // 2] *= 2.0
    return np.asarray(found, dtype=float)


def pieces(result: View) -> tuple[Places, int, bool] | None:
    """First outputs of whole turns, or of overlapping parts of a run without; outputs in each, and whether they are turns; None where too few."""
    outputs, count = outputs_of_a_turn(result.record.assembly), len(result.record.steps) - 1
    if result.record.static or count < 16:
        return None
    if outputs is not None and result.crank is not None and count >= outputs:
        return np.arange(count % outputs, count - outputs + 1, outputs), outputs, True
    if count < LEAST:
        return np.array([0]), count, False
    long = 2 * (count // (PIECES + 1))
    return np.arange(PIECES) * (long // 2), long, False


@dataclass(frozen=True)
class Found:
    """Places on the axis, orders or frequencies (Hz), and amplitudes of each piece, shape (pieces, places)."""

    over: Array
    each: Array


def found(result: View, one: Quantity, starts: Places, count: int, orders: bool) -> Found:
    """Amplitudes of a quantity in pieces of so many outputs; ``orders``: of turns, which repeat themselves."""
    values = one.samples(result.record)
    cut = np.stack([values[int(k) + 1 : int(k) + count + 1] for k in starts])
    over = np.arange(count // 2 + 1) / (1.0 if orders else count * spacing(result))
    return Found(np.asarray(over, dtype=float), amplitudes(cut, orders))


def spacing(result: View) -> float:
    """Time between two outputs (s)."""
    return float(result.record.steps[1] - result.record.steps[0]) * result.record.assembly.choice.step


def _latest(result: View, one: Quantity, orders: bool) -> Found:
    """The root of the mean square of the latest turns, or of a whole run without any; of a reference, which turns, at frequencies too."""
    starts, count, turning = pieces(result) or (np.array([0]), 1, False)
    if not turning:
        starts, count = np.array([0]), len(result.record.steps) - 1
    every = found(result, one, starts[-TURNS:], count, turning)
    over = every.over if orders or not turning else every.over / (count * spacing(result))
    return Found(over, np.sqrt(np.mean(every.each**2, axis=0)))


def spectrum(result: View, reference: View | None = None) -> Figure:
    """Amplitudes of the size of each joint's force, of the last turns or of the whole run, on logarithmic scales."""
    chosen = list(hardest(result, joint_forces(result), MOST).values())
    panels = Panels([(4.6, 2.2) if len(chosen) > 1 else (8.0, 2.9)] * len(chosen), 2)
    starts, _, turning = pieces(result) or (np.array([0]), 1, False)
    for k, (ax, one) in enumerate(zip(panels.axes, chosen, strict=True)):
        own = _latest(result, one, turning)
        top = float(own.each.max())
        factor, unit = scale_of(top, one.unit)
        if reference is not None and pieces(reference) is not None:
            ideal = _latest(reference, one, turning)
            ax.plot(ideal.over, factor * ideal.each, color=VERMILION, lw=1.2, ls=(0, (5, 1.6)), label="ideal joints")
        ax.plot(own.over, factor * own.each, color=BLUE, lw=0.9, label="this run", zorder=3)
        above = int(np.flatnonzero(own.each > top * 10.0**-DECADES)[-1])
        logarithmic(ax, 2.0 * factor * top)
        ax.set(xlim=(0.0, own.over[min(int(1.05 * above) + 2, len(own.over) - 1)]), title=one.title, ylabel=f"amplitude ({unit})")
        if k in panels.lowest:
            ax.set_xlabel(f"order of {result.crank}" if turning else "frequency (Hz)")
    many = min(TURNS, len(starts))
    part = "whole run" if not turning else f"last {many} turns" if many > 1 else "last turn"
    return panels.close(f"{result.name}: spectra of joint forces, {part}")


def logarithmic(ax: Axes, top: float) -> None:
    """A logarithmic axis of so many decades, ticks at powers of ten."""
    ax.set_yscale("log")
    ax.set_ylim(top * 10.0**-DECADES, top)
    powers = range(int(np.ceil(np.log10(top) - DECADES)), int(np.floor(np.log10(top))) + 1)
    ax.set_yticks([10.0**power for power in powers], labels=[power_of_ten(power) for power in powers])
    ax.minorticks_off()


def waterfall(result: View) -> Figure:
    """The same of every turn, or of parts of a run without turns, as colour: from bottom to top as time goes on."""
    chosen = list(hardest(result, joint_forces(result), MOST).values())
    panels = Panels([(4.4, 2.6) if len(chosen) > 1 else (7.4, 3.4)] * len(chosen), 2, across=1.75)
    starts, count, turning = pieces(result) or (np.array([0]), 1, False)
    edges = np.arange(len(starts) + 1) + 0.5
    if not turning:
        edges = 1e3 * spacing(result) * (np.append(starts, 2 * starts[-1] - starts[-2]) + 0.25 * count)  # pieces overlap by half
    for ax, one in zip(panels.axes, chosen, strict=True):
        every = found(result, one, starts, count, turning)
        factor, unit = scale_of(float(every.each.max()), one.unit)
        top = float(np.log10(factor * every.each.max()))
        shown = np.log10(np.maximum(factor * every.each, 10.0 ** (top - DECADES)))
        last = min(int(np.flatnonzero((shown > top - DECADES + 0.3).any(axis=0))[-1]) + 2, len(every.over))
        half, over = 0.5 * every.over[1], every.over[:last]
        drawn = ax.pcolormesh(np.append(over - half, over[-1] + half), edges, shown[:, :last], cmap="cividis", rasterized=True)
        ax.grid(visible=False)
        ax.set(title=one.title, ylabel="turn" if turning else "time (ms)", xlabel=f"order of {result.crank}" if turning else "frequency (Hz)")
        ax.set_xlim(left=0.0)
        bar = panels.scale(ax, drawn, f"amplitude ({unit})")
        powers = range(int(np.ceil(shown[:, :last].min())), int(np.floor(top)) + 1)
        bar.set_ticks(list(powers), labels=[power_of_ten(power) for power in powers])
    return panels.close(f"{result.name}: joint forces in time and frequency")


def power_of_ten(power: int) -> str:
    """A power of ten as it is written."""
    return {0: "1", 1: "10", -1: "0.1"}.get(power, f"10{str(power).translate(RAISED)}")
