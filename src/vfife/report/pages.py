"""The report of a run, and that of a study, as a page to be read on a screen and printed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import VfifeError
from ..files import read_bytes
from ..modelfile import dump, load
from .check import mechanism_parts
from .document import (
    Bullets,
    Document,
    Element,
    Facts,
    Figure,
    Paragraph,
    Part,
    Section,
    Table,
    named,
    sentences,
)
from .html import page
from .run import facts, footnotes, tables
from .statics import equilibria
from .study import error_table, extreme_table, parameter_table, quantity, where
from .summary import report

if TYPE_CHECKING:
    from ..results.studied import Study
    from ..results.view import View

TRUSTED = ("Step", "Run", "Turns", "Trust", "Energy")  # facts on how reliable the numbers are
LONGEST = 60_000  # characters of a model that are shown
MOST_ROWS = 1000
SCRIPT = """<script>
for (const button of document.querySelectorAll("button[data-positions]"))
  button.onclick = () => {
    const frame = document.querySelector("iframe");
    frame.contentWindow.postMessage({ positions: JSON.parse(button.dataset.positions) }, "*");
    frame.scrollIntoView({ behavior: "smooth", block: "center" });
    document.getElementById("picked").textContent = button.dataset.said;
  };
</script>"""


def run_page(result: View, pictures: Mapping[str, str], live: str | None, source: str | None) -> str:
    """The report of a run: ``pictures`` are elements by their titles, ``live`` is a page shown in it,
    ``source`` the path of the model file.
    """
    summary = report(result)
    about = summary["model"]
    cautions = [*summary["warnings"], *summary["remarks"]]
    sections = (
        Section("Found", found(summary)),
        Section("Cautions", [Bullets(cautions) if cautions else Paragraph("None.")]),
        Section("Trust", trust(summary)),
        Section("Figures", _figures(pictures)),
        Section("The mechanism running", [] if live is None else [_frame(live)]),
        Section("Inputs", _inputs(result, source)),
        Section("Derived parameters", _derived(summary)),
    )
    return page(
        Document(sections, about["name"]),
        (about["note"], f"Read from {Path(about['source']).name}." if about["source"] else ""),
    )


def found(summary: dict[str, Any]) -> list[Part]:
    """Peaks with their ranges, effects of play, losses; of a static analysis its equilibria."""
    if summary["run"].get("analysis") == "static":
        return equilibria(summary)
    shown = [(name, text) for topic, name, text in _topics(summary) if topic not in (*TRUSTED, "Laws")]
    return [Facts(shown), *tables(summary), *sentences(footnotes(summary))]


def trust(summary: dict[str, Any]) -> list[Part]:
    """Step, companions, the energy ledger, depths at which contacts began."""
    if summary["run"].get("analysis") == "static":
        return []
    depths = [
        (
            name,
            f"{one.get('deep_landings', 0.0):.0f} of {one.get('impacts', 0.0):.0f}",
            f"{1e6 * one.get('landing_depth.max', 0.0):.4g} µm",
        )
        for name, one in summary["contacts"].items()
    ]
    onsets = (
        [Table.of(("contact", "too deep", "deepest"), depths, "Depth at which contacts began")]
        if depths
        else []
    )
    return [
        Facts([(name, text) for topic, name, text in _topics(summary) if topic in TRUSTED]),
        *onsets,
        *sentences(summary["run"]["notes"]),
    ]


def _topics(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Facts with the last name above each of them."""
    lines, topic = [], ""
    for name, text in facts(summary):
        topic = name or topic
        lines.append((topic, name, text))
    return lines


def _figures(pictures: Mapping[str, str]) -> list[Part]:
    return [Figure(title, lambda picture=picture: picture) for title, picture in pictures.items()]  # type: ignore[misc]


def _frame(live: str) -> Part:
    """A page in the page, without access to it."""
    opened = (
        '<iframe title="the mechanism running" sandbox="allow-scripts allow-downloads"'
        f' srcdoc="{escape(live)}"></iframe>'
    )
    return Element(
        f'<div class="screen">{opened}</div><p class="paper">On a screen the mechanism runs here.</p>'
    )


def _inputs(result: View, source: str | None) -> list[Part]:
    """The parts of the mechanism, its model in SI units as it was run, and the file that it was read from."""
    mechanism = result.record.assembly.mechanism
    parts: list[Part] = [*mechanism_parts(mechanism)]
    try:
        model = dump(mechanism)
    except (TypeError, ValueError):
        return [*parts, Paragraph("No model file can hold this mechanism.")]
    return [*parts, _model("In SI units, as it was run", model), *as_given(model, source)]


def as_given(model: str, source: str | None) -> list[Part]:
    """The model file as it reads now, and whether it gives the ``model`` that was run."""
    try:
        text = read_bytes(source).decode("utf-8") if source else ""
        same = bool(text) and dump(load(Path(source or ""))) == model
    except (OSError, VfifeError, ValueError):
        text = ""
    if not text:
        return (
            [Paragraph("The file that it was read from is not there any more, or cannot be read.")]
            if source
            else []
        )
    differs = (
        "It gives the numbers above."
        if same
        else "It gives other numbers than those above: options were added, or it was changed since."
    )
    return [_model("As given", text, f"{Path(source or '').name} as it reads now. {differs}")]


