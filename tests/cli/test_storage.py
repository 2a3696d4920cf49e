"""A disk that is full, broken or forbidden: every file is whole or as it was, and a sentence says what is
kept.
"""

from __future__ import annotations

import errno
import json
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import vfife
from cli.folders import contents, stages
from results.killed import full_at
from vfife import files, plots
from vfife.cli.app import app
from vfife.cli.commands import run as of_a_run
from vfife.compiler.runtime import cache
from vfife.results import export
from vfife.store import folder
from vfife.store.runfile import RunFile


@pytest.fixture
def kept(command: Callable, pendulum: Path) -> Path:
    """A run in the empty folder."""
    assert command("run", pendulum, "-o", "kept", "--quiet").exit_code == 0
    return Path("kept")


def no_room(*args: Any, **named: Any) -> Any:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "somewhere")


def forbidden(*args: Any, **named: Any) -> Any:
    raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), "somewhere")


def broken_disk(*args: Any, **named: Any) -> Any:
    raise OSError(errno.EIO, os.strerror(errno.EIO), "somewhere")


def only_summaries(fault: Callable[..., Any]) -> Callable[..., Any]:
    """``os.replace`` that fails where a summary is put in its place; the run file before it is written."""
    real = os.replace
    return lambda source, place: fault() if Path(place).name == "summary.json" else real(source, place)


WRITES = {
    "the folder": (folder.Path, "mkdir", "nothing to keep"),
    "the lock": (folder, "Lock", "nothing to keep"),
    "the move": (folder.os, "rename", "nothing to keep"),
    "the summary": (of_a_run, "json_text", ""),
    "the figures": (plots, "save", "The run itself is complete"),
}


@pytest.mark.system("a full disk at each write in turn")
@pytest.mark.parametrize("fault", [no_room, forbidden, broken_disk], ids=lambda fault: fault.__name__)
@pytest.mark.parametrize("what", ["the folder", "the lock", "the move", "the figures", "the summary"])
def test_every_write_in_turn(
    command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch, what: str, fault: Any
) -> None:
    owner, name, said = WRITES[what]
    if what == "the summary":
        owner, name, said = files.os, "replace", "The run itself is complete"
    with monkeypatch.context() as context:
        context.setattr(owner, name, only_summaries(fault) if what == "the summary" else fault)
        done = CliRunner().invoke(
            app, ["run", str(pendulum), "--json", *(["--figures"] if what == "the figures" else [])]
        )
    assert done.exit_code == 5, (done.exit_code, done.stderr, done.exception)
    assert json.loads(done.stdout)["status"] == "storage"
    assert (
        said in done.stderr
        and "Traceback" not in done.stderr
        and os.strerror(fault_number(fault)) in done.stderr
    )
    assert not stages()
    if "complete" in said:
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
def test_a_full_disk_in_the_run_file(
    command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch, call: int
) -> None:
    with monkeypatch.context() as context:
        context.setattr(RunFile, "insert", full_at(call))
        done = command("run", pendulum, "--json", "--outputs", "2000", "--step", "1e-6")
    assert done.exit_code == 5, (done.exit_code, done.stderr, done.exception)
    assert (
        "disk is full" in done.stderr
        and "bytes are free there" in done.stderr
        and "Traceback" not in done.stderr
    )
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
@pytest.mark.usefixtures("unrendered")
def test_every_other_file_is_whole_or_as_it_was(
    command: Callable, monkeypatch: pytest.MonkeyPatch, what: str, fault: Any
) -> None:
    words = FILES[what]
    Path(words[-1]).write_text("before")
    with monkeypatch.context() as context:
        context.setattr(os, "replace", fault)
        done = command(*words, *(["--json"] if words[0] == "laws" else []))
    assert done.exit_code == 5 and "unchanged" in done.stderr, (done.stderr, done.exception)
    assert ("bytes are free there" in done.stderr) == (fault is not forbidden), done.stderr
    assert os.strerror(fault_number(fault)) in done.stderr
    assert [path.name for path in Path().iterdir()] == [words[-1]] and Path(words[-1]).read_text() == "before"
    assert command(*words).exit_code == 0 and Path(words[-1]).read_text(errors="replace") != "before"


def test_a_page_of_the_paper_is_whole_or_as_it_was(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from vfife_validation.paper.contents import Item
    from vfife_validation.paper.page import Folder

    place, item = Folder(tmp_path, ""), Item("table3", "Table 3", data={})
    place.add(item, str)
    before = contents(tmp_path)
    with monkeypatch.context() as context, pytest.raises(OSError, match="space"):
        context.setattr(os, "replace", no_room)
        place.add(item, str)
    assert contents(tmp_path) == before


MADE: list[memoryview] = []


def made_once(*args: Any, made: Any = export._in_memory) -> memoryview:
    """The bytes of an export, which are always the same here and take a quarter of a second."""
    if not MADE:
        MADE.append(made(*args))
    return MADE[0]


@pytest.mark.parametrize("fault", [no_room, forbidden, broken_disk], ids=lambda fault: fault.__name__)
@pytest.mark.parametrize("there", [False, True])
def test_an_export_is_whole_or_not_there(
    command: Callable, kept: Path, monkeypatch: pytest.MonkeyPatch, fault: Any, there: bool
) -> None:
    monkeypatch.setattr(export, "_in_memory", made_once)
    if there:
        Path("out.nc").write_text("before")
    for owner, name in ((files.Path, "open"), (files.os, "replace"), (files.os, "fsync")):
        with monkeypatch.context() as context:
            if name == "open":
                opened = Path.open
                context.setattr(
                    Path,
                    "open",
                    lambda self, *a, opened=opened, **k: (
                        fault() if self.suffix == ".part" else opened(self, *a, **k)
                    ),
                )
            else:
                context.setattr(owner, name, fault)
            done = command("export", "kept", "out.nc", "--force")
        assert done.exit_code == 5, (done.stderr, done.exception)
        assert "The run is unchanged" in done.stderr and ("bytes are free there" in done.stderr) == (
            fault is not forbidden
        )
        assert not list(Path().glob(".*.part")) and Path("out.nc").exists() == there
        assert not there or Path("out.nc").read_text() == "before"


def test_a_disk_that_fills_up_under_an_export(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A limit of the system's own: a child process whose files may have 20 kB."""
    child = os.fork()
    if not child:
        import resource

        code = -1
        try:  # whatever happens, the child ends here and runs no tests of its own
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
            code = CliRunner().invoke(app, ["export", "kept", "out.nc"]).exit_code
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 5
    assert not Path("out.nc").exists() and not list(Path().glob(".*.part"))


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    yield tmp_path / "cache"


@pytest.mark.parametrize("fault", [no_room, forbidden, broken_disk], ids=lambda fault: fault.__name__)
def test_a_cache_that_cannot_be_written_costs_time_and_no_run(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch, fault: Any
) -> None:
    monkeypatch.setattr(cache.os, "replace", fault)
    cache.keep("step-1.o", b"code")
    assert cache.read("step-1.o") is None and list(own_cache.iterdir()) == []
