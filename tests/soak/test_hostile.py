"""A hundred thousand inputs made up at random: see tests/hostile.py."""

from __future__ import annotations

from pathlib import Path

import pytest

from hostile import cached, model_texts, overrides, quantities, results, run_files
from results.test_fuzz import a_run  # noqa: F401 - a fixture
from results.test_runfile import small

pytestmark = pytest.mark.soak


@pytest.mark.parametrize("seed", range(10))
def test_model_texts(seed: int) -> None:
    assert model_texts(3000, 1000 + seed)


@pytest.mark.parametrize("seed", range(10))
def test_mechanisms_put_together(seed: int) -> None:
    assert model_texts(500, 2000 + seed, assembled=True)


@pytest.mark.parametrize("seed", range(10))
def test_overrides(seed: int) -> None:
    assert overrides(1000, 3000 + seed)


def test_quantities() -> None:
    assert quantities(30_000, 4000)


@pytest.mark.parametrize("seed", range(4))
def test_run_files(tmp_path: Path, seed: int) -> None:
    assert run_files(3500, 5000 + seed, small(tmp_path / "a"), tmp_path / "b")


def test_results(a_run: Path, tmp_path: Path) -> None:  # noqa: F811 - it is the fixture
    assert results(1000, 6000, a_run, tmp_path / "b")


def test_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    assert cached(10_000, 7000, tmp_path / "cache") >= 0
