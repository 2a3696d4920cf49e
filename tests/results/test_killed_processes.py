"""Processes killed with -9 at random moments leave run files that go on to the bit."""

from __future__ import annotations

import os
import random
import signal
import time
from pathlib import Path

import pytest

import vfife
from results.killed import arch, same, write
from support import four_bar
from vfife.errors import RunFileError
from vfife.solvers import interrupts
from vfife.solvers.arguments import RunArguments
from vfife.store.runfile import RunFile

RANDOM = random.Random(5)


def child(path: Path, mechanism: vfife.Mechanism, asked: RunArguments) -> int:
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


def killed_at_random(
    folder: Path, mechanism: vfife.Mechanism, asked: RunArguments, kills: int, longest: float
) -> int:
    """Kills with -9 at random moments, the very first and last included, until the run is complete; how many
    there were.
    """
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
        "transient": (four_bar("BC"), RunArguments(turns=2.0, step=2.5e-6, outputs=100, companions=3)),
        "static": (arch(), RunArguments()),
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


@pytest.mark.system("kills twenty processes")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_twenty_kills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "SECONDS", 5e-3)
    kill_and_compare(tmp_path, 20)


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_hundred_kills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "SECONDS", 5e-3)
    kill_and_compare(tmp_path, 100)
