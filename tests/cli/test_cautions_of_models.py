"""Every command that computes with a model says once what is doubtful about its numbers."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import vfife
from cli.models import ROOT

Command = Callable[..., Any]
LOOSE = ROOT / "examples" / "slider_crank_loose_pin.toml"
HEAVY = "--set", "gravity=[0, -9810]"
WORDS = "1,000 times that of the Earth: is it 9810 mm/s^2?"
PLAY = '[vary.play]\npath = "joint.pin.clearance"\n'

BEAM = """name = "cantilever"
gravity = [0, -9.81]
[material.st]
youngs_modulus = "207 GPa"
poissons_ratio = 0.3
density = 7.8
[run]
analysis = "static"
load_factors = [1.0]
[ground]
O = [0, 0]
[body.beam]
length = "1 m"
model = "elastic"
material = "st"
section = { rectangle = ["30 mm", "20 mm"] }
elements = 2
[joint.O]
kind = "weld"
bearing = "ground.O"
journal = "beam.start"
"""
FOAM = "below that of foams: is it 7.8 g/cm^3?"


@pytest.fixture
def beam(tmp_path: Path) -> Path:
    path = tmp_path / "beam.toml"
    path.write_text(BEAM, encoding="utf-8")
    return path


def joined(text: str) -> str:
    return " ".join(text.split())


def test_a_static_answer_has_the_cautions_of_its_model(command: Command, beam: Path) -> None:
    assert joined(command("run", beam, "-o", "once").stdout).count(FOAM) == 1
    quiet = command("run", beam, "-o", "quiet", "-q")
    assert quiet.exit_code == 0 and quiet.stderr.count(FOAM) == 1 and quiet.stdout == ""
    data = json.loads(command("run", beam, "-o", "json", "--json").stdout)
    assert [note for note in data["notes"] if FOAM in note]
    assert joined(command("info", "once", "--long").stdout).count(FOAM) == 1
    command("report", "once", "-o", "once.html")
    assert joined(Path("once.html").read_text(encoding="utf-8")).count(FOAM) == 1


def test_a_static_result_in_python_has_them(beam: Path) -> None:
    result = vfife.simulate(vfife.load(beam))
    assert sum(FOAM in note for note in result.summary["run"]["notes"]) == 1


def test_a_static_analysis_says_of_clearances_once(command: Command, beam: Path) -> None:
    loose = BEAM.replace('kind = "weld"', "") + (
        '[joint.P]\nkind = "clearance"\nbearing = "ground.P"\njournal = "beam.end"\nclearance = "9 mm"\n'
        'bearing_radius = "10 mm"\naxial_length = "10 mm"\n'
    )
    beam.write_text(loose.replace("O = [0, 0]", "O = [0, 0]\nP = [1, 0]"), encoding="utf-8")
    text = joined(command("run", beam, "-o", "loose").stdout)
    assert text.count("in a static analysis a clearance changes positions and forces") == 1
    assert text.count("joint.P.clearance is 9 mm, 90 %") == 1
    assert text.count(FOAM) == 1


@pytest.mark.parametrize(
    "words",
    [
        ("check", LOOSE),
        ("run", LOOSE, "--turns", "1", "-q"),
        ("modes", LOOSE),
        ("wear", LOOSE, "--turns", "1000", "--set", "joint.pin.wear.bearing=8e-17"),
        ("design", LOOSE),
        ("sensitivity", LOOSE, "--turns", "1", "--of", "pin.force.max"),
        ("compare", LOOSE, "--contact", "flores", "--turns", "1", "-q"),
        ("map", "section", LOOSE, "--turns", "3"),
    ],
    ids=lambda words: words[0],
)
def test_commands_say_it_once(command: Command, words: tuple[Any, ...]) -> None:
    answer = command(*words, *HEAVY)
    assert answer.exit_code == 0, answer.output
    assert joined(answer.stderr + answer.stdout).count(WORDS) == 1


@pytest.fixture
def heavy(tmp_path: Path) -> str:
    """First lines of a study file of a model whose gravity is in mm/s^2."""
    text = LOOSE.read_text(encoding="utf-8")
    (tmp_path / "heavy.toml").write_text(f"gravity = [0, -9810]\n{text}", encoding="utf-8")
    return 'model = "heavy.toml"\nmeasures = ["pin.force.max"]\nturns = 1\n'


def test_a_study_says_it(command: Command, heavy: str) -> None:
    Path("s.toml").write_text(f'{heavy}{PLAY}values = ["0.2 mm", "0.3 mm"]\n', encoding="utf-8")
    answer = command("study", "run", "s.toml")
    assert answer.exit_code == 0 and joined(answer.output).count(WORDS) == 1, answer.output


def test_a_search_says_it(command: Command, heavy: str) -> None:
    pytest.importorskip("optuna")
    aim = '[optimise]\nminimise = ["pin.force.max"]\ncases = 2\nrefine = 0\n'
    Path("o.toml").write_text(f'{heavy}{PLAY}from = "0.2 mm"\nto = "0.3 mm"\n{aim}', encoding="utf-8")
    answer = command("optimise", "o.toml")
    assert answer.exit_code == 0 and joined(answer.output).count(WORDS) == 1, answer.output


def test_models_in_the_right_units_have_no_caution(command: Command) -> None:
    answer = command("modes", LOOSE)
    assert answer.exit_code == 0 and answer.stderr == ""


def test_a_refusal_does_not_repeat_them(command: Command) -> None:
    answer = command("sensitivity", LOOSE, *HEAVY, "--set", "body.rod.length=0.01")
    assert answer.exit_code == 2 and joined(answer.stderr).count(WORDS) == 1
    assert "jams at crank angle" in joined(answer.stderr)
