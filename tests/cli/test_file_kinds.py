"""A file of the wrong kind gets one sentence that names its kind and the command for it, in every command."""

import shutil
import sqlite3
from pathlib import Path

import pytest
from typer.testing import CliRunner

from vfife.cli.app import app
from vfife.files.kinds import APPLICATIONS, KINDS, RUN_FILE

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TEXTS = {
    "study.toml": 'model = "model.toml"\nmeasures = ["C.force.max"]\n[vary.c]\npath = "joint.C.clearance"\n',
    "plan.toml": 'model = "model.toml"\n[[record]]\ndata = "data.csv"\n',
    "data.csv": "time (s), C.force (N)\n0, 1\n1, 2\n",
    "laws.py": "import math\n",
    "empty.toml": " \n",
}
FILES = {
    "model.toml": "model", "study.toml": "study file", "plan.toml": "fit plan", "data.csv": "table",
    "laws.py": "python", "empty.toml": "empty", "binary.toml": "binary", "folder": "folder",
    "other.db": "database", "runs": "run",
    RUN_FILE: "run", "a.study": "study", "a.map": "map", "a.wear": "wear", "a.fit": "fit",
}  # fmt: skip
MODEL, RUN, STUDY = ("model",), ("run",), ("study",)
# A command up to its file, what follows it, and the kinds that it takes.
COMMANDS: dict[str, tuple[str, tuple[str, ...]]] = {
    **dict.fromkeys(("run", "check", "modes", "compare", "sensitivity", "map section"), ("", MODEL)),
    "live": ("", ("model", "run")),
    "wear": ("", ("model", "wear")),
    "waterfall": ("--over driver.crank.speed=100..200rpm", MODEL),
    "map sweep": ("--over joint.C.clearance=0.1..1mm", MODEL),
    "map basins": ("--over start.C.x=0..0.1mm --over start.C.y=0..0.1mm", MODEL),
    "map show": ("", ("map",)),
    **dict.fromkeys(("study", "study allocate", "optimise"), ("", ("study file",))),
    **dict.fromkeys(
        ("study show", "study tolerance", "study indices", "study resume", "study add"), ("", STUDY)
    ),
    "study plot": ("", STUDY),
    "study export": ("new.csv", STUDY),
    **dict.fromkeys(("impacts", "plot", "animate", "spectrum", "resume"), ("", RUN)),
    **dict.fromkeys(("info", "report"), ("", ("run", "study"))),
    "export": ("new.csv", RUN),
    "fit": ("", ("fit plan", "fit")),
    "fit model.toml": ("-p joint.C.clearance=0.1..1mm", ("table",)),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of every kind."""
    place = tmp_path_factory.mktemp("kinds")
    shutil.copy(EXAMPLES / "four_bar_case_c.toml", place / "model.toml")
    for name, text in TEXTS.items():
        (place / name).write_text(text, encoding="utf-8")
    (place / "binary.toml").write_bytes(bytes(range(256)))
    with sqlite3.connect(place / "other.db") as connection:
        connection.execute("CREATE TABLE meta (key)")
    connection.close()
    (place / "folder").mkdir()
    (place / "runs").mkdir()
    for kind, number in APPLICATIONS.items():
        path = place / (RUN_FILE if kind == "run" else f"a.{kind}")
        with sqlite3.connect(path) as connection:
            connection.execute(f"PRAGMA application_id = {number}")
            connection.execute("CREATE TABLE meta (key)")
        connection.close()
    shutil.copy(place / RUN_FILE, place / "runs")
    return place


@pytest.mark.parametrize("command", COMMANDS)
def test_every_wrong_kind_gets_one_sentence(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    rest, accepted = COMMANDS[command]
    for file, kind in FILES.items():
        if kind in accepted:
            continue
        result = CliRunner().invoke(app, [*command.split(), file, *rest.split()])
        lines = result.stderr.strip().splitlines()
        assert result.exit_code == 2 and len(lines) == 1, (file, result.output)
        assert lines[0].startswith(f"error: {file} is {KINDS[kind].name}"), lines[0]
        assert ", not " in lines[0] and "; " in lines[0]
    assert sorted(one.name for one in folder.iterdir()) == sorted(FILES)


def test_the_sentence_names_the_command_for_the_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    sentence = CliRunner().invoke(app, ["run", "study.toml"]).stderr.strip()
    expected = (
        "study.toml is a study (it has the table [vary]), not a model; run it with vfife study study.toml"
    )
    assert sentence == f"error: {expected}"


def test_a_model_with_a_key_of_a_study_stays_a_model(tmp_path: Path) -> None:
    """Its own tables decide; the other key is reported as unknown."""
    model = tmp_path / "model.toml"
    model.write_text("limit = 1\n" + (EXAMPLES / "four_bar_case_c.toml").read_text(encoding="utf-8"))
    result = CliRunner().invoke(app, ["check", str(model)])
    assert result.exit_code == 2 and "limit" in result.stderr and "a study" not in result.stderr
