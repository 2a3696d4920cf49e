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
