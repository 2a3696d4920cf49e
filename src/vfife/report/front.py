"""First page of a report, for a reader who decides: what clearance costs, which joint suffers most, and how
certain that is.
"""

from __future__ import annotations

import base64
import dataclasses
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from datetime import date
from html import escape
from pathlib import Path

from ..errors import VfifeError
from ..files import read_bytes
from .amounts import interval, prefixed
from .design_words import and_words, or_words
from .digits import CERTAIN, Json, ideal_force_text, is_undetermined, turns_text, uncertainty
from .document import Element, Facts, Paragraph, Part, Section, Table
from .noise import blow, hardest_joints, knock_speed, rivals
from .overview import certainty, certainty_leads, clearance_note, interrupted_length, joint_table
from .run_tables import NONE_BEGAN, force_text, influence_text, knock_texts, may_not_knock
from .run_up import WITH_RUN_UP, run_ups

LARGEST_LOGO = 1_000_000  # bytes
PICTURES = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}
# What the words of tables and facts mean; each is explained below the part in which it occurs first.
TERMS = {
    "ideal": "the same mechanism with joints without clearance",
    "change": (
        "by how much clearance raises the largest value, in per cent of the ideal one: local influence"
        " parameter, LIP(F) of a force, LIP(a) of an angular acceleration"
    ),
    "knocks": "speed at which the two surfaces of a joint meet, at the hardest impact",
    "penetration": "depth by which the surfaces of a joint press into each other",
    "pressure": "pressure between the surfaces by the theory of Hertz",
    "free flight": "share of the time in which the surfaces do not touch",
    "grazing": "contacts that begin slower than the least impact speed of their law",
    "landed too deep": "contacts that are already deep after their first step; a smaller step resolves them",
    "line pressure": "largest pressure between surfaces that touch along a line, by the theory of Hertz",
    "half-width": "half of the width of the strip on which the surfaces touch",
    "p v": "pressure times sliding speed, which limits a dry bearing",
    "Trust": "how far the numbers differ from those of the same run with smaller and larger time steps",
    "ledger": "balance of energies supplied, stored and lost; the remainder is an error of the run",
    "shaking": "force and moment with which the running mechanism acts on its base",
}


# Options of the command line in sentences of the answer, and what stands in their place in a report.
OPTIONS: dict[str, str | Callable[[re.Match[str]], str]] = {
    r"vfife compare MODEL --contact (\S+) --companions 3, with the other options of this run": (
        lambda match: f"compare the contact laws {and_words(match[1].split(','))}"
    ),
    r"run it again with (?:--set \S+\.contact\.(\w+=[\w-]+(?:\.\d+)?) ?)+": (
        r"compare contact.\1 in these joints"
    ),
    r"compare --set \S+\.elements=\d+(?: --set \S+\.elements=\d+)*": "compare twice the elements",
    r"operation: vfife run MODEL --start-from RUN": "operation is in a run that starts from its end",
    r" \(--long\)": "",
    r"more: --long": "more",
    r"run it with --turns (\d+) --settle 1%": r"run up to \1 turns, or until they repeat within 1 %",
}


@dataclass(frozen=True)
class Front:
    """What a reader finds on the first page besides the results: ``author``, date and ``logo`` (a file)."""

    author: str = ""
    day: str = ""
    logo: str | Path | None = None

    @property
    def line(self) -> str:
        """Author and date."""
        return " · ".join(text for text in (self.author, self.day or date.today().isoformat()) if text)

    def picture(self) -> tuple[bytes, str] | None:
        """Read the logo and return its bytes and media type; None without a logo. Raises VfifeError for a
        file that is not PNG or JPEG.
        """
        if self.logo is None:
            return None
        try:
            data = read_bytes(self.logo, LARGEST_LOGO)
        except OSError as error:
            raise VfifeError(f"logo {self.logo}: it cannot be read: {error.strerror}") from error
        for begin, media in PICTURES.items():
            if data.startswith(begin):
                return data, media
        raise VfifeError(
            f"logo {self.logo}: it is neither a PNG nor a JPEG picture; convert it to one of them"
        )

    def element(self) -> Element:
        """Return the logo as an element of a page."""
        picture = self.picture()
        if picture is None:
            return Element("")
        data = base64.b64encode(picture[0]).decode("ascii")
        return Element(
            f'<img class="logo" alt="{escape(self.author)}" src="data:{picture[1]};base64,{data}">'
        )


