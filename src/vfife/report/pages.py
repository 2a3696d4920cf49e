"""The report of a run, and that of a study, as a page to be read on a screen and printed."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import VfifeError
from ..files import read_bytes
from ..modelfile import dump, load
from ..modelfile.csvtables import CURVES
from ..modelfile.parameter import Parameter
from ..modelfile.tables import CSV
from ..units import in_rpm
from .amounts import prefixed
from .case_errors import error_table, study_cautions, turn_words
from .check import mechanism_parts
from .document import (
    Bullets,
    Document,
    Element,
    Facts,
    Figure,
    Paragraph,
    Part,
    Preformatted,
    Section,
    Table,
    grouped,
    paragraphs,
    quantities,
)
from .excerpts import rounded, table_excerpt, with_short_lists
from .front import Front, explained, front_page, without_options
from .html import page
from .overview import cautions, certainty
from .run import equilibria, facts, facts_of, footnotes
from .run_tables import depths_of_onsets, tables
from .study import case_table, case_words, counts_words, extreme_table, parameter_table
from .summary import run_summary
from .trust import verdict

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..results.run_data import RunData
    from ..results.study import Study

RELIABILITY = ("Step", "Run", "Turns", "Trust", "Energy")  # facts on how reliable the numbers are
MODEL_LENGTH = 60_000  # characters of a model that are shown
METHOD = (
    "The motion is computed in time steps with explicit central differences{contact}. The same run with other"
    " time steps shows how certain the numbers are."
)
CONTACT = (
    "; a joint with clearance is a journal in a bearing, with a contact and a friction law where they touch"
)
STATIC_METHOD = (
    "Each equilibrium is found by dynamic relaxation: a damped motion that comes to rest under its loads. The"
    " same analysis with other numbers of elements shows how certain the numbers are."
)
# Where a verdict leads the report, which stands in it once.
NO_OTHER = "None besides the first sentence of this report on how far its numbers can be trusted."
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


def run_page(
    result: RunData,
    pictures: Mapping[str, str],
    live: str | None,
    source: str | None,
    front: Front | None = None,
) -> str:
    """Return the report of a run: ``pictures`` are elements by their titles, the first of them stands on
    the first page; ``live`` is an embedded page, ``source`` the path of the model file.
    """
    front = front or Front()
    document, introduction = run_document(result, _figures(pictures), live, source)
    return page(document, (front.line, *introduction), head=front.element().html)


def run_document(
    result: RunData, figures: Sequence[Part], live: str | None, source: str | None
) -> tuple[Document, tuple[str, ...]]:
    """Return the report of a run as a document, and sentences below its title; see :func:`run_page`."""
    summary = run_summary(result)
    model = summary["model"]
    leading = "" if summary["run"].get("analysis") == "static" else verdict(summary)
    warnings = [text for text in summary["warnings"] if not leading or text != leading]
    texts = [*cautions_of_run(summary), *warnings, *summary["remarks"]]
    texts = list(dict.fromkeys(map(without_options, texts)))
    sections = (
        front_page(summary, figures[0] if figures else None),
        Section(
            "Cautions",
            [Bullets(texts, ordered=True) if texts else Paragraph(NO_OTHER if leading else "None.")],
        ),
        Section(
            "Method and trust",
            [
                Paragraph(_method(summary)),
                *paragraphs([leading] if leading and leading != certainty(summary) else []),
                *trust(summary),
            ],
        ),
        Section("Results in numbers", findings(summary)),
        Section("Figures", figures[1:]),
        Section("The mechanism running", [] if live is None else [_frame(live)]),
        Section("Derived parameters", _derived(summary)),
        Section("Appendix: the model", model_parts(result.record.assembly.mechanism, source)),
    )
    introduction = model["note"], f"Read from {Path(model['source']).name}." if model["source"] else ""
    return Document(explained(sections), model["name"]), introduction


def _method(summary: dict[str, Any]) -> str:
    """Return how the numbers of a run were computed, as far as it concerns this model."""
    if summary["run"].get("analysis") == "static":
        return STATIC_METHOD
    return METHOD.format(contact=CONTACT if summary["contacts"] else "")


def cautions_of_run(summary: dict[str, Any]) -> list[str]:
    """Return all cautions that the answer of a run shows; of a static analysis those about the model."""
    static = summary["run"].get("analysis") == "static"
    return list(summary["run"]["notes"] if static else cautions(summary))


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
    onsets = depths_of_onsets(summary)
    return [
        Facts(
            [(name, without_options(text)) for topic, name, text in _topics(summary) if topic in RELIABILITY]
        ),
        *[onsets] * bool(onsets.rows),
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


def model_parts(mechanism: Mechanism, source: str | None) -> list[Part]:
    """Return the parts of a mechanism, and its model as it was written."""
    parts: list[Part] = [*mechanism_parts(mechanism)]
    try:
        model = dump(mechanism)
    except (TypeError, ValueError):
        return [*parts, Paragraph("This mechanism cannot be written as a model file.")]
    return [*parts, *(model_file(model, source) or [rounded_model(model)])]


# The first line by which an editor finds the schema, in a folder of its user.
SCHEMA_LINE = re.compile(r"\A#:schema [^\n]*\n+")


def rounded_model(model: str) -> Part:
    """Format a model in SI units, with numbers rounded for reading."""
    words = (
        "Numbers are rounded to six digits; the run file contains all digits, and all numbers of long lists."
    )
    return _model("In SI units", with_short_lists(rounded(model)), words)


def model_file(model: str, source: str | None) -> list[Part]:
    """Return the model file as it was written, and what the ``model`` that was run has instead."""
    if source is None:
        return []
    name = Path(source).name
    try:
        text = SCHEMA_LINE.sub("", read_bytes(source).decode("utf-8"))
        written, tables = dump(load(Path(source))), csv_tables(text, Path(source).parent)
    except (OSError, VfifeError, ValueError):
        return [Paragraph(f"{name} is missing or cannot be read."), rounded_model(model)]
    if written == model:
        return [_model("As written", text, f"{name}. The run has these numbers."), *tables]
    changed = _model(
        "As it was run instead",
        "\n".join(_differences(model, written)),
        "Options changed these lines, or the file was changed since the run.",
    )
    return [_model("As written", text, f"{name} as it reads now."), changed, *tables]


def _differences(model: str, written: str) -> Iterator[str]:
    """Yield the values of a ``model`` that a model as ``written`` does not have, with their paths and, beside
    SI units, readable ones.
    """
    values, tables = set(_assignments(written)), tomllib.loads(model)
    for path, value in _assignments(model):
        if (path, value) not in values:
            size = _readable(tables, path, value)
            yield f"{path} = {with_short_lists(rounded(value))}{f'  ({size})' if size else ''}"


def _assignments(model: str) -> Iterator[tuple[str, str]]:
    """Yield path and value, as text, of each line of a model as :func:`~vfife.modelfile.dump` writes it."""
    table = ""
    for line in model.splitlines():
        key, equals, value = line.partition(" = ")
        if line.startswith("["):
            table = f"{line.strip('[]')}."
        elif equals:
            yield f"{table}{key}", value


def _readable(tables: dict[str, Any], path: str, value: str) -> str:
    """Return a number of a model in a unit for readers; "" of other values and of numbers without unit."""
    with suppress(ValueError):  # no number, or a part of a table that has none by itself
        number, unit = float(value), Parameter(tables, path).unit
        return "" if unit in ("", "1") else in_rpm(number) if unit == "rad/s" else prefixed(number, unit)
    return ""


def csv_tables(text: str, folder: Path) -> list[Preformatted]:
    """Return the CSV files in a ``folder`` that the ``text`` of a model names, as they read now, long ones by
    their ends.
    """
    names, levels = dict[str, None](), [tomllib.loads(text)]
    for level in levels:  # grows by the tables in the tables
        levels += [value for value in level.values() if isinstance(value, dict)]
        names |= {
            value: None for key, value in level.items() if key in (CSV, *CURVES) and isinstance(value, str)
        }
    tables = {name: read_bytes(folder / name).decode("utf-8-sig") for name in names}
    return [_model(f"Table {name}", *table_excerpt(table)) for name, table in tables.items()]


def _model(title: str, text: str, words: str = "") -> Preformatted:
    """Return a model file, the end of a long one left out."""
    remainder = f"\n… and {len(text) - MODEL_LENGTH:,} characters more" if len(text) > MODEL_LENGTH else ""
    return Preformatted(text[:MODEL_LENGTH] + remainder, title, words)


def _derived(summary: dict[str, Any]) -> list[Part]:
    """Return the parameters derived by laws from radii and materials: formulas, numbers with units,
    sources.
    """
    laws = [(joint, kind, law) for joint, laws in summary["laws"].items() for kind, law in laws.items()]
    alike = grouped(
        ((kind, law["law"], quantities(law["derived"], law.get("units", {}))), joint)
        for joint, kind, law in laws
    )
    rows = [(", ".join(names), *cells) for cells, names in alike.items()]
    sources = {law["law"]: (law["law"], law["formula"], law["source"]) for *_, law in laws}
    if not rows:
        return []
    return [
        Table(("joints", "kind", "law", "parameters"), rows),
        Table(("law", "formula", "source"), list(sources.values()), "Formulas and sources"),
        *paragraphs(facts_of(summary)),
    ]


NO_FRONT = Front()  # no author and no logo, the date of today


def study_page(
    study: Study,
    pictures: Mapping[str, str],
    live: str | None = None,
    places: Mapping[int, Mapping[str, int]] | None = None,
    notes: Sequence[str] = (),
    front: Front = NO_FRONT,
) -> str:
    """Return the report of a study: ``pictures`` and ``live`` as of a run, ``places`` are positions of
    sliders of the live page by case; ``front`` has author, date and logo.
    """
    running = () if live is None else _running(study, live, places or {}, notes)
    document, introduction = study_document(
        study, _figures(pictures), running, (places or {}) if live else {}
    )
    return page(document, (front.line, *introduction), SCRIPT, front.element().html)


def study_document(
    study: Study,
    figures: Sequence[Part],
    running: Sequence[Part] = (),
    places: Mapping[int, Mapping[str, int]] | None = None,
) -> tuple[Document, tuple[str, ...]]:
    """Return the report of a study as a document, and sentences below its title; see :func:`study_page`."""
    failed = [(case.number, case_words(study, case), reason) for case, reason in study.failed[:MOST_ROWS]]
    source = study.request.get("source")
    read = [Paragraph(f"Read from {source}.")] if source else []
    sections = (
        Section(
            "Results",
            [
                parameter_table(study, "Parameters"),
                extreme_table(study, "Least, mean and largest values"),
                error_table(study),
                *study_cautions(study),
            ],
        ),
        Section("Failed", [Table(("case", "at", "reason"), failed)] if failed else []),
        Section("Figures", figures),
        Section("A case running", running),
        Section("Cases", _cases(study, places or {})),
        Section("Inputs", [*read, rounded_model(study.request["text"])]),
    )
    introduction = _study_words(study), study.request.get("note", "")
    return Document(sections, f"{study.model}: {study.name}"), introduction


def _study_words(study: Study) -> str:
    """Numbers of cases and of turns."""
    plan = study.request["wanted"]
    turns = f"Each makes {plan['turns']:,} turns{turn_words(study)}."
    return f"{len(study.cases):,} cases: {counts_words(study)}. {turns}"


def _running(
    study: Study, live: str, places: Mapping[int, Mapping[str, int]], notes: Sequence[str]
) -> list[Part]:
    """Return the page in which a case runs."""
    first = study.done[0]
    picked = escape(f"{first.number}: {case_words(study, first)}")
    line = Element(f'<p class="screen">Case <span id="picked">{picked}</span>; choose another one below.</p>')
    steps = (
        "All cases run here with the number of steps per turn of the finest case, so numbers that depend on"
        " the step may differ from those of the study."
    )
    left = len(study.done) - len(places)
    left_out = [f"{left:,} cases cannot run on this page; run them with vfife live."] if left > 0 else []
    return [line, _frame(live), *paragraphs([steps, *left_out, *(f"{note}." for note in notes)])]


def _cases(study: Study, places: Mapping[int, Mapping[str, int]]) -> list[Part]:
    """Return every case with its measures, and a button that runs it."""
    cases = {case.number: case for case in study.cases}
    button = (
        (lambda number: _button(places, number, f"{number}: {case_words(study, cases[number])}"))
        if places
        else None
    )
    remaining = len(study.cases) - MOST_ROWS
    left_out = (
        [Paragraph(f"{remaining:,} more are in the file; vfife study export writes all of them.")]
        if remaining > 0
        else []
    )
    return [case_table(study, "ended", MOST_ROWS, button), *left_out]


def _button(places: Mapping[int, Mapping[str, int]], number: int, words: str) -> Element:
    """Return a button that runs a case in the page; nothing for a case that the page cannot run."""
    if number not in places:
        return Element("")
    at = escape(json.dumps(places[number]))
    return Element(f'<button data-positions="{at}" data-said="{escape(words)}" class="screen">run</button>')
