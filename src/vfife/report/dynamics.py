"""Documents on motions: bifurcation diagrams, basins of attraction, Poincaré sections, waterfalls,
strongest waves.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..job.progress import counted
from ..measures.chaos import (
    CHAOTIC,
    LONGER,
    LONGER_OR_STEP,
    NO_POINTS,
    SCATTER,
    STEP_UNKNOWN,
    TEST_POINTS,
    UNDECIDED,
    UNSETTLED,
    longer_transient,
)
from ..model.functions import turn_of
from .amounts import quantity
from .design_words import and_words
from .document import Caution, Document, Paragraph, Table, incomplete, paragraphs

if TYPE_CHECKING:
    from ..dynamics.basins import Basins
    from ..dynamics.bifurcation import Bifurcation, Spell
    from ..dynamics.sections import PoincareSection
    from ..dynamics.waterfall import Waterfall

DIRECTIONS = {"up": "On the way up", "down": "On the way down"}
MOST_ATTRACTORS = 12
MOST_SPELLS = 8  # ranges of values of one direction that are listed
PEAKS = 8
SETTLING = 6.91  # ln 1000: a difference of the range of points decays to the tolerance of 0.1 %
PERIODIC = (
    "A motion is periodic if points repeat within 0.1 % of their range or 1e-5 of their size, or scatter with"
    f" the step within {100.0 * SCATTER:g} % of the motion's range"
)
UNESTIMATED = "Errors of points, of the 0-1 test and of onsets: not estimated."


def document(result: Any) -> Document:
    """Return the document of any kind of map."""
    documents: dict[str, Any] = {
        "Bifurcation": diagram,
        "Basins": basins,
        "PoincareSection": section,
        "Waterfall": waterfall,
    }
    document: Document = documents[type(result).__name__](result)
    spec, turn = result.spec, turn_of(result.mechanism) or 0.0
    # In chains the time goes on from value to value.
    motions = len(spec.values) if getattr(spec, "starts", None) == () else 1
    cautions = [
        Caution(text)
        for load in result.mechanism.loads.values()
        for text in (*load.cautions(), load.end_caution(motions * spec.turns * turn))
        if text
    ]
    return dataclasses.replace(document, parts=[*document.parts, *cautions])


def _protocol(result: Any, turns: str) -> str:
    """Return how many turns were run and dropped with how many steps, and under which laws."""
    return f"{turns}, {result.spec.dropped} discarded, {result.spec.steps:,} steps a turn; {result.laws}."


def diagram(result: Bifurcation) -> Document:
    """Return a document with the number of values of each kind of motion, and ranges of values."""
    spec, (factor, unit) = result.spec, result.shown
    if not any(map(any, result.kinds)):
        words = f"{NO_POINTS}: none of {len(spec.values):,} values is complete"
        return Document(paragraphs([f"{result.name}: {spec.path}: {words}."]))
    ways = spec.ways
    heads = ways if spec.starts else (f"values on the way {ways[0]}", f"on the way {ways[1]}")
    counts = [Counter(kind for kind in kinds if kind) for kinds in result.kinds]
    rows = [
        (result.words_of(kind), *(count[kind] for count in counts))
        for kind in sorted({kind for count in counts for kind in count}, key=_period)
    ]
    texts = [
        _chaos(result),
        *(
            f"{DIRECTIONS.get(way, way)}: {spells_words(result.spells(k), unit, factor)}{_gap(result, k)}."
            for k, way in enumerate(spec.ways)
        ),
        *_longer_periods(
            [
                (f"{quantity(factor * value, unit)} ({way})", motion)
                for way, motions in zip(ways, result.verdicts, strict=True)
                for value, motion in zip(spec.values, motions, strict=True)
                if motion is not None
            ]
        ),
        _protocol(result, f"{spec.turns} turns at each value"),
        (
            f"{PERIODIC}; chaotic within these turns if a small difference grows more than e-fold in each"
            f" half of them, and by more than the error of so few. Exponents, {STEP_UNKNOWN}."
        ),
        _step_errors(result),
        f"Companions: {result.step_report or 'none.'}",
    ]
    return Document(
        [*incomplete(result.progress), Table.numeric(("motion", *heads), rows), *paragraphs(texts)],
        f"{result.name}: {spec.path}",
    )


def _longer_periods(motions: Sequence[tuple[str, Any]]) -> list[str]:
    """Return which of some motions, each with the words of its place, repeat after more turns than the period
    that is shown.
    """
    places: dict[tuple[str, int], list[str]] = {}
    for place, motion in motions:
        if motion.repeats:
            places.setdefault((motion.kind, motion.repeats), []).append(place)
    texts = []
    for (kind, repeats), names in places.items():
        rest = f" and {len(names) - MOST_SPELLS} more" * (len(names) > MOST_SPELLS)
        texts.append(f"{kind} may be period {repeats} at {', '.join(names[:MOST_SPELLS])}{rest}")
    if not texts:
        return []
    distance = 100.0 * max(motion.scatter for _, motion in motions if motion.repeats)
    words = "; ".join(texts)
    return [
        f"{words[:1].upper()}{words[1:]}: points within the longer period differ by up to {distance:.2g} % of"
        " the motion's range, which the step may cause; compare half the step."
    ]


def _step_errors(result: Bifurcation) -> str:
    """Return that errors of a diagram are not estimated, and what companions of a sweep leave out."""
    spec, (factor, unit) = result.spec, result.shown
    count = len(spec.values)
    width = abs(factor * (spec.values[-1] - spec.values[0])) / max(count - 1, 1)
    interval = f" (values are {quantity(width, unit)} apart)" if count > 1 else ""
    text = f"Errors of points and of values at which the motion changes{interval}: not estimated."
    if spec.starts:
        return text
    return (
        f"{text} Each value continues the motion of the value before, with the errors collected so far;"
        " companions repeat a value from that state, and show only the error of this value."
    )


def _gap(result: Bifurcation, chain: int) -> str:
    """Return between which values a chain is not computed yet, or how many of them; empty if it is."""
    kinds, (factor, unit) = result.kinds[chain], result.shown
    gap = [k for k, kind in enumerate(kinds) if not kind]
    if not gap:
        return ""
    if gap[-1] - gap[0] >= len(gap):
        return f"; {counted(len(gap), 'value')} not computed"
    ends = sorted(result.spec.values[k] for k in (gap[0], gap[-1]))
    low, high = (quantity(factor * end, unit) for end in ends)
    return f"; not computed {f'from {low} to {high}' if len(gap) > 1 else f'at {low}'}"


def _period(kind: str) -> tuple[float, str]:
    """Sorting key: periodic motions first, the shortest period before longer ones."""
    return (int(kind.removeprefix("period ")), "") if kind.startswith("period ") else (math.inf, kind)


def _chaos(result: Bifurcation) -> str:
    """Return between which values chaos was found in each direction; other motions may lie between them."""
    texts = []
    factor, unit = result.shown
    for way, kinds in zip(result.spec.ways, result.kinds, strict=True):
        values = [value for value, kind in zip(result.spec.values, kinds, strict=True) if kind == CHAOTIC]
        if values:
            low, high = (quantity(factor * end, unit) for end in (min(values), max(values)))
            place = f"between {low} and {high}" if len(values) > 1 else f"at {low}"
            direction = DIRECTIONS[way].lower() if way in DIRECTIONS else f"from {way}"
            computed = " computed" if result.progress else ""
            texts.append(f"{direction} {place} ({len(values)} of {sum(map(bool, kinds))}{computed} values)")
    if texts:
        limit = " Companions make as many turns and do not show it." if result.companions else ""
        return (
            f"{result.words_of(CHAOTIC).capitalize()}: {', '.join(texts)};"
            f" {longer_transient(result.spec.turns)}.{limit}"
        )
    values = result.spec.values
    low, high = (quantity(factor * end, unit) for end in (min(values), max(values)))
    count = result.progress or counted(len(values), "value")
    ends = f"from {low} to {high}" if len(values) > 1 else f"of {low}"
    place = f"within {result.spec.turns:,} turns at {count} {ends}"
    motions = [kind for kinds in result.kinds for kind in kinds if kind]
    open_kinds = sum(kind in (UNDECIDED, UNSETTLED) for kind in motions)
    if not open_kinds:
        return f"No chaos was found {place}."
    if open_kinds == len(motions):
        return f"Whether there is chaos is not known: no motion is decided {place}. Take more turns."
    part = f"{open_kinds} of {counted(len(motions), 'motion')}"
    return f"No chaos was found {place}; of {part} nothing is known."


def spells_words(spells: Sequence[Spell], unit: str, factor: float = 1.0) -> str:
    """Return ranges of values with one kind of motion as text, in a unit by its factor; of many the
    longest.
    """
    places = sorted(range(len(spells)), key=lambda k: -spells[k].count)[:MOST_SPELLS]
    longest = [spells[k] for k in sorted(places)]
    texts = [
        f"{spell.kind} {f'from {quantity(factor * spell.first, unit)} to' if spell.count > 1 else 'at'}"
        f" {quantity(factor * spell.last, unit)}"
        for spell in longest
    ]
    left_out = len(spells) - len(longest)
    return ", ".join(texts) + (f", and {left_out} others between them" if left_out else "")


def basins(result: Basins) -> Document:
    """Return a document with the number of starts that lead to each motion; motions have the numbers of the
    figure.
    """
    spec, total = result.spec, max(len(result.verdicts), 1)
    sizes = [
        (f"{k}. {result.words_of(attractor.kind)}", len(attractor.members))
        for k, attractor in enumerate(result.attractors, 1)
    ]
    if len(sizes) > MOST_ATTRACTORS:
        left_out = sizes[MOST_ATTRACTORS:]
        numbers = f"{MOST_ATTRACTORS + 1} to {len(sizes)}"
        sizes[MOST_ATTRACTORS:] = [
            (f"{numbers}. {len(left_out)} others", sum(count for _, count in left_out))
        ]
    rows = [(kind, f"{count:,}", f"{100.0 * count / total:.3g} %") for kind, count in sizes]
    excluded = result.done - len(result.verdicts)
    impossible = (
        f" {excluded:,} of the grid are not valid starts: a journal is outside its bearing."
        if excluded
        else ""
    )
    criterion = (
        f"periodic motions are one of one period, for their points move with {' and '.join(spec.varied)}"
        if spec.varied
        else "a motion belongs to a periodic one, settled or not, if all their points agree within"
        f" {100.0 * result.share:.2g} % of the range of the motion"
        f" ({'error of the step, 0.1 to 1 %' if result.companions else 'error of the step not known'})"
    )
    texts = [
        *start_caution(result),
        *_undecided_starts(result),
        *_longer_periods([(f"start {number + 1}", motion) for number, motion in result.verdicts.items()]),
        *_unsettled_starts(result),
        *_transients(result),
        f"{_protocol(result, f'{spec.turns} turns of each start')}{impossible}",
        f"{PERIODIC}; {criterion}.",
        "Shares count starts of the grid. Errors of points and of shares of the area: not estimated.",
        f"Companions: {result.step_report or ('not computed yet.' if result.progress else 'none.')}",
    ]
    share = f"share of these {total:,}" if result.progress else "share"
    return Document(
        [*incomplete(result.progress), Table.numeric(("motion", "starts", share), rows), *paragraphs(texts)],
        f"{result.name}: {spec.paths[0]}, {spec.paths[1]}",
    )


def start_caution(result: Basins | PoincareSection) -> list[str]:
    """Return the caution on a given velocity that is not the one with which a motion starts."""
    if result.misfit is None:
        return []
    place = "At some starts" if hasattr(result.spec, "paths") else "In this motion"
    return [f"{place} a given velocity is not that of the run. {result.misfit.text}"]


def _undecided_starts(result: Basins) -> list[str]:
    """Return the remedy if more than a quarter of the starts are not decided, because few turns of each are
    recorded, or for the step.
    """
    reasons = [motion.reason for motion in result.verdicts.values() if motion.kind == UNDECIDED]
    of_step = sum(LONGER_OR_STEP in reason for reason in reasons)
    if 4 * of_step > len(result.verdicts):
        return [
            f"{of_step:,} of {len(result.verdicts):,} starts are not decided: their points repeat within"
            f" {100.0 * SCATTER:g} % of the motion's range, and much closer after more turns. That is"
            f" {LONGER_OR_STEP}."
        ]
    undecided = len(reasons) - of_step
    recorded = result.spec.turns - result.spec.dropped
    if 4 * undecided <= len(result.verdicts) or recorded >= TEST_POINTS:
        return []
    return [
        f"{undecided:,} of {len(result.verdicts):,} starts are not decided, because only"
        f" {counted(recorded, 'turn')} of each {'is' if recorded == 1 else 'are'} recorded: record"
        f" {TEST_POINTS} or more (turns ="
        f" {3 * TEST_POINTS}; two thirds are discarded by default)."
    ]


def _unsettled_starts(result: Basins) -> list[str]:
    """Return what chaotic starts leave open, and the remedy if more than a quarter of the starts are not
    settled.
    """
    spec, motions = result.spec, result.verdicts
    chaotic = any(motion.kind == CHAOTIC for motion in motions.values())
    texts = [f"{result.words_of(CHAOTIC).capitalize()}: {longer_transient(spec.turns)}."] * chaotic
    numbers = [n for group in result.attractors if group.kind == UNSETTLED for n in group.members]
    if 4 * len(numbers) > len(motions):
        growths = [growth.value for n in numbers if (growth := motions[n].exponent) and growth.value < 0.0]
        rate = max(float(np.median(growths or [0.0])), -SETTLING)
        # Turns to be discarded until a difference of the size of the motion is within the tolerance.
        needed = SETTLING * spec.turns / max(spec.dropped, 1) / max(-rate, 1e-6)
        advised = min(max(10 * math.ceil(needed / 10.0), 2 * spec.turns), LONGER * spec.turns)
        reason = f": a small difference shrinks by {-100.0 * rate:.2g} % a turn there" * (rate < 0.0)
        shares = f"{len(numbers):,} of {len(motions):,}"
        texts.append(f"{shares} starts are not settled: take more turns (--turns {advised}{reason}).")
    return texts


def _transients(result: Basins) -> list[str]:
    """Return which periodic motions may be transients, and the remedy."""
    numbers = [str(k + 1) for k in result.transients]
    if not numbers:
        return []
    plural = len(numbers) > 1
    subject, noun = (f"Motion{'s' * plural} {and_words(numbers)}", "transients" if plural else "a transient")
    return [
        f"{subject} of this table may be {noun} near an unstable motion: the exponents of"
        f" {'their' if plural else 'its'} starts do not show that a small difference decays. Take more turns."
    ]


def section(result: PoincareSection) -> Document:
    """Return a document with the kind of a motion, its evidence, and the contacts that began."""
    spec = result.spec
    if not result.done:
        status = f"{result.name}: {NO_POINTS}, the first {counted(spec.dropped, 'turn')} are discarded"
        protocol = f"{counted(spec.turns, 'turn')} are planned, {spec.steps:,} steps a turn; {result.laws}."
        return Document(paragraphs([status, protocol]))
    verdict = result.verdict
    texts = [f"{result.name}: {verdict.words}", f"{verdict.evidence[:1].upper()}{verdict.evidence[1:]}."]
    if (later := result.later_exponent) is not None:
        drop = spec.turns - result.done // 2
        texts.append(f"In the second half of these turns: {later.words}. Drop more turns (--drop {drop}).")
    for name, impacts in result.struck.items():
        count = len(impacts["speed"])
        fastest = f", the fastest at {impacts['speed'].max():.4g} m/s" if count else ""
        closed = (
            ""
            if count
            else (
                "; in a joint that is always in contact, the law still uses the impact speed with which that"
                " contact began, before the turns that are shown"
            )
        )
        texts.append(f"{name}: {counted(count, 'contact')} began{fastest}{closed}.")
    texts.append(
        f"{result.done:,} turns after {spec.dropped:,} discarded turns, {spec.steps:,} steps a turn;"
        f" {result.laws}. {_range_of_exponent(result)}"
    )
    texts += start_caution(result)
    return Document([*incomplete(result.progress), *paragraphs(texts)])


def _range_of_exponent(result: PoincareSection) -> str:
    """Return where the range of a section's exponent comes from."""
    if result.exponent is None or not result.exponent.estimated:
        return f"Without companions. {UNESTIMATED}"
    return (
        "The exponent's range includes a second motion with half the step; near a bifurcation it may be too"
        f" narrow. {UNESTIMATED}"
    )


