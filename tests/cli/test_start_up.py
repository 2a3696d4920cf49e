"""The command line starts quickly and loads nothing that it does not need."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
HEAVY = {"numba", "llvmlite", "matplotlib", "xarray", "scipy", "pandas", "plotly"}
LISTED = """
import sys
sys.argv = ["vfife", *{words!r}]
try:
    from vfife.cli import app
    app()
finally:
    print(*sorted({{name.partition(".")[0] for name in sys.modules}}), file=sys.stderr)
"""


LIGHT = [["--help"], ["--version"], ["run", "--help"], ["laws"], ["laws", "pereira", "--json"], ["run", "none.toml"]]


@pytest.mark.parametrize("words", LIGHT, ids=" ".join)
def test_loads_nothing_heavy(words: list[str]) -> None:
    done = subprocess.run([sys.executable, "-c", LISTED.format(words=words)], env=ENVIRONMENT, capture_output=True, text=True)
    loaded = set(done.stderr.splitlines()[-1].split())
    assert "vfife" in loaded
    assert not loaded & HEAVY


LIMITS = [(["-c", "import vfife"], 0.3), (["-m", "vfife", "--help"], 0.5)]  # s


@pytest.mark.parametrize(("words", "limit"), LIMITS, ids=["import", "help"])
def test_starts_quickly(words: list[str], limit: float) -> None:
    """The quickest of several starts: other work on the machine only adds time."""
    spent = []
    for _ in range(8):
        began = time.perf_counter()
        subprocess.run([sys.executable, *words], env=ENVIRONMENT, capture_output=True, check=True)
        spent.append(time.perf_counter() - began)
        if spent[-1] < limit:
            return
    raise AssertionError(f"{min(spent):.2f} s at best; `python -X importtime` tells who takes it")


def test_both_ways_in_say_the_version() -> None:
    import vfife

    done = subprocess.run([sys.executable, "-m", "vfife", "--version"], env=ENVIRONMENT, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"vfife {vfife.__version__}\n")
