"""The command line starts quickly and loads nothing that it does not need."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
HEAVY = {"numba", "llvmlite", "matplotlib", "xarray", "scipy", "pandas"}
LISTED = """
import sys
sys.argv = ["vfife", *{words!r}]
try:
    from vfife.cli.app import app
    app()
finally:
    print(*sorted({{name.partition(".")[0] for name in sys.modules}}), file=sys.stderr)
"""


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


@pytest.mark.parametrize("words", LIGHT, ids=" ".join)
def test_loads_nothing_heavy(words: list[str]) -> None:
    done = subprocess.run([sys.executable, "-c", LISTED.format(words=words)], env=ENVIRONMENT, capture_output=True, text=True)
    loaded = set(done.stderr.splitlines()[-1].split())
    assert "vfife" in loaded
    assert not loaded & HEAVY


def test_a_run_loads_what_it_needs(tmp_path: Path) -> None:
    """Neither what draws on a terminal, nor what checks arguments that are plain, nor what reads the names of installed packages."""
    words = ["run", str(ROOT / "examples" / "four_bar_case_c.toml"), "-o", str(tmp_path / "run"), "--json"]
    done = subprocess.run([sys.executable, "-c", LISTED.format(words=words)], env=ENVIRONMENT, capture_output=True, text=True)
    assert not set(done.stderr.splitlines()[-1].split()) & (HEAVY - {"llvmlite"} | {"rich", "pydantic", "email"})


def test_both_ways_in_say_the_version() -> None:
    import vfife

    done = subprocess.run([sys.executable, "-m", "vfife", "--version"], env=ENVIRONMENT, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"vfife {vfife.__version__}\n")


@pytest.mark.parametrize("words", [["schema"], ["map", "--nonsense"], ["rum"]], ids=" ".join)
def test_only_the_command_that_is_named_is_loaded(words: list[str]) -> None:
    """The others are known by their names alone, also to what suggests one for a word that is none."""
    program = LISTED.format(words=words).replace('.partition(".")[0]', "")
    done = subprocess.run([sys.executable, "-c", program], env=ENVIRONMENT, capture_output=True, text=True)
    loaded = set(done.stderr.splitlines()[-1].split())
    others = {"animate", "compare", "fitted", "schema", "searched", "study", "wear"} - set(words)
    assert "vfife.cli.app" in loaded
    assert not loaded & {f"vfife.cli.{name}" for name in others}
    assert words != ["rum"] or "Did you mean 'run'" in done.stderr
