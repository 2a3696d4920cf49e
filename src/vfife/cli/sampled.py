"""What a sample of machines tells: ``vfife study tolerance`` and ``vfife study indices``."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import JsonOption, LawsOption, take_laws
from .studied import FileArgument, read
from .terminal import counted, grid, output, print_json, row, sentences, tell

if TYPE_CHECKING:
    from ..results.studied import Study
    from ..study.limits import Bound, Estimate

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
    from ..report.study import error_words, quantity
    from ..results.member_errors import NOT_ESTIMATED

    found = read(file)
    with sentences(str(file)):
        from ..study.tolerance import spreads

        take_laws(laws)
        rows = spreads(found, bounds_of(found, limit or ()), percents(quantiles), confidence / 100.0)
    if as_json:
        print_json(
            {"study": found.name, "file": str(file), "confidence": confidence / 100.0, "machines": rows[0].machines, "measures": plain(rows)}
        )
        return
    table = grid("measure", "of all machines", "value", "not below", "not above", right=(2, 3, 4))
    for one in rows:
        row(table, one.measure, "mean", *(known(value, one.unit) for value in (one.mean, one.average.low, one.average.high)))
        row(table, "", "standard deviation", quantity(one.deviation, one.unit), NOT_ESTIMATED, NOT_ESTIMATED)
        for share, at in one.quantiles.items():
            row(table, "", f"{100.0 * share:g} % are below", *(known(value, one.unit) for value in (at.value, at.low, at.high)))
        if one.bound is not None and one.failing is not None:
            failing = (f"{100.0 * value:.3g} %" for value in (one.failing.value, one.failing.low, one.failing.high))
            row(table, "", f"fail: {one.bound.words(one.unit)}", *failing)
    console = output()
    console.print(
        f"{found.model}: {counted(rows[0].machines, 'machine')}; not below and not above what stands there with {confidence:g} % confidence"
    )
    console.print(table)
    for one in rows:
        console.print(f"{one.measure}: {error_words(one.numerical, one.unit)}", soft_wrap=True)
    held = "Limits hold the numerical error of members, too." if found.errors else "Limits are those of sampling alone."
    console.print(held)
    if (other := len(found.done) - rows[0].machines) > 0:
        tell("note", f"{counted(other, 'member')} of the file left out: points, members of a search, or samples of former tolerances.")


def indices(file: FileArgument, measure: Measures = None, laws: LawsOption = None, as_json: JsonOption = False) -> None:
    """Which parameters a measure hangs on, over all they vary: Sobol' indices (method = "saltelli") or effects of Morris (method = "morris").

    For the slope at one point, by derivatives, see `vfife sensitivity`.
    """
    found = read(file)
    with sentences(str(file)):
        from ..study.sensitivity_indices import sensitivities

        take_laws(laws)
        every = sensitivities(found, measure or ())
    if as_json:
        from ..report.study import errors_plainly

        rows = {one.measure: [dataclasses.asdict(two) for two in one.rows] for one in every}
        print_json({"study": found.name, "file": str(file), "measures": rows, "errors": errors_plainly(found)})
        return
    console = output()
    for one in every:
        console.print(index_table(one))
        console.print(numerical_share(found, one), soft_wrap=True)
        if one.left_out:
            console.print(f"{one.left_out:,} groups of the design were left out, for a member of them has no value")


def numerical_share(found: Study, one: Any) -> str:
    """How much of what a measure varies by is the numerical error of members, by which its indices may be wrong."""
    import numpy as np

    from ..report.study import error_words

    error = found.errors.get(one.measure)
    said, values = error_words(error, one.unit), found.values(one.measure)
    spread = float(np.nanvar(values)) if np.isfinite(values).any() else 0.0
    if error is None or spread == 0.0:
        return said
    return f"{said} Its square is {100.0 * error.rms**2 / spread:.2g} % of the variance; margins are those of sampling alone."


def index_table(one: Any) -> Any:
    """The table of a measure, what matters most first."""
    from ..report.study import quantity
    from ..study.sensitivity_indices import Index

    if isinstance(one.rows[0], Index):
        table = grid(one.measure, "alone", "±", "with others", "±", right=(1, 2, 3, 4))
        for two in sorted(one.rows, key=lambda two: -two.total):
            row(table, two.parameter, *(f"{value:.3f}" for value in (two.first, two.first_margin, two.total, two.total_margin)))
        return table
    table = grid(one.measure, "size of the effect", "±", "mean", "deviation", right=(1, 2, 3, 4))
    for two in sorted(one.rows, key=lambda two: -two.size):
        row(table, two.parameter, *(quantity(value, one.unit) for value in (two.size, two.size_margin, two.mean, two.deviation)))
    return table


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


def known(value: float, unit: str) -> str:
    """A quantity; nothing where the sample is too small for it."""
    from ..report.study import quantity

    return quantity(value, unit) if math.isfinite(value) else "-"


def plain(rows: Any) -> dict[str, Any]:
    """What JSON can say of spreads."""

    def said(at: Estimate) -> dict[str, float | None]:
        return {name: value if math.isfinite(value) else None for name, value in vars(at).items()}

    return {
        one.measure: {
            "unit": one.unit,
            "count": one.count,
            "mean": one.mean,
            "average": said(one.average),
            "numerical": None if one.numerical is None else dataclasses.asdict(one.numerical),
            "deviation": one.deviation,
            "quantiles": {f"{share:g}": said(at) for share, at in one.quantiles.items()},
            "limit": None
            if one.bound is None
            else {name: getattr(one.bound, name) for name in ("low", "high") if math.isfinite(getattr(one.bound, name))},
            "failing": None if one.failing is None else said(one.failing),
        }
        for one in rows
    }
