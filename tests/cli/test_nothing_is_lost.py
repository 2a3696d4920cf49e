"""Whatever is mistyped, interrupted or claimed by two: what lay in a folder is there afterwards, and a
sentence says what is kept.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import vfife
from cli.folders import contents, stages
from cli.models import PENDULUM
from vfife import files
from vfife.cli.app import app
from vfife.compiler.runtime.runner import Runner
from vfife.job import cost
from vfife.solvers import transient
from vfife.store import folder
from vfife.store.lock import Lock, holder
from vfife.store.runfile import RunFile


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with figures."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "pendulum.toml").write_text(PENDULUM)
    assert (
        CliRunner()
        .invoke(
            app, ["run", str(folder / "pendulum.toml"), "-o", str(folder / "kept"), "--quiet", "--figures"]
        )
        .exit_code
        == 0
    )
    return folder / "kept"


@pytest.fixture
def kept(command: Callable, pendulum: Path, made: Path) -> Path:
    """It, copied into the empty folder, and a file of the user's beside it."""
    shutil.copytree(made, "kept")
    Path("kept/mine.txt").write_text("notes")
    Path("kept/figures/mine.png").write_bytes(b"\x89PNG, drawn by hand")
    return Path("kept")


REFUSED = {
    "no --force": ([], "add --force to replace it"),
    "start from itself": (["--force", "--start-from", "kept"], "the one from which it starts"),
    "start from its file": (["--force", "--start-from", "kept/run.sqlite"], "the one from which it starts"),
    "too many outputs": (["--force", "--outputs", "1000000000"], "--outputs"),
    "turns without a crank": (["--force", "--turns", "2"], "duration"),
    "a start that is none": (["--force", "--start-from", "nowhere"], "nowhere"),
    "no such loop": (["--force", "--loop", "fast"], "--loop"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused_touches_nothing(command: Callable, pendulum: Path, kept: Path, case: str) -> None:
    before, (words, said) = contents(kept), REFUSED[case]
    done = command("run", pendulum, "-o", "kept", *words, "--json")
    assert done.exit_code in (2, 5) and said in done.stderr, done.stderr
    assert json.loads(done.stdout)["status"] in ("refused", "storage")
    assert contents(kept) == before and not stages()


def test_a_disk_without_room_is_told_before_anything_begins(
    command: Callable, pendulum: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(kept)
    monkeypatch.setattr(files, "free_bytes", lambda path: 1000)
    done = command("run", pendulum, "-o", "kept", "--force", "--json")
    assert (
        done.exit_code == 5 and "1,000 are free there" in done.stderr and "no file was changed" in done.stderr
    )
    assert json.loads(done.stdout)["status"] == "storage"
    assert contents(kept) == before and not stages()


def test_a_runs_own_model_in_its_own_folder(
    command: Callable, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(kept)
    monkeypatch.chdir(kept)
    assert command("run", "model.toml", "-o", ".").exit_code == 2
    assert contents(Path()) == before
    done = command("run", "model.toml", "-o", ".", "--force", "--quiet")
    assert done.exit_code == 0, done.stderr
    assert vfife.load_result(".").record.status == "complete"
    assert Path("mine.txt").read_text() == "notes" and Path("figures/mine.png").exists()
    assert (
        not list(Path("figures").glob("forces.png"))
        and Path("model.toml").read_bytes() == before["model.toml"]
    )


@pytest.mark.parametrize("name", ["run.sqlite", "model.toml", "summary.json", "figures/mechanism.png"])
def test_files_that_are_not_ours_are_never_written_over(
    command: Callable, pendulum: Path, kept: Path, name: str
) -> None:
    (kept / name).write_text("my own text")
    before = contents(kept)
    done = command("run", pendulum, "-o", "kept", "--force")
    assert done.exit_code == 2
    assert ("not a run of vfife" if name == "run.sqlite" else name) in done.stderr
    assert contents(kept) == before and not stages()


def test_another_program_s_database_of_that_name(command: Callable, pendulum: Path, tmp_path: Path) -> None:
    folder = tmp_path / "theirs"
    folder.mkdir()
    sqlite3.connect(folder / "run.sqlite").execute("CREATE TABLE years (work)").connection.close()
    before = contents(folder)
    for words in ([], ["--force"], ["--resume"]):
        assert command("run", pendulum, "-o", folder, *words).exit_code == 2
        assert contents(folder) == before


def test_a_run_is_replaced_when_its_first_output_is_there(
    command: Callable, pendulum: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while the loop is compiled leaves the old run; after the first output the new one is in its
    place.
    """
    before = contents(kept)
    advance = Runner.advance

    def broken(self: Runner, *args: Any, **how: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(Runner, "advance", broken)
    done = command("run", pendulum, "-o", "kept", "--force")
    assert done.exit_code == 130 and "nothing to keep" in done.stderr
    assert contents(kept) == before and not stages()
    monkeypatch.setattr(Runner, "advance", advance)
    assert command("run", pendulum, "-o", "kept", "--force", "--duration", "0.01", "--quiet").exit_code == 0
    assert vfife.load_result("kept").time[-1] == pytest.approx(0.01)
    assert set(contents(kept)) == {"run.sqlite", "model.toml", "summary.json", "mine.txt", "figures/mine.png"}


def test_what_a_killed_process_began_is_tidied_up(command: Callable, pendulum: Path) -> None:
    left = Path("runs/.pendulum.new-0123")
    left.mkdir(parents=True)
    (left / "model.toml").write_text("")
    other = Path("runs/.pendulum.new-4567")
    other.mkdir()
    with Lock(other):
        assert command("run", pendulum, "--quiet").exit_code == 0
        assert not left.exists() and other.exists()


FORECASTS = {
    "time": (["--duration", "100000000"], "days "),
    "disk": ([], "left"),
    "memory": ([], "of memory on a machine that has 1 MB"),
}


@pytest.mark.parametrize("what", FORECASTS)
def test_what_takes_too_much_is_asked_for_twice(
    command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    words, said = FORECASTS[what]
    if what == "disk":
        monkeypatch.setattr(files, "free_bytes", lambda path: 150_000)
    if what == "memory":
        monkeypatch.setattr(cost, "physical_memory", lambda: 1_000_000)
    done = command("run", pendulum, *words, "--step", "1e-6", "--json")
    assert (
        done.exit_code == 2 and "--yes" in done.stderr and said in done.stderr and not Path("runs").exists()
    )
    assert json.loads(done.stdout)["status"] == "refused"
    if not words:
        assert command("run", pendulum, "--yes", "--quiet").exit_code == 0


# ---------------------------------------------------------------------------------------------------- writers


def test_one_writer_at_a_time(command: Callable, pendulum: Path, kept: Path) -> None:
    before = contents(kept)
    holds, tells = os.pipe()
    child = os.fork()
    if not child:
        try:  # whatever happens, the child ends here and runs no tests of its own
            lock = Lock(kept)
            os.write(tells, b"x")
            time.sleep(60)
            lock.release()
        finally:
            os._exit(0)
    os.close(tells)
    assert os.read(holds, 1) == b"x"
    os.close(holds)
    for words in (["run", pendulum, "-o", "kept", "--force"], ["resume", "kept", "--until", "1"]):
        done = command(*words)
        assert done.exit_code == 2
        assert f"process {child} on " in done.stderr and "since 20" in done.stderr
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    assert holder(kept) is None  # the lock has died with its process
    after = contents(kept)
    after.pop("run.lock")
    assert after == before
    assert command("resume", "kept", "--until", "0.06", "--quiet").exit_code == 0


def test_two_that_begin_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one that comes first is there; the other one leaves it alone."""
    model = tmp_path / "m.toml"
    first, second = folder.placed(tmp_path / "r", model), folder.placed(tmp_path / "r", model)
    for one in (first, second):
        one.begin()
        (one.path / "model.toml").write_text("")
        RunFile.create(one.run_file).close()
    first.settle()
    with pytest.raises(vfife.errors.HeldError):
        second.settle()
    second.leave()
    assert first.run_file.is_file() and (tmp_path / "r" / "run.lock").is_file()
    first.leave()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r"]


def test_two_without_a_name_go_beside_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    both = [folder.placed(None, Path("m.toml")) for _ in range(2)]
    for one in both:
        one.begin()
        (one.path / "model.toml").write_text("")
        RunFile.create(one.run_file).close()
    assert [str(one.settle().parent) for one in both] == ["runs/m", "runs/m-2"]
    for one in both:
        one.leave()


# ----------------------------------------------------------------------------------------------------- resume


def test_resume_and_run_resume(command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert command("run", pendulum, "-o", "whole", "--quiet").exit_code == 0
    monkeypatch.setattr(transient, "QUICK", 16)  # steps of the first call, so that there are more of them
    advance, calls = Runner.advance, []

    def interrupted(self: Runner, *args: Any, **how: Any) -> Any:
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return advance(self, *args, **how)

    for name, words in (("a", ["resume", "a"]), ("b", ["run", pendulum, "-o", "b", "--resume"])):
        calls.clear()
        monkeypatch.setattr(Runner, "advance", interrupted)
        broken = command("run", pendulum, "-o", name)
        assert broken.exit_code == 130 and f"vfife resume {name}" in broken.stderr
        monkeypatch.setattr(Runner, "advance", advance)
        done = command(*words, "--json")
        assert done.exit_code == 0, done.stderr
        whole, again = (json.loads(Path(where, "summary.json").read_text()) for where in ("whole", name))
        assert (
            again["status"] == "complete"
            and again["measures"] == whole["measures"]
            and again["energy_error"] == whole["energy_error"]
        )
    complete = command("resume", "a")
    assert complete.exit_code == 2 and "is complete; give a later end" in complete.stderr
    other = command("run", pendulum, "-o", "a", "--resume", "--step", "1e-5")
    assert other.exit_code == 2 and "of another model, or of other options" in other.stderr
    further = command("resume", "a", "--until", "60 ms", "--json")
    assert further.exit_code == 0 and vfife.load_result("a").time[-1] == pytest.approx(0.06)
    assert vfife.load_model("a/model.toml").settings.duration == 0.06
    assert (
        command("run", pendulum, "-o", "new", "--resume", "--quiet").exit_code == 0
    )  # where there is none yet it begins
