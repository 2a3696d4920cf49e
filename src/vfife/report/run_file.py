"""Documents of a run file: its contents, the hardest impacts of its run, and the forces of several runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from ..errors import VfifeError
from ..job.progress import amount_of_bytes, span
from ..measures.error_ranges import LEAST_CHANGE
from ..measures.stops import stop_sentence
from ..measures.values import NOT_ESTIMATED
from ..numerics.outward import significant_range
from ..solvers.status import Status
from . import amounts, dead_centres, digits
from .amounts import interval, percent
from .digits import Json, is_about_zero, is_estimated, is_undetermined, plain_number, range_text, turns_text
from .document import Caution, Document, Facts, Paragraph, Part, Table, grouped
from .noise import knock_speed
from .overview import NOT_COMPUTED, cautions, certainty, has_fall, heading_sentence, moment_texts, overview
from .run import effort_texts
from .run_tables import force_text, knock_texts, lacks_friction, mean_text, of_contacts
from .run_up import run_up_note

if TYPE_CHECKING:
    from ..measures.contacts import Impact, Impacts

WIDE = 2.0  # per cent: a change that is known less well is shown as a range
MOST_INPUTS = 20  # of models that differ, in a table
ALIKE = "The models of these runs have the same inputs."
OVERLAP = "ranges overlap"  # instead of a change that may be an error of the steps


def info(contents: Json, measures: bool = False) -> Document:
    """Return the document of a run file: the answer of the run, as the run printed it, and the file's
    contents; with ``measures`` its laws and every measure instead of the answer.
    """
    answer = [] if measures else _answer(contents["summary"] or {})
    facts = [*_file_facts(contents), *(_law_facts(contents) if measures or not answer else ())]
    return Document([*answer, Facts(facts)], data=contents)


def _answer(summary: Json) -> list[Part]:
    """Return the answer that the run printed; none for a run that did not end, or whose summary needs another
    version or a law that is not loaded.
    """
    if not summary.get("measures"):
        return []
    try:
        return list(overview(summary).parts)
    except (VfifeError, KeyError):
        return []


def _law_facts(file: Json) -> Iterator[tuple[str, str]]:
    """Yield the sources of laws and every measure."""
    keys = {name: name.rpartition(".") for name in file["laws"]}
    joints = grouped((f"{keys[name][2]}: {source}", keys[name][0]) for name, source in file["laws"].items())
    yield from (("Law", f"{', '.join(names)}.{text}") for text, names in joints.items())
    summary = file["summary"] or {}
    if part := summary.get("part"):
        yield (
            "Measures",
            f"{part}; counts, shares of time, landings and speeds of knocks are those of the whole run; in SI"
            " units, lip in %",
        )
    for name in summary.get("measures") or ():
        text = f"{name} = {plain_number(summary, name)} ({range_text(summary, name)})"
        yield "Measure", text + _turns(summary, name)
    yield from dead_centres.lines(summary)


def _turns(summary: Json, name: str) -> str:
    """Return the lowest and highest turn of a measure whose turns differ, "" for any other."""
    if not turns_text(summary, name, ""):
        return ""
    bounds = summary["ranges"][name]
    return f", single turns {significant_range(bounds['lowest'], bounds['highest'], 6)}"


def _file_facts(file: Json) -> Iterator[tuple[str, str]]:
    yield "Run file", f"{file['file']}, {amount_of_bytes(file['bytes'])}"
    yield "Model", f"{file['model']}" + (f", from {file['source']}" if file["source"] else "")
    continued = "the file is complete up to its end, and vfife resume continues the run"
    ending = f", finished {file['finished']}" if file["finished"] else f"; {continued}"
    if file["status"] == Status.UNFINISHED:
        ending = f"; its process was killed or could not write (a full disk?); {continued}"
    if file["written_by"]:
        ending = f"; {file['written_by']} is writing it"
    damaged = ", but the file is damaged" if file["damage"] else ""
    yield "Status", f"{file['status']}{damaged}; begun {file['created']}{ending}"
    if file["step"] and file["static"]:
        yield "Load factors", f"{file['steps']:,} of {file['steps_planned']:,}"
    elif file["step"]:
        time = file["steps"] * file["step"]
        turns = f" = {time / file['turn']:.4g} turns" if file["turn"] else ""
        yield (
            "Steps",
            f"{file['steps']:,} of {file['steps_planned']:,}, of {file['step']:.6g} s: {time:.6g} s{turns}",
        )
    yield "Outputs", f"{file['outputs']:,}, of {len(file['channels'])} kinds of numbers each"
    yield "Checkpoint", "none" if file["checkpoint"] is None else f"step {file['checkpoint']:,}"
    yield "Reference", "the ideal mechanism, in the same file" if file["reference"] else "none"
    wall = f", {span(file['wall_s'])}" if file["wall_s"] else ""
    versions = ", ".join(f"{name} {version}" for name, version in file["versions"].items())
    yield "Computed by", f"{file['loop']} loop{wall}; {versions}"
    for law in file["own_laws"]:
        text = "its text is kept here (--json prints it)" if law["text"] else "its text could not be kept"
        yield (
            "Own law",
            f"{law['name']} ({law['kind']}), from {law['file']}: {text}; reading this run does not run it",
        )
    if file["damage"]:
        yield "Damage", f"{', '.join(file['damage'])} cannot be read"
    if file.get("other_model"):
        yield (
            "Model file",
            "model.toml in this folder is not the model of this run: it was changed or is damaged; the run"
            " file contains the correct one",
        )
    if not file["checked"]:
        yield (
            "Outputs",
            "are not checked for damage in so large a file; --check and every command that reads them do so",
        )
    for event in file["events"]:
        yield "Event", f"step {event['step']:,}: {event['text']} ({event['time']})"


ERROR_NOTE = (
    "Numbers are those of this run; their errors are not estimated. Ranges of the number of impacts and of"
    " the hardest in each joint: vfife info RUN --measures."
)
INTERVAL_NOTE = (
    "A contact began between the two outputs whose times are shown; more outputs narrow the interval."
)


def impacts(impacts: Impacts, count: int, facts: Sequence[str] = ()) -> Document:
    """Return a document of the ``count`` hardest impacts of a run; ``facts`` about laws qualify its
    energies.
    """
    notes = [*facts, *filter(None, [stop_sentence(impacts.stops, impacts.interval)])]
    data = {
        "count": impacts.count,
        "alone": impacts.alone,
        "before": impacts.before,
        "notes": notes,
        "impacts": [dataclasses.asdict(impact) for impact in impacts.entries],
    }
    if not impacts.entries:
        place = "in a joint of" if impacts.stops else "in"
        stops = [Caution(fact, "note") for fact in notes[len(facts) :]]
        return Document([Paragraph(f"No contact began {place} this run."), *stops], data=data)
    shared, hardest = impacts.count - impacts.alone, impacts.fastest(count)
    merged = f", {shared} of them between the same two outputs as others" if shared else ""
    shown = (
        f" The hardest {len(hardest)}, by speed (--count for more):"
        if len(hardest) < len(impacts.entries)
        else ""
    )
    energy = sum(impact.energy for impact in impacts.entries)
    start = f", contacts of the start {impacts.before:.4g} J more" if impacts.before > 0.0 else ""
    text = (
        f"{impacts.count} contact{'s' * (impacts.count != 1)} began{merged}. They lost {energy:.4g} J in"
        f" all{start}.{shown}"
    )
    crank = any(impact.crank is not None for impact in impacts.entries)
    heads = (
        "joint",
        "time, ms",
        *(("crank, deg",) if crank else ()),
        "began",
        "speed, mm/s",
        "lost, J",
        "depth, µm",
    )
    return Document(
        [
            Paragraph(text),
            Table.numeric(heads, [_impact(impact) for impact in hardest]),
            Paragraph(f"{INTERVAL_NOTE} {ERROR_NOTE}"),
            *(Caution(fact, "note") for fact in notes),
        ],
        data=data,
    )


def _impact(impact: Impact) -> tuple[str, ...]:
    """Return the cells of an impact; time and angle are those of the outputs before and after its onset."""
    crank: tuple[str, ...] = ()
    if impact.crank is not None and impact.crank_since is not None:
        crank = (_span(impact.crank_since, impact.crank, 1),)
    speed = "" if impact.speed is None else f"{1e3 * impact.speed:.4g}"
    return (
        impact.joint,
        _span(1e3 * impact.since, 1e3 * impact.time, 4),
        *crank,
        str(impact.count),
        speed,
        f"{impact.energy:.4g}",
        f"{1e6 * impact.depth:.4g}",
    )


def _span(since: float, until: float, places: int) -> str:
    """Return the interval of an onset; the one number of a contact that is closed at the start."""
    first, last = f"{since:.{places}f}", f"{until:.{places}f}"
    return last if since == until else f"{first} to {last}"


CHANGE_RANGE = (
    "The ends of a change are the least and the largest difference of both ranges, in per cent of the value"
    " of the first run."
)


def side_by_side(summaries: Mapping[str, Json], inputs: Sequence[tuple[str, list[str]]] = ()) -> Document:
    """Return a table of the largest force of each joint in several runs, and of moments that are not
    negligible, one of knocks, friction and drives, and one of the ``inputs`` that differ, each with a value
    for every run.

    ``summaries`` are those of :func:`vfife.report.summary.run_summary` by the name of the run. A column
    beside each run after the first is the change from the first, unless the ranges of both overlap. Raises
    VfifeError for a static analysis.
    """
    if static := [name for name, summary in summaries.items() if summary["run"].get("analysis") == "static"]:
        raise VfifeError(f"{static[0]} is a static analysis, which has no largest forces; name it by itself")
    names = list(summaries)
    changes = (head for name in names[1:] for head in (name, "change"))
    heads, forces, drives = (*names[:1], *changes), _force_rows(summaries), _other_rows(summaries)
    facts = [
        (label if k == 0 else "", text)
        for label, summary in summaries.items()
        for k, text in enumerate((heading_sentence(summary), certainty(summary)))
    ]
    numbers, note = range(1, len(heads) + 1), run_up_note(summaries)
    parts: list[Part] = [
        Facts(facts),
        Table(("joint", *heads), forces, "Largest forces", numbers=numbers, names=(0,), note=note),
    ]
    if drives:
        title = "Knocks, friction and drives"
        parts.append(Table(("of", *heads), drives, title, numbers=numbers, names=(0,), note=note))
    rows = [(name, *values) for name, values in inputs]
    if (left := len(rows) - MOST_INPUTS) > 0:
        rows[MOST_INPUTS:] = [(f"{left} more", *[""] * len(names))]
    parts.append(
        Table(("input", *names), rows, "Inputs that differ", names=(0,)) if rows else Paragraph(ALIKE)
    )
    commands = [f"vfife info {name}" for name, summary in summaries.items() if any(cautions(summary))]
    shown_by = f"Cautions: {', '.join(commands)}. " if commands else ""
    parts.append(
        Paragraph(
            f"{CHANGE_RANGE} {shown_by}Figures of these runs in one: vfife plot {' '.join(names)}"
            if any(" to " in cell for row in (*forces, *drives) for cell in row[3::2])
            else f"{shown_by}Figures of these runs in one: vfife plot {' '.join(names)}"
        )
    )
    runs = {name: _data(summary) for name, summary in summaries.items()}
    entries = [{"input": name, "values": row} for name, row in inputs]
    return Document(parts, data={"runs": runs, "inputs": entries})


Text = Callable[[Json, str], str]  # of a measure of a run, by its name


def _force_rows(summaries: Mapping[str, Json]) -> list[tuple[str, ...]]:
    """Return the rows of largest forces, then those of moments that are not negligible in any run."""
    joints = list(dict.fromkeys(joint for summary in summaries.values() for joint in summary["joints"]))
    moments = {joint for summary in summaries.values() for joint in moment_texts(summary)}
    rows = [_row(summaries, joint, f"{joint}.force.max", force_text) for joint in joints]
    torque = partial(force_text, unit="N m")
    return rows + [
        _row(summaries, f"{joint}, moment", f"{joint}.moment.max", torque)
        for joint in joints
        if joint in moments
    ]


def _other_rows(summaries: Mapping[str, Json]) -> list[tuple[str, ...]]:
    """Return the rows of the hardest knock and the friction power of each joint, and of each driver and
    actuator, with the texts of the answers of single runs.
    """
    runs = list(summaries.values())
    joints = list(dict.fromkeys(joint for summary in runs for joint in summary["joints"]))
    rows = [
        _row(summaries, f"{joint}, hardest knock", joint, _knock_text, _knock_change)
        for joint in joints
        if any(knock_texts(summary, joint)[0] for summary in runs)
    ]
    if any(knock_texts(summary, joint)[1] for summary in runs for joint in joints):
        label = "hardest knock, whole run"
        rows.append(_row(summaries, label, "", _fastest_text, _fastest_change))
    for joint in joints:
        measure = f"{joint}.friction_power.mean"
        if any(summary["measures"].get(measure) for summary in runs):
            rows.append(_row(summaries, f"{joint}, friction power", measure, _friction_text, _measure_change))
    rows += [
        _row(summaries, label, measure, text)
        for label, measure, text in _drives(runs)
        if any(measure in summary["measures"] for summary in runs)
    ]
    return rows + list(_effort_rows(runs))


def _effort_rows(runs: Sequence[Json]) -> Iterator[tuple[str, ...]]:
    """Yield the rows of drivers that apply a torque or force: the part of each run, and the figures in it."""
    for name in dict.fromkeys(name for summary in runs for name in summary.get("efforts", {})):
        efforts = [summary.get("efforts", {}).get(name) for summary in runs]
        texts = [effort_texts(effort) if effort else {} for effort in efforts]
        for word in dict.fromkeys(word for figures in texts for word in figures):
            cells = [f"{name}, {word}"]
            for figures in texts:
                (value, text), (first, _) = (part.get(word, (0.0, "-")) for part in (figures, texts[0]))
                change = percent(100.0 * (value - first) / abs(first)) if value and first else ""
                cells += [text, change]
            yield (*cells[:2], *cells[3:])


def _drives(runs: Sequence[Json]) -> Iterator[tuple[str, str, Text]]:
    """Yield label, measure and text of the powers, torques and forces of drivers and actuators."""
    power = partial(mean_text, unit="W", certain=digits.SCATTER)
    torque = partial(mean_text, unit="N m", certain=digits.CERTAIN)
    bodies = dict.fromkeys(
        name
        for summary in runs
        for name, body in summary["model"]["bodies"].items()
        if body["torque.max"] is not None
    )
    for name in bodies:
        yield f"{name}, mean power", f"{name}.power.mean", power
        yield f"{name}, mean torque", f"{name}.torque.mean", torque
        yield f"{name}, largest torque", f"{name}.torque.max", partial(force_text, unit="N m")
    actuators = {name: entry for summary in runs for name, entry in summary.get("actuators", {}).items()}
    for name, entry in actuators.items():
        kind = "force" if entry["unit"] == "N" else "torque"
        yield f"{name}, mean power", f"{name}.actuator_power.mean", power
        yield f"{name}, largest {kind}", entry["measure"], partial(force_text, unit=entry["unit"])


def _friction_text(summary: Json, measure: str) -> str:
    if lacks_friction(summary, measure.partition(".")[0]):
        return NOT_COMPUTED
    return mean_text(summary, measure, "W", amounts.WIDE) if summary["measures"].get(measure) else ""


def _knock_text(summary: Json, joint: str) -> str:
    return knock_texts(summary, joint)[0] if joint in summary["joints"] else ""


def _knock_change(summaries: Sequence[Json], joint: str) -> str:
    """Return the change of the hardest knock of a joint in the turns of the measures; "" where one run has
    none, or its error is not estimated.
    """
    texts = [_knock_text(summary, joint) for summary in summaries]
    if any(NOT_ESTIMATED in text for text in texts) or not all(knock_speed(s, joint) for s in summaries):
        return ""
    names = [of_contacts(summary, joint, "approach_speed.max") for summary in summaries]
    return _change_of_largest(summaries, names)


def _speeds(summary: Json) -> list[str]:
    return [name for name in summary["measures"] if name.endswith(".approach_speed.max")]


def _fastest_text(summary: Json, _: str) -> str:
    names = _speeds(summary)
    if not any(summary["measures"][name] for name in names):
        return "none" if names else ""
    return digits.largest_text(summary, names, "m/s", digits.CERTAIN)


def _fastest_change(summaries: Sequence[Json], _: str) -> str:
    return _change_of_largest(summaries, [_speeds(summary) for summary in summaries])


def _change_of_largest(summaries: Sequence[Json], names: Sequence[Sequence[str]]) -> str:
    """Return the change of the largest of some measures, ``names`` by run; "" where one is not known."""
    values, ends = [], []
    for summary, measures in zip(summaries, names, strict=True):
        if not measures or not all(is_estimated(summary, name) for name in measures):
            return ""
        largest = max(measures, key=summary["measures"].__getitem__)
        if is_about_zero(summary, largest) or any(is_undetermined(summary, name) for name in measures):
            return ""
        values.append(float(summary["measures"][largest]))
        pairs = [_ends(summary, name) for name in measures]
        ends.append((max(low for low, _ in pairs), max(high for _, high in pairs)))
    return _change(values, ends, largest=True) if all(values) else ""


def _row(
    summaries: Mapping[str, Json],
    label: str,
    measure: str,
    text: Text,
    change: Callable[[Sequence[Json], str], str] | None = None,
) -> tuple[str, ...]:
    """Return the label of a row, the text of a measure in each run, and beside those after the first its
    change: that of the measure, or ``change`` of both runs.
    """
    first, cells = next(iter(summaries.values())), [label]
    for summary in summaries.values():
        has_text = change is not None or measure in summary["measures"]
        cells.append((text(summary, measure) if has_text else "") or "-")
        if summary is not first:
            cells.append((change or _measure_change)([first, summary], measure))
    return tuple(cells)


def _measure_change(summaries: Sequence[Json], measure: str) -> str:
    if not all(measure in summary["measures"] for summary in summaries):
        return ""
    return change_text(summaries, measure)


def change_text(summaries: Sequence[Json], measure: str) -> str:
    """Return by how much a measure of the second of two runs differs from that of the first, in per cent."""
    old, new = (float(summary["measures"][measure]) for summary in summaries)
    if any(is_about_zero(s, measure) or is_undetermined(s, measure) for s in summaries) or not old:
        return ""
    if not all(is_estimated(summary, measure) for summary in summaries):
        return percent(100.0 * (new - old) / abs(old))
    return _change([old, new], [_ends(summary, measure) for summary in summaries], measure.endswith(".max"))


def _change(values: Sequence[float], ends: Sequence[tuple[float, float]], largest: bool) -> str:
    """Return the change from the first of two ``values`` in per cent, as a range where their ranges
    (``ends``) leave it open; ``largest`` values cannot be negative.
    """
    (old, new), ((low, high), (lowest, highest)) = values, ends
    if old != new and low <= highest and lowest <= high:
        return OVERLAP
    bottom, top = 100.0 * (lowest - high) / abs(old), 100.0 * (highest - low) / abs(old)
    if largest:
        bottom = max(bottom, LEAST_CHANGE)
    if top - bottom > WIDE:
        return interval(bottom, top, "%", top - bottom, prefix=False)
    return percent(100.0 * (new - old) / abs(old), top - bottom)


def _ends(summary: Json, measure: str) -> tuple[float, float]:
    """Return the lowest and highest value of a measure: its range, or its value if it has none."""
    value = summary["measures"][measure]
    bounds = (summary.get("ranges") or {}).get(measure, {})
    return float(bounds.get("low", value)), float(bounds.get("high", value))


def _data(summary: Json) -> Json:
    """Return model, part and the measures of the tables with their ranges, in SI units; the knocks in the
    turns of the measures by contact; the figures of drivers that apply a torque or force; of a run whose
    largest forces are those of the fall at its start also ``start_fall``, see the summary.
    """
    endings = ("force.max", "moment.max", "friction_power.mean")
    names = [f"{joint}.{kind}" for joint in summary["joints"] for kind in endings]
    names += [*_speeds(summary), *(measure for _, measure, _ in _drives([summary]))]
    return {
        "model": summary["model"]["name"],
        "part": summary["part"],
        "measures": {
            name: {"value": summary["measures"][name]}
            | dict(zip(("low", "high"), _ends(summary, name), strict=True))
            | ({} if is_estimated(summary, name) else {"estimated": False})
            for name in names
            if name in summary["measures"]
        },
        "knocks": summary.get("knocks", {}),
        "efforts": summary.get("efforts", {}),
        **({"start_fall": summary["start_fall"]} if has_fall(summary) else {}),
    }
