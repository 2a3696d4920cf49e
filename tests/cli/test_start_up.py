"""The command line starts quickly and loads nothing that it does not need."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
HEAVY = {"numba", "llvmlite", "matplotlib", "xarray", "scipy", "pandas"}
LISTED = """
import json, sys
from vfife.cli.app import app
found = []
for words in {many!r}:
    sys.argv = ["vfife", *words]
    try:
        app()
    except SystemExit:
        pass
    found.append(sorted(sys.modules))
print("", json.dumps(found), sep=chr(10), file=sys.stderr)
"""


def loaded(*many: list[str]) -> tuple[list[set[str]], str]:
    """All modules that a process has loaded when each of some commands, one after the other, is done; and
    what was said.

    What one of them loads that it does not need is seen behind all that follow it, and so is what they load
    themselves.
    """
    done = subprocess.run(
        [sys.executable, "-c", LISTED.format(many=many)], env=ENVIRONMENT, capture_output=True, text=True
    )
    return [set(names) for names in json.loads(done.stderr.splitlines()[-1])], done.stderr


def packages(names: set[str]) -> set[str]:
    return {name.partition(".")[0] for name in names}


LIGHT = [
    ["--help"],
    ["--version"],
    ["new"],
    ["new", "frame"],
    ["schema"],
    ["run", "--help"],
    ["laws"],
    ["laws", "pereira", "--json"],
    ["run", "none.toml"],
]


@pytest.fixture(scope="module")
def behind_light_ones() -> dict[str, set[str]]:
    """Modules that are loaded when each of ``LIGHT`` is done, in one process."""
    return {" ".join(words): names for words, names in zip(LIGHT, loaded(*LIGHT)[0], strict=True)}


@pytest.mark.parametrize("words", LIGHT, ids=" ".join)
def test_loads_nothing_heavy(behind_light_ones: dict[str, set[str]], words: list[str]) -> None:
    found = packages(behind_light_ones[" ".join(words)])
    assert "vfife" in found
    assert not found & HEAVY


@pytest.mark.system("starts a process")
def test_laws_are_listed_without_what_computes() -> None:
    """Neither the compiled routines nor a model are needed to list them."""
    ((found,), _) = loaded(["laws"])
    assert "vfife.laws.contact" in found
    assert not found & {"vfife.numerics.library", "vfife.model", "vfife.assembly"}


@pytest.mark.system("starts a process")
def test_a_model_that_is_not_there_is_missed_before_what_runs_it_is_loaded() -> None:
    ((found,), _) = loaded(["run", "none.toml"])
    assert "vfife.modelfile" in found
    assert not found & {"vfife.assembly", "vfife.measures", "vfife.results", "vfife.simulation"}


@pytest.mark.system("starts a process")
def test_a_run_loads_what_it_needs(tmp_path: Path) -> None:
    """Neither what draws on a terminal, nor what checks arguments that are plain, nor what reads the names of
    installed packages.
    """
    (found,), _ = loaded(
        [
            "run",
            str(ROOT / "examples" / "four_bar_case_c.toml"),
            "-o",
            str(tmp_path / "run"),
            "--turns",
            "0.1",
            "--outputs",
            "9",
            "--json",
        ]
    )
    assert not packages(found) & (HEAVY - {"llvmlite"} | {"rich", "pydantic", "email"})


def test_both_ways_in_say_the_version() -> None:
    import vfife

    done = subprocess.run(
        [sys.executable, "-m", "vfife", "--version"], env=ENVIRONMENT, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, f"vfife {vfife.__version__}\n")


@pytest.fixture(scope="module")
def behind_others() -> tuple[list[set[str]], str]:
    """What is loaded behind a command that is refused, a word that is no command, and the schema."""
    return loaded(["map", "--nonsense"], ["rum"], ["schema"])


@pytest.mark.system("starts processes")
@pytest.mark.parametrize(
    ("k", "arguments", "work"),
    [(0, {"analyses"}, set()), (1, {"analyses"}, set()), (2, {"analyses", "models"}, {"new"})],
    ids=["map --nonsense", "rum", "schema"],
)
def test_only_the_command_that_is_named_is_loaded(
    behind_others: tuple[list[set[str]], str], k: int, arguments: set[str], work: set[str]
) -> None:
    """The others are known by their names alone, also to what suggests one for a word that is none; what a
    command does is loaded when its arguments are read.
    """
    found, said = behind_others
    for package, names in (("arguments", arguments), ("commands", work)):
        prefix = f"vfife.cli.{package}."
        assert {name.removeprefix(prefix) for name in found[k] if name.startswith(prefix)} == names
    assert k != 1 or "Did you mean 'run'" in said


def test_the_entry_listens_before_anything_is_imported():
    """Ctrl-C in the first hundredths of a second leaves no traceback; only the interpreter's own start comes
    before.
    """
    said = (
        "import sys, _signal; _signal.signal(_signal.SIGINT, _signal.default_int_handler); before ="
        " set(sys.modules); import vfife_command"
    )
    said += "; print(sorted(set(sys.modules) - before), _signal.getsignal(_signal.SIGINT) == _signal.SIG_DFL)"
    found = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert found.stdout.split("]")[0] == "['vfife_command'" and found.stdout.strip().endswith("True")


def test_an_interrupt_that_is_ignored_stays_ignored():
    """As for a command behind nohup, or in the background of a script."""
    said = "import _signal; _signal.signal(_signal.SIGINT, _signal.SIG_IGN); import vfife_command; "
    said += "print(_signal.getsignal(_signal.SIGINT) == _signal.SIG_IGN)"
    assert (
        subprocess.run(
            [sys.executable, "-c", said], capture_output=True, text=True, check=True
        ).stdout.strip()
        == "True"
    )
