"""Ctrl-C, SIGTERM and SIGHUP at any moment of a process: a sentence, an exit code, no traceback.

The moment is held: a module of a library's name that says so and waits for a line, in front of the library's
own. Nothing waits for a clock.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from cli.conftest import ENVIRONMENT, hear
from vfife.cli import signals

CODES = {"SIGINT": 130, "SIGTERM": 143, "SIGHUP": 129}


@pytest.mark.parametrize("name", CODES)
def test_while_the_command_line_is_loaded(held: Callable, name: str) -> None:
    process = held("typer", "run", "model.toml", "--json")
    process.send_signal(getattr(signal, name))
    out, err = process.communicate("on\n", timeout=60)
    by = "Ctrl-C" if name == "SIGINT" else name
    assert (process.returncode, err) == (
        CODES[name],
        f"interrupted: Stopped by {by}. Nothing was started, so there is nothing to keep.\n",
    )
    assert json.loads(out) == {
        "status": "interrupted",
        "faults": [{"what": err.removeprefix("interrupted: ").strip()}],
    }


def test_while_what_a_command_needs_is_loaded(held: Callable, pendulum: Path) -> None:
    process = held("numpy", "run", pendulum)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate("on\n", timeout=60)
    assert (
        process.returncode == 143
        and "Stopped by SIGTERM" in err
        and "nothing to keep" in err
        and "Traceback" not in err
    )
    assert not (pendulum.parent / "runs").exists()


@pytest.mark.parametrize(
    "before", ["sys.modules['vfife.files'] = sys", "signals.ENDING.last.append(lambda: 1 / 0)"]
)
def test_the_sentence_is_printed_whatever_the_cleaning_up_finds(before: str) -> None:
    """A module that is half imported lacks its functions; a lock may be gone."""
    text = f"import sys\nfrom vfife.cli import signals\n{before}\nsignals.end_at_once()"
    done = subprocess.run([sys.executable, "-c", text], env=ENVIRONMENT, text=True, capture_output=True)
    assert (done.returncode, done.stderr) == (
        130,
        "interrupted: Stopped by Ctrl-C. Nothing was started, so there is nothing to keep.\n",
    )


@pytest.mark.system("starts a process and sends it signals")
def test_a_second_one_while_the_first_is_told(held: Callable, pendulum: Path) -> None:
    """What tells it is loaded only then, and may not be done when somebody presses Ctrl-C again."""
    process = held("rich", "run", pendulum, "-o", pendulum)
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGHUP)
    _, err = process.communicate("on\n", timeout=60)
    assert process.returncode in (129, 130) and "interrupted: Stopped by" in err and "Traceback" not in err


@pytest.mark.system("starts a process and sends it a signal")
def test_while_figures_are_drawn(held: Callable, pendulum: Path) -> None:
    process = held("matplotlib", "run", pendulum, "--figures", "-o", "out", "--json", "--duration", "0.001")
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate("on\n", timeout=60)
    assert (
        process.returncode == 143
        and "Stopped by SIGTERM. The run itself is complete, in out." in err
        and "Traceback" not in err
    )
    assert json.loads(out)["status"] == "interrupted"
    assert (pendulum.parent / "out" / "summary.json").exists() and not (
        pendulum.parent / "out" / "run.lock"
    ).exists()


def test_one_that_comes_when_all_is_done_changes_nothing(held: Callable, tmp_path: Path) -> None:
    """The process ends as it was about to: what it was asked for is printed."""
    (tmp_path / "before").mkdir()
    text = (
        "import atexit, os, sys\natexit.register(lambda: (os.write(2, b'at its end\\n'),"
        " sys.stdin.readline()))\n"
    )
    (tmp_path / "before" / "sitecustomize.py").write_text(text)
    environment = ENVIRONMENT | {
        "PYTHONPATH": os.pathsep.join((str(tmp_path / "before"), ENVIRONMENT["PYTHONPATH"]))
    }
    line = [sys.executable, "-m", "vfife", "new"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(line, env=environment, text=True, preexec_fn=hear, **pipes)
    assert process.stderr is not None and process.stderr.readline() == "at its end\n"
    for name in CODES:
        process.send_signal(getattr(signal, name))
    out, err = process.communicate("on\n", timeout=60)
    assert process.returncode == 0 and "slider" in out and not err


@pytest.mark.parametrize("text", ["plain", 'a "quoted" \\ path', "new\nline", "Zürich 𝔸", "\x00\x7f"])
def test_what_is_printed_without_a_library_is_json(text: str) -> None:
    assert json.loads(signals.quoted(text)) == text
