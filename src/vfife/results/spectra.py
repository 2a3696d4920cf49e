"""Spectra, spectrograms and envelopes of series, with the window, overlap and resolution that they have, and
as tables.

Samples of a run are its outputs: what is faster than half their rate is folded back into what is seen, so let
impacts have several outputs each.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import VfifeError, suggestion
from ..files import write_rows
from ..measures.spectral import (
    SHORTEST,
    analytic,
    averaged,
    frequencies_of,
    resolution_of,
    samples,
    short_time,
)
from ..solvers.repeating import outputs_of_a_turn

if TYPE_CHECKING:
    from .view import View

Array = NDArray[np.float64]
PARTS = 16  # of a series: the length of a spectrogram's windows, unless said


@dataclass(frozen=True, kw_only=True)
class Transformed:
    """What is known of all of them: ``name`` and ``unit`` of the series, ``spacing`` (s) of its samples,
    ``turn`` (s) of a crank that turns evenly.

    Windows are ``length`` samples long and overlap by ``overlap`` (1); ``frequencies`` (Hz), shape (places,).
    """

    name: str
    unit: str
    spacing: float
    turn: float | None
    window: str
    length: int
    overlap: float
    frequencies: Array

    @property
    def resolution(self) -> float:
        """Equivalent noise bandwidth (Hz): two waves nearer than this are seen as one."""
        return resolution_of(self.window, self.length * self.spacing)

    @property
    def orders(self) -> Array:
        """Frequencies in turns of the crank (1). Raises VfifeError where nothing turns evenly."""
        if self.turn is None:
            raise VfifeError("there are no orders here: no crank turns at constant speed; take frequencies")
        return np.asarray(self.frequencies * self.turn, dtype=float)

    @property
    def words(self) -> str:
        """Window, overlap and resolution, in words."""
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
    """``amplitudes`` of waves over ``frequencies``, in the unit of the series, the root of the mean square
    over ``windows``; shape (places,).

    ``density``: power spectral density (unit^2/Hz), whose sum times the distance of frequencies is the mean
    square of the series (Parseval).
    """

    amplitudes: Array
    density: Array
    windows: int

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for each frequency: frequency, order where a crank turns evenly, amplitude, density.
        Raises OSError.
        """
        orders = [] if self.turn is None else [("order [1]", self.orders)]
        last = (
            (titled(self.name, self.unit), self.amplitudes),
            (f"density [({self.unit or '1'})^2/Hz]", self.density),
        )
        table(path, [("frequency [Hz]", self.frequencies), *orders, *last])


@dataclass(frozen=True, kw_only=True)
class Spectrogram(Transformed):
    """``amplitudes`` of waves over ``frequencies`` around ``times`` (s), the middles of the windows; shape
    (times, frequencies).
    """

    times: Array
    amplitudes: Array

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for each time, a column for each frequency. Raises OSError."""
        columns = [
            (f"{frequency:.9g} Hz", self.amplitudes[:, k]) for k, frequency in enumerate(self.frequencies)
        ]
        table(path, [("time [s]", self.times), *columns])


@dataclass(frozen=True, kw_only=True)
class Envelope:
    """Size ``values`` of what vibrates within ``band`` (Hz), and what vibrates, ``filtered``, at ``times``
    (s); all shape (samples,).

    The mean is taken off first. ``spectrum``: that of the envelope, which shows how often what vibrates is
    struck.
    """

    name: str
    unit: str
    band: tuple[float, float] | None
    times: Array
    values: Array
    filtered: Array
    spectrum: Spectrum

    @property
    def words(self) -> str:
        """Band and resolution, in words."""
        band = "all frequencies" if self.band is None else f"{self.band[0]:g} to {self.band[1]:g} Hz"
        return f"{band}; {self.spectrum.words}"

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for each time: time, what vibrates, its envelope. Raises OSError."""
        table(
            path,
            [
                ("time [s]", self.times),
                (titled(self.name, self.unit), self.filtered),
                (titled("envelope", self.unit), self.values),
            ],
        )


def spectrum(
    values: ArrayLike, spacing: float, *, window: str = "hann", length: int | None = None, overlap: float = 0.5, turn: float | None = None,
    name: str = "", unit: str = "",
) -> Spectrum:  # fmt: skip
    """Amplitudes of a series of samples ``spacing`` (s) apart, averaged over windows of ``length`` samples
    (Welch 1967), all of them unless said.

    ``window``: "hann", "hamming", "blackman", "flat-top" (true heights) or "rectangular" (of whole periods).
    ``turn`` (s) is that of a crank, for orders. Raises VfifeError for what cannot be.
    """
    given, length, hop = samples(np.asarray(values, dtype=float), spacing, length, overlap, np.size(values))
    starts = np.arange(0, len(given) - length + 1, hop, dtype=np.int64)
    amplitudes, density = averaged(given, spacing, starts, window, length)
    return Spectrum(
        name=name, unit=unit, spacing=spacing, turn=turn, window=window, length=length, overlap=overlap,
        frequencies=frequencies_of(length, spacing), amplitudes=amplitudes, density=density, windows=len(starts),
    )  # fmt: skip


