"""``vfife modes`` and ``vfife spectrum``: natural frequencies of a mechanism, and what series of a run are
made of.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ..options import FileOptions, JsonOptions, ModelOptions, RunOptions, flag, option, positive
from ..terminal import sentences

if TYPE_CHECKING:
    from ...results.spectra import Envelope, Spectrogram, Spectrum
    from ...simulation.result import Result

    AnySpectrum: TypeAlias = Spectrum | Spectrogram | Envelope


class ModesOptions(ModelOptions, JsonOptions):
    """Options of ``vfife modes``."""

    count: int = option(10, "Number of modes, the lowest first.", "N", "-n", "--count", min=1)
    released: bool = flag("--released", "Without drivers, which otherwise hold what they drive.")


def modes(options: ModesOptions) -> None:
    """Natural frequencies and shapes about the start: of the whole mechanism, and of its elastic links by
    themselves.

    Shapes are in the JSON value: displacement (m, m, rad) of every particle, in the order of the particles of
    a result, the ground first.
    """
    with sentences(str(options.model)):
        mechanism = options.mechanism()
        from ...measures.modes import modes as natural_modes

        result = natural_modes(mechanism, options.count, released=options.released)
    from ...report import dynamics

    options.answer(dynamics.modes(mechanism, result))


KINDS = ("spectrum", "spectrogram", "envelope")


class SpectrumOptions(RunOptions, FileOptions):
    """Options of ``vfife spectrum``."""

    of: list[str] | None = option(
        None, "Series, as C.force; once for each.", "SERIES", show_default="the largest forces"
    )
    kind: str = option(
        "spectrum",
        "Over frequency; over time and frequency; or the size of what vibrates.",
        "|".join(KINDS),
        "--as",
    )
    window: str | None = option(
        None, "hann, hamming, blackman, flat-top or rectangular.", "NAME", show_default="hann"
    )
    length: str | None = option(
        None,
        "Length of the windows, as 5ms.",
        "TIME",
        show_default="the run; of a spectrogram a sixteenth of it",
    )
    turns: float | None = option(None, "The same in turns of the crank.", "N")
    overlap: float | None = option(
        None, "Overlap of the windows.", "SHARE", show_default="0.5; of a spectrogram 0.75"
    )
    band: str | None = option(
        None, "Band of an envelope, as 2..8kHz.", "LOW..HIGH", show_default="all frequencies"
    )
    hertz: bool = flag("--hertz", "Frequencies in the figure and table, also where a crank turns evenly.")

    def check(self, names: list[str]) -> None:
        """Raise ValueError for options that go with another kind of spectrum, or with one series."""
        if self.kind not in KINDS:
            raise ValueError(f"--as {self.kind}: allowed: {', '.join(KINDS)}")
        if self.csv is not None and len(names) != 1:
            raise ValueError(
                f"--csv {self.csv}: one table holds one series and these are {len(names)}; name one with --of"
            )
        if self.kind != "envelope" and self.band is not None:
            raise ValueError("--band: only an envelope has one; add --as envelope")
        unused = [
            f"--{name}"
            for name in ("window", "length", "turns", "overlap")
            if getattr(self, name) is not None
        ]
        if self.kind == "envelope" and unused:
            raise ValueError(
                f"{', '.join(unused)}: an envelope is that of the whole run and has no windows; leave this"
                " out, or choose a --band"
            )


def spectrum(options: SpectrumOptions) -> None:
    """Spectrum of any series of a run, spectrogram or envelope: the strongest waves, by orders of the crank
    or in Hz; a figure, a table.

    A run is seen at its outputs: what is faster than half their rate is folded back, so let short impacts
    have several each (vfife run --outputs).
    """
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
        options.check(names)
        spectra: list[AnySpectrum] = [getattr(result, kind)(name, **arguments) for name in names]
    if options.hertz:
        spectra = [by_frequency(one) for one in spectra]
    options.write_files(spectra[0], lambda: draw(spectra, result, kind))
    from ...report import dynamics

    options.answer(dynamics.spectra(spectra, result.name))


def parse_band(text: str | None) -> tuple[float, float] | None:
    """Parse a band of frequencies, as 2..8kHz, into its limits (Hz). Raises ValueError for any other text."""
    if text is None:
        return None
    from ...units import ends_of

    ends = ends_of(text)
    if ends is None:
        raise ValueError(f"--band {text}: this is not LOW..HIGH; write it as in --band 2..8kHz")
    low, high = (positive("--band", end, "1/s") for end in ends)
    return low, high


def series(run: Path, of: list[str] | None) -> tuple[Result, list[str]]:
    """Return the run and the names of its series. Raises ValueError if the run has none."""
    from ...plots.spectra import forces
    from ...simulation.result import Result

    result = Result.load(run)
    names = of or ([] if result.record.static else forces(result))
    if not names:
        raise ValueError("no joint carries a force here, or there are too few outputs; name series with --of")
    return result, names


def by_frequency(one: AnySpectrum) -> AnySpectrum:
    """Return the spectrum over frequency (Hz) instead of orders of the crank."""
    inner = getattr(one, "spectrum", None)
    changes: dict[str, Any] = (
        {"turn": None} if inner is None else {"spectrum": dataclasses.replace(inner, turn=None)}
    )
    return dataclasses.replace(one, **changes)


def draw(spectra: list[Any], result: Result, kind: str) -> Any:
    """Draw the figure of these spectra."""
    from ...plots import spectra as figures

    draws: dict[str, Any] = {
        "spectrum": figures.spectrums,
        "spectrogram": figures.spectrograms,
        "envelope": figures.envelopes,
    }
    return draws[kind](spectra, result)
