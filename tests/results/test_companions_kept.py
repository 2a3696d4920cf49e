"""What companions leave survives the process, in the same transactions as the run."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import numpy as np
import pytest

import vfife
from support import four_bar
from vfife.errors import ResumeError
from vfife.measures.trust import trust
from vfife.simulation.result import Result
from vfife.simulation.simulate import prepare, run_prepared
from vfife.solvers import transient
from vfife.solvers.arguments import RunArguments
from vfife.store.runfile import RunFile


def same(one: Result, other: Result) -> None:
    assert trust(one.record, one.measures) == trust(other.record, other.measures)
    assert list(one.measures) == list(other.measures)
    for name, value in one.measures.items():
        assert (value, value.low, value.high) == (
            other.measures[name],
            other.measures[name].low,
            other.measures[name].high,
        )


@pytest.fixture(scope="module")
def result() -> Result:
    return vfife.simulate(four_bar("BCD"), turns=1.5)


def test_saved_and_read(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path / "run.sqlite")
    same(result, again)
    assert again.record.assembly.choice == result.record.assembly.choice
    assert again.record.companions is not None and result.record.companions is not None
    assert np.array_equal(again.record.companions.rows, result.record.companions.rows)


def test_written_while_it_runs(result: Result, tmp_path: Path) -> None:
    prepared = prepare(four_bar("BCD"), RunArguments(turns=1.5))
    with RunFile.create(tmp_path / "run.sqlite", prepared.run_meta) as file:
        written = run_prepared(prepared, file=file)
        written.finish(file)
    same(written, result)
    same(Result.load(tmp_path / "run.sqlite"), result)


def test_an_interrupted_run_has_ranges(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    prepared = prepare(four_bar("BCD"), RunArguments(turns=8.0, outputs=200))
    monkeypatch.setattr(transient, "CHUNK_BYTES", 2**16)

    def stop(progress: object) -> None:
        if progress.done > 10000:  # type: ignore[attr-defined]
            raise KeyboardInterrupt

    with RunFile.create(tmp_path / "run.sqlite", prepared.run_meta) as file:
        written = run_prepared(prepared, file=file, progress=stop)
    assert written.record.status == "interrupted"
    killed = Result.load(tmp_path / "run.sqlite")
    assert killed.record.status == "unfinished"
    same(written, killed)
    assert any(one.width > 0.0 for one in killed.measures.values())


def test_a_run_of_version_0_2_is_read_and_not_resumed(result: Result, tmp_path: Path) -> None:
    """Its companions had the step of the run and displaced first steps: ranges are those of their values, as
    they were then.
    """
    path = tmp_path / "run.sqlite"
    result.save(path)
    with RunFile.write(path) as file:
        told = dict(file.meta["companions"])
        del told["counts"]
        file.put({"companions": {**told, "shifts": [0.25, 0.5, 0.75]}})
    again = Result.load(path)
    left = again.record.companions
    assert left is not None and left.counts.tolist() == 3 * [again.record.assembly.choice.outputs_every]
    now, then = result.measures["C.force.max"], again.measures["C.force.max"]
    assert then.value == now.value and now.low < then.low <= then.value <= then.high < now.high
    before = path.read_bytes()
    with pytest.raises(ResumeError, match=r"version 0\.2 wrote this run, with companions of the same step"):
        vfife.resume(path, until=0.1)
    assert path.read_bytes() == before


def test_chunks_that_nobody_needs_are_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transient, "CHUNK_BYTES", 2**17)
    prepared = prepare(four_bar("C"), RunArguments(turns=6.0, outputs=100, step=1e-5))
    with RunFile.create(tmp_path / "run.sqlite", prepared.run_meta) as file:
        run_prepared(prepared, file=file).finish(file)
    with sqlite3.connect(tmp_path / "run.sqlite") as connection:
        kept, every = (
            connection.execute(f"SELECT sum(outputs) FROM {table}").fetchone()[0]
            for table in ("companions", "history")
        )
    assert every == 601 and kept < 250


def test_a_file_without_them_is_read_as_before(result: Result, tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    result.save(path)
    with sqlite3.connect(path) as connection:
        connection.execute("DROP TABLE companions")
    again = Result.load(path)
    assert again.record.companions is None
    assert {name: one.value for name, one in again.measures.items()} == {
        name: one.value for name, one in result.measures.items()
    }


def test_damaged_ones_are_left_out_and_told(result: Result, tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    result.save(path)
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE companions SET outputs = outputs - 1")
    again = Result.load(path)
    assert again.record.companions is None and again.record.damaged_parts == ("the companions",)
    assert "the companions could not be read" in again.summary["warnings"][0]
    assert {name: one.value for name, one in again.measures.items()} == {
        name: one.value for name, one in result.measures.items()
    }
