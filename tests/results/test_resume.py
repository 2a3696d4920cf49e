"""A run that was killed goes on as if nothing had happened: to the bit, wherever it was killed, companions, steps tried and statics with it."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from support import bits, four_bar, journal_in_bearing
from vfife.codegen.runner import Runner
from vfife.errors import HeldError, ResumeError, RunFileError
from vfife.results import runfile
from vfife.results.lock import Lock
from vfife.results.runfile import RunFile
from vfife.simulation import carry_out, prepare
from vfife.solvers import pace, transient
from vfife.solvers.arguments import Asked


class Killed(BaseException):
    """The end of a process, as far as one test goes."""


def write(path: Path, mechanism: vfife.Mechanism, asked: Asked, reference: bool = True) -> vfife.Result:
    prepared = prepare(mechanism, asked, reference)
    with RunFile.create(path, prepared.kept) as file:
        result = carry_out(prepared, file=file)
        result.finish(file)
    return result


def kill_at(monkeypatch: pytest.MonkeyPatch, call: int) -> Callable[[], None]:
    """The process ends at a call of the loop; what it gives back takes the fault away."""
    advance, calls = Runner.advance, []

    def killed(self: Runner, *args: Any, **how: Any) -> Any:
        calls.append(1)
        if len(calls) == call:
            raise Killed
        return advance(self, *args, **how)

    monkeypatch.setattr(Runner, "advance", killed)
    return lambda: monkeypatch.setattr(Runner, "advance", advance)


def paced(monkeypatch: pytest.MonkeyPatch, steps: int) -> None:
    """So many steps a call on every machine: by the clock, a fast one would come to its end before the call at which it is killed."""
    monkeypatch.setattr(pace.Pace, "room", property(lambda self: steps, lambda self, value: None), raising=False)


def killed_run(path: Path, mechanism: vfife.Mechanism, asked: Asked, reference: bool = True) -> bool:
    """A run that is killed: what was not committed is gone. False where it came to its end before."""
    prepared = prepare(mechanism, asked, reference)
    file = RunFile.create(path, prepared.kept)
    try:
        carry_out(prepared, file=file).finish(file)
    except Killed:
        return True
    finally:
        file._connection.close()
    return False


def same(one: Path, other: Path) -> None:
    """All that two run files say, except times of the clock."""
    with RunFile.open(one) as a, RunFile.open(other) as b:
        steps, rows = a.outputs()
        again, others = b.outputs()
        assert np.array_equal(steps, again) and (bits(rows) == bits(others)).all()
        assert not a.lost and not b.lost
        first, second = a.latest(), b.latest()
        assert first is not None and second is not None and first.step == second.step
        assert (bits(first.values) == bits(second.values)).all()
        beside, others_beside = a.companions(), b.companions()
        if beside is not None:
            assert others_beside is not None and beside[0] == others_beside[0]
            window = np.isin(others_beside[1], beside[1])
            assert (bits(beside[2][np.isin(beside[1], others_beside[1])]) == bits(others_beside[2][window])).all()
        told = [{key: value for key, value in file.meta.items() if not isinstance(value, np.ndarray)} for file in (a, b)]
        for one_told in told:
            for key in ("created", "finished", "wall"):
                one_told.pop(key)
            for key in ("wall_s", "ns_per_step"):
                one_told["summary"].pop(key)
        assert told[0] == told[1]


SEARCHED = Asked(turns=1.1, outputs=120)  # two tries of the step
RANDOM = random.Random(5)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "run.sqlite"
    result = write(path, four_bar("BCD", friction=vfife.Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2)), SEARCHED)
    assert len(result.record.assembly.choice.tried) >= 1 and result.record.companions is not None
    return path


@pytest.mark.parametrize("call", [10, 60, 110, 180])
def test_companions_and_steps_tried_go_on(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    """Killed in the first try of the step or a later one, in the middle of an interval between two outputs too."""
    paced(monkeypatch, 2000)
    mechanism = four_bar("BCD", friction=vfife.Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2))
    path = tmp_path / "run.sqlite"
    restore = kill_at(monkeypatch, call)
    assert killed_run(path, mechanism, SEARCHED)
    restore()
    vfife.resume(path)
    same(whole, path)


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
def test_between_two_outputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, loop: Any) -> None:
    """One output for the whole run: checkpoints lie within the interval, extremes since its begin with them."""
    asked = Asked(duration=2e-3, step=1e-6, outputs=1, loop=loop)
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


UNTIL = Asked(turns=9, step=5e-6, outputs=200, companions=3, settle=0.005)


@pytest.fixture(scope="module")
def settled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("settled") / "run.sqlite"
    result = write(path, four_bar("BCD"), UNTIL, reference=False)
    assert result.motion is not None and 4 < result.motion.count < 9
    return path


@pytest.mark.parametrize("call", [15, 60, 110])
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
        assert (bits(whole.turns()) == bits(again.turns())).all() and len(again.turns()) == result.motion.count  # type: ignore[union-attr]


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
    assert all((one.low, one.high) == (longer.measures[name].low, longer.measures[name].high) for name, one in straight.measures.items())


def arch() -> vfife.Mechanism:
    m = vfife.Mechanism("arch", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.0, mass=2.0, angle=-0.5, model="elastic", elements=3, section=vfife.Section.square(1e-4))
    m.weld("J", "ground.O", "rod.start")
    m.settings = vfife.Settings(analysis="static", load_factors=(0.2, 0.5, 1.0))
    return m


@pytest.mark.parametrize("call", [15, 30, 50])
def test_statics_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    write(tmp_path / "whole.sqlite", arch(), Asked())
    path = tmp_path / "run.sqlite"
    restore = kill_at(monkeypatch, call)
    assert killed_run(path, arch(), Asked())
    restore()
    vfife.resume(path)
    same(tmp_path / "whole.sqlite", path)


def test_a_started_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the whole state of a former run, which is gone by then; its step is halved after it was killed."""
    first = vfife.simulate(four_bar("C"), turns=0.3, outputs=60)
    options = {"turns": 0.4, "outputs": 60}
    mechanism = four_bar("C", friction=vfife.Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2))
    files = {}
    for name in ("whole", "run"):
        prepared = prepare(mechanism, Asked(**options), True, first)
        files[name] = RunFile.create(tmp_path / f"{name}.sqlite", prepared.kept)
        if name == "run":
            paced(monkeypatch, 500)
            restore = kill_at(monkeypatch, 6)
        try:
            result = carry_out(prepared, file=files[name])
            result.finish(files[name])
        except Killed:
            restore()
        files[name]._connection.close()
    vfife.resume(tmp_path / "run.sqlite")
    same(tmp_path / "whole.sqlite", tmp_path / "run.sqlite")


