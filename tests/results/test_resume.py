"""A run that was killed goes on as if nothing had happened: to the bit, wherever it was killed, companions,
steps tried and statics with it.
"""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path
from typing import Any

import pytest

import vfife
from choice import default_cases
from results.killed import Killed, arch, full_at, kill_at, killed_run, paced, same, write
from support import bits, four_bar, journal_in_bearing
from vfife.errors import HeldError, ResumeError
from vfife.simulation.simulate import prepare, run_prepared
from vfife.solvers import transient
from vfife.solvers.arguments import RunArguments
from vfife.store.lock import Lock
from vfife.store.runfile import RunFile

SEARCHED = RunArguments(turns=1.1, outputs=120)  # two tries of the step


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "run.sqlite"
    result = write(
        path, four_bar("BCD", friction=vfife.laws.Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2)), SEARCHED
    )
    assert len(result.record.assembly.choice.tried) >= 1 and result.record.companions is not None
    return path


@pytest.mark.parametrize(
    "call", default_cases([10, 60, 110, 180], lambda call: call in (10, 110), "runs a model twice")
)
def test_companions_and_steps_tried_go_on(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int
) -> None:
    """Killed in the first try of the step or a later one, in the middle of an interval between two outputs
    too.
    """
    paced(monkeypatch, 2000)
    mechanism = four_bar("BCD", friction=vfife.laws.Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2))
    path = tmp_path / "run.sqlite"
    restore = kill_at(monkeypatch, call)
    assert killed_run(path, mechanism, SEARCHED)
    restore()
    vfife.resume(path)
    same(whole, path)


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
def test_between_two_outputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, loop: Any) -> None:
    """One output for the whole run: checkpoints lie within the interval, extremes since its
    begin with them.
    """
    asked = RunArguments(duration=2e-3, step=1e-6, outputs=1, loop=loop)
    write(tmp_path / "whole.sqlite", journal_in_bearing(), asked)
    path = tmp_path / "run.sqlite"
    with monkeypatch.context() as context:
        paced(context, 30)
        context.setattr(transient, "CHECKPOINT_SECONDS", 0.0)
        kill_at(context, 30)
        assert killed_run(path, journal_in_bearing(), asked)
    with RunFile.open(path) as file:
        last = file.latest()
        assert len(file.steps) == 1 and last is not None and 0 < last.step < 2000
    result = vfife.resume(path)
    assert len(result.record.steps) == 2
    same(tmp_path / "whole.sqlite", path)


UNTIL = RunArguments(turns=9, step=5e-6, outputs=200, companions=3, settle=0.005)


@pytest.fixture(scope="module")
def settled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("settled") / "run.sqlite"
    result = write(path, four_bar("BCD"), UNTIL, reference=False)
    assert result.motion is not None and 4 < result.motion.count < 9
    return path


@pytest.mark.parametrize("call", default_cases([15, 60, 110], lambda call: call == 60, "runs a model twice"))
def test_a_run_until_it_repeats_goes_on_and_ends_in_the_same_turn(
    settled: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int
) -> None:
    """With what companions leave of each turn, and the same mean over the turns after the transient."""
    path = tmp_path / "run.sqlite"
    with monkeypatch.context() as context:
        paced(context, 400)
        context.setattr(transient, "CHECKPOINT_SECONDS", 0.0)
        kill_at(context, call)
        assert killed_run(path, four_bar("BCD"), UNTIL, reference=False)
    result = vfife.resume(path)
    same(settled, path)
    with RunFile.open(settled) as whole, RunFile.open(path) as again:
        assert (bits(whole.turns()) == bits(again.turns())).all() and len(
            again.turns()
        ) == result.motion.count  # type: ignore[union-attr]


