"""One page for all items: self-contained HTML, pictures embedded, written anew after each item so that an interrupted run keeps what is done."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from string import Template

from vfife.files import replacement, write_text
from vfife.report.contents import Chart, Item, Parameter, Table, Verdict

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; margin: 0 auto; max-width: 76rem; padding: 1.5rem; }
h1 { font-size: 1.7rem; margin-bottom: .3rem; } h2 { font-size: 1.3rem; margin-top: 3rem; border-top: 1px solid #ccc; padding-top: 1rem; }
nav a { display: inline-block; margin: 0 .9rem .3rem 0; } a { color: #0072b2; }
p { max-width: 52rem; } figure { margin: 1.2rem 0; } img { max-width: 100%; height: auto; } figcaption { color: #555; font-size: .92rem; }
.wide { overflow-x: auto; } table { border-collapse: collapse; margin: .8rem 0; font-size: .9rem; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; } td { font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .2rem .8rem .2rem 0; border-bottom: 1px solid #e3e3e3; vertical-align: top; }
.true { color: #007a55; font-weight: 600; } .false { color: #b84500; font-weight: 600; } .open { color: #666; font-weight: 600; }
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
TITLE = "The paper beside our numbers"
INTRODUCTION = (
    "Every figure and table of numbers in <em>Vector form intrinsic finite element method for planar multibody systems with multiple "
    "clearance joints</em>, computed anew by vfife. The text that this is checked against has neither the paper's pictures nor its Tables 2 and 4: "
    "what is compared is what it says. Parameters are <span class='stated'>stated</span> by the paper, <span class='inferred'>inferred</span> "
    "from it, or <span class='chosen'>chosen</span> because nothing in it decides them."
)


def page(items: Sequence[Item], pictures: Callable[[Chart], str], footer: str = "") -> str:
    """The page; ``pictures`` gives the source of an image for a chart."""
    links = "".join(f'<a href="#{item.name}">{escape(item.title.partition(":")[0])}</a>' for item in items)
    body = "\n".join(section(item, pictures) for item in items)
    return PAGE.substitute(title=TITLE, introduction=INTRODUCTION, links=links, body=body, footer=escape(footer))


def section(item: Item, pictures: Callable[[Chart], str]) -> str:
    """An item: text, verdicts, pictures, tables, parameters."""
    parts = [f'<section id="{item.name}">', f"<h2>{escape(item.title)}</h2>"]
    parts += [f"<p>{escape(paragraph)}</p>" for paragraph in item.text]
    parts += [verdict_table(item.verdicts)] if item.verdicts else []
    for chart in item.charts:
        alternative = f"{item.title}. {chart.caption}"
        parts.append(f'<figure><img src="{pictures(chart)}" alt="{escape(alternative)}"><figcaption>{escape(chart.caption)}.</figcaption></figure>')
    parts += [html_table(table) for table in item.tables]
    parts += [parameter_table(item.parameters)] if item.parameters else []
    return "\n".join([*parts, "</section>"])


def verdict_table(verdicts: Sequence[Verdict]) -> str:
    """Claims with true or false and their numbers."""
    rows = "".join(f'<tr><td class="{v.word}">{v.word}</td><td>{escape(v.statement)}</td><td>{escape(v.numbers)}</td></tr>' for v in verdicts)
    return f'<div class="wide"><table><thead><tr><th>holds</th><th>claim</th><th>numbers</th></tr></thead><tbody>{rows}</tbody></table></div>'


def parameter_table(parameters: Sequence[Parameter]) -> str:
    """Parameters and where each comes from."""
    rows = "".join(
        f'<tr><td>{escape(p.name)}</td><td>{escape(p.value)}</td><td class="{p.origin}">{p.origin}</td><td>{escape(p.where)}</td></tr>'
        for p in parameters
    )
    head = "<thead><tr><th>parameter</th><th>value</th><th>origin</th><th>where</th></tr></thead>"
    return f'<div class="wide"><table><caption>Parameters</caption>{head}<tbody>{rows}</tbody></table></div>'


def html_table(table: Table) -> str:
    """A table; a cell that is true, false or open is coloured as a verdict."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in table.headings)
    rows = "".join("<tr>" + "".join(_cell(cell) for cell in row) + "</tr>" for row in table.rows)
    caption = f"<caption>{escape(table.caption)}</caption>"
    return f'<div class="wide"><table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def _cell(text: str) -> str:
    marked = f' class="{text}"' if text in ("true", "false", "open") else ""
    return f"<td{marked}>{escape(text)}</td>"


class Folder:
    """The folder of the page: index.html, the same pictures as files in figures/, all numbers in paper.json."""

    def __init__(self, path: Path, footer: str) -> None:
        self.path, self.footer, self.items = path, footer, list[Item]()
        self.sources: dict[str, str] = {}
        path.mkdir(parents=True, exist_ok=True)
        (path / "figures").mkdir(exist_ok=True)

    @property
    def index(self) -> Path:
        """The page."""
        return self.path / "index.html"

    def add(self, item: Item, as_text: Callable[[object], str]) -> None:
        """Draws an item and writes the page with all items so far; ``as_text`` turns their data into JSON."""
        from vfife.plots.charts import embedded, picture

        for chart in item.charts:
            data = picture(chart)
            with replacement(self.path / "figures" / f"{chart.name}.png") as temporary:
                temporary.write_bytes(data)
            self.sources[chart.name] = embedded(data)
        self.items.append(item)
        write_text(self.index, page(self.items, lambda chart: self.sources[chart.name], self.footer))
        numbers = {one.name: one.data for one in self.items}
        write_text(self.path / "paper.json", as_text(numbers) + "\n")
