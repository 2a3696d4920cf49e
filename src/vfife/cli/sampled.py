"""What a sample of machines tells: ``vfife study tolerance`` and ``vfife study indices``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import JsonOption, LawsOption, take_laws
from .studied import FileArgument, read
from .terminal import answer, sentences

if TYPE_CHECKING:
    from ..results.studied import Study
    from ..study.limits import Bound

Limits = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="MEASURE=VALUE",
        help='The most allowed, as in C.force.max="2 kN"; else the table limit of the study.',
    ),
]
Shares = Annotated[str, typer.Option("--quantiles", metavar="%,%", help="Quantiles to tell, in percent.")]
Confidence = Annotated[float, typer.Option(min=50.0, max=99.99, help="Confidence of their limits, in percent.")]
Measures = Annotated[list[str] | None, typer.Option("--measure", metavar="NAME", help="A measure; may be repeated.", show_default="all")]


def tolerance(
    file: FileArgument,
    limit: Limits = None,
    quantiles: Shares = "1,50,95,99",
    confidence: Confidence = 95.0,
    laws: LawsOption = None,
    as_json: JsonOption = False,
) -> None:
    """What the machines of a study say of all that are made so: quantiles of each measure, and the share that fails a limit, with confidence.

    The members have to be drawn (method = "random", "latin" or "sobol") from fits, tolerances or distributions; those that were added one by one
    do not count. Limits of confidence are those of independent draws.
    """
    found = read(file)
    with sentences(str(file)):
        from ..study.tolerance import spreads

        take_laws(laws)
        rows = spreads(found, bounds_of(found, limit or ()), percents(quantiles), confidence / 100.0)
    from ..report.study import tolerances

    answer(tolerances(found, str(file), confidence / 100.0, rows), as_json)


def indices(file: FileArgument, measure: Measures = None, laws: LawsOption = None, as_json: JsonOption = False) -> None:
    """Which parameters a measure hangs on, over all they vary: Sobol' indices (method = "saltelli") or effects of Morris (method = "morris").

    For the slope at one point, by derivatives, see `vfife sensitivity`.
    """
    found = read(file)
    with sentences(str(file)):
        from ..study.sensitivity_indices import sensitivities

        take_laws(laws)
        every = sensitivities(found, measure or ())
    from ..report import study as answers

    answer(answers.indices(found, str(file), every), as_json)


def bounds_of(found: Study, given: Any) -> tuple[Bound, ...]:
    """Limits of the command line, or else those of the study file. Raises ModelError, ValueError."""
    from ..study import tolerance as room

    limit: dict[str, float | str] = {}
    for text in given:
        measure, sign, value = text.partition("=")
        if not sign:
            raise ValueError(f'--limit {text}: this is not MEASURE=VALUE; write it as in --limit C.force.max="2 kN"')
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
        raise ValueError(f"--quantiles {text}: these are not percents between 0 and 100; write them as in --quantiles 5,50,95")
    return found
