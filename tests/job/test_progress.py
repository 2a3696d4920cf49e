"""Progress that a script sees: a line below a notebook cell, a bar on a terminal, elsewhere a line every ten
seconds.
"""

import sys
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import vfife
from dynamics.test_map_arguments import PATH, QUICK, oscillator
from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime import cache
from vfife.job import progress
from vfife.job.cost import Forecast, timed_step
from vfife.job.job import Job, job_of
from vfife.job.progress import Counter, ProgressLine, ScriptLine, amount_of_bytes, script_line, span
from vfife.solvers.status import Progress
from vfife.solvers.transient import Stepping
from vfife.store.runfile import RunFile

STUDY = {"turns": 2, "step": 2e-4}


class Notebook:
    """What IPython shows below a cell."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def display(self, one: object, display_id: bool) -> "Notebook":
        assert display_id
        self.update(one)
        return self

    def update(self, one: object) -> None:
        self.texts.append(repr(one))


@pytest.fixture
def notebook(monkeypatch):
    """A notebook in which each piece of work lasts long enough to be shown."""
    shell = type("ZMQInteractiveShell", (), {})()
    ipython, display, cell = ModuleType("IPython"), ModuleType("IPython.display"), Notebook()
    ipython.get_ipython, display.display = lambda: shell, cell.display
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr(progress, "PATIENCE", -1.0)
    return cell


def test_a_notebook_shows_the_progress_of_studies_and_maps(notebook):
    vfife.study(oscillator(), {PATH: [1.0, 1.5, 2.0]}, ["max(block.x)"], **STUDY)
    assert notebook.texts[0] == "..." and notebook.texts[-1].startswith("100 %  3 of 3 cases")
    notebook.texts.clear()
    vfife.dynamics.bifurcation(oscillator(), PATH, 1.0, 2.0, **QUICK)
    assert notebook.texts[-1].startswith("100 %  2 of 2 values")
    notebook.texts.clear()
    vfife.dynamics.poincare_section(oscillator(), turns=60, step=2e-4, series=["block.x"])
    assert notebook.texts[-1].startswith("100 %  60 of 60 turns")


def test_a_terminal_has_a_bar_at_once_and_a_file_lines_after_ten_seconds(monkeypatch, capsys):
    """Work of a script whose output goes to a file is not silent for minutes; short work is."""
    monkeypatch.setattr(sys, "stderr", None)
    assert script_line() is None and ScriptLine().make is None
    monkeypatch.undo()
    assert isinstance(script_line()(), ProgressLine)
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock.now)
    line, count = ScriptLine(), Counter("values", 0.0)
    for clock.now, done in ((9.0, 1), (11.0, 2), (12.0, 3), (22.0, 4)):
        line(count(done, 4))
    line.close()
    texts = capsys.readouterr().err.splitlines()
    assert len(texts) == 3 and texts[0].startswith(" 50 %  2 of 4 values"), "the first line comes at once"
    assert texts[1].startswith("100 %  4 of 4 values") and texts[1] == texts[2], texts


def test_what_follows_the_last_step_is_shown(monkeypatch, capsys):
    """A long run was silent for 40 s after 100 %, while turns were compared and measures taken."""
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock.now)
    line = ScriptLine()
    for clock.now in (2.0, 12.0):
        line(Progress(10, 10, 2.0))
        line.phase("comparing turns")
    line.close()
    texts = capsys.readouterr().err.splitlines()
    end = "100 %  10 of 10 steps  5 steps/s  in 2 s"
    assert texts == [end, f"{end}; comparing turns", end], "nothing of short work"


def test_a_run_shows_what_it_computes_after_its_last_step(monkeypatch, capsys, tmp_path):
    for name in ("PATIENCE", "PLAIN_SECONDS"):
        monkeypatch.setattr(progress, name, -1.0)
    vfife.simulate(four_bar("C"), turns=0.2, step=2e-6, reference=False, file=tmp_path / "a.run")
    texts = capsys.readouterr().err.splitlines()
    steps = next(k for k, text in enumerate(texts) if text.startswith("100 %"))
    assert [text.partition("; ")[2] for text in texts[steps:]] == [
        "", "comparing turns and steps", "taking measures and their ranges", ""
    ]  # fmt: skip


def test_the_time_of_a_run_includes_the_time_to_write_it(monkeypatch, tmp_path):
    """A run that is written as slowly as it is stepped takes twice as long as its steps."""
    calls, append = [], RunFile.append

    def slow(*args, **named):
        time.sleep(0.1)
        return append(*args, **named)

    monkeypatch.setattr(RunFile, "append", slow)
    vfife.simulate(
        four_bar("C"), turns=0.2, step=2e-6, reference=False, companions=0, file=tmp_path / "a.run",
        progress=calls.append,
    )  # fmt: skip
    assert calls[-1].done == calls[-1].steps and calls[-1].seconds >= 0.1 * len(calls)


def test_a_script_is_told_how_long_it_takes(capsys):
    """From ten seconds on; nothing of shorter work."""
    job_of("bifurcation", None, False, None).begin(Forecast("value", 40, 1e6, seconds=240.0))
    assert "bifurcation: 40 values" in capsys.readouterr().err
    job_of("bifurcation", None, False, None).begin(Forecast("value", 4, 1e4, seconds=2.0))
    assert capsys.readouterr().err == ""


def test_the_remaining_time_is_shown_once_later_items_show_it(monkeypatch):
    """The first item includes the preparation. A piece of work with its own items begins anew."""
    now, shown = [100.0], list[Progress]()
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    job = Job("design", None, False, shown.append)

    def text(seconds: float, done: int, total: int, noun: str = "values") -> str:
        now[0] += seconds
        job.count(done, total, noun)
        return shown[-1].text

    assert text(10.0, 1, 5) == "1 of 5 values" and text(4.0, 2, 5) == "2 of 5 values"
    assert text(4.0, 3, 5) == "3 of 5 values  0.25 values/s  8 s left"
    text(4.0, 4, 5)
    assert text(4.0, 5, 5) == "5 of 5 values  0.192 values/s  in 26 s"
    assert text(10.0, 1, 8) == "1 of 8 values" and text(10.0, 1, 1, "machines").endswith("in 10 s")


def test_the_remaining_time_of_a_search_is_not_known(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    count = Counter("cases", 0.0, limit=700)
    for done in range(1, 10):
        now[0] += 1.0
        text = count(done, 300).text
    assert text == "9 of 300 cases  1 cases/s  700 at most"


def test_a_long_wait_leaves_no_wrong_remaining_time(monkeypatch):
    """A second compilation of 24 s is no measure of the items after it."""
    now, count = [0.0], Counter("runs", 0.0)
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    for item in range(1, 600):
        now[0] += {1: 5.0, 40: 24.0}.get(item, 0.5)
        text, left = count(item, 600).text, 0.5 * (600 - item)
        assert "left" not in text or item < 40 or item > 180
        if item > 300:
            assert "2 runs/s" in text and f"{span(left)} left" in text


def test_the_preparation_of_many_items_is_not_counted_in_their_rate(monkeypatch):
    """Eight lanes that take 2 s after 8 s of preparation: 4 items/s, not one; at the end the mean of all."""
    now, count, texts = [0.0], Counter("starts", 0.0), []
    monkeypatch.setattr("vfife.job.progress.time.monotonic", lambda: now[0])
    for batch in range(5):
        for item in range(8):
            now[0] = 10.0 + 2.0 * batch + 0.01 * item
            texts.append(count(8 * batch + item + 1, 40).text)
    assert texts[7] == "8 of 40 starts" and texts[16] == "17 of 40 starts  4 starts/s  5.8 s left"
    assert texts[23] == "24 of 40 starts  4 starts/s  4 s left"
    assert texts[39] == "40 of 40 starts  2.21 starts/s  in 18 s"


def test_a_script_is_told_that_ctrl_c_ended_its_work(capsys: pytest.CaptureFixture[str]) -> None:
    """It goes on with what was computed until then."""

    def interrupt(progress: Progress) -> None:
        raise KeyboardInterrupt

    result = vfife.simulate(four_bar("C"), turns=2, progress=interrupt, reference=False, companions=0)
    assert result.record.status == "interrupted"
    sentence = "simulate() was interrupted; it returns the results computed until then.\n"
    assert capsys.readouterr().err == sentence


def test_a_script_that_resumes_is_told_that_ctrl_c_ended_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def interrupt(progress: Progress) -> None:
        raise KeyboardInterrupt

    path = tmp_path / "run.sqlite"
    begun = vfife.simulate(four_bar("C"), turns=2, progress=interrupt, reference=False, companions=0)
    begun.save(path)
    capsys.readouterr()
    again = vfife.resume(path, progress=interrupt)
    assert again.record.status == "interrupted" and again.record.reached >= begun.record.reached
    said = "resume() was interrupted; it returns the results computed until then.\n"
    assert capsys.readouterr().err == said


def test_ctrl_c_during_a_forecast_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its short runs end with a status; the long one would begin after them."""
    begun = []

    def interrupt(stepping: Stepping, progress: object) -> str:
        begun.append(stepping.assembly.choice.outputs)
        raise KeyboardInterrupt

    monkeypatch.setattr(Stepping, "to_the_end", interrupt)
    with pytest.raises(KeyboardInterrupt):
        timed_step(assemble(four_bar("C"), turns=2))
    assert len(begun) == 1


def test_long_times_and_large_files_have_readable_numbers() -> None:
    assert span(99.0 * 3600.0) == "99 h 00 min" and span(31569.7 * 3600.0) == "1,315 days"
    assert amount_of_bytes(3.114e15) == "3,110 TB"
    run = Forecast("run", 1, 1e6)
    assert run.amount == "1 run of 1,000,000 steps"


def test_a_script_reports_that_a_step_is_compiled(monkeypatch, capsys):
    """Once for each kind of mechanism; a caller with a function of its own sees what it shows itself."""
    monkeypatch.setattr(cache, "read", lambda name: None)
    monkeypatch.setattr(cache, "keep", lambda name, content: None)
    for function, count in ((None, 1), (lambda state: None, 0)):
        with job_of("fit", None, False, function):
            cache.stored("a step", lambda: b"")
        assert capsys.readouterr().err.count("compiling the step") == count
    cache.stored("a step", lambda: b"")
    assert not capsys.readouterr().err
