"""From process start to result, and memory: what a user waits for before the first step, and after a short
run.

Each time is that of a whole new process, the best of several; limits are those of the project's issue on
speed. Python keeps the bytecode of modules, as it does for whoever installs the package, also where this
process was told not to.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from measure import EXAMPLES, ROOT, Options, Part, seconds, table

LIMITS = {"import": 0.3, "help": 0.5, "run_warm": 0.7, "run_cold": 2.5}
MODEL = EXAMPLES / "four_bar_case_c.toml"
VFIFE = [sys.executable, "-m", "vfife"]
# The same number of outputs whatever the length; peak memory in KiB (bytes on macOS, where only the ratio
# counts).
MEMORY = """
import resource, sys, vfife
turns = int(sys.argv[2])
model = vfife.load_model(sys.argv[1])
vfife.simulate(model, turns=turns, outputs=1440 // turns, loop="data-driven", reference=False)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def process(*command: str, cache: str | None = None) -> str:
    """Runs a command to its end and returns what it printed."""
    variables = dict(os.environ, MPLBACKEND="Agg")
    variables.pop("PYTHONDONTWRITEBYTECODE", None)
    if cache is not None:
        variables["VFIFE_CACHE"] = cache
    done = subprocess.run(
        command, env=variables, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False
    )
    if done.returncode:
        said = (done.stderr or done.stdout).strip()[-500:]
        raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}: {said}")
    return done.stdout


def loaded(*command: str) -> list[str]:
    """Which of the heavy libraries a command loads, by ``-X importtime``."""
    timed = [sys.executable, "-X", "importtime", *command]
    done = subprocess.run(timed, cwd=ROOT, capture_output=True, text=True, check=False)
    names = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.splitlines()}
    return sorted(names & {"matplotlib", "xarray", "scipy", "llvmlite"})


def best(times: int, *command: str) -> float:
    """Shortest wall time of several processes."""
    return min(seconds(lambda: process(*command)) for _ in range(times))


def measure(options: Options) -> Part:
    """Times of the commands a session begins with, and peak memory at two lengths."""
    part, many = Part(), 3 if options.quick else 7
    took: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:

        def run(name: str, cache: str | None = None) -> float:
            out = Path(folder) / name
            return seconds(lambda: process(*VFIFE, "run", str(MODEL), "-o", str(out), "--json", cache=cache))

        took["import"] = best(many, sys.executable, "-c", "import vfife")
        took["help"] = best(many, *VFIFE, "--help")
        cold = [run(f"cold{k}", str(Path(folder) / f"cache{k}")) for k in range(1 if options.quick else 2)]
        took["run_cold"] = min(cold)
        run("first")
        took["run_warm"] = min(run(f"warm{k}") for k in range(many))
    heavy = {"import": loaded("-c", "import vfife"), "help": loaded("-m", "vfife", "--help")}
    for name, found in heavy.items():
        if set(found) & {"llvmlite", "matplotlib"}:
            part.notes.append(f"startup: {name} loads {', '.join(found)}")
    peaks = {turns: int(process(sys.executable, "-c", MEMORY, str(MODEL), str(turns))) for turns in (2, 16)}
    part.ratios = {f"startup.{name}": took[name] / limit for name, limit in LIMITS.items()}
    part.ratios["startup.memory_8x"] = peaks[16] / peaks[2]
    part.measured = {
        "seconds_taken": took,
        "cold_runs": cold,
        "heavy_libraries": heavy,
        "peak_memory_KiB": peaks,
    }
    rows: list[tuple[Any, ...]] = [
        (name.replace("_", " "), took[name], limit) for name, limit in LIMITS.items()
    ]
    title = "seconds from process start to end; the run is case c"
    part.tables.append(table(title, "command", "s", "limit", rows=rows))
    rows = [(f"{turns} turns", f"{peak / 1024:.1f}") for turns, peak in peaks.items()]
    part.tables.append(table("peak memory at equal numbers of outputs", "run", "MiB", rows=rows))
    return part