def front_page(summary: Json, picture: Part | None) -> Section:
    """Picture, conclusion and table of a run."""
    texts = [Paragraph(text) for text in conclusion(summary)]
    table = joint_table(summary) if "joints" in summary else Table((), ())
    rows = [tuple(map(without_options, map(str, row))) for row in table.rows]
    title = f"Whole run, {WITH_RUN_UP}" if run_ups(summary) else ""
    table = dataclasses.replace(table, rows=rows, title=title)
    parts = [*([picture] if picture else []), *texts, *([table] if table.rows else [])]
    parts += clearance_note(summary) if table.rows else []
    return Section("Conclusion", parts)


def conclusion(summary: Json) -> list[str]:
    """Return sentences on the cost of clearance, the joint that differs most, the joints that knock, and how
    certain the numbers are; this first where values are those of a fall at the start or of a run-up.
    """
    if summary["run"].get("analysis") == "static":
        run = summary["run"]
        unstable = sum(factor["unstable"] is True for factor in run["factors"])
        instability = f", {unstable} of them unstable" if unstable else ""
        return [f"The analysis found {run['reached']} of {run['load_factors']} equilibria{instability}."]
    certain, length = without_options(certainty(summary)), interrupted_length(summary)
    part = f"The run was interrupted after {length}; all values are of that part." if length else ""
    texts = [_cost(summary), _joint(summary), _knocks(summary)]
    texts = [certain, *texts] if certainty_leads(summary) else [*texts, certain]
    return [text for text in (part, *texts) if text]


def without_options(text: str) -> str:
    """Return a sentence of the answer for a reader who does not use the command line."""
    for option, words in OPTIONS.items():
        text = re.sub(option, words, text)
    return text


def _cost(summary: Json) -> str:
    joints = summary["joints"]
    if not joints:
        return ""
    names, single = _most_loaded(summary), _single_turn(summary)
    mean = ", a mean over turns," if _turns_differ(summary) else ""
    name, force = or_words(names), _largest_force(summary, names)
    if not any(joint.get("clearance") for joint in joints.values()):
        return f"No joint has clearance; the largest joint force{mean} is {force}, in joint {name}{single}."
    lead = f"With clearance the largest joint force{mean} is {force}"
    ideals = [joint["ideal_force.max"] for joint in joints.values()]
    if any(ideal is None for ideal in ideals):
        return f"{lead}, in joint {name}{single}."
    if len(names) > 1:
        ideal = prefixed(max(ideals), "N")
        return f"{lead}, in joint {name}{single}; with ideal joints it is {ideal}."
    change, place = _change(summary, name), "in that joint" if mean else "there"
    return (
        f"{lead} in joint {name}{single}; with ideal joints it is {ideal_force_text(summary, name)}"
        f" {place}{f', {change}' if change else ''}."
    )


def _turns_differ(summary: Json) -> bool:
    """Return whether largest forces are means over turns that differ."""
    names = (f"{joint}.force.max" for joint in summary["joints"])
    return any(
        turns_text(summary, name, "N", CERTAIN) and not is_undetermined(summary, name) for name in names
    )


def _single_turn(summary: Json) -> str:
    """Return the largest force of a single turn and its joint, where largest forces are means over turns that
    differ; empty elsewhere.
    """
    ranges = summary.get("ranges") or {}
    names = [f"{joint}.force.max" for joint in summary["joints"]]
    names = [name for name in names if name in ranges and not is_undetermined(summary, name)]
    if not names:
        return ""
    # Of all joints: where the turns of the most loaded one hardly differ, its mean is the largest already.
    name = max(names, key=lambda entry: float(ranges[entry]["highest"]))
    span = turns_text(summary, name, "N", CERTAIN)
    largest = span.rpartition(" to ")[2]
    return f"; single turns reach {largest}, in joint {name.removesuffix('.force.max')}" if span else ""


def _most_loaded(summary: Json) -> list[str]:
    """Return the joints whose force may be the largest: that of the largest force, and where that is shown
    as a range, those whose ranges reach it.
    """
    names = [f"{joint}.force.max" for joint in summary["joints"]]
    largest = max(names, key=lambda name: float(summary["measures"][name]))
    uncertain = [
        name for name in names if " to " in force_text(summary, name) and not is_undetermined(summary, name)
    ]
    candidates = rivals(summary, largest, names)
    shown = [name for name in candidates if name == largest or largest in uncertain or name in uncertain]
    return [name.removesuffix(".force.max") for name in shown]


