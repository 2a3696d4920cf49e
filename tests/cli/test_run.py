"""`vfife run`: one object on standard output, a run folder, and what an exit code says."""

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import vfife
from choice import default_cases
from cli.conftest import ENVIRONMENT
from cli.models import CASE_C, ROOT
from vfife.cli import terminal
from vfife.cli.commands import run as run_command
from vfife.compiler.runtime import loops
from vfife.compiler.runtime.runner import Runner
from vfife.errors import RunFileError
from vfife.report import overview, trust
from vfife.store.runfile import RunFile

KEYS = {
    "turns",
    "part",
    "faults",
    "status",
    "step",
    "steps",
    "wall_s",
    "ns_per_step",
    "energy_error",
    "run",
    "loop",
    "notes",
    "measures",
    "ranges",
    "not_unique",
    "about_zero",
    "ground",
    "not_estimated",
    "trust",
    "warnings",
    "law_dependent",
    "law_shocks",
    "law_loads",
}
ELASTIC = ROOT / "examples" / "elastic_pendulum.toml"


@pytest.mark.system("starts a process")
def test_standard_output_is_one_object(process: Callable, tmp_path: Path) -> None:
    """Progress, notes and warnings stay away from it."""
    began = process("run", CASE_C, "--turns", "1.5", "--step", "2e-6", "--json")
    out, err = began.communicate(timeout=300)
    assert began.returncode == 0, err
    said = json.loads(out)
    assert set(said) == KEYS
    assert said["warnings"] == said["notes"][len(said["notes"]) - len(said["warnings"]) :]
    summary = json.loads((tmp_path / said["run"] / "summary.json").read_text(encoding="utf-8"))
    assert all(said[key] == summary[key] for key in ("law_dependent", "law_shocks", "law_loads"))
    assert (said["status"], said["step"], said["steps"]) == ("complete", 2e-6, 30000)
    assert (tmp_path / said["run"] / "run.sqlite").is_file()
    assert all(isinstance(value, float) and math.isfinite(value) for value in said["measures"].values())
    assert said["energy_error"] < 1e-4
    assert "100 %" in err
    assert "steps/s" in err


def test_measures_that_scripts_read(case_c_run: Path) -> None:
    measures = json.loads((case_c_run / "summary.json").read_text())["measures"]
    wanted = ["follower.angular_acceleration.max", "C.force.lip", "follower.angular_acceleration.lip"]
    wanted += [
        f"C.{name}" for name in ("force.max", "penetration.max", "impacts", "share.continuous_contact")
    ]
    assert set(wanted) <= set(measures)


def test_folder_holds_the_run(case_c_run: Path) -> None:
    assert {path.name for path in case_c_run.iterdir()} == {"run.sqlite", "model.toml", "summary.json"}


def test_model_as_run_runs_again(command: Callable, pendulum: Path) -> None:
    """The model in the folder has what --set and the options say, and gives the same numbers."""
    options = [
        "--set",
        "body.rod.mass=3 kg",
        "--duration",
        "20 ms",
        "--step",
        "1e-5",
        "--outputs",
        "50",
        "--json",
    ]
    first = json.loads(command("run", pendulum, *options).stdout)
    model = Path(first["run"]) / "model.toml"
    assert vfife.load_model(model).bodies["rod"].mass == 3.0
    second = json.loads(command("run", model, "--json").stdout)
    assert first["steps"] == 2000
    for key in ("step", "steps", "measures", "energy_error"):
        assert second[key] == first[key]


def test_earlier_runs_are_kept_unless_named(command: Callable, pendulum: Path) -> None:
    first, second = (json.loads(command("run", pendulum, "--json").stdout) for _ in range(2))
    assert (first["run"], second["run"]) == (str(Path("runs/pendulum")), str(Path("runs/pendulum-2")))
    assert "stays as it is" in second["notes"][0]
    (Path(first["run"]) / "mine.txt").write_text("notes")
    again = ["run", pendulum, "-o", first["run"], "--duration", "0.01", "--json"]
    refused = command(*again)
    assert refused.exit_code == 2 and "add --force to replace it" in refused.stderr
    assert json.loads(refused.stdout)["status"] == "refused"
    third = command(*again, "--force")
    assert "replaces" in json.loads(third.stdout)["notes"][0]
    assert (Path(first["run"]) / "mine.txt").read_text() == "notes"
    assert vfife.Result.load(first["run"]).time[-1] == pytest.approx(0.01)