def test_a_run_that_has_settled_goes_on_where_it_is_asked_to(settled: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    path.write_bytes(settled.read_bytes())
    before = vfife.load_result(settled)
    with pytest.raises(ResumeError, match="complete"):
        vfife.resume(path)
    longer = vfife.resume(path, until=0.32)
    assert len(longer.record.steps) == 8 * 200 + 1 and longer.motion.count == 8  # type: ignore[union-attr]
    assert (bits(longer.record.rows[: len(before.record.rows)]) == bits(before.record.rows)).all()
    straight = vfife.simulate(four_bar("BCD"), turns=8, step=5e-6, outputs=200, companions=3, reference=False)
    assert dict(longer.measures) == dict(straight.measures)
    assert all(
        (one.low, one.high) == (longer.measures[name].low, longer.measures[name].high)
        for name, one in straight.measures.items()
    )


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("still") / "run.sqlite"
    write(path, arch(), RunArguments())
    return path


@pytest.mark.parametrize("call", default_cases([15, 30, 50], lambda call: call == 30, "runs a model twice"))
def test_statics_go_on(still: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    path = tmp_path / "run.sqlite"
    restore = kill_at(monkeypatch, call)
    assert killed_run(path, arch(), RunArguments())
    restore()
    vfife.resume(path)
    same(still, path)


def test_a_started_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the whole state of a former run, which is gone by then; its step is halved after it was killed."""
    first = vfife.simulate(four_bar("C"), turns=0.3, outputs=60)
    options = {"turns": 0.4, "outputs": 60}
    mechanism = four_bar("C", friction=vfife.laws.Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2))
    files = {}
    for name in ("whole", "run"):
        prepared = prepare(mechanism, RunArguments(**options), True, first)
        files[name] = RunFile.create(tmp_path / f"{name}.sqlite", prepared.run_meta)
        if name == "run":
            paced(monkeypatch, 500)
            restore = kill_at(monkeypatch, 6)
        try:
            result = run_prepared(prepared, file=files[name])
            result.finish(files[name])
        except Killed:
            restore()
        files[name]._connection.close()
    vfife.resume(tmp_path / "run.sqlite")
    same(tmp_path / "whole.sqlite", tmp_path / "run.sqlite")


def test_until_a_later_time(tmp_path: Path) -> None:
    """Past the end of a complete run: as one that was asked to last so long."""
    asked = RunArguments(duration=2e-3, step=1e-6, outputs=50)
    write(tmp_path / "run.sqlite", journal_in_bearing(), asked)
    before = vfife.load_result(tmp_path / "run.sqlite")
    after = vfife.resume(tmp_path / "run.sqlite", until="3 ms")
    assert after.time[-1] == pytest.approx(3e-3) and len(after.time) == 76
    assert (bits(after.record.rows[:51]) == bits(before.record.rows)).all()
    whole = vfife.simulate(journal_in_bearing(), duration=3e-3, step=1e-6, outputs=75)
    assert (bits(after.record.rows) == bits(whole.record.rows)).all()
    assert vfife.load_result(tmp_path / "run.sqlite").record.assembly.mechanism.settings.duration == 3e-3
    with pytest.raises(ResumeError, match=r"is at 0.003 s already"):
        vfife.resume(tmp_path / "run.sqlite", until=1e-3)


def test_an_interrupted_resume_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A script goes on with the result, so it has to be told on standard error, as simulate() does."""
    path = tmp_path / "run.sqlite"
    write(path, journal_in_bearing(), RunArguments(duration=2e-3, step=1e-6, outputs=50))

    def interrupt(_: object) -> None:
        raise KeyboardInterrupt

    result = vfife.resume(path, until="3 ms", progress=interrupt)
    assert result.record.status == "interrupted"
    assert "resume() was interrupted; it returns the results computed until then." in capsys.readouterr().err
    assert len(vfife.resume(path).time) == 76


def test_what_cannot_go_on_is_told(tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    write(path, journal_in_bearing(), RunArguments(duration=1e-4, step=1e-6, outputs=10))
    whole = path.read_bytes()
    with pytest.raises(ResumeError, match="is complete; give a later end"):
        vfife.resume(path)
    assert path.read_bytes() == whole
    with (
        Lock(tmp_path),
        pytest.raises(HeldError, match=rf"process {os.getpid()} on .*, since 20.* writes a run here"),
    ):
        vfife.resume(path, until=1.0)
    assert path.read_bytes() == whole
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE history SET data = zeroblob(50) WHERE chunk = 1")
    with pytest.raises(ResumeError, match=r"damaged \(outputs? .*\), and would continue with a gap"):
        vfife.resume(path, until=1.0)


LOST = {
    "its state": (["DELETE FROM checkpoints"], "no complete state at its last output"),
    "its state, damaged": (
        ["UPDATE checkpoints SET state = zeroblob(40)"],
        "no complete state at its last output",
    ),
    "its last outputs": (
        ["UPDATE history SET data = zeroblob(50) WHERE chunk = (SELECT max(chunk) FROM history)"],
        "its end is unknown",
    ),
}


@pytest.mark.parametrize("case", LOST)
def test_a_new_run_does_not_start_without_what_it_needs(tmp_path: Path, case: str) -> None:
    path, (statements, said) = tmp_path / "run.sqlite", LOST[case]
    mechanism = journal_in_bearing()
    write(path, mechanism, RunArguments(duration=1e-4, step=1e-6, outputs=10))
    assert (
        vfife.simulate(mechanism, start=path, duration=1e-5, step=1e-6, companions=0).record.status
        == "complete"
    )
    with sqlite3.connect(path) as connection:
        for statement in statements:
            connection.execute(statement)
    with pytest.raises(ResumeError, match=said):
        vfife.simulate(mechanism, start=path, duration=1e-5, step=1e-6, companions=0)


def test_a_disk_that_is_full_loses_the_last_transaction_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every write in turn fails; what was there before it is whole, and the run goes on from it when there is
    room again.
    """
    asked = RunArguments(duration=1e-3, step=1e-6, outputs=40)
    write(tmp_path / "whole.sqlite", journal_in_bearing(), asked)
    insert = RunFile.insert
    paced(monkeypatch, 30)
    for fails in range(60, 200, 35):
        path = tmp_path / f"{fails}.sqlite"
        monkeypatch.setattr(RunFile, "insert", full_at(fails))
        prepared = prepare(journal_in_bearing(), asked)
        file = RunFile.create(path, prepared.run_meta)
        try:
            run_prepared(prepared, file=file).finish(file)
        except vfife.errors.StorageError as error:
            assert "disk is full" in str(error) and "bytes are free there" in str(error)
        file.close()
        monkeypatch.setattr(RunFile, "insert", insert)
        if vfife.load_result(path).record.status != "complete":
            vfife.resume(path)
        same(tmp_path / "whole.sqlite", path)


def test_rows_of_companions_that_went_before_the_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed long after its only checkpoint, when the window over the last turn has left that behind."""
    asked, mechanism = RunArguments(turns=3.0, step=1e-5, outputs=60, companions=3), four_bar("BC")
    write(tmp_path / "whole.sqlite", mechanism, asked)
    path = tmp_path / "run.sqlite"
    with monkeypatch.context() as context:
        context.setattr(transient, "CHECKPOINT_SHARE", 1e9)
        context.setattr(transient, "CHUNK_BYTES", 2**16)
        context.setattr(RunFile, "finish", killed)
        assert killed_run(path, mechanism, asked)
    with sqlite3.connect(path) as connection:
        connection.execute("DELETE FROM checkpoints WHERE step > 0")
        assert connection.execute("SELECT min(last) FROM companions").fetchone()[0] > 1
    vfife.resume(path)
    same(tmp_path / "whole.sqlite", path)


def killed(*args: Any, **named: Any) -> None:
    raise Killed
