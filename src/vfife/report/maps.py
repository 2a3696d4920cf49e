"""Answers of maps: bifurcation diagrams, basins of attraction, Poincaré sections and waterfalls."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ..job.amounts import counted
from ..measures.chaos import CHAOTIC
from .document import Document, Paragraph, Table, sentences
from .study import quantity

if TYPE_CHECKING:
    from ..dynamics.basins import Basins
    from ..dynamics.bifurcation import Bifurcation, Spell
    from ..dynamics.sections import PoincareSection
    from ..dynamics.waterfall import Waterfall

WAYS = {"up": "On the way up", "down": "On the way down"}
MOST_ATTRACTORS = 12
MOST_SPELLS = 8  # ranges of values of one way that are listed


def document(found: Any) -> Document:
    """The answer of any kind of map."""
    documents: dict[str, Callable[[Any], Document]] = {
        "Bifurcation": diagram, "Basins": basins, "PoincareSection": section, "Waterfall": waterfall,
    }  # fmt: skip
    return documents[type(found).__name__](found)


def diagram(found: Bifurcation) -> Document:
    """How many values have which motion, and which ranges of values."""
    asked = found.asked
    heads = asked.ways if asked.starts else ("values on the way up", "on the way down")
    counts = [Counter(kind for kind in kinds if kind) for kinds in found.kinds]
    rows = [
        (kind, *(one[kind] for one in counts))
        for kind in sorted({kind for one in counts for kind in one}, key=_order)
    ]
    said = [
        _chaos(found),
        *(
            f"{WAYS.get(way, way)}: {spells_words(found.spells(k), asked.unit)}."
            for k, way in enumerate(asked.ways)
        ),
        (
            f"{asked.turns} turns at each value, {asked.dropped} of them dropped, {asked.steps:,} steps a"
            f" turn; {found.laws}."
        ),
        (
            "A period is told within 0.1 % of the range, chaos where a small difference grows more than"
            " e-fold in each half of the turns."
        ),
        f"Companions: {found.step_report or 'none.'}",
    ]
    return Document([Table.of(("motion", *heads), rows), *sentences(said)], f"{found.name}: {asked.path}")


def _order(kind: str) -> tuple[float, str]:
    """Periodic motions come first, the shortest before longer ones."""
    return (int(kind.removeprefix("period ")), "") if kind.startswith("period ") else (math.inf, kind)


def _chaos(found: Bifurcation) -> str:
    """Between which values chaos was found, each way; other motions may lie between them."""
    said, unit = [], found.asked.unit
    for way, kinds in zip(found.asked.ways, found.kinds, strict=True):
        values = [value for value, kind in zip(found.asked.values, kinds, strict=True) if kind == CHAOTIC]
        if values:
            ends = f"{quantity(min(values), unit)} and {quantity(max(values), unit)}"
            how = WAYS[way].lower() if way in WAYS else f"from {way}"
            said.append(f"{how} between {ends} ({len(values)} of {sum(map(bool, kinds))} values)")
    return f"Chaos was found {', '.join(said)}." if said else "Chaos was found nowhere."


def spells_words(spells: Sequence[Spell], unit: str) -> str:
    """Ranges of values with one motion; the longest of many."""
    places = sorted(range(len(spells)), key=lambda k: -spells[k].count)[:MOST_SPELLS]
    longest = [spells[k] for k in sorted(places)]
    said = [
        f"{one.kind} {f'from {quantity(one.first, unit)} to' if one.count > 1 else 'at'}"
        f" {quantity(one.last, unit)}"
        for one in longest
    ]
    rest = len(spells) - len(longest)
    return ", ".join(said) + (f", and {rest} others between them" if rest else "")


def basins(found: Basins) -> Document:
    """How many starts lead to which motion."""
    asked, every = found.asked, max(len(found.verdicts), 1)
    sizes = [(one.kind, len(one.members)) for one in found.attractors]
    if len(sizes) > MOST_ATTRACTORS:
        rest = sizes[MOST_ATTRACTORS:]
        sizes[MOST_ATTRACTORS:] = [(f"{len(rest)} others", sum(count for _, count in rest))]
    rows = [(kind, f"{count:,}", f"{100.0 * count / every:.3g} %") for kind, count in sizes]
    none = found.done - len(found.verdicts)
    lost = f" {none:,} of the grid are no start, a journal being outside its bearing." if none else ""
    same = "whose points are within 1 % of that of all"
    if asked.varied:
        same = f"of one period, for their points move with {' and '.join(asked.varied)}"
    said = [
        (
            f"{asked.turns} turns of each start, {asked.dropped} of them dropped, {asked.steps:,} steps a"
            f" turn; {found.laws}.{lost}"
        ),
        f"A period is told within 0.1 % of the range; periodic motions are one {same}.",
        f"Companions: {found.step_report or 'none.'}",
    ]
    return Document(
        [Table.of(("motion", "starts", "share"), rows), *sentences(said)],
        f"{found.name}: {asked.paths[0]}, {asked.paths[1]}",
    )


def section(found: PoincareSection) -> Document:
    """The kind of a motion, and the evidence for it."""
    return Document([Paragraph(text) for text in _section(found)])


def _section(found: PoincareSection) -> Iterator[str]:
    asked, verdict = found.asked, found.verdict
    yield f"{found.name}: {verdict.kind}"
    yield f"{verdict.evidence[:1].upper()}{verdict.evidence[1:]}."
    for name, one in found.struck.items():
        count = len(one["speed"])
        fastest = f", the fastest at {one['speed'].max():.4g} m/s" if count else ""
        held = (
            ""
            if count
            else (
                "; if it is closed all the time, a law that has the speed of its onset in it remembers that"
                " of long ago"
            )
        )
        yield f"{name}: {counted(count, 'contact')} began{fastest}{held}."
    yield (
        f"{found.done:,} turns after {asked.dropped:,} that were dropped, {asked.steps:,} steps a turn;"
        f" {found.laws}. Without companions."
    )


def waterfall(found: Waterfall) -> Document:
    """The range that was swept, and how the series were transformed."""
    asked = found.asked
    low, high = asked.values[0], asked.values[-1]
    speeds = (
        f" ({30.0 / math.pi * low:.4g} to {30.0 / math.pi * high:.4g} rpm)" if asked.unit == "rad/s" else ""
    )
    said = [
        (
            f"{found.name}: {', '.join(asked.series)} over {asked.path} from {low:.6g} to {high:.6g}"
            f" {asked.unit}{speeds}"
        ),
        f"{found.done:,} runs. {found.words}.",
        (
            f"{found.limits[:1].upper()}{found.limits[1:]}; without companions; each run begins at the"
            " model's own start."
        ),
    ]
    if found.diverged:
        said.append(
            f"At {', '.join(f'{value:g}' for value in found.diverged)} {asked.unit} the motion diverged."
        )
    return Document(sentences(said))
