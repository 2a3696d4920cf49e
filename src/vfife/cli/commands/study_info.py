"""What to do with a study that was made, or that is still growing: show, draw, export; what a sample of
machines tells.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..options import FileArgument as FileArgument
from ..options import JsonOption, LawsOption, take_laws
from ..terminal import amount_of_bytes, answer, sentences, writing
from .result import ForceFile, refuse_ending, refuse_taken

if TYPE_CHECKING:
    from ...results.studied import Study
    from ...studies.spec.limits import Bound

Members = Annotated[bool, typer.Option("--members", help="Every member with what it came to.")]


def show(file: FileArgument, members: Members = False, as_json: JsonOption = False) -> None:
    """What a study came to so far: each measure's least, mean and largest value and where, and what failed."""
    found = read(file)
    from ...report.study import document

    answer(document(found, members), as_json)


def read(file: Path) -> Study:
    """A study as its file has it now."""
    with sentences(str(file)):
        from ...results.studied import Study

        found = Study.open(file)
    return found


ENDINGS = (".csv", ".nc", ".parquet")


def export(
    file: FileArgument,
    target: Annotated[
        Path, typer.Argument(metavar="OUT", help="File to write: .csv, .nc or .parquet.", show_default=False)
    ],
    force: ForceFile = False,
) -> None:
    """Write a study as a table of its members (CSV, Parquet) or a labelled dataset (NetCDF), with units."""
    with sentences(str(target)):
        refuse_ending(target, ENDINGS)
        refuse_taken(target, force)
    found = read(file)
    with (
        sentences(str(file)),
        writing(str(target), "The study is as it was, and so is what was there before."),
    ):
        found.export(target)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)})")


FiguresOption = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FOLDER", help="Where to.", show_default="FILE-figures"),
]
FigureOption = Annotated[
    list[str] | None,
    typer.Option("--figure", metavar="NAME", help="maps, curves, parallel or fronts; all unless named."),
]
MeasureOption = Annotated[
    list[str] | None,
    typer.Option("--measure", metavar="NAME", help="A measure to draw, in this order; all unless named."),
]
LargerOption = Annotated[
    list[str] | None,
    typer.Option(
        "--maximise", metavar="NAME", help="A measure that is better the larger it is; may be repeated."
    ),
]
Kind = Annotated[str, typer.Option("--kind", metavar="KIND", help="png, svg or pdf.")]


def plot(
    file: FileArgument,
    folder: FiguresOption = None,
    figure: FigureOption = None,
    measure: MeasureOption = None,
    maximise: LargerOption = None,
    kind: Kind = "png",
) -> None:
    """Draw a study: heat maps, curves with bands, parallel coordinates, Pareto fronts (the smaller, the
    better, unless --maximise says not).
    """
    found = read(file)
    target = folder if folder is not None else file.with_name(f"{file.stem}-figures")
    with sentences(str(file)), writing(str(target), "The study is as it was."):
        from ...plots.study import save_figures

        target.mkdir(parents=True, exist_ok=True)
        paths = save_figures(
            found, target, figure or (), measure or (), f".{kind.lower().removeprefix('.')}", maximise or ()
        )
    for path in paths:
        typer.echo(path)


Limits = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="MEASURE=VALUE",
        help='The most allowed, as in C.force.max="2 kN"; else the table limit of the study.',
    ),
]
Shares = Annotated[str, typer.Option("--quantiles", metavar="%,%", help="Quantiles to tell, in percent.")]
Confidence = Annotated[
    float, typer.Option(min=50.0, max=99.99, help="Confidence of their limits, in percent.")
]
Measures = Annotated[
    list[str] | None,
    typer.Option("--measure", metavar="NAME", help="A measure; may be repeated.", show_default="all"),
]


def tolerance(
    file: FileArgument,
    limit: Limits = None,
    quantiles: Shares = "1,50,95,99",
    confidence: Confidence = 95.0,
    laws: LawsOption = None,
    as_json: JsonOption = False,
) -> None:
    """What the machines of a study say of all that are made so: quantiles of each measure, and the share that
    fails a limit, with confidence.

    The members have to be drawn (method = "random", "latin" or "sobol") from fits, tolerances or
    distributions; those that were added one by one do not count. Limits of confidence are those of
    independent draws.
    """
    found = read(file)
    with sentences(str(file)):
        from ...studies.methods.tolerance import spreads

        take_laws(laws)
        rows = spreads(found, bounds_of(found, limit or ()), percents(quantiles), confidence / 100.0)
    from ...report.study import tolerances

    answer(tolerances(found, str(file), confidence / 100.0, rows), as_json)


def indices(
    file: FileArgument, measure: Measures = None, laws: LawsOption = None, as_json: JsonOption = False
) -> None:
    """Which parameters a measure hangs on, over all they vary: Sobol' indices (method = "saltelli") or
    effects of Morris (method = "morris").

    For the slope at one point, by derivatives, see `vfife sensitivity`.
    """
    found = read(file)
    with sentences(str(file)):
        from ...studies.methods.sensitivity_indices import sensitivities

        take_laws(laws)
        every = sensitivities(found, measure or ())
    from ...report import study as answers

    answer(answers.indices(found, str(file), every), as_json)


def bounds_of(found: Study, given: Any) -> tuple[Bound, ...]:
    """Limits of the command line, or else those of the study file. Raises ModelError, ValueError."""
    from ...studies.methods import tolerance as room

    limit: dict[str, float | str] = {}
    for text in given:
        measure, sign, value = text.partition("=")
        if not sign:
            raise ValueError(
                f'--limit {text}: this is not MEASURE=VALUE; write it as in --limit C.force.max="2 kN"'
            )
        limit[measure.strip()] = number_or_text(value.strip())
    return room.bounds_of(found, limit)


def number_or_text(text: str) -> float | str:
    """A bare number is one in SI units."""
    try:
        return float(text)
    except ValueError:
        return text


def percents(text: str) -> tuple[float, ...]:
    """Shares from percents. Raises ValueError."""
    try:
        found = tuple(sorted({float(part) / 100.0 for part in text.split(",")}))
    except ValueError:
        found = ()
    if not found or not all(0.0 < one < 1.0 for one in found):
        raise ValueError(
            f"--quantiles {text}: these are not percents between 0 and 100; write them as in --quantiles"
            " 5,50,95"
        )
    return found
