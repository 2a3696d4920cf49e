"""Spectra of forces and other series: over orders or frequencies, turn by turn, in time, over a parameter of
the model; envelopes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray

from ..measures.spectral import frequencies_of, short_time
from ..solvers.repeating import outputs_of_a_turn
from .curves import Quantity, largest_forces
from .layout import Panels
from .style import BLUE, FAINT, IDEAL, RPM, SKY, STYLE, VERMILION, power_of_ten, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..dynamics.waterfall import Waterfall
    from ..results.run_data import RunData
    from ..results.spectra import Envelope, Spectrogram, Spectrum, Transformed

Array = NDArray[np.float64]
Places = NDArray[np.int64]
MOST_PANELS, MOST_IN_TIME = 6, 4  # panels of spectra, of spectrograms and envelopes
PANEL, ALONE = (4.6, 2.2), (8.0, 2.9)  # inches of a panel of spectra
TURNS = 4  # the latest ones, over which a spectrum is the root of the mean square
PIECES, LEAST_OUTPUTS = 15, 256  # pieces of a run without turns, and its least number of outputs
WATERFALL_TURNS = 3  # turns that a waterfall needs
SAMPLES = 64  # outputs that a spectrogram needs
DECADES = 5.0  # below the largest amplitude
COLOURED = 3.5  # decades below the largest amplitude that colours show
CELLS = 1200  # of a picture in each direction; more are joined, showing the highest


# -------------------------------------------------------------------------------------- joint forces of a run


class Pieces(NamedTuple):
    """First output of each piece, number of outputs of a piece, and whether pieces are turns."""

    starts: Places
    outputs: int
    turns: bool


ONE_PIECE = Pieces(np.array([0]), 1, False)


@dataclass(frozen=True)
class PieceSpectra:
    """Orders or frequencies (Hz), and amplitudes of each piece, shape (pieces, orders)."""

    over: Array
    each: Array


def pieces(result: RunData) -> Pieces | None:
    """Return the whole turns of a run, or overlapping pieces of a run without turns; None where there are too
    few outputs.
    """
    outputs, count = outputs_of_a_turn(result.record.assembly), len(result.record.steps) - 1
    if result.record.static or count < 16:
        return None
    if outputs is not None and result.crank is not None and count >= outputs:
        return Pieces(np.arange(count % outputs, count - outputs + 1, outputs), outputs, True)
    if count < LEAST_OUTPUTS:
        return Pieces(np.array([0]), count, False)
    long = 2 * (count // (PIECES + 1))
    return Pieces(np.arange(PIECES) * (long // 2), long, False)


def spectra_of(result: RunData, one: Quantity, starts: Places, count: int, orders: bool) -> PieceSpectra:
    """Return the amplitudes of a quantity in pieces of ``count`` outputs, through Hann's window unless they
    are turns, which repeat (``orders``).
    """
    over = frequencies_of(count, 1.0 / count if orders else spacing(result))
    return PieceSpectra(
        over, short_time(one.samples(result.record), starts + 1, "rectangular" if orders else "hann", count)
    )


def spacing(result: RunData) -> float:
    """Return the time between two outputs (s)."""
    return float(result.record.steps[1] - result.record.steps[0]) * result.record.assembly.choice.step


def latest(result: RunData, one: Quantity, orders: bool = True) -> tuple[bool, PieceSpectra]:
    """Return the root mean square of the latest turns, or of a whole run without any, and whether there are
    turns; over ``orders``, else over frequencies.
    """
    starts, count, turning = pieces(result) or ONE_PIECE
    if not turning:
        starts, count = np.array([0]), len(result.record.steps) - 1
    every = spectra_of(result, one, starts[-TURNS:], count, turning)
    over = every.over if orders or not turning else every.over / (count * spacing(result))
    return turning, PieceSpectra(over, np.sqrt(np.mean(every.each**2, axis=0)))


def spectrum(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of amplitudes of the size of each joint's force, of the last turns or of the whole run,
    on logarithmic scales.
    """
    chosen = list(largest_forces(result, MOST_PANELS).values())
    panels = Panels.alike(len(chosen), 2, PANEL, ALONE)
    starts, _, turning = pieces(result) or ONE_PIECE
    for ax, one in zip(panels.axes, chosen, strict=True):
        _, own = latest(result, one)
        factor = amplitude_curve(ax, own.over, own.each, one.unit, label="this run")
        if reference is not None and pieces(reference) is not None:
            _, ideal = latest(reference, one, turning)
            ax.plot(ideal.over, factor * ideal.each, **IDEAL)
        ax.set_title(one.title)
    panels.label_lowest(order_or_frequency(result, turning))
    many = min(TURNS, len(starts))
    part = "whole run" if not turning else f"last {many} turns" if many > 1 else "last turn"
    return panels.close(f"{result.name}: spectra of joint forces, {part}")


