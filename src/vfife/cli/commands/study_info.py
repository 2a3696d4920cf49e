"""Commands for a study that was made, or that is still growing: show, plot, export, tolerance, indices."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..options import JsonOptions, LawOptions, StudyFileOptions, argument, flag, option, take_laws
from ..outputs import DECIMAL, one_target, refuse_ending, refuse_existing
from ..terminal import amount_of_bytes, sentences, writing

if TYPE_CHECKING:
    from ...results.study import Study
    from ...studies.spec.limits import Bound

ENDINGS = (".csv", ".xlsx", ".nc", ".parquet")


class ShowOptions(StudyFileOptions, JsonOptions):
    """Options of ``vfife study show``."""

    cases: bool = flag("--cases", "Every case with its results.")
    members: bool = typer.Option(False, "--members", hidden=True)


def show(options: ShowOptions) -> None:
    """Results of a study so far: least, mean and largest value of each measure and where, and what failed."""
    study = read(options.file)
    from ...report.study import document

    options.answer(document(study, options.cases, options.members))


def read(file: Path) -> Study:
    """Open a study in the present state of its file."""
    with sentences(str(file)):
        from ...results.study import Study

        return Study.open(file)


class ExportOptions(StudyFileOptions):
    """Options of ``vfife study export``."""

    out: Path | None = argument("File to write: .csv, .xlsx, .nc or .parquet.", "[OUT]", None)
    target: Path | None = option(None, "The same.", "OUT", "-o", "--output")
    decimal: str = option("point", DECIMAL, "point|comma")
    force: bool = flag("--force", "Replace the file if there is one.")


def export(options: ExportOptions) -> None:
    """Write a study as a table of its cases (CSV, XLSX, Parquet) or a dataset (NetCDF), with units."""
    with sentences(str(options.file)):
        target = one_target(options.out, options.target)
    with sentences(str(target)):
        refuse_ending(target, ENDINGS)
        refuse_existing(target, options.force)
    study = read(options.file)
    with (
        sentences(str(options.file)),
        writing(str(target), "The study is as it was, and so is what was there before."),
    ):
        study.export(target, options.decimal)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)})")


class PlotOptions(StudyFileOptions):
    """Options of ``vfife study plot``."""

    folder: Path | None = option(
        None, "Folder of the figures.", "FOLDER", "-o", "--output", show_default="FILE-figures"
    )
    figure: list[str] | None = option(None, "maps, curves, parallel or fronts; all unless named.", "NAME")
    measure: list[str] | None = option(None, "A measure to draw, in this order; all unless named.", "NAME")
    maximise: list[str] | None = option(
        None, "A measure that is better the larger it is; may be repeated.", "NAME"
    )
    kind: str = option("png", "png, svg or pdf.", "KIND")


def plot(options: PlotOptions) -> None:
    """Draw a study: heat maps, curves with bands, parallel coordinates, Pareto fronts (of the smallest
    values; --maximise names measures that shall be large).
    """
    file = options.file
    study = read(file)
    target = options.folder if options.folder is not None else file.with_name(f"{file.stem}-figures")
    with sentences(str(file)), writing(str(target), "The study is as it was."):
        from ...plots.study import save_figures

        target.mkdir(parents=True, exist_ok=True)
        ending = f".{options.kind.lower().removeprefix('.')}"
        paths = save_figures(
            study, target, options.figure or (), options.measure or (), ending, options.maximise or ()
        )
    for path in paths:
        typer.echo(path)


class ToleranceOptions(StudyFileOptions, LawOptions, JsonOptions):
    """Options of ``vfife study tolerance``."""

    limit: list[str] | None = option(
        None,
        'The most allowed, as in C.force.max="2 kN"; else the table limit of the study.',
        "MEASURE=VALUE",
    )
    quantiles: str = option("1,50,95,99", "Quantiles to tell, in percent.", "%,%")
    confidence: float = option(95.0, "Confidence of their limits, in percent.", min=50.0, max=99.99)


def tolerance(options: ToleranceOptions) -> None:
    """Estimate the scatter of a series of machines from a study: quantiles of each measure, and the share
    that exceeds a limit, with confidence.

    The cases must be drawn (method = "random", "latin" or "sobol") from fits, tolerances or distributions;
    cases added one by one do not count. The confidence limits are those of independent draws.
    """
    study, confidence = read(options.file), options.confidence / 100.0
    with sentences(str(options.file)):
        from ...studies.methods.tolerance import spreads

        take_laws(options.laws)
        rows = spreads(study, bounds_of(study, options.limit or []), percents(options.quantiles), confidence)
    from ...report.study import tolerances

    options.answer(tolerances(study, str(options.file), confidence, rows))


class IndicesOptions(StudyFileOptions, LawOptions, JsonOptions):
    """Options of ``vfife study indices``."""

    measure: list[str] | None = option(None, "A measure; may be repeated.", "NAME", show_default="all")


def indices(options: IndicesOptions) -> None:
    """Which parameters a measure depends on over their whole ranges: Sobol' indices (method = "saltelli") or
    effects of Morris (method = "morris").

    For the slope at one point, by derivatives, see `vfife sensitivity`.
    """
    study = read(options.file)
    with sentences(str(options.file)):
        from ...studies.methods.sensitivity_indices import sensitivities

        take_laws(options.laws)
        rows = sensitivities(study, options.measure or ())
    from ...report.study import indices as document

    options.answer(document(study, str(options.file), rows))


def bounds_of(study: Study, texts: list[str]) -> tuple[Bound, ...]:
    """Limits of the command line, or else those of the study file. Raises ModelError, ValueError."""
    from ...studies.methods.tolerance import bounds_of as bounds
    from ...units import assignments

    items = assignments("--limit", texts, 'C.force.max="2 kN"', "not MEASURE=VALUE")
    return bounds(study, {measure: number_or_text(value) for measure, value in items})


def number_or_text(text: str) -> float | str:
    """Convert a bare number to a float in SI units, and keep any other text."""
    try:
        return float(text)
    except ValueError:
        return text


def percents(text: str) -> tuple[float, ...]:
    """Shares from percents. Raises ValueError."""
    try:
        shares = tuple(sorted({float(part) / 100.0 for part in text.split(",")}))
    except ValueError:
        shares = ()
    if not shares or not all(0.0 < share < 1.0 for share in shares):
        raise ValueError(
            f"--quantiles {text}: these are not percents between 0 and 100; write them as in --quantiles"
            " 5,50,95"
        )
    return shares
