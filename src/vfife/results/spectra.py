"""Spectra, spectrograms and envelopes of series, with window, overlap and resolution, and as tables.

The samples of a run are its outputs. Frequencies above half the output rate are folded to lower ones
(aliasing), so impacts need several outputs each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import VfifeError, suggestion
from ..files import DataTable
from ..measures import spectral
from ..model.functions import NO_CRANK
from ..options import with_faults
from ..solvers.repeating import outputs_of_a_turn
from .export import TableColumn, table_rows

if TYPE_CHECKING:
    from .run_data import RunData

Array = NDArray[np.float64]
EQUAL = 1e-9  # relative difference below which two frequencies are equal
PARTS = 16  # windows side by side in a spectrogram


class SeriesLabel(TypedDict, total=False):
    """Description of a series: name and unit, ``turn`` (s) of a crank with constant speed, ``start`` (s) of
    the first sample.
    """

    turn: float | None
    start: float
    name: str
    unit: str


@dataclass(frozen=True, kw_only=True)
class Transformed(DataTable):
    """A transformed series: its ``name`` and ``unit``, the ``spacing`` (s) of its samples, the ``turn`` (s)
    of a crank of constant speed.

    Windows are ``length`` samples long and overlap by ``overlap`` (1).
    """

    name: str
    unit: str
    spacing: float
    turn: float | None
    window: str
    length: int
    overlap: float

    @property
    def frequencies(self) -> Array:
        """Frequencies (Hz), shape (frequencies,)."""
        return spectral.frequencies_of(self.length, self.spacing)

    @property
    def resolution(self) -> float:
        """Equivalent noise bandwidth (Hz): two waves nearer than this are seen as one."""
        return spectral.resolution_of(self.window, self.length * self.spacing)

    @property
    def orders(self) -> Array:
        """Frequencies in cycles a turn of the crank (1). Raises VfifeError where no crank has a constant
        speed.
        """
        if self.turn is None:
            raise VfifeError(f"there are no orders here: {NO_CRANK}; take frequencies")
        return np.asarray(self.frequencies * self.turn, dtype=float)

    @property
    def words(self) -> str:
        """Description of window, overlap and resolution."""
        seconds = self.length * self.spacing
        long = f"{seconds / self.turn:.4g} turns" if self.turn else f"{1e3 * seconds:.4g} ms"
        wide = f"{self.resolution * self.turn:.3g} orders or " if self.turn else ""
        name = self.window if self.window in ("flat-top", "rectangular") else self.window.capitalize()
        return (
            f"{name} windows of {long}, overlapping by {100.0 * self.overlap:.3g} %; resolution"
            f" {wide}{self.resolution:.4g} Hz"
        )


@dataclass(frozen=True, kw_only=True)
class Spectrum(Transformed):
    """``amplitudes`` over ``frequencies``, the root of the mean square over ``windows``, in the unit of the
    series; shape (frequencies,).

    ``density``: power spectral density (unit^2/Hz), whose sum times the distance of frequencies is the mean
    square of the series (Parseval).
    """

    amplitudes: Array = field(repr=False)
    density: Array = field(repr=False)
    windows: int

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield a row for each frequency: frequency, order if the crank has constant speed, amplitude,
        density.
        """
        orders = [] if self.turn is None else [TableColumn("order [1]", self.orders)]
        density = TableColumn(f"density [({self.unit or '1'})^2/Hz]", self.density)
        return table_rows(
            [
                TableColumn("frequency", self.frequencies, "Hz"),
                *orders,
                values_column(self.name, self.unit, self.amplitudes),
                density,
            ]
        )