def test_until_a_later_time(tmp_path: Path) -> None:
    """Past the end of a complete run: as one that was asked to last so long."""
    asked = Asked(duration=2e-3, step=1e-6, outputs=50)
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


def test_what_cannot_go_on_is_told(tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    write(path, journal_in_bearing(), Asked(duration=1e-4, step=1e-6, outputs=10))
    whole = path.read_bytes()
    with pytest.raises(ResumeError, match="is complete; say how far"):
        vfife.resume(path)
    assert path.read_bytes() == whole
    with Lock(tmp_path), pytest.raises(HeldError, match=rf"process {os.getpid()} on .*, since 20.* writes a run here"):
        vfife.resume(path, until=1.0)
    assert path.read_bytes() == whole
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE history SET data = zeroblob(50) WHERE chunk = 1")
    with pytest.raises(ResumeError, match=r"damaged \(outputs? .*\), and would go on with a gap"):
        vfife.resume(path, until=1.0)
    former = Path(__file__).parent / "former" / "four_bar.sqlite"
    (tmp_path / "former.sqlite").write_bytes(former.read_bytes())
    with pytest.raises(RunFileError, match="without all it takes"):
        vfife.resume(tmp_path / "former.sqlite", until=1.0)


LOST = {
    "its state": (["DELETE FROM checkpoints"], "no whole state at its last output"),
    "its state, damaged": (["UPDATE checkpoints SET state = zeroblob(40)"], "no whole state at its last output"),
    "its last outputs": (["UPDATE history SET data = zeroblob(50) WHERE chunk = (SELECT max(chunk) FROM history)"], "where it ended is not known"),
}


@pytest.mark.parametrize("case", LOST)
def test_a_new_run_does_not_start_without_what_it_needs(tmp_path: Path, case: str) -> None:
    path, (statements, said) = tmp_path / "run.sqlite", LOST[case]
    mechanism = journal_in_bearing()
    write(path, mechanism, Asked(duration=1e-4, step=1e-6, outputs=10))
    assert vfife.simulate(mechanism, start=path, duration=1e-5, step=1e-6, companions=0).record.status == "complete"
    with sqlite3.connect(path) as connection:
        for statement in statements:
            connection.execute(statement)
    with pytest.raises(ResumeError, match=said):
        vfife.simulate(mechanism, start=path, duration=1e-5, step=1e-6, companions=0)


# ----------------------------------------------------------------------------------------------------------------- kill


def child(path: Path, mechanism: vfife.Mechanism, asked: Asked) -> int:
    """A process of its own that runs, or goes on, and ends without a word."""
    number = os.fork()
    if number:
        return number
    try:
        if path.exists() and _begun(path):
            vfife.resume(path)
        else:
            for old in path.parent.glob("run.sqlite*"):
                old.unlink()
            write(path, mechanism, asked)
    finally:
        os._exit(0)


def _begun(path: Path) -> bool:
    try:
        with RunFile.open(path) as file:
            return len(file.steps) > 0
    except RunFileError:
        return False


LONGEST = 0.5  # s that a process is left alive; the first one of all may have to compile


def killed_at_random(folder: Path, mechanism: vfife.Mechanism, asked: Asked, kills: int, longest: float) -> int:
    """Kills with -9 at random moments, the very first and last included, until the run is complete; how many there were."""
    path, done = folder / "run.sqlite", 0
    while done < kills:
        number = child(path, mechanism, asked)
        time.sleep(RANDOM.choice((RANDOM.uniform(0.0, 0.03), RANDOM.uniform(0.0, longest))))
        os.kill(number, signal.SIGKILL)
        os.waitpid(number, 0)
        done += 1
        if path.exists() and _begun(path) and vfife.load_result(path).record.status == "complete":
            break
    number = child(path, mechanism, asked)
    os.waitpid(number, 0)
    return done


def kill_and_compare(tmp_path: Path, kills: int) -> None:
    cases = {
        "transient": (four_bar("BC"), Asked(turns=2.0, step=2.5e-6, outputs=100, companions=3)),
        "static": (arch(), Asked()),
    }
    for name, (mechanism, asked) in cases.items():
        (tmp_path / name).mkdir()
        began = time.monotonic()
        write(tmp_path / name / "whole.sqlite", mechanism, asked)
        lasts, left = time.monotonic() - began, kills // 2
        while left > 0:
            for old in (tmp_path / name).glob("run.*"):
                old.unlink()
            left -= killed_at_random(tmp_path / name, mechanism, asked, left, min(1.2 * lasts, LONGEST))
            same(tmp_path / name / "whole.sqlite", tmp_path / name / "run.sqlite")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_twenty_kills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pace, "SECONDS", 5e-3)
    kill_and_compare(tmp_path, 20)


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_hundred_kills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pace, "SECONDS", 5e-3)
    kill_and_compare(tmp_path, 100)


