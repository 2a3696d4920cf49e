"""`vfife new` writes model files to start from; `vfife schema` what editors want to know of them."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from choice import default_cases
from cli.models import ROOT
from cli.test_bad_input import refused
from vfife import simulate
from vfife.modelfile import dump, load, loads

TEMPLATES = [
    *sorted((ROOT / "src" / "vfife" / "modelfile" / "templates").glob("*.toml")),
    ROOT / "examples" / "compressor.toml",
]
NAMES = [path.stem for path in TEMPLATES]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_to_start_from_is_whole_and_explained(command: Callable, name: str) -> None:
    assert command("new", name, "-o", "mine.toml").exit_code == 0
    model = load("mine.toml")
    assert model.bodies
    assert loads(dump(model)) == model
    lines = Path("mine.toml").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("#:schema file:///")
    assert lines[0].endswith("/model.schema.json")
    assert Path(lines[0].removeprefix("#:schema file://")).is_file()
    assert sum("#" in line for line in lines) >= 7
    assert command("new", name).stdout.splitlines() == lines


def test_there_is_one_of_each_kind(command: Callable) -> None:
    assert {"four-bar", "slider-crank", "pendulum", "journal-in-bearing", "six-bar", "frame"} <= set(NAMES)
    listed = command("new").stdout
    for path in TEMPLATES:
        assert f" {path.stem} " in listed
        assert path.read_text(encoding="utf-8").splitlines()[0].lstrip("# ").split(",")[0][:60] in listed


@pytest.mark.parametrize("name", [path.stem for path in sorted((ROOT / "examples").glob("*.toml"))])
def test_the_gallery_is_there_to_start_from(command: Callable, name: str) -> None:
    text = (ROOT / "examples" / f"{name}.toml").read_text(encoding="utf-8")
    assert command("new", name).stdout.partition("\n")[2] == text
    other = name.replace("_", "-")
    assert other in NAMES or command("new", other).stdout.partition("\n")[2] == text


@pytest.mark.parametrize("name", ["pendulum", "four-bar", "six-bar", "journal-in-bearing"])
def test_linkages_close_and_move(command: Callable, name: str) -> None:
    command("new", name, "-o", "mine.toml")
    found = json.loads(command("check", "mine.toml", "--json").stdout)
    driven = any(body["driver"] for body in found["bodies"])
    assert (found["degrees_of_freedom"]["free"], found["degrees_of_freedom"]["after_drives"]) == (
        1,
        0 if driven else 1,
    )


@pytest.mark.parametrize(
    "name", default_cases(NAMES, lambda name: name == "geared-five-bar", "runs every template")
)
def test_each_runs_to_its_end(command: Callable, name: str) -> None:
    """As it stands, statics included; the energy ledger closes, and equilibria balance their loads. Of those
    with many steps one turn will do.
    """
    command("new", name, "-o", "mine.toml")
    brief = ["--turns", "1"] if name in ("compressor", "four-bar", "slider-crank") else []
    assert command("run", "mine.toml", "-o", "out", *brief).exit_code == 0
    said = json.loads(Path("out/summary.json").read_text())
    assert said["status"] == "complete"
    if name == "cantilever":
        last = said["run"]["factors"][-1]["reactions"]["clamp"]
        assert last["force_y"] == pytest.approx(20.0, rel=1e-5) and last["force_x"] == pytest.approx(
            0.0, abs=1e-4
        )
        return
    assert said["energy_error"] < 1e-3
    if name == "geared-five-bar":
        assert said["measures"]["wheels.moment.max"] > 0.0
        assert said["energy"]["end"]["spring_loss"] > 0.0


def test_no_file_is_lost(command: Callable) -> None:
    Path("mine.toml").write_text("dear to me")
    refused(command("new", "pendulum", "-o", "mine.toml"), ["mine.toml", "--force"])
    assert Path("mine.toml").read_text() == "dear to me"
    assert command("new", "pendulum", "-o", "mine.toml", "--force").exit_code == 0
    assert load("mine.toml").name == "pendulum"


def test_what_cannot_be_written_is_told(command: Callable, tmp_path: Path) -> None:
    refused(command("new", "pendulm"), ["pendulm", 'did you mean "pendulum"'])
    refused(command("new", "zzz"), ["four-bar", "slider-crank"])
    refused(command("new", "-o", "mine.toml"), ["mine.toml", "pendulum"])
    refused(command("new", "pendulum", "-o", "nowhere/mine.toml"), ["nowhere/mine.toml", "No such file"])
    refused(command("new", "pendulum", "-o", tmp_path, "--force"), [tmp_path.name])
    refused(command("schema", "-o", "nowhere/x.json"), ["nowhere/x.json", "No such file"])


def test_the_schema_is_printed_or_written(command: Callable) -> None:
    done = command("schema")
    assert json.loads(done.stdout)["title"] == "Model file of vfife"
    assert command("schema", "-o", "x.json").exit_code == 0
    assert Path("x.json").read_text(encoding="utf-8") == done.stdout


def test_a_typing_error_of_a_million_elements_is_told_within_two_seconds(
    command: Callable, tmp_path: Path
) -> None:
    text = (ROOT / "src" / "vfife" / "modelfile" / "templates" / "frame.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(
        text.replace("elements = 8", "elements = 99_999").replace("elements = 6", "elements = 1_000_000", 1)
    )
    began = time.process_time()
    done = command("check", tmp_path / "mine.toml")
    assert time.process_time() - began < 2.0
    assert done.exit_code == 2
    assert "100,005 elements" in " ".join(done.stderr.split())
    assert "from 1 to 100000" in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr


def test_lines_of_the_press_give_it_clearance_and_work(command: Callable) -> None:
    """The lines that a user may take in make a valid model, whose force acts on the way forward alone."""
    assert command("new", "six_bar_press", "-o", "press.toml").exit_code == 0
    text = Path("press.toml").read_text(encoding="utf-8")
    assert not loads(text).contacts and not loads(text).loads
    lines = [line.removeprefix("#~ ") for line in text.splitlines()]
    press = loads("\n".join(lines))
    assert [(name, joint.clearance) for name, joint in press.contacts.items()] == [("E", 25e-6), ("F", 25e-6)]
    work = press.loads["work"]
    assert min(work.force) == -5000.0 and set(work.force_back) == {0.0}
    low, high = simulate(loads(text)).measures["guide.position.low"], 0.1157
    assert work.travels[0] < low < work.travels[1] and work.travels[-2] < high < work.travels[-1]
