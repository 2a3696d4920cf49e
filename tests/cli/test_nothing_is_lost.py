"""Whatever is mistyped, interrupted, full or forbidden: what lay in a folder is there afterwards, and a sentence says what is kept."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import vfife
from cli.models import PENDULUM
from vfife import plots
from vfife.cli import carried, cost
from vfife.cli.app import app
from vfife.codegen import cache
from vfife.codegen.runner import Runner
from vfife.results import folder, netcdf, place, tables
from vfife.results.lock import Lock, holder
from vfife.results.runfile import RunFile
from vfife.solvers import transient


def contents(where: Path) -> dict[str, bytes]:
    return {str(path.relative_to(where)): path.read_bytes() for path in sorted(where.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with figures."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "pendulum.toml").write_text(PENDULUM)
    assert CliRunner().invoke(app, ["run", str(folder / "pendulum.toml"), "-o", str(folder / "kept"), "--quiet", "--figures"]).exit_code == 0
    return folder / "kept"


@pytest.fixture
def kept(command: Callable, pendulum: Path, made: Path) -> Path:
    """It, copied into the empty folder, and a file of the user's beside it."""
    shutil.copytree(made, "kept")
    Path("kept/mine.txt").write_text("notes")
    Path("kept/figures/mine.png").write_bytes(b"\x89PNG, drawn by hand")
    return Path("kept")


def stages() -> list[Path]:
    return [path for path in Path().rglob("*") if ".new-" in path.name or path.name in ("run.lock",)]


# ---------------------------------------------------------------------------------------------------------------- replace

