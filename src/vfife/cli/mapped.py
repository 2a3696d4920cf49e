"""What is told of maps, sections, basins and waterfalls: the picture, the table, and in words what they are and how they were made."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from .signals import NOW
from .terminal import grid, output, row, tell, writing

if TYPE_CHECKING:
    from ..study.maps.basins import Basins
    from ..study.maps.bifurcation import Bifurcation, Spell
    from ..study.maps.sections import PoincareSection
    from ..study.maps.waterfall import Waterfall, WaterfallSpec

WAYS = {"up": "On the way up", "down": "On the way down"}
MOST_ATTRACTORS = 12  # that are told of basins
LAST = 10**9  # after all periods
MOST_SPELLS = 8  # that are told of a way


def drawn_and_told(
    found: Any, place: Path, drawn: Path | None, csv: Path | None, quiet: bool, *, whole: bool = True, plot: Mapping[str, Any] | None = None
) -> None:
    """Draws it, as ``plot`` says, writes its table, and says what it is; where it is not ``whole``, nobody waits for the rest."""
    if drawn is not None:
        with writing(str(drawn)):
            from ..plots.style import saved_in_style

            saved_in_style(lambda: found.plot(**plot or {}), drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    done, of_all, what = counted(found)
    if not quiet:
        teller_of(found)(found)
        print_line(", ".join(str(path) for path in (place, drawn, csv) if path is not None))
    if whole and done < of_all:
        tell("interrupted", f"{NOW.by}: {done:,} of {of_all:,} {what} are complete and kept in {place}; the same command goes on.")
        raise typer.Exit(NOW.code)


def counted(found: Any) -> tuple[int, int, str]:
    """How much of it is done, of how much."""
    from ..study.maps.basins import Basins
    from ..study.maps.sections import PoincareSection

    if isinstance(found, PoincareSection):
        return found.done, found.asked.turns - found.asked.dropped, "turns"
    if isinstance(found, Basins):
        return found.done, found.asked.count, "starts"
    return found.done, len(found.asked.values), "values"


def teller_of(found: Any) -> Callable[[Any], None]:
    """What tells of it."""
    from ..study.maps.basins import Basins
    from ..study.maps.sections import PoincareSection
    from ..study.maps.waterfall import Waterfall

    tellers: dict[type, Callable[[Any], None]] = {PoincareSection: tell_section, Basins: tell_basins, Waterfall: tell_waterfall}
    return next((tell for kind, tell in tellers.items() if isinstance(found, kind)), tell_diagram)


def print_line(text: str) -> None:
    """A line on standard output."""
    from rich.text import Text

    output().print(Text(text))


def tell_diagram(found: Bifurcation) -> None:
    """How many values have which motion."""
    console, asked = output(), found.asked
    heads = ("values on the way up", "on the way down") if not asked.starts else asked.ways
    table = grid("motion", *heads, title=f"{found.name}: {asked.path}", right=tuple(range(1, len(heads) + 1)))
    counts = [Counter(kind for kind in kinds if kind) for kinds in found.kinds]
    for kind in sorted({kind for one in counts for kind in one}, key=rank):
        row(table, kind, *(str(one[kind]) for one in counts))
    console.print(table)
    print_line(said_chaos(found))
    for k, way in enumerate(asked.ways):
        print_line(f"{WAYS.get(way, way)}: {said_spells(found.spells(k), asked.unit)}.")
    print_line(f"{asked.turns} turns at each value, {asked.dropped} of them dropped, {asked.steps:,} steps a turn; {found.laws}.")
    print_line("A period is told within 0.1 % of the range, chaos where a small difference grows more than e-fold in each half of the turns.")
    print_line(f"Companions: {found.told or 'none.'}")


def rank(kind: str) -> tuple[int, str]:
    """Periodic motions come first, the shortest before longer ones."""
    return (int(kind.removeprefix("period ")), "") if kind.startswith("period ") else (LAST, kind)


def said_chaos(found: Bifurcation) -> str:
    """Between which values chaos was found, each way; other motions may lie between them."""
    from ..analysis.chaos import CHAOTIC
    from ..report.study import quantity

    said, unit = [], found.asked.unit
    for way, kinds in zip(found.asked.ways, found.kinds, strict=True):
        values = [value for value, kind in zip(found.asked.values, kinds, strict=True) if kind == CHAOTIC]
        if values:
            ends = f"{quantity(min(values), unit)} and {quantity(max(values), unit)}"
            how = WAYS[way].lower() if way in WAYS else f"from {way}"
            said.append(f"{how} between {ends} ({len(values)} of {sum(map(bool, kinds))} values)")
    return f"Chaos was found {', '.join(said)}." if said else "Chaos was found nowhere."


def said_spells(spells: Sequence[Spell], unit: str) -> str:
    """Where which motion is found; where they are many, the longest of them."""
    from ..report.study import quantity

    places = sorted(range(len(spells)), key=lambda k: -spells[k].count)[:MOST_SPELLS]
    longest = [spells[k] for k in sorted(places)]
    said = [f"{one.kind} {f'from {quantity(one.first, unit)} to' if one.count > 1 else 'at'} {quantity(one.last, unit)}" for one in longest]
    more = len(spells) - len(longest)
    return ", ".join(said) + (f", and {more} others between them" if more else "")


def tell_basins(found: Basins) -> None:
    """How many starts come to which motion."""
    console, asked = output(), found.asked
    table = grid("motion", "starts", "share", title=f"{found.name}: {asked.paths[0]}, {asked.paths[1]}", right=(1, 2))
    of_all, rest = max(len(found.verdicts), 1), found.attractors[MOST_ATTRACTORS:]
    for one in found.attractors[:MOST_ATTRACTORS]:
        row(table, one.kind, f"{len(one.members):,}", f"{100.0 * len(one.members) / of_all:.3g} %")
    if rest:
        left = sum(len(one.members) for one in rest)
        row(table, f"{len(rest)} others", f"{left:,}", f"{100.0 * left / of_all:.3g} %")
    console.print(table)
    none = found.done - len(found.verdicts)
    lost = f" {none:,} of the grid are no start, a journal being outside its bearing." if none else ""
    print_line(f"{asked.turns} turns of each start, {asked.dropped} of them dropped, {asked.steps:,} steps a turn; {found.laws}.{lost}")
    same = "whose points are within 1 % of that of all"
    if asked.varied:
        same = f"of one period, for their points move with {' and '.join(asked.varied)}"
    print_line(f"A period is told within 0.1 % of the range; periodic motions are one {same}.")
    print_line(f"Companions: {found.told or 'none.'}")


def tell_section(found: PoincareSection) -> None:
    """What a motion is, and what says so."""
    asked, verdict = found.asked, found.verdict
    print_line(f"{found.name}: {verdict.kind}")
    print_line(f"{verdict.evidence[:1].upper()}{verdict.evidence[1:]}.")
    for name, one in found.struck.items():
        fastest = f", the fastest at {one['speed'].max():.4g} m/s" if len(one["speed"]) else ""
        count = len(one["speed"])
        held = "" if count else "; if it is closed all the time, a law that has the speed of its onset in it remembers that of long ago"
        print_line(f"{name}: {count:,} contact{'' if count == 1 else 's'} began{fastest}{held}.")
    print_line(f"{found.done:,} turns after {asked.dropped:,} that were dropped, {asked.steps:,} steps a turn; {found.laws}. Without companions.")


def turning(asked: WaterfallSpec) -> str:
    """Speeds as the axis of the figure has them, in brackets; nothing of other numbers."""
    low, high = (30.0 / math.pi * asked.values[end] for end in (0, -1))
    return f" ({low:.4g} to {high:.4g} rpm)" if asked.unit == "rad/s" else ""


def tell_waterfall(found: Waterfall) -> None:
    """What was swept, and how it was transformed."""
    asked = found.asked
    ends = f"from {asked.values[0]:.6g} to {asked.values[-1]:.6g} {asked.unit}{turning(asked)}"
    print_line(f"{found.name}: {', '.join(asked.series)} over {asked.path} {ends}")
    print_line(f"{found.done:,} runs. {found.words}.")
    print_line(f"{found.limits[:1].upper()}{found.limits[1:]}; without companions; each run begins at the model's own start.")
    if found.diverged:
        print_line(f"At {', '.join(f'{value:g}' for value in found.diverged)} {asked.unit} the motion diverged.")
