"""Documents of a run file: its contents, and the hardest impacts of its run."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..job.progress import amount_of_bytes, span
from .digits import Json, plain_number, range_text
from .document import Document, Facts, Paragraph, Table

if TYPE_CHECKING:
    from ..measures.contacts import Impact, Impacts


def info(contents: Json) -> Document:
    """Return the document of the contents of a run file."""
    return Document([Facts(list(_file_facts(contents)))], data=contents)


def _file_facts(file: Json) -> Iterator[tuple[str, str]]:
    yield "Run file", f"{file['file']}, {amount_of_bytes(file['bytes'])}"
    yield "Model", f"{file['model']}" + (f", from {file['source']}" if file["source"] else "")
    ending = (
        f", finished {file['finished']}"
        if file["finished"]
        else ": its process was killed or could not write (a full disk?); what it wrote is whole, and vfife"
        " resume goes on with it"
    )
    if file["written_by"]:
        ending = f"; {file['written_by']} is at work on it"
    yield "Status", f"{file['status']}; begun {file['created']}{ending}"
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
    yield "Reference", "the ideal mechanism is kept beside it" if file["reference"] else "none"
    wall = f", {span(file['wall_s'])}" if file["wall_s"] else ""
    versions = ", ".join(f"{name} {version}" for name, version in file["versions"].items())
    yield "Computed by", f"{file['loop']} loop{wall}; {versions}"
    yield from (("Law", f"{name}: {source}") for name, source in file["laws"].items())
    for law in file["own_laws"]:
        text = "its text is kept here (--json prints it)" if law["text"] else "its text could not be kept"
        yield (
            "Own law",
            f"{law['name']} ({law['kind']}), from {law['file']}: {text}; reading this run does not run it",
        )
    if file["damage"]:
        yield "Damage", f"{', '.join(file['damage'])} cannot be read"
    if not file["checked"]:
        yield (
            "Outputs",
            "are not looked at for damage in so large a file; --check does, and so does whatever reads them",
        )
    for event in file["events"]:
        yield "Event", f"step {event['step']:,}: {event['text']} ({event['time']})"
    summary = file["summary"] or {}
    if part := summary.get("part"):
        yield (
            "Measures",
            f"{part}; counts, shares and energies are those of the whole run; in SI units, lip in %",
        )
    for name in summary.get("measures") or ():
        yield "Measure", f"{name} = {plain_number(summary, name)} ({range_text(summary, name)})"


BETWEEN = "A contact began between the two outputs whose times are shown; more outputs narrow the interval."


def impacts(impacts: Impacts, count: int) -> Document:
    """Return a document of the ``count`` hardest impacts of a run."""
    data = {
        "count": impacts.count,
        "alone": impacts.alone,
        "before": impacts.before,
        "impacts": [dataclasses.asdict(impact) for impact in impacts.entries],
    }
    if not impacts.entries:
        return Document([Paragraph("No contact began in this run.")], data=data)
    shared, hardest = impacts.count - impacts.alone, impacts.hardest(count)
    merged = f", {shared} of them between the same two outputs as others" if shared else ""
    shown = f" The hardest {len(hardest)} (--count for more):" if len(hardest) < len(impacts.entries) else ""
    energy = sum(impact.energy for impact in impacts.entries)
    text = (
        f"{impacts.count} contact{'s' * (impacts.count != 1)} began{merged}. They lost {energy:.4g} J in"
        f" all.{shown}"
    )
    crank = any(impact.crank is not None for impact in impacts.entries)
    heads = (
        "joint",
        "time, ms",
        *(("crank, deg",) if crank else ()),
        "began",
        "speed, m/s",
        "lost, J",
        "depth, µm",
    )
    return Document(
        [Paragraph(text), Table.numeric(heads, [_impact(impact) for impact in hardest]), Paragraph(BETWEEN)],
        data=data,
    )


def _impact(impact: Impact) -> tuple[str, ...]:
    """Return the cells of an impact; time and angle are those of the outputs before and after its onset."""
    crank: tuple[str, ...] = ()
    if impact.crank is not None and impact.crank_since is not None:
        crank = (_span(impact.crank_since, impact.crank, 1),)
    speed = "" if impact.speed is None else f"{impact.speed:.4g}"
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
