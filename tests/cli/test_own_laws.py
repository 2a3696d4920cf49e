"""`--laws FILE.py`: laws of the user's own on the command line, and a model file that cannot load code by
itself.
"""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from cli.models import PENDULUM
from laws.test_own_laws import COPY
from vfife.laws import ContactLaw

pytestmark = pytest.mark.usefixtures("only_built_in_laws")

MODEL = (
    PENDULUM.replace("duration = 0.05", "duration = 0.002")
    + 'kind = "clearance"\nclearance = 1e-4\nbearing_radius = 0.01\ncontact = {law = "mine"}\n'
)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "model.toml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def laws(tmp_path: Path) -> Path:
    path = tmp_path / "my_laws.py"
    path.write_text(COPY)
    return path


def test_run_check_and_info(command: Callable, model: Path, laws: Path) -> None:
    said = json.loads(command("check", model, "--laws", laws, "--json").stdout)
    assert said["joints"][0]["contact"]["law"] == "mine"
    assert (
        "equal to Python to the bit at 256 states in" in said["laws"]["mine"]
        and "not on a card" in said["laws"]["mine"]
    )
    done = command("run", model, "--laws", laws, "-o", "out", "--quiet")
    assert done.exit_code == 0, done.stderr
    del ContactLaw.registry["mine"]
    laws.unlink()
    text = " ".join(command("info", "out").stdout.split())
    assert "Own law mine (contact), from" in text and "does not run it" in text
    assert json.loads(command("info", "out", "--json").stdout)["own_laws"][0]["text"] == COPY
    assert command("plot", "out").exit_code == 0


def test_a_model_file_alone_loads_no_code(command: Callable, model: Path, laws: Path) -> None:
    done = command("run", model)
    assert done.exit_code == 2
    assert "there is no contact law of this name" in done.stderr and "--laws" in done.stderr
    model.write_text(MODEL + 'laws = "my_laws.py"\n')
    assert command("check", model).exit_code == 2
    model.write_text('laws = "my_laws.py"\n' + MODEL)
    done = command("check", model)
    assert done.exit_code == 2 and "mine" not in ContactLaw.registry


@pytest.mark.parametrize("words", [["run"], ["check"]], ids=" ".join)
def test_a_law_that_cannot_be_used_ends_with_a_sentence(
    command: Callable, model: Path, laws: Path, words: list[str]
) -> None:
    laws.write_text(COPY.replace("penetration * math.sqrt", "penetration * math.exp"))
    done = command(*words, model, "--laws", laws)
    assert done.exit_code == 2
    assert re.search(
        r"error: --laws .*my_laws\.py, line \d+, law 'mine'.*line 34: math.exp.*write exp of", done.stderr
    ), done.stderr
    assert "Traceback" not in done.output
    laws.write_text(COPY.replace("stiffness * penetration *", "-stiffness * penetration *"))
    done = command(*words, model, "--laws", laws)
    assert done.exit_code == 2 and "push" in done.stderr and "Traceback" not in done.output
    assert command(*words, model, "--laws", "none.py").exit_code == 2
    assert not Path("runs").exists()


def test_what_was_compared_is_said(
    command: Callable, model: Path, laws: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = (
        "JavaScript: compared in node"
        if shutil.which("node")
        else "JavaScript: not compared, because there is no node on this machine"
    )
    text = " ".join(command("laws", "mine", "--laws", laws).stdout.split())
    assert (
        re.search(
            r"Compared: equal to Python to the bit at 256 states in \d+ loops; JavaScript: .*; .*not on a"
            r" card",
            text,
        )
        and node in text
    )
    assert node in " ".join(command("check", model, "--laws", laws).stdout.split())
    monkeypatch.setenv("PATH", "")
    laws.write_text(COPY.replace("0.75", "0.7"))
    told = json.loads(command("laws", "mine", "--laws", laws, "--json").stdout)[0]["compared"]
    assert "JavaScript: not compared, because there is no node on this machine" in told


def test_a_law_whose_truth_values_are_numbers_is_refused(command: Callable, model: Path, laws: Path) -> None:
    laws.write_text(
        COPY.replace("hysteresis(elastic, factor, slowness)\n", "elastic * slowness * (factor or 0.5)\n")
    )
    for words in (("check", model), ("run", model, "-o", "out"), ("laws",)):
        done = command(*words, "--laws", laws)
        said = " ".join(done.stderr.split())
        assert (
            done.exit_code == 2
            and "line 35: `factor or 0.5`" in said
            and "write `factor if factor != 0.0 else 0.5`" in said
        )
