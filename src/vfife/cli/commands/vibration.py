"""``vfife modes`` and ``vfife spectrum``: natural frequencies of a mechanism, and what series of a run are
made of.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ...job.activity import ACTIVITY
from ...measures.modes import modes as natural_modes
from ...report import dynamics
from ...report.modes import modes as mode_document
from ...results.spectra import Envelope, Spectrogram, Spectrum
from ...simulation.result import Result
from ...units import ends_of
from ..arguments.runs import KINDS, ModesOptions, SpectrumOptions
from ..terminal import sentences
from ..values import mechanism_of, positive, separated

if TYPE_CHECKING:
    AnySpectrum: TypeAlias = Spectrum | Spectrogram | Envelope


def modes(options: ModesOptions) -> None:
    """Run ``vfife modes``."""
    with sentences(str(options.model)):
        mechanism = mechanism_of(options)
        result = natural_modes(mechanism, options.count, released=options.released)
    options.answer(mode_document(mechanism, result))


def spectrum(options: SpectrumOptions) -> None:
    """Run ``vfife spectrum``."""
    kind = options.kind
    with sentences(str(options.run)):
        options.refuse_files()
        windows: dict[str, Any] = {
            "seconds": positive("--length", options.length, "s"),
            "turns": options.turns,
        }
        windows |= {
            name: value for name in ("window", "overlap") if (value := getattr(options, name)) is not None
        }
        arguments = {"band": parse_band(options.band)} if kind == "envelope" else windows
        result, names = series(options.run, options.of)
        check_options(options, names)
        ACTIVITY(f"computing the {kind} of {', '.join(names)}")
        spectra: list[AnySpectrum] = [getattr(result, kind)(name, **arguments) for name in names]
    if options.hertz:
        spectra = [by_frequency(entry) for entry in spectra]
    options.write_files(spectra[0], lambda: draw(spectra, result, kind))
    options.answer(dynamics.spectra(spectra, result.name))


def parse_band(text: str | None) -> tuple[float, float] | None:
    """Parse a band of frequencies, as 2..8kHz, into its limits (Hz). Raises ValueError for any other text."""
    if text is None:
        return None
    ends = ends_of(text)
    if ends is None:
        raise ValueError(f"--band {text}: this is not LOW..HIGH; write it as in --band 2..8kHz")
    low, high = (positive("--band", end, "1/s") for end in ends)
    return low, high


def series(run: Path, of: list[str] | None) -> tuple[Result, list[str]]:
    """Return the run and the names of its series. Raises ValueError if the run has none."""
    from ...plots.spectra import forces

    ACTIVITY(f"reading {run}")
    result = Result.load(run)
    names = separated(of, result.record.assembly.mechanism) or (
        [] if result.record.static else forces(result)
    )
    if not names:
        raise ValueError("no joint carries a force, or there are too few outputs; name series with --of")
    return result, names


def by_frequency(spectrum: AnySpectrum) -> AnySpectrum:
    """Return the spectrum over frequency (Hz) instead of orders of the crank."""
    inner = getattr(spectrum, "spectrum", None)
    changes: dict[str, Any] = (
        {"turn": None} if inner is None else {"spectrum": dataclasses.replace(inner, turn=None)}
    )
    return dataclasses.replace(spectrum, **changes)


def draw(spectra: list[Any], result: Result, kind: str) -> Any:
    """Draw the figure of these spectra."""
    from ...plots import spectra as figures

    draws: dict[str, Any] = {
        "spectrum": figures.spectrums,
        "spectrogram": figures.spectrograms,
        "envelope": figures.envelopes,
    }
    return draws[kind](spectra, result)


def check_options(options: SpectrumOptions, names: list[str]) -> None:
    """Raise ValueError for options that go with another kind of spectrum, or with one series."""
    if options.kind not in KINDS:
        raise ValueError(f"--as {options.kind}: allowed: {', '.join(KINDS)}")
    if options.csv is not None and len(names) != 1:
        raise ValueError(
            f"--csv {options.csv}: one table holds one series and these are {len(names)}; name one with --of"
        )
    if options.kind != "envelope" and options.band is not None:
        raise ValueError("--band: only an envelope has one; add --as envelope")
    unused = [
        f"--{name}" for name in ("window", "length", "turns", "overlap") if getattr(options, name) is not None
    ]
    if options.kind == "envelope" and unused:
        raise ValueError(
            f"{', '.join(unused)}: an envelope covers the whole run and has no windows; leave this"
            " out, or choose a --band"
        )
