"""Spectra of series with even sampling: amplitudes over frequency, over time and frequency, and the analytic
signal.

Amplitudes are those of sines: a wave a sin(2 pi f t) has a peak of height a at f. These are transforms by
NumPy and not functions of scipy.signal, whose import takes longer (0.5 s) than most spectra, and which holds
all windows in memory.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError, shown, suggestion

Array = NDArray[np.float64]
Places = NDArray[np.int64]
SHORTEST = 8  # samples of a window
AT_ONCE = 2**20  # samples that are transformed together, so that memory is that of what comes out
# weights sum_k a_k cos(2 pi k n/N) of sample n of N (Harris 1978; the last one is that of ISO 18431)
COSINES = {
    "hann": (0.5, -0.5),
    "hamming": (0.54, -0.46),
    "blackman": (0.42, -0.5, 0.08),
    "flat-top": (0.21557895, -0.41663158, 0.277263158, -0.083578947, 0.006947368),
    "rectangular": (1.0,),
}


def window_of(name: str, count: int) -> Array:
    """Return the weights of a window with period ``count``, shape (count,). Raises VfifeError for an unknown
    name.
    """
    if name not in COSINES:
        raise VfifeError(
            f"there is no window {shown(name)}: {suggestion(name, COSINES, 'name one of the windows')}"
        )
    phase = 2.0 * math.pi * np.arange(count) / count
    return np.asarray(sum(a * np.cos(k * phase) for k, a in enumerate(COSINES[name])), dtype=float)


def resolution_of(name: str, seconds: float) -> float:
    """Return the equivalent noise bandwidth (Hz) of a window of this length: two waves closer together appear
    as one.
    """
    a = COSINES[name]
    return (1.0 + 0.5 * sum(k * k for k in a[1:]) / a[0] ** 2) / seconds


class Windows(NamedTuple):
    """A series of numbers and the windows of it: samples in each, and the first sample of each, shape
    (windows,).
    """

    values: Array
    length: int
    starts: Places


def windows_of(values: Array, spacing: float, length: int | None, overlap: float, default: int) -> Windows:
    """Divide a series into overlapping windows of ``length`` samples, or of a ``default``. Raises VfifeError
    for arguments out of range.
    """
    values = np.asarray(values, dtype=float)
    if values.ndim != 1 or len(values) < SHORTEST or not np.isfinite(values).all():
        raise VfifeError(
            f"a spectrum takes a series of at least {SHORTEST} finite numbers; this one has {values.size} in"
            f" {values.ndim} dimensions"
        )
    if not (spacing > 0.0 and math.isfinite(spacing)):
        raise VfifeError(
            f"spacing {spacing:g}: samples follow each other in time; give the seconds between them"
        )
    if not 0.0 <= overlap < 1.0:
        raise VfifeError(f"overlap {overlap:g}: windows overlap by a share from 0 to below 1")
    length = default if length is None else length
    if not SHORTEST <= length <= len(values):
        raise VfifeError(
            f"a window of {length} samples: allowed are {SHORTEST} to {len(values)}, as many as there are;"
            " ask for another length"
        )
    hop = max(1, round(length * (1.0 - overlap)))
    return Windows(values, length, np.arange(0, len(values) - length + 1, hop, dtype=np.int64))


def transforms(values: Array, starts: Places, weights: Array) -> Iterator[Array]:
    """Yield the squares of the sizes of Fourier transforms of windows, some of them at a time, shape (..,
    places).
    """
    batch = max(1, AT_ONCE // len(weights))
    cut = np.lib.stride_tricks.sliding_window_view(values, len(weights))
    for first in range(0, len(starts), batch):
        transform = np.fft.rfft(cut[starts[first : first + batch]] * weights, axis=-1)
        yield np.asarray(transform.real**2 + transform.imag**2, dtype=float)


def one_sided(count: int) -> Array:
    """Return the weights of the one-sided spectrum of ``count`` samples: 2, but 1 at zero frequency and, for
    an even count, at Nyquist's.
    """
    weights = np.full(count // 2 + 1, 2.0)
    weights[0] = 1.0
    if count % 2 == 0:
        weights[-1] = 1.0
    return weights


def frequencies_of(length: int, spacing: float) -> Array:
    """Return the frequencies (Hz) of a transform of so many samples, ``spacing`` (s) apart."""
    return np.asarray(np.arange(length // 2 + 1) / (length * spacing), dtype=float)


class AveragedSpectrum(NamedTuple):
    """Amplitudes (unit of the series) and power spectral density (unit^2/Hz), shape (frequencies,) each."""

    amplitudes: Array
    density: Array


def averaged(windows: Windows, spacing: float, window: str) -> AveragedSpectrum:
    """Average the squared transforms of windows (Welch 1967).

    The sum of the density times the distance of frequencies is the mean square of the series (Parseval),
    weighted by the window.
    """
    weights, sides = window_of(window, windows.length), one_sided(windows.length)
    parts = (part.sum(axis=0) for part in transforms(windows.values, windows.starts, weights))
    square = sum(parts, np.zeros(windows.length // 2 + 1)) / len(windows.starts)
    density = sides * square * spacing / (weights**2).sum()
    return AveragedSpectrum(sides * np.sqrt(square) / weights.sum(), np.asarray(density, dtype=float))


def short_time(values: Array, starts: Places, window: str, length: int) -> Array:
    """Return the amplitudes in each window of ``length`` samples, shape (windows, frequencies)."""
    weights = window_of(window, length)
    scale = one_sided(length) / weights.sum()
    return np.concatenate([scale * np.sqrt(part) for part in transforms(values, starts, weights)])


def analytic(values: Array, spacing: float, band: tuple[float, float] | None) -> NDArray[np.complex128]:
    """Return the analytic signal of a series minus its mean, within a ``band`` of frequencies (Hz) if given:
    its imaginary part is the Hilbert transform. Raises VfifeError for a band without frequencies.
    """
    length, frequencies, transform = len(values), frequencies_of(len(values), spacing), np.fft.rfft(values)
    transform[0] = 0.0
    if band is not None:
        low, high = band
        inside = (frequencies >= low) & (frequencies <= high)
        if not (0.0 <= low < high) or not inside[1:].any():
            allowed = f"there are 0 to {frequencies[-1]:g} Hz, {frequencies[1]:g} Hz apart"
            raise VfifeError(f"band {low:g} to {high:g} Hz: nothing lies in it; {allowed}")
        transform[~inside] = 0.0
    two_sided = np.zeros(length, dtype=complex)
    two_sided[: len(transform)] = one_sided(length) * transform
    return np.asarray(np.fft.ifft(two_sided), dtype=np.complex128)
