"""Model files in reports: long tables and lists are shown by their ends."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import vfife
from vfife.modelfile import dump
from vfife.report.excerpts import table_excerpt, with_short_lists
from vfife.report.pages import model_parts
from vfife.report.parts import Preformatted

GALLERY = Path(__file__).parents[2] / "examples"


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """The compressor with an indicator diagram of 361 lines in a CSV file."""
    text = (GALLERY / "compressor.toml").read_text("utf-8")
    begin = text.index('zero_travel = "123 mm"')
    path = tmp_path / "compressor.toml"
    path.write_text(text[:begin] + 'table = "cyl.csv"\n', "utf-8")
    rows = (f"{k}; {2.5 + 1.5 * math.cos(math.radians(k)):.4f}" for k in range(361))
    (tmp_path / "cyl.csv").write_text("\n".join(["angle [deg]; pressure [bar]", *rows]), "utf-8")
    return path


def test_a_report_has_the_ends_of_a_long_table_and_its_count(measured: Path) -> None:
    mechanism = vfife.load(measured)
    source = measured.read_text("utf-8")
    parts = [part for part in model_parts(mechanism, str(measured)) if isinstance(part, Preformatted)]
    model, table = parts
    assert model.text == source
    lines = table.text.splitlines()
    assert len(lines) < 20 and lines[0] == "angle [deg]; pressure [bar]"
    assert lines[-1] == "360; 4.0000" and "… 346 lines more …" in lines
    assert table.words == "362 lines, of which 16 are shown."
    [only] = [part for part in model_parts(mechanism, None) if isinstance(part, Preformatted)]
    assert "… 353 more …" in only.text and len(only.text) < 0.5 * len(dump(mechanism))


def test_short_tables_and_lists_are_whole() -> None:
    short = "\n".join(f"{k}, {k}" for k in range(40))
    assert table_excerpt(short) == (short, "")
    text = f"a = {list(range(24))}\nat = [0.1, 0.2]\nnames = ['x', 'y']"
    assert with_short_lists(text) == text