def waterfall(result: Waterfall) -> Document:
    """Return a document with the range of the sweep and the transform of the series."""
    spec = result.spec
    low, high = spec.values[0], spec.values[-1]
    speeds = (
        f" ({30.0 / math.pi * low:.4g} to {30.0 / math.pi * high:.4g} rpm)" if spec.unit == "rad/s" else ""
    )
    texts = [
        (
            f"{result.name}: {', '.join(spec.series)} over {spec.path} from {low:.6g} to {high:.6g}"
            f" {spec.unit}{speeds}"
        ),
        f"{counted(result.done, 'run')}. {result.words}.",
        (
            f"{result.limits[:1].upper()}{result.limits[1:]}; without companions, so errors of amplitudes are"
            " not estimated; each run begins at the model's own start."
        ),
    ]
    if result.diverged:
        texts.append(
            f"At {', '.join(f'{value:g}' for value in result.diverged)} {spec.unit} the motion diverged."
        )
    return Document([*incomplete(result.progress), *paragraphs(texts)])


def spectra(spectra: Sequence[Any], name: str) -> Document:
    """Return a document of the strongest waves of each series of the run ``name``.

    ``spectra`` may be spectra; spectrograms, whose waves have the time at which they are strongest; or
    envelopes with their own spectra.
    """
    first = spectra[0]
    timed = hasattr(first, "times") and not hasattr(first, "spectrum")
    turning = getattr(first, "spectrum", first).turn is not None
    heads = (
        "series",
        *(("order",) if turning else ()),
        "frequency, Hz",
        "amplitude",
        *(("at, ms",) if timed else ()),
    )
    rows = []
    for series in spectra:
        of = getattr(series, "spectrum", series)
        sizes = of.amplitudes.max(axis=0) if timed else of.amplitudes
        for n, k in enumerate(strongest(sizes, of.window)):
            time = (f"{1e3 * of.times[int(of.amplitudes[:, k].argmax())]:.4g}",) if timed else ()
            order = (f"{of.orders[k]:.4g}",) if turning else ()
            rows.append(
                (
                    of.name if n == 0 else "",
                    *order,
                    f"{of.frequencies[k]:.5g}",
                    f"{sizes[k]:.4g} {of.unit}",
                    *time,
                )
            )
    words = f"{first.words[0].upper()}{first.words[1:]}."
    return Document([Table.numeric(heads, rows), Paragraph(words)], title=f"{name}: the strongest waves")


def waves(transformed: Any) -> Document:
    """Return a document of the strongest waves of a spectrum, spectrogram or envelope."""
    return spectra([transformed], transformed.name)


def strongest(sizes: Any, window: str) -> list[int]:
    """Return the indices of the highest local maxima, without the mean and the neighbours over which the
    window spreads it.
    """
    from ..measures.spectral import COSINES

    inside = ((sizes[1:-1] >= sizes[:-2]) & (sizes[1:-1] > sizes[2:])).nonzero()[0] + 1
    return sorted((int(k) for k in inside if k >= len(COSINES[window])), key=lambda k: -sizes[k])[:PEAKS]