REFUSED = {
    "no --force": ([], "add --force to replace it"),
    "start from itself": (["--force", "--start-from", "kept"], "which would be lost"),
    "start from its file": (["--force", "--start-from", "kept/run.sqlite"], "which would be lost"),
    "too many outputs": (["--force", "--outputs", "1000000000"], "[run] outputs"),
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


def test_a_disk_without_room_is_told_before_anything_begins(command: Callable, pendulum: Path, kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = contents(kept)
    monkeypatch.setattr(tables, "free_bytes", lambda path: 1000)
    done = command("run", pendulum, "-o", "kept", "--force", "--json")
    assert done.exit_code == 5 and "1,000 are free there" in done.stderr and "nothing is touched" in done.stderr
    assert json.loads(done.stdout)["status"] == "storage"
    assert contents(kept) == before and not stages()


def test_a_runs_own_model_in_its_own_folder(command: Callable, kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = contents(kept)
    monkeypatch.chdir(kept)
    assert command("run", "model.toml", "-o", ".").exit_code == 2
    assert contents(Path()) == before
    done = command("run", "model.toml", "-o", ".", "--force", "--quiet")
    assert done.exit_code == 0, done.stderr
    assert vfife.load_result(".").record.status == "complete"
    assert Path("mine.txt").read_text() == "notes" and Path("figures/mine.png").exists()
    assert not list(Path("figures").glob("forces.png")) and Path("model.toml").read_bytes() == before["model.toml"]


@pytest.mark.parametrize("name", ["run.sqlite", "model.toml", "summary.json", "figures/mechanism.png"])
def test_files_that_are_not_ours_are_never_written_over(command: Callable, pendulum: Path, kept: Path, name: str) -> None:
    (kept / name).write_text("my own text")
    before = contents(kept)
    done = command("run", pendulum, "-o", "kept", "--force")
    assert done.exit_code == 2
    assert ("no run of vfife" if name == "run.sqlite" else name) in done.stderr
    assert contents(kept) == before and not stages()


def test_another_program_s_database_of_that_name(command: Callable, pendulum: Path, tmp_path: Path) -> None:
    folder = tmp_path / "theirs"
    folder.mkdir()
    sqlite3.connect(folder / "run.sqlite").execute("CREATE TABLE years (work)").connection.close()
    before = contents(folder)
    for words in ([], ["--force"], ["--resume"]):
        assert command("run", pendulum, "-o", folder, *words).exit_code == 2
        assert contents(folder) == before


def test_a_run_is_replaced_when_its_first_output_is_there(command: Callable, pendulum: Path, kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while the loop is compiled leaves the old run; after the first output the new one is in its place."""
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
    "time": (["--duration", "100000"], "h "),
    "disk": ([], "left"),
    "memory": ([], "of memory, of which there are 1 MB"),
}


@pytest.mark.parametrize("what", FORECASTS)
def test_what_takes_too_much_is_asked_for_twice(command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch, what: str) -> None:
    words, said = FORECASTS[what]
    if what == "disk":
        monkeypatch.setattr(tables, "free_bytes", lambda path: 150_000)
    if what == "memory":
        monkeypatch.setattr(cost, "physical_memory", lambda: 1_000_000)
    done = command("run", pendulum, *words, "--step", "1e-6", "--json")
    assert done.exit_code == 2 and "--yes" in done.stderr and said in done.stderr and not Path("runs").exists()
    assert json.loads(done.stdout)["status"] == "refused"
    if not words:
        assert command("run", pendulum, "--yes", "--quiet").exit_code == 0


# ----------------------------------------------------------------------------------------------------------------- writers


def test_one_writer_at_a_time(command: Callable, pendulum: Path, kept: Path) -> None:
    before = contents(kept)
    holds, tells = os.pipe()
    child = os.fork()
    if not child:
        lock = Lock(kept)
        os.write(tells, b"x")
        time.sleep(60)
        lock.release()
        os._exit(0)
    os.read(holds, 1)
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
    first, second = place.placed(tmp_path / "r", model), place.placed(tmp_path / "r", model)
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
    both = [place.placed(None, Path("m.toml")) for _ in range(2)]
    for one in both:
        one.begin()
        (one.path / "model.toml").write_text("")
        RunFile.create(one.run_file).close()
    assert [str(one.settle().parent) for one in both] == ["runs/m", "runs/m-2"]
    for one in both:
        one.leave()


# ------------------------------------------------------------------------------------------------------------------ resume


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
        assert again["status"] == "complete" and again["measures"] == whole["measures"] and again["energy_error"] == whole["energy_error"]
    complete = command("resume", "a")
    assert complete.exit_code == 2 and "is complete; say how far" in complete.stderr
    other = command("run", pendulum, "-o", "a", "--resume", "--step", "1e-5")
    assert other.exit_code == 2 and "of another model, or of other options" in other.stderr
    further = command("resume", "a", "--until", "60 ms", "--json")
    assert further.exit_code == 0 and vfife.load_result("a").time[-1] == pytest.approx(0.06)
    assert vfife.load_model("a/model.toml").settings.duration == 0.06
    assert command("run", pendulum, "-o", "new", "--resume", "--quiet").exit_code == 0  # where there is none yet it begins


# ------------------------------------------------------------------------------------------------------------------ signals


def computing(process: int, seconds: float) -> None:
    """Waits until a process has computed for so long, however little of a processor it gets."""
    told = Path(f"/proc/{process}/stat")
    if not told.exists():
        time.sleep(1.0)
        return

    def spent() -> float:
        return sum(map(int, told.read_text().rpartition(")")[2].split()[11:13])) / os.sysconf("SC_CLK_TCK")

    began = spent()
    while spent() - began < seconds:
        time.sleep(0.02)


def patience() -> float:
    """Seconds within which a process has to end that may take two on a machine that does nothing else."""
    return 4.0 * max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
def test_signals_are_heard_between_outputs(process: Callable, command: Callable, pendulum: Path, tmp_path: Path, name: str, code: int) -> None:
    """One output for a run of hours: it ends within two seconds, and goes on from where it was."""
    began = process(
        "run", pendulum, "--outputs", "1", "--step", "1e-6", "--duration", "20000", "-o", "long", "--json", "--companions", "0", "--yes"
    )
    until = time.monotonic() + 60.0
    while not (tmp_path / "long" / "run.sqlite").exists():
        assert began.poll() is None and time.monotonic() < until, began.communicate()[1]
        time.sleep(0.02)
    computing(began.pid, 0.1)
    asked = time.monotonic()
    began.send_signal(getattr(signal, name))
    out, err = began.communicate(timeout=60)
    assert time.monotonic() - asked < patience()
    assert began.returncode == code, err
    assert "steps were made; they are kept in" in err and "Traceback" not in err and ("Ctrl-C" if name == "SIGINT" else name) in err
    if out:  # the summary itself was interrupted where there is none
        assert json.loads(out)["status"] == "interrupted"
    with RunFile.open(tmp_path / "long") as file:
        last = file.latest()
        assert last is not None and last.step > 1000 and len(file.steps) == 1
    assert not stages()


def test_a_signal_that_is_not_heard_ends_the_process_all_the_same(tmp_path: Path) -> None:
    """What a compiler in a library does: it sits in the main thread, and lets no signal through."""
    text = """
import ctypes, sys, time, pathlib
from vfife.cli import signals
with signals.Signals():
    signals.NOW.saved = "Nothing is lost."
    signals.NOW.last.append(lambda: pathlib.Path("left").write_text("x"))
    libc = ctypes.CDLL(None)
    for k in range(200):
        try:
            if k == 0:
                print("ready", flush=True)
            libc.usleep(900_000)
        except KeyboardInterrupt:
            pass
"""
    from cli.conftest import ENVIRONMENT, hear

    began = subprocess.Popen(
        [sys.executable, "-c", text], cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=hear
    )
    assert began.stdout is not None and began.stdout.readline() == "ready\n"
    asked = time.monotonic()
    began.send_signal(signal.SIGTERM)
    _, err = began.communicate(timeout=60)
    assert began.returncode == 143 and "Stopped by SIGTERM. Nothing is lost." in err
    assert 1.0 < time.monotonic() - asked < patience()
    assert (tmp_path / "left").read_text() == "x"


# ------------------------------------------------------------------------------------------------------------------ storage


def no_room(*args: Any, **named: Any) -> Any:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "somewhere")


def forbidden(*args: Any, **named: Any) -> Any:
    raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), "somewhere")


def broken_disk(*args: Any, **named: Any) -> Any:
    raise OSError(errno.EIO, os.strerror(errno.EIO), "somewhere")


WRITES = {
    "the folder": (place.Path, "mkdir", "nothing to keep"),
    "the lock": (place, "Lock", "nothing to keep"),
    "the move": (place.os, "rename", "nothing to keep"),
    "the summary": (carried, "json_text", ""),
    "the figures": (plots, "save", "The run itself is whole"),
}


@pytest.mark.parametrize("fault", [no_room, forbidden, broken_disk], ids=lambda fault: fault.__name__)
@pytest.mark.parametrize("what", ["the folder", "the lock", "the move", "the figures", "the summary"])
def test_every_write_in_turn(command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch, what: str, fault: Any) -> None:
    owner, name, said = WRITES[what]
    if what == "the summary":
        owner, name, said = folder.os, "replace", "The run itself is whole"
    with monkeypatch.context() as context:
        context.setattr(owner, name, fault)
        done = CliRunner().invoke(app, ["run", str(pendulum), "--json", *(["--figures"] if what == "the figures" else [])])
    assert done.exit_code == 5, (done.exit_code, done.stderr, done.exception)
    assert json.loads(done.stdout)["status"] == "storage"
    assert said in done.stderr and "Traceback" not in done.stderr and os.strerror(fault_number(fault)) in done.stderr
    assert not stages()
    if "whole" in said:
        assert vfife.load_result("runs/pendulum").record.status == "complete"
    else:
        assert not Path("runs").exists() or not list(Path("runs").iterdir())


def fault_number(fault: Any) -> int:
    try:
        fault()
    except OSError as error:
        return error.errno or 0
    return 0


@pytest.mark.parametrize("call", [3, 20, 25, 30])
def test_a_full_disk_in_the_run_file(command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    from results.test_resume import full_at

    with monkeypatch.context() as context:
        context.setattr(tables, "insert", full_at(call))
        done = command("run", pendulum, "--json", "--outputs", "2000", "--step", "1e-6")
    assert done.exit_code == 5, (done.exit_code, done.stderr, done.exception)
    assert "disk is full" in done.stderr and "bytes were to be written" in done.stderr and "Traceback" not in done.stderr
    assert json.loads(done.stdout)["status"] == "storage" and not stages()
    if Path("runs/pendulum").exists():
        assert "vfife resume runs/pendulum" in done.stderr
        again = command("resume", "runs/pendulum", "--json")
        assert again.exit_code in (0, 2), again.stderr
        assert vfife.load_result("runs/pendulum").record.status == "complete"
    else:
        assert "nothing to keep" in done.stderr


FILES = {
    "a model": ("new", "slider-crank", "--force", "-o", "out.toml"),
    "the schema": ("schema", "-o", "out.json"),
    "a law": ("laws", "hertz", "--plot", "-o", "out.png"),
    "a law, drawn": ("laws", "coulomb", "--plot", "-o", "out.svg"),
}


@pytest.mark.parametrize("fault", [no_room, forbidden, broken_disk], ids=lambda fault: fault.__name__)
@pytest.mark.parametrize("what", FILES)
def test_every_other_file_is_whole_or_as_it_was(command: Callable, monkeypatch: pytest.MonkeyPatch, what: str, fault: Any) -> None:
    words = FILES[what]
    Path(words[-1]).write_text("before")
    with monkeypatch.context() as context:
        context.setattr(os, "replace", fault)
        done = command(*words, *(["--json"] if words[0] == "laws" else []))
    assert done.exit_code == 5 and "bytes are free there" in done.stderr and "as it was" in done.stderr, (done.stderr, done.exception)
    assert os.strerror(fault_number(fault)) in done.stderr
    assert [path.name for path in Path().iterdir()] == [words[-1]] and Path(words[-1]).read_text() == "before"
    assert command(*words).exit_code == 0 and Path(words[-1]).read_text(errors="replace") != "before"


def test_a_page_of_the_paper_is_whole_or_as_it_was(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from vfife.paper.page import Folder
    from vfife.report.contents import Item

    place, item = Folder(tmp_path, ""), Item("table3", "Table 3", data={})
    place.add(item, str)
    before = contents(tmp_path)
    with monkeypatch.context() as context, pytest.raises(OSError, match="space"):
        context.setattr(os, "replace", no_room)
        place.add(item, str)
    assert contents(tmp_path) == before


MADE: list[memoryview] = []


def made_once(*args: Any, made: Any = netcdf._made) -> memoryview:
    """The bytes of an export, which are always the same here and take a quarter of a second."""
    if not MADE:
        MADE.append(made(*args))
    return MADE[0]


@pytest.mark.parametrize("fault", [no_room, forbidden, broken_disk], ids=lambda fault: fault.__name__)
@pytest.mark.parametrize("there", [False, True])
def test_an_export_is_whole_or_not_there(command: Callable, kept: Path, monkeypatch: pytest.MonkeyPatch, fault: Any, there: bool) -> None:
    monkeypatch.setattr(netcdf, "_made", made_once)
    if there:
        Path("out.nc").write_text("before")
    for owner, name in ((netcdf.Path, "open"), (netcdf.os, "replace"), (netcdf.os, "fsync")):
        with monkeypatch.context() as context:
            if name == "open":
                opened = Path.open
                context.setattr(Path, "open", lambda self, *a, opened=opened, **k: fault() if self.suffix == ".part" else opened(self, *a, **k))
            else:
                context.setattr(owner, name, fault)
            done = command("export", "kept", "out.nc", "--force")
        assert done.exit_code == 5, (done.stderr, done.exception)
        assert "The run is as it was" in done.stderr and "bytes are free there" in done.stderr
        assert not Path("out.nc.part").exists() and Path("out.nc").exists() == there
        assert not there or Path("out.nc").read_text() == "before"


def test_a_disk_that_fills_up_under_an_export(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A limit of the system's own: a child process whose files may have 20 kB."""
    child = os.fork()
    if not child:
        import resource

        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        os._exit(CliRunner().invoke(app, ["export", "kept", "out.nc"]).exit_code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 5
    assert not Path("out.nc").exists() and not Path("out.nc.part").exists()


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    yield tmp_path / "cache"


@pytest.mark.parametrize("fault", [no_room, forbidden, broken_disk], ids=lambda fault: fault.__name__)
def test_a_cache_that_cannot_be_written_costs_time_and_no_run(own_cache: Path, monkeypatch: pytest.MonkeyPatch, fault: Any) -> None:
    monkeypatch.setattr(cache.os, "replace", fault)
    cache.keep("step-1.o", b"code")
    assert cache.read("step-1.o") is None and list(own_cache.iterdir()) == []
