"""The answer of a run without a crank of constant speed states the speed that a torque reaches, or the turns
that a crank makes that runs up.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

import vfife
from model_texts import FALLING, FLYWHEEL
from vfife.cli.app import app
from vfife.modelfile import loads
from vfife.report.overview import heading_sentence
from vfife.report.run import document
from vfife.report.terminal import as_text

ROOT = Path(__file__).parents[2]

WHEEL = FLYWHEEL.format(run='duration = "2 s"', driver=FALLING)


def test_a_flywheel_under_a_motor_curve() -> None:
    """Torque 2 N m (1 - w/w0) on an inertia I: w = w0 (1 - exp(-2 N m t/(I w0)))."""
    result = vfife.simulate(loads(WHEEL))
    speed = 50.0 * (1.0 - math.exp(-2.0 * 2.0 / (0.1 * 50.0)))
    reached = result.summary["run"]["reached"]["wheel"]
    assert reached["end"] == reached["high"] == pytest.approx(speed, rel=1e-4) and reached["low"] == 0.0
    text = " ".join(str(result).split())
    assert f"Speed wheel {speed:.4g} rad/s ({30.0 * speed / math.pi:.4g} rpm) at the end" in text
    assert f"least 0 rad/s, largest {speed:.4g} rad/s (not estimated)" in text


def test_a_crank_of_constant_speed_has_none() -> None:
    result = vfife.simulate(vfife.gallery.scotch_yoke(), turns=1, companions=0)
    assert "reached" not in result.summary["run"]


def test_a_crank_that_runs_up_is_headed_by_the_turns_that_it_makes() -> None:
    """600 rpm after a ramp of 0.2 s: five turns in 0.6 s, of which the run-up has one instead of two."""
    speed = 20.0 * math.pi
    changes = [("driver.crank.speed", speed), ("driver.crank.ramp", 0.2)]
    model = vfife.load_model(ROOT / "examples" / "slider_crank.toml", set=changes)
    summary = vfife.simulate(model, duration=0.6).summary
    assert summary["run"]["turns"] == pytest.approx(6.0)
    assert summary["run"]["crank_turns"] == pytest.approx(5.0, rel=1e-12)
    assert " · 5 turns · " in heading_sentence(summary)
    assert "(600 ms, 5 turns)" in as_text(document(summary), 200)
    steady = vfife.simulate(vfife.load_model(ROOT / "examples" / "slider_crank.toml"), turns=2).summary
    assert "crank_turns" not in steady["run"] and " · 2 turns · " in heading_sentence(steady)
    late = dataclasses.replace(model, start=dataclasses.replace(model.start, time=0.2))
    assert late.crank_turns(0.1, 0.4) is None and late.crank_turns(None, 0.4) is None
    assert model.crank_turns(0.1, 0.2) == pytest.approx(1.0)
    change = [f"--set=driver.crank.{key}" for key in (f"speed={speed!r}", "ramp=0.2")]
    done = CliRunner().invoke(
        app, ["check", str(ROOT / "examples/slider_crank.toml"), "--duration", "0.6", *change]
    )
    assert "= 6 turns at full speed; the run-up leaves 5; an output" in " ".join(done.stdout.split())


@pytest.mark.parametrize(("start", "words"), [("0 rad/s", ""), ("-60 rad/s", ""), ("60 rad/s", "573 rpm")])
def test_a_motor_faster_than_its_curve_has_a_caution(start: str, words: str) -> None:
    """Beyond the last place the torque is zero: a wheel that begins at 60 rad/s keeps its speed."""
    text = WHEEL.replace('mass = "5 kg"', f'mass = "5 kg"\nvelocity = [0, 0, "{start}"]')
    texts = vfife.simulate(loads(text)).summary["warnings"]
    beyond = [text for text in texts if "its curve ends" in text]
    if start.startswith("-"):
        words = "-573 rpm; its curve ends at 0 rpm and keeps 2 N m beyond"
    assert len(beyond) == bool(words) and words in "".join(beyond)
