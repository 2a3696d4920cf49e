"""Pages of PDF reports: a heading stands above the figure that it announces."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from vfife.plots import pdf
from vfife.plots.layout import width_of
from vfife.report import parts
from vfife.report.document import Document


@pytest.mark.parametrize("lines", range(40, 90, 10))
def test_a_heading_is_on_the_page_of_its_first_figure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lines: int
) -> None:
    pages: dict[str, int] = {}
    write, draw = pdf.Paper.text, pdf.Paper.figure

    def text(paper: pdf.Paper, words: str, *sizes: Any, **look: Any) -> None:
        write(paper, words, *sizes, **look)
        pages.setdefault(words, paper.count)

    def figure(paper: pdf.Paper, drawing: Figure, caption: str, scale: float) -> None:
        draw(paper, drawing, caption, scale)
        pages["drawn " + caption] = paper.count

    monkeypatch.setattr(pdf.Paper, "text", text)
    monkeypatch.setattr(pdf.Paper, "figure", figure)
    figures = {"tall": Figure(figsize=(6.0, 7.0)), "short": Figure(figsize=(6.0, 1.5))}
    sections = (
        parts.Section("First", [parts.Paragraph("words")]),
        parts.Section("Filler", [parts.Preformatted("x\n" * lines, "file")]),
        parts.Section("Figures", [parts.Figure(title, str) for title in figures]),
    )
    pdf.write_pdf(tmp_path / "r.pdf", Document(sections, "title"), (), figures)
    assert pages["Figures"] == pages["drawn tall"]


def test_a_word_wider_than_its_column_is_broken_behind_a_sign() -> None:
    """Every letter of a name is there; "small-end.approa..." would be any quantity."""
    paper = pdf.Paper(None, "")
    name = "small-end.approach_speed.max"
    lines = paper.cell(name, 1.0)
    assert len(lines) > 1 and "".join(lines) == name and "…" not in name
    assert all(line[-1] in "-._" for line in lines[:-1])
    assert all(width_of(paper.page, line, pdf.SMALL) <= 1.0 for line in lines)
    assert "".join(paper.cell("x" * 60, 0.8)) == "x" * 60


def test_headings_of_a_table_do_not_touch() -> None:
    """They are bold, and wider than the same words in the cells."""
    heads = ("joint", "knocks", "hardest knock", "in turns measured", "hardest there", "power of the knocks")
    long = "178.5 to 183.0 mm/s (not estimated)"
    paper = pdf.Paper(None, "")
    paper.rows([("small-end", "1,203", long, "604", long, long)], range(1, 6), heads)
    renderer: Any = paper.page.canvas.get_renderer()  # type: ignore[attr-defined]
    bold = [text for text in paper.page.texts if text.get_weight() == "bold"]
    assert {word for text in bold for word in text.get_text().split()} == set(" ".join(heads).split())
    boxes = [text.get_window_extent(renderer) for text in bold]
    for one in boxes:
        for other in boxes:
            if one is not other and abs(one.y0 - other.y0) < 1.0 and one.x0 <= other.x0:
                assert other.x0 - one.x1 > 0.5 * pdf.CELL * paper.page.dpi


def test_cautions_have_the_numbers_to_which_the_conclusion_refers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines: list[str] = []
    monkeypatch.setattr(pdf.Paper, "text", lambda paper, words, *sizes, **look: lines.append(words))
    bullets = [parts.Bullets(["first", "second"], ordered=True), parts.Bullets(["third"])]
    pdf.write_pdf(tmp_path / "r.pdf", Document((parts.Section("Cautions", bullets),), "title"), (), {})
    assert lines[-3:] == ["1. first", "2. second", "• third"]


def placed(paper: pdf.Paper) -> list[str]:
    """The lines on the page that is being written."""
    return [text.get_text() for text in paper.page.texts]


@pytest.mark.parametrize("unit", ["kN", "µm", "%", "N m", "mm/s", "rad/s²"])
def test_a_unit_stands_on_the_line_of_its_number(unit: str) -> None:
    paper = pdf.Paper(None, "")
    for room in (0.9, 1.1, 1.3):
        lines = paper.cell(f"big-end 17 {unit}, 0.9 to 1.2 {unit}", room)
        assert len(lines) > 1 and " ".join(lines) == f"big-end 17 {unit}, 0.9 to 1.2 {unit}"
        assert not any(line.startswith(unit.split()[0]) for line in lines), lines


def test_cells_that_fit_in_a_smaller_font_are_not_wrapped() -> None:
    paper = pdf.Paper(None, "")
    cells = ["36.8 to 42.5 mm/s"]
    paper.rows([cells], range(1), ("first",))
    assert paper.cell_size == pdf.SMALL
    while sum(paper.natural_widths([cells], ())) <= pdf.ROOM:
        cells.append("1 to 2 N")
    paper.rows([cells], range(len(cells)), ())
    assert paper.cell_size < pdf.SMALL
    assert placed(paper).count(cells[0]) == 2 and placed(paper).count(cells[1]) == len(cells) - 1


@pytest.mark.parametrize("used", [3.0, 8.0, 9.0])
def test_a_short_table_and_its_glossary_are_on_one_page(used: float) -> None:
    """A table that is longer than half a page is broken, as it must be, under its headings."""
    short = parts.Table(("joint", "change"), [(f"joint {k}", "12 %") for k in range(12)], "short table")
    glossary = parts.Facts([("change", "by how much clearance raises the force")])
    paper = pdf.Paper(None, "")
    paper.at = used
    pdf._section(paper, parts.Section("Section", [parts.Paragraph("words"), short, glossary]), {}, False)
    assert {"short table", "joint 0", "joint 11", "change"} <= set(placed(paper))
    assert paper.count == (1 if used < 5.0 else 2)
    long = parts.Table(("joint", "change"), [(f"joint {k}", "12 %") for k in range(40)], "long table")
    paper = pdf.Paper(None, "")
    paper.at = used
    pdf._section(paper, parts.Section("Section", [long]), {}, False)
    assert paper.count == 2 and "change" in placed(paper) and "long table" not in placed(paper)


def test_the_first_figure_leaves_room_for_the_first_table() -> None:
    """The glossary goes to the next page before the table is broken."""
    rows = [(f"joint {k}", "12 %") for k in range(14)]
    texts = [parts.Paragraph("words " * 150), parts.Table(("joint", "change"), rows)]
    glossary = parts.Facts([(f"term {k}", "what it means") for k in range(20)])
    figures = {"machine": Figure(figsize=(6.0, 5.0))}
    section = parts.Section("Conclusion", [parts.Figure("machine", str), *texts, glossary])
    paper = pdf.Paper(None, "")
    paper.tallest = pdf.tallest_first(paper, section, figures)
    assert pdf.SHORT_FIRST <= paper.tallest < pdf.TALL_FIRST
    whole = parts.Section("Conclusion", [parts.Figure("machine", str), *texts])
    pdf._section(paper, whole, figures, True)
    assert paper.count == 1 and "joint 13" in placed(paper)


@pytest.mark.parametrize("kind", ["file", "text", "table"])
def test_no_page_has_a_line_by_itself(kind: str) -> None:
    """A part that begins anywhere near the end of a page leaves four lines or more for the next one."""
    counts = []
    for begin in range(930, 1090, 5):
        paper = pdf.Paper(None, "")
        paper.at = 0.01 * begin
        if kind == "file":
            paper.lines("line\n" * 9)
        elif kind == "text":
            paper.text("word " * 150)
        else:
            paper.rows([["cell"]] * 9, ())
        counts += [sum(text.get_text() != " · 2" for text in paper.page.texts)] * (paper.count > 1)
    assert len(counts) > 5 and min(counts) >= 4
