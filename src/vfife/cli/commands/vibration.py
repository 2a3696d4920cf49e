"""``vfife modes`` and ``vfife spectrum``: natural frequencies of a mechanism, and what series of a run are
made of.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from ..job import FIGURES, refuse_endings
from ..options import (
    JsonOption,
    LawsOption,
    ModelArgument,
    RunArgument,
    SetOption,
    positive,
    read_model,
    refuse_inputs,
)
from ..terminal import answer, sentences, writing

if TYPE_CHECKING:
    from ...results.spectra import Envelope, Spectrogram, Spectrum
    from ...simulation.result import Result

    Found: TypeAlias = Spectrum | Spectrogram | Envelope

Count = Annotated[int, typer.Option("-n", "--count", metavar="N", min=1, help="So many of the lowest.")]
Released = Annotated[
    bool, typer.Option("--released", help="Without drivers, which otherwise hold what they drive.")
]


def modes(
    model: ModelArgument,
    set_: SetOption = None,
    count: Count = 10,
    released: Released = False,
    laws: LawsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Natural frequencies and shapes about the start: of the whole mechanism, and of its elastic links by
    themselves.

    Shapes are in the JSON value: displacement (m, m, rad) of every particle, in the order of the particles of
    a result, the ground first.
    """
    with sentences(str(model)):
        mechanism = read_model(model, set_, laws)
        from ...measures.modes import modes as found_modes

        found = found_modes(mechanism, count, released=released)
    from ...report import dynamics

    answer(dynamics.modes(mechanism, found), as_json)


KINDS = ("spectrum", "spectrogram", "envelope")
OF = "Series, as C.force; once for each."
Of = Annotated[
    list[str] | None, typer.Option("--of", metavar="SERIES", help=OF, show_default="the largest forces")
]
As = Annotated[
    str,
    typer.Option(
        "--as",
        metavar="|".join(KINDS),
        help="Over frequency; over time and frequency; or the size of what vibrates.",
    ),
]
Window = Annotated[
    str | None,
    typer.Option(
        metavar="NAME", help="hann, hamming, blackman, flat-top or rectangular.", show_default="hann"
    ),
]
Length = Annotated[
    str | None,
    typer.Option(
        metavar="TIME",
        help="Length of the windows, as 5ms.",
        show_default="the run; of a spectrogram a sixteenth of it",
    ),
]
Turns = Annotated[
    float | None, typer.Option(metavar="N", help="The same in turns of the crank.", show_default=False)
]
Overlap = Annotated[
    float | None,
    typer.Option(metavar="SHARE", help="Overlap of the windows.", show_default="0.5; of a spectrogram 0.75"),
]
Band = Annotated[
    str | None,
    typer.Option(
        metavar="LOW..HIGH", help="Band of an envelope, as 2..8kHz.", show_default="all frequencies"
    ),
]
Hertz = Annotated[
    bool,
    typer.Option("--hertz", help="Frequencies in the figure and table, also where a crank turns evenly."),
]
Figure = Annotated[Path | None, typer.Option(metavar="FILE.png|svg|pdf", help="Draw it.", show_default=False)]
Table = Annotated[
    Path | None,
    typer.Option("--csv", metavar="FILE.csv", help="Write it as a table, of one series.", show_default=False),
]


def spectrum(
    run: RunArgument,
    of: Of = None,
    kind: As = "spectrum",
    window: Window = None,
    length: Length = None,
    turns: Turns = None,
    overlap: Overlap = None,
    band: Band = None,
    hertz: Hertz = False,
    figure: Figure = None,
    csv: Table = None,
) -> None:
    """Spectrum of any series of a run, spectrogram or envelope: the strongest waves, by orders of the crank
    or in Hz; a figure, a table.

    A run is seen at its outputs: what is faster than half their rate is folded back, so let short impacts
    have several each (vfife run --outputs).
    """
    with sentences(str(run)):
        refuse_endings((("--figure", figure, FIGURES), ("--csv", csv, (".csv",))), in_folder=True)
        refuse_inputs((("--figure", figure), ("--csv", csv)), ())
        seconds, within = None if length is None else positive("--length", length, "s"), banded(band)
        result, names = series(run, of)
        if kind not in KINDS:
            raise ValueError(f"--as {kind}: allowed: {', '.join(KINDS)}")
        if csv is not None and len(names) != 1:
            raise ValueError(
                f"--csv {csv}: one table holds one series and these are {len(names)}; name one with --of"
            )
        if within is not None and kind != "envelope":
            raise ValueError("--band: only an envelope has one; add --as envelope")
        named = {"window": window, "length": length, "turns": turns, "overlap": overlap}
        if kind == "envelope" and (
            vain := [f"--{name}" for name, value in named.items() if value is not None]
        ):
            raise ValueError(
                f"{', '.join(vain)}: an envelope is that of the whole run and has no windows; leave this out,"
                " or choose a --band"
            )
        given: dict[str, Any] = {"window": window or "hann", "seconds": seconds, "turns": turns}
        if overlap is not None:
            given["overlap"] = overlap
        if kind == "envelope":
            found: list[Found] = [result.envelope(name, band=within) for name in names]
        else:
            found = [getattr(result, kind)(name, **given) for name in names]
    if hertz:
        found = [by_frequency(one) for one in found]
    if csv is not None:
        with writing(str(csv)):
            found[0].write_csv(csv)
    if figure is not None:
        with writing(str(figure)):
            draw(found, result, figure, kind)
    from ...report import dynamics

    answer(dynamics.spectra(found, result.name))


def banded(text: str | None) -> tuple[float, float] | None:
    """A band of frequencies (Hz), as 2..8kHz. Raises ValueError for what is none."""
    if text is None:
        return None
    from ...units import ends_of

    ends = ends_of(text)
    if ends is None:
        raise ValueError(f"--band {text}: this is not LOW..HIGH; write it as in --band 2..8kHz")
    return positive("--band", ends[0], "1/s"), positive("--band", ends[1], "1/s")


def series(run: Path, of: list[str] | None) -> tuple[Result, list[str]]:
    """The run, and which series. Raises ValueError where there are none to choose from."""
    from ...plots.spectra import forces
    from ...simulation.result import Result

    result = Result.load(run)
    names = of or ([] if result.record.static else forces(result))
    if not names:
        raise ValueError("no joint carries a force here, or there are too few outputs; name series with --of")
    return result, names


def by_frequency(one: Found) -> Found:
    """The same, as of a mechanism without a crank."""
    inner = getattr(one, "spectrum", None)
    changes: dict[str, Any] = (
        {"turn": None} if inner is None else {"spectrum": dataclasses.replace(inner, turn=None)}
    )
    return dataclasses.replace(one, **changes)


def draw(found: list[Any], result: Result, path: Path, kind: str) -> None:
    """The figure of them."""
    from ...plots import spectra as drawn
    from ...plots.style import saved

    draws: Any = {
        "spectrum": drawn.spectrums,
        "spectrogram": drawn.spectrograms,
        "envelope": drawn.envelopes,
    }[kind]
    saved(draws(found, result), path)
