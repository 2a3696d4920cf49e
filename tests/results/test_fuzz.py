"""Run files and cached code with anything done to them: what was written, or what is missing is told; never
another number.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import vfife
from hostile import cached, results, run_files
from results.test_runfile import small


@pytest.fixture(scope="module")
def a_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a short run with an ideal reference and companions."""
    path = tmp_path_factory.mktemp("run") / "run.sqlite"
    model = vfife.load_model(Path(__file__).parents[2] / "examples" / "four_bar_case_c.toml")
    vfife.simulate(model, turns=0.05, outputs=200, step=2e-6).save(path)
    return path


def test_damaged_run_files(tmp_path: Path) -> None:
    assert run_files(500, 11, small(tmp_path / "a"), tmp_path / "b") > 50


def test_damaged_results(a_run: Path, tmp_path: Path) -> None:
    assert results(40, 12, a_run, tmp_path / "b") > 2


def test_damaged_files_of_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    assert cached(900, 13, tmp_path / "cache") < 100
