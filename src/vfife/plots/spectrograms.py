"""Spectrograms and envelopes: what series are made of from moment to moment, and the size of what vibrates in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .curves import hardest, joint_forces
from .layout import Panels
from .spectra import DECADES, logarithmic, power_of_ten
from .style import BLUE, SKY, VERMILION, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.spectra import Envelope, Spectrogram, Spectrum, Transformed
    from ..results.view import View

Array = NDArray[np.float64]
MOST = 4  # panels of joint forces
CELLS = 1200  # of a picture in each direction; more are joined, the highest of them shown
LEAST = 64  # outputs that a run needs for them


def forces(result: View) -> list[str]:
    """Series of the forces of joints that carry the most."""
    if len(result.record.steps) <= LEAST:
        return []
    return [f"{name}.force" for name in hardest(result, joint_forces(result), MOST) if f"{name}.force" in result.series]


def spectrogram(result: View) -> Figure:
    """Spectrograms of the largest joint forces."""
    return spectrograms([result.spectrogram(name) for name in forces(result)], result)


def envelope(result: View) -> Figure:
    """Envelopes of the largest joint forces, and their spectra."""
    return envelopes([result.envelope(name) for name in forces(result)], result)


def spectrograms(every: Sequence[Spectrogram], result: View) -> Figure:
    """A panel each: time to the right, orders of the crank or frequencies upwards, amplitudes as colour."""
    panels = Panels([(5.2, 2.8) if len(every) > 1 else (8.0, 3.6)] * len(every), 2, across=1.75)
    for ax, found in zip(panels.axes, every, strict=True):
        size, (upwards, label) = shared(found.amplitudes), axis(found, result)
        factor, unit = scale_of(float(size.max()), found.unit)
        top = float(np.log10(max(factor * size.max(), 1e-300)))
        shown = np.log10(np.maximum(factor * size, 10.0 ** (top - DECADES)))
        seen = np.flatnonzero((shown > top - DECADES + 0.5).any(axis=0))
        last = min(int(seen[-1]) + 2, shown.shape[1]) if len(seen) else shown.shape[1]
        x, y = 1e3 * edges(found.times, len(shown)), edges(upwards, shown.shape[1])[: last + 1]
        drawn = ax.pcolormesh(x, y, shown[:, :last].T, cmap="cividis", rasterized=True)
        ax.grid(visible=False)
        ax.set(title=found.name, xlabel="time (ms)", ylabel=label, ylim=(0.0, y[-1]))
        bar = panels.scale(ax, drawn, f"amplitude ({unit})")
        powers = range(int(np.ceil(shown[:, :last].min())), int(np.floor(top)) + 1)
        bar.set_ticks(list(powers), labels=[power_of_ten(power) for power in powers])
    return panels.close(f"{result.name}: {every[0].words}")


def axis(found: Transformed, result: View) -> tuple[Array, str]:
    """Places on the axis of orders, or of frequencies where nothing turns evenly, and what it is called."""
    if found.turn is None:
        return found.frequencies, "frequency (Hz)"
    return found.orders, f"order of {result.crank} ({1.0 / found.turn:.4g} Hz each)"


def shared(size: Array) -> Array:
    """Amplitudes in no more cells than a picture can show, of those that are joined the highest."""
    for axis in (0, 1):
        many = -(-size.shape[axis] // CELLS)
        if many > 1:
            size = np.maximum.reduceat(size, np.arange(0, size.shape[axis], many), axis=axis)
    return size


def edges(middles: Array, count: int) -> Array:
    """Edges of so many even cells around places at even distances."""
    half = 0.5 * (middles[1] - middles[0]) if len(middles) > 1 else 0.5
    return np.linspace(middles[0] - half, middles[-1] + half, count + 1)


def envelopes(every: Sequence[Envelope], result: View) -> Figure:
    """A row each: what vibrates within its envelope, and the spectrum of the envelope."""
    panels = Panels([(5.6, 2.1), (3.4, 2.1)] * len(every), 2)
    for k, found in enumerate(every):
        ax, beside = panels.axes[2 * k], panels.axes[2 * k + 1]
        factor, unit = scale_of(float(found.values.max()), found.unit)
        band: dict[str, Any] = {"lw": 0.5, "rasterized": True}
        ax.plot(1e3 * found.times, factor * found.filtered, color=SKY, label="what vibrates", **band)
        ax.plot(1e3 * found.times, factor * found.values, color=VERMILION, lw=0.9, label="its envelope")
        ax.set(title=found.name, ylabel=f"{unit}, without the mean")
        ax.margins(x=0.0)
        amplitudes(beside, found.spectrum, result)
        beside.set_title("spectrum of the envelope")
        if k == len(every) - 1:
            ax.set_xlabel("time (ms)")
        else:
            beside.set_xlabel("")
    return panels.close(f"{result.name}: {every[0].words}")


def spectrums(every: Sequence[Spectrum], result: View) -> Figure:
    """A panel each: amplitudes over orders or frequencies."""
    panels = Panels([(4.6, 2.2) if len(every) > 1 else (8.0, 2.9)] * len(every), 2)
    for ax, found in zip(panels.axes, every, strict=True):
        amplitudes(ax, found, result)
        ax.set_title(found.name)
    return panels.close(f"{result.name}: {every[0].words}")


def amplitudes(ax: Axes, found: Spectrum, result: View) -> None:
    """A curve of amplitudes, as far as there are any."""
    top = float(found.amplitudes.max())
    factor, unit = scale_of(top, found.unit)
    over, label = axis(found, result)
    ax.plot(over, factor * found.amplitudes, color=BLUE, lw=0.9)
    above = np.flatnonzero(found.amplitudes > top * 10.0**-DECADES)
    if top > 0.0:
        logarithmic(ax, 2.0 * factor * top)
    ax.set(xlabel=label, ylabel=f"amplitude ({unit})")
    ax.set_xlim(0.0, over[min(int(1.05 * (above[-1] if len(above) else len(over))) + 2, len(over) - 1)])