def test_foreign_folder_is_left_alone(command: Callable, pendulum: Path, tmp_path: Path) -> None:
    done = command("run", pendulum, "-o", tmp_path)
    assert done.exit_code == 2
    assert "not a run of vfife" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["pendulum.toml"]
    assert command("run", pendulum, "-o", pendulum).exit_code == 2


def test_faulty_input_leaves_an_earlier_run_alone(command: Callable, pendulum: Path) -> None:
    assert command("run", pendulum, "-o", "kept", "--quiet").exit_code == 0
    before = Path("kept/run.sqlite").read_bytes()
    assert command("run", pendulum, "-o", "kept", "--force", "--set", "body.rod.mass=-1").exit_code == 2
    assert Path("kept/run.sqlite").read_bytes() == before


def test_summary_and_the_next_step(command: Callable, pendulum: Path) -> None:
    done = command("run", pendulum)
    for word in ("pendulum", "50 ms", "no clearance", "runs/pendulum", "vfife plot runs/pendulum"):
        assert word in done.stdout
    assert "ledger" not in done.stdout
    long = command("run", pendulum, "--long")
    for word in ("pendulum", "steps of", "ledger", "runs/pendulum", "vfife plot runs/pendulum"):
        assert word in long.stdout
    later = command("info", "runs/pendulum", "--long")
    assert later.exit_code == 0 and "ledger" in later.stdout
    quiet = command("run", pendulum, "--quiet")
    assert (quiet.stdout, quiet.stderr) == ("", "")


@pytest.mark.usefixtures("unrendered")
def test_figures_on_request(command: Callable) -> None:
    done = command("run", CASE_C, "--turns", "1", "--outputs", "90", "--figures", "-o", "drawn")
    assert done.exit_code == 0, done.stderr
    assert len(list(Path("drawn/figures").glob("*.png"))) >= 3


def test_without_the_ideal_mechanism(command: Callable) -> None:
    said = json.loads(
        command("run", CASE_C, "--turns", "1", "--step", "2e-6", "--no-reference", "--json").stdout
    )
    assert not [name for name in said["measures"] if name.endswith(".lip")]


def test_divergence_is_explained(command: Callable) -> None:
    words = ["run", ELASTIC, "--step", "3e-3", "--duration", "0.999", "-o", "burst"]
    refused = command(*words)
    assert refused.exit_code == 2
    assert "--force-step" in refused.stderr
    done = command(*words, "--force-step", "--outputs", "10", "--json")
    assert done.exit_code == 3
    assert json.loads(done.stdout)["status"] == "diverged"
    said = re.search(
        r"in step ([\d,]+), at ([\d.e-]+) s, (.+) (became infinite|grew without bound)", done.stderr
    )
    assert said
    assert float(said[2]) == pytest.approx(3e-3 * int(said[1]), rel=1e-3)
    command(*words, "--force-step", "--outputs", "333", "--quiet", "--force")  # an output every step
    assert int(said[1]) == vfife.Result.load("burst").record.steps[-1] + 1
    assert "larger than the stable" in done.stderr
    assert "--step auto" in done.stderr
    assert "Traceback" not in done.stderr