def order_or_frequency(result: RunData, turning: bool) -> str:
    """Return the label of the abscissa of a spectrum."""
    return f"order of {result.crank}" if turning else "frequency (Hz)"


def waterfall(result: RunData) -> Figure:
    """Return a figure of spectra of every turn, or piece of a run without turns, as colours: from bottom to
    top in time.
    """
    chosen = list(largest_forces(result, MOST_PANELS).values())
    panels = Panels.alike(len(chosen), 2, (4.4, 2.6), (7.4, 3.4), across=1.75)
    starts, count, turning = pieces(result) or ONE_PIECE
    times = np.arange(len(starts) + 1, dtype=float) + 0.5
    if not turning:  # pieces overlap by half
        ends = np.append(starts, 2 * starts[-1] - starts[-2]).astype(float)
        times = 1e3 * spacing(result) * (ends + 0.25 * count)
    for ax, one in zip(panels.axes, chosen, strict=True):
        every = spectra_of(result, one, starts, count, turning)
        shown, unit = logarithms(every.each, one.unit)
        last = visible_count(shown)
        coloured(panels, ax, edges(every.over, len(every.over))[: last + 1], times, shown[:, :last], unit)
        ax.set(
            title=one.title,
            ylabel="turn" if turning else "time (ms)",
            xlabel=order_or_frequency(result, turning),
        )
        ax.set_xlim(left=0.0)
    return panels.close(f"{result.name}: joint forces in time and frequency")


def forces(result: RunData) -> list[str]:
    """Return the series of the forces of joints that carry the most."""
    if len(result.record.steps) <= SAMPLES:
        return []
    return [
        f"{name}.force" for name in largest_forces(result, MOST_IN_TIME) if f"{name}.force" in result.series
    ]


def spectrogram(result: RunData) -> Figure:
    """Return a figure of the spectrograms of the largest joint forces."""
    return spectrograms([result.spectrogram(name) for name in forces(result)], result)


def envelope(result: RunData) -> Figure:
    """Return a figure of envelopes of the largest joint forces, and their spectra."""
    return envelopes([result.envelope(name) for name in forces(result)], result)


# ------------------------------------------------------------------------------------------------- any series


@rc_context(STYLE)
def spectrograms(every: Sequence[Spectrogram], result: RunData) -> Figure:
    """Return a figure with a panel for each series: time to the right, orders of the crank or frequencies
    upwards, amplitudes as colours.
    """
    panels = Panels.alike(len(every), 2, (5.2, 2.8), (8.0, 3.6), across=1.75)
    for ax, one in zip(panels.axes, every, strict=True):
        size, (upwards, label) = joined(one.amplitudes), axis(one, result)
        shown, unit = logarithms(size, one.unit)
        last = visible_count(shown)
        y = edges(upwards, shown.shape[1])[: last + 1]
        coloured(panels, ax, 1e3 * edges(one.times, len(shown)), y, shown[:, :last].T, unit)
        ax.set(title=one.name, xlabel="time (ms)", ylabel=label, ylim=(0.0, y[-1]))
    return panels.close(f"{result.name}: {every[0].words}")


