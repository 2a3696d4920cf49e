"""Every notebook runs from top to bottom, and displays figures and results without further commands."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType

import pytest
from matplotlib.figure import Figure

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
def test_a_notebook_is_stored_without_output(path: Path) -> None:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in notebook["cells"]}) == len(notebook["cells"])
    assert not any(cell.get("outputs") for cell in notebook["cells"])


@pytest.mark.system("runs the notebooks")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_displays_its_results(
    path: Path,
    notebooks: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    only_built_in_laws: None,
) -> None:
    monkeypatch.chdir(tmp_path)
    figures = 0
    for source, value in notebooks.displayed(path):
        if value is None or isinstance(value, float | int):
            continue
        shown = notebooks.representation(value)
        assert isinstance(shown, bytes) or len(shown) < 3_000_000, source
        plotted = isinstance(value, Figure) or ".plot(" in source.splitlines()[-1]
        if plotted:
            figures += 1
            assert shown.startswith(b"\x89PNG") if isinstance(shown, bytes) else "data:image/" in shown, (
                source
            )
        elif not isinstance(shown, bytes):
            assert " object at 0x" not in shown, source
    assert figures >= 1