def interrupt_at(monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    """Ctrl-C as it arrives: when a call of the compiled loop is over, or while it is compiled."""
    advance, calls = Runner.advance, []

    def interrupted(self, count, outputs, **how):
        calls.append(count)
        if len(calls) == call:
            raise KeyboardInterrupt
        return advance(self, count, outputs, **how)

    monkeypatch.setattr(Runner, "advance", interrupted)


def test_interrupted_run_is_kept(command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupt_at(monkeypatch, 3)
    done = command("run", pendulum, "--json")
    said = json.loads(done.stdout)
    assert (done.exit_code, said["status"]) == (130, "interrupted")
    assert "are kept in runs/pendulum" in done.stderr
    assert "Traceback" not in done.stderr
    assert vfife.Result.load(said["run"]).record.steps[-1] == said["steps"] > 0


def test_interrupted_compilation_leaves_nothing(
    command: Callable, pendulum: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt_at(monkeypatch, 1)
    done = command("run", pendulum, "--json")
    assert (done.exit_code, json.loads(done.stdout)["status"]) == (130, "interrupted")
    assert "had not made a step" in done.stderr
    assert not Path("runs").exists()


def test_interrupted_reference_starts_nothing(command: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupt_at(monkeypatch, 3)
    done = command("run", CASE_C, "--json")
    assert (done.exit_code, json.loads(done.stdout)["status"]) == (130, "interrupted")
    assert "Ctrl-C" in done.stderr
    assert not Path("runs").exists()


def written(path: Path) -> bool:
    """Whether a file has outputs that a kill cannot take away."""
    try:
        with RunFile.open(path) as file:
            return len(file.steps) > 1
    except RunFileError:  # it is not there yet, or being made
        return False


def long_run(process: Callable, folder: Path, *words: Any) -> "subprocess.Popen[str]":
    """A run of an hour that has written some of its outputs."""
    began = process("run", *words, "--yes", "-o", folder, "--companions", "0", "--json")
    until = time.monotonic() + 120.0
    while not written(folder / "run.sqlite"):
        assert began.poll() is None, began.communicate()[1]
        assert time.monotonic() < until, "the run does not begin"
        time.sleep(0.05)
    return began


@pytest.mark.slow("starts a process and sends it a signal")
def test_ctrl_c(process: Callable, pendulum: Path, tmp_path: Path) -> None:
    began = long_run(
        process, tmp_path / "long", pendulum, "--duration", "10000", "--step", "1e-6", "--outputs", "100000"
    )
    began.send_signal(signal.SIGINT)
    out, err = began.communicate(timeout=240)
    assert began.returncode == 130
    assert json.loads(out)["status"] == "interrupted"
    assert "they are kept in" in err
    assert "Traceback" not in err


@pytest.mark.system("kills a process")
def test_killed_run_is_readable(process: Callable, command: Callable, tmp_path: Path) -> None:
    began = long_run(process, tmp_path / "long", CASE_C, "--turns", "100000", "--outputs", "30")
    began.kill()
    began.communicate(timeout=240)
    done = command("info", "long")
    assert done.exit_code == 0, done.stderr
    assert "unfinished" in done.stdout
    said = json.loads(command("info", "long", "--json").stdout)
    assert said["steps"] > 0
    assert said["reference"]
    exported = command("export", "long", "out.csv")
    assert exported.exit_code == 0, exported.stderr
    assert "unfinished" in exported.stderr


def test_a_sensitive_run_says_so_first(command: Callable, tmp_path: Path) -> None:
    """Case c with three times the friction, at a step at which companions part."""
    rough = [word for joint in "BCD" for word in ("--set", f"joint.{joint}.friction.coefficient=0.3")]
    done = command("run", CASE_C, *rough, "--step", "2.5e-6", "--companions", "3", "-o", "out")
    assert done.exit_code == 0
    first, second = done.stdout.splitlines()[:2]
    assert first.startswith("four-bar, case c") and second.startswith("Sensitive to the step size: ")
    said = " ".join(command("info", "out", "--long").stdout.split())
    assert (
        said.index("This run is sensitive") < said.index("Bodies")
        and "The runs diverge at" in said
        and "range of reaction" in said
    )
    summary = json.loads(Path("out/summary.json").read_text())
    assert summary["trust"]["sensitive"] and summary["trust"]["joint"] in "BCD"
    name = summary["trust"]["measure"]
    assert summary["ranges"][name]["low"] <= summary["measures"][name] <= summary["ranges"][name]["high"]


def test_companions_are_asked_for_and_turned_off(command: Callable) -> None:
    assert (
        command(
            "run", CASE_C, "--step", "5e-6", "--turns", "1", "--companions", "0", "-o", "out", "--json"
        ).exit_code
        == 0
    )
    assert json.loads(Path("out/summary.json").read_text())["ranges"] == {}
    assert "companions = 0" in Path("out/model.toml").read_text()
    wrong = command("run", CASE_C, "--companions", "12")
    assert wrong.exit_code == 2 and 'from 0 to 7, or "auto"' in wrong.stderr


@pytest.mark.system("starts processes")
@pytest.mark.parametrize(
    "way",
    default_cases(
        ["python -m", "a script that is not on the path", "a script on the path"],
        lambda way: way == "python -m",
        "starts processes",
    ),
)
def test_what_comes_next_works_as_printed(tmp_path: Path, pendulum: Path, way: str) -> None:
    """The first of the commands that a run ends with, typed into a shell of the same environment."""
    environment = dict(ENVIRONMENT)
    if way == "python -m":
        line = [sys.executable, "-m", "vfife"]
    else:
        script = tmp_path / "my environment" / "bin" / "vfife"
        script.parent.mkdir(parents=True)
        script.write_text(f"#!{sys.executable}\nfrom vfife.__main__ import main\nmain()\n")
        script.chmod(0o700)
        if way == "a script on the path":
            environment["PATH"] = os.pathsep.join((str(script.parent), environment["PATH"]))
        line = ["vfife" if way == "a script on the path" else str(script.relative_to(tmp_path))]
    told = {"cwd": tmp_path, "env": environment, "capture_output": True, "text": True}
    done = subprocess.run([*line, "run", str(pendulum), "--duration", "1e-3"], **told)
    (following,) = (
        one.removeprefix("Next: ") for one in done.stdout.splitlines() if one.startswith("Next: ")
    )
    info = following.split("; ")[1]
    assert info.startswith("vfife ") == (way == "a script on the path")
    again = subprocess.run(info, shell=True, **told)
    assert again.returncode == 0 and "pendulum" in again.stdout, again.stderr


def test_commands_that_come_next_are_short(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``vfife`` where the shell would find this program, else the shorter of its two paths."""
    program = tmp_path / "environment" / "bin" / "vfife"
    program.parent.mkdir(parents=True)
    program.write_text("")
    program.chmod(0o700)
    monkeypatch.setattr("sys.argv", [str(program), "run"])
    monkeypatch.chdir(tmp_path)
    assert terminal.command() == "environment/bin/vfife"
    monkeypatch.chdir(program.parent)
    assert terminal.command() == "./vfife"
    monkeypatch.setenv("PATH", str(program.parent))
    assert terminal.command() == "vfife"
    monkeypatch.delenv("PATH")
    monkeypatch.chdir("/")
    assert terminal.command() == str(program).lstrip("/")


def test_a_run_with_knocks_names_the_help_on_noise(command: Callable, pendulum: Path) -> None:
    knocks = command("run", CASE_C, "--turns", 0.2, "--companions", 0)
    assert knocks.exit_code == 0 and "vfife help noise" in knocks.stdout
    assert "help noise" not in command("run", pendulum, "--duration", "1e-3").stdout


def test_a_first_run_of_its_kind_says_that_it_compiles(
    command: Callable, pendulum: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    loops.straight_line.cache_clear()
    first = command("run", pendulum, "--duration", "1e-3")
    loops.straight_line.cache_clear()
    second = command("run", pendulum, "--duration", "1e-3", "-o", "again")
    assert first.exit_code == second.exit_code == 0
    assert "note: compiling the step" in first.stderr and "compiling" not in second.stderr


@pytest.mark.parametrize(
    ("certain", "word"), [(True, "note: Reliable, except spin"), (False, "warning: sensitive")]
)
def test_quiet_a_run_whose_forces_are_certain_is_not_called_sensitive(certain, word, monkeypatch, capsys):
    """Where only an angular acceleration depends on the step, it is a note; other warnings stay warnings."""
    monkeypatch.setattr(overview, "uncertain", lambda summary: not certain)
    monkeypatch.setattr(overview, "certainty", lambda summary: "Reliable, except spin")
    monkeypatch.setattr(trust, "verdict", lambda summary: "sensitive")
    run_command.warn(SimpleNamespace(summary={}), ["deep", "sensitive"])
    assert [line.strip() for line in capsys.readouterr().err.splitlines()] == ["warning: deep", word]
