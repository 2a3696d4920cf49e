"""The report of a study as one page: what its members came to, figures, every member, and one of them running, picked by the reader."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from .. import __version__
from .document import PAGE, figures, frame, html, model_text, place, sentences
from .study import errors, extremes, placed, quantity, said_of, where

if TYPE_CHECKING:
    from ..results.studied import Study

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


def document(
    study: Study,
    pictures: Mapping[str, str],
    live: str | None = None,
    places: Mapping[int, Mapping[str, int]] | None = None,
    notes: Sequence[str] = (),
) -> str:
    """The report: ``pictures`` are elements by their titles, ``live`` a page shown in it, ``places`` positions of its sliders by member."""
    known = places or {}
    sections = {
        "Found": found(study), "Failed": failed(study), "Figures": figures(pictures),
        "A member running": "" if live is None else running(study, live, known, notes), "Members": members(study, known if live else {}),
        "Inputs": inputs(study),
    }  # fmt: skip
    present = {title: body for title, body in sections.items() if body}
    links = "".join(f'<a href="#{place(title)}">{title}</a>' for title in present)
    body = "\n".join(f'<section id="{place(title)}"><h2>{title}</h2>\n{text}\n</section>' for title, text in present.items())
    said = "".join(f"<p>{escape(text)}</p>" for text in (summary(study), study.asked.get("note", "")) if text)
    return PAGE.substitute(title=escape(f"{study.model}: {study.name}"), said=said, links=links, body=body + SCRIPT, version=escape(__version__))


def summary(study: Study) -> str:
    """How many members ended, over how many turns."""
    wanted, counts = study.asked["wanted"], ", ".join(f"{count:,} {word}" for word, count in study.counts.items() if count)
    until = "" if wanted["settle"] is None else f" at most, until they repeat within {100.0 * wanted['settle']:g} %"
    over = "the last turn" if wanted["last"] == 1 else f"the last {wanted['last']} turns, of which means are told"
    return f"{len(study.members):,} members: {counts}. Each makes {wanted['turns']:,} turns{until}; measures are of {over}."


def found(study: Study) -> str:
    """What is varied, and the extremes of each measure."""
    varied = [
        (one.name, said_of([study.at(member)[k] for member in study.members], one.unit, one.kind, one.words), ", ".join(one.paths))
        for k, one in enumerate(study.parameters)
    ]
    lines = []
    for name, one in extremes(study).items():
        cells = [quantity(one[key], one["unit"]) for key in ("least", "mean", "largest")]
        lines.append((name, cells[0], placed(study, one["least_at"]), cells[1], cells[2], placed(study, one["largest_at"])))
    heads = ("measure", "least", "at", "mean", "largest", "at")
    return html(varied, "What is varied", ("name", "values", "numbers of the model")) + (
        html(lines, "What it came to", heads)
        + html(errors(study), "Numerical error of a member", ("measure", "typically", "at most", "estimated from"))
    )


def failed(study: Study) -> str:
    """Members that gave no measures, or not all of them, with their reasons."""
    lines = [(str(one.number), where(study, one), reason) for one, reason in study.failed[:MOST_ROWS]]
    return html(lines, "", ("member", "at", "reason")) if lines else ""


def running(study: Study, live: str, places: Mapping[int, Mapping[str, int]], notes: Sequence[str]) -> str:
    """The page in which a member runs."""
    first = study.done[0]
    said = f'<p class="screen">Member <span id="picked">{escape(f"{first.number}: {where(study, first)}")}</span>; pick another one below.</p>'
    steps = (
        "All run here with as many steps a turn as the finest of them, so numbers may differ from the study's as far as they depend on the step."
    )
    left = len(study.done) - len(places)
    more = [f"{left:,} members run by themselves only, with vfife live."] if left > 0 else []
    return said + frame(live) + sentences([steps, *more, *(f"{note}." for note in notes)])


def members(study: Study, places: Mapping[int, Mapping[str, int]]) -> str:
    """Every member with what it came to, and what picks it."""
    names, measures = [one.name for one in study.parameters], list(study.measures)
    units = {**{one.name: one.unit for one in study.parameters}, **study.measures}
    heads = "".join(f"<th>{escape(name)}</th>" for name in ("member", *names, *measures, "ended", *(("",) if places else ())))
    lines, known = [], {one.number: one for one in study.members}
    for row in study.rows()[:MOST_ROWS]:
        number = int(row["member"])
        cells = [str(number), *(quantity(row[name], units[name]) for name in (*names, *measures)), str(row["status"])]
        line = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        if places:
            at = escape(json.dumps(places.get(number)), quote=True)
            said = escape(f"{number}: {where(study, known[number])}", quote=True)
            line += f'<td class="screen"><button data-positions="{at}" data-said="{said}">run</button></td>' if number in places else "<td></td>"
        lines.append(f"<tr>{line}</tr>")
    rest = len(study.members) - len(lines)
    more = sentences([f"{rest:,} more are in the file; vfife study export writes all of them."]) if rest > 0 else ""
    return f'<div class="wide"><table><thead><tr>{heads}</tr></thead><tbody>{"".join(lines)}</tbody></table></div>{more}'


def inputs(study: Study) -> str:
    """The model in SI units, without what is varied."""
    source = study.asked.get("source")
    read = f"<p>Read from {escape(str(source))}.</p>" if source else ""
    return f"{read}<h3>The model, in SI units, before anything is varied</h3>{model_text(study.asked['text'])}"
