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
from .style import BLUE, FAINT, IDEAL, RPM, SKY, STYLE, VERMILION, Array, power_of_ten, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..dynamics.waterfall import Waterfall
    from ..results.run_data import RunData
    from ..results.spectra import Envelope, Spectrogram, Spectrum, Transformed

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

    abscissa: Array
    amplitudes: Array


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


def spectra_of(result: RunData, quantity: Quantity, starts: Places, count: int, orders: bool) -> PieceSpectra:
    """Return the amplitudes of a quantity in pieces of ``count`` outputs, through Hann's window unless they
    are turns, which repeat (``orders``).
    """
    abscissa = frequencies_of(count, 1.0 / count if orders else spacing(result))
    return PieceSpectra(
        abscissa,
        short_time(quantity.samples(result.record), starts + 1, "rectangular" if orders else "hann", count),
    )


def spacing(result: RunData) -> float:
    """Return the time between two outputs (s)."""
    return float(result.record.steps[1] - result.record.steps[0]) * result.record.assembly.choice.step


def latest_spectra(result: RunData, quantity: Quantity, orders: bool = True) -> tuple[bool, PieceSpectra]:
    """Return the root mean square of the latest turns, or of a whole run without any, and whether there are
    turns; over ``orders``, else over frequencies.
    """
    starts, count, turning = pieces(result) or ONE_PIECE
    if not turning:
        starts, count = np.array([0]), len(result.record.steps) - 1
    spectra = spectra_of(result, quantity, starts[-TURNS:], count, turning)
    abscissa = spectra.abscissa if orders or not turning else spectra.abscissa / (count * spacing(result))
    return turning, PieceSpectra(abscissa, np.sqrt(np.mean(spectra.amplitudes**2, axis=0)))


