"""The report of a run as one page, to be read on a screen and printed: every text in it is text, whatever it says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from html import escape
from io import StringIO
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from .. import __version__
from ..errors import VfifeError
from ..files import read_bytes
from ..modelfile import dump, load
from .checked import parts
from .statics import print_static
from .summary import report
from .tables import SHARED, facts, found_tables
from .wear import CONFORMAL

if TYPE_CHECKING:
    from ..results.view import View

PAGE = Template(Path(__file__).with_name("document.html").read_text("utf-8"))
TRUSTED = ("Step", "Run", "Turns", "Trust", "Energy")  # facts that say how far numbers hold
LONGEST = 60_000  # signs of a model that are shown


def document(result: View, pictures: Mapping[str, str], live: str | None, source: str | None) -> str:
    """The report: ``pictures`` are elements by their titles, ``live`` is a page that is shown in it, ``source`` where the model was read."""
    told = report(result)
    sections = {
        "Found": found(result, told), "Cautions": cautions(told), "Trust": trust(told), "Figures": figures(pictures),
        "The mechanism running": "" if live is None else frame(live), "Inputs": inputs(result, source), "Derived parameters": derived(told),
    }  # fmt: skip
    present = {title: body for title, body in sections.items() if body}
    links = "".join(f'<a href="#{place(title)}">{title}</a>' for title in present)
    body = "\n".join(f'<section id="{place(title)}"><h2>{title}</h2>\n{text}\n</section>' for title, text in present.items())
    about = told["model"]
    said = "".join(
        f"<p>{escape(text)}</p>" for text in (about["note"], f"Read from {Path(about['source']).name}." if about["source"] else "") if text
    )
    return PAGE.substitute(title=escape(about["name"]), said=said, links=links, body=body, version=escape(__version__))


def place(title: str) -> str:
    """A title as the name of a place in the page."""
    return title.lower().replace(" ", "-")


def found(result: View, told: dict[str, Any]) -> str:
    """Peaks with their ranges, what play costs, losses; of a static analysis its equilibria."""
    if result.record.static:
        console = Console(file=StringIO(), width=110, color_system=None, force_terminal=False)
        print_static(console, told)
        return f"<pre>{escape(console.file.getvalue())}</pre>"  # type: ignore[attr-defined]
    lines = of_facts(told, lambda name: name not in (*TRUSTED, "Laws"))
    tables = "".join(html(rows(table), title, heads(table)) for title, table in found_tables(told))
    notes = [CONFORMAL] * bool(told["conformal"]) + [SHARED] * bool(told["not_unique"])
    return html(lines, "", ()) + tables + sentences(notes)


def cautions(told: dict[str, Any]) -> str:
    """Warnings, each with what to do, and remarks."""
    said = [*told["warnings"], *told["remarks"]]
    return f"<ul>{''.join(f'<li>{escape(one)}</li>' for one in said)}</ul>" if said else "<p>None.</p>"


def trust(told: dict[str, Any]) -> str:
    """Step, companions, the energy ledger, how deep first contacts landed."""
    if "factors" in told["run"]:
        return ""
    lines = of_facts(told, lambda name: name in TRUSTED)
    depths = [
        (name, f"{one.get('deep_landings', 0.0):.0f} of {one.get('impacts', 0.0):.0f}", f"{1e6 * one.get('landing_depth.max', 0.0):.4g} µm")
        for name, one in told["contacts"].items()
    ]
    onsets = html(depths, "Depth at which contacts began", ("contact", "too deep", "deepest")) if depths else ""
    return html(lines, "", ()) + onsets + sentences(told["run"]["notes"])


def of_facts(told: dict[str, Any], wanted: Callable[[str], bool]) -> list[tuple[str, ...]]:
    """Names and sentences of the facts that are wanted; a line without a name belongs to the one before."""
    lines, last = [], ""
    for line in rows(facts(told)):
        last = line[0] or last
        lines += [line] if wanted(last) else []
    return lines


def figures(pictures: Mapping[str, str]) -> str:
    """Figures with their titles."""
    return "".join(f"<figure>{picture}<figcaption>{escape(title)}</figcaption></figure>" for title, picture in pictures.items())


def frame(live: str) -> str:
    """A page in the page, without access to it."""
    opened = f'<iframe title="the mechanism running" sandbox="allow-scripts allow-downloads" srcdoc="{escape(live)}"></iframe>'
    return f'<div class="screen">{opened}</div><p class="paper">On a screen the mechanism runs here.</p>'


def inputs(result: View, source: str | None) -> str:
    """What the mechanism is made of, its model in SI units as it was run, and the file that it was read from."""
    mechanism = result.record.assembly.mechanism
    tables = "".join(html(lines[1:], title, lines[0]) for title, lines in parts(mechanism))
    try:
        kept = dump(mechanism)
    except (TypeError, ValueError):
        return tables + "<p>No model file can hold this mechanism.</p>"
    shown = f"<h3>In SI units, as it was run</h3>{model_text(kept)}"
    return tables + shown + as_given(kept, source)


def as_given(kept: str, source: str | None) -> str:
    """The model file as it reads now, and whether it gives what was run."""
    try:
        given = read_bytes(source).decode("utf-8") if source else ""
        same = bool(given) and dump(load(Path(source or ""))) == kept
    except (OSError, VfifeError, ValueError):
        given = ""
    if not given:
        return "<p>The file that it was read from is not there any more, or cannot be read.</p>" if source else ""
    differs = "It gives the numbers above." if same else "It gives other numbers than those above: options were added, or it was changed since."
    return f"<h3>As given</h3><p>{escape(Path(source or '').name)} as it reads now. {differs}</p>{model_text(given)}"


def model_text(text: str) -> str:
    """A model file, the end of a long one left out."""
    rest = f"\n… and {len(text) - LONGEST:,} signs more" if len(text) > LONGEST else ""
    return f'<pre class="model">{escape(text[:LONGEST] + rest)}</pre>'


def derived(told: dict[str, Any]) -> str:
    """What laws make of radii and materials: formulas, numbers with units, sources."""
    lines = []
    for joint, laws in told["laws"].items():
        for kind, law in laws.items():
            units = law.get("units", {})
            numbers = ", ".join(
                f"{name} {value} {'' if units.get(name, '1') == '1' else units[name]}".rstrip() for name, value in law["derived"].items()
            )
            lines.append((joint, f"{kind}: {law['law']}", law["formula"], numbers, law["source"]))
    return html(lines, "", ("joint", "law", "formula", "parameters", "source")) if lines else ""


def rows(table: Table) -> list[tuple[str, ...]]:
    """The cells of a table as texts."""
    columns = [[cell.plain if hasattr(cell, "plain") else str(cell) for cell in column.cells] for column in table.columns]
    return list(zip(*columns, strict=True))


def heads(table: Table) -> tuple[str, ...]:
    """Its headings."""
    return tuple(str(column.header) for column in table.columns)


def html(lines: Iterable[Iterable[str]], title: str, above: Iterable[str]) -> str:
    """A table with its title and headings."""
    head = "".join(f"<th>{escape(one)}</th>" for one in above)
    body = "".join("<tr>" + "".join(f"<td>{escape(one)}</td>" for one in line) + "</tr>" for line in lines)
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    return f'<div class="wide"><table>{caption}{f"<thead><tr>{head}</tr></thead>" if head else ""}<tbody>{body}</tbody></table></div>'


def sentences(said: Iterable[str]) -> str:
    """A paragraph each."""
    return "".join(f"<p>{escape(one)}</p>" for one in said)
