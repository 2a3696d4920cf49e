"""What a command says while it has nothing to count: one line after two seconds of silence, and no other."""

from __future__ import annotations

import re
import sys
import time
from io import StringIO
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.models import CASE_C
from vfife.cli.app import app
from vfife.job import activity
from vfife.job.activity import Activity
from vfife.job.progress import ProgressLine
from vfife.results.run_data import RunData


class Terminal(StringIO):
    """Standard error that is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Silence is long after a tenth of a second."""
    monkeypatch.setattr(activity, "PATIENCE", 0.1)
    monkeypatch.setattr(activity, "LOOK", 0.01)


def wait_for(text: str, stream: StringIO) -> str:
    """Everything on a stream once a text is there."""
    until = time.monotonic() + 10.0
    while text not in stream.getvalue() and time.monotonic() < until:
        time.sleep(0.01)
    return stream.getvalue()


@pytest.mark.usefixtures("hasty")
def test_a_silence_is_explained_once(monkeypatch: pytest.MonkeyPatch) -> None:
    error, doing = StringIO(), Activity()
    monkeypatch.setattr(sys, "stderr", error)
    with doing.watched("vfife export"):
        doing("writing a.csv", 60.0)
        said = wait_for("writing", error)
        time.sleep(0.2)
    assert (
        re.fullmatch(r"note: writing a.csv: \S+ s of about 1 min 00 s.\n", said) and said == error.getvalue()
    )
    time.sleep(0.2)
    assert said == error.getvalue()


@pytest.mark.usefixtures("hasty")
def test_short_parts_quiet_commands_and_progress_lines_are_not_explained(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    error, doing = StringIO(), Activity()
    monkeypatch.setattr(sys, "stderr", error)
    monkeypatch.setattr("vfife.job.progress.ACTIVITY", doing)
    with doing.watched("vfife plot"):
        for part in range(20):
            doing(f"drawing figure {part}")
            time.sleep(0.02)
        with ProgressLine(quiet=False):
            time.sleep(0.3)
        with doing.watched("a command within another one"):
            pass
        assert doing.stop is not None
    with doing.watched("vfife run", quiet=True):
        time.sleep(0.3)
    assert error.getvalue() == ""


@pytest.mark.usefixtures("hasty")
def test_a_command_without_a_part_has_its_own_time_after_a_progress_line(monkeypatch) -> None:
    """The line after 70 s of work says 70 s, not the 2 s since the last line of progress."""
    error, doing = StringIO(), Activity()
    monkeypatch.setattr(sys, "stderr", error)
    monkeypatch.setattr("vfife.job.progress.ACTIVITY", doing)
    with doing.watched("vfife design"):
        with ProgressLine(quiet=True):
            doing.command_began -= 70.0
        said = wait_for("so far", error)
    assert said.startswith("note: vfife design: 1 min 10 s so far"), said


@pytest.mark.usefixtures("hasty")
def test_the_line_of_a_terminal_is_erased(monkeypatch: pytest.MonkeyPatch) -> None:
    error, doing = Terminal(), Activity()
    monkeypatch.setattr(sys, "stderr", error)
    monkeypatch.setattr(activity, "on_terminal", lambda: True)
    with doing.watched("vfife report"):
        said = wait_for(" s so far", error)
        assert said.startswith("\rvfife report: 0.") and "note" not in said and "\n" not in said
    line = error.getvalue().rpartition("\r")[0].rpartition("\r")[2]
    assert line and not line.strip() and error.getvalue().endswith("\r")


@pytest.mark.usefixtures("hasty")
def test_a_command_says_which_part_of_its_work_takes_long(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """All commands have it from one place: the function that typer calls."""
    monkeypatch.chdir(tmp_path)
    runner, column = CliRunner(), RunData.channels.func
    short = ["--set", "run.turns=0.05", "--companions", "0", "-q"]
    assert runner.invoke(app, ["run", str(CASE_C), "-o", "a", *short]).exit_code == 0

    def slow(view: RunData) -> object:
        time.sleep(0.5)
        return column(view)

    monkeypatch.setattr(RunData.channels, "func", slow)
    done = runner.invoke(app, ["export", "a", "a.csv"])
    assert done.exit_code == 0 and "note: writing a.csv" in done.stderr
    assert activity.ACTIVITY.stop is None
