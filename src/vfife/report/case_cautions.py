"""Cautions that a case of a study would have as a run: kinds of them, found in a sample of the cases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from ..measures.landings import lasting_landings
from ..measures.whirl import backward_whirls
from ..results.run_data import RunData
from .cautions import contact_extremes, excesses
from .damping_cautions import damping_cautions, shock_cautions
from .fall_cautions import fall_of

if TYPE_CHECKING:
    from ..results.study import Study
    from ..solvers.record import Record

# Kinds of cautions in the order of a run, each with what it says of a case.
KINDS = {
    "fall": "the largest forces are those of the fall of the journals at the start, not of the machine",
    "law": "shocks or damping make the largest force of a joint, which the contact law decides",
    "landing": "a contact never ends and its law remembers the last landing, so that another start, law or"
    " step may lead to forces outside the errors stated here",
    "whirl": "friction drives a journal around its bearing (dry-friction whirl)",
    "excess": "penetrations or line pressures of the last turn are beyond what joints are built for",
}
MOST_NUMBERS = 12  # of cases that a sentence lists


class IdealPeaks(NamedTuple):
    """What cautions take from a run of the ideal mechanism: its largest values."""

    measures: Mapping[str, float]


def case_cautions(record: Record, ideal: Mapping[str, float] | None, repeats: bool) -> tuple[str, ...]:
    """Return the kinds of cautions that a run has whose measures are of this record, of all its turns or of
    the last one alone; ``ideal``: the largest values of the ideal mechanism; ``repeats``: whether its last
    turns are alike.
    """
    result = RunData(record, None if ideal is None else cast(Any, IdealPeaks(ideal)))
    by_kind = {
        "fall": fall_of(result) is not None,
        "law": bool(damping_cautions(result) or shock_cautions(result, ())),
        "landing": repeats and bool(lasting_landings(record)),
        "whirl": bool(backward_whirls(record)),
        "excess": bool(excesses(result, contact_extremes(record))),
    }
    return tuple(kind for kind in KINDS if by_kind[kind])


def cases_with_cautions(study: Study) -> dict[str, list[int]]:
    """Return the numbers of the examined cases with each kind of caution; kinds of none are left out."""
    examined = examined_cases(study)
    by_kind = {kind: [k for k, kinds in examined.items() if kind in kinds] for kind in KINDS}
    return {kind: numbers for kind, numbers in by_kind.items() if numbers}


def examined_cases(study: Study) -> dict[int, tuple[str, ...]]:
    """Return the kinds of cautions of the sampled cases that were examined, by number."""
    kinds = {case.number: study.repeats.get(case.number, {}).get("cautions") for case in study.done}
    return {number: of_case for number, of_case in kinds.items() if of_case is not None}


def caution_sentences(study: Study) -> Iterator[str]:
    """Yield a sentence on each kind of caution, with the cases that have it."""
    count = len(examined_cases(study))
    for kind, numbers in cases_with_cautions(study).items():
        subject = f"{len(numbers):,} of {count:,} examined cases ({case_numbers(numbers)})"
        if len(numbers) == count > 1:
            subject = f"All {count:,} examined cases"
        yield f"{subject}: {KINDS[kind]}."


def case_numbers(numbers: list[int]) -> str:
    """Return numbers of cases in words, the first of many."""
    listed = ", ".join(map(str, numbers[:MOST_NUMBERS]))
    left = f" and {len(numbers) - MOST_NUMBERS:,} more" * (len(numbers) > MOST_NUMBERS)
    return f"case{'s' * (len(numbers) > 1)} {listed}{left}"
