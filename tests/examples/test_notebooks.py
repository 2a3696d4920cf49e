"""Every notebook is stored without output, and its cells display what a page can show. `make docs` runs all
of them, and fails where a cell does.
"""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType

import pytest

from vfife.plots.style import NotebookFigure

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


@pytest.fixture
def notebooks(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The module that executes notebooks for the pages."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "extensions"))
    return importlib.import_module("notebooks")


def test_there_are_four() -> None:
    assert len(NOTEBOOKS) == 4


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_output_and_draws(path: Path) -> None:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in notebook["cells"]}) == len(notebook["cells"])
    assert not any(cell.get("outputs") for cell in notebook["cells"])
    code = [cell["source"] for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert any(".plot(" in source[-1] for source in code)


def test_a_cell_displays_the_value_of_its_last_line_in_its_richest_form(notebooks: ModuleType) -> None:
    class Table:
        def _repr_html_(self) -> str:
            return "<table></table>"

    names = {"Table": Table}
    assert notebooks.run_cell("a = 3\na + 1", names, "<cell>") == 4 and names["a"] == 3
    assert notebooks.run_cell("a = 3", names, "<cell>") is None
    assert notebooks.representation(notebooks.run_cell("Table()", names, "<cell>")) == "<table></table>"
    assert notebooks.representation("text") == "'text'"
    picture = notebooks.representation(NotebookFigure())
    assert isinstance(picture, bytes) and picture.startswith(b"\x89PNG")


@pytest.mark.parametrize("value", [object(), "x" * 3_000_000], ids=["a bare object", "too long"])
def test_a_cell_that_displays_nothing_for_a_reader_fails(notebooks: ModuleType, value: object) -> None:
    with pytest.raises(ValueError, match="a notebook displays"):
        notebooks.representation(value)
