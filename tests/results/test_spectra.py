"""Spectra, spectrograms and envelopes against waves that are known, Parseval's theorem, and scipy's own."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest
import scipy.signal

import vfife
from vfife import gallery
from vfife.errors import VfifeError
from vfife.measures.spectral import COSINES, resolution_of, window_of
from vfife.report.dynamics import spectra

RATE = 2000.0
TIMES = np.arange(4000) / RATE


@pytest.mark.parametrize("window", COSINES)
def test_windows_are_those_of_scipy(window):
    """And their bandwidth is that of their noise: N sum w^2/(sum w)^2."""
    name = {"flat-top": "flattop", "rectangular": "boxcar"}.get(window, window)
    assert window_of(window, 64) == pytest.approx(scipy.signal.get_window(name, 64), abs=1e-9)
    w = window_of(window, 1000)
    assert resolution_of(window, 1000 / RATE) == pytest.approx(RATE * (w**2).sum() / w.sum() ** 2, rel=1e-9)


@pytest.mark.parametrize("window", COSINES)
def test_a_wave_is_as_high_as_it_is(window):
    """Of 3 at 125 Hz about a mean of 2."""
    found = vfife.dynamics.spectrum(
        2.0 + 3.0 * np.sin(2.0 * math.pi * 125.0 * TIMES), 1.0 / RATE, window=window
    )
    k = int(np.argmin(np.abs(found.frequencies - 125.0)))
    assert found.amplitudes[[0, k]] == pytest.approx([2.0, 3.0], rel=1e-6)
    assert found.frequencies[int(np.argmax(found.amplitudes[50:])) + 50] == 125.0


def test_a_flat_top_tells_heights_between_its_places():
    """Where other windows lose up to a third."""
    wave = np.sin(2.0 * math.pi * 125.25 * TIMES)
    highest = {
        window: vfife.dynamics.spectrum(wave, 1.0 / RATE, window=window).amplitudes.max()
        for window in COSINES
    }
    assert (
        highest["flat-top"] == pytest.approx(1.0, abs=2e-3)
        and highest["hann"] < 0.87
        and highest["rectangular"] < 0.66
    )


@pytest.mark.parametrize("count", [4000, 3999])
def test_the_density_holds_the_mean_square(count):
    """Parseval: of noise under no window, to rounding."""
    noise = np.random.default_rng(0).normal(size=count)
    found = vfife.dynamics.spectrum(noise, 1.0 / RATE, window="rectangular")
    assert (found.density.sum() * found.frequencies[1]) == pytest.approx(np.mean(noise**2), rel=1e-12)
    averaged = vfife.dynamics.spectrum(noise, 1.0 / RATE, length=400)
    assert averaged.density.sum() * averaged.frequencies[1] == pytest.approx(np.mean(noise**2), rel=0.05)
    assert averaged.windows == (count - 400) // 200 + 1


def test_averages_are_those_of_scipy():
    noise = np.random.default_rng(1).normal(size=5000)
    found = vfife.dynamics.spectrum(noise, 1.0 / RATE, length=512, overlap=0.5)
    _, density = scipy.signal.welch(noise, RATE, "hann", 512, 256, detrend=False)
    assert found.density == pytest.approx(density, rel=1e-9)


def test_a_chirp_stands_where_it_is_at_each_time():
    """From 100 Hz by 200 Hz/s: the highest place of each window is the frequency in its middle."""
    wave = 1.5 * np.sin(2.0 * math.pi * (100.0 * TIMES + 100.0 * TIMES**2))
    found = vfife.dynamics.spectrogram(wave, 1.0 / RATE, length=200, start=5.0)
    at = found.frequencies[found.amplitudes.argmax(axis=1)]
    assert at == pytest.approx(100.0 + 200.0 * (found.times - 5.0), abs=0.6 * RATE / 200)
    assert found.amplitudes.max(axis=1) == pytest.approx(1.5, rel=0.2)
    assert found.times[0] == pytest.approx(5.0 + 99.5 / RATE) and np.diff(found.times) == pytest.approx(
        50 / RATE
    )
    assert found.resolution == pytest.approx(1.5 * RATE / 200)


def test_a_spectrogram_is_that_of_scipy():
    noise = np.random.default_rng(2).normal(size=3000)
    found = vfife.dynamics.spectrogram(noise, 1.0 / RATE, length=256, overlap=0.75)
    frequencies, times, other = scipy.signal.spectrogram(
        noise, RATE, "hann", 256, 192, detrend=False, scaling="spectrum", mode="magnitude"
    )
    assert found.frequencies == pytest.approx(frequencies) and len(found.times) == len(times)
    assert found.amplitudes[:, 1:-1] == pytest.approx(2.0 * other.T[:, 1:-1], rel=1e-9)


def test_an_envelope_is_what_modulates():
    """(2 + cos at 5 Hz) sin at 300 Hz beside a slow wave and a mean, which the band leaves out; the spectrum
    of the envelope has its 5 Hz.
    """
    slow = 2.0 + np.cos(2.0 * math.pi * 5.0 * TIMES)
    wave = 7.0 + np.sin(2.0 * math.pi * 20.0 * TIMES) + slow * np.sin(2.0 * math.pi * 300.0 * TIMES)
    found = vfife.dynamics.envelope(wave, 1.0 / RATE, band=(250.0, 350.0))
    assert found.values == pytest.approx(slow, abs=1e-9)
    assert found.filtered == pytest.approx(slow * np.sin(2.0 * math.pi * 300.0 * TIMES), abs=1e-9)
    k = int(np.argmin(np.abs(found.spectrum.frequencies - 5.0)))
    assert found.spectrum.amplitudes[[0, k]] == pytest.approx([2.0, 1.0], abs=1e-9)
    noise = np.random.default_rng(3).normal(size=999)
    assert vfife.dynamics.envelope(noise, 1.0).values == pytest.approx(
        np.abs(scipy.signal.hilbert(noise - noise.mean())), rel=1e-9
    )


@pytest.fixture(scope="module")
def run():
    return vfife.simulate(gallery.four_bar_ideal(), turns=2, outputs=360, companions=0)


def test_series_of_a_run_have_orders(run):
    """A window of a turn: the amplitude of an order is that of the discrete transform of the turn."""
    found = run.spectrum("C.force", window="rectangular", turns=1)
    assert (
        found.orders[:4] == pytest.approx([0.0, 1.0, 2.0, 3.0]) and found.unit == "N" and found.length == 360
    )
    last = run.series["C.force"].values[-360:]
    assert found.amplitudes[1] == pytest.approx(2.0 * abs(np.fft.rfft(last)[1]) / 360, rel=1e-3)
    times = run.spectrogram("C.force", turns=0.5)
    assert times.amplitudes.shape == (len(times.times), 91) and times.orders[1] == pytest.approx(2.0)
    assert "0.5 turns" in times.words and "75 %" in times.words and "resolution 3 orders" in times.words
    assert len(run.envelope("C.force").values) == 720


def test_the_band_of_an_envelope_ends_at_half_the_output_rate(run):
    """The series has no higher frequencies; the answer, the title of the figure and the command say so."""
    half = 0.5 / float(np.diff(run.series["C.force"].time.values[-2:])[0])
    found, whole = (run.envelope("C.force", band=(0.1 * half, end)) for end in (9.0 * half, half))
    assert found.band == pytest.approx((0.1 * half, half)) and found.request == 9.0 * half
    assert f"to {half:g} Hz (half the sampling rate; {9.0 * half:g} Hz asked for)" in found.words
    assert whole.request is None and "asked" not in whole.words
    assert np.array_equal(found.values, whole.values)
    assert any("asked for" in getattr(part, "text", "") for part in spectra([found], "run").parts)


def test_tables_hold_what_was_found(run, tmp_path):
    for name, found in (
        ("a", run.spectrum("C.force")),
        ("b", run.spectrogram("C.force")),
        ("c", run.envelope("C.force")),
    ):
        found.write_csv(tmp_path / f"{name}.csv")
    a, b, c = (list(csv.reader((tmp_path / f"{name}.csv").read_text().splitlines())) for name in "abc")
    assert a[0] == ["frequency [Hz]", "order [1]", "C.force [N]", "density [(N)^2/Hz]"] and len(a) == 362
    assert b[0][:2] == ["time [s]", "0 Hz"] and float(b[3][2]) == run.spectrogram("C.force").amplitudes[2, 1]
    assert c[0] == ["time [s]", "C.force [N]", "envelope [N]"] and len(c) == 721


@pytest.mark.parametrize("call, said", [
    (lambda run: run.spectrum("C.forc"), "no series 'C.forc'.*C.force"),
    (lambda run: run.spectrum("C.force", window="han"), 'no window "han".*hann'),
    (lambda run: run.spectrogram("C.force", overlap=1.0), "overlap 1"),
    (lambda run: run.spectrogram("C.force", seconds=1.0, turns=1.0), "not both"),
    (lambda run: run.spectrogram("C.force", turns=5.0), "720"),
    (lambda run: run.envelope("C.force", band=(1e6, 2e6)), "nothing lies in it"),
    (lambda run: run.envelope("C.force", band=(9.0, 3.0)), "nothing lies in it"),
    (lambda run: vfife.dynamics.spectrum([1.0, math.nan] * 8, 0.1), "finite"),
    (lambda run: vfife.dynamics.spectrum(np.zeros(16), 0.0), "spacing"),
    (lambda run: vfife.dynamics.spectrum(np.zeros(16), 1.0).orders, "no orders"),
])  # fmt: skip
def test_what_cannot_be_is_told(run, call, said):
    with pytest.raises(VfifeError, match=said):
        call(run)


@pytest.mark.parametrize("turns", [float("nan"), float("inf"), 0.0, -1.0])
def test_windows_are_of_finite_turns(run, turns):
    with pytest.raises(vfife.VfifeError, match="give a finite number above 0"):
        run.spectrum("C.force", turns=turns)


def test_a_printed_spectrum_names_its_strongest_waves(run):
    """As the command does, which prints the same document."""
    for found in (run.spectrum("C.force"), run.spectrogram("C.force"), run.envelope("C.force")):
        shown = " ".join(str(found).split())
        assert "the strongest waves" in shown and found.words[1:] in shown and "amplitude" in shown
        assert "<table" in found._repr_html_() and repr(found).startswith(type(found).__name__)
