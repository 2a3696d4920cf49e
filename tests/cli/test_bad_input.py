"""Whatever is wrong with the input: exit code 2, a sentence with file, table and key, no traceback, no
standard output.
"""

import json
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

import vfife
from cli.models import CASE_C, PENDULUM
from vfife.errors import DamageWarning

# What is changed in the pendulum's file, and what the sentence has to name.
FILES = {
    "unknown key": ("mass = 2", "mas = 2", ["[body.rod] mas", "mass"]),
    "unknown table": ("[run]", "[ruin]", ["ruin", "run"]),
    "unknown pin": ("rod.start", "rod.stat", ["[joint.J] journal", "rod.stat", "rod.start"]),
    "unknown body": ("rod.start", "rood.start", ["[joint.J] journal", "rood"]),
    "zero length": ('"1 m"', "0", ["[body.rod] length", "0"]),
    "negative mass": ("mass = 2", 'mass = "-2 kg"', ["[body.rod] mass", "-2 kg"]),
    "nan": ("mass = 2", "mass = nan", ["[body.rod] mass", "nan"]),
    "wrong unit": ('"1 m"', '"1 s"', ["[body.rod] length", "1 s", "mm"]),
    "unknown unit": ('"1 m"', '"1 cubit_"', ["[body.rod] length", "cubit_"]),
    "missing key": ("mass = 2", "", ["[body.rod] mass"]),
    "no TOML": ("[run]", "[run", ["line 3", "TOML"]),
    "journal larger than its bearing": (
        'journal = "rod.start"',
        'journal = "rod.start"\nkind = "clearance"\nclearance = "2 cm"\nbearing_radius = "1 cm"',
        ["[joint.J] clearance", "2 cm", "bearing_radius"],
    ),
    "unknown law": (
        'journal = "rod.start"',
        (
            'journal = "rod.start"\nkind = "clearance"\nclearance = 1e-4\nbearing_radius = 0.01\ncontact ='
            ' {law = "perreira"}'
        ),
        ["[joint.J.contact] law", "pereira"],
    ),
}

OPTIONS = {
    "no assignment": (["--set", "joint.C.clearance"], ["--set joint.C.clearance", "PATH=VALUE"]),
    "unknown path": (["--set", "joint.C.clearence=1e-4"], ["joint.C.clearence", "joint.C.clearance"]),
    "unknown joint": (["--set", "joint.X.clearance=1e-4"], ["joint.X.clearance", "joint 'X'"]),
    "value of no use": (["--set", "joint.C.clearance=0.5 s"], ["[joint.C] clearance", "0.5 s", "set"]),
    "links that cannot reach": (
        ["--set", "body.coupler.length=1 cm"],
        ["case_c.toml", "joints stay open", "mm"],
    ),
    "step too large": (["--set", "run.step=1"], ["case_c.toml", "a step of 1 s is too large", "allows"]),
}
RUN_OPTIONS = {
    "step": (["--step", "1"], ["a step of 1 s is too large", "--force-step"]),
    "step in kg": (["--step", "1 kg"], ["--step 1 kg", "time"]),
    "step nan": (["--step", "nan"], ["--step nan", "finite"]),
    "negative step": (["--step", "-1e-6"], ["--step -1e-6", "above 0"]),
    "no turns": (["--turns", "0"], ["--turns 0", "above 0"]),
    "infinite turns": (["--turns", "inf"], ["--turns inf"]),
    "two lengths": (["--turns", "1", "--duration", "1"], ["--turns", "--duration", "exclude"]),
    "no duration": (["--duration", "0 s"], ["--duration 0 s"]),
    "no outputs": (["--outputs", "0"], ["--outputs"]),
    "unknown loop": (["--loop", "fast"], ["--loop", "generated"]),
    "unknown option": (["--stp", "1"], ["--stp"]),
}


def refused(done, words: list[str]) -> None:
    assert done.exit_code == 2, (done.exit_code, done.stdout, done.stderr)
    assert "Traceback" not in done.stderr
    assert done.stdout == "" or json.loads(done.stdout)["status"] == "refused"
    for word in words:
        assert word in done.stderr


@pytest.mark.parametrize("verb", ["check", "run"])
@pytest.mark.parametrize("fault", FILES)
def test_fault_in_a_file(command: Callable, pendulum: Path, fault: str, verb: str) -> None:
    old, new, words = FILES[fault]
    assert old in PENDULUM
    pendulum.write_text(PENDULUM.replace(old, new))
    refused(command(verb, pendulum, "--json"), ["pendulum.toml", *words])
    assert not Path("runs").exists()