def spectrum(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of amplitudes of the size of each joint's force, of the last turns or of the whole run,
    on logarithmic scales.
    """
    chosen = list(largest_forces(result, MOST_PANELS).values())
    panels = Panels.alike(len(chosen), 2, PANEL, ALONE)
    starts, _, turning = pieces(result) or ONE_PIECE
    for ax, force in zip(panels.axes, chosen, strict=True):
        _, spectra = latest_spectra(result, force)
        factor = amplitude_curve(ax, spectra.abscissa, spectra.amplitudes, force.unit, label="this run")
        if reference is not None and pieces(reference) is not None:
            _, ideal = latest_spectra(reference, force, turning)
            ax.plot(ideal.abscissa, factor * ideal.amplitudes, **IDEAL)
        ax.set_title(force.title)
    panels.label_lowest(order_or_frequency(result, turning))
    count = min(TURNS, len(starts))
    part = "whole run" if not turning else f"last {count} turns" if count > 1 else "last turn"
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
    for ax, force in zip(panels.axes, chosen, strict=True):
        spectra = spectra_of(result, force, starts, count, turning)
        shown, unit = logarithms(spectra.amplitudes, force.unit)
        last = visible_count(shown)
        draw_colours(
            panels,
            ax,
            edges(spectra.abscissa, len(spectra.abscissa))[: last + 1],
            times,
            shown[:, :last],
            unit,
        )
        ax.set(
            title=force.title,
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
def spectrograms(series: Sequence[Spectrogram], result: RunData) -> Figure:
    """Return a figure with a panel for each series: time to the right, orders of the crank or frequencies
    upwards, amplitudes as colours.
    """
    panels = Panels.alike(len(series), 2, (5.2, 2.8), (8.0, 3.6), across=1.75)
    for ax, spectrogram in zip(panels.axes, series, strict=True):
        size, (upwards, label) = join_cells(spectrogram.amplitudes), axis(spectrogram, result)
        shown, unit = logarithms(size, spectrogram.unit)
        last = visible_count(shown)
        y = edges(upwards, shown.shape[1])[: last + 1]
        draw_colours(panels, ax, 1e3 * edges(spectrogram.times, len(shown)), y, shown[:, :last].T, unit)
        ax.set(title=spectrogram.name, xlabel="time (ms)", ylabel=label, ylim=(0.0, y[-1]))
    return panels.close(f"{result.name}: {series[0].words}")


@rc_context(STYLE)
def envelopes(series: Sequence[Envelope], result: RunData) -> Figure:
    """Return a figure with a row for each series: its vibration within its envelope, and the spectrum of the
    envelope.
    """
    panels = Panels([(5.6, 2.1), (3.4, 2.1)] * len(series), 2)
    for k, envelope in enumerate(series):
        ax, right = panels.axes[2 * k], panels.axes[2 * k + 1]
        factor, unit = scale_of(float(envelope.values.max()), envelope.unit)
        ax.plot(
            1e3 * envelope.times,
            factor * envelope.filtered,
            color=SKY,
            lw=0.5,
            rasterized=True,
            label="what vibrates",
        )
        ax.plot(1e3 * envelope.times, factor * envelope.values, color=VERMILION, lw=0.9, label="its envelope")
        ax.set(title=envelope.name, ylabel=f"{unit}, without the mean")
        ax.margins(x=0.0)
        amplitudes(right, envelope.spectrum, result)
        right.set_title("spectrum of the envelope")
        if k == len(series) - 1:
            ax.set_xlabel("time (ms)")
        else:
            right.set_xlabel("")
    return panels.close(f"{result.name}: {series[0].words}")


@rc_context(STYLE)
def spectrums(series: Sequence[Spectrum], result: RunData) -> Figure:
    """Return a figure with a panel for each series: amplitudes over orders or frequencies."""
    panels = Panels.alike(len(series), 2, PANEL, ALONE)
    for ax, spectrum in zip(panels.axes, series, strict=True):
        amplitudes(ax, spectrum, result)
        ax.set_title(spectrum.name)
    return panels.close(f"{result.name}: {series[0].words}")


@dataclass(frozen=True)
class Subject:
    """The subject of a figure of a transformed series without its run."""

    name: str
    crank: str = "the crank"


def figure_of(series: Transformed | Envelope) -> Figure:
    """Return the figure of one spectrum, spectrogram or envelope."""
    figures = {"Spectrum": spectrums, "Spectrogram": spectrograms, "Envelope": envelopes}
    draw: Any = figures[type(series).__name__]
    figure: Figure = draw([series], Subject(series.name))
    return figure


def amplitudes(ax: Axes, series: Spectrum, result: RunData) -> None:
    """Draw the curve of visible amplitudes."""
    abscissa, label = axis(series, result)
    amplitude_curve(ax, abscissa, series.amplitudes, series.unit)
    ax.set_xlabel(label)


def axis(series: Transformed, result: RunData) -> tuple[Array, str]:
    """Return the orders, or frequencies where nothing turns evenly, and the label of their axis."""
    if series.turn is None:
        return series.frequencies, "frequency (Hz)"
    return series.orders, f"order of {result.crank} ({1.0 / series.turn:.4g} Hz each)"


# ---------------------------------------------------------------------- amplitudes over a number of the model


@rc_context(STYLE)
def over_values(sweep: Waterfall, hertz: bool = False) -> Figure:
    """Return a figure with a panel for each series: orders or frequencies (``hertz``) to the right, the
    parameter upwards; missing and diverged values are grey.
    """
    spec, unit = sweep.spec, sweep.spec.unit
    panels = Panels.alike(len(spec.series), 2, (5.2, 3.4), (8.0, 4.4), across=1.85)
    factor, unit = (RPM, "rpm") if unit == "rad/s" else scale_of(float(np.abs(spec.values).max()), unit)
    y = edges(factor * np.array(spec.values), len(spec.values))
    for ax, name, unit_of in zip(panels.axes, spec.series, spec.units, strict=True):
        shown, of = logarithms(sweep.amplitudes[name], unit_of)
        ax.set_facecolor(FAINT)
        draw_colours(
            panels,
            ax,
            cell_edges(sweep, hertz),
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
    part = f"not complete, {sweep.progress}; " if sweep.progress else ""
    return panels.close(f"{part}{sweep.name}: {sweep.words}; {sweep.limits}; errors not estimated")


def cell_edges(sweep: Waterfall, hertz: bool) -> Array:
    """Return the edges of cells from left to right, shape (values + 1, orders + 1); frequencies fan out with
    the speed.
    """
    places = np.append(sweep.orders, 2.0 * sweep.orders[-1] - sweep.orders[-2]) - 0.5 * sweep.orders[1]
    rate = 1.0 / sweep.turn if hertz else np.ones(len(sweep.turn))
    rate = np.concatenate([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
    return np.asarray(np.maximum(places, 0.0) * rate[:, None], dtype=float)


# ----------------------------------------------------------------------------------------------------- scales


def amplitude_curve(ax: Axes, abscissa: Array, values: Array, unit: str, **look: Any) -> float:
    """Draw amplitudes on a logarithmic scale; return the factor of their unit."""
    factor, unit = scale_of(float(values.max()), unit)
    ax.plot(abscissa, factor * values, color=BLUE, lw=0.9, zorder=3, **look)
    ax.set_ylabel(f"amplitude ({unit})")
    logarithmic_axis(ax, abscissa, factor * values)
    return factor


def logarithmic_axis(ax: Axes, abscissa: Array, values: Array) -> None:
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
    ax.set_xlim(
        0.0,
        abscissa[min(int(1.05 * (visible[-1] if len(visible) else len(abscissa))) + 2, len(abscissa) - 1)],
    )


def logarithms(size: Array, unit: str) -> tuple[Array, str]:
    """Return the logarithms of amplitudes in a unit that reads well, over ``DECADES``, and the unit."""
    largest = float(np.nanmax(size, initial=0.0))
    factor, unit = scale_of(largest, unit)
    top = np.log10(max(factor * largest, 1e-300))
    return np.log10(np.maximum(factor * size, 10.0 ** (top - DECADES))), unit


def visible_count(shown: Array) -> int:
    """Return the number of orders up to the last visible one."""
    visible, count = np.flatnonzero((shown > shown.max() - DECADES + 0.5).any(axis=0)), int(shown.shape[1])
    return min(int(visible[-1]) + 2, count) if len(visible) else count


def draw_colours(panels: Panels, ax: Axes, x: Array, y: Array, shown: Array, unit: str) -> None:
    """Draw logarithms of amplitudes as colours, with a scale in powers of ten over ``COLOURED`` decades."""
    count = shown.count() if isinstance(shown, np.ma.MaskedArray) else shown.size
    high = float(shown.max()) if count else 0.0
    drawn = ax.pcolormesh(x, y, shown, cmap="magma", vmin=high - COLOURED, vmax=high, rasterized=True)
    bar = panels.scale(ax, drawn, f"amplitude ({unit})")
    ax.grid(visible=False)
    if count:
        powers = list(range(int(np.ceil(high - COLOURED)), int(np.floor(high)) + 1))
        bar.set_ticks(powers, labels=[power_of_ten(power) for power in powers])


def join_cells(size: Array) -> Array:
    """Return the amplitudes joined into at most ``CELLS`` cells, each the highest of its amplitudes."""
    for axis in (0, 1):
        stride = -(-size.shape[axis] // CELLS)
        if stride > 1:
            size = np.maximum.reduceat(size, np.arange(0, size.shape[axis], stride), axis=axis)
    return size


def edges(middles: Array, count: int) -> Array:
    """Return the edges of ``count`` even cells around evenly spaced places."""
    half = 0.5 * (middles[1] - middles[0]) if len(middles) > 1 else 0.5
    return np.linspace(middles[0] - half, middles[-1] + half, count + 1)