@dataclass(frozen=True, kw_only=True)
class Spectrogram(Transformed):
    """``amplitudes`` over ``frequencies`` around ``times`` (s), the middles of the windows; shape (times,
    frequencies).
    """

    times: Array = field(repr=False)
    amplitudes: Array = field(repr=False)

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield a row for each time with a column for each frequency."""
        columns = [
            TableColumn(f"{frequency:.9g} Hz", self.amplitudes[:, k])
            for k, frequency in enumerate(self.frequencies)
        ]
        return table_rows([TableColumn("time", self.times, "s"), *columns])


@dataclass(frozen=True, kw_only=True)
class Envelope(DataTable):
    """Envelope ``values`` of the vibration within ``band`` (Hz), and that vibration, ``filtered``, at
    ``times`` (s); all shape (samples,).

    The mean is subtracted first. ``spectrum``: that of the envelope, which shows how often the vibration is
    excited. ``request``: the highest frequency (Hz) that was asked for, if ``band`` ends at half the sampling
    rate instead.
    """

    name: str
    unit: str
    band: tuple[float, float] | None
    times: Array = field(repr=False)
    values: Array = field(repr=False)
    filtered: Array = field(repr=False)
    spectrum: Spectrum
    request: float | None = None

    @property
    def words(self) -> str:
        """Description of band and resolution."""
        band = "all frequencies" if self.band is None else f"{self.band[0]:g} to {self.band[1]:g} Hz"
        cut = "" if self.request is None else f" (half the sampling rate; {self.request:g} Hz asked for)"
        return f"{band}{cut}; {self.spectrum.words}"

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield a row for each time: time, vibration, envelope."""
        columns = (
            values_column(self.name, self.unit, self.filtered),
            values_column("envelope", self.unit, self.values),
        )
        return table_rows([TableColumn("time", self.times, "s"), *columns])


def values_column(name: str, unit: str, values: Array) -> TableColumn:
    """Return the column of a series, with the unit in its head."""
    return TableColumn(f"{name or 'values'} [{unit or '1'}]", values)


@with_faults(SeriesLabel)
def spectrum(
    values: ArrayLike,
    spacing: float,
    *,
    window: str = "hann",
    length: int | None = None,
    overlap: float = 0.5,
    **label: Unpack[SeriesLabel],
) -> Spectrum:
    """Return the amplitudes of a series over frequency, averaged over windows (Welch 1967).

    values: equally spaced samples, shape (samples,)
    spacing: time between two samples (s)
    window: "hann", "hamming", "blackman", "flat-top" (exact heights) or "rectangular" (for whole periods)
    length: samples in a window, by default all
    overlap: share of a window that the next one repeats, from 0 to below 1
    label: ``name`` and ``unit`` for tables, ``turn`` (s) of a crank with constant speed for orders,
    ``start`` (s) of the first sample

    Raises VfifeError for arguments out of range.
    """
    parts = spectral.windows_of(np.asarray(values, dtype=float), spacing, length, overlap, np.size(values))
    averages = spectral.averaged(parts, spacing, window)
    return Spectrum(
        name=label.get("name", ""), unit=label.get("unit", ""), turn=label.get("turn"), spacing=spacing,
        window=window, length=parts.length,
        overlap=overlap, amplitudes=averages.amplitudes, density=averages.density, windows=len(parts.starts),
    )  # fmt: skip


