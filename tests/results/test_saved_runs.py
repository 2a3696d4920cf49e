"""A run that a script saved, or wrote into a file, goes on with the bits of one that was longer."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import vfife
from support import bits, journal_in_bearing
from vfife.errors import HeldError, ModelError
from vfife.store.lock import run_lock
from vfife.store.runfile import RunFile


def run_for(duration: float, **options: object) -> vfife.Result:
    """50 outputs in 2 ms, with the usual companions."""
    return vfife.simulate(
        journal_in_bearing(), duration=duration, step=1e-6, outputs=round(duration / 4e-5), **options
    )


@pytest.fixture(scope="module")
def longer() -> vfife.Result:
    return run_for(3e-3)


def same_run(one: vfife.Result, other: vfife.Result) -> None:
    assert (bits(one.record.rows) == bits(other.record.rows)).all()
    assert str(one.measures) == str(other.measures)
    companions, others = one.record.companions, other.record.companions
    assert companions is not None and others is not None
    assert (bits(companions.rows) == bits(others.rows)).all() and companions.parting == others.parting


def saved(path: Path) -> None:
    run_for(2e-3).save(path)


def saved_again(path: Path) -> None:
    """A copy of a file is as good as the file."""
    saved(path.with_suffix(".first"))
    vfife.load_result(path.with_suffix(".first")).save(path)


def written(path: Path) -> None:
    run_for(2e-3, file=path)


@pytest.mark.parametrize("make", [saved, saved_again, written])
def test_a_complete_run_goes_on_with_its_companions(
    tmp_path: Path, longer: vfife.Result, make: Callable[[Path], None]
) -> None:
    make(tmp_path / "run.vfife")
    result = vfife.resume(tmp_path / "run.vfife", until="3 ms")
    same_run(result, longer)
    same_run(vfife.load_result(tmp_path / "run.vfife"), longer)
    assert not result.summary["run"]["notes"]


def test_a_file_without_the_states_of_companions_goes_on_alone(tmp_path: Path, longer: vfife.Result) -> None:
    """As version 0.2 saved it; the answer says why there is no numerical error."""
    path, result = tmp_path / "run.vfife", run_for(2e-3)
    result.record.checkpoint = None
    result.save(path)
    vfife.resume(path, until="3 ms")
    alone = vfife.load_result(path)
    assert (bits(alone.record.rows) == bits(longer.record.rows)).all() and alone.record.companions is None
    assert any("continues from 0.002 s without companions" in note for note in alone.summary["run"]["notes"])
    assert vfife.resume(path, until="3.2 ms").time[-1] == pytest.approx(3.2e-3)


def test_an_interrupted_run_goes_on_from_where_it_was(tmp_path: Path, longer: vfife.Result) -> None:
    """Not from its start: progress and the steps that are made begin at the interruption."""

    def interrupt(progress: object) -> None:
        if getattr(progress, "done", 0) >= 400:
            raise KeyboardInterrupt

    first = run_for(3e-3, progress=interrupt)
    done = first.record.reached
    assert first.record.status == "interrupted" and 400 <= done < 3000
    first.save(tmp_path / "run.vfife")
    seen: list[int] = []
    result = vfife.resume(tmp_path / "run.vfife", progress=lambda progress: seen.append(progress.done))
    assert min(seen) > done
    same_run(result, longer)


def test_a_saved_run_keeps_its_length_when_it_goes_on_with_half_the_step(tmp_path: Path) -> None:
    """The arguments of a run are in its file, not those of the settings of its model."""

    def interrupt(progress: object) -> None:
        raise KeyboardInterrupt

    model = vfife.gallery.slider_crank_loose_pin()
    first = vfife.simulate(model, turns=1.25, outputs=60, progress=interrupt)
    assert first.record.status == "interrupted"
    first.save(tmp_path / "run.vfife")
    whole = vfife.simulate(model, turns=1.25, outputs=60)
    assert whole.record.assembly.choice.tried
    same_run(vfife.resume(tmp_path / "run.vfife"), whole)


def test_the_path_of_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run_for(4e-4, file="run.vfife")
    assert len(result.time) == 11 and len(vfife.load_result("run.vfife").time) == 11
    with pytest.raises(
        ModelError,
        match=r"there is a file of this name.*vfife.resume\('run.vfife'\), .* vfife.load_result\(\)",
    ):
        run_for(4e-4, file="run.vfife")
    with pytest.raises(ModelError, match=r"not the ending of a run file.*export\(\)"):
        run_for(4e-4, file="run.csv")
    with pytest.raises(ModelError, match="there is no such folder"):
        run_for(4e-4, file=Path("nowhere", "run.vfife"))
    with run_lock(tmp_path / "run.vfife"), pytest.raises(HeldError, match="writes this run file"):
        vfife.resume("run.vfife", until=1e-3)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.vfife"]


def test_a_run_that_cannot_begin_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("vfife.simulation.simulate.run", fail)
    with pytest.raises(MemoryError):
        vfife.simulate(journal_in_bearing(), duration=1e-4, step=1e-6, file=tmp_path / "run.vfife")
    assert not list(tmp_path.iterdir())


SCRIPT = """
import sys, vfife
from support import journal_in_bearing
options = dict(duration=100.0, step=1e-6, outputs=1000000, confirm=True)
vfife.simulate(journal_in_bearing(), file=sys.argv[1], **options)
"""


@pytest.mark.system("starts a process and kills it")
def test_a_killed_script_loses_a_fraction_of_a_second(tmp_path: Path) -> None:
    path = tmp_path / "run.vfife"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([sys.executable, "-c", SCRIPT, str(path)], env=environment) as process:
        end = time.monotonic() + 60.0
        while time.monotonic() < end and (not path.exists() or path.stat().st_size < 400_000):
            time.sleep(0.05)
        process.send_signal(signal.SIGKILL)
    with RunFile.open(path) as file:
        last = file.latest()
    assert last is not None and last.step > 0
    until = 1e-6 * last.step + 1e-3
    result = vfife.resume(path, until=until)
    assert result.time[-1] == pytest.approx(until, abs=1e-4) and result.record.status == "complete"
