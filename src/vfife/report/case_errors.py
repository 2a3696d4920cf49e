"""Numerical errors of the cases of a study in words and tables, and the caution of a sensitive motion."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..numerics.outward import UP
from ..results.case_errors import NOT_ESTIMATED, turn_changes, uncertain_ranges
from ..solvers.companions import SENSITIVE
from ..store.studyfile import REPEATS, SEARCH
from .amounts import Digits, quantity
from .case_cautions import case_numbers, caution_sentences
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


def error_share(study: Study, result: Any) -> str:
    """Return the share of the numerical error of cases in the variance of a measure."""
    error = study.errors.get(result.measure)
    text, values = error_words(error, result.unit), study.values(result.measure)
    variance = float(np.nanvar(values)) if np.isfinite(values).any() else 0.0
    if error is None or variance == 0.0:
        return text
    return (
        f"{text} The mean square of this error is {100.0 * error.rms * error.rms / variance:.2g} % of the"
        " variance; margins are those of sampling alone."
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
    listed = case_numbers(sorted(study.sensitive_measures))
    remedy = "means over more turns (last = N) scatter less"
    if study.request["wanted"].get("duration"):
        remedy = "a shorter duration, or a smaller step, may make them agree"
    return (
        f"Not periodic, or sensitive: {sensitive} of {count} sampled cases depend on the step by more than"
        f" {100.0 * SENSITIVE:g} % ({listed}; case {number} in {names[0]}). Their motion need not"
        " repeat, and their values scatter: quote each with the largest numerical error, never alone;"
        f" {remedy}."
    )


def part_words(study: Study) -> str:
    """Return over which turns the measures of cases are."""
    plan = study.request["wanted"]
    if plan["last"] > 1:
        return f"the last {plan['last']} turns (means)"
    has_means = any(is_mean_of_period(outcome) for outcome in study.outcomes.values())
    return "the last turn, or of whole periods (means)" if has_means else "the last turn"


def turn_words(study: Study) -> str:
    """Return until when each case runs and which turns are measured, in addition to its number of turns."""
    settle = study.request["wanted"]["settle"]
    until = "" if settle is None else f" at most, until they repeat within {100.0 * settle:g} %"
    return f"{until}; measures are of {part_words(study)}"


def is_mean_of_period(outcome: Any) -> bool:
    """Return whether measures of a case are means over a period of several turns."""
    period, turns = outcome.get("period"), outcome.get("measured_turns")
    return period is not None and period > 1 and turns is not None and turns % period == 0


def turn_data(study: Study) -> dict[str, Any]:
    """Return as data the number of cases by period, and of those whose measured turns differ."""
    changes = turn_changes(study.outcomes, study.outcomes)
    return {"periods": periods(study), "different_turns": len(changes)}


def periods(study: Study) -> dict[str, int] | None:
    """Return the number of cases with ``settle`` by period, of those that did not repeat ("none"), and of
    those of former versions with an unknown period ("unknown"); None without ``settle``.
    """
    if study.request["wanted"].get("settle") is None:
        return None
    counts: dict[str, int] = {}
    for outcome in study.outcomes.values():
        if outcome["status"] == "complete":
            period = outcome.get("period") or ("none" if is_without_period(outcome) else "unknown")
            counts[str(period)] = counts.get(str(period), 0) + 1
    return dict(sorted(counts.items()))


def is_without_period(outcome: Any) -> bool:
    """Return whether a case with ``settle`` is complete, and its turns do not repeat."""
    return bool(outcome["status"] == "complete" and outcome["settled"] is None)


def period_remarks(study: Study) -> list[str]:
    """Return a sentence on cases that repeat with a period of several turns, and what their measures are."""
    means = {k: outcome["period"] for k, outcome in study.outcomes.items() if is_mean_of_period(outcome)}
    if not means:
        return []
    periods_of_means = list(means.values())
    of_period = [
        f"{periods_of_means.count(period):,} of period {period}" for period in sorted(set(periods_of_means))
    ]
    return [
        f"Turns alternate in {len(means):,} of {len(study.done):,} cases ({', '.join(of_period)}):"
        f" their measures are means over whole periods{difference_words(study, means)}."
    ]


def difference_words(study: Study, numbers: list[int] | dict[int, Any]) -> str:
    """Return which of the cases of these ``numbers`` has the turns that are farthest apart, and how far; ""
    where none differ.
    """
    changes = turn_changes({number: study.outcomes[number] for number in numbers}, study.outcomes)
    shares = [(share, -k, name) for k, by_name in changes.items() for name, share in by_name.items()]
    if not shares:
        return ""
    _, negative, name = max(shares)
    width = quantity(study.outcomes[-negative]["ranges"][name], study.measures[name])
    return f"; single turns differ most in case {-negative}, in {name} by {width}"


def turn_cautions(study: Study) -> list[str]:
    """Return the cautions of measures of turns that differ from those before them."""
    plan, outcomes = study.request["wanted"], study.outcomes
    if plan.get("settle") is not None:
        return settling_cautions(study)
    changes = turn_changes(outcomes, outcomes)
    if not changes or plan["last"] > 1:
        return []
    return [
        f"Turns differ: in {len(changes):,} of {len(study.done):,} cases a measure differs between"
        f" the last turns by more than {100.0 * SENSITIVE:g} %{difference_words(study, changes)}. Values are"
        ' of the last turn alone, where vfife run takes means over turns: settle = "1 %" goes on until turns'
        " repeat and measures whole periods, last = N takes means."
    ]


def settling_cautions(study: Study) -> list[str]:
    """Return the cautions of a study with ``settle``: of cases of which a part of a period is measured, of
    those that do not repeat, and of those of former versions.
    """
    plan, outcomes, texts = study.request["wanted"], study.outcomes, list[str]()
    count = f"of {len(study.done):,} cases"
    uncertain = uncertain_ranges(plan, outcomes)
    if parts := [number for number in uncertain if outcomes[number]["period"] is not None]:
        texts.append(
            f"Not whole periods: turns alternate in {len(parts):,} {count}, and last = {plan['last']}"
            f" measures a part of the period{difference_words(study, parts)}. Their errors include"
            " this difference; without last, measures are of whole periods."
        )
    if left := [number for number, outcome in outcomes.items() if is_without_period(outcome)]:
        single = "values are of the last turn, and errors include this difference"
        values = single if plan["last"] == 1 else f"values are means over the last {plan['last']} turns"
        texts.append(
            f"Not settled: turns of {len(left):,} {count} do not repeat within"
            f" {plan['turns']:,} turns{difference_words(study, left)}. Their {values}; last = N"
            " takes means over more turns."
        )
    if former := (periods(study) or {}).get("unknown"):
        texts.append(
            f"Periods are unknown: an older version of vfife computed {former:,} {count}, and measured one"
            " turn also where turns alternate. Compute the study again in another file."
        )
    return texts


def sensitivity_data(study: Study) -> dict[str, Any]:
    """Return how many of the sampled cases are sensitive, and their numbers, as data."""
    sensitive, count = study.sensitive
    return {"cases": sensitive, "sample": count, "numbers": sorted(study.sensitive_measures)}


def errors_data(study: Study) -> dict[str, Any] | None:
    """Return the numerical errors of cases by measure, as data; None where none is estimated."""
    return {name: dataclasses.asdict(error) for name, error in study.errors.items()} or None


def missing_error(study: Study) -> str:
    """Return why no numerical error of a case is estimated."""
    if not any(outcome["status"] == "complete" for outcome in study.outcomes.values()):
        return "no case is complete"
    if study.request["raw"].get("method") == SEARCH:
        return "a search repeats no case: vfife run with the values of one has its ranges and cautions"
    if REPEATS not in study.meta:
        return "no case was repeated with another step yet: the same study continues with them"
    return "no repetition with another step gave a value"


def error_table(study: Study) -> Part:
    """Return a table of the numerical error of a case: typical, largest, how far its last turns differ where
    they were compared, and how it was estimated.
    """
    if not study.errors:
        return Paragraph(f"{error_words(None, '').removesuffix('.')}, because {missing_error(study)}.")
    rows, turns = list[tuple[str, ...]](), turn_widths(study)
    for name, unit in study.measures.items():
        if (error := study.errors.get(name)) is None:
            cells = [NOT_ESTIMATED, "", ""]
        else:
            cells = [typical_words(error, unit), quantity(error.most, unit, UP), error.words]
        rows.append((name, *cells, *([turns.get(name, "")] if turns else [])))
    heads = ["numerical error of a case", "typically", "at most", "estimated from"]
    return Table([*heads, *["last turns differ by"] * bool(turns)], rows, numbers=(1, 2, 4), names=(0,))


def turn_widths(study: Study) -> dict[str, str]:
    """Return by how much each measure differs at most between the last turns of a case, in words; empty where
    no turns were compared.
    """
    ranges = [outcome["ranges"] for outcome in study.outcomes.values()]
    names = [name for name in study.measures if any(name in widths for widths in ranges)]
    largest = {name: max(widths.get(name, 0.0) for widths in ranges) for name in names}
    return {name: f"up to {quantity(largest[name], study.measures[name], UP)}" for name in names}


def study_cautions(study: Study) -> list[Part]:
    """Return the cautions of a study: one whose measures are of an older definition, those of turns that
    differ, one whose sample is sensitive to the step, and those that its cases have as runs.
    """
    former = FORMER_MEASURES if study.has_former_measures else ""
    texts = [former, *turn_cautions(study), sensitivity_words(study), *caution_sentences(study)]
    return [Caution(text, "warning") for text in texts if text]
