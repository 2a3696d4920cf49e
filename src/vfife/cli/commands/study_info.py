"""Commands for a study that was made, or that is still growing: show, plot, export, tolerance, indices."""

from __future__ import annotations

from pathlib import Path

import typer

from ...report import study as documents
from ...results.study import Study
from ...studies.methods.sensitivity_indices import sensitivities
from ...studies.methods.tolerance import bounds_of as bounds
from ...studies.methods.tolerance import spreads
from ...studies.spec.limits import Bound
from ...units import assignments
from ..arguments.studies import ExportOptions, IndicesOptions, PlotOptions, ShowOptions, ToleranceOptions
from ..outputs import one_target, refuse_ending, refuse_existing
from ..terminal import amount_of_bytes, sentences, writing
from ..values import take_laws

ENDINGS = (".csv", ".xlsx", ".nc", ".parquet")


def show(options: ShowOptions) -> None:
    """Run ``vfife study show``."""
    study = read(options.file)
    options.answer(documents.document(study, options.cases, options.members))


def read(file: Path) -> Study:
    """Open a study in the present state of its file."""
    with sentences(str(file)):
        return Study.open(file)


def export(options: ExportOptions) -> None:
    """Run ``vfife study export``."""
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


def plot(options: PlotOptions) -> None:
    """Run ``vfife study plot``."""
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


def tolerance(options: ToleranceOptions) -> None:
    """Run ``vfife study tolerance``."""
    study, confidence = read(options.file), options.confidence / 100.0
    with sentences(str(options.file)):
        take_laws(options.laws)
        rows = spreads(study, bounds_of(study, options.limit or []), percents(options.quantiles), confidence)
    options.answer(documents.tolerances(study, str(options.file), confidence, rows))


def indices(options: IndicesOptions) -> None:
    """Run ``vfife study indices``."""
    study = read(options.file)
    with sentences(str(options.file)):
        take_laws(options.laws)
        rows = sensitivities(study, options.measure or ())
    options.answer(documents.indices(study, str(options.file), rows))


def bounds_of(study: Study, texts: list[str]) -> tuple[Bound, ...]:
    """Limits of the command line, or else those of the study file. Raises ModelError, ValueError."""
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