def spectrogram(
    values: ArrayLike, spacing: float, *, window: str = "hann", length: int | None = None, overlap: float = 0.75, turn: float | None = None,
    start: float = 0.0, name: str = "", unit: str = "",
) -> Spectrogram:  # fmt: skip
    """Short-time Fourier transform: amplitudes in windows of ``length`` samples, a sixteenth of all unless
    said.

    ``start`` (s) is the time of the first sample. Whatever repeats within a window is told apart in
    frequency, what takes longer in time. Raises VfifeError for what cannot be.
    """
    given, length, hop = samples(
        np.asarray(values, dtype=float), spacing, length, overlap, max(SHORTEST, np.size(values) // PARTS)
    )
    starts = np.arange(0, len(given) - length + 1, hop, dtype=np.int64)
    return Spectrogram(
        name=name, unit=unit, spacing=spacing, turn=turn, window=window, length=length, overlap=overlap,
        frequencies=frequencies_of(length, spacing), times=np.asarray(start + (starts + 0.5 * (length - 1)) * spacing, dtype=float),
        amplitudes=short_time(given, starts, window, length),
    )  # fmt: skip


def envelope(
    values: ArrayLike, spacing: float, *, band: tuple[float, float] | None = None, turn: float | None = None, start: float = 0.0,
    name: str = "", unit: str = "",
) -> Envelope:  # fmt: skip
    """Envelope by Hilbert's transform: the size of the analytic signal, within a ``band`` of frequencies (Hz)
    if that is said.

    The series is taken to repeat itself after its end; where it does not, the first and the last few waves
    are wrong. Raises VfifeError.
    """
    given, length, _ = samples(np.asarray(values, dtype=float), spacing, None, 0.0, np.size(values))
    signal = analytic(given, spacing, band)
    size = np.abs(signal)
    of = spectrum(size, spacing, turn=turn, name=f"envelope of {name}".strip(), unit=unit)
    times = np.asarray(start + np.arange(length) * spacing, dtype=float)
    return Envelope(
        name=name,
        unit=unit,
        band=band,
        times=times,
        values=size,
        filtered=np.asarray(signal.real),
        spectrum=of,
    )


@dataclass(frozen=True)
class Sampled:
    """A series of a run at its outputs after the start, and how it is sampled."""

    values: Array
    spacing: float
    start: float
    turn: float | None
    unit: str


def sampled(view: View, name: str) -> Sampled:
    """A series of a run by its name. Raises VfifeError for a name that none has, for statics, and where
    outputs are missing.
    """
    record = view.record
    if record.static:
        raise VfifeError("a static analysis has no motion, and so no spectrum")
    if name not in view.series:
        raise VfifeError(
            f"there is no series {name!r}:"
            f" {suggestion(name, list(view.series), 'their names are those of result.series')}"
        )
    steps = np.diff(record.steps[1:])
    if len(steps) < SHORTEST or (steps != steps[0]).any():
        raise VfifeError(
            f"a spectrum takes {SHORTEST + 1} outputs at even times; this run has {len(record.steps)}, or"
            " some are lost"
        )
    column = view.series.column(name)
    choice = record.assembly.choice
    turn = choice.turn if outputs_of_a_turn(record.assembly) is not None else None
    return Sampled(
        np.asarray(column.values[1:], dtype=float),
        float(steps[0]) * choice.step,
        float(view.time[1]),
        turn,
        column.unit,
    )


def length_of(one: Sampled, seconds: float | None, turns: float | None) -> int | None:
    """Samples of a window that is so long. Raises VfifeError where both are said, and for turns where nothing
    turns evenly.
    """
    if seconds is not None and turns is not None:
        raise VfifeError("a window has a length in seconds or in turns, not both")
    if turns is not None:
        if not 0.0 < turns < math.inf:
            raise VfifeError(f"a window of {turns:g} turns: give a finite number above 0")
        if one.turn is None:
            raise VfifeError("no crank turns at constant speed; give the length of the windows in seconds")
        seconds = turns * one.turn
    return None if seconds is None else round(seconds / one.spacing)


def titled(name: str, unit: str) -> str:
    """A column's head."""
    return f"{name or 'values'} [{unit or '1'}]"


def table(path: str | Path, columns: list[tuple[str, Array]]) -> None:
    """Writes columns as CSV, numbers to the last bit; a file that is there gives way when the new one is
    whole. Raises OSError.
    """
    write_rows(
        path, [[name for name, _ in columns], *zip(*(values.tolist() for _, values in columns), strict=True)]
    )
