"""Files whose outputs are many: what is asked of a run is told without them, and they are read where they are
asked for.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import vfife
from cli.conftest import command  # noqa: F401 - a fixture
from support import four_bar
from vfife.store import run_reader
from vfife.store.runfile import RunFile


@pytest.fixture
def large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, vfife.Result, list[bool]]:
    """A file that counts as large, the run that it holds, and how often its outputs were read."""
    result = vfife.simulate(four_bar(), turns=0.1, outputs=300, step=2e-6)
    path = tmp_path / "run.sqlite"
    with RunFile.create(path, result._meta()) as file:
        for first in range(0, len(result.record.steps), 7):
            some = slice(first, first + 7)
            file.append(result.record.steps[some], result.record.rows[some])
        result.finish(file)
    monkeypatch.setattr(run_reader, "LARGE", 0)
    outputs, read = RunFile.outputs, list[bool]()

    def counted(self: RunFile, only_steps: bool = False) -> object:
        read.append(only_steps)
        return outputs(self, only_steps)

    monkeypatch.setattr(RunFile, "outputs", counted)
    return path, result, read


def test_its_summary_is_shown_without_its_outputs(large: tuple[Path, vfife.Result, list[bool]]) -> None:
    path, result, read = large
    again = vfife.load_result(path)
    assert (again.record.steps == result.record.steps).all() and repr(again) == repr(result)
    assert json.loads(json.dumps(again.summary["measures"])) == {
        name: float(value) for name, value in result.summary["measures"].items()
    }
    assert not read
    assert (again.record.rows == result.record.rows).all() and again.measures == result.measures
    assert read == [False]


def test_damage_is_told_when_they_are_read(large: tuple[Path, vfife.Result, list[bool]]) -> None:
    path, result, read = large
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE history SET data = zeroblob(50) WHERE chunk = 1")
    again = vfife.load_result(path)
    assert not again.record.damaged_parts and not read
    rows = again.record.rows
    assert (
        again.record.damaged_parts == ("outputs 7 to 13",)
        and len(rows) == len(again.record.steps) == len(result.record.steps) - 7
    )
    kept = np.searchsorted(result.record.steps, again.record.steps)
    assert (rows == result.record.rows[kept]).all()


@pytest.mark.parametrize("statement", ["steps = zeroblob(9)", "chunk = 900"])
def test_steps_that_are_not_whole_are_looked_at_with_their_outputs(
    large: tuple[Path, vfife.Result, list[bool]], statement: str
) -> None:
    path, _, read = large
    with sqlite3.connect(path) as connection:
        connection.execute(f"UPDATE history SET {statement} WHERE chunk = 1")
    again = vfife.load_result(path)
    assert again.record.damaged_parts == ("outputs 7 to 13",) and read == [False]


def test_info_is_told_without_them_and_checks_them_when_asked(
    large: tuple[Path, vfife.Result, list[bool]],
    command: Callable,  # noqa: F811
) -> None:
    path, result, read = large
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE history SET data = zeroblob(50) WHERE chunk = 1")
    told = command("info", path)
    assert (
        told.exit_code == 0
        and "--check" in told.stdout
        and f"{len(result.record.steps):,}, of" in told.stdout
        and not read
    )
    told = command("info", path, "--check")
    assert "outputs 7 to 13 cannot be read" in told.stdout and read
