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
    paragraphs,
    quantities,
)
from .html import page
from .run import equilibria, facts, footnotes, tables
from .study import (
    counts_words,
    error_table,
    extreme_table,
    member_table,
    parameter_table,
    settling_words,
    where,
)
from .summary import run_summary

if TYPE_CHECKING:
    from ..results.study import Study
    from ..results.view import View

RELIABILITY = ("Step", "Run", "Turns", "Trust", "Energy")  # facts on how reliable the numbers are
MODEL_LENGTH = 60_000  # characters of a model that are shown
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
    """Return the report of a run: ``pictures`` are HTML elements by title, ``live`` is an embedded page,
    ``source`` the path of the model file.
    """
    summary = run_summary(result)
    about = summary["model"]
    cautions = [*summary["warnings"], *summary["remarks"]]
    sections = (
        Section("Found", findings(summary)),
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


def findings(summary: dict[str, Any]) -> list[Part]:
    """Return the peaks with their ranges, effects of clearance, losses; equilibria of a static analysis."""
    if summary["run"].get("analysis") == "static":
        return equilibria(summary)
    shown = [(name, text) for topic, name, text in _topics(summary) if topic not in (*RELIABILITY, "Laws")]
    return [Facts(shown), *tables(summary), *paragraphs(footnotes(summary))]


def trust(summary: dict[str, Any]) -> list[Part]:
    """Step, companions, energy ledger, and depths of the first contacts."""
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
        [Table.numeric(("contact", "too deep", "deepest"), depths, "Depth at which contacts began")]
        if depths
        else []
    )
    return [
        Facts([(name, text) for topic, name, text in _topics(summary) if topic in RELIABILITY]),
        *onsets,
        *paragraphs(summary["run"]["notes"]),
    ]


def _topics(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return the facts, each with its topic: the last name before it."""
    lines, topic = [], ""
    for name, text in facts(summary):
        topic = name or topic
        lines.append((topic, name, text))
    return lines


def _figures(pictures: Mapping[str, str]) -> list[Part]:
    return [Figure(title, lambda picture=picture: picture) for title, picture in pictures.items()]  # type: ignore[misc]


def _frame(live: str) -> Part:
    """Return a page in the page, without access to it."""
    frame = (
        '<iframe title="the mechanism running" sandbox="allow-scripts allow-downloads"'
        f' srcdoc="{escape(live)}"></iframe>'
    )
    return Element(
        f'<div class="screen">{frame}</div><p class="paper">On a screen the mechanism runs here.</p>'
    )


def _inputs(result: View, source: str | None) -> list[Part]:
    """Return the parts of the mechanism, its model in SI units as it was run, and the file that it was read
    from.
    """
    mechanism = result.record.assembly.mechanism
    parts: list[Part] = [*mechanism_parts(mechanism)]
    try:
        model = dump(mechanism)
    except (TypeError, ValueError):
        return [*parts, Paragraph("No model file can hold this mechanism.")]
    return [*parts, _model("In SI units, as it was run", model), *model_file(model, source)]


def model_file(model: str, source: str | None) -> list[Part]:
    """Return the current model file, and whether it gives the ``model`` that was run."""
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
    """Return a model file, the end of a long one left out."""
    rest = f"\n… and {len(text) - MODEL_LENGTH:,} signs more" if len(text) > MODEL_LENGTH else ""
    note = f"<p>{escape(words)}</p>" if words else ""
    return Element(
        f'<h3>{escape(title)}</h3>{note}<pre class="model">{escape(text[:MODEL_LENGTH] + rest)}</pre>'
    )


def _derived(summary: dict[str, Any]) -> list[Part]:
    """Return the parameters derived by laws from radii and materials: formulas, numbers with units,
    sources.
    """
    rows = [
        (
            joint,
            f"{kind}: {law['law']}",
            law["formula"],
            quantities(law["derived"], law.get("units", {})),
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
    """Return the report of a study: ``pictures`` and ``live`` as of a run, ``places`` are positions of
    sliders of the live page by member.
    """
    failed = [(one.number, where(study, one), reason) for one, reason in study.failed[:MOST_ROWS]]
    source = study.request.get("source")
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
            [*read, _model("The model, in SI units, before anything is varied", study.request["text"])],
        ),
    )
    return page(
        Document(sections, f"{study.model}: {study.name}"),
        (_study_words(study), study.request.get("note", "")),
        SCRIPT,
    )


def _study_words(study: Study) -> str:
    """Numbers of cases and of turns."""
    plan = study.request["wanted"]
    over = "the last turn" if plan["last"] == 1 else f"the last {plan['last']} turns, of which means are told"
    turns = f"Each makes {plan['turns']:,} turns{settling_words(study)}; measures are of {over}."
    return f"{len(study.members):,} members: {counts_words(study)}. {turns}"


def _running(
    study: Study, live: str, places: Mapping[int, Mapping[str, int]], notes: Sequence[str]
) -> list[Part]:
    """Return the page in which a member runs."""
    first = study.done[0]
    picked = escape(f"{first.number}: {where(study, first)}")
    line = Element(f'<p class="screen">Member <span id="picked">{picked}</span>; pick another one below.</p>')
    steps = (
        "All run here with as many steps a turn as the finest of them, so numbers may differ from the study's"
        " as far as they depend on the step."
    )
    left = len(study.done) - len(places)
    rest = [f"{left:,} members run by themselves only, with vfife live."] if left > 0 else []
    return [line, _frame(live), *paragraphs([steps, *rest, *(f"{note}." for note in notes)])]


def _members(study: Study, places: Mapping[int, Mapping[str, int]]) -> list[Part]:
    """Return every case with its measures, and a button that runs it."""
    cases = {one.number: one for one in study.members}
    button = (
        (lambda number: _button(places, number, f"{number}: {where(study, cases[number])}"))
        if places
        else None
    )
    rest = len(study.members) - MOST_ROWS
    left_out = (
        [Paragraph(f"{rest:,} more are in the file; vfife study export writes all of them.")]
        if rest > 0
        else []
    )
    return [member_table(study, "ended", MOST_ROWS, button), *left_out]


def _button(places: Mapping[int, Mapping[str, int]], number: int, words: str) -> Element:
    """Return a button that runs a member in the page; nothing for a member that the page cannot run."""
    if number not in places:
        return Element("")
    at = escape(json.dumps(places[number]))
    return Element(f'<button data-positions="{at}" data-said="{escape(words)}" class="screen">run</button>')
