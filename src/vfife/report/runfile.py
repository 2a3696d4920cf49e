"""What a run file holds, and the impacts of its run."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from ..job.amounts import amount_of_bytes, span
from .document import Document, Facts, Paragraph, Table

if TYPE_CHECKING:
    from ..measures.contacts import Impact, Impacts


def info(found: Mapping[str, Any]) -> Document:
    """The contents of a run file."""
    return Document([Facts(list(_facts(found)))], data=found)


def _facts(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    yield "Run file", f"{found['file']}, {amount_of_bytes(found['bytes'])}"
    yield "Model", f"{found['model']}" + (f", from {found['source']}" if found["source"] else "")
    ending = (
        f", finished {found['finished']}"
        if found["finished"]
        else ": killed; what it wrote is whole, and vfife resume goes on with it"
    )
    if found["written_by"]:
        ending = f"; {found['written_by']} is at work on it"
    yield "Status", f"{found['status']}; begun {found['created']}{ending}"
    if found["step"] and found["static"]:
        yield "Load factors", f"{found['steps']:,} of {found['steps_planned']:,}"
    elif found["step"]:
        time = found["steps"] * found["step"]
        turns = f" = {time / found['turn']:.4g} turns" if found["turn"] else ""
        yield (
            "Steps",
            (
                f"{found['steps']:,} of {found['steps_planned']:,}, of {found['step']:.6g} s: {time:.6g}"
                f" s{turns}"
            ),
        )
    yield "Outputs", f"{found['outputs']:,}, of {len(found['channels'])} kinds of numbers each"
    yield "Checkpoint", "none" if found["checkpoint"] is None else f"step {found['checkpoint']:,}"
    yield "Reference", "the ideal mechanism is kept beside it" if found["reference"] else "none"
    wall = f", {span(found['wall_s'])}" if found["wall_s"] else ""
    versions = ", ".join(f"{name} {version}" for name, version in found["versions"].items())
    yield "Computed by", f"{found['loop']} loop{wall}; {versions}"
    for name, source in found["laws"].items():
        yield "Law", f"{name}: {source}"
    for law in found["own_laws"]:
        text = "its text is kept here (--json prints it)" if law["text"] else "its text could not be kept"
        yield (
            "Own law",
            f"{law['name']} ({law['kind']}), from {law['file']}: {text}; reading this run does not run it",
        )
    if found["damage"]:
        yield "Damage", f"{', '.join(found['damage'])} cannot be read"
    if not found["checked"]:
        yield (
            "Outputs",
            "are not looked at for damage in so large a file; --check does, and so does whatever reads them",
        )
    for event in found["events"]:
        yield "Event", f"step {event['step']:,}: {event['text']} ({event['time']})"
    summary = found["summary"] or {}
    if part := summary.get("part"):
        yield (
            "Measures",
            f"{part}; counts, shares and energies are those of the whole run; in SI units, lip in %",
        )
    if measures := summary.get("measures"):
        from .digits import bounds, plain

        yield from (
            ("Measure", f"{name} = {plain(summary, name)} ({bounds(summary, name)})") for name in measures
        )


def impacts(found: Impacts, count: int) -> Document:
    """The ``count`` hardest impacts of a run."""
    data = {
        "count": found.count,
        "alone": found.alone,
        "before": found.before,
        "impacts": [dataclasses.asdict(one) for one in found.entries],
    }
    if not found.entries:
        return Document([Paragraph("No contact began in this run.")], data=data)
    shared, hardest = found.count - found.alone, found.hardest(count)
    merged = f", {shared} of them between the same two outputs as others" if shared else ""
    shown = f" The hardest {len(hardest)} (--count for more):" if len(hardest) < len(found.entries) else ""
    lost = sum(one.energy for one in found.entries)
    text = (
        f"{found.count} contact{'s' * (found.count != 1)} began{merged}. They lost {lost:.4g} J in"
        f" all.{shown}"
    )
    crank = any(one.crank is not None for one in found.entries)
    heads = (
        "joint",
        "time, ms",
        *(("crank, deg",) if crank else ()),
        "began",
        "speed, m/s",
        "lost, J",
        "depth, µm",
    )
    return Document([Paragraph(text), Table.of(heads, [_impact(one) for one in hardest])], data=data)


def _impact(one: Impact) -> tuple[str, ...]:
    """Cells of an entry; the time is that of the output that shows it."""
    crank = () if one.crank is None else (f"{one.crank:.1f}",)
    speed = "" if one.speed is None else f"{one.speed:.4g}"
    return (
        one.joint,
        f"{1e3 * one.time:.4f}",
        *crank,
        str(one.count),
        speed,
        f"{one.energy:.4g}",
        f"{1e6 * one.depth:.4g}",
    )