@pytest.mark.parametrize("verb", ["check", "run"])
@pytest.mark.parametrize("fault", OPTIONS)
def test_fault_in_what_is_set(command: Callable, fault: str, verb: str) -> None:
    refused(command(verb, CASE_C, *OPTIONS[fault][0]), OPTIONS[fault][1])


@pytest.mark.parametrize("fault", RUN_OPTIONS)
def test_fault_in_an_option(command: Callable, fault: str) -> None:
    refused(command("run", CASE_C, *RUN_OPTIONS[fault][0]), RUN_OPTIONS[fault][1])
    assert not Path("runs").exists()


def test_all_faults_at_once(command: Callable, pendulum: Path) -> None:
    pendulum.write_text(PENDULUM.replace("mass = 2", "mass = -2\ncolour = 3").replace("ground.O", "ground.P"))
    refused(
        command("check", pendulum), ["3 faults", "[body.rod] mass", "[body.rod] colour", "[joint.J] bearing"]
    )


def test_turns_without_a_crank(command: Callable, pendulum: Path) -> None:
    refused(command("run", pendulum, "--turns", "2"), ["pendulum.toml", "duration"])


@pytest.mark.parametrize("verb", ["check", "run", "info", "plot"])
def test_file_that_is_not_there(command: Callable, verb: str) -> None:
    refused(command(verb, "nowhere.toml"), ["nowhere.toml"])


def test_file_that_is_a_folder_or_no_text(command: Callable, tmp_path: Path) -> None:
    refused(command("run", tmp_path), [tmp_path.name])
    (tmp_path / "noise.toml").write_bytes(bytes(range(256)))
    refused(command("check", "noise.toml"), ["noise.toml", "is a binary file, not a model"])


def test_run_that_is_none(command: Callable, pendulum: Path) -> None:
    refused(command("info", pendulum), ["pendulum.toml", "is a model", "not a run; run it with vfife run"])
    refused(command("plot", "."), ["run.sqlite"])
    Path("run.sqlite").write_bytes(b"SQLite format 3\0" + bytes(200))
    refused(command("info", "."), ["run.sqlite"])


def test_damaged_run(command: Callable, case_c_run: Path) -> None:
    """A file without its tables is refused; of one that was cut off later, what is left is shown."""
    whole = (case_c_run / "run.sqlite").read_bytes()
    Path("run.sqlite").write_bytes(whole[: len(whole) // 3])
    done = command("info", "run.sqlite")
    assert done.exit_code == 0 and "the file is damaged" in done.stdout and "outputs 1 to" in done.stderr
    Path("run.sqlite").write_bytes(whole[:4000])
    refused(command("info", "run.sqlite"), ["run.sqlite", "damaged"])
    refused(command("export", "run.sqlite", "out.nc"), ["run.sqlite", "damaged"])
    assert not Path("out.nc").exists()


@pytest.mark.parametrize("table", ["companions", "turns", "reference"])
def test_info_names_every_damaged_part_that_a_reading_names(
    command: Callable, case_c_run: Path, table: str
) -> None:
    shutil.copy(case_c_run / "run.sqlite", "run.sqlite")
    with sqlite3.connect("run.sqlite") as connection:
        connection.execute(f"UPDATE {table} SET seal = x'00'")
    connection.close()
    with pytest.warns(DamageWarning, match="is damaged") as caught:
        vfife.load_result("run.sqlite")
    done = command("info", "run.sqlite")
    part = {
        "companions": "the companions",
        "turns": "the companions' turns",
        "reference": "the ideal reference",
    }
    assert part[table] in str(caught[0].message) and done.exit_code == 0
    assert f"{part[table]} cannot be read" in " ".join(done.stdout.split())
    assert "this run file is damaged" in done.stderr


def test_unknown_law(command: Callable) -> None:
    refused(command("laws", "perreira"), ["perreira", "pereira"])


def test_lengths_steps_and_loops_that_make_no_sense(command: Callable, pendulum: Path) -> None:
    for words in (["--turns", "-1"], ["--duration", "0"], ["--step", "1 mm"], ["--outputs", "0"],
        ["--loop", "numba"], ["--step", "nan"],
                  ["--turns", "1", "--duration", "1"]):  # fmt: skip
        done = command("run", pendulum, *words)
        assert done.exit_code == 2 and "Traceback" not in done.output, words
    assert not Path("runs").exists()