def _model(title: str, text: str, words: str = "") -> Part:
    """A model file, the end of a long one left out."""
    rest = f"\n… and {len(text) - LONGEST:,} signs more" if len(text) > LONGEST else ""
    said = f"<p>{escape(words)}</p>" if words else ""
    return Element(f'<h3>{escape(title)}</h3>{said}<pre class="model">{escape(text[:LONGEST] + rest)}</pre>')


def _derived(summary: dict[str, Any]) -> list[Part]:
    """Parameters that laws derive from radii and materials: formulas, numbers with units, sources."""
    rows = [
        (
            joint,
            f"{kind}: {law['law']}",
            law["formula"],
            named(law["derived"], law.get("units", {})),
            law["source"],
        )
        for joint, laws in summary["laws"].items()
        for kind, law in laws.items()
    ]
    return [Table(("joint", "law", "formula", "parameters", "source"), rows)] if rows else []


def study_page(
    study: Study,
    pictures: Mapping[str, str],
    live: str | None = None,
    places: Mapping[int, Mapping[str, int]] | None = None,
    notes: Sequence[str] = (),
) -> str:
    """The report of a study: ``pictures`` and ``live`` as of a run, ``places`` are positions of sliders of
    the live page by member.
    """
    failed = [(one.number, where(study, one), reason) for one, reason in study.failed[:MOST_ROWS]]
    source = study.asked.get("source")
    read = [Paragraph(f"Read from {source}.")] if source else []
    sections = (
        Section(
            "Found",
            [
                parameter_table(study, "What is varied"),
                extreme_table(study, "What it came to"),
                error_table(study),
            ],
        ),
        Section("Failed", [Table(("member", "at", "reason"), failed)] if failed else []),
        Section("Figures", _figures(pictures)),
        Section("A member running", [] if live is None else _running(study, live, places or {}, notes)),
        Section("Members", _members(study, (places or {}) if live else {})),
        Section(
            "Inputs",
            [*read, _model("The model, in SI units, before anything is varied", study.asked["text"])],
        ),
    )
    return page(
        Document(sections, f"{study.model}: {study.name}"),
        (_study_words(study), study.asked.get("note", "")),
        SCRIPT,
    )


def _study_words(study: Study) -> str:
    """How many members ended, over how many turns."""
    wanted, counts = (
        study.asked["wanted"],
        ", ".join(f"{count:,} {word}" for word, count in study.counts.items() if count),
    )
    until = (
        ""
        if wanted["settle"] is None
        else f" at most, until they repeat within {100.0 * wanted['settle']:g} %"
    )
    over = (
        "the last turn"
        if wanted["last"] == 1
        else f"the last {wanted['last']} turns, of which means are told"
    )
    return (
        f"{len(study.members):,} members: {counts}. Each makes {wanted['turns']:,} turns{until}; measures are"
        f" of {over}."
    )


def _running(
    study: Study, live: str, places: Mapping[int, Mapping[str, int]], notes: Sequence[str]
) -> list[Part]:
    """The page in which a member runs."""
    first = study.done[0]
    picked = escape(f"{first.number}: {where(study, first)}")
    said = Element(f'<p class="screen">Member <span id="picked">{picked}</span>; pick another one below.</p>')
    steps = (
        "All run here with as many steps a turn as the finest of them, so numbers may differ from the study's"
        " as far as they depend on the step."
    )
    left = len(study.done) - len(places)
    rest = [f"{left:,} members run by themselves only, with vfife live."] if left > 0 else []
    return [said, _frame(live), *sentences([steps, *rest, *(f"{note}." for note in notes)])]


def _members(study: Study, places: Mapping[int, Mapping[str, int]]) -> list[Part]:
    """Every member with its measures, and a button that runs it."""
    names = [*(one.name for one in study.parameters), *study.measures]
    units = {**{one.name: one.unit for one in study.parameters}, **study.measures}
    rows, known = [], {one.number: one for one in study.members}
    for row in study.rows()[:MOST_ROWS]:
        number = int(row["member"])
        button = [_button(places, number, f"{number}: {where(study, known[number])}")] if places else []
        rows.append((number, *(quantity(row[name], units[name]) for name in names), row["status"], *button))
    rest = len(study.members) - len(rows)
    left_out = (
        [Paragraph(f"{rest:,} more are in the file; vfife study export writes all of them.")]
        if rest > 0
        else []
    )
    return [
        Table(("member", *names, "ended", *([""] if places else [])), rows, numbers=range(len(names) + 1)),
        *left_out,
    ]


def _button(places: Mapping[int, Mapping[str, int]], number: int, words: str) -> Element:
    """A button that runs a member in the page; nothing for a member that the page cannot run."""
    if number not in places:
        return Element("")
    at = escape(json.dumps(places[number]))
    return Element(f'<button data-positions="{at}" data-said="{escape(words)}" class="screen">run</button>')
