"""What a series is made of: waves over frequency, over time and frequency, and the envelope of what vibrates.

All of it takes samples at even times, of any quantity; amplitudes are those of sines, so a wave a sin(2 pi f
t) has a peak of height a at f.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

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
    """Weights of a window, shape (count,), that repeats itself after ``count`` samples. Raises VfifeError for
    a name that none has.
    """
    if name not in COSINES:
        raise VfifeError(
            f"there is no window {shown(name)}: {suggestion(name, COSINES, 'name one that there is')}"
        )
    phase = 2.0 * math.pi * np.arange(count) / count
    return np.asarray(sum(a * np.cos(k * phase) for k, a in enumerate(COSINES[name])), dtype=float)


def resolution_of(name: str, seconds: float) -> float:
    """Equivalent noise bandwidth (Hz) of a window so long: two waves nearer than this are seen as one."""
    a = COSINES[name]
    return (1.0 + 0.5 * sum(k * k for k in a[1:]) / a[0] ** 2) / seconds


def samples(
    values: Array, spacing: float, length: int | None, overlap: float, default: int
) -> tuple[Array, int, int]:
    """Values as numbers, samples of a window, and samples from one window to the next. Raises VfifeError for
    what cannot be.
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
    return values, length, max(1, round(length * (1.0 - overlap)))


def transforms(values: Array, starts: Places, weights: Array) -> Iterator[Array]:
    """Squares of the sizes of Fourier transforms of windows, some of them at a time, shape (.., places)."""
    many, cut = (
        max(1, AT_ONCE // len(weights)),
        np.lib.stride_tricks.sliding_window_view(values, len(weights)),
    )
    for first in range(0, len(starts), many):
        found = np.fft.rfft(cut[starts[first : first + many]] * weights, axis=-1)
        yield np.asarray(found.real**2 + found.imag**2, dtype=float)


def doubled(count: int) -> Array:
    """How often a place of a real transform stands in the full one: twice, but for the mean and the fastest
    wave of an even count.
    """
    found = np.full(count // 2 + 1, 2.0)
    found[0] = 1.0
    if count % 2 == 0:
        found[-1] = 1.0
    return found


def frequencies_of(length: int, spacing: float) -> Array:
    """Frequencies (Hz) of a transform of so many samples, ``spacing`` (s) apart."""
    return np.asarray(np.arange(length // 2 + 1) / (length * spacing), dtype=float)


def averaged(values: Array, spacing: float, starts: Places, window: str, length: int) -> tuple[Array, Array]:
    """Amplitudes and power spectral density (unit^2/Hz) over frequency: the mean square of windows of so many
    samples (Welch 1967).

    The sum of the density times the distance of frequencies is the mean square of the series (Parseval),
    weighted as the window does.
    """
    weights, twice = window_of(window, length), doubled(length)
    square = sum(
        (one.sum(axis=0) for one in transforms(values, starts, weights)), np.zeros(length // 2 + 1)
    ) / len(starts)
    root = twice * np.sqrt(square) / weights.sum()
    return root, np.asarray(twice * square * spacing / (weights**2).sum(), dtype=float)


def short_time(values: Array, starts: Places, window: str, length: int) -> Array:
    """Amplitudes of the waves in each window of so many samples, shape (windows, frequencies)."""
    weights = window_of(window, length)
    found, done, twice = np.zeros((len(starts), length // 2 + 1)), 0, doubled(length) / weights.sum()
    for part in transforms(values, starts, weights):
        found[done : done + len(part)] = twice * np.sqrt(part)
        done += len(part)
    return found


def analytic(values: Array, spacing: float, band: tuple[float, float] | None) -> NDArray[np.complex128]:
    """The analytic signal of a series without its mean, within a ``band`` of frequencies (Hz) if that is
    said: itself and, turned by a quarter of a wave, Hilbert's transform of it. Raises VfifeError for a band
    in which nothing lies.
    """
    length, frequencies, found = len(values), frequencies_of(len(values), spacing), np.fft.rfft(values)
    found[0] = 0.0
    if band is not None:
        low, high = band
        inside = (frequencies >= low) & (frequencies <= high)
        if not (0.0 <= low < high) or not inside[1:].any():
            there = f"there are 0 to {frequencies[-1]:g} Hz, {frequencies[1]:g} Hz apart"
            raise VfifeError(f"band {low:g} to {high:g} Hz: nothing lies in it; {there}")
        found[~inside] = 0.0
    whole = np.zeros(length, dtype=complex)
    whole[: len(found)] = doubled(length) * found
    return np.asarray(np.fft.ifft(whole), dtype=np.complex128)
