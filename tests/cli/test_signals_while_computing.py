"""Ctrl-C, SIGTERM and SIGHUP while a run computes, or while a library hears nothing: it ends soon, and keeps
what it has.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cli.conftest import ENVIRONMENT, hear
from cli.folders import stages
from vfife.cli import signals
from vfife.store.runfile import RunFile


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


@pytest.mark.system("starts processes and sends them signals")
@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
def test_signals_are_heard_between_outputs(
    process: Callable, command: Callable, pendulum: Path, tmp_path: Path, name: str, code: int
) -> None:
    """One output for a run of hours: it ends within two seconds, and goes on from where it was."""
    began = process(
        "run",
        pendulum,
        "--outputs",
        "1",
        "--step",
        "1e-6",
        "--duration",
        "20000",
        "-o",
        "long",
        "--json",
        "--companions",
        "0",
        "--yes",
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
    assert (
        "steps were made; they are kept in" in err
        and "Traceback" not in err
        and ("Ctrl-C" if name == "SIGINT" else name) in err
    )
    if out:  # the summary itself was interrupted where there is none
        assert json.loads(out)["status"] == "interrupted"
    with RunFile.open(tmp_path / "long") as file:
        last = file.latest()
        assert last is not None and last.step > 1000 and len(file.steps) == 1
    assert not stages()


@pytest.mark.system("starts a process and sends it a signal")
def test_a_signal_that_is_not_heard_ends_the_process_all_the_same(tmp_path: Path) -> None:
    """What a compiler in a library does: it sits in the main thread, and lets no signal through."""
    text = """
import ctypes, sys, time, pathlib
from vfife.cli import signals
with signals.Signals():
    signals.ENDING.saved = "Nothing is lost."
    signals.ENDING.last.append(lambda: pathlib.Path("left").write_text("x"))
    libc = ctypes.CDLL(None)
    for k in range(200):
        try:
            if k == 0:
                print("ready", flush=True)
            libc.usleep(900_000)
        except KeyboardInterrupt:
            pass
"""
    began = subprocess.Popen(
        [sys.executable, "-c", text],
        cwd=tmp_path,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=hear,
    )
    assert began.stdout is not None and began.stdout.readline() == "ready\n"
    asked = time.monotonic()
    began.send_signal(signal.SIGTERM)
    _, err = began.communicate(timeout=60)
    assert began.returncode == 143 and "Stopped by SIGTERM. Nothing is lost." in err
    assert 1.0 < time.monotonic() - asked < patience()
    assert (tmp_path / "left").read_text() == "x"


SIGNALLED_TWICE = """
import os, signal, time
from vfife.cli import signals
from vfife.solvers.interrupts import Interrupts
def noted():
    with Interrupts() as halt:
        os.kill(os.getpid(), signal.SIGTERM)
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.1)
        halt.look()
with signals.Signals():
    signals.ENDING.grace = signals.ANSWER_GRACE
    try:
        {first}
    except KeyboardInterrupt:
        try:
            {second}
            print("kept", flush=True)
        except KeyboardInterrupt:
            print("lost", flush=True)
"""
KILL = "os.kill(os.getpid(), signal.SIGTERM)"


@pytest.mark.system("starts a process that sends itself signals")
@pytest.mark.parametrize(
    ("first", "second", "code", "out"),
    [
        (KILL, KILL, 0, "kept\n"),  # as of the program timeout
        (KILL, f"time.sleep(0.5); {KILL}", 143, ""),
        (KILL, f"time.sleep({signals.GRACE + 0.6})", 0, "kept\n"),  # an answer that takes so long
        ("noted()", "pass", 0, "kept\n"),
    ],
)
def test_a_command_writes_its_answer_after_a_signal(
    tmp_path: Path, first: str, second: str, code: int, out: str
) -> None:
    text = SIGNALLED_TWICE.format(first=first, second=second)
    done = subprocess.run(
        [sys.executable, "-c", text], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True,
        preexec_fn=hear, timeout=60,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (code, out), done.stderr
