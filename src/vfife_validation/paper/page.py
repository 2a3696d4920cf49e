"""One page for all items: self-contained HTML, pictures embedded, written anew after each item so that an
interrupted run keeps what is done.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template

from vfife.files import replacement, write_text
from vfife.report.document import Element
from vfife.report.html import table

from .contents import Chart, Item

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
body { font: 16px/1.5 system-ui,
sans-serif; color: #222; background: #fff; margin: 0 auto; max-width: 76rem; padding: 1.5rem; }
h1 { font-size: 1.7rem; margin-bottom: .3rem; }
h2 { font-size: 1.3rem; margin-top: 3rem; border-top: 1px solid #ccc; padding-top: 1rem; }
nav a { display: inline-block; margin: 0 .9rem .3rem 0; } a { color: #0072b2; }
p { max-width: 52rem; } figure { margin: 1.2rem 0; } img { max-width: 100%; height: auto; }
figcaption { color: #555; font-size: .92rem; }
.wide { overflow-x: auto; } table { border-collapse: collapse; margin: .8rem 0; font-size: .9rem; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; } td { font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .2rem .8rem .2rem 0; border-bottom: 1px solid #e3e3e3;
vertical-align: top; }
.true { color: #007a55; font-weight: 600; } .false { color: #b84500; font-weight: 600; }
.open { color: #666; font-weight: 600; }
.stated { color: #007a55; } .inferred { color: #b84500; } .chosen { color: #666; }
@media print { h2 { break-before: page; } nav { display: none; } }
</style>
</head>
<body>
<h1>$title</h1>
<p>$introduction</p>
<nav aria-label="items">$links</nav>
$body
<footer><p>$footer</p></footer>
</body>
</html>
""")
MARKED = ("true", "false", "open", "stated", "inferred", "chosen")
TITLE = "The paper, recomputed"
INTRODUCTION = (
    "This page recomputes every figure and table of numbers in <em>Vector form intrinsic finite element"
    " method for planar multibody systems with multiple clearance joints</em>. The available text lacks the"
    " pictures and Tables 2 and 4, so the comparison uses its statements. Parameters are <span"
    " class='stated'>stated</span> by the paper, <span class='inferred'>inferred</span> from it, or <span"
    " class='chosen'>chosen</span> where it determines nothing."
)


def page(
    items: Sequence[Item], pictures: Callable[[Chart], str], footer: str = "", title: str = TITLE,
    introduction: str = INTRODUCTION, absent: Mapping[str, str] | None = None,
) -> str:  # fmt: skip
    """Assemble the page; ``pictures`` returns the image source of a chart, ``absent`` the reason for each
    item that was not computed.
    """
    for name, reason in (absent or {}).items():
        introduction += f"</p>\n<p><strong>{escape(name)} is omitted:</strong> {escape(reason)}"
    links = "".join(f'<a href="#{item.name}">{escape(item.title.partition(":")[0])}</a>' for item in items)
    body = "\n".join(section(item, pictures, items[:k]) for k, item in enumerate(items))
    return PAGE.substitute(
        title=title, introduction=introduction, links=links, body=body, footer=escape(footer)
    )


def section(item: Item, pictures: Callable[[Chart], str], earlier: Sequence[Item] = ()) -> str:
    """Format an item: text, verdicts, pictures, tables, and parameters unless ``earlier`` items list them."""
    parts = [f'<section id="{item.name}">', f"<h2>{escape(item.title)}</h2>"]
    parts += [f"<p>{escape(paragraph)}</p>" for paragraph in item.text]
    if item.verdicts:
        rows = [(marked(v.word), v.statement, v.numbers) for v in item.verdicts]
        parts.append(table(rows, headings=("holds", "claim", "numbers")))
    for chart in item.charts:
        alternative = f"{item.title}. {chart.caption}"
        parts.append(
            f'<figure><img src="{pictures(chart)}"'
            f' alt="{escape(alternative)}"><figcaption>{escape(chart.caption)}.</figcaption></figure>'
        )
    parts += [
        table([[marked(cell) for cell in row] for row in sheet.rows], sheet.title, sheet.headings)
        for sheet in item.tables
    ]
    if item.parameters:
        parts.append(parameters(item, earlier))
    return "\n".join([*parts, "</section>"])


def parameters(item: Item, earlier: Sequence[Item]) -> str:
    """Format the parameters of an item: all, or the differences from the earlier item that shares most of
    them.
    """

    def shared(candidate: Item) -> int:
        return sum(p in candidate.parameters for p in item.parameters)

    base = max(earlier, key=shared, default=None)
    chosen, lead, title = list(item.parameters), "", "Parameters"
    if base is not None and shared(base) > len(chosen) // 2:
        omitted = {p.name for p in base.parameters} - {p.name for p in chosen}
        chosen = [p for p in chosen if p not in base.parameters]
        without = f" without {escape(', '.join(sorted(omitted)))}" if omitted else ""
        source = f'<a href="#{base.name}">{escape(base.title.partition(":")[0])}</a>'
        lead, title = f"<p>Parameters as for {source}{without}{', except:' if chosen else '.'}</p>", ""
    origins = [(p.name, p.value, marked(p.origin), p.where) for p in chosen]
    return lead + (table(origins, title, ("parameter", "value", "origin", "where")) if chosen else "")


def marked(text: str) -> Element | str:
    """Colour a verdict or an origin; other texts stay as they are."""
    return Element(f'<span class="{text}">{text}</span>') if text in MARKED else text


class Folder:
    """The folder of the page: index.html, the same pictures as files in figures/, all numbers in
    paper.json, or a JSON file of another name. The page names the ``absent`` items with the reasons.
    """

    def __init__(
        self, path: Path, footer: str, title: str = TITLE, introduction: str = INTRODUCTION,
        numbers: str = "paper.json", absent: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        self.path, self.footer, self.items = path, footer, list[Item]()
        self.title, self.introduction, self.numbers = title, introduction, numbers
        self.absent = dict(absent or {})
        self.sources: dict[str, str] = {}
        path.mkdir(parents=True, exist_ok=True)
        (path / "figures").mkdir(exist_ok=True)

    @property
    def index(self) -> Path:
        """The page."""
        return self.path / "index.html"

    def add(self, item: Item, as_text: Callable[[object], str]) -> None:
        """Draws an item and writes the page with all items so far; ``as_text`` turns their data into JSON."""
        from .charts import embedded, picture

        for chart in item.charts:
            data = picture(chart)
            with replacement(self.path / "figures" / f"{chart.name}.png") as temporary:
                temporary.write_bytes(data)
            self.sources[chart.name] = embedded(data)
        self.items.append(item)
        pictures = self.sources.__getitem__
        text = page(
            self.items, lambda chart: pictures(chart.name), self.footer, self.title, self.introduction,
            self.absent,
        )  # fmt: skip
        write_text(self.index, text)
        numbers = {item.name: item.data for item in self.items}
        write_text(self.path / self.numbers, as_text(numbers) + "\n")
