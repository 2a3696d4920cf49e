"""Dead centres: the ends of the stroke of bodies on straight guides, against those of the ideal mechanism.

Positions are those at the outputs, which miss the end of a stroke by up to half of the second difference
beside it. The outputs of the ideal mechanism lie at the same times and miss its end by about as much: the
difference of both is known better than either.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ..kinematics.drives import guide_of
from ..measures.motion import slider_motion
from ..measures.output_intervals import missed_end
from ..measures.turn_peaks import windows
from ..measures.values import NOT_ESTIMATED
from ..model.functions import cycle_of
from ..numerics.outward import UP, exponent
from .amounts import fixed_point, prefixed
from .digits import Json, is_estimated, uncertainty
from .document import Table

if TYPE_CHECKING:
    from ..results.run_data import RunData

STEEP = 0.7  # least size of the vertical part of a guide's direction for its ends to be top and bottom
AT_REST = 1e-9  # m: a body on a guide that moves by less has no stroke
MOST_BODIES = 2  # bodies of which the short answer has the dead centres
FINEST, SMALLEST_PLACE = 5, 1e-5  # decimals of a position (mm), and the last of them (mm)


def dead_centres(result: RunData, measures: Json, ideal: Json) -> list[dict[str, Any]]:
    """Return the ends of the strokes along guides that stand on the ground, two of each guide.

    Each has ``joint``, ``body``, ``name`` ("bottom dead centre"), the ``measure`` with its ``position`` (m),
    that of the ``ideal`` mechanism (None without one), ``short`` (m, less than 0 beyond the ideal end), and
    ``missed`` (m), by how much the outputs may miss the end.

    Where bodies turn slower than the fastest driver, a turn has no dead centres: the ends are those of all
    turns that count.
    """
    record = result.record
    mechanism, turn, time = record.assembly.mechanism, record.assembly.choice.turn, float(result.time[-1])
    parts = list(windows(record, result.motion))
    is_slower = any(count > 1 for name, count in cycle_of(mechanism).items() if name in mechanism.bodies)
    turns = turn is not None and time >= turn * (1.0 - 1e-9) and not is_slower
    entries = []
    for joint in mechanism.joints:
        slider = guide_of(mechanism, joint)
        low, high = (measures.get(f"{joint}.position.{end}") for end in ("low", "high"))
        if slider is None or slider[0].sides[0][0] != "ground" or low is None or high - low < AT_REST:
            continue
        body, travel = slider[0].sides[1][0], slider_motion(record, joint).position
        for end, sign, name in zip(
            ("low", "high"), (-1.0, 1.0), _names(slider[1].unit(), turns), strict=True
        ):
            measure = f"{joint}.position.{end}"
            position, reference = measures[measure], ideal.get(measure)
            if is_slower:
                turn_values = result.measures[measure]
                position, reference = turn_values.lowest if end == "low" else turn_values.highest, None
            entries.append(
                {
                    "joint": joint, "body": body, "name": name, "measure": measure,
                    "position": float(position),
                    "ideal": None if reference is None else float(reference),
                    "short": None if reference is None else sign * float(reference - position),
                    "missed": max(missed_end(travel, part, sign) for part in parts),
                }
            )  # fmt: skip
    return entries


def _names(direction: Any, turns: bool) -> tuple[str, str]:
    """Return the names of the ends with the least and the greatest position along a guide."""
    upward = float(direction[1])
    if abs(upward) < STEEP:
        names = "least travel", "greatest travel"
        return (f"dead centre of {names[0]}", f"dead centre of {names[1]}") if turns else names
    names = ("bottom dead centre", "top dead centre") if turns else ("lowest position", "highest position")
    return names if upward > 0.0 else (names[1], names[0])


# ----------------------------------------------------------------------------------------------------- text


def facts(summary: Json) -> list[tuple[str, str]]:
    """Return a line on the dead centres of each of the first :data:`MOST_BODIES` bodies on guides."""
    entries = summary.get("dead_centres") or []
    rows = []
    for joint in list(dict.fromkeys(entry["joint"] for entry in entries))[:MOST_BODIES]:
        ends = [entry for entry in entries if entry["joint"] == joint]
        texts = ", ".join(_end(summary, entry) for entry in ends)
        estimated = all(is_estimated(summary, entry["measure"]) for entry in ends)
        note = "" if estimated else f"; {NOT_ESTIMATED}"
        turns = any("dead centre" in entry["name"] for entry in ends)
        rows.append((f"{'Dead centres' if turns else 'Travel'} {ends[0]['body']}", texts + note))
    return rows


def _end(summary: Json, entry: Json) -> str:
    """Return an end of a stroke in few words."""
    word = entry["name"].split()[0]
    word = f"{word} " if word in ("top", "bottom", "lowest", "highest") else ""
    aside = (
        "" if entry["ideal"] is None else f" (ideal {_position(summary, entry, 'ideal').removesuffix(' mm')})"
    )
    return f"{word}{_position(summary, entry)}{aside}"


def lines(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield a name and a sentence for each dead centre, beside the list of all measures."""
    for entry in summary.get("dead_centres") or []:
        text = f"{entry['body']}: {entry['name']} {_position(summary, entry)}"
        if entry["ideal"] is not None:
            text += f", {_difference(summary, entry)}"
        yield "Dead centre", f"{text} ({_error(summary, entry)}; {entry['measure']})"


