"""Documents of studies: extremes of measures, tables of cases, quantiles of samples, sensitivity indices."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..job.progress import counted
from ..laws.stored import standing_in
from ..measures import catalogue
from ..measures.catalogue import CASE, COUNTED, COUNTS_KEY, LAST, counted_from_start, is_reduction
from ..measures.landings import FORCE_ENDINGS
from ..modelfile import loads
from ..numerics.outward import DOWN, NEAREST, UP, significant
from ..results.case_errors import NOT_ESTIMATED
from ..store.lock import holder
from .amounts import Digits, limit_digits, limit_quantity, prefixed, quantities, quantity, quantity_of_digits
from .case_cautions import cases_with_cautions, examined_cases
from .case_errors import (
    digits_of,
    error_share,
    error_table,
    error_words,
    errors_data,
    part_words,
    period_remarks,
    sensitivity_data,
    study_cautions,
    turn_data,
    turn_words,
)
from .document import Caution, Document, Paragraph, Part, Table, incomplete
from .fall_cautions import fall_remark

if TYPE_CHECKING:
    from ..results.parameters import Varied
    from ..results.study import Study
    from ..store.studyfile import StudyCase
    from ..studies.methods.tolerance import Spread

MOST_FAILED = 10  # failed cases that are shown
LEAST_GROUPS = 256  # of a design of Saltelli, as recommended by docs/tolerance.md
FORCE = ".force.max"  # end of the name of a measure whose largest value needs the cautions of a run
# What measures of impacts leave out, after the name of the joint whose largest force has it.
NO_BLOWS = (
    "A blow in closed contact is no impact and is not counted here: {}.force.max has it, and vfife run with"
    " the values of a case states it."
)


# -------------------------------------------------------------------------------------------- values in words


def case_words(study: Study, case: StudyCase) -> str:
    """Return the parameter values of a case as text."""
    return values_words(
        study, dict(zip((parameter.name for parameter in study.parameters), study.at(case), strict=True))
    )


def values_words(study: Study, values: Mapping[str, Any] | None) -> str:
    """Return parameter values by name as text."""
    parameters = {parameter.name: parameter for parameter in study.parameters}
    return ", ".join(
        f"{name} {value_words(parameters[name], value)}" for name, value in (values or {}).items()
    )


def value_words(parameter: Varied, value: Any) -> str:
    """Return a value (SI) of a parameter in the unit in which the study file gives its values."""
    if isinstance(value, str) or value is None or not parameter.written:
        return quantity(value, parameter.unit)
    return f"{significant(value / parameter.written_factor, 5)} {parameter.written}"


def measure_words(name: str, value: float | None, unit: str, digits: Digits | None = None) -> str:
    """Return a value of a measure with the ``digits`` of its column; a largest impact speed of 0 in words,
    because it is no speed.
    """
    if catalogue.is_no_impact(name, value):
        return catalogue.NO_IMPACT
    return quantity(value, unit) if digits is None else quantity_of_digits(value, unit, digits)


def counts_words(study: Study) -> str:
    """Return the number of cases by status as text."""
    return ", ".join(f"{count:,} {word}" for word, count in study.counts.items() if count)


def _values(values: list[Any], parameter: Varied) -> str:
    """Return the values of a parameter in words, after the kind of its distribution."""
    kind, words = parameter.kind, parameter.words
    distinct = list(dict.fromkeys(values))
    if any(isinstance(value, str) for value in distinct):
        return ", ".join(map(str, distinct))
    if not distinct:
        return "-"
    distribution = {"fit": f"fit {words}, "}.get(kind, "" if kind in ("values", "range") else f"{kind}, ")
    if len(distinct) == 1:
        return value_words(parameter, distinct[0])
    if parameter.written:
        ends = f"{value_words(parameter, min(distinct))} to {value_words(parameter, max(distinct))}"
    else:
        ends = quantities(min(distinct), max(distinct), parameter.unit, exact=True)
    return f"{distribution}{len(distinct):,} values, {ends}"


def no_blows(measure: str) -> str:
    """Return a sentence that a measure of impacts does not count blows in closed contact, and where they
    are.
    """
    return NO_BLOWS.format(measure.partition(".")[0])


# ---------------------------------------------------------------------------------------------------- a study


def extremes(study: Study) -> dict[str, dict[str, Any]]:
    """Return least, mean and largest value of each measure, and the parameters at the extremes. Means are of
    the cases with impacts.
    """
    names, entries = [parameter.name for parameter in study.parameters], {}
    for name, unit in study.measures.items():
        pairs = [
            (float(value), case)
            for value, case in zip(study.values(name), study.done, strict=True)
            if math.isfinite(value)
        ]
        values = [value for value, _ in pairs]
        counted = [value for value in values if not catalogue.is_no_impact(name, value)] or values
        mean = math.fsum(counted) / len(counted) if counted else None
        ends: dict[str, dict[str, Any]] = {}
        for end, choose in (("least", min), ("largest", max)):
            value, case = choose(pairs, key=lambda pair: pair[0]) if pairs else (None, None)
            at = None if case is None else dict(zip(names, study.at(case), strict=True))
            ends[end] = {end: value, f"{end}_at": at}
        entries[name] = {"unit": unit, "count": len(pairs), **ends["least"], "mean": mean, **ends["largest"]}
    return entries


def parameter_table(study: Study, title: str = "") -> Table:
    """Return a table of the parameters, their values, and the numbers of the model that they change."""
    rows = [
        (
            parameter.name,
            _values([study.at(case)[k] for case in study.cases], parameter),
            ", ".join(parameter.paths),
        )
        for k, parameter in enumerate(study.parameters)
    ]
    return Table(("name" if title else "varied", "values", "numbers of the model"), rows, title)


def extreme_table(study: Study, title: str = "") -> Table:
    """Return a table of least, mean and largest value of each measure."""
    rows = []
    for name, entry in extremes(study).items():
        digits = digits_of(study, name)
        smallest, mean, largest = (
            measure_words(name, entry[key], entry["unit"], digits) for key in ("least", "mean", "largest")
        )
        rows.append(
            (
                name,
                smallest,
                values_words(study, entry["least_at"]),
                mean,
                largest,
                values_words(study, entry["largest_at"]),
            )
        )
    return Table(
        ("measure", "least", "at", "mean", "largest", "at"), rows, title, numbers=(1, 3, 4), names=(0,)
    )


def document(study: Study, cases: bool = False, members: bool = False) -> Document:
    """Compose the document of a study so far; with ``cases`` every case with its measures.

    ``members``: the same with the keys of version 0.2 as data.
    """
    at_work = None if study.path is None else holder(study.path.absolute().parent, f"{study.path.name}.lock")
    text = ", ".join(filter(None, (counted(len(study.cases), "case"), counts_words(study)))) + (
        f"; {at_work} is at work" if at_work else ""
    )
    plan = study.request["wanted"]
    turns = f"{counted(plan['turns'], 'turn')}{turn_words(study)}"
    if duration := plan.get("duration"):
        turns = f"{prefixed(duration, 's')}; measures are of the whole run, or of its last full turn"
    parts: list[Part] = [*incomplete(study.progress, "the same study with its file continues.")]
    parts += [Paragraph(text, lead=f"{study.model}: "), Paragraph(turns)]
    parts += [Paragraph(sentence, lines="whole") for sentence in remarks_on_turns(study)]
    parts += [parameter_table(study), extreme_table(study), error_table(study), *study_cautions(study)]
    parts += missing_cautions(study)
    if cases or members:
        parts.append(case_table(study, "status"))
    for case, reason in study.failed[:MOST_FAILED]:
        parts.append(
            Paragraph(f"{case_words(study, case)}: {reason}", lead=f"case {case.number}: ", lines="whole")
        )
    if len(study.failed) > MOST_FAILED:
        parts.append(Paragraph(f"... and {len(study.failed) - MOST_FAILED:,} more; --json has all of them"))
    data = (
        _data(study)
        | {"remarks": remarks_on_turns(study)}
        | ({"sampled": study.sampled} if study.sampled else {})
    )
    data |= {"cases": study.rows()} if cases else {}
    if members:
        data["members"] = [{"member": row["case"], **row} for row in study.rows()]
    return Document(parts, data=data)


def missing_cautions(study: Study) -> list[Part]:
    """Return a line on the run that has the cautions of a case in full: that of the largest force, or of the
    largest value of the first measure; it names the cautions that no case was examined for. Empty without
    contact and without values.
    """
    measures = extremes(study)
    name = next((name for name in measures if name.endswith(FORCE)), next(iter(measures), ""))
    largest = measures[name]["largest_at"] if name else None
    if largest is None or not has_contact(study):
        return []
    count = len(examined_cases(study))
    lead = "Cases have no cautions about contact laws, pressures and whirl: "
    if count:
        lead = f"Cautions are those of {count:,} of {len(study.done):,} cases, each at another step: "
    text = f"vfife run with {values_words(study, largest)} has all of them for the largest {name}."
    return [Paragraph(text, lead=lead)]


def has_contact(study: Study) -> bool:
    """Return whether the mechanism of a study has contact."""
    with standing_in(study.request["own_laws"]):
        return bool(loads(study.request["text"]).contacts)


def remarks_on_turns(study: Study) -> list[str]:
    """Return which measures are counted over whole cases, and whether turns were compared."""
    plan, remarks = study.request["wanted"], []
    counts = [name for name in study.measures if name.endswith(COUNTED)]
    remarks += remarks_on_start(study)
    if study.sampled:
        remarks.append(
            f"{', '.join(study.sampled)}: errors are {NOT_ESTIMATED}, for they depend on the outputs, between"
            " which impacts may lie; compare with four times the outputs, or take measures of all steps, as"
            " in C.force.max."
        )
    speeds = (name for name in counts if name.endswith(catalogue.IMPACT_SPEED))
    if quiet := [name for name in speeds if 0.0 in study.values(name)]:
        remarks.append(
            f"{', '.join(quiet)}: {catalogue.NO_IMPACT} means that the journal never left its bearing in this"
            " case; neighbouring values may knock hard, and means are of the other cases."
            f" {no_blows(quiet[0])}"
        )
    single = plan["last"] == 1 and plan["settle"] is None and not plan.get("duration")
    compared = any(outcome.get("ranges") for outcome in study.outcomes.values())
    if single and len(counts) < len(study.measures) and not compared:
        remarks.append(
            'Turns were not compared: last = N takes means over turns, settle = "1 %" compares them.'
        )
    return remarks + period_remarks(study)


def remarks_on_start(study: Study) -> list[str]:
    """Return which measures are counted from the start of each case on, with the key that counts them over
    the last turns; which are counted over these; and which may be largest forces of the fall at the start.
    """
    plan = study.request["wanted"]
    counts = plan.get("counts", CASE)
    names, remarks = counted_from_start(list(study.measures), counts), []
    if names:
        remarks.append(f"{', '.join(names)}: counted over the whole case, its start included.")
        if counted_from_start(names, LAST) != names and not plan.get("duration"):
            remarks.append(
                "At the start the journals fall onto their bearings, which may be the hardest knock;"
                f" {COUNTS_KEY} in the study file counts the last turns only."
            )
    if later := [name for name in study.measures if name.endswith(COUNTED) and name not in names]:
        part = part_words(study).removeprefix("the ").replace(" (means)", "")
        start = ", which is also the first" if plan["last"] == plan["turns"] == 1 else ""
        remarks.append(f"{', '.join(later)}: counted over the {part} of each case{start}.")
    forces = [
        name
        for name in study.measures
        if name.endswith(FORCE_ENDINGS) or (is_reduction(name) and name.endswith(("force)", "torque)")))
    ]
    if forces and (plan.get("duration") or plan["last"] == plan["turns"]):
        with standing_in(study.request["own_laws"]):
            mechanism = loads(study.request["text"])
        if remark := fall_remark(mechanism, not plan.get("duration")):
            remarks.append(f"{', '.join(forces)}: values of each case include its start. {remark}")
    return remarks


def case_table(
    study: Study, status: str, limit: int | None = None, last: Callable[[int], Any] | None = None
) -> Table:
    """Return a table of the first ``most`` cases with their measures, their status under a heading, and a
    ``last`` cell by number.
    """
    names = [*(parameter.name for parameter in study.parameters), *study.measures]
    rows, digits = [], {name: digits_of(study, name) for name in study.measures}
    for row in study.rows()[:limit]:
        cells = [last(int(row["case"]))] if last is not None else []
        values = [value_words(parameter, row[parameter.name]) for parameter in study.parameters]
        values += [
            measure_words(name, row[name], unit, digits[name]) for name, unit in study.measures.items()
        ]
        rows.append((row["case"], *values, row["status"], *cells))
    return Table(("case", *names, status, *[""] * (last is not None)), rows, numbers=range(len(names) + 1))


def _data(study: Study) -> dict[str, Any]:
    return {
        "study": study.name,
        "file": None if study.path is None else str(study.path),
        "model": study.model,
        "status": study.status,
        "planned": len(study.cases),
        "counts": study.counts,
        "wanted": study.request["wanted"],
        "parameters": [
            {
                "name": parameter.name,
                "paths": list(parameter.paths),
                "unit": parameter.unit,
                "kind": parameter.kind,
            }
            for parameter in study.parameters
        ],
        "measures": extremes(study),
        **turn_data(study),
        "errors": errors_data(study),
        "sensitive": sensitivity_data(study),
        "examined": len(examined_cases(study)),
        "cautions": cases_with_cautions(study),
        "failed": [
            {"case": case.number, "at": dict(case.numbers), "reason": reason} for case, reason in study.failed
        ],
    }


# ---------------------------------------------------------------------------------------- samples and indices


def tolerances(study: Study, file: str, confidence: float, spreads: Sequence[Spread]) -> Document:
    """Return a document of quantiles of measures and shares of failing machines, with limits of
    ``confidence`` (1).
    """
    machines, rows = spreads[0].machines, list[tuple[str, ...]]()
    for spread in spreads:
        shown = spread_digits(spread)

        def add(
            words: str, *values: float, measure: str = "", unit: str = spread.unit, digits: Digits = shown
        ) -> None:
            texts = (
                limit_quantity(value, unit, digits, way) if math.isfinite(value) else "-"
                for value, way in zip(values, (NEAREST, DOWN, UP), strict=True)
            )
            rows.append((measure, words, *texts))

        add("mean", spread.mean, spread.average.low, spread.average.high, measure=spread.measure)
        rows.append(
            ("", "standard deviation", quantity(spread.deviation, spread.unit), NOT_ESTIMATED, NOT_ESTIMATED)
        )
        for share, at in spread.quantiles.items():
            add(f"{100.0 * share:g} % are below", at.value, at.low, at.high)
        if spread.bound is not None and spread.failing is not None:
            failing = (
                f"{significant(100.0 * value, 3, way)} %"
                for value, way in (
                    (spread.failing.value, NEAREST),
                    (spread.failing.low, DOWN),
                    (spread.failing.high, UP),
                )
            )
            rows.append(("", f"do not keep the limit, {spread.bound.words(spread.unit)}", *failing))
    text = (
        f"{counted(machines, 'machine')}; the limits of each value hold with {100.0 * confidence:g} %"
        " confidence, a dash means that more machines are needed for it"
    )
    parts: list[Part] = [
        Paragraph(f"{study.model}: {text}"),
        Table.numeric(("measure", "of all machines", "value", "lower limit", "upper limit"), rows, texts=2),
        *(
            Paragraph(f"{spread.measure}: {error_words(spread.numerical, spread.unit)}", lines="whole")
            for spread in spreads
        ),
        *(Paragraph(sentence, lines="whole") for sentence in remarks_on_start(study)),
        Paragraph(
            "Limits cover sampling and the numerical error of a case, the largest of those estimated: means"
            " over turns (last = N) narrow them where turns do not repeat."
            if study.errors
            else "Limits cover sampling alone."
        ),
    ]
    parts += study_cautions(study)
    if (unused := len(study.done) - machines) > 0:
        left_out = (
            f"{counted(unused, 'case')} of the file left out: points, cases of a search, or samples of"
            " former tolerances."
        )
        parts.append(Caution(left_out, "note", aside=True))
    return Document(
        parts,
        data={
            "study": study.name,
            "file": file,
            "confidence": confidence,
            "machines": machines,
            "measures": {spread.measure: _spread(spread) for spread in spreads},
            "sensitive": sensitivity_data(study),
            "remarks": remarks_on_start(study),
        },
    )


def spread_digits(spread: Spread) -> Digits:
    """Return the digits of the numbers of all machines: those by which they differ from a limit."""
    values = [spread.mean, *(at.value for at in spread.quantiles.values())]
    ends = [] if spread.bound is None else [spread.bound.low, spread.bound.high]
    limits = [end for end in ends if math.isfinite(end)]
    return min((limit_digits(limit, values) for limit in limits), default=limit_digits(None, values))


def _spread(spread: Spread) -> dict[str, Any]:
    """Return the spread of a measure as data."""
    bound = spread.bound
    return {
        "unit": spread.unit,
        "count": spread.count,
        "mean": spread.mean,
        "average": vars(spread.average),
        "numerical": None if spread.numerical is None else dataclasses.asdict(spread.numerical),
        "deviation": spread.deviation,
        "quantiles": {f"{share:g}": vars(at) for share, at in spread.quantiles.items()},
        "limit": (
            None
            if bound is None
            else {name: value for name in ("low", "high") if math.isfinite(value := getattr(bound, name))}
        ),
        "failing": None if spread.failing is None else vars(spread.failing),
    }


def indices(study: Study, file: str, results: Sequence[Any]) -> Document:
    """Return a document of Sobol' indices or Morris effects of all parameters, the largest first, for each
    measure.
    """
    parts: list[Part] = []
    for result in results:
        parts += [_index_table(result), Paragraph(error_share(study, result), lines="whole")]
        if result.left_out:
            parts.append(
                Paragraph(
                    f"{result.left_out:,} groups of the design were omitted: one of their cases has no value"
                )
            )
    parts += [Paragraph(sentence, lines="whole") for sentence in remarks_on_start(study)]
    parts += study_cautions(study)
    raw = study.request["raw"]
    if raw.get("method") == "saltelli" and raw.get("count", LEAST_GROUPS) < LEAST_GROUPS:
        caution = f"{raw['count']} groups are few for Sobol' indices, and their margins are uncertain"
        parts.append(Caution(f"{caution}; take count = {LEAST_GROUPS} or more.", "note", aside=True))
    measures = {result.measure: [dataclasses.asdict(row) for row in result.rows] for result in results}
    return Document(
        parts,
        data={
            "study": study.name,
            "file": file,
            "measures": measures,
            "errors": errors_data(study),
            "sensitive": sensitivity_data(study),
            "remarks": remarks_on_start(study),
        },
    )


def _index_table(result: Any) -> Table:
    if hasattr(result.rows[0], "first"):
        indices = sorted(result.rows, key=lambda row: -row.total)
        rows = [
            (row.parameter, *(f"{x:.3f}" for x in (row.first, row.first_margin, row.total, row.total_margin)))
            for row in indices
        ]
        return Table.numeric((result.measure, "alone", "±", "with others", "±"), rows)
    effects = sorted(result.rows, key=lambda row: -row.size)
    rows = [
        (
            row.parameter,
            *(quantity(x, result.unit) for x in (row.size, row.size_margin, row.mean, row.deviation)),
        )
        for row in effects
    ]
    return Table.numeric((result.measure, "size of the effect", "±", "mean", "deviation"), rows)