def full_at(call: int) -> Callable[..., int]:
    """What writes a row, on a disk that is full at one of its calls."""
    insert, calls = runfile.tables.insert, []

    def full(connection: sqlite3.Connection, table: str, *values: Any) -> int:
        calls.append(1)
        if len(calls) == call:
            raise sqlite3.OperationalError("database or disk is full")
        return insert(connection, table, *values)

    return full


def test_a_disk_that_is_full_loses_the_last_transaction_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every write in turn fails; what was there before it is whole, and the run goes on from it when there is room again."""
    asked = Asked(duration=1e-3, step=1e-6, outputs=40)
    write(tmp_path / "whole.sqlite", journal_in_bearing(), asked)
    insert = runfile.tables.insert
    paced(monkeypatch, 30)
    for fails in range(60, 200, 35):
        path = tmp_path / f"{fails}.sqlite"
        monkeypatch.setattr(runfile.tables, "insert", full_at(fails))
        prepared = prepare(journal_in_bearing(), asked)
        file = RunFile.create(path, prepared.kept)
        try:
            carry_out(prepared, file=file).finish(file)
        except vfife.errors.StorageError as error:
            assert "disk is full" in str(error) and "bytes were to be written" in str(error) and "are free there" in str(error)
        file.close()
        monkeypatch.setattr(runfile.tables, "insert", insert)
        if vfife.load_result(path).record.status != "complete":
            vfife.resume(path)
        same(tmp_path / "whole.sqlite", path)


def test_rows_of_companions_that_went_before_the_checkpoint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Killed long after its only checkpoint, when the window over the last turn has left that behind."""
    asked, mechanism = Asked(turns=3.0, step=1e-5, outputs=60, companions=3), four_bar("BC")
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