@with_faults(SeriesLabel)
def spectrogram(
    values: ArrayLike,
    spacing: float,
    *,
    window: str = "hann",
    length: int | None = None,
    overlap: float = 0.75,
    **label: Unpack[SeriesLabel],
) -> Spectrogram:
    """Return the short-time Fourier transform of a series: amplitudes over time and frequency.

    values: equally spaced samples, shape (samples,)
    spacing: time between two samples (s)
    window: shape of the windows, as of :func:`spectrum`
    length: samples in a window, by default a sixteenth of all
    overlap: share of a window that the next one repeats, from 0 to below 1
    label: ``name`` and ``unit`` for tables, ``turn`` (s) of a crank for orders, ``start`` (s) of the first
    sample

    Vibrations that repeat within a window are separated in frequency, slower changes in time. Raises
    VfifeError for arguments out of range.
    """
    parts = spectral.windows_of(
        np.asarray(values, dtype=float),
        spacing,
        length,
        overlap,
        max(spectral.SHORTEST, np.size(values) // PARTS),
    )
    times = label.get("start", 0.0) + (parts.starts + 0.5 * (parts.length - 1)) * spacing
    return Spectrogram(
        name=label.get("name", ""), unit=label.get("unit", ""), turn=label.get("turn"), spacing=spacing,
        window=window, length=parts.length,
        overlap=overlap, times=np.asarray(times, dtype=float), amplitudes=spectral.short_time(parts.values,
        parts.starts, window, parts.length),
    )  # fmt: skip


@with_faults(SeriesLabel)
def envelope(
    values: ArrayLike,
    spacing: float,
    *,
    band: tuple[float, float] | None = None,
    **label: Unpack[SeriesLabel],
) -> Envelope:
    """Return the envelope of a series by Hilbert's transform: the magnitude of the analytic signal.

    values: equally spaced samples, shape (samples,)
    spacing: time between two samples (s)
    band: lowest and highest frequency (Hz) of the part of the series that is used, by default all; a band
    beyond half the sampling rate ends there
    label: ``name`` and ``unit`` for tables, ``turn`` (s) of a crank for orders, ``start`` (s) of the first
    sample

    The series is assumed to be periodic; where it is not, the first and the last few waves are wrong. Raises
    VfifeError for arguments out of range.
    """
    series = spectral.windows_of(np.asarray(values, dtype=float), spacing, None, 0.0, np.size(values)).values
    signal = spectral.analytic(series, spacing, band)
    request, highest = None, 0.5 / spacing
    if band is not None and band[1] > highest * (1.0 + EQUAL):
        band, request = (band[0], highest), float(band[1])
    size, name, unit = np.abs(signal), label.get("name", ""), label.get("unit", "")
    of_envelope = spectrum(
        size, spacing, turn=label.get("turn"), name=f"envelope of {name}".strip(), unit=unit
    )
    times = np.asarray(label.get("start", 0.0) + np.arange(len(series)) * spacing, dtype=float)
    return Envelope(
        name=name,
        unit=unit,
        band=band,
        times=times,
        values=size,
        filtered=np.asarray(signal.real),
        spectrum=of_envelope,
        request=request,
    )


@dataclass(frozen=True)
class SampledSeries:
    """A series of a run at its outputs after the start, shape (outputs - 1,), ``spacing`` (s) apart."""

    values: Array
    spacing: float
    label: SeriesLabel

    def length(self, seconds: float | None, turns: float | None) -> int | None:
        """Return the number of samples in a window of ``seconds`` or ``turns``. Raises VfifeError if both are
        given, and for turns without a crank of constant speed.
        """
        if seconds is not None and turns is not None:
            raise VfifeError("a window has a length in seconds or in turns, not both")
        if turns is not None:
            if not 0.0 < turns < math.inf:
                raise VfifeError(f"a window of {turns:g} turns: give a finite number above 0")
            if (turn := self.label["turn"]) is None:
                raise VfifeError(f"{NO_CRANK}; give the length of the windows in seconds")
            seconds = turns * turn
        return None if seconds is None else round(seconds / self.spacing)


def sampled(view: RunData, name: Any) -> SampledSeries:
    """Return a series of a run by name. Raises VfifeError for an unknown name, for a static analysis, and if
    outputs are missing.
    """
    record = view.record
    if record.static:
        raise VfifeError("a static analysis has no motion, and so no spectrum")
    if not isinstance(name, str) or name not in view.series:
        raise VfifeError(
            f"there is no series {name!r}:"
            f" {suggestion(name, list(view.series), 'their names are those of result.series')}"
        )
    steps = np.diff(record.steps[1:])
    if len(steps) < spectral.SHORTEST or (steps != steps[0]).any():
        raise VfifeError(
            f"a spectrum takes {spectral.SHORTEST + 1} outputs at even times; this run has"
            f" {len(record.steps)}, or some are lost"
        )
    column, choice = view.series.column(name), record.assembly.choice
    turn = choice.turn if outputs_of_a_turn(record.assembly) is not None else None
    label = SeriesLabel(turn=turn, start=float(view.time[1]), name=name, unit=column.unit)
    return SampledSeries(np.asarray(column.values[1:], dtype=float), float(steps[0]) * choice.step, label)