def table(summary: Json, part: str) -> Table:
    """Return the table of the dead centres of all bodies on guides."""
    entries = summary.get("dead_centres") or []
    compared = any(entry["ideal"] is not None for entry in entries)
    rows = []
    for entry in entries:
        ideal = [_position(summary, entry, "ideal"), _difference(summary, entry)] if compared else []
        rows.append((entry["body"], entry["name"], _position(summary, entry), *ideal, _error(summary, entry)))
    heads = ("body", "end of the stroke", "position", *["ideal", "difference"] * compared, "error")
    return Table(
        heads, rows, f"Dead centres, positions along the guide {part}", numbers=(2, 3) if compared else (2,)
    )


def _places(summary: Json, entry: Json) -> int:
    """Return the decimals of a position (mm): two digits of the difference from the ideal one, none finer
    than scatter, or than half of what the outputs miss.
    """
    difference = 1e3 * abs(entry["short"] or 0.0)
    places = 1 - exponent(difference) if difference > SMALLEST_PLACE else 2
    error = max(1e3 * uncertainty(summary, entry["measure"]), 1e3 * entry["missed"])
    return max(0, min(places, FINEST, -exponent(error) if error > 0.0 else FINEST))


def _position(summary: Json, entry: Json, key: str = "position") -> str:
    value = entry[key]
    return "" if value is None else f"{fixed_point(1e3 * value, _places(summary, entry))} mm"


def _difference(summary: Json, entry: Json) -> str:
    """Return by how much a stroke ends before or behind the end of the ideal mechanism."""
    short = entry["short"]
    if short is None:
        return ""
    text = fixed_point(1e3 * abs(short), _places(summary, entry))
    if float(text.replace(",", "")) == 0.0:
        return "as the ideal mechanism"
    return f"{text} mm {'short of' if short > 0.0 else 'beyond'} the ideal mechanism"


def _error(summary: Json, entry: Json) -> str:
    """Return what is known of the error of a position."""
    width = uncertainty(summary, entry["measure"])
    estimated = is_estimated(summary, entry["measure"])
    source = "over turns or steps" if estimated else "over turns"
    texts = [f"± {prefixed(0.5 * width, 'm', width)} {source}"] if width > AT_REST else []
    texts += [f"outputs miss up to {prefixed(entry['missed'], 'm', entry['missed'], UP)}"]
    return ", ".join([*texts, *([] if estimated else [f"change with the step {NOT_ESTIMATED}"])])
