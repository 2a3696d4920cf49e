"""Numerical errors of the cases of a study in words and tables, and the caution of a sensitive motion."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from ..numerics.outward import UP
from ..results.case_errors import NOT_ESTIMATED
from ..solvers.companions import SENSITIVE
from ..store.studyfile import REPEATS
from .amounts import Digits, quantity
from .document import Caution, Paragraph, Part, Table

if TYPE_CHECKING:
    from ..results.case_errors import ErrorEstimate
    from ..results.study import Study


FORMER_MEASURES = (
    "Computed by an older version of vfife: where the duration is not a whole number of turns, measures"
    " are of the last turn counted from the start, not of the last 360 degrees before the end as of a"
    " run. Compute the study again in another file."
)


def error_words(error: ErrorEstimate | None, unit: str) -> str:
    """Return the numerical error of a case in one line."""
    if error is None:
        return f"Numerical error of a case: {NOT_ESTIMATED}."
    return (
        f"Numerical error of a case: typically {typical_words(error, unit)}, at most"
        f" {quantity(error.most, unit, UP)} ({error.words})."
    )


def typical_words(error: ErrorEstimate, unit: str) -> str:
    """Return the typical error, or below which least error it lies."""
    if error.typical < error.floor:
        return f"below {quantity(error.floor, unit, UP)}"
    return quantity(error.typical, unit)


def digits_of(study: Study, name: str) -> Digits:
    """Return which digits a measure is printed with: those in which cases differ, as far as its numerical
    error lets them be known.
    """
    finite = [float(value) for value in study.values(name) if math.isfinite(value)]
    spread = max(finite) - min(finite) if finite else 0.0
    error = study.errors.get(name)
    typical = error.typical if error is not None and math.isfinite(error.typical) else 0.0
    return Digits(spread, typical)


def sensitivity_words(study: Study) -> str:
    """Return a sentence on a sample that is sensitive to the step; "" for any other."""
    sensitive, count = study.sensitive
    if not sensitive:
        return ""
    number, names = next(iter(study.sensitive_measures.items()))
    example = f"case {number} in {names[0]}"
    remedy = "means over more turns (last = N) scatter less"
    if study.request["wanted"].get("duration"):
        remedy = "a shorter duration, or a smaller step, may make them agree"
    return (
        f"Not periodic, or sensitive: {sensitive} of {count} sampled cases depend on the step by more than"
        f" {100.0 * SENSITIVE:g} % ({'' if sensitive == 1 else 'such as '}{example}). Their motion need not"
        " repeat, and their values scatter: quote each with the largest numerical error, never alone;"
        f" {remedy}."
    )


def sensitivity_data(study: Study) -> dict[str, int]:
    """Return how many of the sampled cases are sensitive, as data."""
    sensitive, count = study.sensitive
    return {"cases": sensitive, "sample": count}


def errors_data(study: Study) -> dict[str, Any] | None:
    """Return the numerical errors of cases by measure, as data; None where none is estimated."""
    return {name: dataclasses.asdict(error) for name, error in study.errors.items()} or None


def missing_error(study: Study) -> str:
    """Return why no numerical error of a case is estimated."""
    if not any(outcome["status"] == "complete" for outcome in study.outcomes.values()):
        return "no case is complete"
    if REPEATS not in study.meta:
        return "no case was repeated with another step yet: the same study continues with them"
    return "no repetition with another step gave a value"


def error_table(study: Study) -> Part:
    """Return a table of the numerical error of a case: typical, largest, and how it was estimated."""
    if not study.errors:
        return Paragraph(f"{error_words(None, '').removesuffix('.')}, because {missing_error(study)}.")
    rows = []
    for name, unit in study.measures.items():
        if (error := study.errors.get(name)) is None:
            rows.append((name, NOT_ESTIMATED, "", ""))
        else:
            rows.append((name, typical_words(error, unit), quantity(error.most, unit, UP), error.words))
    heads = ("numerical error of a case", "typically", "at most", "estimated from")
    return Table(heads, rows, numbers=(1, 2), names=(0,))


def study_cautions(study: Study) -> list[Part]:
    """Return the cautions of a study: one whose measures are of an older definition, one whose sample is
    sensitive to the step.
    """
    texts = [FORMER_MEASURES if study.has_former_measures else "", sensitivity_words(study)]
    return [Caution(text, "warning") for text in texts if text]