def _largest_force(summary: Json, joints: list[str]) -> str:
    """Return the largest force of joints of which any may have it, with the digits of the widest range."""
    names = [f"{joint}.force.max" for joint in joints]
    if len(names) == 1:
        return force_text(summary, names[0])
    ranges = [summary["ranges"][f"{joint}.force.max"] for joint in summary["joints"]]
    width = max(uncertainty(summary, name) for name in names)
    low, high = (max(float(ends[key]) for ends in ranges) for key in ("low", "high"))
    return interval(low, high, "N", width)


def _joint(summary: Json) -> str:
    joints = {name: joint for name, joint in summary["joints"].items() if joint.get("clearance")}
    rises = {name: summary["lip"].get(f"{name}.force") for name in joints}
    changed = (name for name in joints if influence_text(summary, f"{name}.force"))
    compared = {name: rise for name in changed if (rise := rises[name]) is not None}
    if not compared:
        return ""
    name = max(compared, key=compared.__getitem__)
    force = force_text(summary, f"{name}.force.max")
    clearance = prefixed(joints[name]["clearance"], "m")
    kind = " on each side" if joints[name].get("guide") else ", radial"
    mean = " (mean)" if turns_text(summary, f"{name}.force.max", "N", CERTAIN) else ""
    return (
        f"Of the joints with clearance, {name} ({clearance}{kind}) differs most from the ideal joint: its"
        f" largest force is {force}{mean}, {_change(summary, name)}. The clearance of another joint may cause"
        " that; vfife design ranks them."
    )


def _knocks(summary: Json) -> str:
    """Return the joints that knock, the hardest first, and the largest blow that is no knock."""
    joints = {name: knock_texts(summary, name) for name in summary["joints"]}
    loose = {name: texts for name, texts in joints.items() if texts[0]}
    struck = sorted(
        (name for name in loose if loose[name][0] not in ("none", NONE_BEGAN)),
        key=lambda name: -knock_speed(summary, name),
    )
    sentences = []
    if struck:
        name, *milder = struck
        texts = [f"{joint} {loose[joint][0]}" for joint in milder]
        remainder = f"; {', '.join(texts)}" if texts else ""
        rivals_of = [joint for joint in hardest_joints(summary) if joint in milder]
        speed = loose[name][0]
        meeting = f"{speed} in the hardest knock" if " to " in speed else f"up to {speed}"
        surfaces = f"the surfaces of {name}" if rivals_of else "its surfaces"
        sentences.append(
            f"Joint {' or '.join([name, *rivals_of])} knocks hardest: {surfaces} meet at {meeting}{remainder}"
        )
        if may_not_knock(summary, name):
            sentences.append(f"At other step sizes joint {name} may not knock at all")
    elif loose:
        sentences.append("No joint knocks")
        speeds = [f"{name} {speed}" for name, (_, speed) in loose.items() if speed]
        sentences[0] += f" in these turns; in the whole run, {', '.join(speeds)}" if speeds else ""
    sentences += [f"A blow in closed contact: {text}" for _, text in blow(summary)]
    return "".join(f"{sentence}. " for sentence in sentences).rstrip()


def _change(summary: Json, name: str) -> str:
    """Return the change of the largest force of a joint by clearance, as the table has it; "" without one."""
    change = influence_text(summary, f"{name}.force")
    return f"a change of {change}" if change else ""


def explained(sections: Iterable[Section]) -> list[Section]:
    """Add the meaning of each technical term below the part in which it occurs first."""
    left = dict(TERMS)
    result = []
    for section in sections:
        parts: list[Part] = []
        for part in section.parts:
            parts.append(part)
            text = " ".join(words(part))
            new = {term: left.pop(term) for term in [*left] if term in text}
            if new:
                parts.append(Facts(list(new.items())))
        result.append(Section(section.title, parts))
    return result


def words(part: Part) -> Iterator[str]:
    """Headings and names in which terms occur."""
    match part:
        case Table():
            yield from part.headings
        case Facts():
            yield from (f"{name} {text}" for name, text in part.rows)
        case Section():
            for inner in part.parts:
                yield from words(inner)
