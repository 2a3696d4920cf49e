"""``vfife design``: the answer on the screen, as a page, a document and data; files of other kinds; Ctrl-C;
exit codes.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import vfife
from cli.models import ROOT
from vfife.assessment import design_work
from vfife.assessment.answer import Design
from vfife.errors import VfifeError
from vfife.job.job import Interrupted
from vfife.tribology import simulate_wear

MODEL = ROOT / "examples" / "slider_crank_loose_pin.toml"
LETTERHEAD = ("A. Designer", date.today().isoformat())
BRIEF = ("--turns", 1, "--share", 0.5, "--wear", "1e-15", "--wear-turns", "1e5")


@pytest.fixture(scope="module")
def answer() -> Design:
    """The answer of a short question, computed once."""
    options: dict[str, Any] = {"turns": 1, "share": 0.5, "wear": 1e-15, "wear_turns": 1e5}
    return vfife.design(vfife.load(MODEL), **options)


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch, answer: Design) -> list[dict[str, Any]]:
    """Gives the command this answer; keeps the keywords that it asked with."""
    keywords = list[dict[str, Any]]()

    def design(_mechanism: Any, of: Any, **options: Any) -> Design:
        keywords.append({"of": of, **options})
        return answer

    monkeypatch.setattr(design_work, "design", design)
    return keywords


def test_a_limit_without_a_unit_is_questioned_before_the_machines_run(command: Callable) -> None:
    done = command("design", MODEL, *BRIEF, "--limit", "4")
    said = " ".join(done.stderr.split())
    assert done.exit_code == 2 and "a unit is probably missing" in said, said
    assert 'Write "4 kN", or "4 N" if that is meant' in said and "pin.force.max" in said
    done = command("design", MODEL, *BRIEF, "--clearance", "0.4")
    assert done.exit_code == 2 and 'Write "0.4 mm"' in " ".join(done.stderr.split())


@pytest.mark.slow("derivatives, machines and wear")
def test_the_answer_of_the_command_is_that_of_python(command: Callable, answer: Design) -> None:
    done = command("design", MODEL, *BRIEF, "--json", "-o", "page.json")
    assert done.exit_code == 0, done.stderr
    data = json.loads(done.stdout)
    (joint,) = answer.joints
    assert data["joints"]["pin"]["fit"] == joint.fit and data["limit"] == answer.limit
    assert joint.life is not None and data["joints"]["pin"]["life"]["turns"] == joint.life.turns
    assert json.loads(Path("page.json").read_text()) == data
    assert "forecast: sensitivities and fits and wear" in done.stderr


def test_a_page_a_document_and_words(command: Callable, stand_in: list[dict[str, Any]]) -> None:
    words = (
        *BRIEF,
        "--limit",
        "5 kN",
        "--cost",
        "IT7=5,IT8=3",
        "--clearance",
        "0.3 mm",
        "--of",
        "pin.force.max",
    )
    Image.new("RGB", (30, 10)).save("logo.png")
    for name, first in (("a.html", b"<!doctype html>"), ("a.PDF", b"%PDF")):
        done = command("design", MODEL, *words, "-o", name, "--author", LETTERHEAD[0], "--logo", "logo.png")
        assert done.exit_code == 0, done.stderr
        assert Path(name).read_bytes()[: len(first)].lower() == first.lower()
        assert "Conclusion" in done.stdout and f"{name}" in done.stdout
    assert b"A. Designer" in Path("a.PDF").read_bytes()
    done = command("design", MODEL, *words, "-o", "a.html")
    assert done.exit_code == 2 and "-o a.html: this file exists" in " ".join(done.stderr.split())
    done = command("design", MODEL, *words, "-o", "a.PDF", "--force")
    assert done.exit_code == 0 and b"A. Designer" not in Path("a.PDF").read_bytes()
    page = Path("a.html").read_text()
    assert "wears out first" in page and "Next steps" in page
    for part in (
        *LETTERHEAD,
        ">The mechanism<",
        "rod (bearing) 1e-15, block (journal) 1e-15",
        "Measure",
        "pin.force.max, the largest force on pin",
    ):
        assert part in page, part
    assert page.count('<img class="logo"') == 1 and page.count("<section") == 4
    assert "clearance = &quot;0.5 mm&quot;" in page, "the model as it was written"
    assert stand_in[0] | {"of": "pin.force.max", "limit": "5 kN", "share": 0.5, "turns": 1, "wear": "1e-15",
        "wear_turns": 1e5, "clearance": 0.3e-3, "cost": {"IT7": 5.0, "IT8": 3.0}} == stand_in[0]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["-o", "a.txt"], "name a file such as a.html: there are .html, .pdf and .json"),
        (["-o", "missing/a.html"], "no folder"),
        (["-o", MODEL.with_suffix(".html").parent], "name a file"),
        (["--limit", "2 m"], "limit"),
        (["--logo", MODEL], "neither a png nor a jpeg"),
        (["--cost", "IT7"], "--cost"),
        (["--cost", "IT7=cheap"], "write costs as numbers, as in it7=5"),
        (["--clearance", "2 kg"], "--clearance"),
        (["--share", "2"], "share"),
        (["--of", "pin.fource.max"], 'did you mean "pin.force.max"'),
        (["--set", "joint.pin.kind=ideal"], "no joint has clearance"),
    ],
)
def test_what_cannot_be_answered_is_told_with_exit_code_2(
    command: Callable, words: list[str], expected: str
) -> None:
    done = command("design", MODEL, *words)
    assert done.exit_code == 2 and expected in done.stderr.lower(), done.stderr
    assert "Traceback" not in done.output and done.stdout == "" and not list(Path().iterdir())


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("study.toml", 'model = "m.toml"\nmeasures = ["C.force.max"]\n[vary]\n', "vfife study study.toml"),
        ("rig.csv", "time (s), C.force (N)\n0, 1\n", "a table of values"),
        ("empty.toml", "", "empty"),
        ("laws.py", "x = 1\n", "a Python file"),
    ],
)
def test_a_file_of_another_kind_gets_one_sentence(
    command: Callable, name: str, text: str, expected: str
) -> None:
    Path(name).write_text(text)
    done = command("design", name)
    assert done.exit_code == 2 and expected in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_ctrl_c_leaves_the_part_that_is_computed(
    command: Callable, monkeypatch: pytest.MonkeyPatch, answer: Design
) -> None:
    """It is shown and written, and the exit code is that of the signal."""
    missing = {"life": design_work.INTERRUPTED}
    part = dataclasses.replace(answer, wear=None, missing=missing, complete=False)

    def design(*_: Any, **__: Any) -> Design:
        raise Interrupted(part)

    monkeypatch.setattr(design_work, "design", design)
    done = command("design", MODEL, *BRIEF, "-o", "part.html")
    assert done.exit_code == 130, done.stderr
    assert "Stopped by Ctrl-C: lives not computed. The same command with --force begins again" in done.stderr
    fit = answer.joints[0].fit
    assert fit is not None and fit in done.stdout and fit in Path("part.html").read_text()
    assert "The computation was interrupted" in Path("part.html").read_text()


@pytest.mark.slow("derivatives and machines")
def test_a_part_that_fails_stops_no_other(command: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any, **__: Any) -> Any:
        raise VfifeError("the rate is not finite")

    monkeypatch.setattr(simulate_wear, "wear", fail)
    monkeypatch.setattr(design_work, "wear", fail)
    done = command("design", MODEL, *BRIEF, "--json")
    assert done.exit_code == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["missing"] == {"life": "the rate is not finite"} and data["joints"]["pin"]["fit"]