@rc_context(STYLE)
def envelopes(every: Sequence[Envelope], result: RunData) -> Figure:
    """Return a figure with a row for each series: its vibration within its envelope, and the spectrum of the
    envelope.
    """
    panels = Panels([(5.6, 2.1), (3.4, 2.1)] * len(every), 2)
    for k, one in enumerate(every):
        ax, right = panels.axes[2 * k], panels.axes[2 * k + 1]
        factor, unit = scale_of(float(one.values.max()), one.unit)
        ax.plot(
            1e3 * one.times, factor * one.filtered, color=SKY, lw=0.5, rasterized=True, label="what vibrates"
        )
        ax.plot(1e3 * one.times, factor * one.values, color=VERMILION, lw=0.9, label="its envelope")
        ax.set(title=one.name, ylabel=f"{unit}, without the mean")
        ax.margins(x=0.0)
        amplitudes(right, one.spectrum, result)
        right.set_title("spectrum of the envelope")
        if k == len(every) - 1:
            ax.set_xlabel("time (ms)")
        else:
            right.set_xlabel("")
    return panels.close(f"{result.name}: {every[0].words}")


@rc_context(STYLE)
def spectrums(every: Sequence[Spectrum], result: RunData) -> Figure:
    """Return a figure with a panel for each series: amplitudes over orders or frequencies."""
    panels = Panels.alike(len(every), 2, PANEL, ALONE)
    for ax, one in zip(panels.axes, every, strict=True):
        amplitudes(ax, one, result)
        ax.set_title(one.name)
    return panels.close(f"{result.name}: {every[0].words}")


@dataclass(frozen=True)
class Subject:
    """The subject of a figure of a transformed series without its run."""

    name: str
    crank: str = "the crank"


def figure_of(one: Transformed | Envelope) -> Figure:
    """Return the figure of one spectrum, spectrogram or envelope."""
    figures = {"Spectrum": spectrums, "Spectrogram": spectrograms, "Envelope": envelopes}
    draw: Any = figures[type(one).__name__]
    figure: Figure = draw([one], Subject(one.name))
    return figure


def amplitudes(ax: Axes, one: Spectrum, result: RunData) -> None:
    """Draw the curve of visible amplitudes."""
    over, label = axis(one, result)
    amplitude_curve(ax, over, one.amplitudes, one.unit)
    ax.set_xlabel(label)


def axis(one: Transformed, result: RunData) -> tuple[Array, str]:
    """Return the orders, or frequencies where nothing turns evenly, and the label of their axis."""
    if one.turn is None:
        return one.frequencies, "frequency (Hz)"
    return one.orders, f"order of {result.crank} ({1.0 / one.turn:.4g} Hz each)"


# ---------------------------------------------------------------------- amplitudes over a number of the model


@rc_context(STYLE)
def over_values(one: Waterfall, hertz: bool = False) -> Figure:
    """Return a figure with a panel for each series: orders or frequencies (``hertz``) to the right, the
    parameter upwards; missing and diverged values are grey.
    """
    spec, unit = one.spec, one.spec.unit
    panels = Panels.alike(len(spec.series), 2, (5.2, 3.4), (8.0, 4.4), across=1.85)
    factor, unit = (RPM, "rpm") if unit == "rad/s" else scale_of(float(np.abs(spec.values).max()), unit)
    y = edges(factor * np.array(spec.values), len(spec.values))
    for ax, name, unit_of in zip(panels.axes, spec.series, spec.units, strict=True):
        shown, of = logarithms(one.amplitudes[name], unit_of)
        ax.set_facecolor(FAINT)
        coloured(
            panels,
            ax,
            cell_edges(one, hertz),
            np.repeat(y[:, None], shown.shape[1] + 1, axis=1),
            np.ma.masked_invalid(shown),
            of,
        )
        ax.set(
            title=name,
            ylabel=f"{spec.path} ({unit})",
            xlabel="frequency (Hz)" if hertz else "order of the crank",
        )
        ax.set_xlim(left=0.0)
    return panels.close(f"{one.name}: {one.words}; {one.limits}; no companions")


