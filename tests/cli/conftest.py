"""The command line in this process, and in one of its own."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from cli.models import CASE_C, PENDULUM, ROOT
from vfife.cli.app import app
from vfife.job import activity

HELD = """
import os, sys
os.write(2, b"{what} is held\\n")
sys.stdin.readline()
"""
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "src"), "MPLBACKEND": "agg"}


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    """Runs a command in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    """A model that runs in no time."""
    path = tmp_path / "pendulum.toml"
    path.write_text(PENDULUM)
    return path


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made and written, as empty pictures of their format: what is seen on them is not what these
    tests look at.
    """
    from matplotlib.figure import Figure

    written = Figure.savefig
    monkeypatch.setattr(
        Figure, "savefig", lambda self, *where, **how: written(Figure((0.1, 0.1)), *where, **how)
    )


@pytest.fixture(autouse=True)
def fast(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a machine that is slow today commands say no more than elsewhere: tests/job looks at what they say
    of a silence.
    """
    monkeypatch.setattr(activity, "PATIENCE", math.inf)


@pytest.fixture(scope="module", autouse=True)
def coarse() -> Iterator[None]:
    """Figures have an eighth of the dots that they have for a user, which is most of the time that a picture
    takes to be written.
    """
    from vfife.plots.style import STYLE

    with pytest.MonkeyPatch.context() as context:
        context.setitem(STYLE, "savefig.dpi", 56)
        yield


@pytest.fixture(scope="session")
def case_c_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of one turn of case c."""
    folder = tmp_path_factory.mktemp("runs") / "case c"
    done = CliRunner().invoke(app, ["run", str(CASE_C), "--turns", "1", "-o", str(folder), "--quiet"])
    assert done.exit_code == 0, done.stderr
    return folder


def hear() -> None:
    """Signals as a terminal gives them: what the tests' own process was started to ignore, by nohup or in the
    background, a child would too.
    """
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        signal.signal(getattr(signal, name), signal.SIG_DFL)


def start(*words: Any, cwd: Path) -> subprocess.Popen[str]:
    """``python -m vfife`` in a process of its own, which hears signals even where this one does not."""
    line = [sys.executable, "-m", "vfife", *map(str, words)]
    return subprocess.Popen(
        line,
        cwd=cwd,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=hear,
    )


@pytest.fixture
def process(tmp_path: Path) -> Callable[..., subprocess.Popen[str]]:
    """Starts a command in a process of its own, in an empty folder."""
    return lambda *words: start(*words, cwd=tmp_path)


@pytest.fixture
def held(tmp_path: Path) -> Callable[..., subprocess.Popen[str]]:
    """``vfife`` in a process that stops where it imports a module of a name, and is there."""

    def begun(what: str, *words: object) -> subprocess.Popen[str]:
        before = tmp_path / "before"
        before.mkdir()
        (before / f"{what}.py").write_text(HELD.format(what=what))
        environment = ENVIRONMENT | {"PYTHONPATH": os.pathsep.join((str(before), ENVIRONMENT["PYTHONPATH"]))}
        line = [sys.executable, "-m", "vfife", *map(str, words)]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        process = subprocess.Popen(line, cwd=tmp_path, env=environment, text=True, preexec_fn=hear, **pipes)
        assert process.stderr is not None
        told = iter(process.stderr.readline, f"{what} is held\n")
        assert "Traceback" not in "".join(told)
        return process

    return begun
