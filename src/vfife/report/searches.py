"""Documents of searches: the best cases of an optimisation, the cheapest fits that keep a limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..measures.catalogue import IMPACT_SPEED, NO_IMPACT
from .amounts import limit_digits, limit_quantity, quantities, quantity
from .case_errors import error_table, errors_data, study_cautions
from .document import Caution, Document, Paragraph, Part, Table
from .study import measure_words, no_blows, remarks_on_start

if TYPE_CHECKING:
    from ..results.study import Study
    from ..studies.study_work import Allocation, Optimum


def optimum(answer: Optimum) -> Document:
    """Return a document of the best cases of a search."""
    study, search, front = answer.study, answer.search, answer.best
    rows = [
        (*(quantity(case.parameters[axis.name], axis.unit) for axis in study.parameters),
         *(measure_words(name, (case.values or {}).get(name), unit) for name, unit in study.measures.items()))
        for case in front
    ]  # fmt: skip
    alone = len(search.aims) == 1
    aims = [*search.minimised, *(name if alone else f"{name} (large)" for name in search.maximised)]
    choice = f"the {'least' if search.minimised else 'most'} of" if alone else "the Pareto front of"
    last = f", the last {answer.refined:,} by derivatives" if answer.refined else ""
    feasible = sum(case.feasible for case in answer.cases)
    text = f"{len(answer.cases):,} cases{last}, {feasible:,} within the limits; {choice} {', '.join(aims)}:"
    heads = (*(parameter.name for parameter in study.parameters), *study.measures)
    parts: list[Part] = [Paragraph(text), Table.numeric(heads, rows, texts=0)] if front else []
    if any(NO_IMPACT in row for row in rows):
        measure = next(name for name in study.measures if name.endswith(IMPACT_SPEED))
        parts.append(
            Caution(
                f"{NO_IMPACT} in a best case: neighbouring values may knock hard: vary it before you choose."
                f" {no_blows(measure)}"
            )
        )
    parts += reservations(study)
    if answer.reason:
        parts.append(
            Caution(f"derivatives give no further improvement: {answer.reason}.", "note", aside=True)
        )
    data = {
        "file": str(study.path),
        "cases": len(answer.cases),
        "members": len(answer.cases),  # the key of version 0.2
        "feasible": feasible,
        "refined": answer.refined,
        "why": answer.reason,
        "minimised": list(search.minimised),
        "maximised": list(search.maximised),
        "best": [
            {"case": case.number, "parameters": case.parameters, "measures": dict(case.values or {})}
            for case in front
        ],
        "errors": errors_data(study),
        "remarks": remarks_on_start(study),
    }
    return Document(parts, data=data)


def reservations(study: Study) -> list[Part]:
    """Return what the values of a search leave open: what they are counted over, their numerical errors, and
    turns that differ.
    """
    remarks: list[Part] = [Paragraph(text, lines="whole") for text in remarks_on_start(study)]
    return [*remarks, error_table(study), *study_cautions(study)]


def allocation(answer: Allocation) -> Document:
    """Return a document of the cheapest fits with which nearly all machines keep a limit."""
    task, choice, estimate = answer.task, answer.choice, answer.quantile
    table = task.table
    data = {
        "file": str(answer.study.path),
        "fits": answer.fits,
        "cost": answer.cost,
        "measure": table.measure,
        "limit": task.bound.high,
        "share": table.share,
        "confidence": table.confidence,
        "quantile": None if estimate is None else estimate.value,
        "failures": answer.failures,
        "machines": answer.machines,
        "rejected": [{"fits": fits, "cost": cost} for fits, cost in answer.rejected],
        "errors": errors_data(answer.study),
        "remarks": remarks_on_start(answer.study),
    }
    remarks = reservations(answer.study)
    if choice is None or estimate is None:
        return Document(remarks, data=data)
    rows = []
    for parameter, option, chosen in zip(task.parameters, choice.options, task.chosen, strict=True):
        if chosen:
            low, high = option.clearance.limits
            rows.append(
                (parameter.name, option.name, f"{option.cost:g}", quantities(low, high, "m", exact=True))
            )
    unit, digits = answer.study.measures[table.measure], limit_digits(task.bound.high, [estimate.value])
    reached, limit = (limit_quantity(value, unit, digits) for value in (estimate.value, task.bound.high))
    quantile = (
        f"{100.0 * table.share:g} % quantile of {table.measure}: {reached}, limit"
        f" {limit}; {answer.failures} of {answer.machines:,} machines are beyond it"
        f" ({100.0 * table.confidence:g} % confidence)"
    )
    cheaper = (
        f"cost {choice.cost:g}; {len(answer.rejected):,} choices as cheap or cheaper do not keep the limit"
    )
    heads = ("fit of", "fit", "cost", "clearance")
    table_part = Table(heads, rows, numbers=(2,))
    return Document([table_part, Paragraph(cheaper), Paragraph(quantile), *remarks], data=data)