def cell_edges(one: Waterfall, hertz: bool) -> Array:
    """Return the edges of cells from left to right, shape (values + 1, orders + 1); frequencies fan out with
    the speed.
    """
    places = np.append(one.orders, 2.0 * one.orders[-1] - one.orders[-2]) - 0.5 * one.orders[1]
    rate = 1.0 / one.turn if hertz else np.ones(len(one.turn))
    rate = np.concatenate([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
    return np.asarray(np.maximum(places, 0.0) * rate[:, None], dtype=float)


# ----------------------------------------------------------------------------------------------------- scales


def amplitude_curve(ax: Axes, over: Array, values: Array, unit: str, **look: Any) -> float:
    """Draw amplitudes on a logarithmic scale; return the factor of their unit."""
    factor, unit = scale_of(float(values.max()), unit)
    ax.plot(over, factor * values, color=BLUE, lw=0.9, zorder=3, **look)
    ax.set_ylabel(f"amplitude ({unit})")
    logarithmic_axis(ax, over, factor * values)
    return factor


def logarithmic_axis(ax: Axes, over: Array, values: Array) -> None:
    """Scale axes to ``DECADES`` below the largest amplitude, and to the last one that is seen."""
    top = float(values.max())
    visible = np.flatnonzero(values > top * 10.0**-DECADES)
    if top > 0.0:
        highest = 2.0 * top
        ax.set_yscale("log")
        ax.set_ylim(highest * 10.0**-DECADES, highest)
        powers = range(int(np.ceil(np.log10(highest) - DECADES)), int(np.floor(np.log10(highest))) + 1)
        ax.set_yticks([10.0**power for power in powers], labels=[power_of_ten(power) for power in powers])
        ax.minorticks_off()
    ax.set_xlim(0.0, over[min(int(1.05 * (visible[-1] if len(visible) else len(over))) + 2, len(over) - 1)])


def logarithms(size: Array, unit: str) -> tuple[Array, str]:
    """Return the logarithms of amplitudes in a unit that reads well, over ``DECADES``, and the unit."""
    most = float(np.nanmax(size, initial=0.0))
    factor, unit = scale_of(most, unit)
    top = np.log10(max(factor * most, 1e-300))
    return np.log10(np.maximum(factor * size, 10.0 ** (top - DECADES))), unit


def visible_count(shown: Array) -> int:
    """Return the number of orders up to the last visible one."""
    visible, count = np.flatnonzero((shown > shown.max() - DECADES + 0.5).any(axis=0)), int(shown.shape[1])
    return min(int(visible[-1]) + 2, count) if len(visible) else count


def coloured(panels: Panels, ax: Axes, x: Array, y: Array, shown: Array, unit: str) -> None:
    """Draw logarithms of amplitudes as colours, with a scale in powers of ten over ``COLOURED`` decades."""
    some = shown.count() if isinstance(shown, np.ma.MaskedArray) else shown.size
    high = float(shown.max()) if some else 0.0
    drawn = ax.pcolormesh(x, y, shown, cmap="magma", vmin=high - COLOURED, vmax=high, rasterized=True)
    bar = panels.scale(ax, drawn, f"amplitude ({unit})")
    ax.grid(visible=False)
    if some:
        powers = list(range(int(np.ceil(high - COLOURED)), int(np.floor(high)) + 1))
        bar.set_ticks(powers, labels=[power_of_ten(power) for power in powers])


def joined(size: Array) -> Array:
    """Return the amplitudes joined into at most ``CELLS`` cells, each the highest of its amplitudes."""
    for axis in (0, 1):
        many = -(-size.shape[axis] // CELLS)
        if many > 1:
            size = np.maximum.reduceat(size, np.arange(0, size.shape[axis], many), axis=axis)
    return size


def edges(middles: Array, count: int) -> Array:
    """Return the edges of ``count`` even cells around evenly spaced places."""
    half = 0.5 * (middles[1] - middles[0]) if len(middles) > 1 else 0.5
    return np.linspace(middles[0] - half, middles[-1] + half, count + 1)
